"""Expressions as a reader sees them: as a line of text, and as LaTeX."""

from stickslip_sym.output.latex_printer import latex as latex
from stickslip_sym.output.latex_printer import latex_value as latex_value
from stickslip_sym.output.text_printer import text as text
from stickslip_sym.output.text_printer import value as value

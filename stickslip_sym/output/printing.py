"""Expressions as a reader sees them: as a line of text, and as LaTeX."""

from stickslip_sym.output.latex_printer import latex as latex
from stickslip_sym.output.text_printer import text as text

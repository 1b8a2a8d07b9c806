"""Expressions as a reader sees them: as a line of text, and as LaTeX."""

from stickslip_sym.latex_printer import latex
from stickslip_sym.text_printer import text

__all__ = ["latex", "text"]

"""Expressions as a reader sees them: as a line of text, and as LaTeX. Printers are imported when one prints."""

from collections.abc import Mapping

from stickslip_sym.core.aliases import Expr

__all__ = ["latex", "text"]


def text(expr: Expr) -> str:
    """Return an expression or a relation as one line of text, as `text_printer` does."""
    from stickslip_sym.output import text_printer

    return text_printer.text(expr)


def latex(expr: Expr, names: Mapping[str, str] | None = None, *, inline: bool = False) -> str:
    """Return an expression or a relation as LaTeX, as `latex_printer` does."""
    from stickslip_sym.output import latex_printer

    return latex_printer.latex(expr, names, inline=inline)

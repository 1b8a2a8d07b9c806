"""Formulas as lines of text: one line where it can be read, a term a line where it is long."""

from collections import Counter

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.output.abbreviation import letter
from stickslip_sym.output.tables import WIDTH, wrapped
from stickslip_sym.output.text_printer import terms, text

__all__ = ["formula"]

_LONG = 400  # characters of a formula from which on it is broken
_BLOCK = 40  # characters from which on what stands repeatedly gets a name
_INDENT = "  "


def formula(left: str, expr: Expr) -> str:
    """Return an equation as indented text: ``left = expr``.

    A long formula has a line for each term of its outermost sum, and more where a term is wider than a page.
    What stands in it repeatedly gets a letter, defined below; blanks and line ends mean nothing.
    """
    if len(text(expr)) <= _LONG:
        return f"{_INDENT}{left} = {text(expr)}"
    shorter, definitions = _named(expr)
    lines = _broken(left, shorter)
    if definitions:
        lines.append("where")
    for name, value in definitions:
        lines += _broken(name, value)
    return "\n".join(f"{_INDENT}{line}" for line in lines)


def _broken(left: str, expr: Expr) -> list[str]:
    if len(text(expr)) + len(f"{left} = ") <= WIDTH - len(_INDENT):
        return [f"{left} = {text(expr)}"]
    lines = [f"{left} ="]
    for term in terms(expr):
        first, *rest = wrapped(term, WIDTH - 4 * len(_INDENT))
        lines += [f"{_INDENT}{first}", *(f"{3 * _INDENT}{line}" for line in rest)]
    return lines


def _named(expr: Expr) -> tuple[Expr, list[tuple[str, Expr]]]:
    """Give names to what stands repeatedly in a formula, the longest first; return it and the definitions."""
    initial = letter(expr, {})
    definitions: list[tuple[str, Expr]] = []
    while True:
        counts = Counter(node for node in sp.preorder_traversal(expr) if node.args and isinstance(node, sp.Expr))
        often = [(len(text(node)), text(node), node) for node, count in counts.items() if count > 1]
        size, _, block = max(often, key=lambda one: one[:2], default=(0, "", None))
        if size < _BLOCK:
            return expr, definitions
        definitions.append((f"{initial}_{len(definitions) + 1}", block))
        expr = expr.xreplace({block: sp.Symbol(definitions[-1][0])})

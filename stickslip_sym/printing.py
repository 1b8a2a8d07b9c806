"""SymPy's printers, with sums and derivatives as a person writes them.

A sum starts with a positive term, and the derivative of a function of one variable is x'(t), also at a
given place, where SymPy prints ``Subs(Derivative(x(t), t), t, t_P)``.
"""

from typing import Any

import sympy as sp
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter

__all__ = ["latex", "text"]


class _Readable:
    """What the printers for text and LaTeX have in common."""

    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms: list[Any] = super()._as_ordered_terms(expr, order=order)  # type: ignore[misc]  # a printer's
        for position, term in enumerate(terms):
            if not term.could_extract_minus_sign():
                return [term, *terms[:position], *terms[position + 1 :]]
        return terms

    def _print_Derivative(self, expr: Any) -> str:
        return self._primed(expr, expr.expr.args[0]) or str(super()._print_Derivative(expr))  # type: ignore[misc]  # a printer's

    def _print_Subs(self, expr: Any) -> str:
        if isinstance(expr.expr, sp.Derivative) and len(expr.point) == 1:
            primed = self._primed(expr.expr, expr.point[0])
            if primed:
                return primed
        return str(super()._print_Subs(expr))  # type: ignore[misc]  # a printer's

    def _primed(self, derivative: Any, argument: Any) -> str:
        function = derivative.expr
        if not isinstance(function, sp.core.function.AppliedUndef) or len(function.args) != 1:
            return ""
        mark = "'" * sum(count for _, count in derivative.variable_count)
        name = self._print(sp.Symbol(function.func.__name__))  # type: ignore[attr-defined]  # a printer's
        return self._applied(f"{name}{mark}", self._print(argument))  # type: ignore[attr-defined]  # a printer's

    def _applied(self, name: str, argument: str) -> str:
        return f"{name}({argument})"


class _Text(_Readable, StrPrinter):  # type: ignore[misc]  # SymPy is untyped
    def _print_Dummy(self, expr: Any) -> str:
        return str(expr.name)


class _Latex(_Readable, LatexPrinter):  # type: ignore[misc]  # SymPy is untyped
    def _applied(self, name: str, argument: str) -> str:
        return f"{name}\\left({argument}\\right)"


def text(expr: Any) -> str:
    """Return an expression or a relation as one line of text, e.g. ``N*(mu_s - mu_m)``."""
    if getattr(expr, "is_Relational", False):
        return f"{text(expr.lhs)} {expr.rel_op.replace('==', '=')} {text(expr.rhs)}"
    return str(_Text().doprint(expr))


def latex(expr: Any) -> str:
    r"""Return an expression or a relation as LaTeX, e.g. ``N \left(\mu_{s} - \mu_{m}\right)``."""
    return str(_Latex().doprint(expr))

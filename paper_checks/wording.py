"""Numbers and formulas as the evidence of a check words them."""

from collections.abc import Iterable
from typing import Any

from sympy.printing.str import StrPrinter

from paper_checks.computed import LAWS


def listed(numbers: Iterable[float], digits: int = 4) -> str:
    """Write numbers to a number of decimals, with commas."""
    return ", ".join(f"{number:.{digits}f}" for number in numbers)


def percent(*fractions: float, digits: int = 2) -> str:
    """Write fractions as signed per cent, with commas."""
    return ", ".join(f"{100 * fraction:+.{digits}f} %" for fraction in fractions)


def by_law(texts: Iterable[str]) -> str:
    """Write what holds of each of the two laws, in their order, with the law's name."""
    return ", ".join(f"{text} ({name} law)" for text, name in zip(texts, LAWS, strict=True))


def formula(expr: Any) -> str:
    """Write an expression as text: Bessel functions as I_1(z), and no sum that begins with a minus needlessly."""
    return _Printer().doprint(expr)


class _Printer(StrPrinter):
    def _as_ordered_terms(self, expr: Any, order: str | None = None) -> list[Any]:
        terms = super()._as_ordered_terms(expr, order=order)
        return sorted(terms, key=lambda term: bool(term.could_extract_minus_sign()))

    def _print_BesselBase(self, expr: Any) -> str:
        letter = type(expr).__name__[-1].upper()
        return f"{letter}_{expr.order}({self._print(expr.argument)})"

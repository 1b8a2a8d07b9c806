"""How languages write the same formulas."""

import re
from collections.abc import Iterable, Mapping
from typing import ClassVar

import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p
from sympy.functions.elementary.piecewise import ExprCondPair
from sympy.logic.boolalg import BooleanTrue
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm

__all__ = ["C", "Dialect", "Reciprocal", "numeric_list"]


_LOCALS = frozenset(
    {
        "a", "added", "angle", "b", "base", "cancelled", "carry", "coarse", "columns", "count", "ends",
        "exponent", "factors", "fine", "first", "g", "half_pi", "halvings", "height", "here", "i", "j",
        "left", "m", "mantissa", "math", "np", "off", "panels", "part", "parts", "place", "power", "r", "ratio",
        "rest", "result", "right", "row", "scale", "scales", "shape", "shift", "sine", "size", "sum", "swap", "t",
        "total", "try_", "upper", "v", "value", "w", "whole", "x", "z",
    }
)  # fmt: skip
"""Names that the functions inside the text use for themselves."""


_WRITTEN = (
    sp.Add, sp.Mul, sp.Pow, sp.Rational, sp.Float, sp.NumberSymbol, sp.Symbol, sp.Max, sp.Min, sp.Abs, sp.sign,
    sp.Piecewise, ExprCondPair, sp.StrictLessThan, sp.StrictGreaterThan, BooleanTrue,
    sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.asin, sp.acos, sp.atan, sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.coth,
    sp.asinh, sp.acosh, sp.atanh, sp.erf, expm1, log1p,
)  # fmt: skip
"""What every language here can compute; SymPy's printers would write other functions as if they existed."""


class Reciprocal:
    """Functions that are one over another one; SymPy would rewrite all that stands in their argument too."""

    def _print_sech(self, expr: Expr) -> str:
        return f"(1.0/{self._print(sp.cosh(expr.args[0], evaluate=False))})"  # type: ignore[attr-defined]  # a printer's

    def _print_coth(self, expr: Expr) -> str:
        return f"(1.0/{self._print(sp.tanh(expr.args[0], evaluate=False))})"  # type: ignore[attr-defined]  # a printer's


class C(Reciprocal, C99CodePrinter):  # type: ignore[misc]  # SymPy is untyped
    """Formulas as C writes them, and languages that took its operators."""

    absolute = "fabs"
    math_macros: ClassVar[dict[Expr, str]] = {}  # M_SQRT2 and the like are neither C99's nor Octave's

    def _print_Float(self, expr: Expr) -> str:
        return repr(float(expr))

    def _print_Rational(self, expr: Expr) -> str:
        return f"({float(expr)!r})"

    def _print_NumberSymbol(self, expr: Expr) -> str:
        return repr(float(expr))

    # What would be of type int to C becomes a double: of a quotient of two ints only the whole part is left.

    def _print_Piecewise(self, expr: Expr) -> str:
        cases = [(sp.Float(part) if part.is_Integer else part, holds) for part, holds in expr.args]
        return str(super()._print_Piecewise(sp.Piecewise(*cases, evaluate=False)))

    def _print_sign(self, expr: Expr) -> str:
        below, above = (f"(({self._print(expr.args[0])}) {relation} 0.0)" for relation in "<>")
        return f"(1.0*{above} - {below})"

    def _print_Abs(self, expr: Expr) -> str:
        return f"{self.absolute}({self._print(expr.args[0])})"

    def _print_Symbol(self, expr: Expr) -> str:
        return str(expr.name)  # `Dialect.name` has seen to the words of the language, which C's are not in Octave


class Dialect:
    """One language: how it prints an expression, and which names it keeps for itself."""

    def __init__(self, printer: CodePrinter, words: frozenset[str], kept: str = "(?!)") -> None:
        self._printer, self._words, self._kept = printer, words | _LOCALS, re.compile(kept)

    def name(self, symbol: Expr) -> str:
        """Return the name of an argument, with an underscore after a word of the language, or after another."""
        text = str(symbol)
        return f"{text}_" if text in self._words or text.endswith("_") or self._kept.fullmatch(text) else text

    def text(self, expr: Expr, names: Mapping[Expr, str]) -> str:
        """Return an expression in this language.

        Raises
        ------
        NoClosedForm
            For a function that not every language here has.
        """
        for node in sp.preorder_traversal(sp.sympify(expr)):
            if not isinstance(node, _WRITTEN):
                raise NoClosedForm(
                    f"{str(node)[:60]} cannot be written as code: C, Python and Octave do not all have "
                    f"{type(node).__name__}; what needs no such function, like the slope of a law, can be written"
                )
        renamed = {symbol: sp.Symbol(name, positive=True) for symbol, name in names.items()}
        return str(self._printer.doprint(sp.sympify(expr).xreplace(renamed)))


def numeric_list(values: Iterable[float], brackets: str, indent: str = "    ") -> str:
    """Return numbers as the text of a list, a few on each line, exact when read back."""
    numbers = [repr(float(value)) for value in values]
    lines = [", ".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    return brackets[0] + f",\n{indent}".join(lines) + brackets[1]

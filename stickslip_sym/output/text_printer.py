"""Expressions as a line of text, with sums and derivatives as a person writes them.

A sum starts with a positive term, and the derivative of a function of one variable is x'(t), also at a
given place, where SymPy prints ``Subs(Derivative(x(t), t), t, t_P)``.
"""

from collections.abc import Iterable, Mapping
from decimal import Decimal, localcontext
from fractions import Fraction

import sympy as sp
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.printer import Printer
from sympy.printing.str import StrPrinter

from stickslip_sym.core.aliases import Condition, Expr
from stickslip_sym.core.functions import elementary

_LEAST_DENOMINATOR = 100  # least denominator of a decimal; a smaller one is read at a glance
_LEAST_COMPUTED_DENOMINATOR = 2**20  # least denominator of a binary number that was computed, not written
_LONGEST_DECIMAL = 24  # characters


class Readable(Printer):
    """What the printers for text and LaTeX have in common."""

    dummies: Mapping[Expr, str]
    """The names of the dummies in what is printed, none that of another symbol."""

    def _as_ordered_terms(self, expr: Expr, order: str | None = None) -> list[Expr]:
        terms = super()._as_ordered_terms(expr, order=order)
        first = next((term for term in terms if not term.could_extract_minus_sign()), None)
        return sorted(terms, key=lambda term: term is not first)

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        return self._primed(expr) or super()._print_Derivative(expr)

    def _print_Subs(self, expr: sp.Subs) -> str:
        if isinstance(expr.expr, sp.Derivative) and len(expr.point) == 1:
            primed = self._primed(expr.expr, expr.point[0])
            if primed:
                return primed
        return super()._print_Subs(expr)

    def _primed(self, derivative: sp.Derivative, place: Expr | None = None) -> str:
        """Return x'(t), or at a place x'(t_P); nothing where what is derived is no function of one argument."""
        function = derivative.expr
        if not isinstance(function, sp.core.function.AppliedUndef) or len(function.args) != 1:
            return ""
        mark = "'" * sum(count for _, count in derivative.variable_count)
        name = self._print(sp.Symbol(function.func.__name__))
        return self._applied(f"{name}{mark}", function.args[0] if place is None else place)

    def _applied(self, name: str, argument: Expr) -> str:
        return f"{name}({self._print(argument)})"


class _Text(Readable, StrPrinter):
    def __init__(self, dummies: Mapping[Expr, str], least: int) -> None:
        super().__init__()
        self.dummies = dummies
        self._least = least

    def _print_Dummy(self, expr: Expr) -> str:
        return self.dummies[expr]

    def _print_Mul(self, expr: Expr) -> str:
        number, rest = expr.as_coeff_Mul()
        written = ""
        if number.q != 1:
            written = decimal(number, least=self._least)
        over = not written and is_over_decimal(number)
        if not (over or written):
            return super()._print_Mul(expr)
        shown = self.parenthesize(rest, PRECEDENCE["Mul"])
        if over:
            return f"{'-' * bool(number < 0)}{shown}/{decimal(abs(1 / number))}"
        return written + (shown.removeprefix("1") if shown.startswith("1/") else f"*{shown}")

    def _print_Rational(self, expr: sp.Rational) -> str:
        return decimal(expr, least=self._least) or super()._print_Rational(expr)

    def _print_Exp1(self, expr: Expr) -> str:
        del expr
        return "exp(1)"  # E may be a parameter


def decimal(number: Expr, *, shortest: bool = False, least: int = _LEAST_DENOMINATOR) -> str:
    """Return an integer, or a rational that was written as a decimal (0.0788816, but 7/20 and 5/128), as text.

    Other numbers give none. With `shortest` a binary number of double precision is its shortest decimal;
    `least` is the least denominator of a decimal.
    """
    q = number.q
    if q == 1:
        return str(number.p)
    if q >= least and q % 5 == 0 and 10**_LONGEST_DECIMAL % q == 0:
        with localcontext(prec=2 * _LONGEST_DECIMAL):
            text = f"{Decimal(int(number.p)) / Decimal(int(q)):f}"
        return text if len(text) <= _LONGEST_DECIMAL else ""
    is_double = shortest and q >= _LEAST_COMPUTED_DENOMINATOR and q & (q - 1) == 0
    if is_double and Fraction(float(number)) == Fraction(int(number.p), int(q)):
        return f"{Decimal(repr(float(number))):f}"
    return ""


def value(number: Expr) -> str:
    """Return the value of a letter as it was written: a number that has a decimal as that, 1/10 as 0.1."""
    return (decimal(number, least=0) if number.is_Rational else "") or text(number)


def is_decimal(number: Expr) -> bool:
    """Whether a rational that is no integer has a decimal, as fitted numbers have."""
    return bool(number.is_Rational and number.q != 1 and decimal(number))


def is_over_decimal(number: Expr) -> bool:
    """Whether a rational is shorter as one over a decimal, as that of v/0.0788."""
    return not decimal(number) and is_decimal(1 / number) and len(decimal(1 / number)) < len(str(number))


def spellings(expr: Expr | Condition, names: Iterable[str] = ()) -> dict[Expr, str]:
    """Return a name for each dummy of an expression: its own, with underscores where another symbol has that.

    `names` are those of symbols elsewhere that no dummy may have either.
    """
    symbols = expr.atoms(sp.Symbol)
    taken = {symbol.name for symbol in symbols if not symbol.is_Dummy} | set(names)
    spelled: dict[Expr, str] = {}
    for dummy in sorted((symbol for symbol in symbols if symbol.is_Dummy), key=sp.default_sort_key):
        spelled[dummy] = dummy.name
        while spelled[dummy] in taken:
            spelled[dummy] += "_"
        taken.add(spelled[dummy])
    return spelled


def text(expr: Expr | Condition) -> str:
    """Return an expression or a relation as one line of text, e.g. ``N*(mu_s - mu_m)``."""
    if isinstance(expr, sp.core.relational.Relational):
        return f"{text(expr.lhs)} {expr.rel_op.replace('==', '=')} {text(expr.rhs)}"
    has_decimals = any(map(is_decimal, expr.atoms(sp.Rational)))
    least = 0 if has_decimals else _LEAST_DENOMINATOR  # 0.4 beside 0.07, and 1/3
    return _Text(spellings(expr), least).doprint(elementary(expr))  # type: ignore[type-var]  # one or the other

"""How a formula is expanded at rest and far out: the algebra of all kinds of series.

Taylor models with a bound, generalised series with logarithms, and leading terms with letters for parameters are
three kinds of numbers in it.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import lru_cache, reduce
from operator import add, mul
from typing import Any, Generic, Protocol, Self, TypeAlias, TypeVar

import sympy as sp
from flint import acb, arb, arb_series, ctx

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import ball_value, number_at, rational, series_function
from stickslip_sym.core.functions import FUNCTIONS, Function, row
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_SUM

RECIPROCALS: dict[type[Expr], type[Expr]] = {sp.coth: sp.tanh, sp.csch: sp.sinh}
"""Functions with a pole at 0, and those that they are one over."""

Bound: TypeAlias = Callable[[arb], arb]
"""From the radius of a disc to a bound on a function there; NaN without one."""


class NotAnalytic(ArithmeticError):
    """A formula has no such series at rest, or none whose first term is certain."""


def is_multiplied_out(exponent: Expr) -> bool:
    """Whether a power is a product."""
    return bool(exponent.is_Integer and 0 <= exponent <= HIGHEST_POWER_OF_SUM)


class Ring(Protocol):
    """What is added and multiplied."""

    def __add__(self, other: Self, /) -> Self: ...
    def __mul__(self, other: Self, /) -> Self: ...


R = TypeVar("R", bound=Ring)


class FormulaAlgebra(ABC, Generic[R]):
    """The algebra by which a formula with values of its letters is expanded from what v is."""

    def __init__(self, point: Substitution, v: R, count: int) -> None:
        self.point = point
        self.v = v
        self.count = count

    def __call__(self, node: Expr, parts: list[R]) -> R:
        """Expand a node, from its arguments."""
        if node == symbols.v:
            return self.v
        if not node.has(symbols.v):
            return self.number(node)
        if node.is_Add or node.is_Mul:
            return reduce(add if node.is_Add else mul, parts)
        if node.is_Pow and node.base is not sp.E:
            return self.power(parts[0], self.exponent(node.exp))
        known = row(node)
        if known is None or known.ball is None or len(parts) != 1:
            raise NotAnalytic(f"{node} is expanded in no rule")
        return self.function(known, parts[0])

    @abstractmethod
    def number(self, node: Expr) -> R:
        """Return what has no v in it."""

    @abstractmethod
    def exponent(self, node: Expr) -> Expr:
        """Return the value of an exponent."""

    @abstractmethod
    def power(self, base: R, exponent: Expr) -> R:
        """Return a power, whose exponent has no v in it."""

    @abstractmethod
    def function(self, known: Function, inner: R) -> R:
        """Return a function."""

    def by_reciprocal(self, known: Function, inner: R) -> R:
        """Return a function that has a pole where its argument vanishes, as coth."""
        return self.power(self.function(FUNCTIONS[RECIPROCALS[known.kind]], inner), sp.S.NegativeOne)

    def whole_power(self, base: R, exponent: Expr) -> R:
        """Return a power that is multiplied out."""
        return reduce(mul, [base] * int(exponent), self.number(sp.S.One))


class Expandable(Ring, Protocol):
    """A number and what vanishes at v = 0, or a power of x before both, with balls for coefficients."""

    @property
    def low(self) -> float:
        """The power of x before it."""

    @property
    def leading(self) -> arb:
        """The first coefficient, which must be certain."""

    def split(self) -> tuple[arb, Self]:
        """Return the value at x = 0, and what vanishes there."""

    def without_first(self) -> Self:
        """Return it without its first term."""

    def scaled(self, factor: arb, power: int = 0) -> Self:
        """Return it times a number and a power of x."""

    def constant(self, value: arb) -> Self:
        """Return a number."""

    def inserted_in(self, coefficients: Sequence[arb], bound: Bound) -> Self:
        """Return a power series of this, which vanishes with x; `bound` is that of the function."""


S = TypeVar("S", bound=Expandable)


class ExpansionAlgebra(FormulaAlgebra[S]):
    """The algebra of series with balls for coefficients, with so many of each function."""

    def number(self, node: Expr) -> S:
        """Return what has no v in it."""
        value = ball_value(node, self.point)
        if not value.is_finite() or value.imag != 0:
            raise NotAnalytic(f"{node} has no value")
        return self.v.constant(value.real)

    def exponent(self, node: Expr) -> Expr:
        """Return the value of an exponent."""
        return number_at(node, self.point)

    def power(self, base: S, exponent: Expr) -> S:
        """Return a power of what begins with a number, or with a power of x."""
        if is_multiplied_out(exponent):
            return self.whole_power(base, exponent)
        first = base.leading
        shift = exponent * int(base.low)
        if not shift.is_Integer or not (exponent.is_Integer or first > 0):
            raise NotAnalytic("a power of v that is not whole, or of what is negative")
        p = arb(rational(exponent)) if exponent.is_Rational else ball_value(exponent, {}).real
        binomials = [arb(1)]
        for k in range(self.count):
            binomials.append(binomials[-1] * (p - k) / (k + 1))

        def bound(farther: arb) -> arb:
            if farther < 1:
                return ((1 + farther) ** p).max((1 - farther) ** p)
            return arb.nan()

        rest = base.without_first().scaled(1 / first, -int(base.low))
        factor = first ** int(exponent) if exponent.is_Integer else first**p
        return rest.inserted_in(binomials, bound).scaled(factor, int(shift))

    def function(self, known: Function, inner: S) -> S:
        """Return a function of what is finite at v = 0."""
        if known.kind in RECIPROCALS and inner.low > 0:
            return self.by_reciprocal(known, inner)
        start, rest = inner.split()
        coefficients = self.coefficients(known.kind, start)
        return rest.inserted_in(coefficients, lambda farther: _bound_on_disc(known, start, farther))

    def coefficients(self, kind: Any, start: arb) -> tuple[arb, ...]:
        """Return the first coefficients of a function around a ball."""
        return _taylor_coefficients(kind, start.mid().man_exp(), start.rad().man_exp(), self.count, ctx.prec)


def _bound_on_disc(function: Function, start: arb, farther: arb) -> arb:
    """Return a bound on a function on a disc around a ball; NaN without one."""
    around = acb(start, 0) + acb(arb(0, farther), arb(0, farther))
    if function.ball is None or function.cut(around):
        return arb.nan()
    return arb(function.ball(around).abs_upper())


@lru_cache
def _taylor_coefficients(
    kind: Any, middle: tuple[int, int], radius: tuple[int, int], count: int, bits: int
) -> tuple[arb, ...]:
    """Return the first coefficients of a function around a ball."""
    x = sp.Dummy()
    start = arb(middle, radius)
    with working_precision(bits, count + 1):
        series = series_function(kind(x), x, {})(arb_series([start, 1], prec=count + 1))
        coefficients = tuple(series[k] for k in range(count + 1))
    if not all(coefficient.is_finite() for coefficient in coefficients):
        raise NotAnalytic(f"{kind.__name__} is not analytic at {float(start)}")
    return coefficients

"""Laurent series at 0, with exact coefficients, of the formulas that averages have."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import reduce
from itertools import islice
from operator import add, mul

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.proof.algebra import Algebra, Element

__all__ = ["Expansion", "Series"]

_HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Series:
    """x^order (c_0 + c_1 x + ...), known as far as the coefficients go; c_0 is not 0, or there are none."""

    order: int
    coefficients: list[Element]

    @classmethod
    def of(cls, order: int, coefficients: Iterable[Element]) -> "Series":
        """Return a series without its leading zeros."""
        found = list(coefficients)
        zeros = next((i for i, c in enumerate(found) if c), len(found))
        return cls(order + zeros, found[zeros:])

    @property
    def known(self) -> int:
        """The first power of x whose coefficient is not known."""
        return self.order + len(self.coefficients)

    def coefficient(self, power: int) -> Element | None:
        """Return the coefficient of a power below `known`, None where the series has not begun."""
        return self.coefficients[power - self.order] if power >= self.order else None

    def __add__(self, other: "Series") -> "Series":
        powers = range(min(self.order, other.order), min(self.known, other.known))
        pairs = ([c for c in (self.coefficient(n), other.coefficient(n)) if c is not None] for n in powers)
        return Series.of(powers.start, [reduce(add, pair) for pair in pairs])

    def __mul__(self, other: "Series") -> "Series":
        count = min(len(self.coefficients), len(other.coefficients))
        left, right = self.coefficients, other.coefficients
        values = [reduce(add, [left[i] * right[n - i] for i in range(n + 1)]) for n in range(count)]
        return Series.of(self.order + other.order, values)


class Expansion:
    """Expressions in `x` as series with `terms` terms, coefficients in the constants of an algebra."""

    def __init__(self, algebra: Algebra, x: Expr, terms: int) -> None:
        self.algebra, self.x, self.terms = algebra, x, terms
        self._seen: dict[Expr, Series] = {}

    def of(self, expr: Expr) -> Series:
        """Return the series; raise ValueError where there is none at 0."""
        if expr not in self._seen:
            self._seen[expr] = self._made(expr)
        return self._seen[expr]

    def _made(self, expr: Expr) -> Series:
        if not expr.has(self.x):
            return self._constant(self.algebra.of(expr))
        if expr == self.x:
            return Series(1, self._constant(self.algebra.of(sp.S.One)).coefficients)
        if expr.is_Add or expr.is_Mul:
            return reduce(add if expr.is_Add else mul, map(self.of, expr.args))
        if isinstance(expr, sp.exp | sp.sin | sp.cos) and expr.args[0].is_Add:
            expanded = sp.expand(expr, power_exp=True, trig=True)
            if expanded != expr:
                return self.of(expanded)
        if expr.is_Pow and not isinstance(expr, sp.exp):
            return self._power(self.of(expr.base), expr.exp)
        if expr.func in (sp.log, sp.atan, sp.asinh, sp.erf):
            return self._integrated(expr)
        if isinstance(expr, sp.hyper):
            return self._hypergeometric(expr.args[0], expr.args[1], self.of(expr.args[2]))
        if isinstance(expr, sp.elliptic_pi):
            return self._third_kind(*map(self.of, expr.args))
        rule = _AS_HYPERGEOMETRIC.get(expr.func)
        if rule is None:
            raise ValueError(f"the series of {expr.func.__name__} at {self.x} = 0 is not known here")
        return self.of(rule(*expr.args))

    def _constant(self, value: Element) -> Series:
        return Series(0, [value, *[self.algebra.of(sp.S.Zero)] * (self.terms - 1)])

    def _power(self, base: Series, exponent: Expr) -> Series:
        """Return base^p by the series of (1 + x)^p; p an integer, or a half, or base(0) != 0."""
        if not base.coefficients:
            raise ValueError("too many terms of a base cancel")
        order, lead = exponent * base.order, base.coefficients[0]
        if not order.is_Integer:
            raise ValueError(f"a fractional power of {self.x} is no series at {self.x} = 0")
        if exponent.is_Integer:
            front = lead ** int(exponent)
        elif exponent.is_Rational and exponent.q in (2, 4):
            front = self.algebra.root_of_constant(lead, int(exponent.q)) ** int(exponent.p)
        else:
            front = self.algebra.of(self.algebra.expression(lead) ** exponent)
        minus_rest = Series.of(1, [self.algebra.of(sp.S.NegativeOne) * c / lead for c in base.coefficients[1:]])
        series = self._hypergeometric([-exponent], [], minus_rest)
        return Series(int(order), [front * c for c in series.coefficients])

    def _hypergeometric(self, upper: Iterable[Expr], lower: Iterable[Expr], z: Series) -> Series:
        """Return the sum of (upper)_k/(lower)_k z^k/k!."""

        def of_power(k: int) -> Expr:
            above, below = (sp.Mul(*[sp.rf(a, k) for a in parameters]) for parameters in (upper, lower))
            return above / below / sp.factorial(k)

        return self._composed(map(of_power, range(self.terms)), z)

    def _composed(self, taylor: Iterable[Expr], inner: Series) -> Series:
        """Return sum taylor[k] inner^k for an inner series that vanishes at 0."""
        if inner.order < 1:
            raise ValueError("a function is needed at another place than 0")
        total, power = self._constant(self.algebra.of(sp.S.Zero)), self._constant(self.algebra.of(sp.S.One))
        for value in islice(taylor, self.terms):
            total += self._constant(self.algebra.of(value)) * power
            power *= inner
            if not power.coefficients or power.order >= self.terms:
                break
        return total

    def _integrated(self, expr: Expr) -> Series:
        """Return f(z) = f(z(0)) + the integral of its derivative."""
        inner, slope = self.of(expr.args[0]), self.of(sp.diff(expr, self.x))
        if slope.order < 0 and slope.coefficients:
            raise ValueError(f"{expr} is infinite at {self.x} = 0")
        if inner.order < 0 or inner.known < 1:
            raise ValueError(f"{expr} is not known at {self.x} = 0")
        start = inner.coefficient(0)
        front = expr.func(sp.S.Zero if start is None else self.algebra.expression(start))
        grown = [c / self.algebra.of(sp.Integer(n)) for n, c in enumerate(slope.coefficients, slope.order + 1)]
        return self._constant(self.algebra.of(front)) + Series(slope.order + 1, grown)

    def _third_kind(self, n: Series, m: Series) -> Series:
        """pi/2 sum over k and j of n^k m^j (1/2)_j (1/2)_(k+j)/(j! (k+j)!)."""
        if n.order < 1:
            raise ValueError("elliptic_pi is needed at another place than 0")
        total, power = self._constant(self.algebra.of(sp.S.Zero)), self._constant(self.algebra.of(sp.S.One))
        for k in range(self.terms):
            front = self.algebra.of(sp.pi / 2 * sp.rf(_HALF, k) / sp.factorial(k))
            series = self._hypergeometric([_HALF, _HALF + k], [sp.Integer(1 + k)], m)
            total += self._constant(front) * power * series
            power *= n
            if power.order >= self.terms:
                break
        return total


def _of_bessel(sign: int) -> Callable[[Expr, Expr], Expr]:
    return lambda n, z: (z / 2) ** n / sp.factorial(n) * sp.hyper((), (n + 1,), sign * z**2 / 4)


_AS_HYPERGEOMETRIC: dict[type[Expr], Callable[..., Expr]] = {
    sp.exp: lambda z: sp.hyper((), (), z),
    sp.cos: lambda z: sp.hyper((), (_HALF,), -(z**2) / 4),
    sp.sin: lambda z: z * sp.hyper((), (3 * _HALF,), -(z**2) / 4),
    sp.besseli: _of_bessel(1),
    sp.besselj: _of_bessel(-1),
    sp.elliptic_k: lambda m: sp.pi / 2 * sp.hyper((_HALF, _HALF), (1,), m),
    sp.elliptic_e: lambda m: sp.pi / 2 * sp.hyper((-_HALF, _HALF), (1,), m),
}

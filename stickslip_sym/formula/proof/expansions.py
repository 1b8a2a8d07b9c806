"""Laurent series at 0, with exact coefficients, of the formulas that harmonic averages have."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import sympy as sp
from sympy.polys.rings import PolyElement

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.proof.differential import Algebra

__all__ = ["Expansion", "Series"]

_HALF = sp.Rational(1, 2)


@dataclass(frozen=True)
class Series:
    """x^order (c_0 + c_1 x + ...), known as far as the coefficients go."""

    order: int
    coefficients: list[PolyElement]

    @property
    def known(self) -> int:
        """The first power of x whose coefficient is not known."""
        return self.order + len(self.coefficients)

    def coefficient(self, power: int) -> PolyElement | int:
        """Return the coefficient of a power below `known`."""
        return self.coefficients[power - self.order] if power >= self.order else 0


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
            return self._constant(self.algebra.constant(expr))
        if expr == self.x:
            return Series(1, self._constant(self.algebra.ring.one).coefficients)
        if expr.is_Add:
            return reduce(self._sum, map(self.of, expr.args))
        if expr.is_Mul:
            return reduce(self._product, map(self.of, expr.args))
        if expr.is_Pow:
            return self._power(self.of(expr.base), expr.exp)
        if expr.func in (sp.log, sp.atan, sp.asinh, sp.erf):
            return self._integrated(expr)
        return self._function(expr.func, expr.args)

    def _constant(self, value: PolyElement) -> Series:
        return Series(0, [value, *[self.algebra.ring.zero] * (self.terms - 1)])

    def _sum(self, a: Series, b: Series) -> Series:
        low, high = min(a.order, b.order), min(a.known, b.known)
        return self._stripped(Series(low, [a.coefficient(n) + b.coefficient(n) for n in range(low, high)]))

    def _stripped(self, a: Series) -> Series:
        zeros = next((i for i, c in enumerate(a.coefficients) if c != 0), len(a.coefficients))
        return Series(a.order + zeros, a.coefficients[zeros:])

    def _product(self, a: Series, b: Series) -> Series:
        count = min(len(a.coefficients), len(b.coefficients))
        values = [self.algebra.ring.zero] * count
        for i, left in enumerate(a.coefficients[:count]):
            if left != 0:
                for j, right in enumerate(b.coefficients[: count - i]):
                    if right != 0:
                        values[i + j] += self.algebra.product(left, right)
        return self._stripped(Series(a.order + b.order, values))

    def _power(self, base: Series, exponent: Expr) -> Series:
        """Return base^p by the series of (1 + x)^p; p an integer, or a half, or base(0) != 0."""
        lead = base.coefficients[0] if base.coefficients else self.algebra.ring.zero
        if lead == 0:
            raise ValueError("a base is 0 as far as its series goes")
        order = exponent * base.order
        if not order.is_Integer:
            raise ValueError("a fractional power of V is no series at V = 0")
        if exponent.is_Integer:
            front = self.algebra.power(lead, int(exponent))
        elif exponent.is_Rational and exponent.q in (2, 4):
            front = self.algebra.power(self.algebra.root_of_constant(lead, exponent.q), int(exponent.p))
        else:
            front = self.algebra.constant(self.algebra.expression(lead) ** exponent)
        inverse = self.algebra.inverse(lead)
        rest = Series(0, [self.algebra.product(c, inverse) for c in base.coefficients])
        rest = self._sum(rest, Series(0, [-self.algebra.ring.one, *[self.algebra.ring.zero] * (self.terms - 1)]))
        series = self._composed([sp.ff(exponent, k) / sp.factorial(k) for k in range(self.terms)], rest)
        return Series(int(order) + series.order, [self.algebra.product(front, c) for c in series.coefficients])

    def _composed(self, taylor: Sequence[Expr], inner: Series) -> Series:
        """Return sum taylor[k] inner^k for an inner series that vanishes at 0."""
        if inner.order < 1:
            raise ValueError("a function is needed at another place than 0")
        total = self._constant(self.algebra.constant(sp.sympify(taylor[0])))
        power = self._constant(self.algebra.ring.one)
        for value in taylor[1:]:
            power = self._product(power, inner)
            factor = self.algebra.constant(sp.sympify(value))
            total = self._sum(
                total, Series(power.order, [self.algebra.product(factor, c) for c in power.coefficients])
            )
            if not power.coefficients or power.order >= self.terms:
                break
        return total

    def _function(self, kind: Expr, arguments: Sequence[Expr]) -> Series:
        counted = range(self.terms)
        if kind in (sp.besseli, sp.besselj) and arguments[0] in (0, 1):
            order, sign = int(arguments[0]), 1 if kind is sp.besseli else -1
            taylor = [sp.Integer(0)] * (2 * self.terms + 2)
            for k in counted:
                taylor[2 * k + order] = sp.Rational(
                    sign**k, 2 ** (2 * k + order) * sp.factorial(k) * sp.factorial(k + order)
                )
            return self._composed(taylor[: self.terms], self.of(arguments[1]))
        if kind is sp.hyper:
            upper, lower, z = arguments
            values = [
                sp.prod([sp.rf(a, k) for a in upper]) / sp.prod([sp.rf(b, k) for b in lower]) / sp.factorial(k)
                for k in counted
            ]
            return self._composed(values, self.of(z))
        if kind in (sp.elliptic_e, sp.elliptic_k) and len(arguments) == 1:
            ratio = [sp.rf(_HALF, k) ** 2 / sp.factorial(k) ** 2 for k in counted]
            if kind is sp.elliptic_e:
                ratio = [value / (1 - 2 * k) for k, value in enumerate(ratio)]
            return self._composed([sp.pi / 2 * value for value in ratio], self.of(arguments[0]))
        if kind is sp.elliptic_pi and len(arguments) == 2:
            return self._third_kind(self.of(arguments[0]), self.of(arguments[1]))
        inner = self.of(arguments[0])
        if kind is sp.exp:
            front, rest = self._split(inner, sp.exp)
            return self._product(
                self._constant(front), self._composed([1 / sp.factorial(k) for k in counted], rest)
            )
        if kind in (sp.sin, sp.cos):
            front, rest = self._split(inner, kind)
            other, _ = self._split(inner, sp.cos if kind is sp.sin else sp.sin)
            sign = 1 if kind is sp.sin else -1
            even, odd = (
                [sp.Integer(0) if (k - j) % 2 else sp.Rational((-1) ** (k // 2), sp.factorial(k)) for k in counted]
                for j in (0, 1)
            )
            parts = [
                self._product(self._constant(factor), self._composed(taylor, rest))
                for factor, taylor in ((front, even), (sign * other, odd))
            ]
            return self._sum(*parts)
        raise ValueError(f"the series of {kind.__name__} at V = 0 is not known here")

    def _integrated(self, expr: Expr) -> Series:
        """Return f(z) = f(z(0)) + the integral of its derivative."""
        slope = self.of(sp.diff(expr, self.x))
        if slope.order < 0 and slope.coefficients:
            raise ValueError(f"{expr} is infinite at {self.x} = 0")
        front, _ = self._split(self.of(expr.args[0]), expr.func)
        grown = [
            self.algebra.product(c, self.algebra.scalar(sp.Rational(1, slope.order + k + 1)))
            for k, c in enumerate(slope.coefficients)
        ]
        return self._sum(self._constant(front), Series(slope.order + 1, grown))

    def _split(self, inner: Series, function: Expr) -> tuple[PolyElement, Series]:
        """Return function(inner(0)) and inner - inner(0)."""
        if inner.order < 0 or inner.known < 1:
            raise ValueError(f"{function.__name__} of what is not known at 0")
        value = inner.coefficient(0)
        if value == 0:
            return self.algebra.constant(function(sp.Integer(0))), inner
        front = self.algebra.constant(function(self.algebra.expression(value)))
        return front, self._sum(inner, self._constant(-value))

    def _third_kind(self, n: Series, m: Series) -> Series:
        """pi/2 sum over k and j of n^k m^j (1/2)_j (1/2)_(k+j)/(j! (k+j)!)."""
        if n.order < 1:
            raise ValueError("elliptic_pi is needed at another place than 0")
        total, power = self._constant(self.algebra.ring.zero), self._constant(self.algebra.ring.one)
        for k in range(self.terms):
            values = [
                sp.pi / 2 * sp.rf(_HALF, j) * sp.rf(_HALF, k + j) / sp.factorial(j) / sp.factorial(k + j)
                for j in range(self.terms)
            ]
            total = self._sum(total, self._product(power, self._composed(values, m)))
            power = self._product(power, n)
            if power.order >= self.terms:
                break
        return total

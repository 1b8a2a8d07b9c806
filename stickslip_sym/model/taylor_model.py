"""A coefficient of friction near rest as a power series with a bound on all that the series leaves out.

(1 - exp(-v))/v has no ball around v = 0, for each of its terms is infinite there. As a series the terms cancel
exactly, and what stays is small on balls of any width. So a formula is expanded as a whole: with x = v^(1/unit)

    f = x^low (c_0 + c_1 x + ...) + x^top g(x),    |g(x)| <= rest    for complex |x| <= radius.

Sums, products and powers are those of Taylor models (Makino, Berz: Taylor models and other validated functional
inclusion methods, Int. J. Pure Appl. Math. 4, 2003); a function's own remainder is bounded by Cauchy's estimate.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, reduce
from operator import mul

import numpy as np
import sympy as sp
from flint import acb, acb_poly, arb, arb_poly, arb_series, ctx

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Substitution
from stickslip_sym.core.balls import BallFunction, ball_function, number_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import fold
from stickslip_sym.core.numbers import DOUBLE_BITS, NEGLIGIBLE
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.formula_algebra import Bound, ExpansionAlgebra, NotAnalytic
from stickslip_sym.model.leading_terms import has_limit_at_rest

_MOST_TERMS = 160  # of a polynomial: more precision than they give is asked for in thousands of digits only
_CIRCLE_RATIO = 2  # times the size of an argument: the circle on which a function is bounded
_RADII = 12  # halvings of the radius that are tried
SHARE_OF_RADIUS = 0.25
"""Of that for which a bound is known, within which a series is used: each term gains two bits."""
_INSIDE_IN_FLOATS = SHARE_OF_RADIUS**2  # within which floats need few terms


@dataclass(frozen=True)
class TaylorModel:
    """A function of x, and what its polynomial leaves out.

    Attributes
    ----------
    low : int
        The power of x that stands before the polynomial.
    polynomial : flint.arb_poly
    top : int
        The power of x that stands before what is left out.
    rest : flint.arb
        A bound on that, over x^top.
    radius : flint.arb
        Of x, up to which it holds.
    unit : int
        x = v^(1/unit).
    """

    low: int
    polynomial: arb_poly
    top: int
    rest: arb
    radius: arb
    unit: int

    def __add__(self, other: "TaylorModel") -> "TaylorModel":
        low = min(self.low, other.low)
        top = min(self.top, other.top)
        total = self.polynomial.left_shift(self.low - low) + other.polynomial.left_shift(other.low - low)
        rest = sum((one.rest * self.radius ** (one.top - top) for one in (self, other)), arb(0))
        return self._cut(low, total, top, rest)

    def __mul__(self, other: "TaylorModel") -> "TaylorModel":
        low = self.low + other.low
        radius = self.radius
        tops = self.top + other.low, other.top + self.low
        top = min(tops)
        sizes = _bound_within_radius(other.polynomial, radius), _bound_within_radius(self.polynomial, radius)
        rests = self.rest, other.rest
        rest = sum((r * s * radius ** (t - top) for r, s, t in zip(rests, sizes, tops, strict=True)), arb(0))
        rest += self.rest * other.rest * radius ** (self.top + other.top - top)
        return self._cut(low, self.polynomial * other.polynomial, top, rest)

    def _cut(self, low: int, polynomial: arb_poly, top: int, rest: arb) -> "TaylorModel":
        """Return a model whose polynomial ends below x^top, and begins with what is not exactly 0."""
        kept = max(top - low, 0)
        rest += _bound_within_radius(polynomial.right_shift(kept), self.radius) * self.radius ** max(low - top, 0)
        coefficients = list(polynomial.truncate(kept))
        zeros = next((k for k, c in enumerate(coefficients) if c != 0 or c.rad() != 0), len(coefficients))
        whole = arb_poly(coefficients[zeros:])
        return replace(self, low=low + zeros, polynomial=whole, top=max(top, low + zeros), rest=rest.abs_upper())

    @property
    def is_exactly_zero(self) -> bool:
        """Whether it is the number 0."""
        return bool(self.polynomial.length() == 0 and self.rest == 0)

    @property
    def size(self) -> arb:
        """A bound on the function within the radius, for a function without a pole."""
        return (
            _bound_within_radius(self.polynomial, self.radius) * self.radius**self.low
            + self.rest * self.radius**self.top
        )

    def scaled(self, factor: arb, power: int = 0) -> "TaylorModel":
        """Return it times a number and a power of x."""
        return replace(
            self, low=self.low + power, polynomial=self.polynomial * factor, top=self.top + power,
            rest=(self.rest * abs(factor)).abs_upper(),
        )  # fmt: skip

    def split(self) -> tuple[arb, "TaylorModel"]:
        """Return the value at v = 0, and what vanishes there."""
        if self.low < 0:
            raise NotAnalytic("it is infinite at rest")
        if self.low == 0:
            return (self.polynomial[0], self.without_first())
        return (arb(0), self)

    def constant(self, value: arb) -> "TaylorModel":
        """Return a number with as many terms."""
        return self._cut(0, arb_poly([value]), self.top - self.low, arb(0))

    @property
    def leading(self) -> arb:
        """The first coefficient, which must be certain."""
        first = self.polynomial[0]
        if self.polynomial.length() == 0 or not bool(first != 0):
            raise NotAnalytic("the first term is not certain")
        return first

    def without_first(self) -> "TaylorModel":
        """Return it without its first coefficient."""
        if self.polynomial.length() == 0:
            raise NotAnalytic("no coefficient is known")
        return replace(self, low=self.low + 1, polynomial=self.polynomial.right_shift(1))

    def inserted_in(self, coefficients: Sequence[arb], bound: Bound) -> "TaylorModel":
        """Return a power series of this, which vanishes with x; `bound` holds for the function on a wider circle.

        By Cauchy's estimate coefficient k of a function that is below `most` on |w| = r is below most/r^k. What
        the product of polynomials has beyond the last power is bounded by that of the sizes of their coefficients.
        """
        most = bound((_CIRCLE_RATIO * self.size).abs_upper())
        if self.low < 1 or not most.is_finite():
            raise NotAnalytic("a function is not bounded")
        if self.size == 0:
            return self.constant(coefficients[0])
        count = self.top
        inner = self.polynomial.left_shift(self.low)
        with working_precision(ctx.prec, count):
            whole, sizes = (
                arb_series(list(map(of, coefficients)))(arb_series(list(map(of, inner)))) for of in (arb, abs)
            )
        largest = arb_poly([abs(c) for c in coefficients])(self.size)
        cut_off = largest - arb_poly([sizes[k] for k in range(count)])(self.radius)
        left_out = most * arb(_CIRCLE_RATIO) ** (1 - len(coefficients)) / (_CIRCLE_RATIO - 1)
        rest = (abs(cut_off) + left_out) / self.radius**count
        return replace(self, low=0)._cut(0, arb_poly([whole[k] for k in range(count)]), count, rest)

    def derivative(self) -> "TaylorModel":
        """Return the derivative by v within half the radius: Cauchy's estimate bounds that of the remainder."""
        radius = self.radius / 2
        coefficients = [(self.low + k) * c / self.unit for k, c in enumerate(self.polynomial)]
        rest = self.rest * (abs(self.top) + radius / (self.radius - radius)) / self.unit
        low = self.low - self.unit
        top = self.top - self.unit
        return replace(self, radius=radius)._cut(low, arb_poly(coefficients), top, rest)

    def within(self, v: acb) -> bool:
        """Whether slip speeds are so low that the series is as good as its precision."""
        return bool(v.abs_upper() <= (SHARE_OF_RADIUS * self.radius) ** self.unit)

    def ball(self, v: acb, analytic: bool) -> acb:
        """Return a ball around the values at slip speeds within the radius."""
        x = v
        if self.unit != 1:
            x = v.pow(acb(1) / self.unit, analytic)
        if self.low < 0 and x.contains(0):
            return acb("nan")
        left_out = (self.rest * arb(x.abs_upper()) ** max(self.top - self.low, 0)).abs_upper()
        sides = arb(0, left_out), arb(0) if x.imag == 0 else arb(0, left_out)
        return (acb_poly(list(self.polynomial))(x) + acb(*sides)) * _multiply_out(x, self.low)


def _multiply_out(x: acb, power: int) -> acb:
    if power >= 0:
        return reduce(mul, [x] * power, acb(1))
    return 1 / _multiply_out(x, -power)


def _bound_within_radius(polynomial: arb_poly, radius: arb) -> arb:
    """Return a bound on a polynomial within a radius."""
    return arb_poly([abs(c) for c in polynomial])(radius)


def unit_of_powers(expr: Expr, point: Substitution) -> int:
    """Return the common denominator of the powers of v at rest."""
    exponents = [node.exp.xreplace(dict(point)) for node in expr.atoms(sp.Pow) if node.base == symbols.v]
    return math.lcm(*(int(exponent.q) for exponent in exponents if exponent.is_Rational))


@dataclass(frozen=True)
class RestPolynomial:
    """A coefficient near rest in floats: a polynomial in v^(1/unit)."""

    unit: int
    coefficients: tuple[float, ...]

    @property
    def onset(self) -> float:
        """Its value at rest."""
        return self.coefficients[0]

    def rise(self, v: FloatArray) -> FloatArray:
        """Return how much it is above its value at rest."""
        x = v if self.unit == 1 else v ** (1 / self.unit)
        return np.asarray(np.polynomial.polynomial.polyval(x, (0.0, *self.coefficients[1:])))

    def slope(self, v: FloatArray) -> FloatArray:
        """Return its derivative by the slip speed."""
        x = v if self.unit == 1 else v ** (1 / self.unit)
        rates = np.arange(1, len(self.coefficients)) * self.coefficients[1:] / self.unit
        with np.errstate(all="ignore"):
            value = np.polynomial.polynomial.polyval(x, rates) * x ** (1 - self.unit)
        return np.asarray(value)


def taylor_model(expr: Expr, point: Substitution) -> TaylorModel | None:
    """Return a smooth coefficient near rest at the working precision; None where it has no such series.

    A coefficient with a pole or a logarithm at v = 0 has none.
    """
    return _made(expr, tuple(point.items()), ctx.prec)


@lru_cache
def _made(expr: Expr, point: tuple[tuple[Expr, Expr], ...], bits: int) -> TaylorModel | None:
    whole = sp.factor_terms(expr)  # a common factor, inexact, would hide that terms cancel
    model = _model_with_pole(whole, dict(point), bits)
    return None if model is None else _remove_pole(model, whole, dict(point))


def _model_with_pole(expr: Expr, point: Substitution, bits: int) -> TaylorModel | None:
    """Return the model of a function that may have a pole at v = 0."""
    unit = unit_of_powers(expr, point)
    count = min(bits // 3 + 10, _MOST_TERMS)
    if unit > count:  # no power of v would be left
        return None
    for halvings in range(_RADII):
        radius = (arb(_lowest_scale(expr, point)) / 2**halvings).root(unit)
        try:
            v = TaylorModel(unit, arb_poly([1]), unit + count, arb(0), arb(radius.mid()), unit)
            return fold(expr, ExpansionAlgebra(point, v, count))
        except (NotAnalytic, InputError, ValueError, ZeroDivisionError, OverflowError):
            continue
    return None


def _remove_pole(model: TaylorModel, expr: Expr, point: Substitution) -> TaylorModel | None:
    """Return a model without a pole; None if it has one.

    Coefficients below x^0 that balls do not tell from 0 are 0 where the coefficient has a finite limit.
    """
    poles = list(model.polynomial)[: max(0, -model.low)]
    if model.low >= 0:
        return model
    if not all(c.contains(0) for c in poles) or model.top < 0 or not has_limit_at_rest(expr, point):
        return None
    return replace(model, low=0, polynomial=model.polynomial.right_shift(-model.low))


def coefficient_near_rest(expr: Expr, point: Substitution) -> tuple[float, RestPolynomial] | None:
    """Return a coefficient near rest where its formula is no number at v = 0; None where it is, or has no series.

    That is the slip speed up to which it holds, and a polynomial in v^(1/unit) with unit and coefficients.
    """
    with working_precision(2 * DOUBLE_BITS):
        direct = ball_function(expr, symbols.v, point)
        if direct(acb(0), False).is_finite() or (model := taylor_model(expr, point)) is None:
            return None
        reach = float(model.radius) * _INSIDE_IN_FLOATS
        coefficients = [float(c) for c in model.polynomial]
        largest = max(abs(c) * reach**k for k, c in enumerate(coefficients))
        kept = [c if abs(c) * reach**k > NEGLIGIBLE * largest else 0.0 for k, c in enumerate(coefficients)]
        return reach**model.unit, RestPolynomial(model.unit, tuple([0.0] * model.low + kept))


def _lowest_scale(expr: Expr, point: Substitution) -> float:
    """Return the least slip speed at which an argument of a function or a base is as large as it is at rest."""
    scales = [1.0]
    for node in expr.atoms(sp.Function, sp.Pow):
        if node.is_Pow and node.base is sp.E:
            argument = node.exp
        else:
            argument = node.args[0]
        if argument == symbols.v or not argument.is_polynomial(symbols.v):
            continue
        *higher, constant = (abs(float(number_at(c, point))) for c in sp.Poly(argument, symbols.v).all_coeffs())
        level = 1.0
        if node.is_Pow and node.base is not sp.E:
            level = constant
        if level:
            scales += [(level / c) ** (1 / k) for k, c in enumerate(higher[::-1], 1) if c]
    return min(scales)


def balls_from_rest(mu: Expr, point: Substitution, *, slope: Expr | None = None) -> BallFunction:
    """Return a smooth coefficient, or its slope, as a function of balls, finite around v = 0 where it is there.

    The coefficient is expanded only where its formula has no value at v = 0.
    """
    coefficient = ball_function(mu, symbols.v, point)
    direct = coefficient if slope is None else ball_function(slope, symbols.v, point)
    if not mu.has(symbols.v) or coefficient(acb(0), False).is_finite():
        return direct
    model = taylor_model(mu, point)
    if model is None:
        return direct
    series = model if slope is None else model.derivative()

    def of_balls(v: acb, analytic: bool) -> acb:
        if not series.within(v):
            return direct(v, analytic)
        by_series = series.ball(v, analytic)
        by_formula = direct(v, analytic)
        narrower = by_formula.is_finite() and by_formula.real.rad() < by_series.real.rad()
        return by_formula if narrower else by_series

    return of_balls

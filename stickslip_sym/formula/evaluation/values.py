"""The average F(r) = -<g'(r(1 + s))>_w of a profile g(x), to some twenty digits more than a float has.

From the closed form in ball arithmetic where there is one, else by a Gauss rule in the same arithmetic. Its
panels halve towards x = 0, so that all scales are met, and are split at kinks. In the outer half 1 - s = u^2,
for there a weight may vanish like a square root; in the innermost one 1 + s is a power of u too, for the slope may
be x^q. Beside it: the mean size of the slope, and the speed at which a profile ends.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import acb, arb, arb_poly, arb_series, ctx, fmpq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.balls import (
    BallFunction,
    ball_function,
    ball_value,
    rational,
    series_function,
    working_precision,
)
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import without_squares
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.expression.pieces import branch_from, jumps, places

__all__ = ["BITS", "MeanSlope", "Unresolved", "Values", "mean_power", "radius_of", "reach_of", "slope_of"]

BITS = 110
"""The working precision of values."""

_PRECISIONS = (BITS, 3 * BITS, 9 * BITS)  # in which the closed form is tried
_ENOUGH = 70  # bits of relative accuracy that a value of the closed form needs
_NODES = 22  # in a panel no longer than its distance to x = 0: they give 2^-110
_DEEPEST = 1200  # panels towards x = 0
_COUNTED = 36  # coefficients by which a radius of convergence is judged
_FAR = 64.0  # a radius that is as good as infinite
_INSIDE = 0.25  # of the radius of convergence: a panel of that length from x = 0 is the innermost
_PLACES, _SHARES = (0.375, 2.2, 17.0), (0.2, 0.5, 0.8)  # r at which a closed form is checked; shares of its range
_SAME = 2.0**-40  # by which it agrees: the rule may not resolve a narrow transition to the last bit
_LONGEST = 0.5  # such a panel: there the other end of a weight is far enough away
_CLOSE, _STEEP = 2.0**-5, 8  # without a power series: the innermost panel, where p is this power of the variable
_SPLITS = (1, 2, 4, 8, 16, 32)  # parts of a panel that are tried, for profiles with a narrow transition
_PROBES = (20, *(k / 4 for k in range(-12, 8)), 4, 7)
"""Binary exponents of the r at which that is judged: a wave for ever is met first; a transition lies anywhere in
the panels of one octave."""
_AGREED = 2.0**-62  # of two numbers of parts


class Unresolved(ArithmeticError):
    """No number of parts gives the values of an average: its profile waves for ever."""


class Values:
    """F(r) as a function of balls. Call it with the working precision `BITS`.

    Parameters
    ----------
    profile : sympy.Expr
        g in the symbol v, and in shapes.
    criterion : Criterion
    closed : sympy.Expr or None
        F in the symbol V; forgotten where it is not the average by the Gauss rule too, at a few places.
    point : mapping
        Values of the shapes in them.

    Raises
    ------
    InputError
        For a function that has no balls.
    """

    def __init__(
        self, profile: Expr, criterion: Criterion, closed: Expr | None, point: Mapping[Expr, Expr]
    ) -> None:
        self.profile, self.criterion, self.point = profile, criterion, point
        ends = [ball_value(place, point).real for place in places(profile)]
        self.kinks = sorted((end for end in ends if bool(end > 0)), key=float)
        inner = [sp.Rational(float(low + high) / 2) for low, high in pairwise([arb(0), *self.kinks])]
        outer = sp.Rational(float(2 * self.kinks[-1])) if self.kinks else sp.Integer(1)
        self._pieces = [branch_from(profile, point, place) for place in (*inner, outer)]
        self.last_piece = self._pieces[-1]
        self._slopes = [ball_function(slope_of(piece), symbols.v, point) for piece in self._pieces]
        self._jumps = [
            (ball_value(place, point).real, ball_value(height, point).real) for place, height in jumps(profile)
        ]
        mean_slope, shapes = MeanSlope(profile, criterion, list(point)), [float(value) for value in point.values()]
        self.mean_slope: Callable[[FloatArray], FloatArray] = lambda r: mean_slope(r, *shapes)
        self.reach = reach_of(profile, point)
        self.radius = self._radius()
        self._inner, self._order = (min(_INSIDE * self.radius, _LONGEST), 2) if self.radius else (_CLOSE, _STEEP)
        self._split: int | None = None
        self._formulas: dict[int, BallFunction] = {}
        self._closed = closed
        if closed is not None:
            tried = _PLACES if self.reach == np.inf else [share * self.reach / 2 for share in _SHARES]
            with working_precision(BITS):
                pairs = [(value, self._by_rule(r)) for r in map(arb, tried) if (value := self._by_formula(r))]
            if not all(bool(abs(value - right) <= _SAME * abs(value)) for value, right in pairs):
                self._closed = None

    # -- power series ------------------------------------------------------------------------------

    def _radius(self) -> float:
        """Return the radius of convergence of g' at x = 0; 0 where it has no power series."""
        coefficients = self.taylor(_COUNTED)
        if coefficients is None:
            return 0.0
        return min(radius_of(coefficients), _FAR)

    def taylor(self, count: int) -> list[arb] | None:
        """Return the coefficients of the slope g' in powers of x, or None."""
        return self._expanded(slope_of(self._pieces[0]), count)

    def taylor_in_powers(self, exponent: Expr, most: int, count: int) -> list[list[arb]] | None:
        """Return the coefficients g_kj of g = sum g_kj v^(k exponent + j), or None where there are none.

        At most `most` powers k, and `count` powers j: one of each where v occurs in the power only.
        """
        powers = [node for node in self._pieces[0].atoms(sp.Pow) if node.base == symbols.v]
        z = sp.Dummy(positive=True)
        expr = self._pieces[0].xreplace(dict.fromkeys(powers, z))
        if not expr.has(symbols.v):
            series = self._expanded(expr.xreplace({z: symbols.v}), count)
            return None if series is None else [[c] for c in series]
        rows = []
        for k in range(most):
            row = self._expanded((expr / sp.factorial(k)).subs(z, 0), count)
            if row is None:
                return None
            rows.append(row)
            expr = sp.diff(expr, z)
        return rows

    def _expanded(self, expr: Expr, count: int) -> list[arb] | None:
        try:
            with working_precision(ctx.prec, count):
                series = series_function(expr, symbols.v, self.point)(arb_series([0, 1], prec=count))
        except (ValueError, ZeroDivisionError, InputError):
            return None
        coefficients = [series[k] for k in range(count)]
        return coefficients if all(c.is_finite() for c in coefficients) else None

    # -- values ------------------------------------------------------------------------------------

    def __call__(self, r: arb) -> arb:
        """Return F(r).

        Raises
        ------
        Unresolved
        """
        value = self._by_formula(r) if self._closed is not None else None
        return self._by_rule(r) if value is None else value

    def _by_formula(self, r: arb) -> arb | None:
        """Return the closed form's value, with more bits where it cancels; None where that does not help."""
        for bits in _PRECISIONS:
            with working_precision(bits):
                try:
                    if bits not in self._formulas:
                        self._formulas[bits] = ball_function(self._closed, symbols.V, self.point)
                    whole = self._formulas[bits](acb(r), False)
                except InputError:  # a special function that has no balls; the rule has no need of it
                    return None
                except (ValueError, ZeroDivisionError):
                    continue
                value = whole.real
                if value.is_finite() and whole.imag.contains(0) and value.rel_accuracy_bits() >= _ENOUGH:
                    return value
        return None

    def _by_rule(self, r: arb) -> arb:
        if self.criterion.weight is None:
            piece = sum(1 for kink in self.kinks if bool(kink < r))
            return -self._slopes[piece](acb(r), False).real
        if self._split is None:
            self._split = self._parts()
        return self._averaged(r, self._split)

    def _parts(self) -> int:
        """Return into how many parts each panel is cut: the least with which twice as many agree, at all probes.

        They agree beside <|g'|> too, for F may vanish there.
        """
        probes = [arb(3).sqrt() * arb(2) ** k for k in _PROBES]
        if self.reach < np.inf:
            probes = [arb(share * self.reach / 2) for share in _SHARES]
        splits = iter(pairwise(_SPLITS))
        split, finer = next(splits)
        for r in probes:
            while not self._agree(r, split, finer):
                if (step := next(splits, None)) is None:
                    raise Unresolved(f"{self.profile} is not resolved at r = {float(r):g}")
                split, finer = step
        return split

    def _agree(self, r: arb, split: int, finer: int) -> bool:
        rough, fine = self._averaged(r, split), self._averaged(r, finer)
        size = max(abs(float(fine)), float(self.mean_slope(np.array([float(r)]))[0]))
        return abs(float(fine - rough)) <= _AGREED * size

    def _averaged(self, r: arb, split: int) -> arb:
        total = arb(0)
        ends = [arb(0), *(kink / r for kink in self.kinks if bool(kink < 2 * r)), arb(2)]
        for slope, (low, high) in zip(self._slopes, pairwise(ends), strict=False):
            for left, right in _panels(low, high, arb(self._inner) * min(1 / r, arb(1))):
                for p, weight in _nodes(self.criterion, left, right, split, self._order):
                    total += weight * slope(acb(r * p), False).real
        for place, height in self._jumps:
            if bool(place > 0) and bool(place < 2 * r):
                total += height * _weight(self.criterion, place / r, 2 - place / r) / r
        return -total


def _panels(low: arb, high: arb, inner: arb) -> Iterator[tuple[arb, arb]]:
    """Part an interval into panels no longer than their distance to 0, from the right to the left.

    What lies below `inner` is one panel.
    """
    for _ in range(_DEEPEST):
        middle = high / 2
        if not bool(middle > low) or bool(high < inner):
            break
        yield middle, high
        high = middle
    yield low, high


@lru_cache(maxsize=4)
def _legendre(n: int, bits: int) -> list[tuple[arb, arb]]:
    del bits  # they are those of the working precision
    rule = [arb.legendre_p_root(n, k, weight=True) for k in range(n)]
    return [((1 + x.mid()) / 2, weight.mid() / 2) for x, weight in rule]


def _nodes(criterion: Criterion, left: arb, right: arb, split: int, order: int) -> list[tuple[arb, arb]]:
    """Return p = 1 + s and w(s) ds at the nodes of a panel."""
    ends = (tuple(int(part) for part in end.mid().man_exp()) for end in (left, right))
    return _rule(criterion, *ends, split, order)


@lru_cache(maxsize=4096)
def _rule(
    criterion: Criterion, left: tuple[int, int], right: tuple[int, int], split: int, order: int
) -> list[tuple[arb, arb]]:
    a, b = arb(left), arb(right)
    innermost, outer = bool(a == 0), bool(b > 1)
    if innermost:  # p = b u^order
        right_end, b = b, arb(1)
    elif outer:  # 2 - p = u^2
        a, b = (2 - b).sqrt(), (2 - a).sqrt()
    length = (b - a) / split
    pairs = []
    for part in range(split):
        for x, weight in _legendre(_NODES, BITS):
            u = a + (part + x) * length
            p, q, factor = u, 2 - u, arb(1)
            if innermost:
                p = right_end * u**order
                q, factor = 2 - p, right_end * order * u ** (order - 1)
            elif outer:
                p, q, factor = 2 - u * u, u * u, 2 * u
            pairs.append((p.mid(), (weight * length * factor * _weight(criterion, p, q)).mid()))
    return pairs


def _weight(criterion: Criterion, p: arb, q: arb) -> arb:
    """Return w(s) for p = 1 + s and q = 1 - s."""
    return _shifted(criterion)(p) if criterion.is_polynomial else 2 * (p * q).sqrt() / arb.pi()


@lru_cache(maxsize=16)
def _shifted(criterion: Criterion) -> arb_poly:
    """Return a weight that is a polynomial in powers of p = 1 + s."""
    return arb_poly([arb(rational(c)) for c in reversed(criterion.from_rest.all_coeffs())])


def radius_of(coefficients: Sequence[arb]) -> float:
    """Return the radius of convergence of a power series, by the root test on its last third."""
    first = 2 * len(coefficients) // 3
    rate = max(float(abs(c).upper()) ** (1 / k) for k, c in enumerate(coefficients[first:], first))
    return 1 / rate if rate else np.inf


def mean_power(criterion: Criterion, exponent: fmpq) -> arb:
    """Return <(1 + s)^exponent>_w, for any exponent for which it exists."""
    if criterion.weight is None:
        return arb(1)
    a = arb(exponent)
    if criterion.is_polynomial:
        weight = _shifted(criterion)
        return sum((weight[k] * arb(2) ** (a + k + 1) / (a + k + 1) for k in range(len(weight))), arb(0))
    half = arb(1) / 2
    return 2 / arb.pi() * arb(2) ** (a + 2) * (a + 1 + half).gamma() * (1 + half).gamma() / (a + 3).gamma()


def slope_of(profile: Expr) -> Expr:
    """Return g', with sech(a)^2 for 1 - tanh(a)^2, which cancels."""
    return without_squares(sp.diff(profile, symbols.v))


# -- in floats -----------------------------------------------------------------------------------------


class MeanSlope:
    """<|g'|> of a profile to a few per cent, the unit in which errors of F are measured.

    Call it with an array of r, and of each parameter.
    """

    _LEVELS, _POINTS = 70, 6  # panels towards x = 0, nodes in each

    def __init__(self, profile: Expr, criterion: Criterion, parameters: Sequence[Expr]) -> None:
        slope, self._local = slope_of(profile), criterion.weight is None
        functions = [slope]
        if self._local:
            # At one point the rounding of r itself counts.
            self._p, self._w = np.ones(1), np.ones(1)
            functions.append(symbols.v * sp.diff(slope, symbols.v))
        else:
            x, w = np.polynomial.legendre.leggauss(self._POINTS)
            scale = 2.0 ** -np.arange(self._LEVELS)[:, None]
            self._p, self._w = (scale * (x + 3) / 2).ravel(), (scale * w / 2).ravel()
            self._w *= np.abs(
                np.polyval(np.array(criterion.from_rest.all_coeffs(), dtype=float), self._p)
                if criterion.is_polynomial
                else 2 / np.pi * np.sqrt(self._p * (2 - self._p))
            )
        self._functions: list[Callable[..., FloatArray]] = [
            function_of([symbols.v, *parameters], function, "numpy") for function in functions
        ]

    def __call__(self, r: FloatArray, *parameters: float | FloatArray) -> FloatArray:
        """Return <|g'|> at each r."""
        columns = [np.asarray(parameter)[..., None] for parameter in parameters]
        x = r[:, None] * self._p
        with np.errstate(all="ignore"):
            sizes = [
                np.nansum(np.broadcast_to(np.abs(function(x, *columns)), x.shape) * self._w, axis=1)
                for function in self._functions
            ]
        return np.asarray(np.max(sizes, axis=0))


_GRID = 2.0 ** np.arange(-30, 40, 1 / 16)  # where an argument is looked at for a change of its sign


def reach_of(profile: Expr, point: Mapping[Expr, Expr]) -> float:
    """Return the speed at which a profile ends: at a pole, or where a logarithm or a root has no real value.

    Infinity where there is none up to 2^40.
    """
    arguments = {node.args[0] for node in profile.atoms(sp.log)}
    arguments |= {
        node.base
        for node in profile.atoms(sp.Pow)
        if node.base != symbols.v and not (node.exp.is_Integer and node.exp.is_positive)
    }
    shapes = [float(value) for value in point.values()]
    return min((_first_zero(a, list(point), shapes) for a in arguments if a.has(symbols.v)), default=np.inf)


def _first_zero(expr: Expr, parameters: list[Expr], values: list[float]) -> float:
    """Return the lowest speed at which a function of v changes its sign, or infinity."""
    if expr.is_positive:
        return np.inf
    function = function_of([symbols.v, *parameters], expr, "numpy")
    with np.errstate(all="ignore"):
        signs = np.sign(np.broadcast_to(function(_GRID, *values), _GRID.shape))
    changes = np.flatnonzero(signs[1:] * signs[:-1] <= 0)
    if not changes.size:
        return np.inf
    low, high = _GRID[changes[0]], _GRID[changes[0] + 1]
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if np.sign(function(middle, *values)) == signs[changes[0]] else (low, middle)
    return float(low)

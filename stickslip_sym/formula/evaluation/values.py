"""The average F(r) = -<g'(r(1 + s))>_w of a profile g(x), to some twenty digits more than a float has.

From the closed form in ball arithmetic where there is one, else by a Gauss rule in the same arithmetic. Its
panels halve towards x = 0, so that all scales are met, and are split at kinks. In the outer half 1 - s = u^2,
for there a weight may vanish like a square root; in the innermost one 1 + s is a power of u too, for the slope may
be x^q.
"""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp
from flint import acb, arb, arb_poly, arb_series, ctx, fmpq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import (
    BallFunction,
    ball_function,
    ball_value,
    rational,
    series_function,
    working_precision,
)
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.exact import without_squares
from stickslip_sym.model.expression.pieces import branch_from, jumps, places

__all__ = ["BITS", "Values", "mean_power", "reach_of", "slope_of"]

BITS = 110
"""The working precision of values."""

_PRECISIONS = (BITS, 3 * BITS, 9 * BITS)  # in which the closed form is tried
_ENOUGH = 70  # bits of relative accuracy that a value of the closed form needs
_NODES = 22  # in a panel no longer than its distance to x = 0: they give 2^-110
_DEEPEST = 1200  # panels towards x = 0
_LAST, _COUNTED = 24, 12  # the coefficients by which a radius of convergence is judged
_FAR = 64.0  # a radius that is as good as infinite
_INSIDE = 0.25  # of the radius of convergence: a panel of that length from x = 0 is the innermost
_PLACES, _SHARES = (0.375, 2.2, 17.0), (0.2, 0.5, 0.8)  # r at which a closed form is checked; shares of its range
_SAME = 2.0**-40  # by which it agrees: the rule may not resolve a narrow transition to the last bit
_LONGEST = 0.5  # such a panel: there the other end of a weight is far enough away
_CLOSE, _STEEP = 2.0**-5, 8  # without a power series: the innermost panel, where p is this power of the variable
_SPLITS = (1, 2, 4, 8, 16, 32)  # parts of a panel that are tried, for profiles with a narrow transition
_PROBES = (*(k / 4 for k in range(-12, 8)), 4, 7)
"""Binary exponents of the r at which that is judged: a transition lies anywhere in the panels of one octave."""
_AGREED = 2.0**-62  # of two numbers of parts


class Values:
    """F(r) as a function of balls. Call it with the working precision `BITS`.

    Parameters
    ----------
    profile : sympy.Expr
        g in the symbol v, and in shapes.
    criterion : Criterion
    closed : sympy.Expr or None
        F in the symbol V.
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
        self._slopes = [ball_function(slope_of(piece), symbols.v, point) for piece in self._pieces]
        heights = [
            (ball_value(place, point).real, ball_value(height, point).real) for place, height in jumps(profile)
        ]
        self._jumps = [(place, height) for place, height in heights if bool(place > 0)]
        self._closed = closed
        self._formulas: dict[int, BallFunction | None] = {}
        self.radius = self._radius()
        self._inner, self._order = (min(_INSIDE * self.radius, _LONGEST), 2) if self.radius else (_CLOSE, _STEEP)
        self._split: int | None = None
        self.reach = reach_of(profile, point)
        if closed is not None and not self._agrees():
            self._closed = None

    def _agrees(self) -> bool:
        """Whether the closed form is the average by the Gauss rule too, at a few places."""
        places = _PLACES if self.reach == np.inf else [share * self.reach / 2 for share in _SHARES]
        with working_precision(BITS):
            for place in map(arb, places):
                value = self._by_formula(place)
                if value is not None and not bool(abs(value - self._by_rule(place)) <= _SAME * abs(value)):
                    return False
        return True

    @property
    def last_piece(self) -> Expr:
        """The profile beyond its last kink."""
        return self._pieces[-1]

    def _radius(self) -> float:
        """Return the radius of convergence of g' at x = 0, by the root test; 0 where it has no power series."""
        coefficients = self.taylor(_LAST + _COUNTED)
        if coefficients is None:
            return 0.0
        rate = max(float(abs(c).upper()) ** (1 / k) for k, c in enumerate(coefficients) if k >= _LAST)
        return min(1 / rate, _FAR) if rate else _FAR

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

    def __call__(self, r: arb) -> arb:
        """Return F(r)."""
        if self._closed is not None and (value := self._by_formula(r)) is not None:
            return value
        return self._by_rule(r)

    def _by_rule(self, r: arb) -> arb:
        if self.criterion.weight is None:
            return -self._slope(r)
        if self._split is None:
            self._split = self._parts()
        return self._averaged(r, self._split)

    def _by_formula(self, r: arb) -> arb | None:
        """Return the closed form's value, with more bits where it cancels; None where that does not help."""
        for bits in _PRECISIONS:
            with working_precision(bits):
                if bits not in self._formulas:
                    try:
                        self._formulas[bits] = ball_function(self._closed, symbols.V, self.point)
                    except InputError:  # a special function that has no balls; the rule has no need of it
                        self._formulas[bits] = None
                formula = self._formulas[bits]
                if formula is None:
                    return None
                try:
                    whole = formula(acb(r), False)
                except (ValueError, ZeroDivisionError):
                    continue
                value = whole.real
                if value.is_finite() and whole.imag.contains(0) and value.rel_accuracy_bits() >= _ENOUGH:
                    return value
        return None

    def _parts(self) -> int:
        """Return into how many parts each panel is cut."""
        probes = [arb(3).sqrt() * arb(2) ** k for k in _PROBES]
        if self.reach < np.inf:
            probes = [arb(share * self.reach / 2) for share in _SHARES]
        for split, finer in pairwise(_SPLITS):
            pairs = [(self._averaged(r, split), self._averaged(r, finer)) for r in probes]
            if all(abs(float(a.mid()) - float(b.mid())) <= 0 or abs(a - b) < _AGREED * abs(b) for a, b in pairs):
                return split
        return _SPLITS[-1]

    def _slope(self, x: arb) -> arb:
        piece = sum(1 for kink in self.kinks if bool(kink < x))
        return self._slopes[piece](acb(x), False).real

    def _averaged(self, r: arb, split: int) -> arb:
        total = arb(0)
        places = [kink / r for kink in self.kinks if bool(kink < 2 * r)]
        for piece, (low, high) in enumerate(pairwise([arb(0), *places, arb(2)])):
            slope = self._slopes[piece]
            for left, right in _panels(low, high, arb(self._inner) * min(1 / r, arb(1))):
                for p, weight in _nodes(self.criterion, left, right, split, self._order):
                    total += weight * slope(acb(r * p), False).real
        for place, height in self._jumps:
            if bool(place < 2 * r):
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


def _nodes(criterion: Criterion, left: arb, right: arb, split: int, order: int) -> list[tuple[arb, arb]]:
    """Return p = 1 + s and w(s) ds at the nodes of a panel."""
    ends = (tuple(int(part) for part in end.mid().man_exp()) for end in (left, right))
    return _rule(criterion, *ends, split, order)


def _weight(criterion: Criterion, p: arb, q: arb) -> arb:
    """Return w(s) for p = 1 + s and q = 1 - s."""
    if not criterion.is_polynomial:
        return 2 * (p * q).sqrt() / arb.pi()
    return _shifted(criterion)(p)


@lru_cache(maxsize=16)
def _shifted(criterion: Criterion) -> arb_poly:
    """Return a weight that is a polynomial in powers of p = 1 + s."""
    return arb_poly([arb(rational(c)) for c in reversed(criterion.from_rest.all_coeffs())])


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

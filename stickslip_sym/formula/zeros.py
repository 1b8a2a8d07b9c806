"""The belt speeds at which a criterion vanishes: by formula, or as numbers for typical parameters.

Numbers are isolated, so that a list is complete in the range that it states. A rational function has the zeros
of a polynomial, counted exactly. Of any other criterion the average F and V F' are bounded on cells of belt speeds
from V to q V: by balls around mu' and v mu'' on panels of slip speeds that grow by the factor q too, and the share
of the weight over each panel. A cell on which F has a sign holds no zero. A run of other cells on which V F' has a
sign holds one zero if F has opposite signs beside the run, and else none. Any other run is cut finer; what stays
is undecided.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp
from flint import acb, arb
from numpy.typing import NDArray
from scipy.optimize import brentq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.balls import BallFunction, ball, ball_function, ball_value, number_at
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.functions import without_squares
from stickslip_sym.core.precision import working_precision
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.model.expression.letters import with_numbers
from stickslip_sym.model.expression.pieces import branch_from, jumps, kinks_at

_LOWEST, _HIGHEST = -40, 40  # octaves of belt speed in m/s between which zeros are isolated
_CELLS = (8, 64, 512)  # in an octave: what is undecided in one of these is cut into the next
_FINEST = 4096  # of the slope at one speed, which needs no panels below
_DEPTH = 24  # octaves below 2 V on which panels are cut; all lower slip speeds are one
_MOST = 8  # zeros that are listed
_BITS = 64  # of the balls
_WEIGHT_BITS = 200  # of the shares of a weight, which are differences
_ROUNDING = 1e-11  # relative to the sum of sizes: more than the rounding of sums of 12,000 floats
_SPILL = 2.0**-46  # relative: more than the rounding of the ends of a panel
_ROOT = float(4 * np.finfo(np.float64).eps)

_Signs = NDArray[np.int64]
_Bounds = tuple[FloatArray, FloatArray]
"""The lower and the upper bounds of a function on cells or panels."""


@dataclass(frozen=True)
class Zeros:
    """The belt speeds at which a criterion vanishes: the transition speeds of the undamped oscillator.

    - `formula`: the only one, in terms of the parameters.
    - `values`: for the typical parameters, ascending; None where there are no such, or no values.
    - `between`: the belt speeds in m/s between which these are all; None where they are all there are.
    - `undecided`: pairs of belt speeds between which there may be others.
    """

    formula: Expr | None = None
    values: tuple[float, ...] | None = None
    everywhere: bool = False
    between: tuple[float, float] | None = None
    undecided: tuple[tuple[float, float], ...] = ()


def zeros(form: ClosedForm) -> Zeros:
    """Return the belt speeds at which a criterion vanishes, by formula or for the typical parameters."""
    if form.expr == 0:
        return Zeros(everywhere=True)
    if form.general is not None:
        vanishing = zeros(form.general)
        if vanishing.formula is not None:
            return replace(vanishing, formula=with_numbers(vanishing.formula, form.meanings))
        if vanishing.everywhere:
            return vanishing
        return _at_typical_values(form)
    numerator = sp.numer(sp.together(form.expr))
    if numerator.is_polynomial(symbols.V):
        match sp.Poly(sp.expand(numerator), symbols.V).terms():
            case [_]:
                return Zeros(values=())
            case [((power,), highest), ((0,), constant)]:
                speed = sp.factor(-constant / highest) ** sp.Rational(1, power)
                if speed.is_positive:
                    return Zeros(speed)
    return _at_typical_values(form)


def _at_typical_values(form: ClosedForm) -> Zeros:
    law = form.law.typical()
    if law.missing:
        return Zeros()
    point = law.point
    if (exactly := _of_rational_function(form.expr, point)) is not None:
        return exactly
    mu = sp.Add(*(term.expr for term in form.terms))
    # With V for v, which is positive where a slip speed may be 0.
    slope = without_squares(sp.diff(mu, symbols.v)).xreplace({**point, symbols.v: symbols.V})
    if not mu.has(sp.Piecewise) and _is_average(form.criterion) and (slope.is_positive or slope.is_negative):
        return Zeros(values=())
    return _isolated(form, mu, point)


def _is_average(criterion: Criterion) -> bool:
    """Whether the weight is negative nowhere."""
    if not criterion.is_polynomial:
        return True
    inside = [root for root in criterion.from_rest.real_roots() if 0 < root < 2]
    return all(inside.count(root) % 2 == 0 for root in inside)


def _of_rational_function(expr: Expr, point: Mapping[Expr, Expr]) -> Zeros | None:
    """Return all zeros of a rational function of V at rational values of its parameters; None for another one."""
    per_force = expr.xreplace({symbols.N: sp.S.One, **point})
    if not per_force.is_rational_function(symbols.V):
        return None
    polynomial = sp.Poly(sp.numer(sp.cancel(per_force)), symbols.V)
    if not all(c.is_Rational for c in polynomial.all_coeffs()):
        return None
    roots = (float(root) for root in polynomial.real_roots(multiple=False, radicals=False) for root in root[:1])
    return Zeros(values=tuple(root for root in roots if root > 0))


def _isolated(form: ClosedForm, mu: Expr, point: Mapping[Expr, Expr]) -> Zeros:
    """Return the zeros of a criterion of mu between the lowest and the highest belt speed looked at."""
    between, criterion = (2.0**_LOWEST, 2.0**_HIGHEST), form.criterion
    if not _is_average(criterion):
        return Zeros()
    average = _Average(mu, point, criterion)
    levels = _CELLS if criterion.weight is not None else (*_CELLS, _FINEST)
    runs = [(_LOWEST * _CELLS[0], _HIGHEST * _CELLS[0])]
    speeds: list[float] = []
    undecided: list[tuple[float, float]] = []
    for count, before in zip(levels, (_CELLS[0], *levels), strict=False):
        waiting: list[tuple[int, int]] = []
        for low, high in ((first * count // before, last * count // before) for first, last in runs):
            signs, rises = average.signs(low, high, count)
            for start, stop in _runs(signs == 0):
                # Beyond the range that was looked at there is no sign.
                left, right = (signs[start - 1] if start else 0), (signs[stop] if stop < signs.size else 0)
                monotone = bool(rises[start]) and bool((rises[start:stop] == rises[start]).all())
                ends = 2.0 ** ((low + start) / count), 2.0 ** ((low + stop) / count)
                root = _root(form, point, *ends) if monotone and left * right < 0 else None
                if root is not None:
                    speeds.append(root)
                elif monotone and left * right > 0:
                    continue
                elif count == levels[-1] or stop - start > count > _CELLS[0]:  # over an octave: not at one speed
                    undecided.append(ends)
                else:
                    waiting.append((max(low + start - 1, low), min(low + stop + 1, high)))
        last = sorted(speeds)[_MOST] if len(speeds) > _MOST else 2.0**_HIGHEST
        runs = [run for run in waiting if 2.0 ** (run[0] / count) < last]
    return _stated(sorted(speeds), *between, sorted(undecided))


def _stated(speeds: list[float], low: float, high: float, undecided: list[tuple[float, float]]) -> Zeros:
    """Return zeros between two belt speeds, but not those beyond many of them, nor what is open at either end."""
    if undecided and undecided[0][0] <= low:
        low = undecided.pop(0)[1]
    if undecided and undecided[-1][1] >= high:
        high = undecided.pop()[0]
    if len(speeds) > _MOST:
        high = (speeds[_MOST - 1] + speeds[_MOST]) / 2
        speeds, undecided = speeds[:_MOST], [ends for ends in undecided if ends[0] < high]
    return Zeros(values=tuple(speeds), between=(low, high), undecided=tuple(undecided)) if low < high else Zeros()


def _runs(chosen: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return where runs of True begin and end."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], chosen, [False])).astype(int)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def _root(form: ClosedForm, point: Mapping[Expr, Expr], low: float, high: float) -> float | None:
    """Return the only zero between two belt speeds; None where the function of floats has none there."""
    values: dict[str, Any] = {symbol.name: float(value) for symbol, value in point.items()}
    try:
        return float(brentq(lambda V: form(V=V, N=1.0, **values), low, high, xtol=1e-300, rtol=_ROOT))
    except (StickSlipError, ValueError):
        return None


class _Average:
    """Bounds of F(V) = -<mu'(V(1 + s))>_w, of no negative weight, and of V F'(V)."""

    def __init__(self, mu: Expr, point: Mapping[Expr, Expr], criterion: Criterion) -> None:
        self.criterion = criterion
        kinks = kinks_at(mu, point)
        starts = [sp.Integer(0), *kinks]
        pieces = [branch_from(mu, point, start) for start in starts]
        with working_precision(_BITS):
            self.starts = [ball(start).real for start in starts]
            slopes = [sp.diff(piece, symbols.v) for piece in pieces]
            curves = [symbols.v * sp.diff(slope, symbols.v) for slope in slopes]
            self.slopes, self.curves = (
                [ball_function(function, symbols.v, point) for function in functions]
                for functions in (slopes, curves)
            )
            self.gains = [
                ball_value(right - left, {**point, symbols.v: place}).real
                for (left, right), place in zip(pairwise(slopes), kinks, strict=True)
            ]
            jumping = [number_at(place, point) for place, _ in jumps(mu, point)]
            heights = [ball_value(height, point).real for _, height in jumps(mu, point)]
            self.heights = [dict(zip(jumping, heights, strict=True)).get(place) for place in kinks]

    def signs(self, low: int, high: int, count: int) -> tuple[_Signs, _Signs]:
        """Return the signs of F and of F' on the cells of V from 2^(low/count) to 2^(high/count); 0 if unsure."""
        with working_precision(_BITS), np.errstate(all="ignore"):
            value, change = (self._mean(part, low, high, count) for part in (self.slopes, self.curves))
            for i in range(high - low):
                belt = (2.0 ** ((low + i + k) / count) for k in (0, 1))
                for bounds, part in zip((value, change), self._of_kinks(*map(arb, belt)), strict=True):
                    lower, upper = _floats(acb(part))
                    bounds[0][i] += lower
                    bounds[1][i] += upper
            if (
                self.criterion.weight is None
            ):  # from the middle of a cell, which is sharp where two zeros are close
                middle = np.array([self._slope_at(2.0 ** ((k + 0.5) / count)) for k in range(low, high)])
                reach = np.maximum(*map(np.abs, change)) * (math.log(2) / count)  # twice what it takes
                value = np.maximum(value[0], middle[:, 0] - reach), np.minimum(value[1], middle[:, 1] + reach)
            sign, rise = (np.where(least > 0, -1, 0) + (most < 0) for least, most in (value, change))
        return sign, rise

    def _mean(self, functions: Sequence[BallFunction], low: int, high: int, count: int) -> _Bounds:
        """Bound the mean over the weight of a function of v, in pieces, at belt speeds in cells."""
        if self.criterion.weight is None:
            return self._on_panels(functions, 2.0 ** (np.arange(low, high + 1) / count))
        depth = _DEPTH * count
        first, shares = low + count - depth, _shares(self.criterion, count)
        edges = 2.0 ** (np.arange(first, high + count + 1) / count)
        least, most = self._on_panels(functions, np.concatenate(([0.0], edges)))
        # Below its panels a cell has one from 0, which is as wide as the lowest panels of the cells together.
        below = [np.minimum.accumulate(least), np.maximum.accumulate(most)]
        cells = high - low
        pairs = np.minimum(least[1:-1], least[2:]), np.maximum(most[1:-1], most[2:])
        lows, highs = (np.convolve(part, shares[:-1], "valid")[:cells] for part in pairs)
        rest = [part[1 : cells + 1] for part in below]
        lows, highs = (sums + shares[-1] * part for sums, part in zip((lows, highs), rest, strict=True))
        size = np.convolve(np.maximum(*map(np.abs, pairs)), shares[:-1], "valid")[:cells]
        size += shares[-1] * np.maximum(*map(np.abs, rest))
        return lows - _ROUNDING * size, highs + _ROUNDING * size

    def _on_panels(self, functions: Sequence[BallFunction], edges: FloatArray) -> _Bounds:
        """Bound a function of v in pieces between some speeds."""
        least, most = np.full(edges.size - 1, np.inf), np.full(edges.size - 1, -np.inf)
        ends = [*self.starts[1:], None]
        for i, (a, b) in enumerate(pairwise(edges)):
            low, high = arb(a) * (1 - _SPILL), arb(b) * (1 + _SPILL)
            for function, start, end in zip(functions, self.starts, ends, strict=True):
                if high < start or (end is not None and low > end):
                    continue
                left, right = low.max(start), high if end is None else high.min(end)
                lower, upper = _floats(function(acb(left.union(right)), False))
                least[i], most[i] = min(least[i], lower), max(most[i], upper)
        return least, most

    def _slope_at(self, speed: float) -> tuple[float, float]:
        """Bound mu' at one speed, by the piece that holds there unless a kink is close."""
        piece = sum(1 for start in self.starts[1:] if start < speed)
        return _floats(self.slopes[piece](acb(speed), False))

    def _of_kinks(self, left: arb, right: arb) -> tuple[arb, arb]:
        """Return what jumps of mu add to the mean of mu', and those of mu' to that of v mu'', on one cell."""
        value, change = arb(0), arb(0)
        for place, gain, height in zip(self.starts[1:], self.gains, self.heights, strict=True):
            p = (place / right).union(place / left)
            if self.criterion.weight is None:
                share = arb.nan() if p.contains(1) else arb(0)
            elif p > 2:
                share = arb(0)
            else:
                ends = {_P: acb(p.min(arb(2))), _Q: acb((2 - p).max(arb(0)))}
                share = p * ball_value(self.criterion.from_ends(_P, _Q), ends).real
            if height is None:
                change += gain * share
            elif not p > 2:
                value, change = value + height * share / place, arb.nan()
        return value, change


_P, _Q = sp.symbols("p q", cls=sp.Dummy)


def _floats(value: acb) -> tuple[float, float]:
    """Return floats with the real part of a ball between them."""
    if not value.is_finite():
        return -np.inf, np.inf
    ends = float(value.real.lower()), float(value.real.upper())
    return float(np.nextafter(ends[0], -np.inf)), float(np.nextafter(ends[1], np.inf))


@lru_cache(maxsize=16)
def _shares(criterion: Criterion, count: int) -> FloatArray:
    """Return the integrals of a weight over p = 1 + s, on panels from 2 down, and from 0 up to the last one."""
    with working_precision(_WEIGHT_BITS):
        ends = [arb(2.0 ** (1 - j / count)) for j in range(_DEPTH * count + 1)]
        if criterion.is_polynomial:
            primitive = ball_function(criterion.from_rest.integrate().as_expr(), symbols.s, {})
            below = [primitive(acb(p), False).real for p in ends]
        else:  # of (2/pi) sqrt(1 - s^2), by the angle at which p = 2 sin^2
            angles = [(p / 2).min(arb(1)).sqrt().asin() for p in ends]
            below = [(2 * angle - (4 * angle).sin() / 2) / arb.pi() for angle in angles]
        return np.array([*(float(a - b) for a, b in pairwise(below)), float(below[-1])])

"""`FrictionTable`: a friction law as data, polynomials on intervals.

A motion asks for mu thousands of times, and for nothing else of a law. So a law is sampled once: its rise
mu(v) - mu(0+) becomes a polynomial on each of a sequence of intervals, graded to rest and to wherever the law is
steep. The error is small relative to the rise itself, since on a slow belt the rise is all that moves the mass.
Smooth, kinked, jumping, measured and static laws need no case after that.

Near rest the polynomial is v g(v) with g through values of rise/v, so the rise keeps its digits down to v = 0; the
first interval is the widest on which that holds for every lower speed. From there on intervals are octaves, halved
until the last coefficients vanish.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
import sympy as sp
from flint import acb, arb
from numpy.polynomial import chebyshev

from stickslip_sym.core import balls, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.at_rest import Rising
from stickslip_sym.model.expression.pieces import branch_from
from stickslip_sym.model.law import FrictionLaw

__all__ = ["FARTHEST", "FrictionTable", "Pieces", "Rise"]

FARTHEST = 1e20
"""The slip speed in m/s at which a table ends at the latest: a motion that comes so far grows without bound."""

_DEGREE = 14  # 15 nodes resolve about an octave of an analytic law to rounding
_LOWEST = 1e-40  # m/s; a law that is singular at rest, as sqrt(v), is a straight line below
_TAIL = 1e-15  # of the last two Chebyshev coefficients, relative to the largest value: what they leave out is less
_OFF = 5e-15  # of the first polynomial, relative to the rise at any lower speed
_NOISE = 4e-15  # of mu, by which a rise may be off where it had to be computed as a difference
_VANISHES = 4e-16  # of the largest coefficient at rest: where mu has no slope at 0, rounding is none either
_MOST = 10_000  # intervals
_RESOLVED = 4  # halvings, after which what is left may be noise of a rise computed as a difference
_NARROWEST = 1e-13  # relative width of an interval that is not halved again
_POLE = 1e6  # a coefficient on the narrowest interval as high as that is a pole's
_ROUNDING = 1e-12  # of mu: where two segments meet and differ by less there is no jump
_CHECKS, _BITS = 3, 400  # speeds in an interval that are held against enclosures, and the precision of these
_SPEEDS = 64  # belt speeds for which a table is kept

_POWERS = np.arange(_DEGREE + 1)
_NODES = -np.cos(np.pi * (_POWERS + 0.5) / (_DEGREE + 1))  # Chebyshev's, ascending
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, _DEGREE)).T
_MONOMIALS = np.array([np.pad(chebyshev.cheb2poly(row), (0, _DEGREE - k)) for k, row in enumerate(np.eye(15))])

"""mu(v) - mu(0+) at an array of slip speeds, NaN where mu has no value."""


Pieces = list[tuple[float, ...]] | FloatArray
"""The polynomials of a rise, a row for each interval: where it begins, then origin and scale of
t = (w - origin) scale, and the coefficients of the powers of t. For plain Python they are tuples, for compiled
code an array."""


class Rise(NamedTuple):
    """A rise as a function of w = v/V.

    - `pieces`: the polynomials.
    - `levels`: w at which each smooth segment of the law begins, the first 0, and after the last where the table
      ends.
    - `firsts`: number of the first interval of each segment, and after the last how many intervals there are.
    - `jumps`: by how much mu rises at the beginning of each segment; 0 at a kink without jump.
    - `steepest`: the largest slope to either side at the ends of intervals.
    """

    pieces: Pieces
    levels: list[float] | FloatArray
    firsts: list[int] | FloatArray
    jumps: list[float] | FloatArray
    steepest: float


@dataclass(frozen=True, eq=False)
class FrictionTable:
    """The rise mu(v) - mu(0+) of a law with all parameters bound, as polynomials on intervals.

    Attributes
    ----------
    onset : float
        mu(0+).
    static : float
        The coefficient that limits sticking, at least `onset`.
    kinks : tuple of float
        Slip speeds in m/s, above 0, at which mu or its slope may jump.
    reach : float
        The slip speed in m/s up to which the law was measured; infinite for a formula.
    end : float
        The slip speed in m/s up to which mu is known and has a finite value, at most `FARTHEST`.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> law = laws.exponential.typical()
    >>> table = FrictionTable.of(law)
    >>> abs(table.rise(0.5) - (law.mu(0.5) - law.mu(0.0))) < 1e-15
    True
    """

    onset: float
    static: float
    kinks: tuple[float, ...]
    reach: float
    end: float
    low: FloatArray = field(repr=False)
    origin: FloatArray = field(repr=False)
    scale: FloatArray = field(repr=False)
    rows: FloatArray = field(repr=False)
    firsts: tuple[int, ...] = field(repr=False)
    _kept: dict[tuple[float, bool], Rise] = field(default_factory=dict, repr=False)

    @staticmethod
    def of(law: FrictionLaw, upto: float | None = None) -> "FrictionTable":
        """Return the table of a law, made once for equal laws.

        - `upto`: for a derivative of a law by a parameter, the slip speed in m/s at which its table may end; a
          derivative may be known by differences only, and is tabulated relative to its largest value.

        Raises
        ------
        InputError
            If a parameter has no value, mu(0+) or mu beside it is not finite, or the static coefficient is below
            mu(0+).
        """
        return _table(law, upto)

    def deviation(self, law: FrictionLaw, low: float, high: float) -> float:
        """Return by how much the table is off, as enclosures of the law's rise in ball arithmetic show.

        Compared are `_CHECKS` speeds in each interval between two speeds in m/s. A deviation is relative to the
        largest rise up to its speed, so to the rise itself where that is monotone.

        Raises
        ------
        InputError
            For a law with a function that has no enclosure.
        """
        ends = np.append(self.low, self.end)
        segments = [sp.Integer(0), *law.kinks()]
        places = np.arange(1, 2 * _CHECKS, 2) / (2 * _CHECKS)
        worst, highest = 0.0, arb(0)
        with balls.working_precision(_BITS):
            lowest = balls.ball_function(branch_from(law.expr, law.point, segments[0]), symbols.v, law.point)
            start = lowest(acb(arb(2) ** -_BITS), False).real  # as good as the limit, where that is 0/0
            for segment, begin in enumerate(segments[: len(self.firsts) - 1]):
                mu = balls.ball_function(branch_from(law.expr, law.point, begin), symbols.v, law.point)
                for i in range(self.firsts[segment], self.firsts[segment + 1]):
                    if ends[i + 1] <= low or ends[i] >= high:
                        continue
                    for v in (ends[i] + (ends[i + 1] - ends[i]) * places).tolist():
                        exact = mu(acb(arb(v)), False).real - start
                        highest = max(highest, exact.abs_lower())
                        off = (exact - arb(self.rise(v))).abs_upper()
                        worst = max(worst, float(off / highest) if highest > 0 else float(off))
        return worst

    def rise(self, v: float) -> float:
        """Return mu(v) - mu(0+) at a slip speed in m/s within the table."""
        i = bisect_right(self.low, v) - 1
        return float(np.polyval(self.rows[i, ::-1], (v - self.origin[i]) * self.scale[i]))

    def slope(self, v: float) -> float:
        """Return dmu/dv in s/m at a slip speed in m/s within the table."""
        i = bisect_right(self.low, v) - 1
        derivative = np.polyder(self.rows[i, ::-1])
        return float(np.polyval(derivative, (v - self.origin[i]) * self.scale[i]) * self.scale[i])

    def at(self, V: float, *, arrays: bool = False) -> Rise:
        """Return the rise as a function of w = v/V, as lists for plain Python or as arrays for compiled code."""
        key = V, arrays
        if key not in self._kept:
            if len(self._kept) >= _SPEEDS:
                self._kept.clear()
            self._kept[key] = self._in_units(V, arrays)
        return self._kept[key]

    def _in_units(self, V: float, arrays: bool) -> Rise:
        pieces = np.column_stack((self.low / V, self.origin / V, self.scale * V, self.rows))
        levels = np.array([0.0, *self.kinks, self.end]) / V
        firsts = np.array(self.firsts)
        with np.errstate(over="ignore"):  # of a law that grows up to the largest number
            jumps = self._jumps()
            steepest = float(max(np.abs(slopes).max() for slopes in self._at_ends(derivative=True))) * V
        if arrays:
            return Rise(pieces, levels, firsts, jumps, steepest)
        return Rise(
            [tuple(row) for row in pieces.tolist()], levels.tolist(), firsts.tolist(), jumps.tolist(), steepest
        )

    def _at_ends(self, *, derivative: bool) -> list[FloatArray]:
        """Return the rises, or slopes, of all polynomials at the lower and the upper ends of their intervals."""
        found = []
        for v in (self.low, np.append(self.low[1:], self.end)):
            t = ((v - self.origin) * self.scale)[:, None]
            if derivative:
                found.append((_POWERS[1:] * t ** _POWERS[:-1] * self.rows[:, 1:]).sum(axis=1) * self.scale)
            else:
                found.append((t**_POWERS * self.rows).sum(axis=1))
        return found

    def _jumps(self) -> FloatArray:
        """Return by how much mu rises where each segment begins."""
        after, before = self._at_ends(derivative=False)
        places = np.array(self.firsts[1:-1], dtype=np.intp)
        below, above = before[places - 1], after[places]
        level = _ROUNDING * np.maximum(np.abs(self.onset + below), np.abs(self.onset + above))
        jumps: FloatArray = np.append(0.0, np.where(np.abs(above - below) > level, above - below, 0.0))
        return jumps


@lru_cache(maxsize=256)
def _table(law: FrictionLaw, upto: float | None) -> FrictionTable:
    onset, static = law.onset, law.static_value
    reach = math.inf if law.v_max is None else float(law.v_max)
    farthest = FARTHEST if upto is None else upto
    segments = [(start, rising) for start, rising in law.rises() if start < farthest]
    starts = [start for start, _ in segments]
    ends = [*starts[1:], min(reach, farthest)]
    parts, kinks, firsts, end = [], [], [0], 0.0
    with np.errstate(all="ignore"):
        for (start, rising), high in zip(segments, ends, strict=True):
            part, end = _segment(rising, onset, start, high, upto is not None)
            if part:
                parts += part
                firsts.append(len(parts))
                kinks.append(start)
            if end < high:
                break
    low, origin, scale = (np.array([part[i] for part in parts]) for i in range(3))
    rows = np.array([part[3] for part in parts])
    return FrictionTable(onset, static, tuple(kinks[1:]), reach, end, low, origin, scale, rows, tuple(firsts))


_Interval: TypeAlias = tuple[float, float, float, FloatArray]  # its begin, origin, scale and coefficients


def _segment(
    rising: Rising, onset: float, start: float, high: float, derivative: bool
) -> tuple[list[_Interval], float]:
    """Return the intervals of a smooth segment of a law, and the speed up to which it has finite values."""
    intervals, begin = ([], start) if start else _first(rising, onset, high)
    if begin >= high:
        return intervals, high
    octaves = max(1, math.ceil(math.log2(high / begin))) if begin else 1
    edges = begin * 2.0 ** np.arange(octaves + 1)
    edges[-1] = high
    low, upper = edges[:-1], edges[1:]
    found: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    halvings = 0
    while low.size:
        if low.size > _MOST:
            raise NotConverged(
                f"mu is too rough to be tabulated between v = {low.min():.6g} and {upper.max():.6g} m/s: "
                f"{low.size} polynomials of degree {_DEGREE} do not follow it; try a law that varies less"
            )
        coefficients, values = _chebyshev(rising, low, upper)
        scale = np.abs(values).max(axis=1)
        finite = np.isfinite(scale)
        narrow = upper - low <= _NARROWEST * upper
        # A speed is rounded, which shows where mu is steep.
        level = _TAIL * (scale + np.ptp(values, axis=1) * upper / (upper - low))
        level += _NOISE * (scale + abs(onset)) if halvings >= _RESOLVED else 0.0
        if not halvings:
            largest = np.nanmax(np.append(0.0, scale))
        level += _NOISE * largest if derivative else 0.0
        fits = finite & (np.abs(coefficients[:, -2:]).max(axis=1) <= level)
        fits |= finite & narrow & (scale < _POLE * (1 + abs(onset)))
        lost = ~fits & (narrow | ~np.isfinite(values).any(axis=1))
        if lost.any():
            high = min(high, float(low[lost].min()))
        found.append((low[fits], upper[fits], coefficients[fits]))
        halved = ~fits & ~lost & (low < high)
        middle = (low[halved] + upper[halved]) / 2
        low, upper = np.concatenate((low[halved], middle)), np.concatenate((middle, upper[halved]))
        halvings += 1
    low, upper, coefficients = (np.concatenate(columns) for columns in zip(*found, strict=True))
    order = np.argsort(low)
    order = order[low[order] < high]
    low, upper, rows = low[order], upper[order], coefficients[order] @ _MONOMIALS
    intervals += zip(low.tolist(), ((low + upper) / 2).tolist(), (2 / (upper - low)).tolist(), rows, strict=True)
    return intervals, high


def _chebyshev(rising: Rising, low: FloatArray, high: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the Chebyshev coefficients of a rise on each interval, and its values at the nodes."""
    nodes = ((low + high)[:, None] + (high - low)[:, None] * _NODES) / 2
    values = rising(nodes)
    return values @ _COEFFICIENTS, values


def _first(rising: Rising, onset: float, high: float) -> tuple[list[_Interval], float]:
    """Return the interval at rest, where the rise is v g(v), and where it ends."""
    widths = high * 2.0 ** -np.arange(max(1.0, math.floor(math.log2(high / _LOWEST))))[::-1]
    nodes = widths[:, None] * (1 + _NODES) / 2
    values = rising(nodes)
    if not np.isfinite(values[0]).any():
        raise InputError(
            f"mu is not a finite real number at v = {nodes[0, 0]:.1e} m/s: no slip begins there; check the law's "
            "formula and the values of its parameters"
        )
    coefficients = (values / nodes) @ _COEFFICIENTS
    largest = np.abs(values / nodes).max(axis=1)
    fits = np.abs(coefficients[:, -2:]).max(axis=1) <= _TAIL * largest
    for noise in (0.0, _NOISE * abs(onset)):  # a rise that had to be computed as a difference has it
        for i in np.flatnonzero(fits)[::-1]:
            below, there = nodes[: i + 1], values[: i + 1]
            fitted = below * chebyshev.chebval(2 * below / widths[i] - 1, coefficients[i])
            if (np.abs(fitted - there) <= _OFF * np.abs(there) + noise).all():
                return [_at_rest(widths[i], coefficients[i])], float(widths[i])
    straight = np.append(float(values[0, -1] / nodes[0, -1]), np.zeros(_DEGREE))
    return [_at_rest(widths[0], straight)], float(widths[0])


def _at_rest(width: float, coefficients: FloatArray) -> _Interval:
    """Return the interval from 0 on with v g(v) in powers of t = v/width, g of degree one less."""
    # In powers of 2 t - 1 first, then of t, without the last coefficient, which is rounding.
    known = np.where(np.abs(coefficients[:-1]) > _VANISHES * np.abs(coefficients).max(), coefficients[:-1], 0.0)
    slope = np.polynomial.Polynomial(chebyshev.cheb2poly(known))(np.polynomial.Polynomial([-1, 2]))
    row = np.zeros(_DEGREE + 1)
    row[1 : slope.coef.size + 1] = np.asarray(slope.coef, dtype=np.float64) * width
    row[np.abs(row) <= _VANISHES * np.abs(row).max()] = 0.0
    return 0.0, 0.0, 1 / float(width), row

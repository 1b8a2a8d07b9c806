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
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import count
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import SAME
from stickslip_sym.model.at_rest import Rising
from stickslip_sym.model.law import FrictionLaw

FARTHEST = 1e20
"""The slip speed in m/s at which a table ends at the latest: a motion that comes so far grows without bound."""

_DEGREE = 14  # 15 nodes resolve about an octave of an analytic law to rounding
_LOWEST = 1e-40  # m/s; a law that is singular at rest, as sqrt(v), is a straight line below
_TAIL = 1e-15  # of the last two Chebyshev coefficients, relative to the largest value: what they leave out is less
_NOISE = 4e-15  # relative error of the first polynomial, and of mu where a rise had to be computed as a difference
_VANISHES = 4e-16  # of the largest coefficient at rest: where mu has no slope at 0, rounding is none either
_MOST = 10_000  # intervals
_RESOLVED = 4  # halvings, after which what is left may be noise of a rise computed as a difference
_NARROWEST = 1e-13  # relative width of an interval that is not halved again
_POLE = 1e6  # a coefficient on the narrowest interval as high as that is a pole's

_POWERS = np.arange(_DEGREE + 1)
_NODES = -np.cos(np.pi * (_POWERS + 0.5) / (_DEGREE + 1))  # Chebyshev's, ascending
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, _DEGREE)).T
_MONOMIALS = np.array([np.pad(chebyshev.cheb2poly(row), (0, _DEGREE - k)) for k, row in enumerate(np.eye(15))])

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
    """

    pieces: Pieces
    levels: list[float] | FloatArray
    firsts: list[int] | FloatArray
    jumps: list[float] | FloatArray


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
    pieces, firsts
        As for a `Rise`, with speeds in m/s.

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
    pieces: FloatArray = field(repr=False)
    firsts: tuple[int, ...] = field(repr=False)

    @staticmethod
    @lru_cache(maxsize=256)
    def of(law: FrictionLaw, upto: float | None = None) -> "FrictionTable":
        """Return the table of a law, made once for equal laws.

        - `upto`: for a derivative of a law by a parameter, the slip speed in m/s at which its table may end; a
          derivative may be known by differences only, and is tabulated relative to its largest value.

        Raises `InputError` if a parameter has no value, mu(0+) or mu beside it is not finite, or the static
          coefficient is below mu(0+).
        """
        onset, static = law.onset, law.static_value
        reach = math.inf if law.v_max is None else float(law.v_max)
        farthest = FARTHEST if upto is None else upto
        segments = [(start, rising) for start, rising in law.rises() if start < farthest]
        ends = [*(start for start, _ in segments[1:]), min(reach, farthest)]
        parts, kinks, firsts, end = list[FloatArray](), list[float](), [0], 0.0
        with np.errstate(all="ignore"):
            for (start, rising), high in zip(segments, ends, strict=True):
                part, end = _segment(rising, onset, start, high, upto is not None)
                if len(part):
                    parts.append(part)
                    firsts.append(firsts[-1] + len(part))
                    kinks.append(start)
                if end < high:
                    break
        return FrictionTable(onset, static, tuple(kinks[1:]), reach, end, np.concatenate(parts), tuple(firsts))

    def rise(self, v: float) -> float:
        """Return mu(v) - mu(0+) at a slip speed in m/s within the table."""
        return float(self.values(np.array([v]))[0])

    def values(self, v: FloatArray, *, derivative: bool = False) -> FloatArray:
        """Return the rise, or the slope of mu, at an array of slip speeds in m/s within the table."""
        return _values(self.pieces[np.searchsorted(self.pieces[:, 0], v, side="right") - 1], v, derivative)

    @lru_cache(maxsize=64)  # noqa: B019  # few tables live as long
    def at(self, V: float, *, arrays: bool = False) -> Rise:
        """Return the rise as a function of w = v/V, as lists for plain Python or as arrays for compiled code."""
        pieces = self.pieces / np.array([V, V, 1 / V, *np.ones(_DEGREE + 1)])
        levels = np.array([0.0, *self.kinks, self.end]) / V
        if arrays:
            return Rise(pieces, levels, np.array(self.firsts), self.jumps)
        return Rise(list(map(tuple, pieces.tolist())), levels.tolist(), list(self.firsts), self.jumps.tolist())

    @cached_property
    def jumps(self) -> FloatArray:
        """By how much mu rises where each segment begins."""
        jumps = [0.0]
        for kink, i in zip(self.kinks, self.firsts[1:], strict=False):
            below, above = self.onset + _values(self.pieces[i - 1 : i + 1], np.array([kink, kink]), False)
            jumps.append(above - below if abs(above - below) > SAME * max(abs(above), abs(below)) else 0.0)
        return np.array(jumps)


def _values(pieces: FloatArray, v: FloatArray, derivative: bool) -> FloatArray:
    """Return polynomials, or their slopes, each at a speed."""
    t, value = (v - pieces[..., 1]) * pieces[..., 2], np.zeros_like(v)
    for k in range(_DEGREE, -1 + derivative, -1):
        value = value * t + pieces[..., k + 3] * (k if derivative else 1)
    return value * pieces[..., 2] if derivative else value


def _segment(
    rising: Rising, onset: float, start: float, high: float, derivative: bool
) -> tuple[FloatArray, float]:
    """Return the pieces of a smooth segment of a law, and the speed up to which it has finite values."""
    rest, begin = (np.empty((0, 3 + _DEGREE + 1)), start) if start else _first(rising, onset, high)
    if begin >= high:
        return rest, high
    edges = begin * 2.0 ** np.arange(max(1, math.ceil(math.log2(high / begin))) + 1)
    edges[-1] = high
    low, upper = edges[:-1], edges[1:]
    found = list[FloatArray]()
    for halvings in count():
        if not low.size:
            break
        if low.size > _MOST:
            raise NotConverged(
                f"mu is too rough to be tabulated between v = {low.min():.6g} and {upper.max():.6g} m/s: "
                f"{low.size} polynomials of degree {_DEGREE} do not follow it; try a law that varies less"
            )
        values = rising(((low + upper)[:, None] + (upper - low)[:, None] * _NODES) / 2)
        coefficients = values @ _COEFFICIENTS
        scale = np.abs(values).max(axis=1)
        narrow = upper - low <= _NARROWEST * upper
        # A speed is rounded, which shows where mu is steep.
        level = _TAIL * (scale + np.ptp(values, axis=1) * upper / (upper - low))
        level += _NOISE * (scale + abs(onset)) if halvings >= _RESOLVED else 0.0
        if not halvings:
            largest = np.nanmax(np.append(0.0, scale))
        level += _NOISE * largest if derivative else 0.0
        fits = np.abs(coefficients[:, -2:]).max(axis=1) <= level
        fits = np.isfinite(scale) & (fits | (narrow & (scale < _POLE * (1 + abs(onset)))))
        lost = ~fits & (narrow | ~np.isfinite(values).any(axis=1))
        high = float(low[lost].min(initial=high))
        columns = low, (low + upper) / 2, 2 / (upper - low), coefficients @ _MONOMIALS
        found.append(np.column_stack(columns)[fits])
        halved = ~fits & ~lost & (low < high)
        middle = (low[halved] + upper[halved]) / 2
        low, upper = np.concatenate((low[halved], middle)), np.concatenate((middle, upper[halved]))
    pieces = np.concatenate(found)
    pieces = pieces[np.argsort(pieces[:, 0])]
    return np.concatenate((rest, pieces[pieces[:, 0] < high])), high


def _first(rising: Rising, onset: float, high: float) -> tuple[FloatArray, float]:
    """Return the piece at rest, where the rise is v g(v), as wide as it fits, and where it ends."""
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
            if (np.abs(fitted - there) <= _NOISE * np.abs(there) + noise).all():
                return _at_rest(widths[i], coefficients[i]), float(widths[i])
    straight = np.append(values[0, -1] / nodes[0, -1], np.zeros(_DEGREE))
    return _at_rest(widths[0], straight), float(widths[0])


def _at_rest(width: float, coefficients: FloatArray) -> FloatArray:
    """Return the piece from 0 on with v g(v) in powers of t = v/width, g of degree one less."""
    # In powers of 2 t - 1 first, then of t, without the last coefficient, which is rounding.
    known = np.where(np.abs(coefficients[:-1]) > _VANISHES * np.abs(coefficients).max(), coefficients[:-1], 0.0)
    slope = np.polynomial.Polynomial(chebyshev.cheb2poly(known))(np.polynomial.Polynomial([-1, 2])).coef
    row = np.zeros(_DEGREE + 1)
    row[1 : slope.size + 1] = np.asarray(slope, dtype=np.float64) * width
    row[np.abs(row) <= _VANISHES * np.abs(row).max()] = 0.0
    return np.array([[0.0, 0.0, 1 / width, *row]])

"""`FrictionTable`: a friction law as data, polynomials on intervals.

A motion asks for mu thousands of times, and for nothing else of a law. So a law is sampled once: its rise
mu(v) - mu(0+) becomes a polynomial on each of a sequence of intervals, graded to rest and to wherever the law is
steep. The error is small relative to the rise itself, since on a slow belt the rise is all that moves the mass.
Smooth, kinked, jumping, measured and static laws need no case after that.

Near rest the polynomial is v g(v) with g through values of rise/v, so the rise keeps its digits down to v = 0; the
first interval is the widest on which that holds for every lower speed. From there on intervals are octaves, halved
until the last coefficients vanish.

What lies between samples is not left to them. Intervals are parted at the places at which a formula varies quickly
(`transitions`) down to their widths, and one is accepted only if balls around mu' over it hold no slope that is
several times as steep as its polynomial's. Measured laws are polynomials already. The tables of derivatives by a
parameter rest on samples and transitions, and the part of the first interval far below its end on samples, which
are dense in octaves there.

A table ends where mu varies too often, as a sine does for ever: a motion that comes there is refused.
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import sympy as sp
from flint import acb, arb
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, IntArray, Substitution
from stickslip_sym.core.balls import BallFunction, ball_function
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import DOUBLE_BITS, EPSILON, LARGEST, LEAST_RTOL, SAME
from stickslip_sym.core.precision import working_precision
from stickslip_sym.core.remedies import Argument, Remedy
from stickslip_sym.model.at_rest import Rising
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.expression.transitions import transitions
from stickslip_sym.model.taylor_model import balls_from_rest
from stickslip_sym.numerics.chebyshev import grid, polynomial_values, tail
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.numerics.subdivide import (
    CROWDED,
    HALVE,
    Accept,
    Decision,
    DivisionLimits,
    Interval,
    ends,
    shown,
    subdivide,
)

FARTHEST = 1e20
"""The slip speed in m/s at which a table ends at the latest: a motion that comes so far grows without bound."""

RISE_RTOL = LEAST_RTOL
"""The relative error of a rise in its table."""
TABLE_DEGREE = 14  # 15 nodes resolve about an octave of an analytic law to rounding
_LOWEST = 1 / FARTHEST**2  # m/s; a law that is singular at rest, as sqrt(v), is a straight line below
_TAIL_SIZE = 1e-15
"""Of the last two Chebyshev coefficients, relative to the largest value: what they leave out is less."""
_RISE_NOISE = 4 * _TAIL_SIZE  # relative error of the first polynomial, and of mu where a rise is a difference
_VANISHES = 2 * EPSILON  # of the largest coefficient at rest: where mu has no slope at 0, rounding is none either
_INTERVALS_AN_OCTAVE = 512
"""Intervals within an octave: a table ends where there would be more; as many are looked at at a time."""
_HALVINGS_TO_NOISE = 4  # halvings, after which what is left may be noise of a rise computed as a difference
_POLE = 1 / math.sqrt(LEAST_RTOL)  # a coefficient on the narrowest interval as high as that is a pole's
_TRANSITION_WIDTHS = 2.0  # widths of a transition, and distances from it, an interval is wide at most
_NARROW_OVER_SPEED = 0.125  # times its own speed: an octave halved that often may hide from a grid of phases
_LEAP = 1 / 32  # times its own speed: the stages of the longest steps meet whatever is wider
_GRADUAL_WIDTH = 0.05  # over V, of each piece of the table of a law that varies gradually
STEEPER = 4.0  # times the steepest slope of a polynomial: balls are larger than what they hold
AT_ONCE = SAME**2
"""Times V: slip comes to that speed within 1e-12/omega, in which nothing happens."""
_CUTS = 3  # halvings of the ball over an interval, to bring it closer to what it holds
_RISE_OF_NO_ACCOUNT = RISE_RTOL / _TAIL_SIZE  # times the level of the last coefficients, however steep
_BALL_BITS = DOUBLE_BITS + round(-math.log2(_LOWEST))  # 1 - exp(-v) has digits down to there

_CHEBYSHEV_GRID = grid(TABLE_DEGREE + 1)
_AT_REST = np.array(
    [
        np.pad(Polynomial(np.trim_zeros(row, "b"))(Polynomial([-1.0, 2.0])).coef, (0, TABLE_DEGREE - 1 - k))
        for k, row in enumerate(grid(TABLE_DEGREE).powers)
    ]
)  # from Chebyshev's polynomials of 2 t - 1 to powers of t

Pieces = list[tuple[float, ...]] | FloatArray
"""The polynomials of a rise, a row for each interval: where it begins, then origin and scale of
t = (w - origin) scale, and the coefficients of the powers of t. For plain Python they are tuples, for compiled
code an array."""


class Rise(NamedTuple):
    """A rise as a function of w = v/V.

    - `pieces`: the polynomials.
    - `levels`: w at which each segment of the law begins, the first 0, and after the last where the table ends;
      a segment is smooth, and ends too where pieces become much narrower, or wider again.
    - `firsts`: number of the first interval of each segment, and after the last how many intervals there are.
    - `jumps`: by how much mu rises at the beginning of each segment; 0 at a kink without jump.
    - `gradual`: whether there is one segment, without a piece so narrow that long steps may miss what it holds.
    """

    pieces: Pieces
    levels: list[float] | FloatArray
    firsts: list[int] | FloatArray
    jumps: list[float] | FloatArray
    gradual: bool


class Smooth(NamedTuple):
    """A smooth segment of a law, which continues smoothly beyond its ends.

    - `start`: slip speed in m/s.
    - `rising`: mu(v) - mu(0+) on it.
    - `formula`: mu on it; None where it is a polynomial.
    """

    start: float
    rising: Rising
    formula: Expr | None


@dataclass(frozen=True, eq=False)
class FrictionTable:
    """The rise mu(v) - mu(0+) of a law, as polynomials on intervals.

    Attributes
    ----------
    onset : float
        mu(0+).
    static : float
        The coefficient that limits sticking, at least `onset`.
    kinks : tuple of float
        Slip speeds in m/s, above 0, at which mu or its slope may jump.
    reach : float
        The slip speed in m/s up to which the law was measured, or varies seldom enough for the table; infinite
        for any other formula.
    end : float
        The slip speed in m/s up to which mu is known and has a finite value, at most `FARTHEST`.
    is_rough : bool
        Whether it is from `reach` on that the law varies too often.
    pieces, firsts
        As for a `Rise`, with speeds in m/s.

    Examples
    --------
    >>> from stickslip_sym import laws
    >>> law = laws.exponential.typical()
    >>> table = law.bound.table
    >>> abs(table.rise(0.5) - (law.mu(0.5) - law.mu(0.0))) < 1e-15
    True
    """

    onset: float
    static: float
    kinks: tuple[float, ...]
    reach: float
    end: float
    is_rough: bool
    pieces: FloatArray = field(repr=False)
    firsts: tuple[int, ...] = field(repr=False)

    @staticmethod
    def of(
        segments: Sequence[Smooth],
        point: Substitution,
        onset: float,
        reach: float,
        upto: float | None = None,
    ) -> "FrictionTable":
        """Return the table of a law without a static coefficient above mu(0+).

        - `segments`: ascending from 0.
        - `point`: the values of the parameters in their formulas.
        - `upto`: for a derivative of a law by a parameter, the slip speed in m/s at which its table may end; a
          derivative may be known by differences only, and is tabulated relative to its largest value.

        Raises `InputError` if mu beside rest is not finite.
        """
        farthest = FARTHEST if upto is None else upto
        segments = [segment for segment in segments if segment.start < farthest]
        ends = [*(segment.start for segment in segments[1:]), min(reach, farthest)]
        parts = list[FloatArray]()
        kinks = list[float]()
        firsts = [0]
        end = 0.0
        with np.errstate(all="ignore"), working_precision(_BALL_BITS):
            for (start, rising, formula), high in zip(segments, ends, strict=True):
                segment = _Segment(rising, onset, start, high, upto is not None)
                if formula is not None:
                    segment.read(formula, point)
                part, end = segment.tabulated()
                if len(part):
                    parts.append(part)
                    firsts.append(firsts[-1] + len(part))
                    kinks.append(start)
                if segment.is_rough:
                    if upto is not None or not parts:
                        raise NotConverged(_ROUGH.format(f"{end:.6g} m/s"))
                    reach = end
                if end < high:
                    break
        return FrictionTable(
            onset, onset, tuple(kinks[1:]), reach, end, segment.is_rough, np.concatenate(parts), tuple(firsts)
        )

    def limit(self, speed: str) -> tuple[str | Remedy, ...]:
        """Return what ends at `reach`, and what to try, as parts of a message; `speed` is that in words."""
        if self.is_rough:
            return (_ROUGH.format(speed),)
        held = Argument("extrapolate", True)
        return f"the law is measured up to {speed}; measure further, or hold the last coefficient: ", held

    def rise(self, v: float) -> float:
        """Return mu(v) - mu(0+) at a slip speed in m/s within the table."""
        return float(self.values(np.array([v]))[0])

    def values(self, v: FloatArray, *, derivative: bool = False) -> FloatArray:
        """Return the rise, or the slope of mu, at an array of slip speeds in m/s within the table."""
        return _values_at(self.pieces[np.searchsorted(self.pieces[:, 0], v, side="right") - 1], v, derivative)

    @cached_property
    def narrow(self) -> FloatArray:
        """Ends of the pieces that are narrow beside their own speed, where mu varies quickly; a row each."""
        low = self.pieces[:, 0]
        high = np.append(self.pieces[1:, 0], self.end)
        return np.column_stack([low, high])[high - low < _NARROW_OVER_SPEED * low]

    def resolved(self, low: ArrayLike, high: ArrayLike, phases: ArrayLike) -> BoolArray:
        """Whether harmonic motions between slip speeds meet every narrow piece at some of their phases.

        - `phases`: of half a period.
        """
        low, high, phases = (
            np.asarray(of, np.float64)[..., None] for of in np.broadcast_arrays(low, high, phases)
        )
        if not self.narrow.size:
            return high[..., 0] <= self.end
        shares = (self.narrow.T - low[..., None]) / (high - low)[..., None]
        begin, end = np.moveaxis(2 * np.arcsin(np.sqrt(np.clip(shares, 0.0, 1.0))), -2, 0)
        missed: BoolArray = (begin < end) & (end - begin < np.pi / phases)
        return ~missed.any(axis=-1) & (high[..., 0] <= self.end)

    @lru_cache  # noqa: B019  # few tables live as long
    def at(self, V: float, *, arrays: bool = False) -> Rise:
        """Return the rise as a function of w = v/V, as lists for plain Python or as arrays for compiled code."""
        pieces = self.pieces / np.array([V, V, 1 / V, *np.ones(TABLE_DEGREE + 1)])
        landings = self._landings
        landings = landings[self.pieces[landings, 0] > AT_ONCE * V]
        firsts = np.unique(np.concatenate([self.firsts, landings]))
        levels = np.append(self.pieces[firsts[:-1], 0], self.end) / V
        jumps = np.zeros(len(firsts) - 1)
        jumps[np.searchsorted(firsts, self.firsts[:-1])] = self.jumps
        gradual = len(jumps) == 1 and bool((np.diff(pieces[:, 0]) >= _GRADUAL_WIDTH).all())
        if arrays:
            return Rise(pieces, levels, firsts, jumps, gradual)
        return Rise(list(map(tuple, pieces.tolist())), levels.tolist(), firsts.tolist(), jumps.tolist(), gradual)

    @property
    def _landings(self) -> IntArray:
        """Numbers of pieces at whose begin a step ends, since it would step over what they hold.

        They are narrow, or a narrow piece comes before them, and is not as wide.
        """
        low = self.pieces[:, 0]
        width = np.diff(self.pieces[:, 0], append=self.end)
        leap = width < _LEAP * low
        return 1 + np.flatnonzero((leap[1:] | leap[:-1]) & ~np.isclose(width[1:], width[:-1], atol=0))

    @cached_property
    def jumps(self) -> FloatArray:
        """By how much mu rises where each segment begins."""
        jumps = [0.0]
        for kink, i in zip(self.kinks, self.firsts[1:], strict=False):
            below, above = self.onset + _values_at(self.pieces[i - 1 : i + 1], np.array([kink, kink]), False)
            jumps.append(above - below if abs(above - below) > SAME * max(abs(above), abs(below)) else 0.0)
        return np.array(jumps)


def _values_at(pieces: FloatArray, v: FloatArray, derivative: bool) -> FloatArray:
    """Return polynomials, or their slopes, each at a speed."""
    t = (v - pieces[..., 1]) * pieces[..., 2]
    value = np.zeros_like(v)
    for k in range(TABLE_DEGREE, -1 + derivative, -1):
        value = value * t + pieces[..., k + 3] * (k if derivative else 1)
    if derivative:
        return value * pieces[..., 2]
    return value


_NO_VALUE = Unknown("mu has no finite value there")
_ROUGH = (
    "mu varies too often to be tabulated beyond {}, or no bound of its slope is close enough there; try a slower "
    "belt, or a law that varies less"
)


@dataclass
class _Segment:
    """A smooth segment of a law, from a start up to a speed, while it is tabulated.

    - `derivative`: whether it is one of a derivative by a parameter.
    - `changes`: speeds and widths at which it varies quickly, a column for each.
    - `slopes`: mu' in several forms, as functions of balls.
    - `cuts`: how often the range that was bounded last had to be halved.
    - `is_rough`: whether it varies too often to be tabulated to its end.
    """

    rising: Rising
    onset: float
    start: float
    high: float
    derivative: bool
    changes: FloatArray = field(default_factory=lambda: np.empty((2, 0)))
    slopes: list[BallFunction] = field(default_factory=list)
    cuts: int = 0
    is_rough: bool = False

    def read(self, expr: Expr, point: Substitution) -> None:
        """Take from the formula of the segment where it varies quickly, and bounds of its slope."""
        quick = transitions(expr, point)
        self.changes = np.reshape(np.array(quick, dtype=np.float64), (len(quick), 2)).T
        if not self.derivative:
            forms = _slopes(expr)
            self.slopes = (
                [ball_function(slope, symbols.v, point) for slope in forms]
                if self.start
                else [balls_from_rest(expr, point, slope=slope) for slope in forms]
            )

    def tabulated(self) -> tuple[FloatArray, float]:
        """Return the pieces, and the speed up to which they go."""
        rest, begin = (np.empty((0, 3 + TABLE_DEGREE + 1)), self.start) if self.start else _first(self)
        if begin >= self.high:
            return rest, self.high
        edges = begin * 2.0 ** np.arange(max(1, math.ceil(math.log2(self.high / begin))) + 1)
        edges[-1] = self.high
        reached = np.zeros(edges.size - 1)  # the highest rise up to the end of each octave

        found = subdivide(
            list(pairwise(edges.tolist())),
            partial(self._look, reached=reached),
            limits=DivisionLimits(parts=_INTERVALS_AN_OCTAVE),
            at_once=_INTERVALS_AN_OCTAVE,
            to_first_open=True,
        )
        pieces = np.array([*rest, *found.payloads])
        if not found.open:
            return pieces, self.high
        ((end, _, _, why),) = found.open
        self.is_rough = why is CROWDED
        return pieces, end

    def _look(
        self, intervals: Sequence[Interval[float, None]], reached: FloatArray
    ) -> Iterator[Decision[FloatArray, None]]:
        """Say of each interval whether one polynomial is enough, and raise the highest rise that was reached."""
        low, high = ends(intervals)
        values = self.rising(_CHEBYSHEV_GRID.between(low, high))
        scale = np.abs(values).max(axis=1)
        octaves = np.array([one.first for one in intervals])
        np.maximum.at(reached, octaves, np.where(np.isfinite(scale), scale, 0.0))
        np.maximum.accumulate(reached, out=reached)

        level = self.noise(values, low, high, np.array([one.halvings for one in intervals]))
        if self.derivative:
            level = level + _RISE_NOISE * reached[-1]
        coefficients = values @ _CHEBYSHEV_GRID.coefficients
        fits = (tail(coefficients, 2) <= level) & ~self.hides(low, high)
        # By so much mu may rise from end to end of an interval on which the polynomial shows all of it.
        steepest = STEEPER * 2 * np.abs(values @ _CHEBYSHEV_GRID.slopes).max(axis=1)
        steepest += _RISE_OF_NO_ACCOUNT * (level + _TAIL_SIZE * reached[octaves]) + 1 / LARGEST

        powers = coefficients @ _CHEBYSHEV_GRID.powers
        for i, one in enumerate(intervals):
            if one.high - one.low <= LEAST_RTOL * one.high:
                is_known = fits[i] or scale[i] < _POLE * (1 + abs(self.onset))
            elif fits[i] and self.is_sure(one.low, one.high, steepest[i] / (one.high - one.low)):
                is_known = True
            elif np.isfinite(values[i]).any():
                yield HALVE
                continue
            else:
                is_known = False
            yield Accept(_row(one, powers[i])) if is_known else _NO_VALUE

    def noise(self, values: FloatArray, low: FloatArray, high: FloatArray, halvings: IntArray) -> FloatArray:
        """Return what coefficients of a rise on intervals may be off by, a row of values for each."""
        scale = np.abs(values).max(axis=1)
        # A speed is rounded, which shows where mu is steep.
        level = _TAIL_SIZE * (scale + np.ptp(values, axis=1) * high / (high - low))
        return np.asarray(
            level + np.where(halvings >= _HALVINGS_TO_NOISE, _RISE_NOISE * (scale + abs(self.onset)), 0.0)
        )

    def hides(self, low: FloatArray, high: FloatArray) -> BoolArray:
        """Whether a transition within ranges, or beside them, is narrow beside them."""
        speed, width = self.changes
        distance = np.maximum(np.maximum(low[:, None] - speed, speed - high[:, None]), 0.0)
        hidden: BoolArray = ((high - low)[:, None] > _TRANSITION_WIDTHS * (width + distance)).any(axis=1)
        return hidden

    def is_sure(self, low: float, high: float, steepest: float, cuts: int = _CUTS) -> bool:
        """Whether balls show that abs(mu') is at most so steep on a range, halved at most so often.

        Ranges that are looked at one after another are much alike: each is cut at once as the last had to be.
        """
        if not self.slopes:
            return True
        first = min(self.cuts, cuts)
        bounds = [0.0]

        def holds(low: float, high: float, halvings: int) -> bool:
            bounds.append(self.bound(low, high, steepest))
            if bounds[-1] <= steepest:
                return True
            if first + halvings < cuts:
                self.cuts = first + halvings + 1
            return False

        between = [*(low + (high - low) * part / 2**first for part in range(2**first)), high]
        if not shown(holds, list(pairwise(between)), halvings=cuts - first):
            return False
        if 2 * max(bounds) <= steepest:
            self.cuts = max(0, first - 1)
        return True

    def bound(self, low: float, high: float, enough: float) -> float:
        """Return a bound of abs(mu') on a range: the first that is small enough, else an infinite one."""
        speeds = acb(arb(low).union(arb(high)))
        for number, slope in enumerate(self.slopes):
            size = slope(speeds, False).real.abs_upper()
            if size.is_finite() and float(size) <= enough:
                self.slopes.insert(0, self.slopes.pop(number))  # the form of the formula that is asked first
                return float(size)
        return math.inf


def _row(one: Interval[float, None], powers: FloatArray) -> FloatArray:
    """Return a piece with coefficients of the powers of its variable."""
    return np.array([one.low, (one.low + one.high) / 2, 2 / (one.high - one.low), *powers])


@lru_cache  # laws with other values share them
def _slopes(expr: Expr) -> list[Expr]:
    """Return the slope of a formula as it stands, and with what multiplies each function over one denominator.

    There algebraic terms cancel less: v/sqrt(v^2 + e^2) has the slope e^2/(v^2 + e^2)^(3/2).
    """
    slope = slope_of(expr)
    multiplied = defaultdict[Expr, Expr](lambda: sp.S.Zero)
    for term in sp.Add.make_args(slope):
        functions, algebraic = sp.sift(sp.Mul.make_args(term), _is_transcendental, binary=True)
        multiplied[sp.Mul(*functions)] += sp.Mul(*algebraic)
    parts = [function * _write_one_denominator(terms) for function, terms in multiplied.items()]
    return list(dict.fromkeys([slope, sp.Add(*parts)]))


def _write_one_denominator(terms: Expr) -> Expr:
    """Return a sum over one denominator."""
    numerator, denominator = sp.fraction(sp.together(terms))
    if denominator == 1:
        return terms
    return sp.expand(numerator) / denominator


def _is_transcendental(expr: Expr) -> bool:
    """Whether an expression is not made of sums, products and powers only, as far as it holds the slip speed."""
    return any(
        node.args and node.has(symbols.v) and not _is_algebraic(node) for node in sp.preorder_traversal(expr)
    )


def _is_algebraic(node: Expr) -> bool:
    return node.is_Add or node.is_Mul or (node.is_Pow and not node.exp.has(symbols.v))


def _first(segment: _Segment) -> tuple[FloatArray, float]:
    """Return the piece at rest, where the rise is v g(v), as wide as it fits, and where it ends."""
    rising = segment.rising
    onset = segment.onset
    high = segment.high
    widths = high * 2.0 ** -np.arange(max(1.0, math.floor(math.log2(high / _LOWEST))))[::-1]
    nodes = _CHEBYSHEV_GRID.between(np.zeros_like(widths), widths)
    values = rising(nodes)
    if not np.isfinite(values[0]).any():
        raise InputError(
            f"mu is not a finite real number at v = {nodes[0, 0]:.1e} m/s: no slip begins there; check the law's "
            "formula and the values of its parameters"
        )
    coefficients = (values / nodes) @ _CHEBYSHEV_GRID.coefficients
    largest = np.abs(values / nodes).max(axis=1)
    fits = (tail(coefficients, 2) <= _TAIL_SIZE * largest) & ~segment.hides(0 * widths, widths)
    steepest = STEEPER * np.abs(values @ _CHEBYSHEV_GRID.slopes).max(axis=1) * 2 / widths
    for noise in (0.0, _RISE_NOISE * abs(onset)):  # a rise that had to be computed as a difference has it
        own = (
            np.abs(nodes * (coefficients @ _CHEBYSHEV_GRID.polynomials) - values)
            <= _RISE_NOISE * np.abs(values) + noise
        )
        for i in np.flatnonzero(fits & own.all(axis=1))[::-1]:
            below = nodes[: i + 1]
            there = values[: i + 1]
            width = widths[i]
            fitted = below * polynomial_values(coefficients[i], 2 * below / width - 1)
            if (np.abs(fitted - there) <= _RISE_NOISE * np.abs(there) + noise).all() and (
                segment.is_sure(0.0, width, steepest[i], 0)
                or _is_sure_towards_rest(segment, float(widths[0]), float(width), steepest[i])
            ):
                return _piece_at_rest(width, coefficients[i]), float(width)
    straight = np.append(values[0, -1] / nodes[0, -1], np.zeros(TABLE_DEGREE))
    return _piece_at_rest(widths[0], straight), float(widths[0])


def _is_sure_towards_rest(segment: _Segment, low: float, high: float, steepest: float) -> bool:
    """Whether balls show that abs(mu') is at most so steep down to the least speed; mu may be singular at 0."""
    octaves = math.log2(high / low)
    halvings = 0
    if octaves > 1:
        halvings = math.ceil(math.log2(octaves))  # in logarithms, down to octaves

    def holds(low: float, high: float, halved: int) -> bool:
        return segment.is_sure(low, high, steepest, 0 if halved < halvings else _CUTS)

    def cut(low: float, high: float) -> float:
        return math.sqrt(low) * math.sqrt(high)

    return shown(holds, [(low, high)], halvings=halvings, cut=cut)


def _piece_at_rest(width: float, coefficients: FloatArray) -> FloatArray:
    """Return the piece from 0 on with v g(v) in powers of t = v/width, g of degree one less."""
    # In powers of 2 t - 1 first, then of t, without the last coefficient, which is rounding.
    known = np.where(np.abs(coefficients[:-1]) > _VANISHES * np.abs(coefficients).max(), coefficients[:-1], 0.0)
    row = np.append(0.0, known @ _AT_REST) * width
    row[np.abs(row) <= _VANISHES * np.abs(row).max()] = 0.0
    return np.array([[0.0, 0.0, 1 / width, *row]])

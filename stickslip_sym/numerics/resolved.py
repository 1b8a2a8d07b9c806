"""Functions of one quantity as polynomials: every root, every extremum, and where they are not resolved.

A function is sampled at the Chebyshev nodes of an interval, and the interval is halved until the last coefficients
of its polynomial vanish (Battles, Trefethen: An extension of MATLAB to continuous functions and operators, SIAM J.
Sci. Comput. 25, 2004). The polynomials then say what the function does between the samples too. A range begins
parted at the arguments where the function may break. An interval that stays open is kept, with an estimate, from
its samples, of the values that the function takes there; how often it takes those is not known.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray, Span
from stickslip_sym.core.numbers import LARGEST
from stickslip_sym.numerics.chebyshev import derivative_coefficients, grid, polynomial_values, real_roots, tail
from stickslip_sym.numerics.known import Column, Unknown
from stickslip_sym.numerics.subdivide import (
    NARROW,
    Accept,
    Decision,
    DivisionLimits,
    Halve,
    Interval,
    WorkBudget,
    ends,
    joined,
    subdivide,
)

NODES = 17
"""Samples of an interval."""
_TAIL_LENGTH = 3  # last coefficients, that must vanish
_LEAST_WIDTH = 1e-11  # width of an interval over the range: it holds a jump, or the end of a stretch without value
_ERROR_THAT_HIDES_ROOTS = 1e3  # times what was asked for, above which an error may hide roots,
_HIDES = 1e-2  # if it is larger than this part of what the values on a piece range over
_LEFT_OUT_BESIDE_ROOTS = 1e-3
"""Of its largest value, that a polynomial with a root may leave out where only roots are sought."""
ERRORS_OF_CLEAR_SIGN = 10.0
"""Errors of two values, between which the sign of their difference is certain."""
_STRIDES = 2.0  # of the largest steps between samples of an interval, by which it may go beyond them

Sampled: TypeAlias = Callable[[FloatArray], Column]
"""A function of many arguments; infinite where it lies beyond every level."""

NO_VALUE = Unknown("the function has no value there")
COARSE = Unknown("its values have large errors")


class Range(NamedTuple):
    """Between which values a function stays, estimated from samples."""

    least: float
    most: float


class Turn(NamedTuple):
    """An argument at which a function turns, or ends: its value there, and the error of that."""

    x: float
    value: float
    error: float


class Root(NamedTuple):
    """Where a function takes a value, and two arguments between which it does so once, within its errors."""

    x: float
    low: float
    high: float


class OpenStretch(NamedTuple):
    """An interval in which it is not known how often a function takes a value, which these may be, and why."""

    low: float
    high: float
    estimate: Range
    why: Unknown


_value = attrgetter("value")


class Piece(NamedTuple):
    """A polynomial, by its Chebyshev coefficients, between two arguments, and its error."""

    low: float
    high: float
    coefficients: FloatArray
    error: float

    def at(self, x: float) -> float:
        """Return the value at an argument."""
        place = (2 * x - self.low - self.high) / (self.high - self.low)
        return float(polynomial_values(self.coefficients, np.asarray(place)))

    def side(self, level: float) -> int:
        """Return 1 where the coefficients show that the polynomial lies above a value, -1 below, else 0."""
        off = float(self.coefficients[0]) - level
        is_clear = abs(off) > float(np.abs(self.coefficients[1:]).sum()) + self.error
        if is_clear:
            return int(math.copysign(1, off))
        return 0

    @property
    def turns(self) -> list[Turn]:
        """Both ends, and the arguments between them at which the slope vanishes."""
        inside: FloatArray = np.empty(0)
        if np.abs(self.coefficients[1:]).sum() > self.error:
            inside = real_roots(derivative_coefficients(self.coefficients))
        arguments = (self.low + self.high) / 2 + (self.high - self.low) / 2 * inside
        return [Turn(x, self.at(x), self.error) for x in (self.low, *arguments.tolist(), self.high)]


@dataclass(frozen=True, eq=False)
class Resolved:
    """A function of one quantity between two arguments.

    Attributes
    ----------
    pieces : tuple of Piece
        Ascending. Two that do not touch leave a jump between them, or a stretch that is open.
    open : tuple of Stretch
        Where the function may do what its pieces do not show, ascending.
    rtol : float
        Of the largest value on a piece, what its polynomial leaves out where the values have no errors.
    """

    pieces: tuple[Piece, ...]
    open: tuple[OpenStretch, ...]
    rtol: float

    def __call__(self, x: float) -> float:
        """Return the value at an argument, or where there is no piece that at the end of the piece before."""
        piece = self.pieces[max(bisect_right(self._lows, x) - 1, 0)]
        return piece.at(min(max(x, piece.low), piece.high))

    def side(self, level: float) -> int:
        """Return 1 where the coefficients show that the function lies above a value, -1 below, else 0."""
        sides = {piece.side(level) for piece in self.pieces}
        if len(sides) == 1 and not self.open:
            return sides.pop()
        return 0

    def between(self, low: float, high: float) -> "Resolved":
        """Return the same between two edges, as a function of the distance from the first."""
        pieces = [
            one._replace(low=one.low - low, high=one.high - low) for one in self.pieces if low <= one.low < high
        ]
        left = [one._replace(low=one.low - low, high=one.high - low) for one in self.open if low <= one.low < high]
        return Resolved(tuple(pieces), tuple(left), self.rtol)

    @cached_property
    def _lows(self) -> list[float]:
        return [piece.low for piece in self.pieces]

    @cached_property
    def _turns(self) -> list[list[Turn]]:
        return [piece.turns for piece in self.pieces]

    @cached_property
    def turns(self) -> tuple[Turn, ...]:
        """The extrema, as far as they stand out of the errors, between the first and the last.

        From each to the next the function only rises, or only falls, within its errors. Ends of the range count,
        and so do kinks and both sides of jumps and of open stretches.
        """
        extrema = list[Turn]()
        way = 0
        turns = [turn for turns in self._turns for turn in turns]
        if not turns:
            return ()
        least = most = turns[0]
        for turn in turns:
            least = min(least, turn, key=_value)
            most = max(most, turn, key=_value)
            if way >= 0 and most.value - turn.value > most.error + turn.error:
                extrema.append(most)
                least = turn
                way = -1
            elif way <= 0 and turn.value - least.value > turn.error + least.error:
                extrema.append(least)
                most = turn
                way = 1
        return (*extrema, least if way < 0 else most)

    def roots(self, level: float = 0.0) -> list[Root]:
        """Return where the function takes a value, ascending; a jump past it counts, and so does touching it."""
        roots = [Root(turn.x, turn.x, turn.x) for turn in self.turns if turn.value == level]
        for low, high in pairwise(self.turns):
            if min(low.value, high.value) < level < max(low.value, high.value):
                sides = {low.x: low.value, high.x: high.value}  # one each, where the function jumps there

                def off(x: float, sides: dict[float, float] = sides) -> float:
                    return min(max(sides.get(x, self(x)) - level, -LARGEST), LARGEST)

                x = low.x
                if low.x < high.x:
                    x = brentq(off, low.x, high.x)
                roots.append(Root(x, low.x, high.x))
        return sorted(roots)

    @cached_property
    def coarse(self) -> list[tuple[Piece, list[Turn], Range]]:
        """Pieces whose errors are much larger than was asked for, their turns, and the values they take."""
        largest = max((abs(turn.value) for turns in self._turns for turn in turns), default=0.0)
        rows = list[tuple[Piece, list[Turn], Range]]()
        for piece, turns in zip(self.pieces, self._turns, strict=True):
            if piece.error > _ERROR_THAT_HIDES_ROOTS * self.rtol * largest:
                values = [turn.value for turn in turns]
                rows.append((piece, turns, Range(min(values), max(values))))
        return rows

    def open_at(self, level: float) -> list[Span]:
        """Return the intervals in which it is not known how often the function takes a value, ascending.

        They are the open ones that may take it, and coarse pieces on which their errors may hide that it is taken
        twice: where an error is no small part of what the values range over, or where the value lies within it
        of an extremum.
        """
        found = [one[:2] for one in self.open if one.estimate.least <= level <= one.estimate.most]
        for piece, turns, (least, most) in self.coarse:
            is_met = least - piece.error <= level <= most + piece.error
            is_vague = piece.error > _HIDES * (most - least)
            touches = any(abs(turn.value - level) <= piece.error for turn in turns[1:-1])
            if is_met and (is_vague or touches):
                found.append((piece.low, piece.high))
        return joined(found)


def nodes(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return where `resolve` asks for values first in intervals, a row for each."""
    return grid(NODES).between(low, high)


def resolve(
    function: Sampled, edges: Sequence[float], *, rtol: float, most: int, sketch: Sampled | None = None
) -> Resolved:
    """Resolve a function of one quantity.

    - `edges`: ascending arguments: the ends of the range, and between them where the function may break.
    - `rtol`: of the largest value on an interval, what its polynomial may leave out; errors of values are added.
    - `most`: how many values may be computed; what they do not resolve is listed as open.
    - `sketch`: the function with larger errors, where only its roots are sought. The function itself is asked
      where these errors may hide one.
    """
    budget = WorkBudget(most)

    def look(intervals: Sequence[Interval[float, Range]]) -> list[Decision[Piece, Range]]:
        x = nodes(*ends(intervals))
        column = (sketch or function)(x.ravel())
        decisions = list[Decision[Piece, Range]]()
        for i, one in enumerate(intervals):
            row = column[i * NODES : (i + 1) * NODES]
            if sketch is None:
                decisions.append(fit_polynomial(one.low, one.high, row, rtol))
            else:
                decisions.append(closer(one, x[i], row))
        return decisions

    def closer(one: Interval[float, Range], x: FloatArray, row: Column) -> Decision[Piece, Range]:
        decision, enough = _sketched(one.low, one.high, row, rtol)
        vague = row.errors > enough
        if not vague.any() or not budget.take(int(vague.sum())):
            return decision
        row = row.replaced(vague, function(x[vague]))
        decision, _ = _sketched(one.low, one.high, row, rtol)
        if isinstance(decision, Accept):
            return decision
        return fit_polynomial(one.low, one.high, row, rtol)

    limits = DivisionLimits(budget, cost=NODES, narrowest=_LEAST_WIDTH * (edges[-1] - edges[0]))
    found = subdivide(list(pairwise(edges)), look, limits=limits, at_once=most)
    anything = Range(-math.inf, math.inf)
    stretches = [
        OpenStretch(one.low, one.high, one.note or anything, one.why)
        for one in found.open
        if one.why is not NARROW  # a jump
    ]
    return Resolved(tuple(found.payloads), tuple(stretches), rtol)


def fit_polynomial(low: float, high: float, row: Column, rtol: float) -> Decision[Piece, Range]:
    """Accept the polynomial through values at the `nodes` of an interval if its last coefficients vanish."""
    values = row.filled(np.nan)
    if np.isinf(values[0]) and (values == values[0]).all():  # it lies beyond every level
        return Accept(Piece(low, high, values[:1], 0.0))
    if not np.isfinite(values).all():
        return _estimated(row)
    coefficients = values @ grid(NODES).coefficients
    error = float(grid(NODES).lebesgue * row.errors.max() + rtol * np.abs(values).max())
    if tail(coefficients, _TAIL_LENGTH) > error:
        return _estimated(row)
    return Accept(Piece(low, high, coefficients, error))


def _estimated(row: Column) -> Halve[Range] | Unknown:
    """Halve an interval, and note what values a function may take on it: beyond those known it goes by strides."""
    values = row.filled(np.nan)
    if not row.known.any() and not np.isfinite(row.low).any():
        return NO_VALUE
    beyond = _STRIDES * float(np.abs(np.diff(values[np.isfinite(values)])).max(initial=0.0))
    return Halve(Range(float(row.low.min()) - beyond, float(row.high.max()) + beyond))


def _sketched(low: float, high: float, row: Column, rtol: float) -> tuple[Decision[Piece, Range], float]:
    """Accept such a polynomial if what it leaves out hides no root at 0, and return errors that hide none.

    Where it has a root what it leaves out has to be small beside its largest value; everywhere, beside its extrema
    and ends. The errors are infinite where the polynomial is accepted, or its last coefficients hide one.
    """
    values = row.filled(np.nan)
    if not np.isfinite(values).all():
        return fit_polynomial(low, high, row, rtol), math.inf
    coefficients = values @ grid(NODES).coefficients
    last = float(tail(coefficients, _TAIL_LENGTH))
    piece = Piece(low, high, coefficients, float(grid(NODES).lebesgue * row.errors.max() + last))
    sides = [turn.value for turn in piece.turns]
    largest = max(map(abs, sides))
    limit = min(map(abs, sides)) / ERRORS_OF_CLEAR_SIGN
    if min(sides) < 0.0 < max(sides):
        limit = min(limit, _LEFT_OUT_BESIDE_ROOTS * largest)
    if piece.error <= limit:
        return Accept(piece), math.inf
    hidden_by_tail = last > max(limit / 2, rtol * largest)
    return _estimated(row), math.inf if hidden_by_tail else limit / 2 / grid(NODES).lebesgue

"""Functions of one quantity as polynomials: every root, every extremum, and where they are not resolved.

A function is sampled at the Chebyshev nodes of an interval, and the interval is halved until the last coefficients
of its polynomial vanish (Battles, Trefethen: An extension of MATLAB to continuous functions and operators, SIAM J.
Sci. Comput. 25, 2004). The polynomials then say what the function does between the samples too. A range begins
parted at the arguments where the function may break; where the bound on the work leaves an interval unresolved, it
is kept as such.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray

_DEGREE = 16
_TAIL = 3  # last coefficients, that must vanish
_NOISE = 4.0  # errors of its values, by which a coefficient may be off
_NARROWEST = 1e-11  # width of an interval over the range: it holds a jump, or the end of a stretch without value
_COARSE = 1e3  # times what was asked for, above which an error hides roots
_PLAIN = 1e-3  # of its largest value, that a polynomial with a root may leave out where only roots are sought
_CLEAR = 10.0  # times what it leaves out, that its extrema and ends are then
_FARTHEST = 1e300  # from a value, that a bisection is to see
_REAL = 1e-3  # imaginary part of a root of a slope, of a double root that rounding has parted

NODES = -np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
"""Chebyshev's, ascending."""
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, _DEGREE)).T

Sampled = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""A function of many arguments: its values, infinite where it lies beyond every level and NaN where unknown, and
their errors."""


class Turn(NamedTuple):
    """An argument at which a function turns, or ends: its value there, and the error of that."""

    x: float
    value: float
    error: float


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
        return float(chebyshev.chebval(place, self.coefficients))

    @property
    def turns(self) -> list[Turn]:
        """Both ends, and the arguments between them at which the slope vanishes."""
        inside = np.empty(0)
        if np.abs(self.coefficients[1:]).sum() > self.error:
            roots = chebyshev.chebroots(chebyshev.chebtrim(chebyshev.chebder(self.coefficients)))
            inside = np.sort(roots.real[(np.abs(roots.imag) < _REAL) & (np.abs(roots.real) < 1)])
        at = (self.low + self.high) / 2 + (self.high - self.low) / 2 * inside
        return [Turn(x, self.at(x), self.error) for x in (self.low, *at.tolist(), self.high)]


class Root(NamedTuple):
    """Where a function takes a value, and two arguments between which it does so once, within its errors."""

    x: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Resolved:
    """A function of one quantity between two arguments.

    Attributes
    ----------
    pieces : tuple of Piece
        Ascending. Two that do not touch leave a jump between them, or an interval that is not resolved.
    unresolved : tuple of (float, float)
        Intervals in which the function may do what its pieces do not show, ascending.
    rtol : float
        Of the largest value on a piece, what its polynomial leaves out where the values have no errors.
    """

    pieces: tuple[Piece, ...]
    unresolved: tuple[tuple[float, float], ...]
    rtol: float

    def __call__(self, x: float) -> float:
        """Return the value at an argument, or where there is no piece that at the end of the piece before."""
        piece = self.pieces[max(bisect_right(self._lows, x) - 1, 0)]
        return piece.at(min(max(x, piece.low), piece.high))

    @cached_property
    def _turns(self) -> list[list[Turn]]:
        return [piece.turns for piece in self.pieces]

    @cached_property
    def _largest(self) -> float:
        values = [abs(turn.value) for turns in self._turns for turn in turns]
        return max(filter(math.isfinite, values), default=0.0)

    @cached_property
    def _lows(self) -> list[float]:
        return [piece.low for piece in self.pieces]

    @cached_property
    def turns(self) -> tuple[Turn, ...]:
        """The extrema, as far as they stand out of the errors, between the first and the last.

        From each to the next the function only rises, or only falls, within its errors. Ends of the range count,
        and so do kinks and both sides of jumps.
        """
        extrema, way = list[Turn](), 0
        turns = [turn for turns in self._turns for turn in turns]
        if not turns:
            return ()
        least = most = turns[0]
        for turn in turns:
            least, most = min(least, turn, key=_value), max(most, turn, key=_value)
            if way >= 0 and most.value - turn.value > most.error + turn.error:
                extrema.append(most)
                least, way = turn, -1
            elif way <= 0 and turn.value - least.value > turn.error + least.error:
                extrema.append(least)
                most, way = turn, 1
        return (*extrema, least if way < 0 else most)

    def roots(self, level: float = 0.0) -> list[Root]:
        """Return where the function takes a value, ascending; a jump past it counts, and so does touching it."""
        roots = [Root(turn.x, turn.x, turn.x) for turn in self.turns if turn.value == level]
        for low, high in pairwise(self.turns):
            if min(low.value, high.value) < level < max(low.value, high.value):
                ends = {low.x: low.value, high.x: high.value}  # one side each, where the function jumps there

                def off(x: float, ends: dict[float, float] = ends) -> float:
                    return min(max(ends.get(x, self(x)) - level, -_FARTHEST), _FARTHEST)

                x = brentq(off, low.x, high.x) if low.x < high.x else low.x
                roots.append(Root(x, low.x, high.x))
        return sorted(roots)

    def open_at(self, level: float) -> list[tuple[float, float]]:
        """Return the intervals in which it is not known how often the function takes a value, ascending.

        They are those that are not resolved, and pieces across the value whose errors are much larger than was
        asked for.
        """
        coarse = [
            (piece.low, piece.high)
            for piece, turns in zip(self.pieces, self._turns, strict=True)
            if piece.error > _COARSE * self.rtol * self._largest
            and min(turns, key=_value).value - piece.error <= level <= max(turns, key=_value).value + piece.error
        ]
        return joined(sorted([*self.unresolved, *coarse]))


def fitted(low: float, high: float, values: FloatArray, errors: FloatArray, rtol: float) -> Piece | None:
    """Return the polynomial through values at the `NODES` between two arguments; None if it is not resolved."""
    if not np.isfinite(values).all():
        return None
    coefficients = values @ _COEFFICIENTS
    error = float(_NOISE * errors.max() + rtol * np.abs(values).max())
    return Piece(low, high, coefficients, error) if np.abs(coefficients[-_TAIL:]).max() <= error else None


def sketched(
    low: float, high: float, values: FloatArray, errors: FloatArray, rtol: float
) -> tuple[Piece | None, float]:
    """Return such a polynomial if what it leaves out hides no root at 0, and errors of its values that hide none.

    Where it has a root that has to be small beside its largest value; everywhere, beside its extrema and ends. The
    errors are infinite where the polynomial is there, or its last coefficients hide one.
    """
    if not np.isfinite(values).all():
        return None, math.inf
    coefficients = values @ _COEFFICIENTS
    tail = float(np.abs(coefficients[-_TAIL:]).max())
    piece = Piece(low, high, coefficients, float(_NOISE * errors.max() + tail))
    ends = [turn.value for turn in piece.turns]
    largest, limit = max(map(abs, ends)), min(map(abs, ends)) / _CLEAR
    if min(ends) < 0.0 < max(ends):
        limit = min(limit, _PLAIN * largest)
    if piece.error <= limit:
        return piece, math.inf
    return None, limit / 2 / _NOISE if tail <= max(limit / 2, rtol * largest) else math.inf


def nodes(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the Chebyshev nodes of intervals, a row for each: where `resolve` asks for values first."""
    return np.asarray((low + high)[:, None] / 2 + (high - low)[:, None] / 2 * NODES)


def resolve(
    function: Sampled, edges: Sequence[float], *, rtol: float, most: int, sketch: Sampled | None = None
) -> Resolved:
    """Resolve a function of one quantity.

    - `edges`: ascending arguments: the ends of the range, and between them where the function may break.
    - `rtol`: of the largest value on an interval, what its polynomial may leave out; errors of values are added.
    - `most`: how many values may be computed; what they do not resolve is listed as unresolved.
    - `sketch`: the function with larger errors, where only its roots are sought. The function itself is asked
      where these errors may hide one.
    """
    low, high = np.array(edges[:-1], dtype=np.float64), np.array(edges[1:], dtype=np.float64)
    narrowest = _NARROWEST * (edges[-1] - edges[0])
    pieces, unresolved, left = list[Piece](), list[tuple[float, float]](), most
    while low.size and (left := left - low.size * NODES.size) >= 0:
        x = nodes(low, high)
        values, errors = (column.reshape(x.shape) for column in (sketch or function)(x.ravel()))
        fits, beyond = (
            np.zeros(low.size, dtype=bool),
            np.isinf(values[:, 0]) & (values == values[:, :1]).all(axis=1),
        )
        for i, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
            if beyond[i]:
                piece: Piece | None = Piece(*ends, values[i, :1], 0.0)
            elif sketch is None:
                piece = fitted(*ends, values[i], errors[i], rtol)
            else:
                piece, enough = sketched(*ends, values[i], errors[i], rtol)
                if (coarse := errors[i] > enough).any():
                    left -= int(coarse.sum())
                    values[i, coarse], errors[i, coarse] = function(x[i, coarse])
                    piece = sketched(*ends, values[i], errors[i], rtol)[0]
                    piece = piece or fitted(*ends, values[i], errors[i], rtol)
            fits[i] = piece is not None
            pieces += [piece] if piece is not None else []
        unknown = np.isnan(values).all(axis=1)
        unresolved += zip(low[unknown].tolist(), high[unknown].tolist(), strict=True)
        halved = ~fits & ~unknown & (high - low > narrowest)
        middle = (low[halved] + high[halved]) / 2
        low, high = np.concatenate((low[halved], middle)), np.concatenate((middle, high[halved]))
    unresolved += zip(low.tolist(), high.tolist(), strict=True)
    ascending = sorted(pieces, key=lambda piece: piece.low)
    return Resolved(tuple(ascending), tuple(joined(sorted(unresolved))), rtol)


def joined(intervals: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Join intervals that touch, of ascending ones."""
    joined = intervals[:1]
    for low, high in intervals[1:]:
        if low <= joined[-1][1]:
            joined[-1] = joined[-1][0], high
        else:
            joined.append((low, high))
    return joined

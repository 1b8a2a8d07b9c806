"""Slip of many oscillators at once, each from a start of its own to the end of a round or a part of it.

All of them take steps of time together, each of its own length. A call on an array costs about as much as one on
a number, so what one orbit costs falls with their count. The equations are those of `Scene`, for a mass slower
than the belt:

    q' = 1 - w,    w' = eta (mu_static - mu(V w)) + q - 2 zeta w.

Where mu has a kink a step ends at it, closely enough, and the next one takes the next piece of mu. What these
steps are not made for (a jump of mu, a fast decay, too rough a law) ends as `LOST`.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.motion.orbits.steps import EXPONENT, error_of, take_step

__all__ = ["AWAY", "CREEPS", "LOST", "RETURN", "TURN", "Arrivals", "Family", "arrive"]

LOST, TURN, RETURN, CREEPS, AWAY = range(5)
"""How a slip ends: not known, at a minimum of w, at the level asked for, on its way to rest, or ever faster."""
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 6.0
_FIRST, _LONGEST = 0.02, 0.4  # steps of time; at the longest one no extremum of w is passed over
_SHORTEST = 1e-11  # step
_MOST_STEPS = 600
_CREEPS = 40.0  # time after which an orbit that has not turned creeps to rest
_HIGHEST = 100.0  # slip speed that stands for all that are higher
_PLACES = 7  # Newton steps to the time of an extremum, or of w = 0
_BESIDE = 0.03  # of the root of a tolerance: how close to a kink a step ends, since what it is off is a square
_HERMITE = 4  # Newton steps to where a cubic through the ends of a step passes a kink
_NEAREST = 1e-14  # slip speed over the belt's, below which mu is not asked for
_LEAST_ERROR = 1e-30
_LEAST_PART = 1e-4  # of a step that leads to a kink; it goes on from there
_TOGETHER = 1024  # orbits, whose states stay in a processor's cache


@dataclass(frozen=True)
class Family:
    """Oscillators free of units, one a row, as `Scene` describes one.

    Attributes
    ----------
    mu : callable
        mu(v) of arrays of slip speeds, then of the place of a piece of mu for each, then of each array of `given`.
    V, eta, static, onset : numpy.ndarray, shape (n,)
        Belt speed, friction, the coefficient that limits sticking, and mu(0+).
    edges : numpy.ndarray, shape (n, pieces + 1)
        Slip speeds over the belt's between which the pieces of mu hold: the first is minus infinity, the last
        where the law is not known any more.
    given : tuple of numpy.ndarray
        Parameters of the law that differ among the rows.
    """

    mu: Callable[..., FloatArray]
    V: FloatArray
    eta: FloatArray
    static: FloatArray
    onset: FloatArray
    edges: FloatArray
    given: tuple[FloatArray, ...] = ()

    def rows(self, chosen: IntArray | BoolArray) -> "Family":
        """Return some of the oscillators."""
        V, eta, static, onset, edges = (
            column[chosen] for column in (self.V, self.eta, self.static, self.onset, self.edges)
        )
        return Family(self.mu, V, eta, static, onset, edges, tuple(column[chosen] for column in self.given))

    @property
    def backward(self) -> "Family":
        """The same with time reversed and q mirrored: the equations keep their form, friction changes its sign."""
        return replace(self, eta=-self.eta)

    def piece(self, w: FloatArray) -> IntArray:
        """Return the place of the piece of mu that holds at slip speeds and above."""
        found: IntArray = (self.edges[:, 1:-1] <= w[:, None]).sum(axis=1)
        return found

    def friction(self, w: FloatArray, piece: IntArray) -> FloatArray:
        """Return what friction adds to w'; mirrored where w < 0, where a step may be tried."""
        rise = self.mu(self.V * np.maximum(np.abs(w), _NEAREST), piece, *self.given) - self.onset
        return self.eta * (self.static - self.onset - np.where(w < 0, -rise, rise))


@dataclass(frozen=True)
class Arrivals:
    """Where each slip ends."""

    end: IntArray  # LOST, TURN, RETURN, CREEPS or AWAY
    q: FloatArray
    w: FloatArray
    slope: FloatArray  # w' there


def arrive(
    family: Family, zeta: FloatArray, q: FloatArray, w: FloatArray, size: FloatArray, ways: IntArray | None = None
) -> Arrivals:
    """Follow the slips that leave (q, w), where w' >= 0, to the next minimum of w or return to w = 0.

    - `zeta`: damping ratios.
    - `size`: by how much a step may be off.
    - `ways`: where the slips are to end as the mass stands still, w = 1: -1 where w falls through it, 1 where it
      rises.
    """
    found = Arrivals(np.full(len(q), LOST), *np.full((3, len(q)), np.nan))
    with np.errstate(all="ignore"):  # a step may be tried where mu has no value, and is then taken again
        for start in range(0, len(q), _TOGETHER):
            part = np.arange(start, min(start + _TOGETHER, len(q)))
            slips = _Slips(family.rows(part), zeta[part], size[part], None if ways is None else ways[part])
            slips.follow(q[part], w[part])
            for column, ends in zip(
                (found.end, found.q, found.w, found.slope), (slips.end, *slips.state, slips.slope), strict=True
            ):
                column[part] = ends
    return found


class _Slips:
    """Some slips on their way."""

    def __init__(self, family: Family, zeta: FloatArray, size: FloatArray, ways: IntArray | None) -> None:
        self.family, self.damping, self.size, self.ways = family, 2 * zeta, size, ways
        self.kinks = family.edges.shape[1] > 2 or bool(np.isfinite(family.edges[:, -1]).any())
        self.beside = _BESIDE * np.sqrt(size)
        self.end = np.full(len(zeta), LOST)
        self.state = np.full((2, len(zeta)), np.nan)
        self.slope = np.full(len(zeta), np.nan)

    def follow(self, q: FloatArray, w: FloatArray) -> None:
        """Take steps until every slip has ended."""
        rows, some = np.arange(len(q)), self
        state, piece = np.array([q, w]), self.family.piece(w)
        rates = some._rates(state, piece)
        rates[1] = np.maximum(rates[1], 0.0)  # it may be 0 but for rounding
        rates, piece = some._entered(state, rates, piece)
        h, time = np.full(len(q), _FIRST), np.zeros(len(q))
        wish = h  # the step that is tried after one that was shortened to end at a kink
        last, last_piece, length = self.state.copy(), piece.copy(), h.copy()  # before the step that ends a slip
        for _ in range(_MOST_STEPS):
            check_time()
            after, error = some._step(state, rates, piece, h)
            later = some._rates(after, piece)
            sound = error < 1
            factor = np.clip(_SAFETY * np.maximum(error, _LEAST_ERROR) ** EXPONENT, _LEAST, _MOST)
            factor = np.where(sound, factor, np.minimum(factor, _SAFETY))
            if some.kinks:
                shorter = some._to_kink(state, rates, after, later, piece, h)
                factor, sound = np.where(sound, np.minimum(factor, shorter), factor), sound & (shorter >= 1)
            turns, meets = some._ends(state, rates, after, later)
            ended = sound & (turns | meets)
            if ended.any():
                last[:, rows[ended]], last_piece[rows[ended]] = state[:, ended], piece[ended]
                length[rows[ended]], self.end[rows[ended]] = h[ended], np.where(turns[ended], TURN, RETURN)
            time += np.where(sound, h, 0.0)
            h, wish = (
                np.minimum(np.where(sound, np.maximum(h * factor, wish), h * factor), _LONGEST),
                np.where(sound, 0.0, np.where(error < 1, np.maximum(wish, h), 0.0)),
            )
            state, rates = np.where(sound, after, state), np.where(sound, later, rates)
            creeps = ~ended & (time > _CREEPS)
            away = state[1] > _HIGHEST
            self.end[rows[creeps]], self.end[rows[away]] = CREEPS, AWAY
            on = ~(ended | creeps | away) & (h > _SHORTEST)
            if some.kinks:
                rates, piece = some._entered(state, rates, piece)
                on &= piece < some.family.edges.shape[1] - 1
            if not on.any():
                break
            if not on.all():
                rows, some = rows[on], some._subset(on)
                state, rates, piece = state[:, on], rates[:, on], piece[on]
                h, wish, time = h[on], wish[on], time[on]
        ended = (self.end == TURN) | (self.end == RETURN)
        some = self._subset(ended)
        landed = some._landed(last[:, ended], last_piece[ended], length[ended], self.end[ended] == TURN)
        self.end[ended], self.state[:, ended], self.slope[ended] = landed

    def _subset(self, chosen: BoolArray) -> "_Slips":
        ways = None if self.ways is None else self.ways[chosen]
        return _Slips(self.family.rows(chosen), self.damping[chosen] / 2, self.size[chosen], ways)

    def _rates(self, state: FloatArray, piece: IntArray) -> FloatArray:
        q, w = state
        return np.array([1 - w, self.family.friction(w, piece) + q - self.damping * w])

    def _step(
        self, state: FloatArray, rates: FloatArray, piece: IntArray, h: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return the state after a step, and the step's error over the tolerance: infinite where there is none."""
        after, estimates = take_step(
            lambda moved, into: np.copyto(into, self._rates(moved, piece)), state, h, first=rates
        )
        error = error_of(estimates, self.size, h)
        return after, np.where(np.isfinite(error) & np.isfinite(after[1]), error, np.inf)

    # -- kinks -------------------------------------------------------------------------------------

    def _bounds(self, piece: IntArray) -> tuple[FloatArray, FloatArray]:
        edges, rows = self.family.edges, np.arange(len(piece))
        return edges[rows, piece], edges[rows, piece + 1]

    def _entered(self, state: FloatArray, rates: FloatArray, piece: IntArray) -> tuple[FloatArray, IntArray]:
        """Return the piece of mu that holds from here on, and the rates with it."""
        low, high = self._bounds(piece)
        w, rises = state[1], rates[1] >= 0
        up, down = rises & (high - w <= self.beside), ~rises & (w - low <= self.beside)
        if not (up | down).any():
            return rates, piece
        now = np.asarray(piece + up - down)
        inside = np.minimum(now, self.family.edges.shape[1] - 2)
        return np.where(up | down, self._rates(state, inside), rates), now

    def _to_kink(
        self,
        state: FloatArray,
        rates: FloatArray,
        after: FloatArray,
        later: FloatArray,
        piece: IntArray,
        h: FloatArray,
    ) -> FloatArray:
        """Return which part of a step to take instead, up to a kink; infinity where it passes none.

        Where w turns close to a kink, and the step is too long to tell whether it gets there, it is a half.
        """
        rises = rates[1] >= 0
        low, high = self._bounds(piece)
        bound, other, sign = np.where(rises, high, low), np.where(rises, low, high), np.where(rises, 1.0, -1.0)
        start, gain = sign * (state[1] - bound), sign * (after[1] - state[1])  # below 0 on this side of the kink
        fast, slow = sign * rates[1] * h, sign * later[1] * h
        # The cubic through the ends of the step, over parts of it.
        bend, twist = 3 * gain - 2 * fast - slow, fast + slow - 2 * gain
        turned = slow < 0
        top = np.where(turned, fast / np.where(turned, fast - slow, 1.0), 1.0)
        rough = top * fast / 2
        for _ in range(_HERMITE):
            fall = 2 * bend + 6 * twist * top
            shift = (fast + top * (2 * bend + 3 * twist * top)) / np.where(fall < 0, fall, -np.inf)
            top = np.where(turned, np.clip(top - shift, 0.0, 1.0), 1.0)
        rise = top * (fast + top * (bend + top * twist))
        highest, unsure = start + rise, np.where(turned, np.abs(rise - rough), 0.0)
        passes, near = highest > self.beside, (np.abs(highest) <= unsure) & (unsure > self.beside)
        part = top / 2
        for _ in range(_HERMITE):
            value = start + part * (fast + part * (bend + part * twist))
            slope = fast + part * (2 * bend + 3 * part * twist)
            part = np.clip(part - value / np.where(slope > 0, slope, np.inf), 0.0, 0.999)
        back = turned & (sign * (other - after[1]) > self.beside)  # it turns, and leaves the piece again
        choices = [near, passes, back]
        return np.select(choices, [0.5, np.maximum(part, _LEAST_PART), np.clip(top, 0.1, 0.9)], np.inf)

    # -- ends --------------------------------------------------------------------------------------

    def _ends(
        self, state: FloatArray, rates: FloatArray, after: FloatArray, later: FloatArray
    ) -> tuple[BoolArray, BoolArray]:
        """Tell in which steps w has its minimum, and in which it passes the level where slips end."""
        if self.ways is not None:
            before, beyond = self.ways * (state[1] - 1), self.ways * (after[1] - 1)
            return np.zeros(before.shape, bool), (before < 0) & (beyond >= 0)
        falls = rates[1] < 0
        turns = falls & (later[1] >= 0)
        return turns, ~turns & falls & (state[1] > 0) & (after[1] <= 0)

    def _landed(
        self, state: FloatArray, piece: IntArray, h: FloatArray, turns: BoolArray
    ) -> tuple[IntArray, FloatArray, FloatArray]:
        """Return how and where slips end within a step, and w' there: a minimum, or the level before it."""
        rates, part, level = self._rates(state, piece), h, 0.0 if self.ways is None else 1.0
        for _ in range(_PLACES if turns.any() else 0):
            after, _ = self._step(state, rates, piece, part)
            dq, slope = self._rates(after, piece)
            part = np.where(turns, np.clip(part - slope / dq, 0.0, h), h)  # near a minimum w'' is q'
        returns = ~turns | (self._step(state, rates, piece, part)[0][1] < level)
        place = np.where(returns, 0.0, part)  # before a minimum Newton's method comes to a level from one side
        for _ in range(_PLACES if returns.any() else 0):
            after, _ = self._step(state, rates, piece, place)
            ahead = np.clip(place - (after[1] - level) / self._rates(after, piece)[1], 0.0, part)
            place = np.where(returns, ahead, part)
        end = self._step(state, rates, piece, place)[0]
        end[1, returns] = level
        return np.where(returns, RETURN, TURN), end, self._rates(end, piece)[1]

"""Slip orbits of strong friction, by shooting from both ends: all scenes at once, each with steps of its own.

With w = 1 - x'/V, u = w' and time in 1/omega an orbit obeys

    w' = u,    u' = (g - d) u + 1 - w,    g = -N mu'(V w)/sqrt(k m),    d = c/sqrt(k m).

From its lowest slip speed, w = 1 - A and u = 0, it is followed forwards over the highest one to w = 1, and
backwards to w = 1: there u < 0 on both ways. Where friction drives (g > d, at small w as a rule) neighbouring
motions part, along the orbit's last stretch by many powers of ten if friction is strong; backwards they close up.
So both ways to the middle are steady where one way round is not.

Damping rotates the field of directions one way, so the mismatch log(u_f/u_b), a straight line for weak friction,
falls with d and has one root. Its slope follows along: a small deviation across either half obeys
M' = (g - d) M + u^2, M = 0 at the start, and du/dd = -M/u at w = 1. A half that creeps to rest, forwards with too
much damping or backwards with too little, ends with u = 0.
"""

from dataclasses import dataclass, fields

import numpy as np

from stickslip_sym.core.aliases import FloatArray, Rows
from stickslip_sym.core.deadline import check_time
from stickslip_sym.motion.orbits.expansion import Slope
from stickslip_sym.motion.orbits.steps import EXPONENT, error_of, take_step

__all__ = ["Shots", "shoot"]

_SAFETY, _LEAST, _MOST = 0.9, 0.2, 5.0
_FIRST, _LONGEST = 1e-3, 0.5  # steps, in 1/omega; the longest one is a small part of a half
_STAGES = ((1e-5, 3e-2), (1e-9, 1e-4), (3e-14, 1e-11))
"""Tolerances of a step, one after another on the way to the root, and for each the mismatch at which the next one
is taken: Newton's method squares it."""
_LEFT = 1e-3  # of the last change of d, which the last tolerance makes: errors go as the tolerance, 1e-4 here
_ROUNDING = 1e-14  # of d, as a part of the largest slope, or of 2 where that is smaller
_TINY = 1e-30  # error of a step, below which it is none
_SMALL = 0.01  # components of the state below count as that large
_NEAREST = 1e-12  # slip speed over belt speed that mu is asked for; a try may overshoot the belt
_MOST_STEPS = 4000  # of one half
_MOST_TRIES = 60  # dampings
_CREEPS = 10.0  # time, times 2 + |d|, after which a half that has not come to w = 1 creeps to rest
_SHORTEST = 1e-12  # step, in 1/omega, below which mu is too rough
_FIRST_REACH = 0.05  # relative change of d that is tried where Newton's method does not help; doubled each time
_PLACES = 5  # Newton steps to a place on the way, at most
_THERE = 1e-8  # time to it after which a straight line serves


@dataclass(frozen=True)
class Shots:
    """Slip orbits, one entry for each scene; NaN where none was found.

    Attributes
    ----------
    d, error : numpy.ndarray
        Damping over sqrt(k m), and its estimated error.
    period : numpy.ndarray
        In 1/omega.
    exponent : numpy.ndarray
        The mean of g - d.
    highest : numpy.ndarray
        The highest slip speed over the belt speed.
    scale : numpy.ndarray
        The largest size of g.
    """

    d: FloatArray
    error: FloatArray
    period: FloatArray
    exponent: FloatArray
    highest: FloatArray
    scale: FloatArray


@dataclass(frozen=True)
class _Halves:
    """Forwards and backwards from the lowest slip speed to w = 1."""

    mismatch: FloatArray  # log(u_f/u_b); infinite where one of them creeps to rest
    slope: FloatArray  # of the mismatch, over d
    period: FloatArray
    gathered: FloatArray  # the integral of g
    highest: FloatArray
    scale: FloatArray


@dataclass(frozen=True)
class _Scenes:
    slope: Slope
    V: FloatArray
    strength: FloatArray  # N/sqrt(k m) in m/s
    A: FloatArray

    def rows(self, chosen: Rows) -> "_Scenes":
        return _Scenes(self.slope, self.V[chosen], self.strength[chosen], self.A[chosen])

    def twice(self) -> "_Scenes":
        return _Scenes(self.slope, *(np.tile(column, 2) for column in (self.V, self.strength, self.A)))

    def g(self, w: FloatArray) -> FloatArray:
        return -self.strength * self.slope(self.V * np.maximum(w, _NEAREST))

    def rates(self, state: FloatArray, d: FloatArray, into: FloatArray) -> FloatArray:
        w, u, across, _ = state
        into[3] = self.g(w)
        excess = into[3] - d
        into[0] = u
        into[1] = excess * u + 1 - w
        into[2] = excess * across + u * u
        return into


def shoot(slope: Slope, V: FloatArray, strength: FloatArray, A: FloatArray, d: FloatArray) -> Shots:
    """Return the slip orbits of highest velocities A V, near a first guess of d."""
    scenes, count = _Scenes(slope, V, strength, A), len(d)
    found = Shots(*np.full((len(fields(Shots)), count), np.nan))
    found.d[:] = d
    for tolerance, settled in _STAGES:
        _settle(scenes, found, tolerance, settled)
    return found


def _settle(scenes: _Scenes, found: Shots, tolerance: float, settled: float) -> None:
    """Move the dampings to the roots at one tolerance of the steps."""
    low, high = np.full((2, len(found.d)), [[-np.inf], [np.inf]])
    reach = _FIRST_REACH * np.abs(found.d)
    before = np.full(len(found.d), np.inf)
    active = np.flatnonzero(np.isfinite(found.d))
    for _ in range(_MOST_TRIES):
        if not active.size:
            return
        check_time()
        now = found.d[active]
        halves = _halves(scenes.rows(active), now, tolerance)
        step, rounding = -halves.mismatch / halves.slope, _ROUNDING * np.maximum(2, halves.scale)
        low[active] = np.where(halves.mismatch > 0, now, low[active])
        high[active] = np.where(halves.mismatch <= 0, now, high[active])
        done = (np.abs(halves.mismatch) <= settled) | (np.abs(step) <= rounding)
        slow = np.abs(halves.mismatch) > before[active] / 2  # Newton's method does not help
        # Twice in turn there is no value: the law is too rough, or too stiff.
        lost = np.isnan(halves.mismatch) & np.isnan(before[active])
        before[active] = np.abs(halves.mismatch)
        safe = _within(now, np.where(slow, np.nan, step), low[active], high[active], reach[active])
        ahead = np.where(lost, np.nan, np.where(done, now + step, safe))
        reach[active] *= 2
        found.d[active] = ahead
        found.error[active] = _LEFT * np.abs(step) + rounding
        found.period[active] = halves.period
        found.exponent[active] = halves.gathered / halves.period - ahead
        found.highest[active] = halves.highest
        found.scale[active] = halves.scale
        active = active[~done & np.isfinite(ahead)]
    found.d[active] = np.nan


def _within(now: FloatArray, step: FloatArray, low: FloatArray, high: FloatArray, reach: FloatArray) -> FloatArray:
    """Return Newton's next d, or one that halves the bracket where it lies outside; NaN where nothing helps."""
    known = np.isfinite(low) & np.isfinite(high)
    middle = np.where(known, (low + high) / 2, np.where(np.isfinite(low), now + reach, now - reach))
    ahead = now + step
    inside = (ahead > low) & (ahead < high)
    ahead = np.where(inside, ahead, middle)
    return np.where(ahead == now, np.nan, ahead)


def _halves(scenes: _Scenes, d: FloatArray, rtol: float) -> _Halves:
    count = len(d)
    ahead = slice(count)
    scenes, d = scenes.twice(), np.tile(d, 2)
    forwards = np.repeat([1.0, -1.0], count)
    state = np.zeros((4, 2 * count))
    state[0] = 1 - scenes.A
    time, length = np.zeros(2 * count), np.full(2 * count, _FIRST)
    scale = np.abs(scenes.g(state[0]))
    crest, before_crest = state.copy(), np.zeros(2 * count)  # the states before the highest w, and the step to it
    arrives, creeps = np.zeros((2, 2 * count), dtype=bool)
    active = np.arange(2 * count)
    for _ in range(_MOST_STEPS):
        some, before, h, way = scenes.rows(active), state[:, active], length[active], forwards[active]
        after, error = _step(some, before, d[active], way * h, rtol)
        sound = error < 1
        factor = np.clip(_SAFETY * np.maximum(error, _TINY) ** EXPONENT, _LEAST, np.where(sound, _MOST, 1.0))
        ended = sound & (way * before[0] > way) & (way * after[0] <= way)  # within this step
        arrives[active] = ended
        passes = sound & (before[1] >= 0) & (after[1] < 0) & (way > 0)
        crest[:, active[passes]], before_crest[active[passes]] = before[:, passes], h[passes]
        length[active] = np.where(ended, h, np.minimum(h * factor, _LONGEST))
        on = sound & ~ended
        kept = active[on]
        state[:, kept] = after[:, on]
        time[kept] += h[on]
        scale[kept] = np.maximum(scale[kept], np.abs(some.g(after[0]))[on])
        creeps[kept] = time[kept] > _CREEPS * (2 + np.abs(d[kept]))
        active = active[~ended & ~creeps[active] & (length[active] > _SHORTEST)]
        if not active.size:
            break
    highest, _ = _arrival(scenes.rows(ahead), crest[:, ahead], d[ahead], before_crest[ahead], 1, 0.0)
    rows = np.flatnonzero(arrives)
    ends, part = _arrival(scenes.rows(rows), state[:, rows], d[rows], (forwards * length)[rows], 0, 1.0)
    state[:, rows], time[rows] = ends, time[rows] + np.abs(part)
    speed = np.where(creeps, 0.0, np.where(arrives, -state[1], np.nan)).reshape(2, count)
    changes, gathered = state[2].reshape(2, count) / speed**2, state[3].reshape(2, count)
    return _Halves(
        np.log(speed[0] / speed[1]),
        changes[1] - changes[0],
        time.reshape(2, count).sum(axis=0),
        gathered[0] - gathered[1],
        highest[0],
        scale.reshape(2, count).max(axis=0),
    )


def _arrival(
    scenes: _Scenes, state: FloatArray, d: FloatArray, longest: FloatArray, row: int, value: float
) -> tuple[FloatArray, FloatArray]:
    """Return the states where w (row 0) or u (row 1) comes to a value within a step, and the time to there."""
    part = longest
    for _ in range(_PLACES):
        after, _ = _step(scenes, state, d, part, 1.0)
        rates = scenes.rates(after, d, np.empty_like(after))
        place = part + (value - after[row]) / rates[row]
        move = np.clip(place, np.minimum(longest, 0), np.maximum(longest, 0)) - part
        part, after = part + move, after + move * rates
        if not (np.abs(move) > _THERE).any():
            break
    return after, part


def _step(
    scenes: _Scenes, state: FloatArray, d: FloatArray, h: FloatArray, rtol: float
) -> tuple[FloatArray, FloatArray]:
    """Return the state after a step, and the step's error over the tolerance: infinite where there is no value."""
    after, estimates = take_step(lambda moved, into: scenes.rates(moved, d, into), state, h)
    size = rtol * (_SMALL + np.maximum(np.abs(state[:2]), np.abs(after[:2])))
    error = error_of(estimates[:, :2], size, h)
    return after, np.where(np.isfinite(after).all(axis=0) & np.isfinite(error), error, np.inf)

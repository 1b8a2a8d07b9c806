"""Slip orbits of strong friction, by shooting: all scenes at once, each with steps of its own.

With w = 1 - x'/V, u = w' and time in 1/omega an orbit obeys

    w' = u,    u' = (g - d) u + 1 - w,    g = -N mu'(V w)/sqrt(k m),    d = c/sqrt(k m).

From its lowest slip speed, w = 1 - A and u = 0, it is followed to the next one, w = 1 - a; where it meets the
belt's speed before, a = 1 + u^2/2. Damping rotates the field of directions one way, so a falls with d, and the
growth log(a/A), a straight line for weak friction, has one root. Its slope follows along: a small deviation across
the orbit obeys M' = (g - d) M + u^2, and -da/dd is M/u' at the end, or M at the belt's speed. The steps are those
of DOP853, the explicit Runge-Kutta method of order 8.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.integrate import DOP853

from stickslip_sym.core.aliases import FloatArray, Rows
from stickslip_sym.core.deadline import check_time
from stickslip_sym.motion.orbits.expansion import Slope

__all__ = ["Shots", "shoot"]

_A, _B = np.array(DOP853.A), np.array(DOP853.B)
_ERRORS = np.array(DOP853.E5[:-1]), np.array(DOP853.E3[:-1])  # the rates at the end of a step have no share
_EXPONENT = -1 / (DOP853.error_estimator_order + 1)
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 5.0
_FIRST, _LONGEST = 1e-4, 0.25  # steps, in 1/omega; at the longest one no extremum of w is passed over
_STAGES = ((1e-5, 3e-2), (1e-9, 1e-4), (1e-13, 1e-10))
"""Tolerances of a step, one after another on the way to the root, and for each the log(a/A) at which the next one
is taken: Newton's method squares it."""
_LEFT = 1e-3  # of the last change of d, which the last tolerance makes: errors go as the tolerance, 1e-4 here
_ROUNDING = 1e-14  # of d, as a part of the largest slope
_TINY = 1e-30  # error of a step, below which it is none
_SMALL = 0.01  # components of the state below count as that large
_NEAREST = 1e-12  # slip speed over belt speed that mu is asked for; a try may overshoot the belt
_MOST_STEPS = 4000  # of one transit
_MOST_TRIES = 60  # dampings
_CREEPS = 40.0  # time after which an orbit that has not turned creeps to rest
_SHORTEST = 1e-12  # step, in 1/omega, below which mu is too rough
_FIRST_REACH = 0.05  # relative change of d that is tried where Newton's method does not help; doubled each time
_PLACES = 5  # Newton steps to the time at which w has its minimum


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
class _Transit:
    """From one lowest slip speed to the next."""

    growth: FloatArray  # log(a/A); minus infinity where the mass creeps to rest
    slope: FloatArray  # of the growth, over d
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

    def g(self, w: FloatArray) -> FloatArray:
        return -self.strength * self.slope(self.V * np.maximum(w, _NEAREST))

    def rates(self, state: FloatArray, d: FloatArray) -> FloatArray:
        w, u, across, _ = state
        g = self.g(w)
        return np.array([u, (g - d) * u + 1 - w, (g - d) * across + u * u, g])


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
        transit = _transit(scenes.rows(active), now, tolerance)
        step = -transit.growth / transit.slope
        low[active] = np.where(transit.growth > 0, now, low[active])
        high[active] = np.where(transit.growth <= 0, now, high[active])
        done = (np.abs(transit.growth) <= settled) | (np.abs(step) <= _ROUNDING * transit.scale)
        slow = np.abs(transit.growth) > before[active] / 2  # Newton's method does not help
        before[active] = np.abs(transit.growth)
        safe = _within(now, np.where(slow, np.nan, step), low[active], high[active], reach[active])
        ahead = np.where(done, now + step, safe)
        reach[active] *= 2
        found.d[active] = ahead
        found.error[active] = _LEFT * np.abs(step) + _ROUNDING * transit.scale
        found.period[active] = transit.period
        found.exponent[active] = transit.gathered / transit.period - ahead
        found.highest[active] = transit.highest
        found.scale[active] = transit.scale
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


def _transit(scenes: _Scenes, d: FloatArray, rtol: float) -> _Transit:
    count = len(d)
    state = np.zeros((4, count))
    state[0] = 1 - scenes.A
    time, length = np.zeros(count), np.full(count, _FIRST)
    scale = np.abs(scenes.g(state[0]))
    crest, before_crest = state.copy(), np.zeros(count)  # the states before the highest w, and the step to it
    turns, meets, creeps = np.zeros((3, count), dtype=bool)
    active = np.arange(count)
    for _ in range(_MOST_STEPS):
        some, before, h = scenes.rows(active), state[:, active], length[active]
        after, error = _step(some, before, d[active], h, rtol)
        sound = error < 1
        factor = np.clip(_SAFETY * np.maximum(error, _TINY) ** _EXPONENT, _LEAST, np.where(sound, _MOST, 1.0))
        turns[active] = sound & (before[1] < 0) & (after[1] >= 0)
        meets[active] = sound & (before[0] > 0) & (after[0] <= 0) & ~turns[active]
        ended = turns[active] | meets[active]  # within this step
        passes = sound & (before[1] >= 0) & (after[1] < 0)
        crest[:, active[passes]], before_crest[active[passes]] = before[:, passes], h[passes]
        length[active] = np.where(ended, h, np.minimum(h * factor, _LONGEST))
        on = sound & ~ended
        kept = active[on]
        state[:, kept] = after[:, on]
        time[kept] += h[on]
        scale[kept] = np.maximum(scale[kept], np.abs(some.g(after[0]))[on])
        creeps[kept] = time[kept] > _CREEPS
        active = active[~ended & ~creeps[active] & (length[active] > _SHORTEST)]
        if not active.size:
            break
    highest, _ = _arrival(scenes, crest, d, before_crest, rtol, 1)
    growth, slope = np.where(creeps, -np.inf, np.nan), np.full(count, np.nan)
    for chosen, row in ((turns, 1), (meets, 0)):
        rows = np.flatnonzero(chosen)
        some = scenes.rows(rows)
        state[:, rows], part = _arrival(some, state[:, rows], d[rows], length[rows], rtol, row)
        w, u, across, _ = state[:, rows]
        time[rows] += part
        height, steep = (1 - w, some.rates(state[:, rows], d[rows])[1]) if row else (1 + u * u / 2, 1.0)
        growth[rows], slope[rows] = np.log(height / some.A), -across / steep / height
    return _Transit(growth, slope, time, state[3], highest[0], scale)


def _arrival(
    scenes: _Scenes, state: FloatArray, d: FloatArray, longest: FloatArray, rtol: float, row: int
) -> tuple[FloatArray, FloatArray]:
    """Return the states where w (row 0) or u (row 1) comes to 0 within a step, and the time to there."""
    part = longest
    for _ in range(_PLACES):
        after, _ = _step(scenes, state, d, part, rtol)
        part = np.clip(part - after[row] / scenes.rates(after, d)[row], 0, longest)
    return _step(scenes, state, d, part, rtol)[0], part


def _step(
    scenes: _Scenes, state: FloatArray, d: FloatArray, h: FloatArray, rtol: float
) -> tuple[FloatArray, FloatArray]:
    """Return the state after a step, and the step's error over the tolerance: infinite where there is no value."""
    rates = np.empty((12, *state.shape))
    flat = rates.reshape(12, -1)
    for stage in range(12):
        moved = state + h * (_A[stage, :stage] @ flat[:stage]).reshape(state.shape) if stage else state
        rates[stage] = scenes.rates(moved, d)
    after = state + h * (_B @ flat).reshape(state.shape)
    size = rtol * (_SMALL + np.maximum(np.abs(state[:2]), np.abs(after[:2])))
    fifth, third = ((((row @ flat).reshape(state.shape)[:2] / size) ** 2).sum(axis=0) for row in _ERRORS)
    both = fifth + 0.01 * third
    error = np.where(both > 0, h * fifth / np.sqrt(2 * np.where(both > 0, both, 1.0)), 0.0)
    return after, np.where(np.isfinite(after).all(axis=0) & np.isfinite(error), error, np.inf)

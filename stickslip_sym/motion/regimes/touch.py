"""The pure-slip thresholds of many oscillators at once: orbits that touch the belt's speed, from both their ends.

At the threshold the slip from P comes back to touch the belt's speed. So where the mass stands still, w = 1, on
its way there it meets the orbit that leads to the touch, which is followed backward in time. Let q_f and q_b be
the displacements from rest of both. Damping brings the one closer to rest, and the other further from it:

    F(zeta) = (q_f - q_b)/(q_f + q_b)

falls all the way, for weak friction at the rate pi, and has one root. No part ends near the belt's speed, so F is
smooth too where mu has a thin layer there, in which returns bend; and friction that grows with the slip speed
is followed forward, where it damps.
"""

from dataclasses import replace

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.motion.regimes.rounds import CREEPS, RETURN, Family, arrive

__all__ = ["touching_dampings"]

_COARSE, _TIGHT = 1e-6, 1e-11  # tolerances of the steps
_NEAR = 1e-3  # F, from which on the tight tolerance is taken
_DONE = 1e-9  # F after which the next secant is the last one
_MOST_SECANTS = 16
_FALL = -np.pi  # of F with zeta, where friction is weak
_FARTHEST = 0.3  # that a damping ratio is moved at once
_OFF = 100  # tolerances by which F may be off, besides twice what one that is ten times looser changes


def touching_dampings(family: Family, guess: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the damping ratios of the orbits from P that touch the belt's speed, and their errors.

    - `guess`: of the ratios.

    A ratio may be negative; it is NaN where it was not found.
    """
    zeta, found_at = guess.copy(), np.full(len(guess), np.nan)
    slope = np.full(len(guess), _FALL)
    low, high = np.full((2, len(guess)), [[-np.inf], [np.inf]])
    before, gap = np.full((2, len(guess)), np.nan)
    tolerance = np.full(len(guess), _COARSE)
    active = np.flatnonzero(np.isfinite(guess))
    for _ in range(_MOST_SECANTS):
        now = zeta[active]
        found = _gap(family.rows(active), now, tolerance[active])
        with np.errstate(all="ignore"):  # there may be no secant
            secant = (found - gap[active]) / (now - before[active])
        slope[active] = np.where(secant < 0, secant, slope[active])
        low[active] = np.where(found > 0, now, low[active])
        high[active] = np.where(found <= 0, now, high[active])
        before[active], gap[active] = now, found
        step = np.clip(-found / slope[active], -_FARTHEST, _FARTHEST)
        ahead = now + step
        inside = (ahead > low[active]) & (ahead < high[active])
        done = (tolerance[active] == _TIGHT) & (np.abs(found) <= _DONE)
        bracketed = ~inside & ~done & np.isfinite(low[active]) & np.isfinite(high[active])
        middle = np.where(bracketed, low[active], 0.0) / 2 + np.where(bracketed, high[active], 0.0) / 2
        zeta[active] = np.where(bracketed, middle, ahead)
        found_at[active[done]] = now[done]
        tightened = (np.abs(found) <= _NEAR) & (tolerance[active] != _TIGHT)
        # What a tighter tolerance moves the root by may lie outside a bracket of looser ones.
        low[active], high[active] = (
            np.where(tightened, far, side[active]) for far, side in ((-np.inf, low), (np.inf, high))
        )
        tolerance[active] = np.where(tightened, _TIGHT, tolerance[active])
        active = active[~done & np.isfinite(found)]
        if not active.size:
            break
    rows = np.flatnonzero(np.isfinite(found_at))
    error = np.full(len(guess), np.nan)
    loose = _gap(family.rows(rows), found_at[rows], np.full(rows.size, 10 * _TIGHT))
    error[rows] = (2 * np.abs(loose - gap[rows]) + _OFF * _TIGHT) / -slope[rows]
    return np.where(np.isfinite(error), zeta, np.nan), error


def _gap(family: Family, zeta: FloatArray, rtol: FloatArray) -> FloatArray:
    """Return F."""
    count = len(zeta)
    both = family.rows(np.tile(np.arange(count), 2))
    way = np.repeat([-1, 1], count)  # in which w passes 1: forward it falls, backward it rises
    both = replace(both, eta=-way * both.eta)
    damping = -way * np.tile(zeta, 2)
    q = np.where(way < 0, 0.0, -both.eta * (both.static - both.onset))  # at the touch w' = 0
    found = arrive(both, damping, q, np.zeros(2 * count), np.tile(rtol, 2), way)
    one = np.ones(2 * count)
    rest = 2 * damping - both.friction(one, both.piece(one))
    away = np.select([found.end == RETURN, found.end == CREEPS], [way * (found.q - rest), 0.0], np.nan)
    forward, back = away[:count], away[count:]
    with np.errstate(invalid="ignore"):  # both may creep to rest
        return np.asarray((forward - back) / (forward + back))

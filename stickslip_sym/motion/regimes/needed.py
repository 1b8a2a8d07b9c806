"""The damping that slip orbits need, for laws that are not smooth: against which of some dampings it is more.

`cycles` interpolates d(A), the damping at which the orbit of amplitude A V is periodic, by polynomials, which
takes a smooth law. Here d is found by secants at some amplitudes, and to no more digits than tell on which side of
every damping that is asked about it lies. A damping has a cycle between two amplitudes where it lies between the d
of both.
"""

import math
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.motion.simulation.levels import Levels

__all__ = ["NODES", "NeededAtNodes", "needed_at_nodes"]

_NEAREST = 1e-3  # lowest amplitude that is looked at: a smaller cycle is not seen
NODES = sorted(
    {float(A) for A in _NEAREST + (1 - _NEAREST) * (1 - np.cos(np.linspace(0.0, math.pi, 33))) / 2}
    | {1 - 10.0**-decade for decade in range(3, 7)}
)
"""Amplitudes over the belt's speed; graded towards the belt's speed, where laws are steep."""
_RTOL = 1e-7  # of integrations
_MOST_SECANTS = 8
_STRAIGHT = 0.1  # of a ratio, over which a secant is trusted at all
_AHEAD = 2.0  # times the last distance of amplitudes, over which they are extrapolated: errors grow by as much
_FARTHEST = 0.2  # that a damping ratio is moved at once
_DOUBT = 0.5  # of a secant, which it may be off by
_LEAST = 1e-7  # of a damping ratio, below which integrations say nothing of it; over the amplitude
_FOLD = 3.0  # times what a parabola rises above three nodes, by which a fold may be higher than the middle one


@dataclass(frozen=True)
class NeededAtNodes:
    """Damping ratios that orbits of ascending amplitudes need, the first at rest, and how far each may be off."""

    zeta: FloatArray
    error: FloatArray
    folds: FloatArray
    """For each inner node how far beyond it d may turn: 0 where neighbours lie on both sides of it."""

    def undecided(self, zeta: FloatArray) -> BoolArray:
        """Tell for which damping ratios the number of orbits is not known."""
        off = zeta[:, None] - self.zeta
        beyond = off / np.where(self.folds == 0, np.nan, self.folds)
        unknown: BoolArray = (np.abs(off) <= self.error) | ((beyond >= 0) & (beyond <= 1))
        return np.asarray(unknown.any(axis=1))


def needed_at_nodes(levels: Levels, at_rest: float, zeta: FloatArray, graze: float) -> NeededAtNodes | None:
    """Return the damping ratios that orbits need; None if some orbit takes other ways than `Levels`.

    - `at_rest`: that of the orbits that begin beside the equilibrium.
    - `zeta`: those from which they are to be told.
    - `graze`: about that of the orbit of the belt's speed.
    """
    found: list[tuple[float, float]] = []
    guess, fall = graze, -2 * math.pi  # of the peak, over the amplitude, with the damping ratio: weak friction's
    amplitudes: list[float] = []
    for A in reversed(NODES):
        if len(found) > 1:
            (one, _), (two, _) = found[-2:]
            ahead = (A - amplitudes[-1]) / (amplitudes[-1] - amplitudes[-2])
            guess = two + (two - one) * min(ahead, _AHEAD)
        node = _node(levels, A, guess, fall, zeta)
        if node is None:
            return None
        ratio, error, fall = node
        guess = ratio
        amplitudes.append(A)
        found.append((ratio, error))
    ratios, errors = np.array([(at_rest, 0.0), *reversed(found)]).T
    return NeededAtNodes(ratios, errors, _folds(np.array([0.0, *NODES]), ratios))


def _node(
    levels: Levels, A: float, guess: float, fall: float, zeta: FloatArray
) -> tuple[float, float, float] | None:
    """Return the damping ratio an orbit needs, its error, and the fall of its peak with the ratio, over A."""
    ratio, growth = guess, _growth(levels, A, guess)
    for _ in range(_MOST_SECANTS):
        if growth is None:
            return None
        step = -growth / fall
        error = _DOUBT * abs(step) + _LEAST / A
        clear = abs(step) <= _STRAIGHT * max(abs(ratio), _STRAIGHT)
        clear = clear and not (np.abs(zeta - (ratio + step)) <= error).any()
        if clear or abs(step) <= _LEAST / A:
            return ratio + step, error, fall
        ahead = ratio + max(min(step, _FARTHEST), -_FARTHEST)
        after = _growth(levels, A, ahead)
        if after is None or not (after - growth) * (ahead - ratio) < 0:
            return None
        fall = (after - growth) / (ahead - ratio)
        ratio, growth = ahead, after
    return None


def _growth(levels: Levels, A: float, zeta: float) -> float | None:
    """Return by how much the next peak of an orbit is higher, over its amplitude."""
    peak = levels.next_peak(zeta, A, _RTOL)
    return None if peak is None else peak / A - 1


def _folds(amplitudes: FloatArray, ratios: FloatArray) -> FloatArray:
    """Return how far beyond each node the parabola through it and its neighbours turns."""
    before, after = np.diff(amplitudes)[:-1], np.diff(amplitudes)[1:]
    left, right = np.diff(ratios)[:-1], np.diff(ratios)[1:]
    bend = (right / after - left / before) / (before + after)
    slope = (right / after * before + left / before * after) / (before + after)
    turned = left * right < 0
    beyond = np.zeros(ratios.shape)
    with np.errstate(all="ignore"):
        beyond[1:-1] = np.where(turned, -_FOLD * slope**2 / (4 * bend), 0.0)
    return beyond

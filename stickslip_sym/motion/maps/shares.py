"""Initial conditions by the separatrices that surround them; none is simulated.

What begins outside all separatrices comes to stick, or goes round without sticking as P's orbit does, which lies
outside them too: so does what begins faster than the belt, since it can only come down where the mass sticks, or
further out.
"""

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.regimes.regime import Regime, separatrices_of
from stickslip_sym.motion.regimes.separatrix import SlipCurve

__all__ = ["FINEST", "Share", "counted_shares", "motions_by_side", "shares_by_area"]

FINEST = 1e-12
"""The relative tolerance of separatrices: they are few, and decide about many initial conditions."""

_NEAR = 100  # tolerances: initial conditions closer to a separatrix are simulated
_COARSE = 1e-10  # tolerance at which the areas are measured again, for their error


@dataclass(frozen=True)
class Share:
    """A part of a box of initial conditions.

    Attributes
    ----------
    value : float
        From 0 to 1.
    error : float
        Estimated: from the same areas at a wider tolerance, or the standard error of a share that was counted.
    counted : bool
        Whether it is the share of the initial conditions, as where geometry does not settle the basins.
    """

    value: float
    error: float
    counted: bool = False

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        return f"{self.value:.10g} +- {self.error:.1g}{', counted' if self.counted else ''}"


def motions_by_side(found: Regime, x0: FloatArray, v0: FloatArray) -> IntArray:
    """Return the places in `MOTIONS` of what initial conditions lead to, a row for each v0.

    They are -1 near a separatrix, and where separatrices do not settle the basins.

    - `found`: at the tolerance `FINEST`.
    """
    if found.basins is None:
        return np.full((v0.size, x0.size), -1)
    q, w = _displacement(found, x0), 1 - v0 / found.oscillator.V
    around = np.zeros((w.size, q.size), dtype=np.intp)
    near = np.zeros(around.shape, dtype=bool)
    for separatrix in found.separatrices:
        rows, places = separatrix.curve.crossings(np.where(w > 0, w, -1.0))
        passed = np.zeros((w.size, q.size + 1), dtype=np.intp)
        np.add.at(passed, (rows, np.searchsorted(q, places)), 1)
        around += np.cumsum(passed, axis=1)[:, :-1] % 2
        margin = _NEAR * FINEST * (1 + np.abs(places))
        first, behind = np.searchsorted(q, places - margin), np.searchsorted(q, places + margin, side="right")
        for close in np.flatnonzero(behind > first):
            near[rows[close], first[close] : behind[close]] = True
    from_outside = np.array([MOTIONS.index(motion) for motion in reversed(found.basins)], dtype=np.intp)
    return np.where(near, -1, from_outside[around])


def shares_by_area(found: Regime, x0: tuple[float, float], v0: tuple[float, float]) -> dict[Motion, Share]:
    """Return the shares of a box of initial conditions, by the areas inside the separatrices.

    They are empty where separatrices do not settle the basins.
    """
    if found.basins is None:
        return {}
    unstable = [one.amplitude for one in found.cycles if not one.stable and one.amplitude <= found.oscillator.V]
    grazes = any(separatrix.kind == "graze" for separatrix in found.separatrices)
    best, coarse = (
        _areas(found, [separatrix.curve for separatrix in separatrices], x0, v0)
        for separatrices in (
            found.separatrices,
            separatrices_of(found.law, found.oscillator, unstable, grazes, _COARSE) if found.separatrices else (),
        )
    )
    return {motion: Share(value, abs(value - coarse[motion]) + math.ulp(1.0)) for motion, value in best.items()}


def _areas(
    found: Regime, curves: list[SlipCurve], x0: tuple[float, float], v0: tuple[float, float]
) -> dict[Motion, float]:
    assert found.basins is not None
    V = found.oscillator.V
    q, w = _displacement(found, np.array(x0)), np.clip(1 - np.array(v0[::-1]) / V, 0.0, None)
    whole = float(q[1] - q[0]) * (v0[1] - v0[0]) / V
    inside = [0.0, *(curve.area_within(q, w) for curve in curves), whole]
    shares = dict.fromkeys(found.basins, 0.0)
    for motion, (low, high) in zip(found.basins, pairwise(inside), strict=True):
        shares[motion] += (high - low) / whole
    return shares


def _displacement(found: Regime, x: FloatArray) -> FloatArray:
    """Return displacements q from P, free of units."""
    return (x - found.oscillator.onset(found.law)) / found.oscillator.length


def counted_shares(index: IntArray) -> dict[Motion, Share]:
    """Return the shares among initial conditions, given by their places in `MOTIONS`, with standard errors."""
    parts = np.bincount(index.ravel(), minlength=len(MOTIONS)) / index.size
    return {
        motion: Share(part, math.sqrt(part * (1 - part) / index.size), counted=True)
        for motion, part in zip(MOTIONS, parts.tolist(), strict=True)
        if part
    }

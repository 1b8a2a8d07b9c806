"""The share of a box of starts that each motion draws: basin stability, by areas rather than samples."""

import math
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.types import FloatArray, IntArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.cells import MOTIONS
from stickslip_sym.motion.maps.sides import sides_of
from stickslip_sym.motion.regimes.attractors import Regime
from stickslip_sym.motion.regimes.classification import Motion

__all__ = ["Share", "counted_shares", "shares_of"]

_COARSER = 100  # times the tolerance, at which the areas are measured again for their error
_FINEST = 1e-12  # tolerance of the separatrices whose areas are measured


@dataclass(frozen=True)
class Share:
    """A part of a box of starts.

    Attributes
    ----------
    value : float
        From 0 to 1.
    error : float
        Estimated: from the same areas at a wider tolerance, or the standard error of a share that was counted.
    counted : bool
        Whether it is the share of the starts, as where geometry does not settle the basins.
    """

    value: float
    error: float
    counted: bool = False

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        return f"{self.value:.10g} +- {self.error:.1g}{', counted' if self.counted else ''}"


def shares_of(
    law: FrictionLaw, osc: Oscillator, found: Regime, x0: FloatArray, v0: FloatArray, *, rtol: float
) -> dict[Motion, Share] | None:
    """Return the shares of the box from the first x0 and v0 to the last; None where areas are not known."""
    box = (float(x0[0]), float(x0[-1])), (float(v0[0]), float(v0[-1]))
    fine = min(rtol, _FINEST)
    measured = [
        sides.shares(*box)
        for tolerance in (fine, _COARSER * fine)
        if (sides := sides_of(law, osc, found, rtol=tolerance)) is not None and min(x0.size, v0.size) > 1
    ]
    if len(measured) < 2:
        return None
    best, other = measured
    return {motion: Share(value, _error(value, other.get(motion, 0.0))) for motion, value in best.items()}


def counted_shares(index: IntArray) -> dict[Motion, Share]:
    """Return the shares among starts, given by their places in `MOTIONS`, with their standard errors."""
    parts = np.bincount(index.ravel(), minlength=len(MOTIONS)) / index.size
    return {
        motion: Share(part, math.sqrt(part * (1 - part) / index.size), counted=True)
        for motion, part in zip(MOTIONS, parts.tolist(), strict=True)
        if part
    }


def _error(value: float, other: float) -> float:
    return abs(value - other) + math.ulp(1.0)

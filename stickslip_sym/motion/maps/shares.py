"""The share of a box of starts that each motion draws: basin stability, by areas rather than samples."""

import math
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import IntArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.cells import MOTIONS
from stickslip_sym.motion.maps.sides import Sides, sides_of
from stickslip_sym.motion.regimes.attractors import Regime
from stickslip_sym.motion.regimes.classification import Motion

__all__ = ["Share", "counted_shares", "shares_of"]

_COARSE = 1e-10  # tolerance at which the areas are measured again, for their error


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
    law: FrictionLaw,
    osc: Oscillator,
    found: Regime,
    sides: Sides,
    x0: tuple[float, float],
    v0: tuple[float, float],
) -> dict[Motion, Share]:
    """Return the shares of a box of starts, by areas."""
    best = sides.shares(x0, v0)
    again = sides_of(law, osc, found, rtol=_COARSE) if sides.boundaries else sides
    other = {} if again is None else again.shares(x0, v0)
    return {
        motion: Share(value, abs(value - other.get(motion, 0.0)) + math.ulp(1.0)) for motion, value in best.items()
    }


def counted_shares(index: IntArray) -> dict[Motion, Share]:
    """Return the shares among starts, given by their places in `MOTIONS`, with their standard errors."""
    parts = np.bincount(index.ravel(), minlength=len(MOTIONS)) / index.size
    return {
        motion: Share(part, math.sqrt(part * (1 - part) / index.size), counted=True)
        for motion, part in zip(MOTIONS, parts.tolist(), strict=True)
        if part
    }

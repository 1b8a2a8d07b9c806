"""What is known of the cells of a map: their attractors, where a start leads, and how each was decided."""

from dataclasses import dataclass, field
from enum import Enum, IntFlag

from stickslip_sym.core.errors import OutOfTime, StickSlipError
from stickslip_sym.motion.regimes.classification import Motion

__all__ = ["CURVES", "MOTIONS", "REASONS", "Attractor", "Cells", "Reason"]


MOTIONS = tuple(Motion)
CURVES = ("equilibrium", "least_squares", "exact")
"""The thresholds of a scene."""


class Attractor(IntFlag):
    """A motion that others come to; a cell holds any number of them."""

    STICK_SLIP = 1
    REST = 2
    PURE_SLIP = 4


class Reason(Enum):
    """How a cell was decided."""

    ABOVE = "above every threshold and fold"
    BELOW = "below every threshold and fold"
    BETWEEN = "between thresholds or folds: by the damping that slip orbits need"
    ALONG = "beyond a simulated cell of the same line from which on there is no slip cycle"
    SIMULATED = "simulated"
    TOLERANCE = "within tolerance of a threshold or a fold"
    FAILED = "failed"
    TIME = "time limit"


REASONS = tuple(Reason)


@dataclass
class Cells:
    """What is known of the cells of one scene, one for each damping."""

    motion: list[int]  # places in `MOTIONS`
    attractors: list[int]  # values of `Attractor`
    reason: list[int]  # places in `REASONS`
    equilibrium: float | None = None
    least_squares: float | None = None
    exact: float | None = None  # all three in kg/s, as `MotionMap` has them; None where one was not found
    notes: dict[int, str] = field(default_factory=dict)  # of cells that failed or stayed undecided: why

    @classmethod
    def failed(cls, count: int, error: StickSlipError) -> "Cells":
        """Return cells of which no more is known than why."""
        kind = Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED
        motion, reason = MOTIONS.index(Motion.UNDECIDED), REASONS.index(kind)
        return cls([motion] * count, [0] * count, [reason] * count, notes=dict.fromkeys(range(count), str(error)))

"""`Motion`: what a motion is."""

from enum import Enum


class Motion(Enum):
    """What a mass does, in the end (`classify`, maps) or so far (`simulate`).

    Rest is steady sliding: the mass stands still while the belt slides on below it.
    """

    STICK_SLIP = "stick-slip"
    PURE_SLIP = "pure slip"
    REST = "rest"
    UNBOUNDED = "grows without bound"
    STICK = "stick, nothing else so far"
    OVERTAKING = "slip that overtakes the belt"
    SHRINKING = "slip that shrinks"
    GROWING = "slip that grows"
    UNDECIDED = "undecided"
    """Within the tolerance of a boundary, or too short to tell."""

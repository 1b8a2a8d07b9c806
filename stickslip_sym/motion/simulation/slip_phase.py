"""`SlipPhase`: the course of one slip phase, whatever integrated it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.core.deadline import check_time, time_left
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.steppers import Piece, Point

__all__ = ["RUNAWAY", "SlipPhase", "attracted_to_rest", "exhausted", "passage", "root"]

RUNAWAY = 1e100  # times the units of the state
_CLOSE = 10  # times the tolerance of a step: nearer to a rest the errors of steps do not let the mass come


@dataclass
class SlipPhase:
    """The course of one slip phase.

    Attributes
    ----------
    side : int
        1 where the mass is slower than the belt, -1 where it is faster.
    end : str
        "return": w came down to 0; "minimum": w turned before; "rest": the mass came to rest, within the
        tolerance; "horizon": the time was over; "steps", "deadline": the bounds on the work were reached;
        "unbounded": the motion grew beyond all bounds; "undefined": it came to where mu has no value.
    last : Point
        The state at the end.
    extrema : list of Point
        The maxima and minima of w, in order.
    pieces : list of Piece
        Interpolants of (q, w), one a step.
    error : StickSlipError or None
        Why mu has no value where the phase ended.
    """

    side: int
    end: str
    last: Point
    extrema: list[Point] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)
    error: StickSlipError | None = None

    @property
    def points(self) -> list[Point]:
        """The states at the ends of the steps, from the beginning of the phase to its end."""
        return [*(piece.start for piece in self.pieces), self.last]

    def at(self, tau: Any) -> Any:
        """Return the rows q and w at times within the phase."""
        tau = np.asarray(tau, dtype=np.float64)
        index = np.searchsorted([piece.start.tau for piece in self.pieces[1:]], tau, side="right")
        result = np.empty((2, *tau.shape))
        result[0], result[1] = self.last.q, self.last.w  # all there is of a phase without steps
        for i in np.unique(index) if self.pieces else ():
            chosen = index == i
            result[:, chosen] = self.pieces[i](tau[chosen])
        return result

    def crossings(self, level: float) -> list[Point]:
        """Return the points where w comes to a level or passes it between the ends of two steps."""
        found = []
        for piece, (before, after) in zip(self.pieces, pairwise(self.points), strict=True):
            if after.w == level:  # as where mu has a kink there
                found.append(after)
            elif (before.w - level) * (after.w - level) < 0:
                tau = passage(piece, level, before.tau, after.tau)
                found.append(Point(tau, *map(float, piece(tau))))
        return found


def exhausted(phase: SlipPhase, max_steps: int | None, deadline: float) -> str | None:
    """Return which bound on the work is reached, as `SlipPhase.end` has it; None if there is some left.

    Raises
    ------
    OutOfTime
        Without `max_steps`, when the time of a `time_limit` is up; with it the phase ends then as at its deadline.
    """
    if max_steps is None:
        check_time()
    elif len(phase.pieces) >= max_steps:
        return "steps"
    elif time_left() < 0:
        return "deadline"
    return "deadline" if time.monotonic() > deadline else None


def attracted_to_rest(scene: Scene, side: int, rtol: float) -> Callable[[Point], bool]:
    """Return the function that tells whether a state is at the rest that attracts it, within the tolerance."""
    if side < 0 or not scene.decay(1.0) > 0:
        return lambda now: False
    q, w = scene.rest
    close = _CLOSE * rtol
    return lambda now: abs(now.w - w) <= close and abs(now.q - q) <= close * max(1.0, abs(q))


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a function that changes its sign between two places."""
    return float(brentq(function, low, high))


def passage(piece: Piece, level: float, low: float, high: float) -> float:
    """Return when w passes a level between two times of a step."""
    return root(lambda tau: float(piece(tau)[1]) - level, low, high)

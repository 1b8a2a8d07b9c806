"""`SlipPhase`: the course of one slip phase, whatever integrated it."""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import cached_property
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.steppers import Interpolant, Point

__all__ = ["REST_WITHIN", "RUNAWAY", "End", "SlipPhase", "Until", "attracted_to_rest", "passage", "root"]

RUNAWAY = 1e100  # times the units of the state
REST_WITHIN = 10  # times the tolerance of a step: nearer to a rest the errors of steps do not let the mass come


class End(Enum):
    """How a slip phase ended."""

    RETURN = auto()
    """w came down to 0."""
    MINIMUM = auto()
    """w turned before. An orbit that left P then never returns, since orbits in a plane do not cross."""
    REST = auto()
    """The mass came to rest, within the tolerance."""
    HORIZON = auto()
    """The time was over."""
    STEPS = auto()
    """The bound on the steps was reached."""
    DEADLINE = auto()
    """The bound on the time of computation was reached."""
    UNBOUNDED = auto()
    """The motion grew beyond all bounds."""
    UNDEFINED = auto()
    """The motion came to where mu has no value."""


Until = Literal[End.RETURN, End.MINIMUM]


@dataclass
class SlipPhase:
    """The course of one slip phase."""

    side: int  # 1 where the mass is slower than the belt, -1 where it is faster
    last: Point  # the state at the end
    end: End = End.HORIZON
    extrema: list[Point] = field(default_factory=list)  # the maxima and minima of w, in order
    interpolants: list[Interpolant] = field(default_factory=list)  # of (q, w), one a step
    error: StickSlipError | None = None  # why mu has no value where the phase ended

    @property
    def points(self) -> list[Point]:
        """The states at the ends of the steps, from the beginning of the phase to its end."""
        return [*(interpolant.start for interpolant in self.interpolants), self.last]

    @property
    def start(self) -> Point:
        """The state at the beginning."""
        return self.interpolants[0].start if self.interpolants else self.last

    @cached_property
    def states(self) -> FloatArray:
        """The rows tau, q and w at the ends of the steps, once the phase is over."""
        return np.array([(point.tau, point.q, point.w) for point in self.points]).T

    def turns(self, extremum: Point, rising: bool, until: Until) -> bool:
        """Note an extremum of w after which it rises or falls, and return whether the phase ends there."""
        self.extrema.append(extremum)
        if rising and until is End.MINIMUM:
            self.end, self.last = End.MINIMUM, extremum
        return self.end is End.MINIMUM

    def at(self, tau: ArrayLike) -> FloatArray:
        """Return the rows q and w at times within the phase."""
        tau = np.asarray(tau, dtype=np.float64)
        index = np.searchsorted(
            [interpolant.start.tau for interpolant in self.interpolants[1:]], tau, side="right"
        )
        result = np.empty((2, *tau.shape))
        result[0], result[1] = self.last.q, self.last.w  # all there is of a phase without steps
        for i in np.unique(index) if self.interpolants else ():
            chosen = index == i
            result[:, chosen] = self.interpolants[i](tau[chosen])
        return result

    def crossings(self, level: float) -> list[Point]:
        """Return the points where w comes to a level or passes it between the ends of two steps."""
        found = []
        for interpolant, (before, after) in zip(self.interpolants, pairwise(self.points), strict=True):
            if after.w == level:  # as where mu has a kink there
                found.append(after)
            elif (before.w - level) * (after.w - level) < 0:
                tau = passage(interpolant, level, before.tau, after.tau)
                found.append(Point(tau, *map(float, interpolant(tau))))
        return found


def attracted_to_rest(scene: Scene, side: int, rtol: float) -> Callable[[Point], bool]:
    """Return the function that tells whether a state is at the rest that attracts it, within the tolerance."""
    if side < 0 or not scene.decay(1.0) > 0:
        return lambda now: False
    q, w = scene.rest
    close = REST_WITHIN * rtol
    return lambda now: abs(now.w - w) <= close and abs(now.q - q) <= close * max(1.0, abs(q))


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a function that changes its sign between two places."""
    return float(brentq(function, low, high))


def passage(interpolant: Interpolant, level: float, low: float, high: float) -> float:
    """Return when w passes a level between two times of a step."""

    def height(tau: float) -> float:
        return float(interpolant(tau)[1]) - level

    ends = height(low), height(high)
    if ends[0] * ends[1] >= 0:  # at an end the interpolant is off by rounding, which may be the larger one
        return low if abs(ends[0]) < abs(ends[1]) else high
    return root(height, low, high)

"""The data of slips: the forces, the law on a segment, states and steps, and why a slip ended."""

from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.model.table import RISE_RTOL, Pieces, Rise
from stickslip_sym.motion.compiled import compilable


class SlipEnd(IntEnum):
    """Why a slip ended."""

    OPEN = -1  # it did not
    RETURN = 0  # w came down to 0, where the mass sticks, or may not pass the belt's speed once more
    MINIMUM = 1  # w turned before; an orbit that left P then never returns, since orbits in a plane do not cross
    MAXIMUM = 2  # w turned down
    LEVEL = 3  # w came to the level asked for
    REST = 4  # the mass came to rest, within the tolerance
    HORIZON = 5  # the time was over
    STEPS = 6  # the bound on the steps was reached
    OUTSIDE = 7  # w came to where the table of the law ends
    FAILED = 8  # no step is short enough for the tolerance, or no number of them
    LATE = 9  # the time of a `time_limit` was up


class Field(NamedTuple):
    """The forces on one side of the belt's speed: w' = push + side q - damping w - eta rise(w).

    - `push`: eta (side mu_static - mu(0+)).
    - `damping`: 2 zeta.
    """

    eta: float
    push: float
    side: float
    damping: float


class Branch(NamedTuple):
    """The law on one of its smooth segments.

    - `pieces`: those of the rise.
    - `first`, `last`: numbers of the first and the last one of the segment.
    - `near`: the number of one that is likely to hold the next w.
    """

    pieces: Any
    first: int
    last: int
    near: int


class Wedge(NamedTuple):
    """The quantity p of a wedge D: dw'/dp = constant + linear w + factor rise(w) at a fixed state.

    - `pieces`: the polynomials of that rise.
    - `shifts`: db/dp of the level b at which each segment of the law begins.
    - `wanted`: whether D is computed at all.
    """

    constant: float
    linear: float
    factor: float
    pieces: Pieces
    shifts: Sequence[float] | FloatArray
    wanted: bool = True


@compilable
def no_wedge(rise: Rise) -> Wedge:
    """Return a wedge that is not computed."""
    return Wedge(0.0, 0.0, 0.0, rise.pieces, np.zeros(len(rise.jumps)), False)


class SlipState(NamedTuple):
    """A motion at one time tau: the displacement, the slip speed, its side and its rate w', and the wedge D."""

    tau: float
    q: float
    w: float
    side: float
    rate: float
    wedge: float


class Stop(NamedTuple):
    """Where a slip ends, besides where the mass sticks.

    - `until`: the number of one more `SlipEnd` at which it stops: a minimum, a maximum or a level of w.
    - `level`: of w, at which a step ends in any case.
    - `horizon`: tau at which to stop.
    - `most`: how many steps it may take.
    - `passes`: how often the mass may pass the belt's speed.
    - `longest`: the length of an explicit step, at most.
    """

    until: int
    level: float
    horizon: float
    most: int
    passes: int
    longest: float


class Extent(NamedTuple):
    """How far a slip went.

    - `taken`, `passed`: how many steps it took, and how often the mass passed the belt's speed.
    - `q_least` to `u_most`: extremes of q, and of u = side w, at the ends of its steps.
    """

    taken: int
    passed: int
    q_least: float
    q_most: float
    u_least: float
    u_most: float


class SlipStep(NamedTuple):
    """One step of a slip: its begin, its length in tau, and how it was taken.

    - `rate`: w' at the begin.
    - `segment`: number of the smooth segment of the law; -1 where the mass slides at a jump of mu.
    - `implicit`: by the method for fast decays.
    """

    tau: float
    q: float
    w: float
    rate: float
    length: float
    segment: int
    implicit: bool


class Run(NamedTuple):
    """A slip that was followed: why it ended, the state there, how far it went, its steps where recorded."""

    end: SlipEnd
    state: SlipState
    extent: Extent
    steps: list[SlipStep]


class Trial(NamedTuple):
    """A step that was tried: its length, q, w, w' and D at its end, and its error over the tolerance."""

    length: float
    q: float
    w: float
    rate: float
    wedge: float
    error: float


class Pace(NamedTuple):
    """What the steps so far say of the next one.

    - `implicit`: whether it is taken by the method for fast decays.
    - `held`: how many explicit steps in a row stability held short.
    - `length`: to be tried next.
    - `tried`: the length of the last one.
    - `bearable`: the longest step that the tolerance bears, by the last one that it accepted.
    - `again`: whether the last one is taken again, shorter.
    """

    implicit: bool
    held: int
    length: float
    tried: float
    bearable: float
    again: bool


TIGHT = 1e-12
"""The relative tolerance of the steps along which numbers are found that others follow from."""
PRECISE = RISE_RTOL
"""The relative error of a rise in its table, and the tolerance of steps where digits are wanted."""
ADDED = 100
"""Errors of a step that may add up along an orbit: within so many tolerances two states are one."""
MOST_STEPS = 60_000
"""Of a slip; the longest that end take some hundred."""
LONGEST_STEP = 0.25
"""Explicit: its stages meet whatever a table does not part; at twice that what it is off shows in thresholds."""
ACCURATE_STEP = 3.0
"""Times rtol^(1/8): the length of a step at which errors are of the size of the tolerance."""

"""One slip phase, followed by an engine from its onset to its end."""

import math
import time

from stickslip_sym.core.deadline import check_time, time_left
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.engines import ENGINES, Engine
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase, Until
from stickslip_sym.motion.simulation.steppers import Point

__all__ = ["follow"]


def follow(
    scene: Scene,
    start: Point,
    side: int,
    *,
    horizon: float,
    rtol: float,
    until: Until = End.RETURN,
    max_steps: int | None = None,
    deadline: float = math.inf,
    engine: Engine = ENGINES["scipy"],
) -> SlipPhase:
    """Integrate a slip phase from `start`.

    - `start`: with w >= 0; at w = 0 the phase is leaving, whatever rounding says of w'.
    - `side`: see `SlipPhase`.
    - `horizon`: time at which to stop in any case.
    - `rtol`: relative tolerance of a step.
    - `until`: `End.MINIMUM`: stop also at a minimum of w above 0.
    - `max_steps`: a number of steps after which the phase ends as it is, as it then does where mu has no value.
      Without it either is an error.
    - `deadline`: of `time.monotonic`, after which the phase ends as it is.
    - `engine`: what takes the steps.

    Raises `InputError` if mu cannot be computed at the start, or is measured up to a lower slip speed than the
      motion's, or the engine is not there or cannot take the law.
    Raises `NotConverged` when the number of steps runs out, or mu cannot be computed on the motion.
    Raises `OutOfTime` without `max_steps`, when the time of a `time_limit` is up; with it the phase ends then as
      at its deadline.
    """
    phase = SlipPhase(side, start)
    method = engine(scene, phase, horizon=horizon, rtol=rtol, until=until)
    while phase.end is End.HORIZON and phase.last.tau < horizon:
        if max_steps is None:
            check_time()
        elif len(phase.interpolants) >= max_steps:
            phase.end = End.STEPS
            break
        if (max_steps is not None and time_left() < 0) or time.monotonic() > deadline:
            phase.end = End.DEADLINE
            break
        method.check_work(bounded=max_steps is not None)
        try:
            method.advance()
        except StickSlipError as error:
            if max_steps is None:
                raise
            phase.end, phase.error = End.UNDEFINED, error
    return phase

"""Extrema of x and of the velocity, located when there are many of them: no motion waits for them."""

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.motion.ensemble.field import Field
from stickslip_sym.motion.ensemble.locating import level_passed, turn_located
from stickslip_sym.motion.ensemble.log import Log
from stickslip_sym.motion.ensemble.rows import Step

__all__ = ["Extrema"]

_MOST = 4000  # steps that wait, of 130 bytes each


class Extrema:
    """Steps with an extremum in them: of the velocity where w turns, of x where w passes 1."""

    def __init__(self, field: Field, log: Log) -> None:
        self.field, self.log = field, log
        self._turning: list[Step] = []
        self._passing: list[Step] = []
        self._waiting = 0

    def add(self, step: Step, turning: BoolArray, passing: BoolArray) -> None:
        """Take the steps in which w turns, and those in which it passes 1, to look at them later."""
        for chosen, steps in ((turning, self._turning), (passing, self._passing)):
            if chosen.any():
                some = step.taken(chosen)
                steps.append(some)
                self._waiting += some.h.size
        if self._waiting > _MOST:
            self.locate()

    def locate(self) -> None:
        """Locate all that wait."""
        if self._turning:
            step = Step.joined(self._turning)
            self.turns(step, turn_located(self.field, step).w)
        if self._passing:
            step = Step.joined(self._passing)
            self.passages(step, np.zeros(step.h.size), step.h, step.before.w < 1)
        self._turning, self._passing, self._waiting = [], [], 0

    def turns(self, step: Step, w: FloatArray) -> None:
        """Note the slip speeds at which w turns."""
        self.log.place(step.before.row, u=1 - step.before.side * w)

    def passages(self, step: Step, low: FloatArray, high: FloatArray, rising: BoolArray) -> None:
        """Note where x turns, as w passes 1 between two times of each step."""
        place = level_passed(self.field, step, np.ones(step.h.size), low, high, rising)
        self.log.turn(step.before.row, step.before.tau + place.t, place.q)

"""Which motion a start leads to."""

import math
from enum import Enum
from functools import cached_property
from typing import Literal

import numpy as np

from stickslip_sym.cycles import LimitCycle
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.oscillator import Oscillator, Scene, check_rtol, real
from stickslip_sym.regimes import graze
from stickslip_sym.slip import Point, SlipPhase, follow
from stickslip_sym.slip_orbits import SlipOrbits, slip_orbits
from stickslip_sym.transit import stick_slip_cycle

__all__ = ["Motion", "classify"]

_P = Point(0.0, 0.0, 0.0)
_MOST_ROUNDS = 1000
_PATIENCE = 20  # rounds after which the whole way in is looked at
_ROUNDS = 12  # looked at on that way
_LONGEST = 1e4  # decay times, for one slip phase
_SAME = 1e-9  # relative change of a round that is periodic
_ESCAPED = 1e6  # growth of a round, over its start, after which it is without bound
_NEAR = 100  # times the tolerance, around a separatrix


class Motion(Enum):
    """What a mass does in the end."""

    STICK_SLIP = "stick-slip"
    PURE_SLIP = "pure slip"
    DAMPED_SLIP = "damped slip"
    UNBOUNDED = "grows without bound"
    UNDECIDED = "undecided, within tolerance of a boundary"


def classify(
    law: FrictionLaw, osc: Oscillator, *, x0: float = 0.0, v0: float | None = None, rtol: float = 1e-10
) -> Motion:
    """Return the motion to which a start leads.

    A mass that comes to stick leaves at P, and all that follows is the transit from there. One that only slips has
    peaks of velocity that grow or shrink up to the next limit cycle. So a few slip phases decide.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound. One with mu(0) = 0 never sticks: its relaxation oscillation is pure slip.
    osc : Oscillator
    x0 : float
        Initial displacement in m.
    v0 : float, optional
        Initial velocity in m/s, on either side of the belt's; the belt's speed if not given.
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.

    Returns
    -------
    Motion
        `UNDECIDED` where the start, or the oscillator itself, is on a boundary within the tolerance.

    Raises
    ------
    InputError
        For unusable numbers or an unbound law.
    NotConverged
        When the bound on the work is reached.
    """
    check_rtol(rtol)
    v0 = osc.V if v0 is None else real("v0", v0)
    scene = Scene.of(law, osc)
    start = Point(0.0, (real("x0", x0) - osc.onset(law)) / osc.length, abs(osc.V - v0) / osc.V)
    q, w = scene.rest
    near = _NEAR * rtol
    if v0 < osc.V and abs(start.w - w) <= near and abs(start.q - q) <= near * max(1.0, abs(q)):
        return Motion.DAMPED_SLIP if scene.decay(w) > 0 else Motion.UNDECIDED
    return _Course(law, osc, scene, rtol).of(start, 1 if v0 < osc.V else -1)


class _Course:
    """The course of a motion, from one slip phase to the next."""

    def __init__(self, law: FrictionLaw, osc: Oscillator, scene: Scene, rtol: float) -> None:
        self.law, self.osc, self.scene, self.rtol = law, osc, scene, rtol
        self.orbits: SlipOrbits | None = None

    def of(self, point: Point, side: int) -> Motion:
        overtakes: list[float] = []  # where slip faster than the belt began
        while True:
            if point.w == 0:
                if self.scene.sticks(point.q):
                    return self.from_onset()
                side = 1 if point.q >= 0 else -1
            if side < 0:
                overtakes.append(abs(point.q))
                if (decided := self._outside(overtakes)) is not None:
                    return decided
            slip = self._slip(point, side, "turn" if side > 0 else "return")
            if slip.end == "rest":
                return Motion.DAMPED_SLIP
            if slip.end == "horizon":
                return Motion.UNDECIDED
            if slip.end == "minimum":
                if (decided := self._inside(1 - slip.last.w)) is not None:
                    return decided
                slip = self._slip(slip.last, 1, "return")
            point = Point(0.0, slip.last.q, slip.last.w)

    def _outside(self, overtakes: list[float]) -> Motion | None:
        """Return what rounds that overtake the belt lead to, once they show it."""
        if len(overtakes) < 3:
            return None
        before, now = overtakes[-2:]
        if abs(now - before) <= _SAME * now:
            return Motion.PURE_SLIP
        if now > _ESCAPED * overtakes[0]:
            return Motion.UNBOUNDED
        if len(overtakes) < _PATIENCE:
            return None
        # From far out it may be a long way in. If every round on that way shrinks, it ends where P's orbit is.
        if now < before and all(self._shrinks(now * part) for part in np.linspace(0.0, 1.0, _ROUNDS + 1)[1:]):
            return self.from_onset()
        return None if len(overtakes) < _MOST_ROUNDS else Motion.UNDECIDED

    def _shrinks(self, q: float) -> bool:
        """Whether the round that overtakes the belt at -q comes back nearer, or sticks, or slips on below V."""
        if self.scene.sticks(-q):
            return True
        back = self._slip(Point(0.0, -q, 0.0), -1, "return").last
        if self.scene.sticks(back.q):
            return True
        slip = self._slip(Point(0.0, back.q, 0.0), 1, "turn")
        return slip.end != "return" or abs(slip.last.q) < q

    def from_onset(self) -> Motion:
        """Return what the slip from P leads to."""
        height = graze(self.scene, self.rtol)
        if height == 0:
            return Motion.UNDECIDED
        if height > 0:
            return self._inside(1 - height) or Motion.UNDECIDED
        if self._cycles:
            return Motion.STICK_SLIP
        beyond = self._slip(_P, 1, "turn").last  # thrown back beyond what static friction holds
        return self.of(Point(0.0, beyond.q, 0.0), -1)

    def _inside(self, peak: float) -> Motion | None:
        """Return what a peak below the belt's speed leads to; None if to the belt, and not to stick."""
        orbits = self._orbits
        for cycle in orbits.cycles:
            if not cycle.stable and abs(cycle.amplitude / self.osc.V - peak) <= _NEAR * self.rtol:
                return Motion.UNDECIDED
        fate = orbits.fate(peak * self.osc.V)
        if isinstance(fate, LimitCycle) or math.isnan(fate):
            return Motion.PURE_SLIP
        if fate == 0:
            return Motion.DAMPED_SLIP
        return Motion.STICK_SLIP if self._cycles else None

    @cached_property
    def _orbits(self) -> SlipOrbits:
        return slip_orbits(self.law, self.osc, rtol=self.rtol)

    @cached_property
    def _cycles(self) -> bool:
        return stick_slip_cycle(self.law, self.osc, rtol=self.rtol) is not None

    def _slip(self, start: Point, side: int, until: Literal["return", "turn"]) -> SlipPhase:
        horizon = start.tau + _LONGEST * max(1.0, 2 * abs(self.scene.zeta))
        return follow(self.scene, start, side, horizon=horizon, rtol=self.rtol, until=until)

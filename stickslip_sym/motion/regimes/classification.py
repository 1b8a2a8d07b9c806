"""Which motion a start leads to."""

import math
from enum import Enum
from functools import cached_property

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import OutOfTime, StickSlipError
from stickslip_sym.core.numbers import read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.ensemble.ends import Ends, first_ends
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import graze, grows_far_out
from stickslip_sym.motion.regimes.slip_orbits import SlipOrbits, overtaking_cycle, round_from, slip_orbits
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase, Until
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.simulation.transit import horizon, stick_slip_cycle

__all__ = ["Motion", "classify", "classify_all"]

_ROUNDS = 12  # looked at on the way from far out
_SAME = 1e-9  # relative change of a round that is periodic
_MANY = 40  # starts, from which on it is faster to follow them together
_NEAR = 100  # times the tolerance, around a separatrix


class Motion(Enum):
    """What a mass does in the end."""

    STICK_SLIP = "stick-slip"
    PURE_SLIP = "pure slip"
    DAMPED_SLIP = "damped slip"
    UNBOUNDED = "grows without bound"
    UNDECIDED = "undecided, within tolerance of a boundary"


def classify(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    x0: float = 0.0,
    v0: float | None = None,
    rtol: float = 1e-10,
    time_limit: float | None = None,
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
    time_limit : float, optional
        Seconds of computation after which it is given up.

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
    OutOfTime
        When the time limit is reached.
    """
    rtol = read_rtol(rtol)
    v0 = osc.V if v0 is None else real("v0", v0)
    scene = Scene.of(law, osc)
    start = Point(0.0, (real("x0", x0) - osc.onset(law)) / osc.length, abs(osc.V - v0) / osc.V)
    with deadline.time_limit(time_limit):
        return _Course(law, osc, scene, rtol).of(start, 1 if v0 < osc.V else -1)


def classify_all(
    law: FrictionLaw, osc: Oscillator, x0: FloatArray, v0: FloatArray, *, rtol: float
) -> list[Motion | StickSlipError]:
    """Return what each of many starts leads to, as `classify` says it, or the error that it raises.

    The first slips are followed all at once, and what follows from P is found once; starts that the steps of many
    do not serve are classified one by one, and so are few.

    Raises
    ------
    InputError
        For an unbound law.
    """
    scene = Scene.of(law, osc)
    course = _Course(law, osc, scene, rtol)
    q, u = (x0 - osc.onset(law)) / osc.length, v0 / osc.V
    ends = first_ends(scene, q, u, horizon=horizon(scene), rtol=rtol) if x0.size >= _MANY else None
    found: list[Motion | StickSlipError] = []
    for i in range(x0.size):
        point, side = Point(0.0, float(q[i]), abs(float(1 - u[i]))), 1 if u[i] < 1 else -1
        try:
            deadline.check_time()
            known = None if ends is None or course.at_rest(point, side) else course.after(ends, i)
            found.append(course.of(point, side) if known is None else known)
        except StickSlipError as error:
            found.append(error)
    return found


class _Course:
    """The course of a motion, from one slip phase to the next."""

    def __init__(self, law: FrictionLaw, osc: Oscillator, scene: Scene, rtol: float) -> None:
        self.law, self.osc, self.scene, self.rtol = law, osc, scene, rtol

    def at_rest(self, point: Point, side: int) -> bool:
        """Whether a start is at the equilibrium, within the tolerance."""
        q, w = self.scene.rest
        near = _NEAR * self.rtol
        return side > 0 and abs(point.w - w) <= near and abs(point.q - q) <= near * max(1.0, abs(q))

    def after(self, ends: Ends, start: int) -> Motion | None:
        """Return what one of many starts leads to after how it first ended; None where that is not known."""
        if ends.late[start]:
            raise OutOfTime("the time limit was reached")
        if ends.onset[start]:
            return self._from_onset
        if ends.rests[start]:
            return Motion.DAMPED_SLIP
        if ends.unbounded[start]:
            return self._beyond_all
        if ends.lowest[start] == ends.lowest[start]:
            return self._inside(1 - float(ends.lowest[start]))
        before, now = ends.rounds[:, start].tolist()
        return self._outside(before, now) if now == now else None

    def of(self, point: Point, side: int) -> Motion:
        """Return what a start leads to."""
        if self.at_rest(point, side):
            return Motion.DAMPED_SLIP if self.scene.decay(self.scene.rest[1]) > 0 else Motion.UNDECIDED
        first: float | None = None  # where slip slower than the belt began, outside P's orbit
        while True:
            if point.w == 0:
                if self.scene.sticks(point.q):
                    return self._from_onset
                side = 1 if point.q >= 0 else -1
                if side > 0 and first is not None:
                    return self._outside(first, point.q)
                first = point.q if side > 0 else first
            slip = self._slip(point, side, End.MINIMUM if side > 0 else End.RETURN)
            if slip.end is End.REST:
                return Motion.DAMPED_SLIP
            if slip.end is End.HORIZON:
                return Motion.UNDECIDED
            if slip.end is End.UNBOUNDED:
                return self._beyond_all
            if slip.end is End.MINIMUM:
                return self._inside(1 - slip.last.w)
            point = Point(0.0, slip.last.q, slip.last.w)

    def _outside(self, before: float, now: float) -> Motion:
        """Return what two rounds outside P's orbit lead to: all that follow go the same way."""
        if abs(now - before) <= _SAME * now:
            return Motion.PURE_SLIP
        if now > before:
            farther = (now * 4.0 ** np.arange(1, _ROUNDS)).tolist()
            return self._beyond_all if all(self._grows(q) for q in farther) else Motion.PURE_SLIP
        # It may be a long way in: if no round there grows, it ends where P's orbit does.
        nearer = (now * np.linspace(0.0, 1.0, _ROUNDS + 1)[1:-1]).tolist()
        return Motion.PURE_SLIP if any(self._grows(q) for q in nearer) else self._from_onset

    def _grows(self, q: float) -> bool:
        return round_from(self.scene, q, self.rtol)[0] > q

    @cached_property
    def _from_onset(self) -> Motion:
        """Return what the slip from P leads to."""
        height = graze(self.scene, self.rtol)
        if height == 0:
            return Motion.UNDECIDED
        return self._inside(1 - height) if height > 0 else self._returned

    def _inside(self, peak: float) -> Motion:
        """Return what a peak below the belt's speed leads to."""
        orbits = self._orbits
        for cycle in orbits.cycles:
            if not cycle.stable and abs(cycle.amplitude / self.osc.V - peak) <= _NEAR * self.rtol:
                return Motion.UNDECIDED
        fate = orbits.fate(peak * self.osc.V)
        if isinstance(fate, LimitCycle) or math.isnan(fate):
            return Motion.PURE_SLIP
        return Motion.DAMPED_SLIP if fate == 0 else self._returned

    @cached_property
    def _returned(self) -> Motion:
        """Return what an orbit that grows up to the belt's speed leads to: no orbits cross, so where P's goes."""
        if graze(self.scene, self.rtol) >= 0:
            return Motion.UNDECIDED
        if stick_slip_cycle(self.law, self.osc, rtol=self.rtol) is not None:
            return Motion.STICK_SLIP
        overtaking = overtaking_cycle(self.law, self.osc, rtol=self.rtol)
        return self._beyond_all if overtaking is None else Motion.PURE_SLIP

    @cached_property
    def _beyond_all(self) -> Motion:
        """What becomes of a motion for which no attractor was found further out."""
        return Motion.UNBOUNDED if grows_far_out(self.law, self.osc) else Motion.UNDECIDED

    @cached_property
    def _orbits(self) -> SlipOrbits:
        return slip_orbits(self.law, self.osc, rtol=self.rtol)

    def _slip(self, start: Point, side: int, until: Until) -> SlipPhase:
        end = start.tau + horizon(self.scene)
        return follow(self.scene, start, side, horizon=end, rtol=self.rtol, until=until)

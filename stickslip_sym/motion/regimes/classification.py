"""Which motion an initial condition leads to."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.regime import graze, grows_far_out
from stickslip_sym.motion.regimes.slip_orbits import SlipOrbits, overtaking_cycle, slip_orbits
from stickslip_sym.motion.simulation.cycle import stick_slip_cycle
from stickslip_sym.motion.simulation.simulate import read_initial_conditions
from stickslip_sym.motion.slip import Dimensionless, End, Slip, Slips

__all__ = ["classify", "classify_all"]

_OPEN, _FAILED = -1, len(MOTIONS)  # instead of a place in `MOTIONS`
_ROUNDS = 12  # looked at on the way from far out
_SAME = 1e-9  # relative change of a round that is periodic
_NEAR = 100  # times the tolerance, around a separatrix


@overload
def classify(
    law: FrictionLaw | str, osc: Oscillator, *, x0: float = ..., v0: float | None = ..., rtol: float = ...,
    time_limit: float | None = ..., workers: int = ...,
) -> Motion: ...  # fmt: skip


@overload
def classify(
    law: FrictionLaw | str, osc: Oscillator, *, x0: ArrayLike = ..., v0: ArrayLike | None = ..., rtol: float = ...,
    time_limit: float | None = ..., workers: int = ...,
) -> Motion | ObjectArray: ...  # fmt: skip


def classify(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    x0: ArrayLike = 0.0,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    time_limit: float | None = None,
    workers: int = 1,
) -> Motion | ObjectArray:
    """Return the motion to which an initial condition leads, or many.

    A mass that comes to stick leaves at P, and all that follows is the slip from there. One that only slips has
    peaks of velocity that grow or shrink up to the next limit cycle. So a few slip phases decide.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound. One with mu(0) = 0 never sticks: its relaxation oscillation is pure slip.
    osc : Oscillator
    x0 : float or array
        Initial displacement in m, one or many.
    v0 : float or array, optional
        Initial velocity in m/s, on either side of the belt's; the belt's speed if not given. Arrays broadcast.
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which it is given up.
    workers : int
        Threads for many initial conditions, where numba is there.

    Returns
    -------
    Motion or numpy.ndarray of Motion
        STICK_SLIP, PURE_SLIP, REST, UNBOUNDED; `UNDECIDED` where the initial condition, or the oscillator itself,
        is on a boundary within the tolerance.

    Raises
    ------
    InputError
        For unusable numbers or an unbound law.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> osc = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    >>> [motion.name for motion in ss.classify(ss.laws.exponential.typical(), osc, x0=[-0.1, 0.0], v0=0.0)]
    ['STICK_SLIP', 'REST']
    """
    law = as_law(law)
    with deadline.time_limit(time_limit):
        deadline.check_time()  # what is kept from earlier calls may need no look at the time
        found = classify_all(law, osc, x0, osc.V if v0 is None else v0, rtol=read_rtol(rtol), workers=workers)
    for one in found.flat:
        if isinstance(one, StickSlipError):
            raise one
    return found if found.ndim else found.item()


def classify_all(
    law: FrictionLaw, osc: Oscillator, x0: ArrayLike, v0: ArrayLike, *, rtol: float, workers: int = 1
) -> ObjectArray:
    """Return what each initial condition leads to, or in its place the error that kept it from being known.

    Raises
    ------
    InputError
        For an unbound law, or initial conditions that do not broadcast.
    """
    places, speeds = read_initial_conditions(x0, v0)
    system = Dimensionless.of(law, osc)
    q, u = (places.ravel() - osc.onset(law)) / osc.length, speeds.ravel() / osc.V
    course = _Course(law, osc, system, rtol, workers)
    return course.of(q, np.abs(1 - u), np.where(u < 1, 1.0, -1.0)).reshape(places.shape)


class _Course:
    """The courses of motions, from one slip phase to the next, decided together.

    A decision is a place in `MOTIONS`, or `_OPEN` as long as there is none; an error stands in its place.
    """

    def __init__(
        self, law: FrictionLaw, osc: Oscillator, system: Dimensionless, rtol: float, workers: int
    ) -> None:
        self.law, self.osc, self.system, self.rtol, self.workers = law, osc, system, rtol, workers
        self.errors: dict[int, StickSlipError] = {}
        self.found = np.empty(0, dtype=np.intp)

    def of(self, q: FloatArray, w: FloatArray, side: FloatArray) -> ObjectArray:
        """Return what initial conditions lead to."""
        self.found = np.full(q.shape, _OPEN)
        first = np.full(q.shape, np.nan)  # where slip slower than the belt began, outside P's orbit
        rest_q, rest_w = self.system.rest
        near = _NEAR * self.rtol
        at_rest = (side > 0) & (np.abs(w - rest_w) <= near) & (np.abs(q - rest_q) <= near * max(1.0, abs(rest_q)))
        self._decide(np.flatnonzero(at_rest), lambda: self._at_rest)
        left = np.flatnonzero(~at_rest)
        while left.size:
            some = left[w[left] == 0]
            stuck = self.system.sticks(q[some])
            self._decide(some[stuck], lambda: self._from_onset)
            some = some[~stuck]
            side[some] = np.where(q[some] >= 0, 1.0, -1.0)
            begins = some[side[some] > 0]
            again = begins[~np.isnan(first[begins])]
            if again.size:
                self._decide(again, partial(self._outside, first[again], q[again]))
            first[begins] = q[begins]
            left = left[self.found[left] == _OPEN]
            for one in (1.0, -1.0):
                self._go_on(left[side[left] == one], q, w, int(one))
            left = left[self.found[left] == _OPEN]
        motions = np.array([*MOTIONS, None], dtype=object)[self.found]
        for row, error in self.errors.items():
            motions[row] = error
        return motions

    def _decide(self, rows: IntArray, decide: Callable[[], Motion | IntArray]) -> None:
        """Note what some motions lead to, or the error that keeps it from being known."""
        if not rows.size:
            return
        try:
            motion = decide()
            self.found[rows] = MOTIONS.index(motion) if isinstance(motion, Motion) else motion
        except StickSlipError as error:
            self.found[rows] = _FAILED
            self.errors |= dict.fromkeys(rows.tolist(), error)

    def _go_on(self, rows: IntArray, q: FloatArray, w: FloatArray, side: int) -> None:
        """Follow slips to their ends, and decide those that do not return."""
        if not rows.size:
            return
        try:
            slips = self._slips(q[rows], w[rows], side)
        except StickSlipError as error:
            self.found[rows] = _FAILED
            self.errors |= dict.fromkeys(rows.tolist(), error)
            return
        q[rows], w[rows] = slips.q, slips.w
        self._decide(rows[slips.end == End.REST], lambda: self._at_rest)
        self._decide(rows[slips.end == End.HORIZON], lambda: Motion.UNDECIDED)
        turned = slips.end == End.MINIMUM
        self._decide(rows[turned], lambda: self._inside(1 - slips.w[turned]))
        for i in np.flatnonzero(np.isin(slips.end, (End.OUTSIDE, End.STEPS, End.FAILED))).tolist():
            self._decide(rows[i : i + 1], partial(self._away, self.system.slip_of(slips, i)))

    def _slips(self, q: FloatArray, w: FloatArray, side: int) -> Slips:
        """Follow slips up to a return, or a minimum of w below the belt's speed."""
        until = End.MINIMUM if side > 0 else End.RETURN
        return self.system.slips(q, w, side, until=until, rtol=self.rtol, workers=self.workers)

    def _away(self, slip: Slip) -> Motion:
        """Return what a slip that came out of the law's table leads to, or raise what kept it from an end."""
        refusal = self.system.refusal(slip, self.rtol)
        if refusal is not None:
            raise refusal
        return self._beyond_all

    def _outside(self, before: FloatArray, now: FloatArray) -> IntArray:
        """Return what two rounds outside P's orbit lead to: all that follow go the same way."""
        found = np.full(now.shape, MOTIONS.index(Motion.PURE_SLIP))
        moved = np.abs(now - before) > _SAME * now
        outward, inward = moved & (now > before), moved & (now < before)
        if outward.any():
            far = now[outward].min() * 4.0 ** np.arange(1, _ROUNDS + math.log(np.ptp(now[outward]) + 1, 4))
            bounded = far[~self._grow(far)]
            found[outward & (now >= bounded.max(initial=0.0))] = MOTIONS.index(self._beyond_all)
        if inward.any():
            # It may be a long way in: if no round there grows, it ends where P's orbit does.
            near = np.geomspace(now[inward].min() / _ROUNDS, now[inward].max(), 2 * _ROUNDS)
            growing = near[self._grow(near)]
            found[inward & (now <= growing.min(initial=math.inf))] = MOTIONS.index(self._from_onset)
        return found

    def _grow(self, q: FloatArray) -> BoolArray:
        """Tell whether rounds that begin at displacements q >= 0 end farther out."""
        grow = np.zeros(q.shape, dtype=bool)
        slow = self._slips(q, np.zeros(q.shape), 1)
        grow[slow.end == End.OUTSIDE] = True
        over = np.flatnonzero((slow.end == End.RETURN) & ~self.system.sticks(slow.q))
        if over.size:
            fast = self._slips(slow.q[over], np.zeros(over.shape), -1)
            grow[over] = (fast.end == End.OUTSIDE) | ((fast.end == End.RETURN) & (fast.q > q[over]))
        return grow

    @cached_property
    def _at_rest(self) -> Motion:
        """Return what a motion that is at rest stays: one that crept to it on one side may leave on the other."""
        return Motion.REST if self.system.decay(1.0) > 0 else Motion.UNDECIDED

    @cached_property
    def _from_onset(self) -> Motion:
        """Return what the slip from P leads to."""
        height = graze(self.system, self.rtol)
        if height == 0:
            return Motion.UNDECIDED
        return MOTIONS[self._inside(np.array([1 - height]))[0]] if height > 0 else self._returned

    def _inside(self, peaks: FloatArray) -> IntArray:
        """Return what peaks below the belt's speed lead to."""
        orbits, found = self._orbits, np.empty(peaks.shape, dtype=np.intp)
        places = np.searchsorted([cycle.amplitude / self.osc.V for cycle in orbits.cycles], peaks)
        for place in np.unique(places):
            some = places == place
            found[some] = MOTIONS.index(self._of_fate(orbits.fate(float(peaks[some][0]) * self.osc.V)))
        for cycle in orbits.cycles:
            if not cycle.stable:
                near = np.abs(cycle.amplitude / self.osc.V - peaks) <= _NEAR * self.rtol
                found[near] = MOTIONS.index(Motion.UNDECIDED)
        return found

    def _of_fate(self, fate: LimitCycle | float) -> Motion:
        if isinstance(fate, LimitCycle) or math.isnan(fate):
            return Motion.PURE_SLIP
        return Motion.REST if fate == 0 else self._returned

    @cached_property
    def _returned(self) -> Motion:
        """Return what an orbit that grows up to the belt's speed leads to: no orbits cross, so where P's goes."""
        if graze(self.system, self.rtol) >= 0:
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

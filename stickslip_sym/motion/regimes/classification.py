"""Which motion an initial condition leads to."""

import math
from collections.abc import Callable
from functools import cached_property, partial
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import graze, grows_far_out
from stickslip_sym.motion.regimes.slip_orbits import SlipOrbits, overtaking_cycle, round_from, slip_orbits
from stickslip_sym.motion.simulation.cycle import stick_slip_cycle
from stickslip_sym.motion.simulation.many import read_initial_conditions
from stickslip_sym.motion.slip import Dimensionless, End, Slips

__all__ = ["classify", "classify_all"]

_ROUNDS = 12  # looked at on the way from far out
_MOST_STEPS = 10_000  # of a slip
_SAME = 1e-9  # relative change of a round that is periodic
_FEW = 8  # initial conditions, up to which plain Python is as fast as loading compiled code
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


def _or_error(decide: Callable[[], Any]) -> Any:
    """Return a decision, or the error that it raises."""
    try:
        return decide()
    except StickSlipError as error:
        return error


class _Course:
    """The courses of motions, from one slip phase to the next."""

    def __init__(
        self, law: FrictionLaw, osc: Oscillator, system: Dimensionless, rtol: float, workers: int
    ) -> None:
        self.law, self.osc, self.system, self.rtol, self.workers = law, osc, system, rtol, workers

    def of(self, q: FloatArray, w: FloatArray, side: FloatArray) -> ObjectArray:
        """Return what initial conditions lead to."""
        found = np.full(q.shape, None, dtype=object)
        first = np.full(q.shape, np.nan)  # where slip slower than the belt began, outside P's orbit
        rest_q, rest_w = self.system.rest
        near = _NEAR * self.rtol
        at_rest = (side > 0) & (np.abs(w - rest_w) <= near) & (np.abs(q - rest_q) <= near * max(1.0, abs(rest_q)))
        found[at_rest] = self._at_rest
        left = np.flatnonzero(~at_rest)
        while left.size:
            still = w[left] == 0
            some = left[still]
            stuck = (q[some] <= 0) & (q[some] >= -2 * self.system.eta * self.system.table.static)
            if stuck.any():
                found[some[stuck]] = _or_error(lambda: self._from_onset)
            some = some[~stuck]
            side[some] = np.where(q[some] >= 0, 1.0, -1.0)
            begins = some[side[some] > 0]
            for i in begins[~np.isnan(first[begins])]:
                found[i] = _or_error(partial(self._outside, float(first[i]), float(q[i])))
            first[begins] = q[begins]
            left = left[found[left] == None]  # noqa: E711  # elementwise
            for one in (1.0, -1.0):
                some = left[side[left] == one]
                if not some.size:
                    continue
                slips = _or_error(partial(self._slips, q[some], w[some], int(one)))
                if isinstance(slips, StickSlipError):
                    found[some] = slips
                    continue
                q[some], w[some] = slips.q, slips.w
                self._decide(found, some, slips)
            left = left[found[left] == None]  # noqa: E711
        return found

    def _slips(self, q: FloatArray, w: FloatArray, side: int) -> Slips:
        """Follow slips up to a return, or a minimum of w below the belt's speed."""
        until = End.MINIMUM if side > 0 else End.RETURN
        if q.size <= _FEW:
            states = zip(q.tolist(), w.tolist(), strict=True)
            rows = [
                self.system.slip(*state, side, until=until, rtol=self.rtol, most=_MOST_STEPS) for state in states
            ]
            return Slips(*(np.array(column) for column in list(zip(*rows, strict=True))[:6]))
        sides = np.full(q.shape, float(side))
        return self.system.slips(q, w, sides, until=until, rtol=self.rtol, workers=self.workers)

    def _decide(self, found: ObjectArray, rows: IntArray, slips: Slips) -> None:
        """Note what slips lead to that do not return."""
        for end, motion in ((End.REST, self._at_rest), (End.HORIZON, Motion.UNDECIDED)):
            found[rows[slips.end == end]] = motion
        turned = slips.end == End.MINIMUM
        found[rows[turned]] = _or_error(lambda: self._inside(1 - slips.w[turned]))
        for i in np.flatnonzero(np.isin(slips.end, (End.OUTSIDE, End.STEPS, End.FAILED))):
            refusal = self.system.refusal(self.system.slip_of(slips, int(i)), self.rtol)
            found[rows[i]] = _or_error(lambda: self._beyond_all) if refusal is None else refusal

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
        return round_from(self.system, q, self.rtol).end > q

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
        return self._inside(np.array([1 - height]))[0] if height > 0 else self._returned

    def _inside(self, peaks: FloatArray) -> ObjectArray:
        """Return what peaks below the belt's speed lead to."""
        orbits, found = self._orbits, np.full(peaks.shape, None, dtype=object)
        places = np.searchsorted([cycle.amplitude / self.osc.V for cycle in orbits.cycles], peaks)
        for place in np.unique(places):
            some = places == place
            fate = orbits.fate(float(peaks[some][0]) * self.osc.V)
            found[some] = _or_error(partial(self._of_fate, fate))
        for cycle in orbits.cycles:
            if not cycle.stable:
                found[np.abs(cycle.amplitude / self.osc.V - peaks) <= _NEAR * self.rtol] = Motion.UNDECIDED
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

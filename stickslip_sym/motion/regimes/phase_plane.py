"""The phase plane of one oscillator: where its motions go, as far as it is asked for.

An orbit in slip has its peaks of velocity at A V. In a plane orbits do not cross, so from peak to peak A only
grows or only shrinks, up to the next limit cycle, to rest, or to the belt's speed. A mass that sticks leaves at P,
so what becomes of it is what becomes of the slip from there. A motion that overtakes the belt and is not held goes
round outside P's orbit, and its rounds too only grow or only shrink, up to a limit cycle there.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle, limit_cycles, needed_damping
from stickslip_sym.motion.regimes.separatrix import Separatrix, SlipCurve
from stickslip_sym.motion.roots import NEAREST
from stickslip_sym.motion.simulation.cycle import StickSlipCycle, first_minimum, stick_slip_cycle
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import End

NEAR = 100
"""Tolerances within which an initial condition is on a separatrix, as far as integration can say."""
_CLOSE = 1e-6  # slip speed over the belt's at a graze, below which its error is measured
_FIRST, _ESCAPED = 1e-3, 1e6  # displacements q at which a round outside P's is tried first, and last
_FAST = 1e12  # slip speed over the belt's, beyond every feature of a law: it stands for all that are higher
_SAME = 1e-9  # relative change of a round that is periodic
_INWARD, _OUTWARD = 24, 12  # rounds that are looked at on the way in to P's, and out


@dataclass(frozen=True)
class PhasePlane:
    """The motions of an oscillator by steps of a relative tolerance; each is found when it is asked for."""

    law: FrictionLaw
    oscillator: Oscillator
    rtol: float

    @cached_property
    def system(self) -> Dimensionless:
        """The oscillator free of units."""
        return Dimensionless.of(self.law, self.oscillator)

    @cached_property
    def height(self) -> float:
        """The first minimum of the slip speed, over V, after P: 0 where integration cannot tell its sign.

        That is up to the tolerance, and where a tolerance ten times wider changes it by half of itself or more.
        """
        height = first_minimum(self.system, 0.0, 0.0, self.rtol)
        if abs(height) > _CLOSE:
            return height
        lost = abs(first_minimum(self.system, 0.0, 0.0, 10 * self.rtol) - height) >= abs(height) / 2
        return 0.0 if lost or abs(height) <= self.rtol else height

    # -- periodic motions --------------------------------------------------------------------------

    @cached_property
    def slip_cycles(self) -> tuple[LimitCycle, ...]:
        """The limit cycles in pure slip up to the belt's speed, by ascending amplitude."""
        return () if self._growth_of_all else limit_cycles(self.law, self.oscillator)

    @cached_property
    def growth(self) -> tuple[int, ...]:
        """1 where slip orbits grow, -1 where they shrink, 0 where all are periodic.

        Below the first limit cycle, between two, and above the last: an orbit grows where it needs more damping
        than there is.
        """
        if self._growth_of_all:
            return (self._growth_of_all,)
        need, damping = needed_damping(self.law, self.oscillator), 2 * self.oscillator.zeta
        bounds = [0.0, *(cycle.amplitude / self.oscillator.V for cycle in self.slip_cycles), 1.0]
        return tuple(int(np.sign(need.gap((low + high) / 2, damping)[0])) for low, high in pairwise(bounds))

    @cached_property
    def _growth_of_all(self) -> int:
        """The growth of all slip orbits, where those at one end settle it; else 0.

        The next peak grows with that before it, since orbits do not cross. Friction may be so strong that nothing
        else can be integrated.
        """
        system = self.system
        turn = system.turn(0.0)
        if 1 - (first_minimum(system, turn, 0.0, self.rtol) if turn else self.height) <= NEAREST:
            return -1
        nearest = system.turn(1 - NEAREST), 1 - NEAREST
        return int(system.decay(1.0) <= 0 and first_minimum(system, *nearest, self.rtol) <= 0)

    @cached_property
    def stick_slip(self) -> StickSlipCycle | None:
        """The stick-slip cycle; None if the slip from P does not come back to stick."""
        return stick_slip_cycle(self.law, self.oscillator, rtol=self.rtol) if self.height < 0 else None

    @cached_property
    def overtaking(self) -> LimitCycle | None:
        """The innermost limit cycle that overtakes the belt each round and never sticks, or None.

        Where friction is weak, N << V sqrt(k m), the mass arrives at the belt's speed where static friction cannot
        hold it. It overtakes the belt, up to where the work of friction there balances the gain below. A law with
        mu(0) = 0 never sticks, and its relaxation oscillation is of this kind.
        """
        if self.height >= 0 or self.stick_slip is not None or not self._gain(0.0) > 0:
            return None
        inner, outer = 0.0, _FIRST
        while (gain := self._gain(outer)) > 0:
            inner, outer = outer, 4 * outer
            if outer > _ESCAPED:
                return None
        if math.isnan(gain):
            return None
        q = float(brentq(self._gain, inner, outer, xtol=1e-14, rtol=1e-13))
        system, wedge, rtol = self.system, self.system.no_wedge, self.rtol
        begin = system.acceleration(q, 0.0, 1)
        slow = system.slip(q, 0.0, 1, until=End.MINIMUM, rtol=rtol, wedge=wedge, D=-begin)
        moved = -slow.wedge / slow.rate  # the q at which the mass overtakes the belt, by that of the begin
        begin = system.acceleration(slow.q, 0.0, -1)
        fast = system.slip(slow.q, 0.0, -1, rtol=rtol, wedge=wedge, D=-begin * moved)
        speed = 1 + fast.extremes[-1]
        return LimitCycle.of(self.oscillator, speed, slow.tau + fast.tau, -fast.wedge / fast.rate)

    def _gain(self, q: float) -> float:
        """Return by how much a round that begins at q >= 0 ends farther out."""
        return float(rounds(self.system, np.array([q]), self.rtol)[0]) - q

    # -- where other motions go --------------------------------------------------------------------

    def of_peaks(self, peaks: FloatArray) -> ObjectArray:
        """Return what slip orbits come to whose velocity has peaks below the belt's speed, over V."""
        places = np.searchsorted([cycle.amplitude / self.oscillator.V for cycle in self.slip_cycles], peaks)
        found = np.empty(peaks.shape, dtype=object)
        for place in np.unique(places).tolist():
            found[places == place] = self.fate(place)
        for cycle in self.slip_cycles:
            if not cycle.stable:
                near = np.abs(cycle.amplitude / self.oscillator.V - peaks) <= NEAR * self.rtol
                found[near] = Motion.UNDECIDED
        return found

    def fate(self, place: int) -> Motion:
        """Return what slip orbits come to that lie beyond so many limit cycles in pure slip."""
        growth = self.growth[place]
        if growth == 0 or (place < len(self.slip_cycles) if growth > 0 else place > 0):
            return Motion.PURE_SLIP
        return self.returned if growth > 0 else Motion.REST

    @property
    def at_rest(self) -> Motion:
        """What a motion that is at rest stays: one that crept to it on one side may leave on the other."""
        return Motion.REST if self.system.decay(1.0) > 0 else Motion.UNDECIDED

    @cached_property
    def from_onset(self) -> Motion:
        """What the slip from P leads to, and with it every motion that sticks."""
        if self.height > 0:
            motion: Motion = self.of_peaks(np.array([1 - self.height]))[0]
            return motion
        return self.returned

    @cached_property
    def returned(self) -> Motion:
        """What an orbit that grows up to the belt's speed leads to: no orbits cross, so where P's goes."""
        if self.height >= 0:
            return Motion.UNDECIDED
        if self.stick_slip is not None:
            return Motion.STICK_SLIP
        return self.beyond if self.overtaking is None else Motion.PURE_SLIP

    @property
    def beyond(self) -> Motion:
        """What becomes of a motion for which no attractor was found farther out."""
        return Motion.UNBOUNDED if self.unbounded else Motion.UNDECIDED

    @property
    def unbounded(self) -> bool:
        """Whether damping and friction together feed motions at all high speeds."""
        osc = self.oscillator
        return bool(osc.c + osc.N * friction_far_out(self.law, osc.V) < 0)

    def of_rounds(self, begins: FloatArray, ends: FloatArray) -> ObjectArray:
        """Return what rounds outside P's orbit lead to, by where they begin and end.

        A periodic one stays. Any other goes on the way it went, unless a round ahead goes the other way: then
        there is a limit cycle between.
        """
        found = np.full(begins.shape, Motion.PURE_SLIP, dtype=object)
        moved = np.abs(ends - begins) > _SAME * ends
        if moved.any():
            near = np.geomspace(ends[moved].min() / _INWARD, ends[moved].max(), _INWARD)
            ahead = np.append(near, near[-1] * 4.0 ** np.arange(1, _OUTWARD + 1))
            grow = rounds(self.system, ahead, self.rtol) > ahead
            away = moved & (ends > begins) & (ends >= ahead[~grow].max(initial=0.0))
            home = moved & (ends < begins) & (ends <= ahead[grow].min(initial=math.inf))
            for some, name in ((away, "beyond"), (home, "from_onset")):
                if some.any():
                    found[some] = getattr(self, name)
        return found

    # -- separatrices ------------------------------------------------------------------------------

    @cached_property
    def separatrices(self) -> tuple[Separatrix, ...]:
        """The curves that part basins, from inside out.

        They are the unstable limit cycles, and, where orbits inside it shrink while those that stick go on, the
        orbit that just touches the belt's speed.
        """
        grazes = self.growth[-1] < 0 and self.stick_slip is not None
        unstable = [cycle.amplitude for cycle in self.slip_cycles if not cycle.stable]
        return self.curves([1 - A / self.oscillator.V for A in unstable] + [0.0] * grazes)

    def curves(self, least: list[float]) -> tuple[Separatrix, ...]:
        """Return the separatrices whose slip speeds, over V, have certain minima: 0 where one grazes."""
        onset, found = self.oscillator.onset(self.law), []
        back = self.system.backward
        for w in least:
            # Backward, since unstable orbits attract those beside them then.
            slip = back.slip(-self.system.turn(w), w, until=End.MINIMUM, rtol=self.rtol, recorded=True)
            if slip.end is not End.OUTSIDE:
                curve = SlipCurve.of(back, slip, self.rtol)
                found.append(Separatrix("limit cycle" if w else "graze", curve, onset, self.oscillator))
        return tuple(found)


@lru_cache(maxsize=256)  # the maps, basins and regime of one operating point ask for the same motions
def phase_plane(law: FrictionLaw, osc: Oscillator, rtol: float) -> PhasePlane:
    """Return the phase plane of an oscillator, with what is known of it already."""
    return PhasePlane(law, osc, rtol)


def friction_far_out(law: FrictionLaw, V: float) -> float:
    """Return mu(v)/v in s/m at slip speeds beyond every feature of a law; 0 if it is measured up to a speed."""
    return 0.0 if law.v_max is not None else float(law.mu(_FAST * V)) / (_FAST * V)


def rounds(
    system: Dimensionless,
    q: FloatArray,
    rtol: float,
    *,
    eta: FloatArray | None = None,
    zeta: FloatArray | None = None,
    **options: int,
) -> FloatArray:
    """Follow rounds that leave the belt's speed at displacements q >= 0, to slower motion first.

    - `eta`, `zeta`: an entry for each round, where they are not the system's.
    - `options`: of `Dimensionless.slips`.

    Returns the q where slip slower than the belt begins again: NaN if the mass sticks before, 0 if it stays slower
      than the belt, infinity if it moves away for ever or beyond what was measured, and -1 if that is unknown.
    """
    ends, going = np.array(q, dtype=np.float64), np.arange(q.size)
    eta = np.full(q.shape, system.eta) if eta is None else eta
    zeta = np.full(q.shape, system.zeta) if zeta is None else zeta
    for side in (1.0, -1.0):
        slips = system.slips(
            ends[going], np.zeros(going.size), np.full(going.size, side), eta=eta[going], zeta=zeta[going],
            until=End.MINIMUM, rtol=rtol, **options,
        )  # fmt: skip
        back = slips.end == End.RETURN
        slower = np.isin(slips.end, (End.MINIMUM, End.REST, End.HORIZON))
        ends[going] = np.select([back, slower, slips.end == End.OUTSIDE], [slips.q, 0.0, math.inf], -1.0)
        sticks = back & (slips.q <= 0) & (slips.q >= -2 * eta[going] * system.table.static)
        ends[going[sticks]] = math.nan
        going = going[back & ~sticks]
    return ends

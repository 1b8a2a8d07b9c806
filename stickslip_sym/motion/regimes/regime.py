"""Which motions an oscillator has: rest, stick-slip, pure slip, and where one ends and another begins.

Damping rotates the field of directions one way, so the transit from P, where every forward stick phase ends,
returns to the belt's speed for c below one threshold and not above. Rest attracts for c above -N mu'(V). Neither
excludes the other: between the two thresholds rest and stick-slip coexist, or a pure-slip limit cycle takes the
place of both.

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

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.numbers import ROUNDING, read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED, TIGHT, SlipEnd
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle, limit_cycles
from stickslip_sym.motion.orbits.damping import NEAREST, OF_ORBITS, needed_damping
from stickslip_sym.motion.regimes.attractors import ATTRACTORS
from stickslip_sym.motion.regimes.overtaking import FixedPoint, Rounds, rounds_outside
from stickslip_sym.motion.regimes.separatrix import Separatrix, interpolated
from stickslip_sym.motion.simulation.cycle import StickSlipCycle, first_minimum, stick_slip_cycle
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.motion.simulation.trajectory import dense
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.shown import Drawn, views_of

_RELATIVE_STEP = TIGHT ** (1 / 3)  # of a displacement by which a round is differentiated


@dataclass(frozen=True)
class Rest(DataResult):
    """The equilibrium, at which the belt slips under a mass that does not move.

    Attributes
    ----------
    x : float
        Displacement N mu(V)/k in m.
    rate : float
        Growth rate of small motions in 1/s, the larger real part of the two eigenvalues. Where mu has a kink at
        V it is the mean over the two halves of a swing, and infinite where mu jumps.
    stable : bool
        Whether it is negative, c > -N mu'(V).
    one_sided : bool
        Whether slower or faster motions come to it, though it is not stable: mu has a kink at V.
    """

    x: float
    rate: float
    stable: bool
    one_sided: bool = False

    def __str__(self) -> str:
        return f"rest at x = {self.x:.6g} m"

    def __repr__(self) -> str:
        return f"Rest: {self}, {'stable' if self.stable else 'unstable'}, growth rate {self.rate:.6g} 1/s"


Attractor = Rest | LimitCycle | StickSlipCycle


@dataclass(frozen=True)
class Regime(Drawn, DataResult):
    """Every motion that an oscillator has, and where others lead to: found when it is first asked for, and kept.

    Attributes
    ----------
    law, oscillator : FrictionLaw, Oscillator
        Whose motions they are.
    rtol : float
        Relative tolerance of an integration step.
    """

    reported = ("attractors",)

    law: FrictionLaw
    oscillator: Oscillator
    rtol: float

    @cached_property
    def system(self) -> NondimensionalOscillator:
        """The oscillator free of units."""
        return NondimensionalOscillator.of(self.law.bound, self.oscillator)

    @cached_property
    def height(self) -> float | Unknown:
        """The first minimum of the slip speed, over V, after P, where integration can tell its sign.

        That is beyond the tolerance, and where a tolerance ten times wider changes it by less than half of itself.
        """
        height = first_minimum(self.system, 0.0, 0.0, self.rtol)
        wider = first_minimum(self.system, 0.0, 0.0, 10 * self.rtol)
        if abs(height) > max(self.rtol, 2 * abs(wider - height)):
            return height
        return Unknown("the slip from P grazes the belt's speed within the error of the integration")

    @property
    def _peak(self) -> float | None:
        """The peak of velocity, over V, after a slip from P that stays slower than the belt; else None."""
        height = self.height
        if isinstance(height, Unknown) or height <= 0:
            return None
        return 1 - height

    @property
    def _comes_back(self) -> bool:
        """Whether the slip from P is known to come back to the belt's speed."""
        height = self.height
        return not isinstance(height, Unknown) and height < 0

    # -- rest and periodic motions -----------------------------------------------------------------

    @cached_property
    def rest(self) -> Rest:
        """The equilibrium."""
        law = self.law
        osc = self.oscillator
        rise = self.system.rise
        x = osc.N * law.mu(osc.V) / osc.k
        jump = sum(
            size for level, size in zip(rise.levels, rise.jumps, strict=False) if abs(level - 1) <= ROUNDING
        )
        # Where mu has a kink at V the two halves of a swing have slopes of their own.
        sides = [_swing(osc, law.slope(osc.V * (1 + side * 10 * ROUNDING))) for side in (-1, 1)]
        ends_here = any(rate < 0 and math.isinf(time) for rate, time in sides)
        if jump != 0 and osc.N > 0:
            # Where mu jumps up it holds the mass as static friction does; where it jumps down it drives it off.
            return Rest(x, math.copysign(math.inf, -jump), jump > 0, jump < 0 and ends_here)
        aperiodic = [rate for rate, time in sides if math.isinf(time)]
        if aperiodic:  # motions on that side do not come back from it
            rate = max(aperiodic)
            return Rest(x, rate, rate < 0, rate >= 0 and ends_here)
        rate = sum(rate * time for rate, time in sides) / sum(time for _, time in sides)
        return Rest(x, rate, rate < 0)

    @cached_property
    def slip_cycles(self) -> tuple[LimitCycle, ...]:
        """The limit cycles in pure slip up to the belt's speed, by ascending amplitude."""
        if self._growth_of_all:
            return ()
        return limit_cycles(self.law, self.oscillator)

    @cached_property
    def growth(self) -> tuple[int, ...]:
        """1 where slip orbits grow, -1 where they shrink, 0 where all are periodic.

        Below the first limit cycle, between two, and above the last: an orbit grows where it needs more damping
        than there is.
        """
        if self._growth_of_all:
            return (self._growth_of_all,)
        need = needed_damping(self.law, self.oscillator)
        damping = 2 * self.oscillator.zeta
        bounds = [0.0, *(cycle.amplitude / self.oscillator.V for cycle in self.slip_cycles), 1.0]
        return tuple(int(np.sign(need.mismatch((low + high) / 2, damping))) for low, high in pairwise(bounds))

    @cached_property
    def _growth_of_all(self) -> int:
        """The growth of all slip orbits, where those at one end settle it; else 0.

        The next peak grows with that before it, since orbits do not cross. Friction may be so strong that nothing
        else can be integrated.
        """
        system = self.system
        if 1 - first_minimum(system, system.turn(0.0), 0.0, self.rtol) <= NEAREST:
            return -1
        nearest = system.turn(1 - NEAREST), 1 - NEAREST
        return int(system.decay(1.0) <= 0 and first_minimum(system, *nearest, self.rtol) <= 0)

    @cached_property
    def stick_slip(self) -> StickSlipCycle | None:
        """The stick-slip cycle; None if the slip from P does not come back to stick."""
        if self._comes_back:
            return stick_slip_cycle(self.law, self.oscillator, rtol=self.rtol)
        return None

    @cached_property
    def outside(self) -> Rounds:
        """Where the rounds of motions that overtake the belt and do not stick grow, and where they shrink."""
        return rounds_outside(self.system, self.rtol)

    @cached_property
    def overtaking(self) -> tuple[LimitCycle, ...]:
        """The limit cycles that overtake the belt each round and never stick, by ascending amplitude.

        Where friction is weak, N << V sqrt(k m), the mass arrives at the belt's speed where static friction cannot
        hold it. It overtakes the belt, up to where the work of friction there balances the gain below. A law with
        mu(0) = 0 never sticks, and its relaxation oscillation is of this kind. With a negative damping one may lie
        outside a stick-slip cycle, where friction rises faster with speed than damping.
        """
        return tuple(self._overtaking(mark) for mark in self.outside.marks if mark.kind == "cycle")

    def _overtaking(self, mark: FixedPoint) -> LimitCycle:
        """Return the limit cycle at a mark outside P's orbit."""
        system = self.system
        q = mark.low
        slope = -1.0
        if mark.low == mark.high:
            # By differences: where mu falls without bound at rest, as v^0.8, a wedge is lost in a step.
            beside = q * (1 + _RELATIVE_STEP * np.array([-1.0, 0.0, 1.0]))
            below, gain, above = (system.rounds(beside, self.rtol).ends.required() - beside).tolist()
            slope = (above - below) / (beside[2] - beside[0])
            q -= gain / slope
        whole = system.slips(np.array([q]), np.zeros(1), passes=1, rtol=self.rtol, few=0).one(0)
        if (refusal := system.refusal(whole, self.rtol)) is not None:
            raise refusal
        return LimitCycle.of(self.oscillator, 1 - whole.u_least, whole.tau, 1 + slope)

    @property
    def cycles(self) -> tuple[LimitCycle, ...]:
        """All pure-slip limit cycles by ascending amplitude, unstable ones too; the last may overtake the belt."""
        return *self.slip_cycles, *self.overtaking

    # -- where other motions go --------------------------------------------------------------------

    def of_peaks(self, peaks: FloatArray) -> ObjectArray:
        """Return what slip orbits come to whose velocity has peaks below the belt's speed, over V."""
        places = np.searchsorted([cycle.amplitude / self.oscillator.V for cycle in self.slip_cycles], peaks)
        fates = np.empty(peaks.shape, dtype=object)
        for place in np.unique(places).tolist():
            fates[places == place] = self.fate(place)
        for cycle in self.slip_cycles:
            if not cycle.stable:
                near = np.abs(cycle.amplitude / self.oscillator.V - peaks) <= ADDED * self.rtol
                fates[near] = Motion.UNDECIDED
        return fates

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
        if self._peak is not None:
            motion: Motion = self.of_peaks(np.array([self._peak]))[0]
            return motion
        return self.returned

    @cached_property
    def returned(self) -> Motion:
        """What an orbit that grows up to the belt's speed leads to: no orbits cross, so where P's goes."""
        if not self._comes_back:
            return Motion.UNDECIDED
        if self.stick_slip is not None:
            return Motion.STICK_SLIP
        return self._outer[0]

    @cached_property
    def _outer(self) -> list[Motion]:
        """What rounds come to at each mark outside P's orbit, and beyond the last."""
        cycle = {"cycle": Motion.PURE_SLIP}
        return [*(cycle.get(mark.kind, Motion.UNDECIDED) for mark in self.outside.marks), self.beyond]

    @property
    def beyond(self) -> Motion:
        """What becomes of a motion for which no attractor was found farther out."""
        return Motion.UNBOUNDED if self.unbounded else Motion.UNDECIDED

    @property
    def unbounded(self) -> bool:
        """Whether motions far out grow without bound.

        So they do with a negative damping that friction does not outdo, or a coefficient of friction that falls
        below 0 for good.
        """
        system = self.system
        return 2 * system.zeta + system.eta * system.friction_far_out < 0

    def of_rounds(self, begins: FloatArray) -> ObjectArray:
        """Return what rounds outside P's orbit lead to, by where they begin: up to the next mark, or P's orbit."""
        marks, growth = self.outside
        place = np.searchsorted([mark.high for mark in marks], begins)
        ahead = np.array(growth)[place]
        fates = np.array([self.from_onset, *self._outer], dtype=object)[place + (ahead > 0)]
        fates[ahead == 0] = Motion.PURE_SLIP
        for mark, (within, without) in zip(marks, pairwise(growth), strict=True):
            if mark.kind == "open" or within < without:
                margin = ADDED * self.rtol * mark.low
                fates[(begins >= mark.low - margin) & (begins <= mark.high + margin)] = Motion.UNDECIDED
        return fates

    # -- separatrices and basins -------------------------------------------------------------------

    @cached_property
    def separatrices(self) -> tuple[Separatrix, ...]:
        """The curves that part basins, from inside out, but for that of motions without bound.

        They are the unstable limit cycles, and, where orbits inside it shrink while those that stick go on, the
        orbit that just touches the belt's speed.
        """
        grazes = self.growth[-1] < 0 and self.stick_slip is not None
        unstable = [cycle.amplitude for cycle in self.slip_cycles if not cycle.stable]
        return self.curves([1 - A / self.oscillator.V for A in unstable] + [0.0] * grazes)

    def curves(self, least: list[float]) -> tuple[Separatrix, ...]:
        """Return the separatrices whose slip speeds, over V, have certain minima: 0 where one grazes."""
        onset = self.oscillator.onset(self.law)
        separatrices = []
        back = self.system.backward
        for w in least:
            # Backward, since unstable orbits attract those beside them then.
            slip = back.slip(-self.system.turn(w), w, until=SlipEnd.MINIMUM, rtol=self.rtol, recorded=True)
            if slip.end is not SlipEnd.OUTSIDE:
                curve = interpolated(back, slip, self.rtol)
                separatrices.append(Separatrix("limit cycle" if w else "graze", *curve, onset, self.oscillator))
        return tuple(separatrices)

    @cached_property
    def undecided(self) -> tuple[str, ...]:
        """What lies within the tolerance of a boundary, in words; empty as a rule."""
        law = self.law
        osc = self.oscillator
        rest = self.rest
        growth = self.growth
        words = []
        if isinstance(self.height, Unknown):
            words.append(str(self.height))
        if 0 in growth:
            words.append("slip orbits neither grow nor shrink")
        elif abs(rest.rate) * 2 * osc.m <= ROUNDING * (abs(osc.c) + osc.N * abs(law.slope(osc.V))):
            words.append("rest neither attracts nor repels to first order")
        if rest.one_sided:
            words.append("rest attracts motions on one side of it, and repels those on the other")
        elif rest.rate * growth[0] < 0:
            kind = "a stable" if rest.rate > 0 else "an unstable"
            words.append(f"{kind} limit cycle about rest is too small to find")
        for mark in self.outside.marks:
            if mark.kind == "open":
                low, high = (osc.onset(law) + osc.length * q for q in (mark.low, mark.high))
                words.append(f"whether limit cycles overtake the belt from x = {low:.6g} to {high:.6g} m on")
        if self.misses_an_attractor:
            words.append("motions stay within bounds and lose energy, but what they come to was not found")
        return tuple(words)

    @property
    def misses_an_attractor(self) -> bool:
        """Whether none was found though there is one: with damping, and motions far out that do not grow."""
        return not self.attractors and self.oscillator.c > 0 and not self.unbounded

    @cached_property
    def basins(self) -> tuple[Motion, ...] | None:
        """The motions that draw what begins inside the first separatrix, ..., outside the last.

        None where separatrices do not settle it: a motion grows without bound or overtakes the belt, or mu jumps,
        so that motions may slide at a constant slip speed.
        """
        returns = self.stick_slip is not None
        if self.undecided or self.unbounded or any(self.system.rise.jumps) or (self._peak is None and not returns):
            return None
        if self.outside.marks:
            return None
        unstable = [place for place, cycle in enumerate(self.slip_cycles, 1) if not cycle.stable]
        grazes = returns and self.growth[-1] < 0
        curves = self.separatrices
        # The orbit that touches the belt's speed comes from there too.
        if len(curves) < len(unstable) + grazes or (
            grazes and curves[-1].w(curves[-1].w.x[-1]) > ADDED * self.rtol
        ):
            return None
        return (*(self.fate(place) for place in (0, *unstable)), *([Motion.STICK_SLIP] * grazes))

    def by_side(self, x0: FloatArray, v0: FloatArray) -> ObjectArray:
        """Return what initial conditions lead to, arrays in m and m/s, by the separatrices that surround them.

        What begins outside all separatrices comes to stick, or goes round without sticking as P's orbit does,
        which lies outside them too: so does what begins faster than the belt, since it can only come down where
        the mass sticks, or farther out. It is None near a separatrix, and where separatrices do not settle the
        basins.
        """
        motions = np.full(np.broadcast_shapes(x0.shape, v0.shape), None, dtype=object)
        if self.basins is None:
            return motions
        osc = self.oscillator
        q = (x0 - osc.onset(self.law)) / osc.length
        w = 1 - v0 / osc.V
        around = np.zeros(motions.shape, dtype=np.intp)
        clear = np.ones(motions.shape, dtype=bool)
        for separatrix in self.separatrices:
            inside = separatrix.surrounds(q, np.where(w > 0, w, -1.0), ADDED * self.rtol)
            around += inside
            clear &= inside >= 0
        motions[clear] = np.array(self.basins[::-1], dtype=object)[around[clear]]
        return motions

    # -- what is said of it ------------------------------------------------------------------------

    @cached_property
    def periodic_curves(self) -> list[tuple[str, FloatArray, FloatArray]]:
        """The periodic motions as curves of the phase plane: a name, x in m and v in m/s for each."""
        law = self.law
        osc = self.oscillator
        cycle = self.stick_slip
        begins = []
        if cycle is not None:
            begins = [("stick-slip", osc.onset(law), osc.V, cycle.period)]
        for orbit in self.cycles:
            # Where v is highest the forces are in balance; slower than the belt or faster, friction has its sign.
            slip = osc.V - orbit.amplitude
            force = osc.N * law.mu(abs(slip)) * (1 if slip >= 0 else -1)
            name = "pure-slip cycle" if orbit.stable else "pure-slip cycle, unstable"
            begins.append((name, (force - osc.c * orbit.amplitude) / osc.k, orbit.amplitude, orbit.period))
        curves = list[tuple[str, FloatArray, FloatArray]]()
        for name, x0, v0, period in begins:
            motion = simulate(law, osc, t_end=period, x0=x0, v0=v0, rtol=OF_ORBITS)
            deadline.check_time()  # one that was cut short is not kept
            state = motion.at(dense(np.unique(motion.t)))
            curves.append((name, state.x, state.v))
        return curves

    @property
    def attractors(self) -> tuple[Attractor, ...]:
        """The motions that attract others, from inside out."""
        return tuple(attractor for kind in ATTRACTORS for attractor in kind.of(self))

    @property
    def coexist(self) -> bool:
        """Whether there is more than one attractor, so that the initial condition decides."""
        return len(self.attractors) > 1

    def __str__(self) -> str:
        return views_of(self).plain_text(self)

    def __repr__(self) -> str:
        return f"Regime: {'; '.join(str(self).splitlines())}"


def regime(
    law: FrictionLaw | str, osc: Oscillator, *, rtol: float = 1e-12, time_limit: float | None = None
) -> Regime:
    """Return every attractor of an oscillator, and the separatrices where there are several.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Raises
    ------
    InputError
        For an unbound law or an unusable tolerance.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws, regime
    >>> print(regime(laws.exponential.typical(), Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)))
    rest at x = 0.0261867 m
    stick-slip of period 0.631968 s, of which stick 0.0453196 s
    """
    result = kept_regime(as_law(law), as_oscillator(osc), read_rtol(rtol))
    with deadline.time_limit(time_limit):
        deadline.check_time()  # what is kept from earlier calls may need no look at the time
        for name in ("attractors", "separatrices", "basins", "periodic_curves"):
            getattr(result, name)
    return result


@lru_cache  # the maps, basins and classification of one operating point ask for the same motions
def kept_regime(law: FrictionLaw, osc: Oscillator, rtol: float) -> Regime:
    """Return the regime of an oscillator, with what is known of it already."""
    return Regime(law, osc, rtol)


def _swing(osc: Oscillator, slope: float) -> tuple[float, float]:
    """Return the growth rate of small motions where mu has a slope, and how long half a swing takes."""
    growth = -(osc.c + osc.N * slope) / (2 * osc.m)
    excess = (growth - osc.omega) * (growth + osc.omega)
    if excess < 0:
        return growth, math.pi / math.sqrt(-excess)
    root = math.sqrt(excess)
    return (growth + root if growth > 0 else osc.omega**2 / (growth - root)), math.inf

"""What slip does on its own: every pure-slip limit cycle, and whether the orbits between two of them grow.

An orbit in slip has its peaks of velocity at A V. In a plane orbits do not cross, so from peak to peak A only
grows or only shrinks, up to the next limit cycle, to rest, or to the belt's speed. For a smooth law `cycles` knows
the limit cycles by collocation. For any other they are the fixed points of the return map, A to the A of the next
peak, followed by integration.
"""

import math
from bisect import bisect
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.cycles import LimitCycle, limit_cycles, needed_damping
from stickslip_sym.motion.slip import Dimensionless, End, Slip

__all__ = ["SlipOrbits", "lowest", "next_peak", "overtaking_cycle", "round_from", "slip_orbits"]

_NEAREST = 1e-3  # lowest amplitude over the belt's speed that is looked at: a smaller cycle is not seen
_FIRST = 1e-3  # displacement q at which a round outside P's is tried first
_ESCAPED = 1e6  # the last q tried, and the peak over V of a motion without bound
_STRONGEST = 1e-300  # contraction of a round that can still be told from 0


@dataclass(frozen=True)
class SlipOrbits:
    """The limit cycles in slip, and the way between them."""

    cycles: tuple[LimitCycle, ...]  # by ascending amplitude
    growth: tuple[int, ...]
    """1 where orbits grow, -1 where they shrink, 0 where all are periodic: below the first cycle, between two, and
    above the last."""

    def fate(self, peak: float) -> LimitCycle | float:
        """Return the limit cycle to which an orbit with a peak velocity in m/s tends, else 0 (rest) or infinity.

        Where all orbits are periodic it is NaN.
        """
        place = bisect([cycle.amplitude for cycle in self.cycles], peak)
        if self.growth[place] == 0:
            return math.nan
        if self.growth[place] > 0:
            return self.cycles[place] if place < len(self.cycles) else math.inf
        return self.cycles[place - 1] if place else 0.0


@lru_cache(maxsize=256)  # the maps and basins of one operating point ask again and again
def slip_orbits(law: FrictionLaw, osc: Oscillator, *, rtol: float) -> SlipOrbits:
    """Return the limit cycles of an oscillator in slip, up to the belt's speed.

    Raises `InputError` for an unbound law.
    Raises `NotConverged` when the bound on the work is reached.
    """
    system = Dimensionless.of(law, osc)
    # The return map grows with A, since orbits do not cross: its value at one end may settle all.
    if (1 - lowest(system, rtol) if system.turn(0.0) == 0 else next_peak(system, 1.0, rtol)[0]) <= _NEAREST:
        return SlipOrbits((), (-1,))
    if system.decay(1.0) <= 0 and next_peak(system, _NEAREST, rtol)[0] >= 1:
        return SlipOrbits((), (1,))
    need, cycles = needed_damping(law, osc), limit_cycles(law, osc)
    bounds = [0.0, *(cycle.amplitude / osc.V for cycle in cycles), 1.0]
    # An orbit grows where it needs more damping than there is.
    gaps = [need.gap((low + high) / 2, 2 * osc.zeta)[0] for low, high in pairwise(bounds)]
    return SlipOrbits(cycles, tuple(int(np.sign(gap)) for gap in gaps))


def next_peak(
    system: Dimensionless, amplitude: float, rtol: float, *, recorded: bool = False
) -> tuple[float, float, Slip]:
    """Return the next peak of the velocity over V, its derivative by the amplitude, and the slip that leads there.

    Where the mass meets the belt before, with an acceleration a, it is 1 + a^2/2 in units of omega V: the peak to
    which the spring alone would pull it. At rest it is 0; of a motion without bound it is very large.
    """
    w = 1 - amplitude
    slip = system.slip(
        system.turn(w), w, until=End.MINIMUM, rtol=rtol, wedge=system.no_wedge, D=-amplitude, recorded=recorded
    )
    if slip.end is End.RETURN:
        return 1 + slip.rate**2 / 2, math.nan, slip
    if slip.end is End.MINIMUM:
        return 1 - slip.w, slip.wedge / (slip.w - 1), slip
    return (_ESCAPED if slip.end is End.OUTSIDE else 0.0), math.nan, slip


@lru_cache(maxsize=256)  # a regime, its basins and classifications ask for the same slip
def lowest(system: Dimensionless, rtol: float) -> float:
    """Return the first minimum of the slip speed, over V, after P.

    Where the mass returns with w' it is -w'^2/2; -infinity where it moves away for ever, and 1 where it creeps to
    rest.
    """
    slip = system.slip(0.0, 0.0, until=End.MINIMUM, rtol=rtol)
    if slip.end is End.RETURN:
        return -(slip.rate**2) / 2
    if slip.end is End.OUTSIDE:
        return -math.inf
    return slip.w if slip.end is End.MINIMUM else 1.0


def _limit_cycle(osc: Oscillator, amplitude: float, tau: float, factor: float) -> LimitCycle:
    """Return the cycle of an amplitude and a period, free of units, from which deviations grow by a factor."""
    floquet = math.log(max(factor, _STRONGEST)) / tau
    return LimitCycle(osc.V * amplitude, tau / osc.omega, floquet * osc.omega, floquet < 0)


def overtaking_cycle(law: FrictionLaw, osc: Oscillator, *, rtol: float) -> LimitCycle | None:
    """Return the innermost limit cycle that overtakes the belt each round and never sticks, or None.

    Where friction is weak, N << V sqrt(k m), the mass arrives at the belt's speed where static friction cannot
    hold it. It overtakes the belt, up to where the work of friction there balances the gain below. A law with
    mu(0) = 0 never sticks, and its relaxation oscillation is of this kind.
    """
    system = Dimensionless.of(law, osc)
    if not round_from(system, 0.0, rtol).end > 0:
        return None
    inner, outer = 0.0, _FIRST
    while (end := round_from(system, outer, rtol).end) > outer:
        inner, outer = outer, 4 * outer
        if outer > _ESCAPED:
            return None
    if math.isnan(end):
        return None
    q = float(brentq(lambda q: round_from(system, q, rtol).end - q, inner, outer, xtol=1e-14, rtol=1e-13))
    cycle = round_from(system, q, rtol)
    return _limit_cycle(osc, 1 + cycle.speed, cycle.tau, cycle.factor)


@dataclass(frozen=True)
class Round:
    """A round that leaves the belt's speed, to slower motion first.

    Attributes
    ----------
    end : float
        Displacement q where slip slower than the belt begins again: NaN if the mass sticks, 0 if it stays slower
        than the belt, infinity if it moves away for ever.
    tau : float
        The time it takes.
    speed : float
        The highest velocity above the belt's, over V.
    factor : float
        The derivative of the end by the begin.
    """

    end: float
    tau: float
    speed: float = 0.0
    factor: float = math.nan


def round_from(system: Dimensionless, q: float, rtol: float) -> Round:
    """Follow a round from a displacement q >= 0."""
    begin = system.acceleration(q, 0.0, 1)
    slow = system.slip(q, 0.0, 1, until=End.MINIMUM, rtol=rtol, wedge=system.no_wedge, D=-begin)
    if slow.end is not End.RETURN:
        return Round(math.inf if slow.end is End.OUTSIDE else 0.0, slow.tau)
    if system.sticks(slow.q):
        return Round(math.nan, slow.tau)
    change = -slow.wedge / slow.rate  # of the q at which the mass overtakes the belt
    begin = system.acceleration(slow.q, 0.0, -1)
    fast = system.slip(slow.q, 0.0, -1, rtol=rtol, wedge=system.no_wedge, D=-begin * change, recorded=True)
    tau = slow.tau + fast.tau
    if fast.end is End.OUTSIDE:
        return Round(math.inf, tau)
    if fast.end is not End.RETURN or system.sticks(fast.q):
        return Round(math.nan, tau)
    return Round(fast.q, tau, max(step.w for step in fast.steps), -fast.wedge / fast.rate)

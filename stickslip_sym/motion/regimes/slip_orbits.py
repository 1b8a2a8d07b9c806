"""What slip does on its own: every pure-slip limit cycle, and whether the orbits between two of them grow.

An orbit in slip has its peaks of velocity at A V. In a plane orbits do not cross, so from peak to peak A only
grows or only shrinks, up to the next limit cycle, to rest, or to the belt's speed. For a smooth law `cycles` knows
the limit cycles by collocation. For any other they are the fixed points of the return map, A to the A of the next
peak, followed by integration.
"""

import math
from bisect import bisect
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.cycles import LimitCycle, limit_cycles, needed_damping
from stickslip_sym.motion.slip import Dimensionless, End, Slip

__all__ = ["SlipOrbits", "by_return_map", "lowest", "next_peak", "overtaking_cycle", "round_from", "slip_orbits"]

_NEAREST = 1e-3  # lowest amplitude that is looked at: a smaller cycle is not seen
_NODES = sorted(
    {float(A) for A in _NEAREST + (1 - _NEAREST) * (1 - np.cos(np.linspace(0.0, math.pi, 33))) / 2}
    | {1 - 10.0**-decade for decade in range(3, 7)}
)  # amplitudes over the belt's speed; graded towards the belt's speed, where laws are steep
_NEUTRAL = 1e-11  # growth a round below which an integration cannot tell its sign
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
    peaks = _Peaks(Dimensionless.of(law, osc), rtol)
    lone = peaks.lone_growth
    if lone is not None:
        return SlipOrbits((), (lone,))
    need = needed_damping(law, osc)  # an orbit grows where it needs more damping than there is
    return _ordered(limit_cycles(law, osc), osc.V, lambda A: need.gap(A, 2 * osc.zeta)[0], 0.0)


def _ordered(cycles: tuple[LimitCycle, ...], V: float, gain: Callable[[float], float], flat: float) -> SlipOrbits:
    """Take the growth between cycles from one orbit of each interval."""
    bounds = [0.0, *(cycle.amplitude / V for cycle in cycles), 1.0]
    gains = [gain((low + high) / 2) for low, high in pairwise(bounds)]
    return SlipOrbits(cycles, tuple(0 if abs(g) <= flat else int(np.sign(g)) for g in gains))


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


class _Peaks:
    """The return map of slip orbits, A to the A of the next peak, which grows with A since orbits do not cross."""

    def __init__(self, system: Dimensionless, rtol: float) -> None:
        self.system, self.rtol = system, rtol
        self.known: dict[float, float] = {}

    def after(self, amplitude: float) -> float:
        """Return the next peak."""
        if amplitude not in self.known and amplitude == 1 and self.system.turn(0.0) == 0:
            self.known[amplitude] = min(1 - lowest(self.system, self.rtol), _ESCAPED)  # the slip from P
        if amplitude not in self.known:
            self.known[amplitude] = next_peak(self.system, amplitude, self.rtol)[0]
        return self.known[amplitude]

    def gain(self, amplitude: float) -> float:
        """Return the relative growth in one round."""
        return self.after(amplitude) / amplitude - 1

    @property
    def lone_growth(self) -> int | None:
        """Whether all orbits grow (1) or shrink (-1), where one round from an end shows it; None elsewhere."""
        if self.system.decay(1.0) > 0:
            return -1 if self.after(1.0) <= _NODES[0] else None
        return 1 if self.after(_NODES[0]) >= 1 else None

    def brackets(self) -> list[tuple[float, float]]:
        """Return pairs of amplitudes between which the growth changes its sign."""
        found, open_ranges = [], [(0, len(_NODES) - 1)]
        while open_ranges:
            first, last = open_ranges.pop()
            low, high = _NODES[first], _NODES[last]
            if self.after(low) >= high or self.after(high) <= low:
                continue  # the map is monotone, and passes over all that lies between
            if last - first > 1:
                middle = (first + last) // 2
                open_ranges += [(middle, last), (first, middle)]
                continue
            gains = self.gain(low), self.gain(high)
            if gains[0] * gains[1] < 0 and max(map(abs, gains)) > _NEUTRAL:
                found.append((low, high))
        return found


def by_return_map(law: FrictionLaw, osc: Oscillator, rtol: float) -> SlipOrbits:
    """Return the same by the return map, for every law."""
    peaks = _Peaks(Dimensionless.of(law, osc), rtol)
    roots = [brentq(peaks.gain, *bracket, rtol=max(rtol, 1e-14)) for bracket in peaks.brackets()]
    cycles = tuple(_cycle(peaks.system, osc, float(root), rtol) for root in roots)
    return _ordered(cycles, osc.V, peaks.gain, _NEUTRAL)


def _cycle(system: Dimensionless, osc: Oscillator, amplitude: float, rtol: float) -> LimitCycle:
    _, factor, slip = next_peak(system, amplitude, rtol)
    return _limit_cycle(osc, amplitude, slip.tau, factor)


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

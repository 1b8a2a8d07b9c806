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

from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.orbits.cycles import LimitCycle, cycles_among, needed_damping
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase, Until
from stickslip_sym.motion.simulation.steppers import Point

__all__ = ["SlipOrbits", "by_simulation", "next_peak", "overtaking_cycle", "round_from", "slip_orbits", "trough"]

_MOST_WORK = 5e7  # cubes of grids: about as long as following the orbits at these amplitudes takes
_NEAREST = 1e-3  # lowest amplitude that is looked at: a smaller cycle is not seen
_NODES = sorted(
    {float(A) for A in _NEAREST + (1 - _NEAREST) * (1 - np.cos(np.linspace(0.0, math.pi, 33))) / 2}
    | {1 - 10.0**-decade for decade in range(3, 7)}
)  # amplitudes over the belt's speed; graded towards the belt's speed, where laws are steep
_NEUTRAL = 1e-11  # growth a round below which an integration cannot tell its sign
_STEP = 1e-5  # of amplitude, for the slope of the return map
_LONGEST = 1e3  # of dimensionless time, for one slip phase; more where damping makes it creep
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


@lru_cache(maxsize=256)  # the maps and the basins of one scene ask again and again
def slip_orbits(law: FrictionLaw, osc: Oscillator, *, rtol: float) -> SlipOrbits:
    """Return the limit cycles of an oscillator in slip, up to the belt's speed.

    Raises `InputError` for an unbound law.
    Raises `NotConverged` when the bound on the work is reached.
    """
    peaks = _Peaks(Scene.of(law, osc), rtol)
    lone = peaks.lone_growth
    if lone is not None:
        return SlipOrbits((), (lone,))
    try:
        need = needed_damping(law, osc, most_work=_MOST_WORK)
        cycles = cycles_among(need, law, osc)
    except (InputError, NotConverged):  # not smooth, or too strong a friction or too thin a layer for collocation
        return by_simulation(law, osc, rtol)
    flat = 1e-14 * np.abs(need.series).max()
    return _ordered(cycles, osc.V, lambda amplitude: float(need.at(amplitude)) - 2 * osc.zeta, flat)


def _ordered(cycles: tuple[LimitCycle, ...], V: float, gain: Callable[[float], float], flat: float) -> SlipOrbits:
    """Take the growth between cycles from one orbit of each interval."""
    bounds = [0.0, *(cycle.amplitude / V for cycle in cycles), 1.0]
    gains = [gain((low + high) / 2) for low, high in pairwise(bounds)]
    return SlipOrbits(cycles, tuple(0 if abs(g) <= flat else int(np.sign(g)) for g in gains))


def trough(scene: Scene, amplitude: float) -> Point:
    """Return the state of least slip speed, 1 - amplitude, where the velocity has its peak."""
    w = 1 - amplitude
    return Point(0.0, scene.turn(w), w)


def next_peak(scene: Scene, amplitude: float, rtol: float) -> tuple[float, SlipPhase]:
    """Return the next peak of the velocity over V, and the slip phase that leads there.

    Where the mass meets the belt before, with an acceleration a, it is 1 + a^2/2 in units of omega V: the peak to
    which the spring alone would pull it. At rest it is 0; of a motion without bound it is very large.
    """
    slip = follow(scene, trough(scene, amplitude), 1, horizon=_horizon(scene), rtol=rtol, until=End.MINIMUM)
    if slip.end is End.RETURN:
        return 1 + scene.acceleration(slip.last.q, 0.0, 1) ** 2 / 2, slip
    if slip.end is End.UNBOUNDED:
        return _ESCAPED, slip
    return (1 - slip.last.w if slip.end is End.MINIMUM else 0.0), slip


class _Peaks:
    """The return map of slip orbits, A to the A of the next peak, which grows with A since orbits do not cross."""

    def __init__(self, scene: Scene, rtol: float) -> None:
        self.scene, self.rtol, self.levels = scene, rtol, Levels(scene)
        self.known: dict[float, float] = {}

    def after(self, amplitude: float) -> float:
        """Return the next peak."""
        if amplitude not in self.known:
            found = self.levels.next_peak(self.scene.zeta, amplitude, self.rtol)
            self.known[amplitude] = next_peak(self.scene, amplitude, self.rtol)[0] if found is None else found
        return self.known[amplitude]

    def gain(self, amplitude: float) -> float:
        """Return the relative growth in one round."""
        return self.after(amplitude) / amplitude - 1

    @property
    def lone_growth(self) -> int | None:
        """Whether all orbits grow (1) or shrink (-1), where one round from an end shows it; None elsewhere."""
        if self.scene.decay(1.0) > 0:
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


def by_simulation(law: FrictionLaw, osc: Oscillator, rtol: float) -> SlipOrbits:
    """Return the same by the return map of simulated orbits, for every law."""
    peaks = _Peaks(Scene.of(law, osc), rtol)
    roots = [brentq(peaks.gain, *bracket, rtol=max(rtol, 1e-14)) for bracket in peaks.brackets()]
    cycles = tuple(_cycle(peaks.scene, osc, float(root), rtol) for root in roots)
    return _ordered(cycles, osc.V, peaks.gain, _NEUTRAL)


def _cycle(scene: Scene, osc: Oscillator, amplitude: float, rtol: float) -> LimitCycle:
    _, slip = next_peak(scene, amplitude, rtol)
    step = min(_STEP, (1 - amplitude) / 2)
    ahead, behind = (next_peak(scene, amplitude + shift, rtol)[0] for shift in (step, -step))
    floquet = math.log(max((ahead - behind) / (2 * step), _STRONGEST)) / slip.last.tau
    return LimitCycle(amplitude * osc.V, slip.last.tau / osc.omega, floquet * osc.omega, floquet < 0)


def overtaking_cycle(law: FrictionLaw, osc: Oscillator, *, rtol: float) -> LimitCycle | None:
    """Return the innermost limit cycle that overtakes the belt each round and never sticks, or None.

    Where friction is weak, N << V sqrt(k m), the mass arrives at the belt's speed where static friction cannot
    hold it. It overtakes the belt, up to where the work of friction there balances the gain below. A law with
    mu(0) = 0 never sticks, and its relaxation oscillation is of this kind.
    """
    scene = Scene.of(law, osc)
    if not round_from(scene, 0.0, rtol)[0] > 0:
        return None
    inner, outer = 0.0, _FIRST
    while (end := round_from(scene, outer, rtol)[0]) > outer:
        inner, outer = outer, 4 * outer
        if outer > _ESCAPED:
            return None
    if math.isnan(end):
        return None
    q = float(brentq(lambda q: round_from(scene, q, rtol)[0] - q, inner, outer, xtol=1e-14, rtol=1e-13))
    _, tau, speed = round_from(scene, q, rtol)
    step = _STEP * q
    ahead, behind = (round_from(scene, q + shift, rtol)[0] for shift in (step, -step))
    floquet = math.log(max((ahead - behind) / (2 * step), _STRONGEST)) / tau
    return LimitCycle(osc.V * (1 + speed), tau / osc.omega, floquet * osc.omega, floquet < 0)


def round_from(scene: Scene, q: float, rtol: float) -> tuple[float, float, float]:
    """Follow a round that leaves the belt's speed at q >= 0, to slower motion first.

    Returns `q, tau, speed`: where slip slower than the belt begins again, the time it took, and the highest
      velocity above the belt's, over V. If the mass sticks q is NaN; if it stays slower than the belt, 0; if it
      moves away for ever, infinity.
    """
    slow = _phase(scene, q, 1, rtol)
    if slow.end is End.UNBOUNDED:
        return math.inf, slow.last.tau, 0.0
    if slow.end is not End.RETURN:
        return 0.0, slow.last.tau, 0.0
    if scene.sticks(slow.last.q):
        return math.nan, slow.last.tau, 0.0
    fast = _phase(scene, slow.last.q, -1, rtol)
    if fast.end is End.UNBOUNDED:
        return math.inf, slow.last.tau + fast.last.tau, 0.0
    stuck = fast.end is not End.RETURN or scene.sticks(fast.last.q)
    speed = max((point.w for point in fast.extrema), default=0.0)
    return (math.nan if stuck else fast.last.q), slow.last.tau + fast.last.tau, speed


def _phase(scene: Scene, q: float, side: int, rtol: float) -> SlipPhase:
    until: Until = End.MINIMUM if side > 0 else End.RETURN
    return follow(scene, Point(0.0, float(q), 0.0), side, horizon=_horizon(scene), rtol=rtol, until=until)


def _horizon(scene: Scene) -> float:
    return _LONGEST * (1 + abs(scene.zeta))

"""Which basin a start lies in, by the side of the boundaries it lies on; no start is simulated.

Rest, or a limit cycle in pure slip, coexists with other motions inside the unstable limit cycles, and inside the
orbit that just touches the belt's speed. All these curves lie below the belt's speed, one inside the other. What
begins outside them comes to stick, or goes round without sticking as P's orbit does, which lies outside them too:
so does what begins faster than the belt, since it can only come down where the mass sticks, or further out.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.maps.boundaries import Boundary, Box, touching_orbit
from stickslip_sym.motion.maps.cells import MOTIONS
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import Regime, graze
from stickslip_sym.motion.regimes.classification import Motion
from stickslip_sym.motion.regimes.slip_orbits import next_peak, slip_orbits

__all__ = ["FINEST", "Sides", "sides_of"]

FINEST = 1e-12
"""The relative tolerance of separatrices: they are few, and decide about many starts."""

_NEAR = 100  # tolerances: starts closer to a boundary are simulated
_JUMP = 1e-12  # relative jump of mu; a smaller one is rounding


@dataclass(frozen=True)
class Sides:
    """The boundaries, from inside out, and the motions between them.

    Attributes
    ----------
    osc : Oscillator
    onset : float
        Displacement x of q = 0 in m.
    rtol : float
        Of the boundaries.
    boundaries : tuple of Boundary
    within : tuple of Motion
        Inside the first boundary, between it and the second, ..., outside the last.
    """

    osc: Oscillator
    onset: float
    rtol: float
    boundaries: tuple[Boundary, ...]
    within: tuple[Motion, ...]

    def motions(self, x0: FloatArray, v0: FloatArray) -> IntArray:
        """Return the places in `MOTIONS` of what starts lead to, a row for each v0; -1 near a boundary."""
        q, w = self._q(x0), 1 - v0 / self.osc.V
        around = np.zeros((w.size, q.size), dtype=np.intp)
        near = np.zeros(around.shape, dtype=bool)
        for curve in self.boundaries:
            rows, places = curve.crossings(np.where(w > 0, w, -1.0))
            passed = np.zeros((w.size, q.size + 1), dtype=np.intp)
            np.add.at(passed, (rows, np.searchsorted(q, places)), 1)
            around += np.cumsum(passed, axis=1)[:, :-1] % 2
            margin = _NEAR * self.rtol * (1 + np.abs(places))
            first, behind = np.searchsorted(q, places - margin), np.searchsorted(q, places + margin, side="right")
            for close in np.flatnonzero(behind > first):
                near[rows[close], first[close] : behind[close]] = True
        from_outside = [MOTIONS.index(motion) for motion in reversed(self.within)]
        return np.where(near, -1, np.array(from_outside, dtype=np.intp)[around])

    def shares(self, x0: tuple[float, float], v0: tuple[float, float]) -> dict[Motion, float]:
        """Return what part of a box of starts leads to each motion, by the areas inside the boundaries."""
        q, slip = self._q(np.array(x0)), np.clip(1 - np.array(v0) / self.osc.V, 0.0, None)
        box = Box(tuple(q.tolist()), tuple(slip[::-1].tolist()))
        whole = float(q[1] - q[0]) * (v0[1] - v0[0]) / self.osc.V
        inside = [0.0, *(curve.area_within(box) for curve in self.boundaries), whole]
        found = dict.fromkeys(self.within, 0.0)
        for motion, (low, high) in zip(self.within, pairwise(inside), strict=True):
            found[motion] += (high - low) / whole
        return found

    def _q(self, x: FloatArray) -> FloatArray:
        return (x - self.onset) / self.osc.length


def sides_of(law: FrictionLaw, osc: Oscillator, found: Regime, *, rtol: float = FINEST) -> Sides | None:
    """Return the boundaries of the basins; None where geometry does not settle them.

    It does for every oscillator whose motions end at rest, in a pure-slip cycle below the belt's speed or in
    stick-slip, with a law that has no jumps.

    Raises
    ------
    NotConverged
        When the bound on the work is reached.
    """
    scene = Scene.of(law, osc)
    if found.undecided or found.unbounded or found.rest.one_sided or _jumps(scene):
        return None
    height = graze(scene, rtol)
    if height == 0 or (height < 0 and found.stick_slip is None):
        return None
    orbits = slip_orbits(law, osc, rtol=FINEST)
    unstable = [cycle.amplitude for cycle in orbits.cycles if not cycle.stable]
    peaks = [(low + high) / 2 for low, high in pairwise([0.0, *unstable, osc.V])]
    curves = [Boundary(next_peak(scene, amplitude / osc.V, rtol)[1]) for amplitude in unstable]
    within = [_motion_of(orbits.fate(peak)) for peak in peaks]
    if height < 0 and orbits.growth[-1] < 0:
        try:
            curves.append(touching_orbit(scene, rtol))
        except StickSlipError:
            return None
        within.append(Motion.STICK_SLIP)
    return Sides(osc, osc.onset(law), rtol, tuple(curves), tuple(within))


def _motion_of(fate: LimitCycle | float) -> Motion:
    """Return the motion that an orbit in slip tends to; one that grows up to the belt's speed comes to stick."""
    if isinstance(fate, LimitCycle):
        return Motion.PURE_SLIP
    return Motion.DAMPED_SLIP if fate == 0 else Motion.STICK_SLIP


def _jumps(scene: Scene) -> bool:
    """Whether mu jumps: motions may then slide at a constant slip speed, and are no longer parted by curves."""
    ends = [(before.rise(after.low), after.rise(after.low)) for before, after in pairwise(scene.branches)]
    return any(abs(after - before) > _JUMP * (abs(scene.onset) + abs(before)) for before, after in ends)

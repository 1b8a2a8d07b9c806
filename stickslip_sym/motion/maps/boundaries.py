"""The boundaries of the basins of attraction in the phase plane, as slip phases that can be intersected."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase
from stickslip_sym.motion.simulation.steppers import Point

__all__ = ["Boundary", "Box", "touching_orbit"]

_LONGEST = 1e3  # dimensionless time for which one orbit is followed at most
_HALVINGS = 60  # bisections of a step, after which a place on it is known to rounding
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(9)  # exact where q and w are of degree 8 in a step
_SLOPES = np.linalg.solve(
    np.vander(_NODES, increasing=True).T,
    (np.arange(9) * np.vander(_NODES, increasing=True)[:, [0, *range(8)]]).T,
).T  # from values at the nodes to derivatives there


@dataclass(frozen=True)
class Box:
    """A rectangle below the belt's speed: displacements q, and slip speeds w >= 0."""

    q: tuple[float, float]
    w: tuple[float, float]

    @property
    def area(self) -> float:
        """The area; 0 where nothing of it lies on this side."""
        return (self.q[1] - self.q[0]) * max(self.w[1] - self.w[0], 0.0)


@dataclass(frozen=True)
class Boundary:
    """A closed curve below the belt's speed: a limit cycle, or an orbit with its piece of the line w = 0.

    Attributes
    ----------
    phase : SlipPhase
        The slip along it.
    forward : int
        1 where q is that of the phase; -1 where the phase was integrated backward in time, so that it is -q.
    """

    phase: SlipPhase
    forward: int = 1

    def crossings(self, levels: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return where the curve passes slip speeds: the places of the levels, and the q there."""
        index, tau = self._passages(1, np.asarray(levels))
        return index, self.forward * self.phase.at(tau)[0]

    def area_within(self, box: Box) -> float:
        """Return the area inside the curve and the box, the integral of q dw, with q cut at the box (Green).

        What closes an orbit, on w = 0, adds nothing.
        """
        if box.area == 0:
            return 0.0
        sides = np.sort(self.forward * np.array(box.q))
        cuts = [self._passages(row, values)[1] for row, values in ((0, sides), (1, np.array(box.w)))]
        times = np.unique(np.concatenate([self._times, *cuts]))
        middle, half = (times[1:] + times[:-1]) / 2, (times[1:] - times[:-1]) / 2
        q, w = self.phase.at(middle[:, None] + half[:, None] * _NODES)
        centre = w[:, w.shape[1] // 2]
        inside = (centre > box.w[0]) & (centre < box.w[1])
        parts = (np.clip(q, *sides) * (w @ _SLOPES.T)) @ _WEIGHTS
        return abs(float(parts[inside].sum()))

    @cached_property
    def _times(self) -> FloatArray:
        """Times between which both q and w are monotone, and which no step passes."""
        points = [*self.phase.points, *self.phase.extrema]
        known = np.unique([point.tau for point in points])
        still = self._between(known, 1, np.array([1.0]))[1]  # q turns where the mass stands still
        return np.unique(np.concatenate([known, still]))

    def _passages(self, row: int, levels: FloatArray) -> tuple[IntArray, FloatArray]:
        return self._between(self._times, row, levels)

    def _between(self, times: FloatArray, row: int, levels: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return where q (row 0) or w (row 1), monotone between the times, passes levels: which, and when."""
        value = self.phase.at(times)[row]
        low, high = np.minimum(value[1:], value[:-1]), np.maximum(value[1:], value[:-1])
        step, index = np.nonzero((low[:, None] <= levels) & (levels < high[:, None]))
        before, after, rises = times[step], times[step + 1], value[step + 1] > value[step]
        for _ in range(_HALVINGS):
            middle = (before + after) / 2
            beyond = (self.phase.at(middle)[row] >= levels[index]) == rises
            before, after = np.where(beyond, before, middle), np.where(beyond, middle, after)
        return index, (before + after) / 2


def touching_orbit(scene: Scene, rtol: float) -> Boundary:
    """Return the orbit that just touches the belt's speed, from where it left that speed before.

    It is followed backward from the touch: with time reversed and q mirrored the equations keep their form, and
    friction and damping change sign.

    Raises
    ------
    NotConverged
        If it does not come from the belt's speed.
    """
    backward = replace(scene, eta=-scene.eta, zeta=-scene.zeta)
    phase = follow(backward, Point(0.0, backward.turn(0.0), 0.0), 1, horizon=_LONGEST, rtol=rtol)
    if phase.end is not End.RETURN:
        raise NotConverged("the orbit that just touches the belt's speed does not come from there")
    return Boundary(phase, -1)

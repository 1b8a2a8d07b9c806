"""The curves that part basins of attraction, as polynomials that can be intersected.

Rest, or a limit cycle in pure slip, coexists with other motions inside the unstable limit cycles, and inside the
orbit that just touches the belt's speed. All these curves lie below the belt's speed, one inside the other.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.polynomial import chebyshev
from scipy.interpolate import PPoly

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.slip import NondimensionalOscillator, Slip
from stickslip_sym.output.data import DataResult

_SEPARATRIX_POINTS = 257  # of a separatrix, in its public arrays
_STEP_DEGREE = 12  # of the polynomials within a step, whose remainder is below the tolerance of steps of order 8


def interpolated(back: NondimensionalOscillator, slip: Slip[float], rtol: float) -> tuple[Any, Any]:
    """Return q and w along a recorded slip of a system backward in time, as polynomials in each of its steps."""
    steps = [step for step in slip.steps if step.length > 0]
    nodes = (1 + chebyshev.chebpts2(_STEP_DEGREE + 1)) / 2
    tau = np.array([step.tau + step.length * nodes for step in steps]).ravel()
    q, w = back.states(steps, np.repeat(np.arange(len(steps)), nodes.size), tau, 1.0, rtol)
    powers = np.vander(nodes)
    number = np.arange(len(steps) + 1.0)
    q, w = (np.linalg.solve(powers, values.reshape(-1, nodes.size).T) for values in (-q, w))
    return PPoly(q, number), PPoly(w, number)


@dataclass(frozen=True, repr=False)
class Separatrix(DataResult):
    """A curve in the phase plane that separates two basins of attraction: a slip below the belt's speed.

    Attributes
    ----------
    kind : str
        "limit cycle": an unstable one, closed; "graze": the orbit that just touches the belt's speed, closed by
        the part of the line v = V between its ends.
    q, w : scipy.interpolate.PPoly
        Displacement and slip speed along it, free of units: polynomials of the number of the step, with the part
        of it that is over.
    onset : float
        Displacement in m where q = 0.
    oscillator : Oscillator
    """

    reported = ("kind", "x", "v")

    kind: Literal["limit cycle", "graze"]
    q: Any
    w: Any
    onset: float
    oscillator: Oscillator

    def surrounds(self, q: FloatArray, w: FloatArray, margin: float) -> IntArray:
        """Return 1 for points inside the curve, 0 for those outside, and -1 for those within a margin of it.

        What closes an orbit, on w = 0, counts as part of it.
        """
        levels, row = np.unique(w, return_inverse=True)
        row = row.reshape(w.shape)
        heights = self.w(self.w.x)
        top = int(np.argmax(heights))
        last = heights.size - 1
        inside = np.zeros(np.broadcast_shapes(q.shape, w.shape), dtype=bool)
        near = inside.copy()
        for begin, end in ((0, top), (top, last)):  # from one minimum of w to the next it rises, then falls
            low, high = np.sort(heights[[begin, end]])
            passed = np.flatnonzero((low <= levels) & (levels < high))
            before = np.full(passed.size, float(begin))
            after = np.full(passed.size, float(end))
            width = float(end - begin)
            while width > np.spacing(1.0):  # then a place on a step is known to rounding
                width /= 2
                middle = (before + after) / 2
                beyond = (self.w(middle) >= levels[passed]) == (heights[end] > heights[begin])
                before = np.where(beyond, before, middle)
                after = np.where(beyond, middle, after)
            crossing = np.full(levels.size, np.inf)
            crossing[passed] = self.q((before + after) / 2)
            off = crossing[row] - q
            inside ^= off < 0
            near |= np.abs(off) <= margin * (1 + np.abs(q))
        return np.where(near, -1, inside)

    def area_within(self, q: FloatArray, w: FloatArray) -> float:
        """Return the area inside the curve and a box, the integral of q dw, with q cut at the box (Green).

        What closes an orbit, on w = 0, adds nothing.

        - `q, w`: the lower and the upper side of the box.
        """
        if not (q[1] > q[0] and w[1] > w[0]):
            return 0.0
        cuts = [self.q.solve(side, extrapolate=False) for side in q]
        cuts += [self.w.solve(side, extrapolate=False) for side in w]
        ends = np.unique(np.concatenate([self.w.x, *cuts]))
        ends = ends[np.isfinite(ends)]
        middle = (ends[1:] + ends[:-1]) / 2
        half = np.diff(ends) / 2
        nodes, weights = np.polynomial.legendre.leggauss(_STEP_DEGREE)  # exact for the product q w' of polynomials
        places = middle[:, None] + half[:, None] * nodes
        integrand = np.clip(self.q(places), *q) * self.w.derivative()(places)
        centre = self.w(middle)
        inside = (centre > w[0]) & (centre < w[1])
        return abs(float((half * (integrand @ weights))[inside].sum()))

    @property
    def x(self) -> FloatArray:
        """Displacements in m along it."""
        return np.asarray(self.onset + self.oscillator.length * self.q(self._samples))

    @property
    def v(self) -> FloatArray:
        """Velocities in m/s along it."""
        return np.asarray(self.oscillator.V * (1 - self.w(self._samples)))

    @property
    def _samples(self) -> FloatArray:
        return np.linspace(0.0, self.w.x[-1], _SEPARATRIX_POINTS)

    def __repr__(self) -> str:
        return f"Separatrix: {self.kind}, {_SEPARATRIX_POINTS} points"

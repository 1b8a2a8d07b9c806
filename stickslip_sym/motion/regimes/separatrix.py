"""The curves that part basins of attraction, as polynomials of time that can be intersected.

Rest, or a limit cycle in pure slip, coexists with other motions inside the unstable limit cycles, and inside the
orbit that just touches the belt's speed. All these curves lie below the belt's speed, one inside the other.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.slip import Dimensionless, Slip

__all__ = ["Separatrix", "SeparatrixKind", "SlipCurve"]

SeparatrixKind = Literal["limit cycle", "graze"]
_SAMPLES = 257  # of a separatrix, in its public arrays
_DEGREE = 12  # of the polynomials within a step, whose remainder is below the tolerance of steps of order 8
_NODES = chebyshev.chebpts2(_DEGREE + 1)
_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(_NODES, _DEGREE))
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(_DEGREE)  # exact for the product q w' of two such polynomials
_ON_BELT = 1e-9  # slip speed over the belt's, at the end of an orbit that returns
_HALVINGS = 60  # bisections of a step, after which a time on it is known to rounding


@dataclass(frozen=True)
class SlipCurve:
    """A slip below the belt's speed: displacement q and slip speed w as functions of time, free of units.

    Attributes
    ----------
    times : numpy.ndarray, shape (n + 1,)
        The ends of the steps.
    series : numpy.ndarray, shape (2, degree + 1, n)
        Chebyshev coefficients of q and w within each step.
    """

    times: FloatArray
    series: FloatArray

    @classmethod
    def of(cls, system: Dimensionless, slip: Slip, rtol: float, *, backward: bool = False) -> "SlipCurve":
        """Interpolate a recorded slip below the belt's speed, in steps of the integration."""
        steps = [step for step in slip.steps if step.length > 0]
        parts = (1 + _NODES) / 2 * (-1 if backward else 1)
        which = np.repeat(np.arange(len(steps)), parts.size)
        tau = np.array([step.tau + step.length * parts for step in steps]).ravel()
        values = np.array(system.states(steps, which, tau, 1, rtol)).reshape(2, len(steps), parts.size)
        return cls.through(np.array([*(step.tau for step in steps), slip.tau]), values)

    @classmethod
    def through(cls, times: FloatArray, values: FloatArray) -> "SlipCurve":
        """Interpolate q and w, of shape (2, n, degree + 1), at Chebyshev points within each step."""
        return cls(times, np.einsum("kj,rij->rki", _COEFFICIENTS, values))

    def at(self, tau: FloatArray) -> FloatArray:
        """Return the rows q and w at times."""
        return self._values(self.series, tau)

    def crossings(self, levels: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return where the curve passes slip speeds: the places of the levels, and the q there."""
        index, tau = self._passages(self.monotone, self.series[1], levels)
        places: FloatArray = self.at(tau)[0]
        return index, places

    def area_within(self, q: FloatArray, w: FloatArray) -> float:
        """Return the area inside the curve and a box, the integral of q dw, with q cut at the box (Green).

        What closes an orbit, on w = 0, adds nothing.

        - `q, w`: the lower and the upper side of the box.
        """
        if not (q[1] > q[0] and w[1] > w[0]):
            return 0.0
        cuts = [self._passages(self.monotone, self.series[row], side)[1] for row, side in ((0, q), (1, w))]
        times = np.unique(np.concatenate([self.monotone, *cuts]))
        middle, half = (times[1:] + times[:-1]) / 2, (times[1:] - times[:-1]) / 2
        tau = middle[:, None] + half[:, None] * _GAUSS
        place, rate = np.clip(self.at(tau)[0], *q), self._values(self._rates, tau)[1]
        centre = self.at(middle)[1]
        inside = (centre > w[0]) & (centre < w[1])
        return abs(float((half * ((place * rate) @ _WEIGHTS))[inside].sum()))

    @cached_property
    def monotone(self) -> FloatArray:
        """Times between which both q and w are monotone, and which no step passes."""
        turns = [self._passages(self.times, rate, np.zeros(1))[1] for rate in self._rates]
        return np.unique(np.concatenate([self.times, *turns]))

    @cached_property
    def _rates(self) -> FloatArray:
        """The Chebyshev coefficients of q' and w'."""
        slopes: FloatArray = chebyshev.chebder(self.series, axis=1)
        return slopes * 2 / np.diff(self.times)

    def _values(self, series: FloatArray, tau: FloatArray) -> FloatArray:
        """Return the rows of values of functions, given by their coefficients on each step, at times."""
        step = np.clip(np.searchsorted(self.times, tau, side="right") - 1, 0, self.times.size - 2)
        start, end = self.times[step], self.times[step + 1]
        coefficients = np.moveaxis(series[..., step], 1, 0)
        found: FloatArray = chebyshev.chebval((2 * tau - start - end) / (end - start), coefficients, tensor=False)
        return found

    def _passages(self, times: FloatArray, series: FloatArray, levels: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return where a function that is monotone between times passes levels: which of them, and when."""

        def value(tau: FloatArray) -> FloatArray:
            row: FloatArray = self._values(series[None], tau)[0]
            return row

        ends = value(times)
        low, high = np.minimum(ends[1:], ends[:-1]), np.maximum(ends[1:], ends[:-1])
        part, index = np.nonzero((low[:, None] <= levels) & (levels < high[:, None]))
        before, after, rises = times[part], times[part + 1], ends[part + 1] > ends[part]
        for _ in range(_HALVINGS):
            middle = (before + after) / 2
            beyond = (value(middle) >= levels[index]) == rises
            before, after = np.where(beyond, before, middle), np.where(beyond, middle, after)
        return index, (before + after) / 2


@dataclass(frozen=True, repr=False)
class Separatrix:
    """A curve in the phase plane that parts two basins of attraction.

    Attributes
    ----------
    kind : str
        "limit cycle": an unstable one, closed; "graze": the orbit that just touches the belt's speed, closed by
        the part of the line v = V between its ends.
    curve : SlipCurve
        The slip along it.
    onset : float
        Displacement in m where q = 0.
    oscillator : Oscillator
    """

    kind: SeparatrixKind
    curve: SlipCurve
    onset: float
    oscillator: Oscillator

    @property
    def curve_ends_on_belt(self) -> bool:
        """Whether both ends are at the belt's speed: the orbit that touches it comes from there."""
        return bool((np.abs(self.curve.at(self.curve.times[[0, -1]])[1]) <= _ON_BELT).all())

    @property
    def x(self) -> FloatArray:
        """Displacements in m along it."""
        return np.asarray(self.onset + self.oscillator.length * self._samples[0])

    @property
    def v(self) -> FloatArray:
        """Velocities in m/s along it."""
        return np.asarray(self.oscillator.V * (1 - self._samples[1]))

    @property
    def _samples(self) -> FloatArray:
        times = self.curve.times
        return self.curve.at(np.linspace(times[0], times[-1], _SAMPLES))

    def __repr__(self) -> str:
        return f"Separatrix: {self.kind}, {_SAMPLES} points"

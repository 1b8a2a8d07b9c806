"""Slip phases by heyoka: Taylor series of order 20, compiled. Needs the extra `fast`.

Whatever `rtol`, every step is as accurate as double precision allows. For a
series that costs little more than a rough step, and one compiled integrator then serves all tolerances, both
sides, and all scenes of a law.

The extrema of w, simple roots of w', are heyoka's terminal events. Each ends its step, so w is monotone in every
step and has crossed 0 if and only if it ends at 0 or below. The return needs no event of its own, and none that
would have to tell a graze from a miss.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray, Numbers
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.heyoka import EXTREMUM, OTHERWISE, integrator_of
from stickslip_sym.motion.simulation.slip_phase import RUNAWAY, End, SlipPhase, Until, attracted_to_rest
from stickslip_sym.motion.simulation.steppers import Point

__all__ = ["Series", "TaylorSteps"]

_MOST_TRIES = 20_000  # of a step
_TRIES = 30  # more for every unit of time, on the way to a given horizon
_TINY = float(np.finfo(np.float64).tiny)
_DEFECT = 1e-13  # how far a step may miss, in units of its state


@dataclass(frozen=True)
class Series:
    """The Taylor series of (q, w) about the beginning of a step."""

    t_old: float  # dimensionless time of the beginning
    t: float  # and of the end
    coefficients: FloatArray  # shape (order + 1, 2)

    @property
    def start(self) -> Point:
        """The state at the beginning."""
        return Point(self.t_old, *self.coefficients[0].tolist())

    def __call__(self, tau: Numbers) -> FloatArray:
        """Return (q, w) at a time, or rows of q and w at several."""
        return self._sum(np.asarray(tau) - self.t_old)

    def _sum(self, time: Numbers) -> FloatArray:
        return (np.power.outer(time, np.arange(len(self.coefficients))) @ self.coefficients).T

    def rate(self, time: float) -> float:
        """Return w' at a time after the beginning."""
        height, value = self.coefficients[:, 1].tolist(), 0.0
        for order in range(len(height) - 1, 0, -1):
            value = value * time + order * height[order]
        return value

    def crossing(self, length: float) -> tuple[float, Point]:
        """Return the time after the beginning at which w, which has come to 0 or below at `length`, is 0."""
        height = self.coefficients[::-1, 1].tolist()

        def w(time: float) -> float:
            value = 0.0
            for coefficient in height:
                value = value * time + coefficient
            return value

        time = brentq(w, 0.0, length, xtol=_TINY) if w(length) < 0 < w(0.0) else length
        return time, Point(self.t_old + time, float(self._sum(time)[0]), 0.0)


class TaylorSteps:
    """Steps of Taylor series: an `Engine`, whose tolerance is only how close to a rest the mass is at rest.

    Raises `InputError` if heyoka is not installed, the law is not one that it can expand, or mu cannot be computed
      at the start.
    """

    def __init__(self, scene: Scene, phase: SlipPhase, *, horizon: float, rtol: float, until: Until) -> None:
        start = phase.last
        if not math.isfinite(scene.acceleration(start.q, start.w, phase.side)):
            raise InputError(f"mu cannot be computed at a slip speed of {start.w:g} V, where the motion starts")
        self.scene, self.phase, self.horizon, self.until, self.start = scene, phase, horizon, until, start.tau
        self.integrator = integrator_of(scene, phase.side)
        self.rests = attracted_to_rest(scene, phase.side, rtol)
        self.rising = True if start.w == 0 else None  # elsewhere the first extremum will tell
        self.longest = math.inf
        self.tries = 0

    def check_work(self, *, bounded: bool) -> None:
        """Refuse to go on after far more tries than a slip phase takes, whatever else bounds them."""
        elapsed = self.phase.last.tau - self.start
        if self.tries >= _MOST_TRIES + (_TRIES * elapsed if self.until is End.RETURN else 0):
            raise NotConverged(
                f"one slip phase took over {self.tries} Taylor steps up to {elapsed:.3g}/omega: a "
                f"fast decay, or a law that is not smooth, holds them short; {OTHERWISE}"
            )

    def advance(self) -> None:
        """Take a step, or find that it must be shorter."""
        phase, before, integrator = self.phase, self.phase.last, self.integrator
        self.tries += 1
        integrator.time, integrator.state[:] = before.tau, (before.q, before.w)
        outcome, length = integrator.step(min(self.longest, self.horizon - before.tau), write_tc=True)
        now = Point(integrator.time, *integrator.state.tolist())
        if not max(abs(now.q), abs(now.w)) < RUNAWAY:
            phase.end = _lost(before)
            return
        interpolant = Series(before.tau, now.tau, integrator.tc.T.copy())
        crosses = now.w <= 0 and not self.rising
        if crosses:
            length, now = interpolant.crossing(length)
        advanced = now.tau > before.tau  # not to an extremum right here, which a step tried again may find again
        if advanced and not _holds(self.scene, interpolant, length, now, phase.side):
            self.longest = length / 4
            return
        phase.last = now
        if advanced:
            self.longest = math.inf
        if advanced or not phase.interpolants:
            phase.interpolants.append(interpolant)
        if crosses:
            phase.end = End.RETURN
            return
        # Where w' = 0, w'' = side - w whatever mu is. At an onset rounding may give w' a root, and w rises on.
        if int(outcome) == EXTREMUM and (now.w < phase.side) != self.rising:
            self.rising = now.w < phase.side
            if phase.turns(now, self.rising, self.until):
                return
        if self.rests(now):
            phase.end = End.REST


def _holds(scene: Scene, interpolant: Series, length: float, now: Point, side: int) -> bool:
    """Whether the rates at the end of a step are those that its series has there.

    The length of a step follows from its last coefficients, and they do not see a layer of the law ahead: of
    tanh(v/v_0) nothing is left in them at v = 20 v_0, and a step could pass from there to v = 0.
    """
    error = length * abs(interpolant.rate(length) - scene.acceleration(now.q, now.w, side))
    return error <= _DEFECT * max(1.0, abs(now.q), abs(now.w), length * scene.eta)


def _lost(before: Point) -> End:
    """Tell a motion that grows for ever from one that comes to where mu has no value, which is an error."""
    if max(abs(before.q), abs(before.w)) > math.sqrt(RUNAWAY):
        return End.UNBOUNDED
    raise NotConverged(
        f"the slip phase cannot be expanded in a Taylor series beyond a slip speed of {before.w:.6g} V; mu may "
        f"have no finite value there; {OTHERWISE}, or another law"
    )

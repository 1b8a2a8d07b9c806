"""One slip phase: integrated from its onset, watched for extrema of the slip speed and for its end.

A return to the belt's speed may graze it: w touches 0 and turns within one step, and no sign change
of w is left to see. So the extrema of w are located first, as simple roots of w'; between two of them
w is monotone and can cross 0 only once, and where it does is then a simple root too.

The ends of a step are enough to see the extrema: from a minimum of w, which lies below w = 1, to a maximum,
which lies above, the motion takes about half a period, longer than any explicit step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, Literal

import numpy as np
from scipy.integrate import DOP853, Radau
from scipy.optimize import brentq

from stickslip_sym.errors import InputError, NotConverged
from stickslip_sym.oscillator import Scene

__all__ = ["Point", "SlipPhase", "follow"]

_LONGEST_STEP = 0.5  # explicit, of dimensionless time; a period is about 2 pi
_MOST_STEPS = 10_000  # and, on the way to a given horizon, 20 more for every unit of time
_STIFF = 10.0  # a decay of w, per unit of time, below which explicit steps are cheap enough
_PATIENCE = 15  # steps held short by stability before the method changes
_LEVEL = 1e-13  # of the terms of w', below which it may be nothing but rounding
_RUNAWAY = 1e100  # times the belt's speed
_ROOT = float(4 * np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Point:
    """A state (q, w) at a time tau."""

    tau: float
    q: float
    w: float


@dataclass
class SlipPhase:
    """The course of one slip phase.

    Attributes
    ----------
    side : int
        1 where the mass is slower than the belt, -1 where it is faster.
    end : str
        "return": w came down to 0; "minimum": w turned before; "rest": the mass came to rest, within the
        tolerance; "horizon": the time was over.
    last : Point
        The state at the end.
    extrema : list of Point
        The maxima and minima of w, in order.
    pieces : list
        Interpolants of (q, w), one a step, each with its `t_old` and `t`.
    """

    side: int
    end: str
    last: Point
    extrema: list[Point] = field(default_factory=list)
    pieces: list[Any] = field(default_factory=list)

    def at(self, tau: Any) -> Any:
        """Return the rows q and w at ascending times within the phase."""
        tau = np.asarray(tau, dtype=np.float64)
        ends = np.array([piece.t for piece in self.pieces])
        index = np.minimum(np.searchsorted(ends, tau), len(self.pieces) - 1)
        result = np.empty((2, tau.size))
        for i in np.unique(index):
            chosen = index == i
            result[:, chosen] = self.pieces[i](tau[chosen])
        return result

    def crossings(self, level: float) -> list[Point]:
        """Return the points where w passes a level between the ends of two steps, from interpolation."""
        times = np.array([piece.t_old for piece in self.pieces] + [self.last.tau])
        offset = self.at(times)[1] - level
        found = []
        for (left, before), (right, after) in pairwise(zip(times.tolist(), offset.tolist(), strict=True)):
            if before * after < 0:
                tau = brentq(lambda s: float(self.at([s])[1, 0]) - level, left, right, rtol=_ROOT)
                found.append(Point(tau, *self.at([tau])[:, 0].tolist()))
        return found


@np.errstate(all="ignore")  # a step into what is not finite is refused, and tried again shorter
def follow(
    scene: Scene,
    start: Point,
    side: int,
    *,
    horizon: float,
    rtol: float,
    until: Literal["return", "turn"] = "return",
) -> SlipPhase:
    """Integrate a slip phase from `start`.

    Parameters
    ----------
    scene : Scene
    start : Point
        With w >= 0; at w = 0 the phase is leaving, whatever rounding says of w'.
    side : int
        See `SlipPhase`.
    horizon : float
        Time at which to stop in any case.
    rtol : float
        Relative tolerance of a step (absolute: the same, all states being of order one).
    until : str
        "return": go on until w = 0; "turn": stop also at a minimum of w above 0, after which an orbit
        that left P never returns, since orbits in a plane do not cross.

    Raises
    ------
    InputError
        If mu cannot be computed at the start.
    NotConverged
        When the number of steps runs out, the motion grows beyond all bounds, or mu cannot be computed on it.
    """
    method = _Method(scene, side, rtol)
    initial = method.rates(start.tau, np.array((start.q, start.w)))[1]
    if not math.isfinite(initial):
        raise InputError(f"mu cannot be computed at a slip speed of {start.w:g} V, where the motion starts")
    phase = SlipPhase(side, "horizon", start)
    solver = method.solver(start, horizon)
    rising = start.w == 0 or initial > 0
    terms = scene.eta * scene.static, start.q, 2 * scene.zeta * start.w
    if abs(initial) <= _LEVEL * max(map(abs, terms)) and start.w < side:  # from a minimum w rises
        rising = True
    steps = 0
    while solver.status == "running":
        steps += 1
        if steps > _MOST_STEPS + (20 * (phase.last.tau - start.tau) if until == "return" else 0):
            raise NotConverged(
                f"one slip phase took over {steps - 1} steps up to {phase.last.tau - start.tau:.3g}/omega, and "
                f"advances by {solver.step_size:.1e}/omega a step: mu may jump or be too rough; try a larger rtol"
            )
        before = phase.last
        piece = method.step(solver)
        phase.pieces.append(piece)
        phase.last = _point(solver.t, solver.y)
        turn = method.turn(piece, rising)
        if turn is not None:
            extremum = method.refine(before, turn, lambda state: float(method.rates(0.0, state)[1]))
            rising = not rising
            if rising and extremum.w <= 0:
                return _returned(phase, before, extremum.tau, method)
            phase.extrema.append(extremum)
            if rising and until == "turn":
                phase.end, phase.last = "minimum", extremum
                return phase
        if phase.last.w <= 0 and not rising:
            return _returned(phase, before, phase.last.tau, method)
        if method.rests(phase.last):
            phase.end = "rest"
            return phase
        if method.changes(phase.last, solver.t - before.tau):
            solver = method.solver(phase.last, horizon)
    return phase


def _point(tau: float, state: Any) -> Point:
    return Point(float(tau), *state.tolist())


def _returned(phase: SlipPhase, before: Point, latest: float, method: "_Method") -> SlipPhase:
    """End a phase where w crosses 0 in the falling stretch of a step that ends at `latest`."""
    piece = phase.pieces[-1]
    earliest = max([before.tau, *(point.tau for point in phase.extrema)])
    height = piece(np.array((earliest, latest)))[1]
    tau = latest
    if height[0] > 0 > height[1]:
        tau = brentq(lambda s: piece(s)[1], earliest, latest, rtol=_ROOT)
    end = method.refine(before, tau, lambda state: float(state[1]))
    phase.end, phase.last = "return", Point(end.tau, end.q, 0.0)
    return phase


class _Method:
    """How one phase is integrated: explicitly, or implicitly while a fast decay of w holds the steps short."""

    def __init__(self, scene: Scene, side: int, rtol: float) -> None:
        self.scene, self.side, self.rtol = scene, side, rtol
        self.stiff = False
        self.held = 0
        self.rest = scene.rest if side > 0 and scene.decay(1.0) > 0 else None

    def rates(self, _: float, state: Any) -> Any:
        q, w = state.tolist()
        return np.array((1 - self.side * w, self.scene.acceleration(q, w, self.side)))

    def _jacobian(self, _: float, state: Any) -> Any:
        return np.array(((0.0, -self.side), (self.side, -self.scene.decay(max(float(state[1]), 0.0)))))

    def solver(self, start: Point, end: float, **options: Any) -> Any:
        state = np.array((start.q, start.w))
        if not self.stiff:
            return DOP853(
                self.rates, start.tau, state, end,
                rtol=self.rtol, atol=self.rtol, **({"max_step": _LONGEST_STEP} | options),
            )  # fmt: skip
        # Radau's estimate is of order 3, its solution of order 5.
        loose = self.rtol ** (2 / 3)
        return Radau(self.rates, start.tau, state, end, rtol=loose, atol=loose, jac=self._jacobian, **options)

    def step(self, solver: Any) -> Any:
        """Take one step and return its interpolant."""
        try:
            message = solver.step()
        except ValueError as error:  # from the linear algebra of a state that is not finite
            solver.status, message = "failed", str(error)
        w = float(solver.y[1])
        if w > self.scene.w_max:
            raise InputError(
                f"the motion reaches a slip speed of {w:g} V, the law is measured up to {self.scene.w_max:g} V; "
                "measure further, or hold the last coefficient: extrapolate=True, or --extrapolate"
            )
        if not abs(w) < _RUNAWAY:
            raise NotConverged("the motion grows without bound; a negative damping feeds it: try a shorter t_end")
        if solver.status == "failed":
            raise NotConverged(
                f"the slip phase cannot be integrated at rtol = {self.rtol:g} beyond a slip speed of {w:.6g} V: "
                f"{message} mu may have no finite value there; try a larger rtol or another law"
            )
        return solver.dense_output()

    def turn(self, piece: Any, rising: bool) -> float | None:
        """Locate an extremum of w within one step on its interpolant."""

        def slope(tau: float) -> float:
            return float(self.rates(tau, piece(tau))[1])

        # In a fast decay w' is a small difference, and its sign the sign of an error of w.
        noise = self.rtol ** (2 / 3) * self.scene.decay(max(float(piece(piece.t)[1]), 0.0)) if self.stiff else 0.0
        last = slope(piece.t)
        if (last >= -noise) if rising else (last <= noise):
            return None
        # Right at an onset or an extremum the slope at the beginning may have either sign.
        settled = (slope(piece.t_old) > 0) == rising
        try:
            tau = float(brentq(slope, piece.t_old, piece.t, rtol=_ROOT)) if settled else float(piece.t_old)
        except ValueError as error:  # within the step an interpolant may leave where mu can be computed
            raise NotConverged(
                f"the slip phase cannot be followed at rtol = {self.rtol:g} from a slip speed of "
                f"{float(piece(piece.t_old)[1]):.6g} V on: {error}; try another rtol"
            ) from None
        # Where w' = 0, w'' = side - w whatever mu is: any other turn is an error of the integration.
        return tau if (piece(tau)[1] < self.side) != rising else None

    def refine(self, before: Point, tau: float, value: Callable[[Any], float]) -> Point:
        """Improve a root near tau, found on an interpolant, to the accuracy of the integration itself."""
        state = self._state(before, tau)
        for _ in range(2):
            speed = self.rates(tau, state)
            size = 1e-6
            slope = (value(state + size * speed) - value(state - size * speed)) / (2 * size)
            shift = -value(state) / slope if slope else math.inf
            if not abs(shift) < 1e-6 or tau + shift <= before.tau:
                break  # a grazing root: the interpolant's is as good as any
            tau += shift
            state = self._state(before, tau)
        return _point(tau, state)

    def _state(self, before: Point, tau: float) -> Any:
        """Integrate afresh from the beginning of the step."""
        length = tau - before.tau
        if length <= 0:
            return np.array((before.q, before.w))
        solver = self.solver(before, tau, first_step=length, max_step=math.inf)
        while solver.status == "running":
            self.step(solver)
        return solver.y

    def rests(self, now: Point) -> bool:
        """Whether the mass is as close to a rest that attracts it as the errors of steps let it come."""
        if self.rest is None:
            return False
        q, w = self.rest
        close = 10 * self.rtol
        return abs(now.w - w) <= close and abs(now.q - q) <= close * max(1.0, abs(q))

    def changes(self, now: Point, step: float) -> bool:
        """Choose the method of the next step, and tell whether it is another one."""
        decay = self.scene.decay(now.w)
        if self.stiff:
            self.held = 0
            self.stiff = decay > _STIFF / 3
            return not self.stiff
        # The explicit method is stable up to about 6 decay times a step.
        self.held = self.held + 1 if decay > _STIFF and decay * step > 2.5 else 0
        self.stiff = self.held >= _PATIENCE
        return self.stiff

"""One slip phase: integrated from its onset, watched for extrema of the slip speed and for its end.

A return to the belt's speed may graze it: w touches 0 and turns within one step, and no sign change
of w is left to see. So the extrema of w are located first, as simple roots of w'; between two of them
w is monotone and can cross 0 only once, and where it does is then a simple root too.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

from stickslip_sym.errors import InputError, NotConverged
from stickslip_sym.oscillator import Scene

__all__ = ["Point", "SlipPhase", "check_rtol", "follow"]

_LOOKS = 4  # times per step at which the sign of w' is looked at
_LONGEST_STEP = 0.5  # of dimensionless time; a period is about 2 pi
_MOST_STEPS = 200_000
_ROOT = 4 * np.finfo(np.float64).eps


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
        "return": w came down to 0; "minimum": w turned before; "horizon": the time was over.
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
        """Return the points where w passes a level, from interpolation."""
        found = []
        for piece in self.pieces:
            start, stop = piece.t_old, min(piece.t, self.last.tau)
            grid = np.linspace(start, stop, _LOOKS + 1)
            offset = piece(grid)[1] - level
            for i in np.flatnonzero(offset[:-1] * offset[1:] < 0):
                tau = brentq(lambda s, piece=piece: piece(s)[1] - level, grid[i], grid[i + 1], rtol=_ROOT)
                found.append(Point(tau, *piece(tau).tolist()))
        return found


def check_rtol(rtol: float) -> None:
    """Refuse a tolerance that double precision cannot hold, or that means nothing."""
    if not 1e-13 <= rtol <= 1e-3:
        raise InputError(f"rtol = {rtol:g} is outside 1e-13 to 1e-3")


def follow(
    scene: Scene,
    start: Point,
    side: int,
    *,
    horizon: float,
    rtol: float,
    until: Literal["return", "turn", "minimum"] = "return",
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
        that left P never returns, since orbits in a plane do not cross; "minimum": ignore w = 0, follow
        the tangent continuation of mu to the first minimum of w.

    Raises
    ------
    NotConverged
        When the number of steps runs out.
    """

    def rates(_: float, state: Any) -> Any:
        q, w = state.tolist()
        return np.array((1 - side * w, scene.acceleration(q, w, side)))

    phase = SlipPhase(side, "horizon", start)
    solver = DOP853(
        rates, start.tau, np.array((start.q, start.w)), horizon, rtol=rtol, atol=rtol, max_step=_LONGEST_STEP
    )
    rising = start.w == 0 or rates(0.0, solver.y)[1] > 0
    for _ in range(_MOST_STEPS):
        if solver.status != "running":
            return phase
        before = Point(solver.t, *solver.y.tolist())
        message = solver.step()
        if solver.status == "failed":
            raise NotConverged(f"the slip phase cannot be integrated at rtol = {rtol:g}: {message}")
        piece = solver.dense_output()
        phase.pieces.append(piece)
        refine = _Refiner(rates, before, rtol)
        for tau in _turns(piece, rates, rising):
            extremum = refine(tau, lambda state: float(rates(0.0, state)[1]))
            rising = not rising
            if rising:  # a minimum
                if extremum.w <= 0 and until != "minimum":
                    return _returned(phase, piece, extremum.tau, refine)
                phase.extrema.append(extremum)
                if until != "return":
                    phase.end, phase.last = "minimum", extremum
                    return phase
            else:
                phase.extrema.append(extremum)
        phase.last = Point(solver.t, *solver.y.tolist())
        if phase.last.w <= 0 and not rising and until != "minimum":
            return _returned(phase, piece, solver.t, refine)
    raise NotConverged(
        f"one slip phase took over {_MOST_STEPS} steps: the scene is too stiff for an explicit method"
    )


def _turns(piece: Any, rates: Callable[[float, Any], Any], rising: bool) -> list[float]:
    """Locate the extrema of w within one step on its interpolant."""
    grid = np.linspace(piece.t_old, piece.t, _LOOKS + 1)

    def slope(tau: float) -> float:
        return float(rates(tau, piece(tau))[1])

    found = []
    left = grid[0]
    for right in grid[1:]:
        if (slope(right) > 0) != rising:
            # Right at an onset or an extremum the slope at the left end may have either sign.
            settled = (slope(left) > 0) == rising
            found.append(brentq(slope, left, right, rtol=_ROOT) if settled else left)
            rising = not rising
        left = right
    return found


def _returned(phase: SlipPhase, piece: Any, latest: float, refine: "_Refiner") -> SlipPhase:
    """End a phase where w crosses 0 in the falling stretch of a step that ends at `latest`."""
    earliest = max([piece.t_old, *(point.tau for point in phase.extrema)])
    height = piece(np.array((earliest, latest)))[1]
    tau = latest
    if height[0] > 0 > height[1]:
        tau = brentq(lambda s: piece(s)[1], earliest, latest, rtol=_ROOT)
    end = refine(tau, lambda state: float(state[1]))
    phase.end, phase.last = "return", Point(end.tau, end.q, 0.0)
    return phase


class _Refiner:
    """Improves a root found on an interpolant to the accuracy of the integration itself."""

    def __init__(self, rates: Callable[[float, Any], Any], before: Point, rtol: float) -> None:
        self.rates, self.before, self.rtol = rates, before, rtol

    def __call__(self, tau: float, value: Callable[[Any], float]) -> Point:
        """Return the state at the root of `value` near tau, by two secant corrections."""
        state = self._state(tau)
        for _ in range(2):
            speed = self.rates(tau, state)
            size = 1e-6
            slope = (value(state + size * speed) - value(state - size * speed)) / (2 * size)
            if slope == 0:
                break
            shift = -value(state) / slope
            if not abs(shift) < 1e-6 or tau + shift <= self.before.tau:
                break  # a grazing root: the interpolant's is as good as any
            tau += shift
            state = self._state(tau)
        return Point(tau, *state.tolist())

    def _state(self, tau: float) -> Any:
        """Integrate afresh from the beginning of the step."""
        state = np.array((self.before.q, self.before.w))
        length = tau - self.before.tau
        if length <= 0:
            return state
        solver = DOP853(self.rates, self.before.tau, state, tau, rtol=self.rtol, atol=self.rtol, first_step=length)
        while solver.status == "running":
            solver.step()
        return solver.y

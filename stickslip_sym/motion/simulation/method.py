"""Steps of a slip phase, segment of mu by segment: explicit ones, or implicit ones in a fast decay.

A return to the belt's speed may graze it: w touches 0 and turns within one step, and no sign change
of w is left to see. So the extrema of w are located first, as simple roots of w'; between two of them
w is monotone and can cross 0 only once, and where it does is then a simple root too.

The ends of a step are enough to see the extrema: from a minimum of w, which lies below w = 1, to a maximum,
which lies above, the motion takes about half a period, longer than any explicit step.

Where mu has a kink, each of its smooth segments is integrated as if it held everywhere. Where w leaves the segment
is located as a return is, which is the same thing at w = 0, and the integration begins anew on the next segment.
So no step has a kink in it. Where mu jumps up, the rates on both sides may both lead to the jump: the mass then
slides at the slip speed of the jump, w is constant, and q a straight line, until one of them turns (Filippov).
"""

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass, replace

from stickslip_sym.core.aliases import Numbers
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.slip_phase import (
    RUNAWAY,
    End,
    SlipPhase,
    Until,
    attracted_to_rest,
    passage,
    root,
)
from stickslip_sym.motion.simulation.steppers import Explicit, Implicit, Interpolant, Point, Rates

__all__ = ["Steps"]

_LONGEST_STEP = 0.25  # explicit, of dimensionless time; at twice that what a step is off shows in thresholds
_MOST_STEPS = 10_000
_STEPS = 20  # more for every unit of time and segment of mu, on the way to a given horizon
_STIFF = 10.0  # a decay of w, per unit of time, below which explicit steps are cheap enough
_SOFT = _STIFF / 3  # below which they are taken again; less, so that the method does not change to and fro
_STABLE = 2.5  # decay times a step, from which stability holds it short: the explicit method bears about 6
_PATIENCE = 15  # steps held short by stability before the method changes
_LEVEL = 1e-13  # of the terms of w', below which it may be nothing but rounding
_JUMP = 1e-12  # of mu, relative, below which it is rounding
_OFF = 1e-6  # of dimensionless time, by which the root of an interpolant is off at most, but for a graze
_AFRESH = 100  # steps for one that is taken again; where time itself is rounded they may be too short to end
_STRAIGHT = 1e-9  # over which a straight line is off by less than rounding


@dataclass
class _Slide:
    """A stretch of constant slip speed."""

    start: Point
    t: float
    rate: float

    def __call__(self, tau: Numbers) -> tuple[Numbers, Numbers]:
        return self.start.q + self.rate * (tau - self.start.tau), self.start.w + 0 * tau


class Steps:
    """Steps of DOP853, and of Radau in a fast decay of w: an `Engine`."""

    def __init__(self, scene: Scene, phase: SlipPhase, *, horizon: float, rtol: float, until: Until) -> None:
        self.scene, self.phase, self.side = scene, phase, phase.side
        self.horizon, self.rtol, self.until = horizon, rtol, until
        self.start = phase.last.tau
        self.segments = [replace(scene, rise=branch.rise) for branch in scene.branches]
        self.stiff = False
        self.held = 0
        self.rests = attracted_to_rest(scene, self.side, rtol)
        self.solver: Explicit | Implicit
        self.rising = self._begin()

    def check_work(self, *, bounded: bool) -> None:
        """Refuse to go on after far more steps than a slip phase takes, unless there is another bound on them."""
        steps, elapsed = len(self.phase.interpolants), self.phase.last.tau - self.start
        more = _STEPS * len(self.segments) * elapsed if self.until is End.RETURN else 0
        if not bounded and steps >= _MOST_STEPS + more:
            raise NotConverged(
                f"one slip phase took over {steps} steps up to {elapsed:.3g}/omega: mu may be too rough, with "
                f"steps of {self.solver.length:.1e}/omega; try a larger rtol"
            )

    def advance(self) -> None:
        """Take a step, up to where w leaves the segment of mu or the phase ends."""
        phase, before = self.phase, self.phase.last
        interpolant, last = self._step(), self.solver.now
        if not max(abs(last.q), abs(last.w)) < RUNAWAY:
            phase.end = End.UNBOUNDED
            return
        turn = self._turn(interpolant)
        left = self._leaves(interpolant, before, last if turn is None else turn)
        phase.interpolants.append(interpolant)
        phase.last = last
        if left is None and turn is not None:
            self.rising = not self.rising
            if phase.turns(turn, self.rising, self.until):
                return
            left = self._leaves(interpolant, turn, last)
        if left is None and self.rests(phase.last):
            phase.end = End.REST
        elif left is None:
            self._choose(phase.last, phase.last.tau - before.tau)
        else:
            phase.last = left
            if left.w == 0:
                phase.end = End.RETURN
                return
            rose, self.rising = self.rising, self._enter(self.rising)
            if self.until is End.MINIMUM and self.rising and not rose and phase.end is not End.REST:
                phase.end = End.MINIMUM

    # -- segments of mu ----------------------------------------------------------------------------------

    def _begin(self) -> bool:
        """Choose the segment of mu at the start, and return whether w rises."""
        start, branches = self.phase.last, self.scene.branches
        self._require_known(start.w)
        self.index = bisect_right([branch.low for branch in branches], start.w) - 1
        slope = self._slope(self.index, start)
        if not math.isfinite(slope):
            raise InputError(f"mu cannot be computed at a slip speed of {start.w:g} V, where the motion starts")
        scene = self.scene
        held, risen = self.side * scene.static - scene.onset, scene.rise(start.w)
        terms = scene.eta * held, scene.eta * risen, start.q, 2 * scene.zeta * start.w
        level = abs(slope) <= _LEVEL * max(map(abs, terms)) and start.w < self.side  # at a minimum of w
        if slope < 0 and not level and self.index and start.w == branches[self.index].low:
            return self._enter(rising=False)
        self.solver = self._solver(start, self.horizon)
        return start.w == 0 or level or slope > 0

    def _enter(self, rising: bool) -> bool:
        """Go on from a level at which mu has a kink, and return whether w rises there."""
        phase = self.phase
        step = self.solver.length if phase.interpolants else None
        now, beyond = phase.last, self.index + (1 if rising else -1)
        onward = (self._slope(beyond, now) >= 0) == rising
        if onward or not self._jumps(now.w, self.index, beyond):
            self.index = beyond
        else:
            rising = self._slide(min(self.index, beyond))
        if self.stiff and self.segments[self.index].decay(now.w) <= _SOFT:
            self.stiff, step = False, None  # where w grows, a long implicit step would take it for a decay
        if phase.last.tau < self.horizon:
            self.solver = self._solver(phase.last, self.horizon, step=step)
        return rising

    def _slope(self, index: int, now: Point) -> float:
        return self.segments[index].acceleration(now.q, now.w, self.side)

    def _jumps(self, w: float, *indices: int) -> bool:
        onset = self.scene.onset
        one, other = (onset + self.scene.branches[index].rise(w) for index in indices)
        return abs(one - other) > _JUMP * max(abs(one), abs(other))

    def _slide(self, lower: int) -> bool:
        """Slide at the slip speed of a jump, and return whether the mass leaves it upward."""
        phase, start, side = self.phase, self.phase.last, self.side
        rate = 1 - side * start.w  # of q; both slopes of w change by side times as much
        if rate == 0:  # a jump at the belt's speed holds the mass, wherever it is
            phase.end = End.REST
            return True
        upward = side * rate > 0
        self.index = lower + 1 if upward else lower
        # Where the slope of w on the side of the exit is 0.
        distance = -side * self._slope(self.index, start) / rate
        tau = min(self.horizon, start.tau + max(distance, 0.0))
        phase.interpolants.append(_Slide(start, tau, rate))
        phase.last = Point(tau, start.q + rate * (tau - start.tau), start.w)
        return upward

    # -- steps ---------------------------------------------------------------------------------------

    @property
    def _rates(self) -> Rates:
        # Of this segment for good: an interpolant may ask for more of them when the mass is on another one.
        return self._rates_of(self.index)

    def _rates_of(self, index: int) -> Rates:
        """Return q' and w' on a segment, as the scene has them, in the one call that most of the time goes to."""
        scene, side, rise = self.scene, self.side, self.scene.branches[index].rise
        eta, held, damping = scene.eta, side * scene.static - scene.onset, 2 * scene.zeta
        return lambda q, w: (1 - side * w, eta * (held - rise(w)) + side * q - damping * w)

    def _solver(self, start: Point, end: float, *, step: float | None = None) -> Explicit | Implicit:
        if self.stiff:
            decay = self.segments[self.index].decay
            return Implicit(self._rates, start, end, self.rtol, side=self.side, decay=decay, step=step)
        return Explicit(self._rates, start, end, self.rtol, step=step, longest=_LONGEST_STEP)

    def _step(self) -> Interpolant:
        """Take one step and return its interpolant."""
        interpolant = self.solver.step()
        w = self.solver.now.w
        self._require_known(w)
        if interpolant is None:
            raise NotConverged(
                f"the slip phase cannot be integrated at rtol = {self.rtol:g} beyond a slip speed of {w:.6g} V: "
                "mu may have no finite value there; try a larger rtol or another law"
            )
        return interpolant

    def _require_known(self, w: float) -> None:
        """Refuse a slip speed beyond the last measured one."""
        if w > self.scene.w_max:
            raise InputError(
                f"the motion reaches a slip speed of {w:.6g} V, the law is measured up to "
                f"{self.scene.w_max:.6g} V; measure further, or hold the last coefficient: extrapolate=True"
            )

    def _turn(self, interpolant: Interpolant) -> Point | None:
        """Locate an extremum of w within one step."""
        start, now, rising = interpolant.start, self.solver.now, self.rising
        # In a fast decay w' is a small difference, and its sign the sign of an error of w.
        noise = self.rtol ** (2 / 3) * self.segments[self.index].decay(max(now.w, 0.0)) if self.stiff else 0.0
        if (self.solver.slope >= -noise) if rising else (self.solver.slope <= noise):
            return None

        rates = self._rates

        def slope(tau: float) -> float:
            return rates(*map(float, interpolant(tau)))[1]

        # Right at an onset or an extremum the slope at the beginning may have either sign, and so may that at the
        # end on the interpolant.
        before, after = ((slope(tau) > 0) == rising for tau in (start.tau, interpolant.t))
        try:
            tau = (
                root(slope, start.tau, interpolant.t)
                if before and not after
                else interpolant.t
                if before
                else start.tau
            )
        except ValueError as error:  # within the step an interpolant may leave where mu can be computed
            raise NotConverged(
                f"the slip phase cannot be followed at rtol = {self.rtol:g} from a slip speed of "
                f"{start.w:.6g} V on: {error}; try another rtol"
            ) from None
        # Where w' = 0, w'' = side - w whatever mu is: any other turn is an error of the integration.
        if (float(interpolant(tau)[1]) < self.side) == rising:
            return None
        return self._refined(interpolant, tau, lambda q, w: (self._rates(q, w)[1], self.side - w))

    def _leaves(self, interpolant: Interpolant, first: Point, last: Point) -> Point | None:
        """Locate where w leaves the range of the segment of mu in a monotone stretch of one step."""
        branch, rising = self.scene.branches[self.index], self.rising
        level = branch.high if rising else branch.low
        if (last.w < level) if rising else (last.w > level):
            return None
        height = [float(interpolant(point.tau)[1]) - level for point in (first, last)]
        if (height[0] < 0) != rising:
            tau = first.tau
        elif (height[1] < 0) == rising:
            tau = last.tau
        else:
            tau = passage(interpolant, level, first.tau, last.tau)
        end = self._refined(interpolant, tau, lambda q, w: (w - level, self._rates(q, w)[1]))
        return Point(end.tau, end.q, level)

    def _refined(
        self, interpolant: Interpolant, tau: float, value: Callable[[float, float], tuple[float, float]]
    ) -> Point:
        """Improve a root near tau, found on an interpolant, to the accuracy of the integration itself.

        `value` gives what vanishes at the root, and its rate.
        """
        before, now = interpolant.start, self._state(interpolant.start, tau)
        for _ in range(2):
            if now is None:
                break
            offset, rate = value(now.q, now.w)
            shift = -offset / rate if rate else math.inf
            if not abs(shift) < _OFF or now.tau + shift <= before.tau:
                break  # a grazing root: the interpolant's is as good as any
            if abs(shift) < _STRAIGHT:
                dq, dw = self._rates(now.q, now.w)
                return Point(now.tau + shift, now.q + shift * dq, now.w + shift * dw)
            now = self._state(before, now.tau + shift)
        return now or Point(tau, *map(float, interpolant(tau)))

    def _state(self, before: Point, tau: float) -> Point | None:
        """Integrate afresh from the beginning of the step; None where that takes many steps for this one."""
        if tau <= before.tau:
            return before
        kept, self.solver = self.solver, self._solver(before, tau, step=tau - before.tau)
        steps = 0
        while self.solver.now.tau < tau and (steps := steps + 1) <= _AFRESH:
            self._step()
        fresh, self.solver = self.solver.now, kept
        return fresh if fresh.tau >= tau else None

    def _choose(self, now: Point, step: float) -> None:
        """Choose the method of the next step."""
        decay = self.segments[self.index].decay(now.w)
        if self.stiff:
            self.held = 0
            stiff = decay > _SOFT
        else:
            self.held = self.held + 1 if decay > _STIFF and decay * step > _STABLE else 0
            stiff = self.held >= _PATIENCE
        if stiff != self.stiff:
            self.stiff = stiff
            self.solver = self._solver(now, self.horizon)

"""The event-driven stick/slip automaton.

Three states: stick, slip slower than the belt, slip faster than the belt. Slip is integrated
(`slip.follow`, or another engine); stick is not, as it is known: x' = V exactly, until static friction gives way.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.simulation import engines
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.simulation.tendency import tendency
from stickslip_sym.motion.simulation.trajectory import (
    Course,
    Event,
    EventKind,
    Outcome,
    Phase,
    Stretch,
    Trajectory,
)

__all__ = ["simulate"]

ENDS = {
    End.REST: Outcome.AT_REST,
    End.STEPS: Outcome.STEP_LIMIT,
    End.DEADLINE: Outcome.TIME_LIMIT,
    End.UNBOUNDED: Outcome.UNBOUNDED,
    End.UNDEFINED: Outcome.UNDEFINED,
}
"""What ends a motion before its time."""
_GROWS = "damping and friction feed the motion: try a shorter t_end, or a larger c"


def simulate(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    t_end: float,
    x0: float = 0.0,
    v0: float | None = None,
    rtol: float = 1e-10,
    engine: str = "scipy",
    max_steps: int = 200_000,
    time_limit: float | None = None,
) -> Trajectory:
    """Integrate m x'' + c x' + k x = friction from x(0) = x0, x'(0) = v0, events included.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    t_end : float
        Duration in s, positive.
    x0 : float
        Initial displacement in m.
    v0 : float, optional
        Initial velocity in m/s; the belt speed if not given.
    rtol : float
        Relative tolerance of a step, 1e-13 to 1e-3.
    engine : {"scipy", "heyoka"}
        What integrates the slip phases. "heyoka" is faster, for smooth laws that are not stiff; it needs
        ``pip install 'stickslip_sym[fast]'``.
    max_steps : int
        Integration steps after which the simulation ends as it is; a cycle of stick and slip takes about 30.
    time_limit : float, optional
        Seconds of computation after which it ends as it is.

    Returns
    -------
    Trajectory
        Its `outcome` says whether `t_end`, a limit, or a rest that goes on for ever was reached, or that the
        motion grows without bound, or comes to where mu has no value; then `note` says more.

    Raises
    ------
    InputError
        For unusable numbers, an unbound law, or an engine that is not there or cannot take the law.
    NotConverged
        When the engine cannot go on, as heyoka's in a fast decay.
    """
    chosen = engines.find(engine)
    t_end, x0, v0 = real("t_end", t_end), real("x0", x0), real("v0", osc.V if v0 is None else v0)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    rtol = read_rtol(rtol)
    max_steps = int(real("max_steps", max_steps))
    if max_steps < 1:
        raise InputError(f"max_steps = {max_steps} must be at least 1")
    seconds = math.inf if time_limit is None else real("time_limit", time_limit)
    if seconds <= 0:
        raise InputError(f"time_limit = {seconds:g} s must be positive")
    deadline = time.monotonic() + seconds
    scene = Scene.of(law, osc)
    recorder = _Recorder(law, osc, rtol)
    horizon = t_end * osc.omega
    start = Point(0.0, recorder.q_of(x0), (osc.V - v0) / osc.V)
    for part in parts(
        scene, start, horizon=horizon, rtol=rtol, engine=chosen, max_steps=max_steps, deadline=deadline
    ):
        if isinstance(part, Sticking):
            recorder.stick(part)
            continue
        phase = part.phase
        recorder.slip(part)
        if phase.end is End.REST:
            recorder.rest(t_end, rest_of(scene, law, osc, phase.last))
        if phase.end in ENDS:
            note = str(phase.error or "") if phase.end is not End.UNBOUNDED else _GROWS
            return recorder.trajectory(ENDS[phase.end], note)
    return recorder.trajectory(Outcome.FINISHED)


def rest_of(scene: Scene, law: FrictionLaw, osc: Oscillator, last: Point) -> float | None:
    """Return the displacement in m at which the mass rests, or None where it rests as it was integrated.

    Where rest is isolated it is known better than integrated; a jump of mu at V holds the mass anywhere.
    """
    held = last.w == 1 and any(branch.low == 1 for branch in scene.branches)
    return None if held else osc.N * float(law.mu(osc.V)) / osc.k


@dataclass(frozen=True)
class Sticking:
    """A stick phase: its start, its end, and the displacement q where it starts."""

    tau: float
    end: float
    q: float


@dataclass(frozen=True)
class Slipping:
    """A slip phase that begins at `tau`, and may have been integrated from another time on."""

    tau: float
    phase: SlipPhase

    @property
    def later(self) -> float:
        """What is to be added to the times of the phase."""
        return self.tau - self.phase.start.tau

    @property
    def end(self) -> float:
        """The time at which it ends."""
        return self.phase.last.tau + self.later


def parts(
    scene: Scene,
    start: Point,
    *,
    horizon: float,
    rtol: float,
    engine: engines.Engine,
    max_steps: int,
    deadline: float,
) -> Iterator[Sticking | Slipping]:
    """Yield the phases of a motion one after another, up to the horizon or the first that does not go on.

    Nothing depends on time itself, so a slip from where one began before is that one again: every stick ends at P,
    and a motion that sticks is integrated for one round, whatever its length.

    - `start`: with w negative where the mass is faster than the belt.
    - The rest as for `slip.follow`, but that `max_steps` bounds the motion as a whole.
    """
    known = dict[tuple[float, int], SlipPhase]()
    tau, q, w = start.tau, start.q, start.w
    side, steps = 1 if w > 0 else -1, 0
    while tau < horizon:
        if w == 0 and scene.sticks(q) and q < 0:
            end = min(horizon, tau - q)
            yield Sticking(tau, end, q)
            tau, q = end, (0.0 if end < horizon else q + end - tau)
            continue
        if w == 0:  # at P, or beyond what static friction holds on either side
            side = 1 if q >= 0 else -1
        phase = known.get((q, side)) if w == 0 else None
        if (
            phase is None
            or Slipping(tau, phase).end > horizon
            or steps + len(phase.interpolants) >= max_steps
            or min(deadline - time.monotonic(), time_left()) < 0
        ):
            phase = follow(
                scene, Point(tau, q, abs(w)), side,
                horizon=horizon, rtol=rtol, max_steps=max_steps - steps, deadline=deadline, engine=engine,
            )  # fmt: skip
            if w == 0 and phase.end is End.RETURN:
                known[q, side] = phase
        part = Slipping(tau, phase)
        yield part
        if phase.end in ENDS:
            return
        steps += len(phase.interpolants)
        tau, q, w = part.end, phase.last.q, phase.last.w


@dataclass(frozen=True)
class _Straight:
    """The course of a mass that moves with one velocity: in stick, or at rest."""

    start: float
    x: float
    v: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.x + self.v * (t - self.start), np.full(t.shape, self.v)


@dataclass(frozen=True)
class _Slip:
    """The course of a slip phase, in units."""

    phase: SlipPhase
    later: float
    osc: Oscillator
    x_onset: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        q, w = self.phase.at(t * self.osc.omega - self.later)
        return self.x_onset + self.osc.length * q, self.osc.V * (1 - self.phase.side * w)


class _Recorder:
    """Collects phases and gives them their units back."""

    def __init__(self, law: FrictionLaw, osc: Oscillator, rtol: float) -> None:
        self.osc, self.rtol = osc, rtol
        self.length = osc.length
        self.x_onset = osc.onset(law)
        self.samples: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self.events: list[Event] = []
        self.stretches: list[Stretch] = []

    def q_of(self, x: float) -> float:
        return (x - self.x_onset) / self.length

    def stick(self, part: Sticking) -> None:
        # Two samples hold all there is to a straight line.
        times = np.array([part.tau, part.end])
        x = self.x_onset + self.length * (part.q + times - part.tau)
        course = _Straight(part.tau / self.osc.omega, float(x[0]), self.osc.V)
        self._add(times / self.osc.omega, x, np.full(2, self.osc.V), Phase.STICK, course)

    def slip(self, part: Slipping) -> None:
        phase = part.phase
        tau, q, w = phase.states
        tau = tau + part.later
        tau[0] = part.tau  # to the last digit
        kind = Phase.SLIP_BACK if phase.side > 0 else Phase.SLIP_FORWARD
        x, v = self.x_onset + self.length * q, self.osc.V * (1 - phase.side * w)
        self._add(tau / self.osc.omega, x, v, kind, _Slip(phase, part.later, self.osc, self.x_onset))

    def rest(self, end: float, known: float | None) -> None:
        """Prolong a slip phase that came to rest, where x is known or is as it was integrated."""
        before = self.stretches[-1]
        x = float(self.samples[-1][1][-1]) if known is None else known
        self.samples.append((np.array([end]), np.array([x]), np.zeros(1)))
        self.stretches.append(Stretch(before.phase, before.end, end, _Straight(before.end, x, 0.0)))

    def _add(self, t: FloatArray, x: FloatArray, v: FloatArray, phase: Phase, course: Course) -> None:
        kind = EventKind.START
        if self.events:
            slipped = self.events[-1].begins is not Phase.STICK
            kind = EventKind.CROSSES if slipped else EventKind.SLIPS
            kind = EventKind.STICKS if phase is Phase.STICK else kind
        self.samples.append((t, x, v))
        self.events.append(Event(float(t[0]), float(x[0]), float(v[0]), phase, kind))
        self.stretches.append(Stretch(phase, float(t[0]), float(t[-1]), course))

    def trajectory(self, outcome: Outcome, note: str = "") -> Trajectory:
        t, x, v = (np.concatenate(parts) for parts in zip(*self.samples, strict=True))
        counts = [part[0].size for part in self.samples]
        phases = np.empty(len(counts), dtype=object)
        phases[:] = [stretch.phase for stretch in self.stretches]
        events, stretches = tuple(self.events), tuple(self.stretches)
        found = Trajectory(t, x, v, np.repeat(phases, counts), events, outcome, stretches, note)
        word, change = tendency(found, length=self.length, rtol=self.rtol)
        return replace(found, tendency=word, change=change)

"""The event-driven stick/slip automaton.

Three states: stick, slip slower than the belt, slip faster than the belt. Slip is integrated
(`slip.follow`, or another engine); stick is not, as it is known: x' = V exactly, until static friction gives way.
"""

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from stickslip_sym.core.aliases import FloatArray
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

_ENDS = {
    End.REST: Outcome.AT_REST,
    End.STEPS: Outcome.STEP_LIMIT,
    End.DEADLINE: Outcome.TIME_LIMIT,
    End.UNBOUNDED: Outcome.UNBOUNDED,
    End.UNDEFINED: Outcome.UNDEFINED,
}
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
    tau, q, w = 0.0, recorder.q_of(x0), (osc.V - v0) / osc.V
    side = 1 if w > 0 else -1
    steps = 0
    while tau < horizon:
        if w == 0 and scene.sticks(q) and q < 0:
            end = min(horizon, tau - q)
            recorder.stick(tau, q, end)
            tau, q = end, (0.0 if end < horizon else q + end - tau)
            continue
        if w == 0:  # at P, or beyond what static friction holds on either side
            side = 1 if q >= 0 else -1
        phase = follow(
            scene, Point(tau, q, abs(w)), side,
            horizon=horizon, rtol=rtol, max_steps=max_steps - steps, deadline=deadline,
            engine=chosen,
        )  # fmt: skip
        recorder.slip(phase)
        if phase.end is End.REST:
            # Where rest is isolated it is known better than integrated; a jump of mu at V holds the mass anywhere.
            held = phase.last.w == 1 and any(branch.low == 1 for branch in scene.branches)
            recorder.rest(horizon, None if held else osc.N * float(law.mu(osc.V)) / osc.k)
        if phase.end in _ENDS:
            note = str(phase.error or "") if phase.end is not End.UNBOUNDED else _GROWS
            return recorder.trajectory(_ENDS[phase.end], note)
        steps += len(phase.interpolants)
        tau, q, w = phase.last.tau, phase.last.q, phase.last.w
    return recorder.trajectory(Outcome.FINISHED)


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
    osc: Oscillator
    x_onset: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        q, w = self.phase.at(t * self.osc.omega)
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

    def stick(self, tau: float, q: float, end: float) -> None:
        # Two samples hold all there is to a straight line.
        times = np.array([tau, end])
        course = _Straight(tau / self.osc.omega, self.x_onset + self.length * q, self.osc.V)
        self._add(times, q + times - tau, np.zeros(2), 1, Phase.STICK, course)

    def slip(self, phase: SlipPhase) -> None:
        tau, q, w = np.array([(point.tau, point.q, point.w) for point in phase.points]).T
        kind = Phase.SLIP_BACK if phase.side > 0 else Phase.SLIP_FORWARD
        self._add(tau, q, w, phase.side, kind, _Slip(phase, self.osc, self.x_onset))

    def rest(self, end: float, known: float | None) -> None:
        """Prolong a slip phase that came to rest, where x is known or is as it was integrated."""
        before = self.stretches[-1]
        x = float(self.samples[-1][1][-1]) if known is None else known
        t = np.array([end / self.osc.omega])
        self.samples.append((t, np.array([x]), np.zeros(1)))
        self.stretches.append(Stretch(before.phase, before.end, float(t[0]), _Straight(before.end, x, 0.0)))

    def _add(self, tau: FloatArray, q: FloatArray, w: FloatArray, side: int, phase: Phase, course: Course) -> None:
        t, x, v = tau / self.osc.omega, self.x_onset + self.length * q, self.osc.V * (1 - side * w)
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

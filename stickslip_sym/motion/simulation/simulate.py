"""`simulate`: the motion from one initial condition, or from many."""

from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.simulation.many import Trajectories, simulate_many
from stickslip_sym.motion.simulation.phases import Slipping, Sticking, outcome_of, phases
from stickslip_sym.motion.simulation.reference import simulate_by_solve_ivp
from stickslip_sym.motion.simulation.trajectory import (
    Course,
    Event,
    EventKind,
    Outcome,
    Phase,
    Stretch,
    Trajectory,
)
from stickslip_sym.motion.slip import Dimensionless

__all__ = ["simulate"]


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float, x0: float = ..., v0: float | None = ...,
    rtol: float = ..., method: str = ..., max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory: ...  # fmt: skip


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float, x0: ArrayLike = ..., v0: ArrayLike | None = ...,
    rtol: float = ..., method: str = ..., max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory | Trajectories: ...  # fmt: skip


def simulate(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    t_end: float,
    x0: ArrayLike = 0.0,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    method: str = "events",
    max_steps: int = 200_000,
    time_limit: float | None = None,
    workers: int = 1,
) -> Trajectory | Trajectories:
    """Integrate m x'' + c x' + k x = friction from x(0) = x0, x'(0) = v0, events included.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    t_end : float
        Duration in s, positive.
    x0 : float or array
        Initial displacement in m, one or many.
    v0 : float or array, optional
        Initial velocity in m/s; the belt speed if not given. Arrays of initial conditions broadcast.
    rtol : float
        Relative tolerance of a step, 1e-13 to 1e-3.
    method : {"events", "solve_ivp"}
        The package's integrator, which locates extrema before crossings, kinks and sliding modes; or SciPy's
        `solve_ivp` with events, an independent reference for one initial condition.
    max_steps : int
        Integration steps after which a motion ends as it is; a cycle of stick and slip takes about 30.
    time_limit : float, optional
        Seconds of computation after which it ends as it is.
    workers : int
        Threads for many initial conditions, where numba is there.

    Returns
    -------
    Trajectory or Trajectories
        For one initial condition, or many. The `outcome` says whether `t_end`, a limit, or a rest that goes on
        for ever was reached, or that the motion grows without bound, or comes to where mu has no value.

    Raises
    ------
    InputError
        For unusable numbers, or an unbound law.
    NotConverged
        When `solve_ivp` cannot go on.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=1.0, V=0.5, N=9.81)
    >>> motion = ss.simulate(law, osc, t_end=5.0)
    >>> motion.motion.value, len(motion.starts_of(ss.Phase.STICK))
    ('stick-slip', 8)
    """
    law = as_law(law)
    t_end = real("t_end", t_end)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    rtol = read_rtol(rtol)
    max_steps = int(real("max_steps", max_steps))
    if max_steps < 1:
        raise InputError(f"max_steps = {max_steps} must be at least 1")
    if method not in ("events", "solve_ivp"):
        raise InputError(f"there is no method {str(method)[:40]!r}; choose 'events' or 'solve_ivp'")
    speeds = osc.V if v0 is None else v0
    many = np.ndim(x0) > 0 or np.ndim(speeds) > 0
    with deadline.time_limit(time_limit):
        if many and method == "events":
            return simulate_many(law, osc, x0, speeds, t_end, rtol, max_steps, workers)
        if many:
            raise InputError("method 'solve_ivp' takes one initial condition; simulate them one by one")
        x, v = real("x0", x0), real("v0", speeds)  # type: ignore[arg-type]
        if method == "solve_ivp":
            return simulate_by_solve_ivp(law, osc, x, v, t_end, rtol)
        return _simulate(law, osc, x, v, t_end, rtol, max_steps)


def _simulate(
    law: FrictionLaw, osc: Oscillator, x0: float, v0: float, t_end: float, rtol: float, max_steps: int
) -> Trajectory:
    system = Dimensionless.of(law, osc)
    recorder = _Recorder(law, osc, system, rtol)
    w = (osc.V - v0) / osc.V
    side = 1 if w > 0 else -1
    outcome, note = Outcome.FINISHED, ""
    steps = 0
    for part in phases(
        system, (x0 - recorder.x_onset) / osc.length, abs(w), side, t_end * osc.omega, rtol, max_steps
    ):
        if isinstance(part, Sticking):
            recorder.stick(part)
            continue
        recorder.slip(part)
        steps += part.slip.taken
        outcome, note = outcome_of(system, part.slip, rtol, out_of_steps=steps >= max_steps)
        if outcome is Outcome.AT_REST:
            recorder.rest(t_end, held=part.slip.w == 1 and 1.0 in system.rise.levels)
    return recorder.trajectory(outcome, note)


@dataclass(frozen=True)
class _Straight:
    """The course of a mass that moves with one velocity: in stick, or at rest."""

    begin: float
    x: float
    v: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.x + self.v * (t - self.begin), np.full(t.shape, self.v)


@dataclass(frozen=True)
class _Slip:
    """The course of a slip phase, in units."""

    system: Dimensionless
    part: Slipping
    osc: Oscillator
    x_onset: float
    rtol: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        slip, side = self.part.slip, self.part.side
        tau = np.clip(t * self.osc.omega - self.part.tau, 0.0, slip.tau).ravel()
        if slip.steps:
            which = np.searchsorted([step.tau for step in slip.steps[1:]], tau, side="right")
            q, w = self.system.states(slip.steps, which, tau, side, self.rtol)
        else:
            q, w = np.full(tau.shape, slip.q), np.full(tau.shape, slip.w)
        x, v = self.x_onset + self.osc.length * q, self.osc.V * (1 - side * w)
        return x.reshape(t.shape), v.reshape(t.shape)


class _Recorder:
    """Collects phases and gives them their units back."""

    def __init__(self, law: FrictionLaw, osc: Oscillator, system: Dimensionless, rtol: float) -> None:
        self.osc, self.system, self.rtol = osc, system, rtol
        self.x_onset = osc.onset(law)
        self.samples: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self.events: list[Event] = []
        self.stretches: list[Stretch] = []

    def stick(self, part: Sticking) -> None:
        # Two samples hold all there is to a straight line.
        times = np.array([part.tau, part.end])
        x = self.x_onset + self.osc.length * (part.q + times - part.tau)
        course = _Straight(part.tau / self.osc.omega, float(x[0]), self.osc.V)
        self._add(times, x, np.full(2, self.osc.V), Phase.STICK, course)

    def slip(self, part: Slipping) -> None:
        slip = part.slip
        tau, q, w = np.array([*(step[:3] for step in slip.steps), (slip.tau, slip.q, slip.w)]).T
        kind = Phase.SLIP_BACK if part.side > 0 else Phase.SLIP_FORWARD
        x, v = self.x_onset + self.osc.length * q, self.osc.V * (1 - part.side * w)
        self._add(part.tau + tau, x, v, kind, _Slip(self.system, part, self.osc, self.x_onset, self.rtol))

    def rest(self, end: float, *, held: bool) -> None:
        """Prolong a slip that came to rest: where rest is isolated x is known better than integrated.

        - `held`: by a jump of mu at the belt's speed, wherever it is.
        """
        before = self.stretches[-1]
        x = float(self.samples[-1][1][-1]) if held else self.x_onset + self.osc.length * self.system.rest[0]
        self.samples.append((np.array([end]), np.array([x]), np.zeros(1)))
        self.stretches.append(Stretch(before.phase, before.end, end, _Straight(before.end, x, 0.0)))

    def _add(self, tau: FloatArray, x: FloatArray, v: FloatArray, phase: Phase, course: Course) -> None:
        t = tau / self.osc.omega
        kind = EventKind.START
        if self.events:
            slipped = self.events[-1].begins is not Phase.STICK
            kind = EventKind.CROSSES if slipped else EventKind.SLIPS
            kind = EventKind.STICKS if phase is Phase.STICK else kind
        self.samples.append((t, x, v))
        self.events.append(Event(float(t[0]), float(x[0]), float(v[0]), phase, kind))
        self.stretches.append(Stretch(phase, float(t[0]), float(t[-1]), course))

    def trajectory(self, outcome: Outcome, note: str) -> Trajectory:
        t, x, v = (np.concatenate(parts) for parts in zip(*self.samples, strict=True))
        lengths = [part[0].size for part in self.samples]
        kinds = np.empty(len(lengths), dtype=object)
        kinds[:] = [stretch.phase for stretch in self.stretches]
        phase = np.repeat(kinds, lengths)
        return Trajectory(
            self.osc, self.rtol, t, x, v, phase, tuple(self.events), outcome, tuple(self.stretches), note
        )

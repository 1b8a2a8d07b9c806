"""The event-driven automaton: the phases of a motion, one after another.

Three states: stick, slip slower than the belt, slip faster than the belt. Slip is integrated (`motion.slip`);
stick is not, as it is known: x' = V exactly, until static friction gives way.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.simulation.trajectory import Outcome, Phase, Straight, Stretch, Trajectory
from stickslip_sym.motion.slip import Dimensionless, End, Slip

__all__ = ["outcome_of", "simulate_by_events"]

_GROWS = "damping and friction feed the motion: try a shorter t_end, or a larger c"


def simulate_by_events(
    law: FrictionLaw, osc: Oscillator, x0: float, v0: float, t_end: float, rtol: float, max_steps: int
) -> Trajectory:
    """Return the motion as `simulate` does; its samples hold the extremes of x and of v."""
    system, x_P = Dimensionless.of(law, osc), osc.onset(law)
    parts = list[tuple[Stretch, FloatArray]]()
    outcome, note, steps = Outcome.FINISHED, "", 0
    u = v0 / osc.V
    horizon = t_end * osc.omega
    for tau, side, phase in _phases(system, (x0 - x_P) / osc.length, u, horizon, rtol, max_steps):
        if isinstance(phase, _Stick):
            # Two samples hold all there is to a straight line.
            times = np.array([tau, phase.end])
            x, v = x_P + osc.length * (phase.q + times - tau), np.full(2, osc.V)
            samples = np.array([times / osc.omega, x, v])
            stretch = Stretch(Phase.STICK, samples[0, 0], samples[0, 1], Straight(samples[0, 0], x[0], osc.V))
        else:
            since, q, w = np.array([*(step[:3] for step in phase.steps), (phase.tau, phase.q, phase.w)]).T
            samples = np.array([
                (tau + since) / osc.omega, x_P + osc.length * q, osc.V * (1 - side * w)
            ])  # fmt: skip
            course = _Curve(system, tau, side, phase, osc, x_P, rtol)
            kind = Phase.SLIP_BACK if side > 0 else Phase.SLIP_FORWARD
            stretch = Stretch(kind, samples[0, 0], samples[0, -1], course)
            steps += phase.taken
            outcome, note = outcome_of(system, phase, rtol, out_of_steps=steps >= max_steps)
        parts.append((stretch, samples))
    if outcome is Outcome.AT_REST:
        # Where rest is isolated x is known better than integrated; a jump of mu holds the mass wherever it is.
        held = w[-1] == 1 and 1.0 in system.rise.levels
        x_rest = samples[1, -1] if held else x_P + osc.length * system.rest[0]
        rest = Stretch(stretch.phase, stretch.end, t_end, Straight(stretch.end, x_rest, 0.0))
        parts.append((rest, np.array([[t_end], [x_rest], [0.0]])))
    return Trajectory.of(osc, rtol, parts, outcome, note)


@dataclass(frozen=True)
class _Stick:
    """A stick phase: its end, and the displacement q where it begins."""

    end: float
    q: float


def _phases(
    system: Dimensionless, q: float, u: float, horizon: float, rtol: float, max_steps: int
) -> Iterator[tuple[float, int, _Stick | Slip]]:
    """Yield when each phase begins, on which side of the belt's speed, and the phase.

    They go up to the horizon, or the first that does not go on. Nothing depends on time itself, so a slip from
    where one began before is that one again: every stick ends at P, and a motion that sticks is integrated for
    one round, whatever its length.

    Raises `InputError` or `NotConverged` where mu has no value at the begin.
    """
    known = dict[tuple[float, int], Slip]()
    tau, steps, w, side = 0.0, 0, abs(1 - u), 1 if u < 1 else -1
    while tau < horizon:
        if w == 0 and system.sticks(q) and q < 0:
            end = min(horizon, tau - q)
            yield tau, 0, _Stick(end, q)
            tau, q = end, (0.0 if end < horizon else q + end - tau)
            continue
        if w == 0:  # at P, or beyond what static friction holds on either side
            side = 1 if q >= 0 else -1
        left = max_steps - steps
        slip = known.get((q, side)) if w == 0 else None
        if deadline.time_left() < 0:
            slip = Slip(End.STEPS, 0.0, q, w, 0.0, 0.0, 0, (q, q, w, w), [])
        elif slip is None or tau + slip.tau > horizon or slip.taken > left:
            slip = system.slip(q, w, side, level=1.0, horizon=horizon - tau, rtol=rtol, most=left, recorded=True)
            refusal = system.refusal(slip, rtol)
            if refusal is not None and not slip.taken and slip.end is not End.STEPS:
                raise refusal
            if w == 0 and slip.end is End.RETURN:
                known[q, side] = slip
        yield tau, side, slip
        if slip.end is not End.RETURN:
            return
        steps += slip.taken
        tau, q, w = tau + slip.tau, slip.q, 0.0


def outcome_of(system: Dimensionless, slip: Slip, rtol: float, *, out_of_steps: bool) -> tuple[Outcome, str]:
    """Return what the end of a slip says of the whole motion, and why it does not go on."""
    if slip.end is End.REST:
        return Outcome.AT_REST, ""
    if slip.end is End.STEPS:
        return (Outcome.STEP_LIMIT if out_of_steps else Outcome.TIME_LIMIT), ""
    if system.unbounded(slip):
        return Outcome.UNBOUNDED, _GROWS
    refusal = system.refusal(slip, rtol)
    if refusal is not None:
        return Outcome.UNDEFINED, str(refusal)
    return Outcome.FINISHED, ""


@dataclass(frozen=True)
class _Curve:
    """The course of a slip phase that begins at `tau` on a side."""

    system: Dimensionless
    tau: float
    side: int
    slip: Slip
    osc: Oscillator
    onset: float
    rtol: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        slip, side = self.slip, self.side
        tau = np.clip(t * self.osc.omega - self.tau, 0.0, slip.tau).ravel()
        if slip.steps:
            which = np.searchsorted([step.tau for step in slip.steps[1:]], tau, side="right")
            q, w = self.system.states(slip.steps, which, tau, side, self.rtol)
        else:
            q, w = np.full(tau.shape, slip.q), np.full(tau.shape, slip.w)
        x, v = self.onset + self.osc.length * q, self.osc.V * (1 - side * w)
        return x.reshape(t.shape), v.reshape(t.shape)

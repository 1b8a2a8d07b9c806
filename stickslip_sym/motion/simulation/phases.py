"""The event-driven automaton: the phases of a motion, one after another.

Three states: stick, slip slower than the belt, slip faster than the belt. Slip is integrated (`motion.slip`);
stick is not, as it is known: x' = V exactly, until static friction gives way.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from stickslip_sym.core import deadline
from stickslip_sym.motion.simulation.trajectory import Outcome
from stickslip_sym.motion.slip import Dimensionless, End, Slip

__all__ = ["Slipping", "Sticking", "outcome_of", "phases"]

_GROWS = "damping and friction feed the motion: try a shorter t_end, or a larger c"


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
class Sticking:
    """A stick phase: its begin, its end, and the displacement q where it begins."""

    tau: float
    end: float
    q: float


@dataclass(frozen=True)
class Slipping:
    """A slip phase that begins at `tau` on a side; the slip itself counts from 0."""

    tau: float
    side: int
    slip: Slip

    @property
    def end(self) -> float:
        """The time at which it ends."""
        return self.tau + self.slip.tau


def phases(
    system: Dimensionless, q: float, w: float, side: int, horizon: float, rtol: float, max_steps: int
) -> Iterator[Sticking | Slipping]:
    """Yield the phases of a motion one after another, up to the horizon or the first that does not go on.

    Nothing depends on time itself, so a slip from where one began before is that one again: every stick ends at
    P, and a motion that sticks is integrated for one round, whatever its length.

    Raises `InputError` or `NotConverged` where mu has no value at the begin.
    """
    known = dict[tuple[float, int], Slip]()
    tau, steps = 0.0, 0
    while tau < horizon:
        if w == 0 and system.sticks(q) and q < 0:
            end = min(horizon, tau - q)
            yield Sticking(tau, end, q)
            tau, q = end, (0.0 if end < horizon else q + end - tau)
            continue
        if w == 0:  # at P, or beyond what static friction holds on either side
            side = 1 if q >= 0 else -1
        left = max_steps - steps
        slip = known.get((q, side)) if w == 0 else None
        if deadline.time_left() < 0:
            slip = Slip(End.STEPS, 0.0, q, w, 0.0, 0.0, 0, [])
        elif slip is None or tau + slip.tau > horizon or slip.taken > left:
            slip = system.slip(q, w, side, horizon=horizon - tau, rtol=rtol, most=left, recorded=True)
            refusal = system.refusal(slip, rtol)
            if refusal is not None and not slip.taken and slip.end is not End.STEPS:
                raise refusal
            if w == 0 and slip.end is End.RETURN:
                known[q, side] = slip
        yield Slipping(tau, side, slip)
        if slip.end is not End.RETURN:
            return
        steps += slip.taken
        tau, q, w = tau + slip.tau, slip.q, 0.0

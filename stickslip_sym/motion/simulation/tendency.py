"""What a motion has come to, from its last rounds: a word for it, and how much a round changes it.

A round goes from one extreme of x to the next but one. At each of them v = 0, so the mass slips there, slower than
the belt. The motion so far is all that is looked at: `classify` says where a start leads in the end.
"""

from collections.abc import Sequence, Set

import numpy as np
from scipy.optimize import brentq

from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome, Phase, Tendency, Trajectory

__all__ = ["tendency", "word"]

_SAME = 1e-6  # relative change of a swing in a round, up to which a motion repeats itself
_STEPS = 100  # errors of a step that may add up in a round
_STILL = 1e-9  # m for each m that the belt moves in 1/omega: a smaller swing is rest


def tendency(motion: Trajectory, *, length: float, rtol: float) -> tuple[Tendency, float | None]:
    """Return what a motion has come to, and for slip alone the relative change of its swing in a round.

    - `length`: V / omega in m, the size of displacements.
    - `rtol`: the relative tolerance of a step that it was integrated with.
    """
    # Where a motion grows without bound its turns are lost in rounding.
    turns = _last_turns(motion) if motion.outcome is not Outcome.UNBOUNDED else []
    since = turns[-3] if len(turns) > 2 else -np.inf
    kinds = [event.kind for event in motion.events]
    released = EventKind.SLIPS in kinds
    return word(
        motion.outcome,
        {stretch.phase for stretch in motion.stretches if stretch.end > since},
        released=released,
        back=released and EventKind.STICKS in kinds[kinds.index(EventKind.SLIPS) :],
        swings=np.abs(np.diff(motion.at(turns).x)).tolist() if len(turns) == 4 else None,
        length=length,
        rtol=rtol,
    )


def word(
    outcome: Outcome,
    lately: Set[Phase],
    *,
    released: bool,
    back: bool,
    swings: Sequence[float] | None,
    length: float,
    rtol: float,
) -> tuple[Tendency, float | None]:
    """Return the word for a motion, and for slip alone the relative change of its swing in a round.

    - `lately`: the phases since the last extreme of x but two.
    - `released`: whether static friction has given way, and `back`: whether the mass stuck again after that.
    - `swings`: the last three; None where there were not as many.
    """
    if outcome is Outcome.AT_REST:
        return Tendency.REST, None
    if outcome is Outcome.UNBOUNDED:
        return Tendency.UNBOUNDED, None
    if Phase.STICK in lately and released:
        # Every stick ends at the same place, so a mass that comes back to it does so for ever.
        return (Tendency.STICK_SLIP if back else Tendency.SHORT), None
    if lately == {Phase.STICK}:
        return Tendency.STICK, None
    if swings is None or Phase.STICK in lately:
        return Tendency.SHORT, None
    before, _, now = swings
    if min(before, now) == 0 or max(before, now) <= _STILL * length:
        return Tendency.REST, None
    change = now / before - 1
    if Phase.SLIP_FORWARD in lately:
        return Tendency.OVERTAKES, change
    if abs(change) <= max(_SAME, _STEPS * rtol):
        return Tendency.PURE_SLIP, change
    return (Tendency.SHRINKS if change < 0 else Tendency.GROWS), change


def _last_turns(motion: Trajectory) -> list[float]:
    """Return the last four times at most at which v changes its sign."""
    moving = np.flatnonzero(motion.v)
    signs = np.sign(motion.v[moving])
    places = np.flatnonzero(signs[:-1] != signs[1:])[-4:]
    brackets = [(float(motion.t[moving[i]]), float(motion.t[moving[i + 1]])) for i in places]
    return [float(brentq(lambda t: float(motion.at(t).v), low, high)) for low, high in brackets]

"""Many initial conditions of one oscillator: a loop over the same slip, compiled where numba is there.

Every stick ends at the same point P, so the motion from P is integrated once: a motion is followed up to P, and
what comes after is read from that one.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import FloatArray, IntArray, ObjectArray
from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_array
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.compiled import compilable
from stickslip_sym.motion.simulation.by_events import outcome_of, simulate_by_events
from stickslip_sym.motion.simulation.trajectory import Outcome, Phase
from stickslip_sym.motion.slip import Dimensionless, End, Slip, follow
from stickslip_sym.output import files, markup

__all__ = ["Trajectories", "simulate_many"]

_BATCH = 500  # motions between two looks at the time limit
_PHASES = tuple(Phase)
"""Their places are what compiled code notes."""
_STICK, _BACK, _FORWARD = (_PHASES.index(phase) for phase in (Phase.STICK, Phase.SLIP_BACK, Phase.SLIP_FORWARD))
_RETURN, _HORIZON, _REST = int(End.RETURN), int(End.HORIZON), int(End.REST)
_ONSET = 100  # instead of the number of an `End`: the motion came to P


@dataclass(frozen=True, repr=False)
class Trajectories:
    """What became of many initial conditions; every array has their shape.

    Attributes
    ----------
    law : FrictionLaw
    oscillator : Oscillator
    t_end : float
        Duration in s.
    rtol : float
        Relative tolerance of a step.
    x0, v0 : numpy.ndarray
        Initial displacements in m and velocities in m/s.
    t, x, v : numpy.ndarray
        Where each motion ended: time in s, displacement in m, velocity in m/s.
    phase : numpy.ndarray of Phase
        The phase in which it ended.
    outcome : numpy.ndarray of Outcome
        Whether `t_end` was reached; else the motion is what was computed so far.
    x_min, x_max, v_min, v_max : numpy.ndarray
        The extremes of the whole motion, as exact as its events.
    changes : numpy.ndarray of int
        How many changes of phase it had.
    sticks : numpy.ndarray of int
        How often the mass came to stick.
    first_stick : numpy.ndarray
        When it first stuck, in s; NaN if it never did.
    """

    law: FrictionLaw
    oscillator: Oscillator
    t_end: float
    rtol: float
    x0: FloatArray
    v0: FloatArray
    t: FloatArray
    x: FloatArray
    v: FloatArray
    phase: ObjectArray
    outcome: ObjectArray
    x_min: FloatArray
    x_max: FloatArray
    v_min: FloatArray
    v_max: FloatArray
    changes: IntArray
    sticks: IntArray
    first_stick: FloatArray

    def __len__(self) -> int:
        return self.x0.size

    def count(self) -> dict[str, int]:
        """Return how many motions stick, slip, came to rest, or ended otherwise."""
        done = self.outcome == Outcome.FINISHED
        found = {
            "stick": int((done & (self.sticks > 0)).sum()),
            "only slip": int((done & (self.sticks == 0)).sum()),
        }
        found |= {one.value: int((self.outcome == one).sum()) for one in Outcome if one is not Outcome.FINISHED}
        return {word: number for word, number in found.items() if number}

    def __repr__(self) -> str:
        counts = ", ".join(f"{number} {word}" for word, number in self.count().items())
        return f"Trajectories: {len(self)} initial conditions to t = {self.t.max():.6g} s; {counts}"

    def _repr_html_(self) -> str:
        rows = [[word, str(number)] for word, number in self.count().items()]
        return markup.block(repr(self), markup.table(["motion", "initial conditions"], rows))

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each initial condition, with units in the header.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        units = {"x0": "m", "v0": "m/s", "t": "s", "x": "m", "v": "m/s", "x_min": "m", "x_max": "m"}
        units |= {"v_min": "m/s", "v_max": "m/s", "first_stick": "s"}
        columns: dict[str, ArrayLike] = {f"{name} ({unit})": getattr(self, name) for name, unit in units.items()}
        columns |= {"changes": self.changes, "sticks": self.sticks, "outcome": files.texts(self.outcome)}
        files.write_csv(Path(path), columns)


def simulate_many(
    law: FrictionLaw,
    osc: Oscillator,
    x0: ArrayLike,
    v0: ArrayLike,
    t_end: float,
    rtol: float,
    max_steps: int,
    workers: int,
) -> Trajectories:
    """Return the motions of `simulate` for many initial conditions.

    Raises
    ------
    InputError
        For an unbound law, or initial conditions that do not broadcast.
    """
    x0, v0 = read_initial_conditions(x0, v0)
    system, x_P, horizon = Dimensionless.of(law, osc), osc.onset(law), t_end * osc.omega
    q, u = (x0.ravel() - x_P) / osc.length, v0.ravel() / osc.V
    numbers, counts = _up_to_P(system, q, u, horizon, rtol, max_steps, workers)
    tau, q, u, q_min, q_max, u_min, u_max, first = numbers
    end, phase, changes, sticks = counts
    t, first_stick = np.where(tau >= horizon, t_end, tau / osc.omega), first / osc.omega
    x, x_min, x_max = (x_P + osc.length * row for row in (q, q_min, q_max))
    v, v_min, v_max = (osc.V * row for row in (u, u_min, u_max))
    phases, outcome = np.array(_PHASES, dtype=object)[phase], np.full(q.shape, Outcome.FINISHED, dtype=object)
    for i in np.flatnonzero(~np.isin(end, (_HORIZON, _ONSET, _REST))).tolist():
        slip = Slip(End(end[i]), 0.0, 0.0, abs(1 - u[i]), 0.0, 0.0, 0, (0.0, 0.0, 0.0, 0.0), [])
        outcome[i], _ = outcome_of(system, slip, rtol, out_of_steps=time_left() > 0)
    rest = end == _REST
    outcome[rest], t[rest], v[rest] = Outcome.AT_REST, t_end, 0.0
    # Where rest is isolated x is known better than integrated; a jump of mu holds the mass wherever it is.
    x[rest & ~((u == 0) & (1.0 in system.rise.levels))] = x_P + osc.length * system.rest[0]

    came = np.flatnonzero(end == _ONSET)
    if came.size:
        left = t_end - t[came]
        course = simulate_by_events(law, osc, x_P, osc.V, float(left.max()), rtol, max_steps)
        at_rest = course.outcome is Outcome.AT_REST
        over = left >= (course.stretches[-1].start if at_rest else course.t[-1])
        outcome[came[over]] = course.outcome
        since = np.minimum(left, course.t[-1])
        t[came] += since
        x[came], v[came], phases[came] = course.at(since)
        event = np.maximum(np.searchsorted([one.t for one in course.events], since) - 1, 0)
        stuck = np.array([one.begins is Phase.STICK for one in course.events])
        late = (sticks[came] == 0) & stuck[: int(event.max()) + 1].cumsum()[event].astype(bool)
        first_stick[came[late]] = t[came[late]] - since[late] + course.events[int(stuck.argmax())].t
        changes[came] += event + 1
        sticks[came] += stuck.cumsum()[event]
        sample = np.searchsorted(course.t, since, side="right") - 1
        for least, most, column, now in ((x_min, x_max, course.x, x), (v_min, v_max, course.v, v)):
            least[came] = np.minimum.reduce([least[came], np.minimum.accumulate(column)[sample], now[came]])
            most[came] = np.maximum.reduce([most[came], np.maximum.accumulate(column)[sample], now[came]])
    columns = t, x, v, phases, outcome, x_min, x_max, v_min, v_max, changes, sticks, first_stick
    return Trajectories(law, osc, t_end, rtol, x0, v0, *(column.reshape(x0.shape) for column in columns))


def read_initial_conditions(x0: ArrayLike, v0: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return initial displacements and velocities as arrays of one shape."""
    places, speeds = read_array("x0", x0), read_array("v0", v0)
    try:
        places, speeds = np.broadcast_arrays(places, speeds)
    except ValueError:
        raise InputError(
            f"x0 of shape {places.shape} and v0 of shape {speeds.shape} do not go together; give one v0 for each "
            "x0, or x0[:, None] and v0 for all combinations"
        ) from None
    if not places.size:
        raise InputError("x0 and v0 hold no initial conditions; give at least one")
    return places.astype(np.float64), speeds.astype(np.float64)


@compilable
def _follow_motions(
    rise: Any, q0: Any, u0: Any, eta: float, zeta: float, static: float, onset: float, horizon: float, rtol: float,
    most: int, wedge: Any, numbers: Any, counts: Any,
) -> None:  # fmt: skip
    """Follow motions up to P or their end, and write what `_up_to_P` returns of each."""
    for i in range(len(q0)):
        tau, q, u = 0.0, q0[i], u0[i]
        side, w = (1.0 if u < 1.0 else -1.0), abs(1.0 - u)
        q_least, q_most, u_least, u_most, first = q, q, u, u, math.nan
        end, phase, changes, sticks, steps = _HORIZON, _BACK, -1, 0, 0
        while tau < horizon:
            if w == 0.0:
                if -2.0 * eta * static <= q < 0.0:
                    phase, changes, sticks, first = _STICK, changes + 1, sticks + 1, tau
                    stop = min(horizon, tau - q)
                    q, tau = (0.0 if stop < horizon else q + horizon - tau), stop
                    q_most = max(q_most, q)
                if q == 0.0 and tau < horizon:
                    end = _ONSET
                if q == 0.0 or tau >= horizon:
                    break
                side = 1.0 if q > 0.0 else -1.0
            phase, changes = (_BACK if side > 0.0 else _FORWARD), changes + 1
            end, duration, q, w, _, _, taken, extremes, _ = follow(
                rise, eta, zeta, eta * (side * static - onset), side, q, w, horizon - tau, rtol, _RETURN, 1.0,
                most - steps, wedge, False,
            )  # fmt: skip
            tau, steps = tau + duration, steps + taken
            u, u_far = 1.0 - side * extremes[2], 1.0 - side * extremes[3]
            q_least, q_most = min(q_least, extremes[0]), max(q_most, extremes[1])
            u_least, u_most = min(u_least, min(u, u_far)), max(u_most, max(u, u_far))
            if end != _RETURN:
                break
        row = (tau, q, 1.0 - side * w, q_least, q_most, u_least, u_most, first)
        for k in range(8):
            numbers[i, k] = row[k]
        counts[i, 0], counts[i, 1], counts[i, 2], counts[i, 3] = end, phase, changes, sticks


def _up_to_P(
    system: Dimensionless, q: FloatArray, u: FloatArray, horizon: float, rtol: float, most: int, workers: int
) -> tuple[FloatArray, IntArray]:
    """Follow motions up to P, or to their end; those whose turn comes when the time is up end at once.

    Returns the rows tau, q, u, the extremes of q and u, and when it first stuck; and the rows of why it ended, its
      phase, and how many changes of phase and how many sticks there were.
    """
    nothing = np.zeros(q.size)
    numbers = np.array((nothing, q, u, q, q, u, u, nothing + math.nan)).T.copy()
    counts = np.zeros((q.size, 4), dtype=np.int64)
    counts[:, 0], counts[:, 1] = End.STEPS, np.where(u < 1, _BACK, _FORWARD)
    arguments = system.eta, system.zeta, system.table.static, system.table.onset, horizon, rtol, most
    system.spread(_follow_motions, (q, u), arguments, (numbers, counts), batch=_BATCH, workers=workers)
    return numbers.T, counts.T

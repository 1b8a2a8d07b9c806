"""Many initial conditions of one oscillator: a loop over the same slip, compiled where numba is there.

Every stick ends at the same point P, so the motion from P is integrated once: a motion is followed up to P, and
what comes after is read from that one.
"""

import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.deadline import time_left
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_array
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.compiled import compilable, compiled, is_compiling
from stickslip_sym.motion.simulation.phases import Sticking, outcome_of, phases
from stickslip_sym.motion.simulation.trajectory import Outcome, Phase
from stickslip_sym.motion.slip import EVERY_TURN, Dimensionless, End, Slip, Step, follow
from stickslip_sym.output import files, markup

__all__ = ["Trajectories", "simulate_many"]

_BATCH = 500  # motions between two looks at the time limit
_PHASES, _OUTCOMES = tuple(Phase), tuple(Outcome)
"""Their numbers are what compiled code notes."""
_STICK, _BACK, _FORWARD = (_PHASES.index(phase) for phase in (Phase.STICK, Phase.SLIP_BACK, Phase.SLIP_FORWARD))
_RETURN, _MINIMUM, _MAXIMUM = int(End.RETURN), int(End.MINIMUM), int(End.MAXIMUM)
_LEVEL, _HORIZON = int(End.LEVEL), int(End.HORIZON)
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
    found = _Found.to_P(system, q, u, horizon, rtol, max_steps, workers)
    came = np.flatnonzero(found.end == _ONSET)
    outcome = np.array([_outcome(system, end, w) for end, w in zip(found.end, np.abs(1 - found.u), strict=True)])
    if came.size:
        course = _Course(system, float(horizon - found.tau[came].min()), rtol, max_steps)
        outcome[came] = found.continued(came, course, horizon)
    if (resting := outcome == _OUTCOMES.index(Outcome.AT_REST)).any():
        found.come_to_rest(resting, system, horizon)
    shape = x0.shape
    length, omega, V = osc.length, osc.omega, osc.V
    return Trajectories(
        law, osc, t_end, rtol, x0, v0,
        t=np.where(found.tau >= horizon, t_end, found.tau / omega).reshape(shape),
        x=(x_P + length * found.q).reshape(shape),
        v=(V * found.u).reshape(shape),
        phase=_members(_PHASES, found.phase).reshape(shape),
        outcome=_members(_OUTCOMES, outcome).reshape(shape),
        x_min=(x_P + length * found.q_min).reshape(shape),
        x_max=(x_P + length * found.q_max).reshape(shape),
        v_min=(V * found.u_min).reshape(shape),
        v_max=(V * found.u_max).reshape(shape),
        changes=found.changes.reshape(shape),
        sticks=found.sticks.reshape(shape),
        first_stick=(found.first_stick / omega).reshape(shape),
    )  # fmt: skip


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
    rise: Any, eta: float, zeta: float, static: float, onset: float, q0: Any, u0: Any, horizon: float, rtol: float,
    most: int, source: Any, numbers: Any, counts: Any,
) -> None:  # fmt: skip
    """Follow motions up to P or their end, and write the columns of `_Found` for each."""
    for i in range(len(q0)):
        tau, q, u = 0.0, q0[i], u0[i]
        side = 1.0 if u < 1.0 else -1.0
        w = abs(1.0 - u)
        q_min, q_max, u_min, u_max = q, q, u, u
        end, phase, changes, sticks, steps, first = _HORIZON, _BACK, -1, 0, 0, math.nan
        slipping = False
        while tau < horizon:
            if w == 0.0 and not slipping:
                if -2.0 * eta * static <= q < 0.0:
                    phase, changes, sticks, first = _STICK, changes + 1, sticks + 1, tau
                    stop = min(horizon, tau - q)
                    q, tau = (0.0 if stop < horizon else q + horizon - tau), stop
                    q_max = max(q_max, q)
                if q == 0.0 and tau < horizon:
                    end = _ONSET
                    break
                if tau >= horizon:
                    break
                side = 1.0 if q >= 0.0 else -1.0
            if not slipping:
                phase, changes, slipping = (_BACK if side > 0.0 else _FORWARD), changes + 1, True
            push = eta * (side * static - onset)
            end, duration, q, w, _, _, taken, _ = follow(
                rise, eta, zeta, push, side, q, w, horizon - tau, rtol, 1.0, EVERY_TURN, 1.0, most - steps,
                (False, 0.0, source), False,
            )  # fmt: skip
            tau, steps, u = tau + duration, steps + taken, 1.0 - side * w
            q_min, q_max, u_min, u_max = min(q_min, q), max(q_max, q), min(u_min, u), max(u_max, u)
            if end == _RETURN:
                slipping = False
            elif end not in (_LEVEL, _MINIMUM, _MAXIMUM):
                break
        u = 1.0 - side * w
        row = (tau, q, u, q_min, q_max, u_min, u_max, first)
        for k in range(8):
            numbers[k, i] = row[k]
        counts[0, i], counts[1, i], counts[2, i], counts[3, i] = end, phase, changes, sticks


@dataclass
class _Found:
    """What became of motions, free of units; u is the velocity over the belt's."""

    tau: FloatArray
    q: FloatArray
    u: FloatArray
    q_min: FloatArray
    q_max: FloatArray
    u_min: FloatArray
    u_max: FloatArray
    first_stick: FloatArray
    end: IntArray
    phase: IntArray
    changes: IntArray
    sticks: IntArray

    @classmethod
    def to_P(
        cls,
        system: Dimensionless,
        q: FloatArray,
        u: FloatArray,
        horizon: float,
        rtol: float,
        most: int,
        workers: int,
    ) -> "_Found":
        """Follow motions up to P, or to their end; those whose turn comes when the time is up end at once."""
        size = q.size
        numbers, counts = np.empty((8, size)), np.empty((4, size), dtype=np.int64)
        fast = is_compiling()
        rise = system.table.at(system.V, arrays=fast)
        run = compiled(_follow_motions)
        source = (0.0, 0.0, 0.0, rise.pieces, np.zeros(len(rise.jumps)))
        table = system.table

        def batch(low: int) -> None:
            some = slice(low, low + _BATCH)
            arrays = [column[some] if fast else column[some].tolist() for column in (q, u)]
            bound = most if time_left() > 0 else 0
            run(
                rise, system.eta, system.zeta, table.static, table.onset, *arrays, horizon, rtol, bound, source,
                numbers[:, some], counts[:, some],
            )  # fmt: skip

        batches = range(0, size, _BATCH)
        if workers > 1 and fast:
            contexts = [copy_context() for _ in batches]  # each thread has the time limit of this call
            with ThreadPoolExecutor(workers) as pool:
                list(pool.map(lambda context, low: context.run(batch, low), contexts, batches))
        else:
            for low in batches:
                batch(low)
        return cls(*numbers, *counts)

    def continued(self, rows: IntArray, course: "_Course", horizon: float) -> IntArray:
        """Go on with the motions that came to P, and return their outcomes."""
        onset = self.tau[rows]
        cut = course.at(horizon - onset)
        stuck_before = self.sticks[rows] > 0
        self.tau[rows], self.q[rows], self.u[rows] = onset + cut["tau"], cut["q"], cut["u"]
        self.q_min[rows] = np.minimum(self.q_min[rows], cut["q_min"])
        self.q_max[rows] = np.maximum(self.q_max[rows], cut["q_max"])
        self.u_min[rows] = np.minimum(self.u_min[rows], cut["u_min"])
        self.u_max[rows] = np.maximum(self.u_max[rows], cut["u_max"])
        self.phase[rows] = cut["phase"]
        self.changes[rows] += cut["changes"].astype(np.int64)
        self.sticks[rows] += cut["sticks"].astype(np.int64)
        late = ~stuck_before & (cut["sticks"] > 0)
        self.first_stick[rows[late]] = onset[late] + course.first_stick
        return cut["outcome"].astype(np.int64)

    def come_to_rest(self, rows: BoolArray, system: Dimensionless, horizon: float) -> None:
        """Prolong motions at rest: where rest is isolated it is known better than integrated."""
        held = (self.u[rows] == 0) & (1.0 in system.rise.levels)
        self.q[rows] = np.where(held, self.q[rows], system.rest[0])
        self.tau[rows], self.u[rows] = horizon, 0.0


class _Course:
    """The motion from P, and what has become of it at any time.

    Its columns are its steps, one after another, and the extremes of x within them: in each, when it begins, what
    goes on from there, and the state there.
    """

    def __init__(self, system: Dimensionless, horizon: float, rtol: float, most: int) -> None:
        self.system, self.rtol = system, rtol
        self.steps: list[Step] = []
        self.first_stick, self.outcome = math.nan, Outcome.FINISHED
        self.end, self.state = 0.0, (0.0, 1.0)
        rows: list[tuple[float, ...]] = []
        known = dict[int, list[tuple[float, int, float, float]]]()
        changes, sticks, taken = 0, 0, 0
        for part in phases(system, 0.0, 0.0, 1, horizon, rtol, most):
            changes += 1
            if isinstance(part, Sticking):
                sticks += 1
                self.first_stick = part.tau if sticks == 1 else self.first_stick
                rows.append((part.tau, part.tau - part.q, -1, 0, _STICK, changes, sticks, part.q, 1.0))
                self.end, self.state = part.end, (part.q + part.end - part.tau, 1.0)
                continue
            slip, side = part.slip, part.side
            if id(slip) not in known:
                known[id(slip)] = self._places(slip, side)
            phase = _BACK if side > 0 else _FORWARD
            rows += [
                (part.tau + tau, part.tau, number, side, phase, changes, sticks, q, u)
                for tau, number, q, u in known[id(slip)]
            ]
            taken += slip.taken
            self.outcome, _ = outcome_of(system, slip, rtol, out_of_steps=taken >= most)
            self.end, self.state = part.end, (slip.q, 1.0 - side * slip.w)
        self.rows = np.array(rows).T
        self.lowest = np.minimum.accumulate(self.rows[-2:], axis=1)
        self.highest = np.maximum.accumulate(self.rows[-2:], axis=1)

    def _places(self, slip: Slip, side: int) -> list[tuple[float, int, float, float]]:
        """Return tau, the number of the step, q and u where steps of a slip begin, and where x' = 0 in them."""
        found = []
        ends = [*(step.w for step in slip.steps[1:]), slip.w]
        for number, (step, end) in enumerate(zip(slip.steps, ends, strict=True), len(self.steps)):
            found.append((step.tau, number, step.q, 1.0 - side * step.w))
            if side > 0 and (step.w - 1.0) * (end - 1.0) < 0.0:

                def velocity(tau: float, step: Step = step) -> float:
                    _, w = self._state(step, tau)
                    return 1.0 - w

                tau = float(brentq(velocity, step.tau, step.tau + step.length, xtol=1e-14))
                found.append((tau, number, self._state(step, tau)[0], 0.0))
        self.steps += slip.steps
        return found

    def _state(self, step: Step, tau: float) -> tuple[float, float]:
        q, w = self.system.states([step], np.zeros(1, dtype=np.intp), np.array([tau]), 1, self.rtol)
        return float(q[0]), float(w[0])

    def at(self, tau: FloatArray) -> dict[str, FloatArray]:
        """Return the columns of `_Found` at times from 0 on."""
        begin, origin, number, side, phase, changes, sticks, _, _ = self.rows
        over, tau = tau >= self.end, np.minimum(tau, self.end)
        row = np.searchsorted(begin, tau, side="right") - 1
        since = tau - origin[row]
        q, u = since, np.ones(tau.shape)  # those of stick
        for one in (1, -1):
            some = side[row] == one
            if some.any():
                which = number[row[some]].astype(np.intp)
                q[some], w = self.system.states(self.steps, which, since[some], one, self.rtol)
                u[some] = 1.0 - one * w
        q[over], u[over] = self.state
        outcomes = _OUTCOMES.index(self.outcome), _OUTCOMES.index(Outcome.FINISHED)
        return {
            "tau": tau, "q": q, "u": u, "phase": phase[row], "changes": changes[row], "sticks": sticks[row],
            "q_min": np.minimum(self.lowest[0, row], q), "q_max": np.maximum(self.highest[0, row], q),
            "u_min": np.minimum(self.lowest[1, row], u), "u_max": np.maximum(self.highest[1, row], u),
            "outcome": np.where(over, *outcomes),
        }  # fmt: skip


def _outcome(system: Dimensionless, end: int, w: float) -> int:
    """Return the number of the outcome of a motion that ended before P."""
    if end in (_HORIZON, _ONSET):
        return _OUTCOMES.index(Outcome.FINISHED)
    slip = Slip(End(end), 0.0, 0.0, w, 0.0, 0.0, 0, [])
    return _OUTCOMES.index(outcome_of(system, slip, 0.0, out_of_steps=time_left() > 0)[0])


def _members(members: Sequence[Enum], numbers: IntArray) -> ObjectArray:
    return np.array([*members, None], dtype=object)[numbers]

"""`simulate`: the motion from one initial condition, or from many.

A motion has three kinds of phases: stick, slip slower than the belt, and slip faster than the belt. Slip is
integrated (`motion.slip`); stick is not, as it is known: x' = V exactly, until static friction gives way. Every
stick ends at the same point P, so a motion that sticks is integrated for one round, whatever its length, and many
motions are followed up to P only: what comes after is read from the motion from P.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Literal, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_array, read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.kernel.slip_data import SlipEnd
from stickslip_sym.motion.simulation.reference import simulate_by_solve_ivp
from stickslip_sym.motion.simulation.trajectory import Outcome, Phase, Stretch, Trajectories, Trajectory
from stickslip_sym.motion.slip import NondimensionalOscillator, Slip

_PERIODS_FOLLOWED = 10  # of free vibration, that a motion is followed for

SimulationName: TypeAlias = Literal["events", "solve_ivp"]
"""How a motion is followed."""


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float | None = ..., x0: float = ..., v0: float | None = ...,
    rtol: float = ..., method: SimulationName = ...,
    max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory: ...  # fmt: skip


@overload
def simulate(
    law: FrictionLaw | str, osc: Oscillator, *, t_end: float | None = ...,
    x0: ArrayLike = ..., v0: ArrayLike | None = ...,
    rtol: float = ..., method: SimulationName = ...,
    max_steps: int = ..., time_limit: float | None = ..., workers: int = ...,
) -> Trajectory | Trajectories: ...  # fmt: skip


def simulate(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    t_end: float | None = None,
    x0: ArrayLike = 0.0,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    method: SimulationName = "events",
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
    t_end : float, optional
        Duration in s, positive; ten natural periods, 20 pi sqrt(m/k), if not given.
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
        Integration steps after which a motion ends as it is; a cycle of stick and slip takes about 30, and one
        when it is repeated.
    time_limit : float, optional
        Seconds of computation after which it ends as it is. The law's table, made once for a law, does not count:
        its work is bounded, some seconds where a law is very narrow.
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
    OutOfTime
        When the time limit is reached within `solve_ivp`.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=1.0, V=0.5, N=9.81)
    >>> motion = ss.simulate(law, osc, t_end=5.0)
    >>> motion.motion.value, len(motion.starts_of(ss.Phase.STICK))
    ('stick-slip', 8)
    """
    law = as_law(law)
    osc = as_oscillator(osc)
    t_end = _PERIODS_FOLLOWED * 2 * math.pi / osc.omega if t_end is None else real("t_end", t_end)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    rtol = read_rtol(rtol)
    max_steps = int(real("max_steps", max_steps))
    if max_steps < 1:
        raise InputError(f"max_steps = {max_steps} must be at least 1")
    if method not in ("events", "solve_ivp"):
        raise InputError(f"there is no method {str(method)[:40]!r}; choose 'events' or 'solve_ivp'")
    if method == "events":
        _ = law.bound.table  # what every motion of the law rests on; the limit is on following this one
    speeds = osc.V if v0 is None else v0
    many = np.ndim(x0) > 0 or np.ndim(speeds) > 0
    with deadline.time_limit(time_limit):
        if many and method == "events":
            return _many(law, osc, *read_initial_conditions(x0, speeds), t_end, rtol, max_steps, workers)
        if many:
            raise InputError("method 'solve_ivp' takes one initial condition; simulate them one by one")
        x = real("x0", x0)  # type: ignore[arg-type]
        v = real("v0", speeds)  # type: ignore[arg-type]
        if method == "solve_ivp":
            return simulate_by_solve_ivp(law, osc, x, v, t_end, rtol)
        return _one(law, osc, x, v, t_end, rtol, max_steps)


def _one(
    law: FrictionLaw, osc: Oscillator, x0: float, v0: float, t_end: float, rtol: float, max_steps: int
) -> Trajectory:
    """Return the motion from one initial condition; its samples hold the extremes of x and of v."""
    system = NondimensionalOscillator.of(law.bound, osc)
    x_P = osc.onset(law)
    horizon = t_end * osc.omega
    stretches = list[Stretch]()
    known = dict[float, Slip[float]]()
    outcome = Outcome.FINISHED
    note = ""
    tau = 0.0
    steps = 0
    q = (x0 - x_P) / osc.length
    u = v0 / osc.V
    while tau < horizon:
        w, side = map(float, system.slip_speed(q, u))
        if w == 0 and q < 0 and system.sticks(q):
            since = np.array([0.0, min(horizon - tau, -q)])
            samples = np.array([(tau + since) / osc.omega, x_P + osc.length * (q + since), np.full(2, osc.V)])
            stretches.append(Stretch(Phase.STICK, samples))
            tau = min(horizon, tau - q)
            q = float(q + since[1])
            continue
        # Nothing depends on time itself: a slip from where one began before is that one again, in one step.
        slip = known.get(q) if w == 0 else None
        taken = 1
        if slip is None or deadline.is_late() or tau + slip.tau > horizon or steps >= max_steps:
            slip = system.slip(
                q, w, side, level=1.0, horizon=horizon - tau, rtol=rtol, most=max_steps - steps, recorded=True
            )
            refusal = system.refusal(slip, rtol)
            if isinstance(refusal, InputError) and not slip.taken:
                raise refusal
            taken = int(slip.taken)
            if w == 0 and slip.end is SlipEnd.RETURN:
                known[q] = slip
        since, places, speeds = np.array([*(step[:3] for step in slip.steps), (slip.tau, slip.q, slip.w)]).T
        samples = np.array([
            (tau + since) / osc.omega, x_P + osc.length * places, osc.V * (1 - side * speeds)
        ])  # fmt: skip
        phase = Phase.SLIP_BACK if side > 0 else Phase.SLIP_FORWARD
        if slip.steps:
            course = partial(_course, system, osc, x_P, rtol, slip, tau, side)
        else:
            course = None
        stretches.append(Stretch(phase, samples, course))
        tau += slip.tau
        q = slip.q
        w = slip.w
        u = 1.0
        steps += taken
        if slip.end is not SlipEnd.RETURN:
            outcome, note = _outcome_of(system, slip, rtol)
            break
    if outcome is Outcome.AT_REST:
        end = stretches[-1].end
        x_rest = _position_at_rest(system, osc, x_P, w, stretches[-1].samples[1, -1])
        stretches.append(Stretch(stretches[-1].phase, np.array([[end, t_end], [x_rest, x_rest], [0.0, 0.0]])))
    return Trajectory(osc, rtol, tuple(stretches), outcome, note)


def _course(
    system: NondimensionalOscillator, osc: Oscillator, x_P: float, rtol: float, slip: Slip[float], begin: float,
    side: float, t: FloatArray,
) -> FloatArray:  # fmt: skip
    """Return the rows x and v at times within a slip that began at tau = begin."""
    tau = np.clip(t * osc.omega - begin, 0.0, slip.tau)
    which = np.searchsorted([step.tau for step in slip.steps[1:]], tau, side="right")
    q, w = system.states(slip.steps, which, tau, side, rtol)
    return np.array([x_P + osc.length * q, osc.V * (1 - side * w)])


def _position_at_rest(system: NondimensionalOscillator, osc: Oscillator, x_P: float, w: float, x: float) -> float:
    """Return where a mass is at rest that came to x: where rest is isolated it is known better than integrated.

    A jump of mu holds the mass wherever it is.
    """
    if w == 1 and 1.0 in system.rise.levels:
        return x
    return x_P + osc.length * system.turn(1.0)


_OUTCOMES = {SlipEnd.REST: Outcome.AT_REST, SlipEnd.STEPS: Outcome.STEP_LIMIT, SlipEnd.LATE: Outcome.TIME_LIMIT}


def _outcome_of(system: NondimensionalOscillator, slip: Slip[float], rtol: float) -> tuple[Outcome, str]:
    """Return what the end of a slip says of the whole motion, and why it does not go on."""
    if slip.end in _OUTCOMES:
        return _OUTCOMES[slip.end], ""
    if system.unbounded(slip):
        return Outcome.UNBOUNDED, "damping and friction feed the motion: try a shorter t_end, or a larger c"
    refusal = system.refusal(slip, rtol)
    if refusal is None:
        return (Outcome.FINISHED, "")
    return (Outcome.UNDEFINED, str(refusal))


class _Ends:
    """The ends of many motions, an element for each: first of their slips, then of what comes after.

    - `tau, q, w, side`: time, place and slip speed where each was followed to, without units.
    - `lowest, highest`: the extremes of place and velocity, a row for each; without units until `convert_to_SI`.
    """

    def __init__(self, law: FrictionLaw, osc: Oscillator, x0: FloatArray, v0: FloatArray, t_end: float) -> None:
        self.law = law
        self.osc = osc
        self.t_end = t_end
        self.system = NondimensionalOscillator.of(law.bound, osc)
        self.x_P = osc.onset(law)
        self.horizon = t_end * osc.omega
        self.q = (x0.ravel() - self.x_P) / osc.length
        u = v0.ravel() / osc.V
        self.w, self.side = self.system.slip_speed(self.q, u)
        self.lowest, self.highest = np.array([self.q, u]), np.array([self.q, u])
        count = self.q.size
        self.tau = np.zeros(count)
        self.first_stick = np.full(count, np.nan)
        self.outcome = np.full(count, Outcome.FINISHED, dtype=object)
        self.phase = np.full(count, None, dtype=object)
        self.phases = np.zeros(count, dtype=np.intp)
        self.sticks = np.zeros(count, dtype=np.intp)

    def slip(self, rtol: float, max_steps: int, workers: int) -> None:
        """Follow what does not stick at once, up to the belt's speed or the horizon."""
        rows = np.flatnonzero((self.w > 0) | ~self.system.sticks(self.q))
        slips = self.system.slips(
            self.q[rows], self.w[rows], self.side[rows], passes=max_steps, level=1.0, horizon=self.horizon,
            rtol=rtol, most=max_steps, workers=workers,
        )  # fmt: skip
        self.tau[rows], self.q[rows], self.w[rows], self.side[rows] = slips.tau, slips.q, slips.w, slips.side
        self.phase[rows] = np.array([Phase.SLIP_FORWARD, Phase.SLIP_BACK])[(slips.side > 0).astype(int)]
        self.phases[rows] = 1 + slips.passed
        self.lowest[:, rows] = slips.q_least, 1 - slips.u_most
        self.highest[:, rows] = slips.q_most, 1 - slips.u_least
        for end, outcome in _OUTCOMES.items():
            self.outcome[rows[slips.end == end]] = outcome
        for i in np.flatnonzero(np.isin(slips.end, (SlipEnd.OUTSIDE, SlipEnd.FAILED))).tolist():
            self.outcome[rows[i]], _ = _outcome_of(self.system, slips.one(i), rtol)

    def stick(self) -> None:
        """Carry what static friction holds to P, or as far as there is time."""
        is_held = (self.w == 0) & (self.q < 0) & self.system.sticks(self.q)
        rows = np.flatnonzero(is_held & (self.tau < self.horizon))
        self.phase[rows], self.first_stick[rows] = Phase.STICK, self.tau[rows]
        self.phases[rows] += 1
        self.sticks[rows] += 1
        since = np.minimum(self.horizon - self.tau[rows], -self.q[rows])
        self.tau[rows] = np.minimum(self.horizon, self.tau[rows] - self.q[rows])
        self.q[rows] += since
        self.highest[0] = np.maximum(self.highest[0], self.q)

    def convert_to_SI(self) -> IntArray:
        """Take SI units from here on, as `t`, `x` and `v`, and return which motions go on from P."""
        osc = self.osc
        is_over = self.tau >= self.horizon
        at_P = np.flatnonzero((self.w == 0) & (self.q == 0) & ~is_over)
        self.t = np.where(is_over, self.t_end, self.tau / osc.omega)
        self.first_stick = self.first_stick / osc.omega
        self.x = self.x_P + osc.length * self.q
        self.v = osc.V * (1 - self.side * self.w)
        for extremes in (self.lowest, self.highest):
            extremes[:] = self.x_P + osc.length * extremes[0], osc.V * extremes[1]
        for i in np.flatnonzero(self.outcome == Outcome.AT_REST).tolist():
            x = _position_at_rest(self.system, osc, self.x_P, self.w[i], self.x[i])
            self.t[i], self.x[i], self.v[i] = self.t_end, x, 0.0
        return at_P

    def continue_from_P(self, rows: IntArray, rtol: float, max_steps: int) -> None:
        """Read what becomes of motions that come to P from the one motion that begins there."""
        left = self.t_end - self.t[rows]
        course = _one(self.law, self.osc, self.x_P, self.osc.V, float(left.max()), rtol, max_steps)
        if course.outcome is Outcome.AT_REST:
            last = course.stretches[-1].start
        else:
            last = course.t[-1]
        self.outcome[rows[left >= last]] = course.outcome

        since = np.minimum(left, course.t[-1])
        event = np.maximum(np.searchsorted([one.t for one in course.events], since) - 1, 0)
        sticks = np.array([event.begins is Phase.STICK for event in course.events])
        sticks_so_far = sticks.cumsum()[event]
        stuck = np.where(sticks_so_far > 0, self.t[rows] + course.events[sticks.argmax()].t, np.nan)
        self.first_stick[rows] = np.fmin(self.first_stick[rows], stuck)
        self.phases[rows] += event + 1
        self.sticks[rows] += sticks_so_far

        self.t[rows] += since
        self.x[rows], self.v[rows], self.phase[rows] = course.at(since)
        sample = np.searchsorted(course.t, since, side="right") - 1
        ends = np.array([self.x[rows], self.v[rows]])
        samples = np.array([course.x, course.v])
        for extremes, reach in ((self.lowest, np.minimum), (self.highest, np.maximum)):
            extremes[:, rows] = reach.reduce(
                [extremes[:, rows], reach.accumulate(samples, axis=1)[:, sample], ends]
            )


def _many(
    law: FrictionLaw, osc: Oscillator, x0: FloatArray, v0: FloatArray, t_end: float, rtol: float, max_steps: int,
    workers: int,
) -> Trajectories:  # fmt: skip
    """Return the ends of the motions from many initial conditions."""
    ends = _Ends(law, osc, x0, v0, t_end)
    ends.slip(rtol, max_steps, workers)
    ends.stick()
    at_P = ends.convert_to_SI()
    if at_P.size:
        ends.continue_from_P(at_P, rtol, max_steps)
    (x_min, v_min) = ends.lowest
    (x_max, v_max) = ends.highest
    columns: Any = (
        ends.t, ends.x, ends.v, ends.phase, ends.outcome, x_min, x_max, v_min, v_max, ends.phases - 1, ends.sticks,
        ends.first_stick,
    )  # fmt: skip
    return Trajectories(law, osc, t_end, rtol, x0, v0, *(column.reshape(x0.shape) for column in columns))


def read_initial_conditions(x0: ArrayLike, v0: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return initial displacements and velocities as arrays of one shape."""
    places = read_array("x0", x0)
    speeds = read_array("v0", v0)
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

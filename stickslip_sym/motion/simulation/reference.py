"""The reference: the motion by ``scipy.integrate.solve_ivp`` with events, in SI units.

It shares nothing with the package's own integrator but the law's mu(v), and is short enough to be checked by eye.
"""

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import check_time, time_left
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import SAME
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED, LONGEST_STEP
from stickslip_sym.motion.simulation.trajectory import Outcome, Phase, Stretch, Trajectory
from stickslip_sym.motion.slip import SAME_AMPLITUDE


def absolute_tolerance(osc: Oscillator, rtol: float) -> FloatArray:
    """Return the absolute tolerances of x and v that go with a relative one, which many steps may add up to."""
    return rtol / ADDED * np.array([osc.V / osc.omega, osc.V])


def slip_by_solve_ivp(
    law: BoundLaw, osc: Oscillator, t: float, x: float, v: float, side: int, t_end: float, rtol: float,
    **options: Any,
) -> Any:  # fmt: skip
    """Follow slip on one side of the belt's speed, 1 below and -1 above, until it comes back to it.

    `options` are those of ``solve_ivp``, in place of a tight choice. Returns SciPy's result, with `sol` for times
    between; `t_events[0]` holds the return, if there is one.
    """
    mu = law.function("math")
    mu_0 = law.onset

    def rates(_: float, y: FloatArray) -> tuple[float, float]:
        if time_left() < 0:
            check_time()
        speed = side * (osc.V - y[1])
        friction = side * osc.N * (mu(speed) if speed > 0 else mu_0)
        return y[1], (friction - osc.c * y[1] - osc.k * y[0]) / osc.m

    def at_belt_speed(_: float, y: FloatArray) -> float:
        return float(y[1] - osc.V)

    at_belt_speed.terminal = True  # type: ignore[attr-defined]  # SciPy's way
    at_belt_speed.direction = side  # type: ignore[attr-defined]
    # An event at the start itself ends a run; later ones are seen where a step has different signs at its ends.
    v = side * min(side * v, (side - SAME_AMPLITUDE) * osc.V)
    tight: dict[str, Any] = {"method": "DOP853", "max_step": LONGEST_STEP / osc.omega}
    solution = solve_ivp(
        rates, (t, t_end), (x, v), rtol=max(rtol, 1e-13), dense_output=True, events=at_belt_speed,
        atol=absolute_tolerance(osc, rtol), **tight | options,
    )  # fmt: skip
    if solution.status < 0:
        raise NotConverged(f"solve_ivp cannot go on beyond t = {solution.t[-1]:.6g} s: {solution.message}")
    return solution


def simulate_by_solve_ivp(
    law: FrictionLaw, osc: Oscillator, x0: float, v0: float, t_end: float, rtol: float, **options: Any
) -> Trajectory:
    """Return the motion as `simulate` does: slip by `solve_ivp` with its `options`, stick in closed form."""
    bound = law.bound
    hold = bound.static * osc.N
    V = osc.V
    x_P = (hold - osc.c * V) / osc.k
    t = 0.0
    x = x0
    v = v0
    stretches = list[Stretch]()
    while t < t_end:
        pull = osc.c * V + osc.k * x
        if v == V and abs(pull) < hold * (1 - SAME):
            end = min(t_end, t + (x_P - x) / V)
            stretches.append(Stretch(Phase.STICK, np.array([[t, end], [x, x + V * (end - t)], [v, v]])))
        else:
            if v == V:
                side = math.copysign(1, pull)
            else:
                side = math.copysign(1, V - v)
            phase = Phase.SLIP_BACK if side > 0 else Phase.SLIP_FORWARD
            solution = slip_by_solve_ivp(bound, osc, t, x, v, int(side), t_end, rtol, **options)
            samples = np.array([solution.t, *solution.y])
            if solution.t_events[0].size:
                samples[2, -1] = V
            stretches.append(Stretch(phase, samples, solution.sol))
        t, x, v = stretches[-1].samples[:, -1].tolist()
    return Trajectory(osc, rtol, tuple(stretches), Outcome.FINISHED)

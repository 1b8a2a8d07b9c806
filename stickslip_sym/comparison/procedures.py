"""What one computes without this package: the paper's Newmark scan, and runs of ``scipy.integrate.solve_ivp``.

Section 3 of the paper: step 1e-4 s, |v_r| <= 1e-4 m/s counts as v_r = 0; section 5: the damping is scanned from 0
to 6 kg/s in steps of 0.001 kg/s. The paper leaves open how the friction force enters a step; here it is iterated
to the velocity at the end of the step. All dampings run side by side, one element of an array each.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NoThreshold
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.simulation.reference import simulate_by_solve_ivp, slip_by_solve_ivp

_ITERATIONS = 3  # of the friction force in a Newmark step; it changes by 1e-4 relative in one
_ROUND = 1.5 * 2 * math.pi  # time in 1/omega within which a slip comes back to the belt's speed, if it does
_WIDEST = 1e3  # times sqrt(k m): no damping beyond is tried
_PERIODS = 80 * 2 * math.pi  # time of a run in 1/omega
_LAST = 0.2  # of it, at its end, that decides about rest
_QUIET = 0.1  # largest speed at rest, over the belt's
_WIDTH = 0.01  # of the smoothed sign of the slip speed, over the belt's
_LEAST = 1e-2  # absolute tolerance in units of V and V/omega, over the relative one
_DEFAULTS = {"method": "RK45", "max_step": math.inf}
"""What ``solve_ivp`` takes where nothing is said, unlike the package's reference."""


@dataclass(frozen=True)
class Scan:
    """The numbers of the paper's procedure."""

    dampings: FloatArray  # ascending, in kg/s
    step: float = 1e-4  # time step in s
    band: float = 1e-4  # relative speed in m/s that counts as none


def pure_slip_by_scan(law: FrictionLaw, osc: Oscillator, scan: Scan) -> float:
    """Return the lowest damping at which the mass, once it slipped, does not come back to v_r = 0."""
    m, k, V, hold = osc.m, osc.k, osc.V, law.mu(0.0) * osc.N
    c, h = scan.dampings, scan.step
    x, v, a = np.zeros_like(c), np.full_like(c, V), np.zeros_like(c)
    away = returned = np.zeros(c.shape, dtype=bool)
    effective = m + c * h / 2 + k * h * h / 4  # average acceleration: gamma = 1/2, beta = 1/4
    for _ in range(int((hold / (k * V) + _ROUND / osc.omega) / h)):
        check_time()
        stick = (np.abs(v - V) <= scan.band) & (np.abs(c * v + k * x) <= hold)
        # One return decides, as orbits in a plane do not cross; a fast one may step over the band.
        returned = returned | (away & (v - V >= -scan.band))
        away = away | (v - V < -scan.band)
        v_free, x_free = v + h / 2 * a, x + h * v + h * h / 4 * a
        v_new = v
        for _ in range(_ITERATIONS):
            relative = v_new - V
            # At v_r = 0 a mass that static friction cannot hold is dragged on by the belt.
            force = np.where(relative > 0, -1.0, 1.0) * law.mu(np.abs(relative)) * osc.N
            a_new = (force - c * v_free - k * x_free) / effective
            v_new = v_free + h / 2 * a_new
        x = np.where(stick, x + h * V, x_free + h * h / 4 * a_new)
        v = np.where(stick, V, v_new)
        a = np.where(stick, 0.0, a_new)
    first_free = int(np.argmin(returned))
    if returned[first_free:].any():
        raise NoThreshold("no damping of the scan separates stick-slip from slip; scan another range")
    return float(scan.dampings[first_free])


def pure_slip_by_bisection(law: FrictionLaw, osc: Oscillator, rtol: float) -> float:
    """Return the damping above which the slip from P does not come back, to `rtol`, that of the runs."""

    def comes_back(c: float) -> bool:
        check_time()
        x = (float(law.mu(0.0)) * osc.N - c * osc.V) / osc.k
        t_end = _ROUND / osc.omega
        run = slip_by_solve_ivp(law, replace(osc, c=c), 0.0, x, osc.V, 1, t_end, rtol, **_DEFAULTS)
        return bool(run.t_events[0].size)

    low, high = 0.0, 2 * osc.impedance
    if not comes_back(low):
        raise NoThreshold("the slip does not come back even without damping")
    while comes_back(high):
        low, high = high, 2 * high
        if high > _WIDEST * osc.impedance:
            raise NoThreshold("the slip comes back at every damping")
    while high - low > rtol * high:
        middle = (low + high) / 2
        low, high = (middle, high) if comes_back(middle) else (low, middle)
    return (low + high) / 2


def comes_to_rest(law: FrictionLaw, osc: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a motion comes to rest, by slip up to the belt's speed and stick in closed form."""
    run = simulate_by_solve_ivp(law, osc, x0, v0, _PERIODS / osc.omega, rtol, **_DEFAULTS)
    return _is_quiet(run.t, run.v, osc)


def comes_to_rest_smoothed(law: FrictionLaw, osc: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a motion comes to rest where the sign of the slip speed is smoothed; stick is slow slip."""
    from scipy.integrate import solve_ivp

    check_time()
    mu, at_rest = law.function("math"), float(law.mu(0.0))

    def rates(_: float, y: FloatArray) -> tuple[float, float]:
        speed = osc.V - y[1]
        friction = math.tanh(speed / (_WIDTH * osc.V)) * osc.N * (mu(abs(speed)) if speed else at_rest)
        return y[1], (friction - osc.c * y[1] - osc.k * y[0]) / osc.m

    atol = _LEAST * rtol * np.array([osc.V / osc.omega, osc.V])
    run = solve_ivp(rates, (0.0, _PERIODS / osc.omega), (x0, v0), method="LSODA", rtol=rtol, atol=atol)
    return _is_quiet(run.t, run.y[1], osc)


def _is_quiet(t: FloatArray, v: FloatArray, osc: Oscillator) -> bool:
    return bool(np.abs(v[t > (1 - _LAST) * t[-1]]).max() <= _QUIET * osc.V)

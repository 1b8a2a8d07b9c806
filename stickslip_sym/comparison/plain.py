"""What one writes with SciPy alone: runs of ``scipy.integrate.solve_ivp`` with an event at the belt's speed."""

import math
from dataclasses import replace

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NoThreshold
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator

__all__ = ["comes_to_rest", "comes_to_rest_smoothed", "pure_slip_by_bisection"]

_ROUND = 1.5 * 2 * math.pi  # time in 1/omega within which a slip comes back to the belt's speed, if it does
_WIDEST = 1e3  # times sqrt(k m): no damping beyond is tried
_PERIODS = 80  # natural periods of a run, the last fifth of which tells whether the mass is at rest
_LAST = 0.2
_QUIET = 0.1  # largest speed at rest, over the belt's
_WIDTH = 0.01  # of the smoothed sign of the slip speed, over the belt's
_ROUNDING = 1e-12  # of the force at which static friction gives way
_BESIDE = 1e-9  # of the belt's speed, by which slip begins off it
_LEAST = 1e-2  # absolute tolerance in units of V and V/omega, over the relative one


def pure_slip_by_bisection(law: FrictionLaw, scene: Oscillator, rtol: float) -> float:
    """Return the damping above which the slip from P does not come back to the belt's speed.

    Halved is a range of dampings, until it is as narrow as `rtol`, the tolerance of the runs.

    Raises `NoThreshold` if slip comes back at no damping, or at every one.
    """
    low, high = 0.0, 2 * scene.impedance
    if not _comes_back(law, scene, low, rtol):
        raise NoThreshold("the slip does not come back even without damping")
    while _comes_back(law, scene, high, rtol):
        low, high = high, 2 * high
        if high > _WIDEST * scene.impedance:
            raise NoThreshold("the slip comes back at every damping")
    while high - low > rtol * high:
        middle = (low + high) / 2
        if _comes_back(law, scene, middle, rtol):
            low = middle
        else:
            high = middle
    return (low + high) / 2


def _comes_back(law: FrictionLaw, scene: Oscillator, c: float, rtol: float) -> bool:
    check_time()
    x = (float(law.mu(0.0)) * scene.N - c * scene.V) / scene.k
    _, _, comes_back = _slip(law, replace(scene, c=c), (0.0, _ROUND / scene.omega), (x, scene.V), 1, rtol)
    return comes_back


def _slip(
    law: FrictionLaw,
    scene: Oscillator,
    span: tuple[float, float],
    start: tuple[float, float],
    side: int,
    rtol: float,
) -> tuple[FloatArray, FloatArray, bool]:
    """Follow slip on one side of the belt's speed, 1 below and -1 above, until it comes back to it.

    Return times, displacements and velocities, and whether it came back.
    """
    from scipy.integrate import solve_ivp

    mu, at_rest = law.function("math"), float(law.mu(0.0))

    def rates(_: float, y: FloatArray) -> tuple[float, float]:
        speed = side * (scene.V - y[1])
        friction = side * scene.N * (mu(speed) if speed > 0 else at_rest)
        return y[1], (friction - scene.c * y[1] - scene.k * y[0]) / scene.m

    def at_belt_speed(_: float, y: FloatArray) -> float:
        return float(y[1] - scene.V)

    at_belt_speed.terminal, at_belt_speed.direction = True, side  # type: ignore[attr-defined]  # SciPy's way
    x, v = start
    beside = (
        min(side * v, side * scene.V * (1 - side * _BESIDE)) * side
    )  # an event at the start itself ends the run
    found = solve_ivp(rates, span, (x, beside), rtol=rtol, atol=_absolute(scene, rtol), events=at_belt_speed)
    return found.t, found.y, bool(found.t_events[0].size)


def _absolute(scene: Oscillator, rtol: float) -> FloatArray:
    return _LEAST * rtol * np.array([scene.V / scene.omega, scene.V])


def comes_to_rest(law: FrictionLaw, scene: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a start comes to rest, by slip up to the belt's speed and stick in closed form."""
    end = _PERIODS * 2 * math.pi / scene.omega
    late = (1 - _LAST) * end
    hold = float(law.mu(0.0)) * scene.N
    x_slip = (hold - scene.c * scene.V) / scene.k
    t, x, v = 0.0, x0, v0
    while t < end:
        check_time()
        pull = scene.c * scene.V + scene.k * x
        if v == scene.V and abs(pull) < hold * (1 - _ROUNDING):
            t, x = t + (x_slip - x) / scene.V, x_slip
            if t > late:
                return False
            continue
        side = (1 if pull > 0 else -1) if v == scene.V else (1 if v < scene.V else -1)
        times, (places, speeds), _ = _slip(law, scene, (t, end), (x, v), side, rtol)
        if np.abs(speeds[times > late]).max(initial=0.0) > _QUIET * scene.V:
            return False
        t, x, v = float(times[-1]), float(places[-1]), scene.V
    return True


def comes_to_rest_smoothed(law: FrictionLaw, scene: Oscillator, x0: float, v0: float, rtol: float) -> bool:
    """Return whether a start comes to rest where the sign of the slip speed is smoothed; stick is slow slip."""
    from scipy.integrate import solve_ivp

    check_time()
    mu, at_rest = law.function("math"), float(law.mu(0.0))

    def rates(_: float, y: FloatArray) -> tuple[float, float]:
        speed = scene.V - y[1]
        friction = math.tanh(speed / (_WIDTH * scene.V)) * scene.N * (mu(abs(speed)) if speed else at_rest)
        return y[1], (friction - scene.c * y[1] - scene.k * y[0]) / scene.m

    end = _PERIODS * 2 * math.pi / scene.omega
    found = solve_ivp(rates, (0.0, end), (x0, v0), method="LSODA", rtol=rtol, atol=_absolute(scene, rtol))
    return bool(np.abs(found.y[1][found.t > (1 - _LAST) * end]).max() <= _QUIET * scene.V)

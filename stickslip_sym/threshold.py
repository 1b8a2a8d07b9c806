"""`pure_slip_damping`: the damping that separates stick-slip from slip, by formula or by simulation."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import toms748

from stickslip_sym.closed_form import derive
from stickslip_sym.errors import InputError, NotConverged, NoThreshold
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.oscillator import Oscillator, Scene
from stickslip_sym.slip import check_rtol
from stickslip_sym.transit import lowest_slip_speed
from stickslip_sym.values import lookup

__all__ = ["METHODS", "Threshold", "pure_slip_damping"]

METHODS = ("equilibrium", "least_squares", "simulation")

_SLOPE_SAMPLES = 257


@dataclass(frozen=True)
class Threshold:
    """A threshold: its value, the method that gave it, and its estimated relative error.

    Attributes
    ----------
    value : float
        In kg/s.
    method : str
    error : float or None
        Estimated error against the exact threshold, relative; None where nothing is known of it.
    """

    value: float
    method: str
    error: float | None

    def __str__(self) -> str:
        accuracy = "unknown" if self.error is None else f"{self.error:.0e}"
        return f"{self.value:.10g} kg/s ({self.method}, relative error {accuracy})"


def pure_slip_damping(
    law: FrictionLaw,
    *,
    V: float,
    N: float,
    m: float | None = None,
    k: float | None = None,
    method: str,
    rtol: float = 1e-10,
) -> Threshold:
    """Return the pure-slip damping coefficient of a law in a scene.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    V, N : float
        Belt speed in m/s and normal force in N.
    m, k : float, optional
        Mass in kg and stiffness in N/m; only "simulation" needs them.
    method : {"equilibrium", "least_squares", "simulation"}
        A criterion in closed form, or the root in c of the lowest slip speed that the orbit from P
        comes down to: the orbit that grazes the belt's speed.
    rtol : float
        Relative tolerance of "simulation".

    Raises
    ------
    InputError
        For an unknown method, or numbers that are missing or unusable.
    NoThreshold
        If the orbit from P never returns, for any c >= 0.
    """
    lookup("method", method, dict.fromkeys(METHODS))
    if method != "simulation":
        return Threshold(derive(law, method)(V=V, N=N), method, None)
    if m is None or k is None:
        raise InputError('method="simulation" needs the mass m and the stiffness k')
    check_rtol(rtol)
    return _by_simulation(law, Oscillator(m=m, k=k, V=V, N=N), rtol)


def _by_simulation(law: FrictionLaw, osc: Oscillator, rtol: float) -> Threshold:
    """Find the c at which the orbit from P comes down to w = 0 and no further."""
    scene = Scene.of(law, osc)

    def lowest(c: float, tolerance: float = rtol) -> float:
        damped = replace(scene, zeta=c / (2 * osc.impedance))
        found = lowest_slip_speed(damped, max(tolerance / 10, 1e-13))
        return 1.0 if found is None else found  # an overdamped mass creeps to rest and does not return

    if lowest(0.0) >= 0:
        raise NoThreshold(
            "the slip that leaves P does not return to the belt's speed even without damping, "
            f"so no c >= 0 is a threshold at V = {osc.V:g}, N = {osc.N:g}"
        )
    high = _steep(law, osc)
    for _ in range(60):
        if lowest(high) > 0:
            break
        high *= 2
    else:
        raise NotConverged("no damping was found at which the orbit from P does not return")
    value = float(toms748(lowest, 0.0, high, xtol=1e-300, rtol=max(rtol / 10, 1e-15)))
    # How far the root moves when the integration is ten times looser bounds how far it is off.
    slack = max(abs(value) * 1e-4, 1e-12 * high)
    slope = (lowest(value + slack) - lowest(value - slack)) / (2 * slack)
    shift = abs(lowest(value, 10 * rtol) - lowest(value)) / abs(slope)
    return Threshold(value, "simulation", float(max(shift / value, rtol / 10)))


def _steep(law: FrictionLaw, osc: Oscillator) -> float:
    """Return a damping of the size that the falls of mu over [0, 2V] can feed, the static jump included."""
    v = np.linspace(0.0, 2 * osc.V, _SLOPE_SAMPLES)
    mu = law.mu(v)
    drop = max(float(law.substitute(law.static_expr)), mu.max()) - mu.min()
    return float(osc.N * max(np.max(-law.slope(v)), drop / osc.V))

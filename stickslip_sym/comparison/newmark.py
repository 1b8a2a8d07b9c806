"""The paper's own procedure: Newmark steps of fixed length, with a band of relative speed for stick.

Section 3 of the paper: step 1e-4 s, |v_r| <= 1e-4 m/s counts as v_r = 0; section 5: the damping is
scanned from 0 to 6 kg/s in steps of 0.001 kg/s. The paper leaves open how the friction force enters a
step; here it is iterated to the velocity at the end of the step. All dampings run side by side, one
element of an array each.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NoThreshold
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator

__all__ = ["Scan", "pure_slip_by_scan"]

_ITERATIONS = 3  # of the friction force in a step; it changes by 1e-4 relative in one


@dataclass(frozen=True)
class Scan:
    """The numbers of the procedure."""

    dampings: FloatArray  # ascending, in kg/s
    step: float = 1e-4  # time step in s
    band: float = 1e-4  # relative speed in m/s that counts as none


def pure_slip_by_scan(law: FrictionLaw, scene: Oscillator, scan: Scan) -> float:
    """Return the lowest damping of the scan at which the mass, once it slipped, does not come back to v_r = 0.

    The motion starts from x = 0 at the belt's speed, sticks up to P, slips, and is followed for one
    natural period and a half from there. One return decides: orbits in a plane do not cross, so a mass
    that misses the belt's speed once misses it ever after.

    Raises `NoThreshold` if no damping of the scan separates the two.
    """
    returns = _returns(lambda relative: law.mu(np.abs(relative)), law.mu(0.0), scene, scan)
    first_free = int(np.argmin(returns))
    if returns[first_free] or returns[first_free:].any():
        raise NoThreshold("no damping of the scan separates stick-slip from slip; scan another range")
    return float(scan.dampings[first_free])


def _returns(mu: Callable[[FloatArray], FloatArray], mu_s: float, scene: Oscillator, scan: Scan) -> BoolArray:
    m, k, V, N = scene.m, scene.k, scene.V, scene.N
    c, h = scan.dampings, scan.step
    x, v, a = np.zeros_like(c), np.full_like(c, V), np.zeros_like(c)
    away = np.zeros(c.shape, dtype=bool)
    returned = np.zeros(c.shape, dtype=bool)
    effective = m + c * h / 2 + k * h * h / 4  # average acceleration: gamma = 1/2, beta = 1/4
    duration = mu_s * N / (k * V) + 1.5 * 2 * np.pi / scene.omega
    for _ in range(int(duration / h)):
        check_time()
        stick = (np.abs(v - V) <= scan.band) & (np.abs(c * v + k * x) <= mu_s * N)
        # A fast return may step over the band, so being above it counts too.
        returned |= away & (v - V >= -scan.band)
        away |= v - V < -scan.band
        v_free, x_free = v + h / 2 * a, x + h * v + h * h / 4 * a
        v_new = v
        for _ in range(_ITERATIONS):
            relative = v_new - V
            # At v_r = 0 a mass that static friction cannot hold is dragged on by the belt.
            force = np.where(relative > 0, -1.0, 1.0) * mu(relative) * N
            a_new = (force - c * v_free - k * x_free) / effective
            v_new = v_free + h / 2 * a_new
        x = np.where(stick, x + h * V, x_free + h * h / 4 * a_new)
        v = np.where(stick, V, v_new)
        a = np.where(stick, 0.0, a_new)
    return returned

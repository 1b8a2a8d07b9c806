"""Over decades of mass and belt speed, and where rest loses stability, what is found is right or named."""

import signal
import sys
import time

import numpy as np
import pytest
from commands import started
from operating_points import paper_oscillator

import stickslip_sym as ss

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


@pytest.mark.parametrize("m", [1e-12, 1e-8, 1e-4])
def test_thresholds_of_light_masses_within_their_errors(m):
    """As m tends to 0 the threshold tends to a limit; the phase is stiff, with rates up to 2e6 a unit of time."""
    law = ss.laws.exponential.typical()
    rough = ss.pure_slip_damping(law, **POINT | {"m": m}, method="simulation", time_limit=60)
    fine = ss.pure_slip_damping(law, **POINT | {"m": m}, method="simulation", rtol=1e-7, time_limit=60)
    assert fine.relative_error < 1e-7
    assert abs(rough.value / fine.value - 1) <= rough.relative_error + fine.relative_error
    if m <= 1e-8:
        limit = -9.81 * law.slope(0.5)  # from which it departs by 50/eta^2
        assert fine.value == pytest.approx(limit, rel=fine.relative_error + 60 * m / (9.81 / 5) ** 2)


@pytest.mark.parametrize("name", ["exponential", "hyperbolic"])
def test_thresholds_of_slow_belts_tend_to_slopes(name):
    law = ss.laws.catalogue[name].typical()
    for V in np.logspace(-12, -7, 3):
        slope = -9.81 * law.slope(V)
        for method in ("equilibrium", "second_order", "orbit", "simulation"):
            found = ss.pure_slip_damping(law, **POINT | {"V": V}, method=method)
            assert abs(found.value - slope) <= found.relative_error * abs(slope) + 1e-5 * abs(slope), (V, method)


def test_cycles_too_small_to_find_are_named():
    """mu' = -a + 3 b (v - V)^2 about rest: a cycle of amplitude A needs N (a - 3/4 b A^2); a kink is in reach."""
    rng = np.random.default_rng(7)
    for amplitude in 10 ** rng.uniform(-5, -3.5, 1):
        for bend in rng.choice([-1, 1]) * np.array([1, -1]) * rng.uniform(0.2, 0.6):
            law = ss.FrictionLaw(f"0.4 - 0.3*(v - 0.5) + ({bend:.6f})*(v - 0.5)^3 + 0.1*Max(0, v - 0.95)")
            found = ss.regime(law, paper_oscillator(9.81 * (0.3 - 0.75 * round(bend, 6) * amplitude**2)))
            assert found.rest.stable == (bend < 0)
            kind = "a stable" if bend > 0 else "an unstable"
            assert f"{kind} limit cycle about rest is too small to find" in found.undecided


@pytest.mark.skipif(sys.platform == "win32", reason="a signal cannot be sent to one process there")
def test_control_c_ends_a_long_map_at_once():
    ss.motion_map(ss.laws.tanh.typical(), x=("V", [0.3]), y=("N", [9.81]), c=1, m=1, k=100)  # is compiled then
    with started("map", "tanh", "--x", "V=0.1:1:300", "--y", "N=1:50:999", "-c", "1", "--workers", "2") as process:
        time.sleep(4)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=20)
    assert process.returncode == 130, err
    assert "Traceback" not in err

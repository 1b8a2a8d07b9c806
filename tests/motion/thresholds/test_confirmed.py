"""A threshold is stated where the slip from P does on both sides of it what the threshold says."""

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.thresholds import grazing
from stickslip_sym.motion.thresholds.grazing import grazing_damping
from support.sweeps import sweep

POINT = {"m": 1.0, "k": 100.0, "V": 0.5, "N": 9.81}


@pytest.mark.parametrize("off", [-1e-3, 1e-3])
def test_a_threshold_that_the_slip_refutes_is_not_stated(monkeypatch, off):
    """As a search would give one that takes a limit on time for an answer."""
    law, osc = ss.laws.exponential.typical().bound, ss.Oscillator(c=0.0, **POINT)
    zeta, error = grazing.orbit_damping_ratio(grazing.NondimensionalOscillator.of(law, osc))
    monkeypatch.setattr(grazing, "orbit_damping_ratio", lambda *_, **__: (zeta + off, error))
    with pytest.raises(ss.NotConverged, match="does not return" if off > 0 else "returns to the belt"):
        grazing_damping(law, osc, rtol=1e-9)


@sweep("seed", range(60), 0, 1, 2)
def test_stick_slip_ends_at_the_threshold(seed):
    """Random laws with narrow features over eight decades of friction: the cycle is there below only."""
    rng = np.random.default_rng(seed)
    a, b, d, place, width = rng.uniform([0.2, 0.5, 0.0, 0.1, -3], [0.5, 8.0, 0.2, 1.5, -0.5]).tolist()
    law = ss.FrictionLaw(f"0.2 + {a}*exp(-{b}*v) + {d}*v - 0.1*exp(-((v - {place})/{10**width})^2)")
    point = {"m": 1.0, "k": 100.0, "V": 0.5, "N": 5.0 * 10 ** float(rng.uniform(-4, 4))}
    try:
        found = ss.pure_slip_damping(law, **point, method="simulation", rtol=1e-6)
    except ss.NoThreshold:
        return
    off = 20 * found.relative_error * abs(found.value) + 1e-9 * abs(found.value)
    cycles = [ss.stick_slip_cycle(law, ss.Oscillator(c=found.value + by, **point)) for by in (-off, off)]
    # Weak friction does not hold the mass that returns.
    returns = ss.peak_velocity(law, ss.Oscillator(c=found.value - off, **point)) > point["V"]
    assert returns or cycles[0] is not None
    assert cycles[1] is None


@pytest.mark.parametrize("V", [60.0, 100.0, 300.0])
def test_weak_friction_does_not_refute_a_threshold(V):
    """The steps of a slip are off beside the spring's force, which is far more than friction's there."""
    law = ss.laws.exponential.typical()
    found = ss.pure_slip_damping(law, **POINT | {"V": V}, method="simulation", rtol=1e-9)
    proved = ss.pure_slip_damping(law, **POINT | {"V": V}, method="proof", rtol=1e-8)
    assert found.value == pytest.approx(proved.value, rel=2e-8)


@pytest.mark.thorough
@pytest.mark.parametrize("N", [1.3e6, 2e6])
def test_rounding_along_a_slip_does_not_refute_a_threshold(N):
    """Where friction is so strong that a slip is off by 1e-8, whatever its steps."""
    osc = ss.Oscillator(c=0.0, **POINT | {"N": N})
    value, error = grazing_damping(ss.laws.exponential.typical().bound, osc, rtol=1e-9)
    assert 0 < error < 1e-9 * value

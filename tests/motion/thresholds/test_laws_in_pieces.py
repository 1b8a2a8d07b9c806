"""Thresholds of kinked and measured laws, against motions followed in time."""

import numpy as np
import pytest
from scenes import laws_in_pieces, paper_oscillator

import stickslip_sym as ss
from stickslip_sym.motion.thresholds import grazing

SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
MOST_ORBITS = 12  # that a threshold takes; a search by brackets takes 20 or more


def test_a_threshold_separates_return_from_none_within_its_error():
    """Or there is none, and even without damping nothing returns."""
    rng = np.random.default_rng(17)
    found = 0
    for law in laws_in_pieces(rng, 24):
        V, N, k = rng.uniform(0.05, 0.9), 10 ** rng.uniform(-0.5, 1.5), 10 ** rng.uniform(1, 3.5)
        rtol = rng.choice([1e-6, 1e-8, 1e-10])
        osc = ss.Oscillator(m=1, k=k, V=V, N=N)
        try:
            value, error = grazing.grazing_damping(law, osc, rtol=rtol)
        except ss.NoThreshold:
            assert ss.peak_velocity(law, osc) <= V * (1 + 1e-12)
            continue
        found += 1
        below, above = (ss.Oscillator(m=1, k=k, V=V, N=N, c=value * (1 + sign * 1.5 * error)) for sign in (-1, 1))
        assert ss.peak_velocity(law, below) > V > ss.peak_velocity(law, above), (law, osc, rtol)
    assert 12 < found < 24


def test_few_orbits_tell_a_threshold(monkeypatch):
    orbits = []
    follow = grazing.lowest_slip_speed
    monkeypatch.setattr(grazing, "lowest_slip_speed", lambda *args: orbits.append(1) or follow(*args))
    v = np.linspace(0, 1.3, 12)
    law = ss.FrictionLaw.from_samples(v, 0.2 + 0.3 * np.exp(-3 * v), extrapolate=True)
    ss.pure_slip_damping(law, **SCENE)
    assert len(orbits) <= MOST_ORBITS


def test_a_canard_is_told_as_well():
    """w jumps within 1e-9 of the damping, and a secant says nothing there."""
    law, osc = ss.laws.exponential.typical(alpha=5.08), paper_oscillator(k=29.367, V=0.41959, N=18.5287)
    exact = grazing.grazing_damping(law, osc, rtol=1e-12)[0]
    for rtol in (1e-6, 1e-8, 1e-9, 1e-10):
        value, error = grazing.grazing_damping(law, osc, rtol=rtol)
        assert abs(value / exact - 1) < error


def test_a_guess_with_the_wrong_sign_is_no_obstacle():
    """The slope of mu is positive, and only the static coefficient makes the mass stick."""
    law = ss.FrictionLaw("0.3 + 0.005*v + 0.01*Max(v - 0.7, 0)", static="0.6")
    value, error = grazing.grazing_damping(law, paper_oscillator(), rtol=1e-8)
    assert 0 < value < 5
    assert error < 1e-6
    assert ss.stick_slip_cycle(law, paper_oscillator(value * (1 - 2 * error))) is not None
    assert ss.stick_slip_cycle(law, paper_oscillator(value * (1 + 2 * error))) is None
    with pytest.raises(ss.NoThreshold):
        grazing.grazing_damping(law.with_static(None), paper_oscillator(), rtol=1e-8)

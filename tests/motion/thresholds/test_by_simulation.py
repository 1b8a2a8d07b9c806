"""The threshold by simulation: what it separates, its error, and laws that are steep."""

import numpy as np
import pytest
from operating_points import laws_in_pieces, paper_oscillator
from sweeps import sweep

import stickslip_sym as ss

EXPONENTIAL, POLYNOMIAL = ss.laws.exponential.typical(), ss.laws.polynomial.typical()
ROOT = ss.FrictionLaw("0.5-0.1*sqrt(v)")
STEEP = {
    "paper, exponential": (EXPONENTIAL, {}, 2.57307887898),
    "paper, polynomial": (POLYNOMIAL, {}, 3.03647724356),
    "alpha 8": (ss.laws.exponential.typical(alpha=8), {}, 2.067284261),
    "N 50": (EXPONENTIAL, {"N": 50.0}, 12.47356032),
    "canard": (EXPONENTIAL, {"V": 0.3, "N": 1e3}, 366.0493724),
    "light": (EXPONENTIAL, {"m": 1e-6}, 1.970041565),
    "soft": (EXPONENTIAL, {"k": 1e-4}, 1.970041565),
    "layer": (ss.FrictionLaw("0.2+0.1*exp(-v/0.01)", static="0.4"), {"V": 0.1}, 3.692056429),
    "polynomial": (POLYNOMIAL, {"N": 1e4}, 3374.977777),
    "root": (ROOT, {}, 0.832662017),
    "root, loaded": (ROOT, {"N": 500.0}, 38.8216104753),
    "root, heavily loaded": (ROOT, {"N": 1e3}, 72.8108848633),
}


def simulated(law, rtol=1e-10, **changes):
    point = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "method": "simulation", "rtol": rtol}
    return ss.pure_slip_damping(law, **(point | changes))


def separates(law, damping, off, **changes):
    """Whether the mass sticks and slips just below a damping, and not just above."""
    below, above = (paper_oscillator(damping * factor, **changes) for factor in (1 - off, 1 + off))
    return ss.stick_slip_cycle(law, below) is not None and ss.stick_slip_cycle(law, above) is None


@pytest.mark.parametrize("name", STEEP)
def test_thresholds_of_steep_laws(name):
    law, changes, expected = STEEP[name]
    threshold = simulated(law, rtol=1e-8, **changes)
    assert {type(threshold.value), type(threshold.relative_error)} == {float}
    assert threshold.value == pytest.approx(expected, rel=1e-8)
    assert separates(law, threshold.value, 1e-6, **changes)


@pytest.mark.parametrize("V", [0.95, 1.5])
def test_every_method_says_no_damping_is_needed(V):
    """By a negative value, and in words."""
    point = {"V": V, "N": 9.81, "m": 1, "k": 100}
    methods = ("harmonic", "orbit", "simulation", "auto")
    found = [ss.pure_slip_damping(POLYNOMIAL, **point, method=method) for method in methods]
    assert all(one.value < 0 and "no damping is needed" in str(one) for one in found)
    assert found[1].value == pytest.approx(found[2].value, rel=1e-5)
    rising = ss.FrictionLaw("mu_0 + b*v").bind(mu_0=0.3, b=0.1)
    assert ss.pure_slip_damping(rising, **point, method="simulation").value == pytest.approx(-0.981, rel=1e-9)


@pytest.mark.parametrize("method", ["orbit", "simulation", "auto"])
def test_without_friction_no_damping_is_needed(method):
    found = simulated(EXPONENTIAL, N=0.0, method=method)
    assert found.value == 0
    assert found.relative_error <= 1e-13


@pytest.mark.parametrize("formula", ["0.3", "0.3 + 0.005*v + 0.01*Max(v - 0.7, 0)"])
def test_a_static_coefficient_moves_the_threshold(formula):
    """But no average, also where the slope of mu is positive and it alone makes the mass stick."""
    plain, jump = ss.FrictionLaw(formula), ss.FrictionLaw(formula, static="0.5")
    assert ss.derive(jump)(V=0.5, N=9.81) == ss.derive(plain)(V=0.5, N=9.81) <= 0
    threshold = simulated(jump, rtol=1e-8).value
    assert 0 < threshold < 5
    assert separates(jump, threshold, 1e-7)
    assert simulated(plain, rtol=1e-8).value <= 0


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        (EXPONENTIAL, {}),
        (EXPONENTIAL, {"V": 10.0}),
        (POLYNOMIAL, {"V": 0.89}),
        (ROOT, {}),
        (ss.FrictionLaw("0.3", static="0.4"), {}),
        (ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)"), {}),
        (ss.FrictionLaw("Piecewise((0.4, v < 0.3), 0.43 - 0.1*v)", static="0.41"), {}),
        (ss.laws.exponential.typical(alpha=5.08), {"k": 29.367, "V": 0.41959, "N": 18.5287}),  # a canard
    ],
)
def test_the_error_of_a_threshold_is_honest(law, changes):
    exact = simulated(law, rtol=1e-10, **changes)
    for rtol in (1e-3, 1e-4, 1e-6, 1e-8):
        loose = simulated(law, rtol=rtol, **changes)
        off = loose.relative_error + exact.relative_error
        assert abs(loose.value - exact.value) <= off * exact.value <= (rtol + 1e-10) * exact.value
    if not law.kinks() and law.static is None:
        orbit = simulated(law, method="orbit", **changes)
        assert orbit.value == pytest.approx(exact.value, rel=1e-9)


def test_a_refusal_holds_the_best_value(law):
    assert simulated(law, rtol=1e-11).relative_error <= 1e-11
    with pytest.raises(ss.NotConverged, match=r'the best value found .* kg/s, relative error.* or method="proof"'):
        simulated(law, rtol=1e-13)


@sweep("count", [8, 60], 8)
def test_a_threshold_of_pieces_separates_return_from_none(count):
    """Within its error, wherever it is positive."""
    rng = np.random.default_rng(17)
    positive = 0
    for law in laws_in_pieces(rng, count):
        V, N, k = rng.uniform(0.05, 0.9), 10 ** rng.uniform(-0.5, 1.5), 10 ** rng.uniform(1, 3.5)
        found = ss.pure_slip_damping(law, V=V, N=N, m=1, k=k, method="simulation", rtol=rng.choice([1e-6, 1e-8]))
        off = max(2 * found.relative_error, 1e-9)
        positive += found.value > 0
        below, above = (ss.Oscillator(m=1, k=k, V=V, N=N, c=found.value * (1 + sign * off)) for sign in (-1, 1))
        if found.value > 0:
            assert ss.peak_velocity(law, below) > V > ss.peak_velocity(law, above), (law, below)
    assert count / 2 <= positive < count

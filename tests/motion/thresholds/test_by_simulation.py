"""The threshold by simulation: what it separates, its error, and laws that are steep."""

from dataclasses import astuple

import numpy as np
import pytest
from scenes import laws_in_pieces, paper_oscillator
from sweeps import sweep

import stickslip_sym as ss


@pytest.mark.parametrize(("name", "expected"), [("exponential", 2.57307887898), ("polynomial", 3.03647724356)])
def test_threshold_is_stable_to_1e_9(name, expected):
    law = ss.laws.catalogue[name].typical()
    scene = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "method": "simulation"}
    loose, tight = (ss.pure_slip_damping(law, **scene, rtol=rtol) for rtol in (1e-10, 1e-11))
    assert abs(loose.value - tight.value) < 1e-9 * tight.value
    assert abs(loose.value - tight.value) < loose.relative_error * loose.value
    assert tight.relative_error < 1e-9
    assert tight.value == pytest.approx(expected, rel=1e-10)


def test_threshold_separates_cycles_from_none(law):
    threshold = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="simulation", rtol=1e-11).value
    for step in (1e-3, 1e-5, 1e-7):
        assert ss.stick_slip_cycle(law, paper_oscillator(threshold * (1 - step))) is not None
        assert ss.stick_slip_cycle(law, paper_oscillator(threshold * (1 + step))) is None
    assert ss.peak_velocity(law, paper_oscillator(threshold * 0.9)) > 0.5
    assert ss.peak_velocity(law, paper_oscillator(threshold * 1.1)) < 0.5


def test_threshold_in_other_units_is_the_same(law):
    """Only two dimensionless groups matter: heavier, stiffer and loaded alike, the threshold scales."""
    base = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=100, method="simulation", rtol=1e-11).value
    scaled = ss.pure_slip_damping(law, V=0.5, N=9.81e6, m=1e6, k=1e8, method="simulation", rtol=1e-11).value
    assert scaled == pytest.approx(1e6 * base, rel=1e-10)


def test_weak_friction_limit_is_the_slope(law):
    """As k grows the orbit becomes harmonic, and the threshold leaves the equilibrium slope behind."""
    stiff = ss.pure_slip_damping(law, V=0.5, N=9.81, m=1, k=1e8, method="simulation", rtol=1e-9).value
    angle = (np.arange(64) + 0.5) * np.pi / 64
    harmonic = 9.81 * np.mean(-law.slope(0.5 * (1 + np.cos(angle))) * 2 * np.sin(angle) ** 2)
    assert stiff == pytest.approx(harmonic, rel=1e-6)


def test_closed_form_methods(law):
    for criterion in ss.criteria.catalogue:
        found, form = ss.pure_slip_damping(law, V=0.5, N=9.81, method=criterion), ss.derive(law, criterion)
        assert (found.value, found.relative_error) == (pytest.approx(form(V=0.5, N=9.81), rel=1e-15), None)


@pytest.mark.parametrize("V", [0.95, 1.5])
def test_where_no_damping_is_needed_every_method_says_so(V):
    """By a negative value, and in words."""
    law, points = ss.laws.polynomial.typical(), {"V": V, "N": 9.81, "m": 1, "k": 100}
    found = [
        ss.pure_slip_damping(law, **points, method=method)
        for method in ("harmonic", "orbit", "simulation", "auto")
    ]
    assert all(one.value < 0 and "no damping is needed" in str(one) for one in found)
    assert found[1].value == pytest.approx(found[2].value, rel=1e-5)
    rising = ss.FrictionLaw("mu_0 + b*v").bind(mu_0=0.3, b=0.1)
    assert ss.pure_slip_damping(rising, **points, method="simulation").value == pytest.approx(-0.981, rel=1e-9)


@pytest.mark.parametrize("method", ["orbit", "simulation", "auto"])
def test_without_friction_no_damping_is_needed(method):
    found = ss.pure_slip_damping(ss.laws.exponential.typical(), V=0.5, N=0.0, m=1, k=100, method=method)
    assert found.value == 0
    assert found.relative_error <= 1e-13


def test_static_coefficient_moves_the_threshold_but_no_average():
    plain = ss.FrictionLaw("mu_k").bind(mu_k=0.3)
    jump = ss.FrictionLaw("mu_k", static="mu_0").bind(mu_k=0.3, mu_0=0.4)
    osc = paper_oscillator(0.0)
    assert ss.stick_slip_cycle(jump, osc) is not None
    assert ss.derive(jump)(V=0.5, N=9.81) == ss.derive(plain)(V=0.5, N=9.81) == 0
    threshold = ss.pure_slip_damping(jump, V=0.5, N=9.81, m=1, k=100, method="simulation")
    assert threshold.value > 0
    assert ss.stick_slip_cycle(jump, paper_oscillator(threshold.value * 1.001)) is None


STEEP = {
    "alpha 8": (ss.laws.exponential.typical(alpha=8), {}, 2.067284261),
    "N 50": (ss.laws.exponential.typical(), {"N": 50.0}, 12.47356032),
    "canard": (ss.laws.exponential.typical(), {"V": 0.3, "N": 1e3}, 366.0493724),
    "light": (ss.laws.exponential.typical(), {"m": 1e-6}, 1.970041565),
    "soft": (ss.laws.exponential.typical(), {"k": 1e-4}, 1.970041565),
    "layer": (ss.FrictionLaw("0.2+0.1*exp(-v/0.01)", static="0.4"), {"V": 0.1}, 3.692056429),
    "polynomial": (ss.laws.polynomial.typical(), {"N": 1e4}, 3374.977777),
    "root": (ss.FrictionLaw("0.5-0.1*sqrt(v)"), {}, 0.832662017),
}


def simulated_threshold(law, rtol=1e-10, **changes):
    scene = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "method": "simulation", "rtol": rtol}
    return ss.pure_slip_damping(law, **(scene | changes))


@pytest.mark.parametrize("name", STEEP)
def test_thresholds_of_steep_laws(name):
    law, changes, expected = STEEP[name]
    threshold = simulated_threshold(law, rtol=1e-8, **changes)
    assert threshold.value == pytest.approx(expected, rel=1e-8)
    below, above = (paper_oscillator(threshold.value * factor, **changes) for factor in (1 - 1e-6, 1 + 1e-6))
    assert ss.stick_slip_cycle(law, below) is not None
    assert ss.stick_slip_cycle(law, above) is None


def test_peak_velocity_continues_through_the_graze(law):
    """Value and slope of the lowest slip speed agree on both sides: its differences show no corner."""
    threshold = simulated_threshold(law, rtol=1e-11).value
    peak = [ss.peak_velocity(law, paper_oscillator(threshold * (1 + d))) - 0.5 for d in (-1e-5, 0, 1e-5)]
    assert abs(peak[1]) < 1e-9
    assert peak[0] == pytest.approx(-peak[2], rel=0.02)


@pytest.mark.parametrize(
    ("law", "changes"),
    [
        (ss.laws.exponential.typical(), {}),
        (ss.laws.exponential.typical(), {"V": 10.0}),
        (ss.laws.polynomial.typical(), {"V": 0.89}),
        (ss.FrictionLaw("0.3", static="0.4"), {}),
        (ss.FrictionLaw("0.5-0.1*sqrt(v)"), {}),
    ],
)
def test_the_error_of_a_threshold_is_honest(law, changes):
    exact = simulated_threshold(law, rtol=1e-9, **changes).value
    for rtol in (1e-3, 1e-4, 1e-6, 1e-8):
        loose = simulated_threshold(law, rtol=rtol, **changes)
        assert abs(loose.value - exact) <= loose.relative_error * exact <= rtol * exact


def test_results_are_plain_floats(law):
    threshold = simulated_threshold(law)
    assert {type(threshold.value), type(threshold.relative_error)} == {float}
    for c in (1.0, -1.0):
        cycle = ss.stick_slip_cycle(ss.laws.exponential.typical(), paper_oscillator(c))
        assert {type(value) for value in astuple(cycle)} == {float}
    osc = paper_oscillator(np.float64(1.0), V=np.float64(0.5))
    assert type(ss.peak_velocity(law, osc)) is float
    motion = ss.simulate(law, osc, t_end=2.0, x0=np.float64(0.1))
    assert {type(value) for event in motion.events for value in (event.t, event.x, event.v)} == {float}


def test_an_accuracy_that_is_not_reached_is_refused_with_the_best_value(law):
    assert simulated_threshold(law, rtol=1e-11).relative_error <= 1e-11
    with pytest.raises(ss.NotConverged, match=r"the best value found .* kg/s, relative error"):
        simulated_threshold(law, rtol=1e-13)


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


def test_a_canard_has_an_honest_error():
    """w jumps within 1e-9 of the damping there."""
    law, point = ss.laws.exponential.typical(alpha=5.08), {"k": 29.367, "V": 0.41959, "N": 18.5287}
    exact = simulated_threshold(law, rtol=1e-11, **point).value
    for rtol in (1e-6, 1e-8, 1e-9, 1e-10):
        found = simulated_threshold(law, rtol=rtol, **point)
        assert abs(found.value / exact - 1) < found.relative_error
    assert exact == pytest.approx(
        ss.pure_slip_damping(law, m=1, **point, method="orbit", rtol=1e-10).value, rel=1e-9
    )


def test_the_slope_of_the_average_may_have_the_wrong_sign():
    """The slope of mu is positive, and only the static coefficient makes the mass stick."""
    law = ss.FrictionLaw("0.3 + 0.005*v + 0.01*Max(v - 0.7, 0)", static="0.6")
    found = simulated_threshold(law, rtol=1e-8)
    assert 0 < found.value < 5
    for sign in (-1, 1):
        osc = paper_oscillator(found.value * (1 + sign * 1e-8))
        assert (ss.stick_slip_cycle(law, osc) is None) is (sign > 0)
    assert simulated_threshold(law.with_static(None), rtol=1e-8).value < 0

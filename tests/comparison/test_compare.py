"""`compare` and the table of `derive`: every method beside the others, and why they differ."""

import math
import pickle
import random

import pytest

import stickslip_sym as ss
from stickslip_sym.comparison import crosscheck
from stickslip_sym.comparison.crosscheck import differences, scatter
from stickslip_sym.comparison.plane import plane
from support.sweeps import sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


def test_compare_gives_what_each_method_gives(law):
    found = ss.compare(law, ss.Oscillator(c=0.0, **POINT))
    assert [one.method for one in found][:4] == ["equilibrium", "least_squares", "harmonic", "second_order"]
    for one in found:
        alone = ss.pure_slip_damping(law, **POINT, method=one.method, rtol=1e-10)
        assert one.threshold.value == alone.value
        assert one.method in str(found)
        assert f"{alone.value:.12g}" in str(found)
    proved = found["proof"].threshold
    for one in (one.threshold for one in found):
        assert abs(one.value / proved.value - 1) <= 1.5 * one.relative_error + proved.relative_error
    assert str(pickle.loads(pickle.dumps(found))) == str(found)


def test_compare_says_why_a_method_has_no_value():
    found = ss.compare(ss.FrictionLaw("0.5 - 0.1*Min(v, 0.3)"), **POINT, methods=["orbit", "simulation"])
    assert found["orbit"].value is None
    assert found["orbit"].reason
    assert f"none: {found['orbit'].reason[:20]}" in str(found)
    assert found["simulation"].threshold.value > 0


def test_compare_without_an_oscillator_has_averages_only():
    found = ss.compare(ss.laws.polynomial.typical(), V=0.5, N=9.81)
    assert [one.method for one in found] == list(ss.criteria.catalogue)
    with pytest.raises(ss.InputError, match=r"depends on k and m; compare with m=1 and k=100"):
        found.plot()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "give the operating point once"),
        ({"osc": ss.Oscillator(c=0.0, **POINT), "V": 1.0}, "give the operating point once"),
        ({"V": 1.0, "N": 1.0, "c": 1.0}, "V, N, m and k, not c"),
        ({**POINT, "methods": "orbits"}, "did you mean 'orbit'"),
        ({"osc": 3}, "got 3 where an Oscillator is expected"),
        ({**POINT, "rtol": "x"}, "rtol = 'x'"),
    ],
)
def test_compare_refuses_what_is_no_operating_point(given, words):
    with pytest.raises(ss.InputError, match=words):
        ss.compare(ss.laws.polynomial.typical(), **given)


def test_static_coefficient_is_named_as_the_reason():
    law = ss.FrictionLaw("0.2 + 0.3*exp(-3*v)", static="0.9")
    value = ss.slope_average(law)(V=0.5, N=9.81)
    reasons = differences(law, ss.criteria.least_squares, POINT, value, 2 * value)
    assert any(reason.startswith("the static coefficient") for reason in reasons)
    plain = ss.FrictionLaw(law.expr)
    assert differences(plain, ss.criteria.least_squares, POINT, value, 1.01 * value) == []


def test_another_weight_is_named_as_the_reason():
    law = ss.laws.exponential.typical()
    point = POINT | {"V": 2.0}
    value = ss.slope_average(law, "equilibrium")(V=2.0, N=9.81)
    reasons = differences(law, ss.criteria.equilibrium, point, value, 0.9)
    weak = ss.slope_average(law, "harmonic")(V=2.0, N=9.81)
    assert f"the harmonic average, {weak:.4g} kg/s" in reasons[0]


@pytest.mark.parametrize(("off", "is_named"), [(0.03, False), (0.12, True)])
def test_differences_of_some_per_cent_are_named(off, is_named, monkeypatch):
    """What the static coefficient, or the weight, makes of the threshold of 1 kg/s."""
    asked = []

    def simulated(law, point, rtol=1e-6):
        asked.append(point["k"] / POINT["k"])
        return 1 - off

    monkeypatch.setattr(crosscheck, "_simulated", simulated)
    law = ss.laws.linear.typical().with_static("0.9")
    weak = float(ss.slope_average(law, "harmonic")(V=0.5, N=9.81))
    reasons = differences(law, ss.criteria.least_squares, POINT, (1 + off) * weak, 1.0)
    assert any(reason.startswith("the weight") for reason in reasons) == is_named
    assert any(reason.startswith("the static coefficient") for reason in reasons) == is_named
    assert max(asked) ** 0.5 == pytest.approx(100), "at a hundredth of eta"


def test_a_threshold_beside_a_criterion_has_twelve_digits():
    law = ss.laws.exponential.typical()
    row = crosscheck.crosscheck(law, ss.criteria.equilibrium, POINT, None, digits=20)["event-driven threshold"]
    right = ss.pure_slip_damping(law, **POINT, method="orbit", rtol=1e-12).value
    assert float(row.value) == pytest.approx(right, rel=1e-11)
    assert len(row.value.replace(".", "")) == 12


def test_curves_over_speed_have_some_tens_of_points():
    """Thresholds up to twice the belt's speed, as exact as a line is wide."""
    law = ss.laws.polynomial.typical()
    curves = plane(law, {name: POINT[name] for name in "Nmk"}, 0.5)
    assert curves["V"][-1] == 1.0
    assert 20 < len(curves["V"]) < 60
    right = ss.pure_slip_damping(law, V=curves["V"][-1], N=9.81, m=1, k=100).value
    assert curves["exact"][-1] == pytest.approx(right, rel=1e-5)


def scattered(count=5):
    rng = random.Random(6)
    v = [1.2 * i / (count - 1) for i in range(count)]
    mu = [round((0.2 + 0.3 * math.exp(-3 * speed)) * (1 + rng.uniform(-0.06, 0.06)), 6) for speed in v]
    return v, mu


@sweep("name", list(ss.criteria.catalogue), "equilibrium", "least_squares")
def test_scatter_is_the_jackknife_of_the_criterion(name):
    v, mu = scattered(9)
    criterion = ss.criteria.catalogue[name]
    values = []
    for i in range(1, len(v) - 1):
        other = ss.FrictionLaw.from_samples(v[:i] + v[i + 1 :], mu[:i] + mu[i + 1 :])
        values.append(float(ss.quadrature.damping(other, criterion, V=0.5, N=9.81, digits=15)))
    mean = sum(values) / len(values)
    expected = math.sqrt((len(values) - 1) / len(values) * sum((value - mean) ** 2 for value in values))
    found = scatter(ss.FrictionLaw.from_samples(v, mu), criterion, 0.5, 9.81)
    assert found == pytest.approx(expected, rel=1e-6)
    assert scatter(ss.FrictionLaw.from_samples(v[:4], mu[:4]), criterion, 0.1, 9.81) == 0.0

"""Standard errors of thresholds: to first order, checked to second, and shared out; against seeded samples."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
from uncertainties import correlated_values, ufloat

import stickslip_sym as ss

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
COVARIANCE = [[4e-4, -1.5e-4, 0], [-1.5e-4, 1e-4, 1e-3], [0, 1e-3, 0.04]]
NAMES = ("mu_s", "mu_m", "alpha")


def correlated():
    """Return the exponential law with parameters as a fit gives them."""
    values = correlated_values([0.5, 0.2, 3.0], COVARIANCE)
    return ss.laws.exponential.bind(**dict(zip(NAMES, values, strict=True)))


def test_the_first_order_is_of_sensitivities_and_covariance():
    found = ss.pure_slip_damping(correlated(), **POINT, method="orbit")
    s = np.array([found.sensitivity[name] for name in NAMES])
    assert found.uncertainty == pytest.approx(np.sqrt(s @ np.array(COVARIANCE) @ s), rel=1e-9)
    independent = correlated().bind(mu_s="0.50(2)", mu_m="0.20(1)", alpha="3.0(2)")
    assert found.uncertainty > 1.1 * ss.pure_slip_damping(independent, **POINT, method="orbit").uncertainty
    plain = ss.pure_slip_damping(ss.laws.exponential.typical(), **POINT)
    assert (plain.uncertainty, plain.budget, plain.nonlinearity) == (None, None, 1.0)


def test_the_library_propagates_the_same():
    """Through an average whose formula its arithmetic can follow."""
    a_1, N = ufloat(0.3, 0.02), ufloat(9.81, 0.4)
    law = ss.FrictionLaw("mu_s - a_1*v + a_3*v^3").bind(mu_s=0.5, a_1=a_1, a_3="0.100(5)")
    a_3, V = law.uncertain["a_3"], ufloat(0.4, 0.01)
    found = ss.pure_slip_damping(law, V=V, N=N, method="equilibrium")
    by_library = N * (a_1 - 3 * a_3 * V**2)
    assert found.value == pytest.approx(by_library.nominal_value, rel=1e-12)
    assert found.uncertainty == pytest.approx(by_library.std_dev, rel=1e-12)
    for part, name in ((a_1, "a_1"), (a_3, "a_3"), (V, "V"), (N, "N")):
        assert found.budget.alone[name] == pytest.approx(by_library.error_components()[part], rel=1e-12)


def test_shares_add_up_and_say_what_is_correlated():
    budget = ss.pure_slip_damping(correlated(), **POINT | {"N": "9.8(3)"}, method="orbit").budget
    assert sum(budget.shares.values()) == pytest.approx(1, rel=1e-12)
    assert list(budget.shares.values()) == sorted(budget.shares.values(), reverse=True)
    pairs = {frozenset(pair): r for *pair, r in budget.correlated}
    assert pairs == {frozenset(NAMES[:2]): pytest.approx(-0.75), frozenset(NAMES[1:]): pytest.approx(0.5)}
    assert "mu_s and mu_m (-0.75)" in str(budget)
    assert budget._repr_html_().count("<tr>") == 5
    alone = ss.pure_slip_damping(ss.laws.exponential.typical(mu_s="0.50(2)"), **POINT, method="orbit").budget
    assert alone.shares == {"mu_s": 1.0}
    assert "correlated" not in str(alone)


def test_the_second_order_is_that_of_samples():
    """Four quantities, three of them correlated, with large errors."""
    values = correlated_values([0.5, 0.2, 3.0], 16 * np.array(COVARIANCE))
    law = ss.laws.exponential.bind(**dict(zip(NAMES, values, strict=True)))
    found = ss.pure_slip_damping(law, V=ufloat(0.9, 0.18), N=9.81, method="harmonic")
    rng = np.random.default_rng(7)
    whole = np.zeros((4, 4))
    whole[:3, :3], whole[3, 3] = 16 * np.array(COVARIANCE), 0.18**2
    draws = rng.multivariate_normal([0.5, 0.2, 3.0, 0.9], whole, 40_000)
    average = ss.slope_average(law, "harmonic")
    keep = (draws > 0.02).all(axis=1)
    assert keep.mean() > 0.98
    sampled = average(N=9.81, **dict(zip((*NAMES, "V"), draws[keep].T, strict=True))).std()
    ratio = sampled / found.budget.uncertainty
    assert found.nonlinearity == pytest.approx(ratio, rel=0.03)
    assert abs(ratio - 1) > 0.03


def test_a_first_order_that_does_not_suffice():
    """The threshold of the gaussian law has its maximum over v_s there: its first order is a millionth."""
    law = ss.laws.gaussian.typical(v_s="0.500(2)")
    found = ss.pure_slip_damping(law, **POINT | {"V": 0.569}, method="harmonic")
    with pytest.warns(ss.InputWarning, match=r"times as large to second order"):
        assert found.uncertainty < 1e-5
    assert found.nonlinearity == pytest.approx(13.03, rel=1e-3)
    wide = ss.pure_slip_damping(ss.laws.exponential.typical(alpha="3.0(20)"), **POINT, method="orbit")
    with pytest.warns(ss.InputWarning, match=r"could not be checked .*alpha = -0\.46"):
        assert wide.uncertainty > 0
    assert np.isnan(wide.nonlinearity)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert ss.pure_slip_damping(correlated(), **POINT, method="harmonic").uncertainty > 0


@pytest.mark.parametrize("method", ["harmonic", "second_order", "orbit", "simulation"])
def test_a_hidden_error_needs_no_second_order(method):
    """That of mu_s, on which the threshold of a falling line does not depend, and one of nine digits less."""
    line = ss.pure_slip_damping(ss.laws.linear.typical(mu_s="0.50(2)"), **POINT, method=method)
    law = ss.laws.exponential.typical(mu_s=ufloat(0.5, 5e-10))
    small = ss.pure_slip_damping(law, **POINT, method=method)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert line.uncertainty == pytest.approx(0, abs=1e-12)
        assert small.uncertainty > 0
    assert (line.nonlinearity, small.nonlinearity) == pytest.approx((1.0, 1.0))
    averaged = ss.pure_slip_damping(ss.laws.linear.typical(mu_s="0.50(2)"), V=0.5, N=9.81, method="equilibrium")
    assert str(averaged).startswith("1.4715 +/- 0 kg/s (parameters)")


def test_arrays_carry_the_errors_of_what_is_one_number():
    found = ss.pure_slip_damping(correlated(), **POINT | {"V": [0.3, 0.5], "N": "9.8(3)"}, method="orbit")
    for place, V in enumerate((0.3, 0.5)):
        single = ss.pure_slip_damping(correlated(), **POINT | {"V": V, "N": "9.8(3)"}, method="orbit")
        assert found.uncertainty[place] == pytest.approx(single.uncertainty, rel=1e-12)
        assert found.nonlinearity[place] == pytest.approx(single.nonlinearity, rel=1e-7)
        assert found.budget.shares["N"][place] == pytest.approx(single.budget.shares["N"], rel=1e-9)
    assert " to " in str(found.budget)
    with pytest.raises(ss.InputError, match=r"V = .* is not a number or an array of numbers"):
        ss.pure_slip_damping(correlated(), **POINT | {"V": [ufloat(0.3, 0.01), 0.5]})


def test_a_time_limit_binds_what_is_asked_later():
    found = ss.pure_slip_damping(correlated(), **POINT, method="simulation", time_limit=60)
    late = replace(found, time_limit=1e-9)
    for quantity in ("sensitivity", "budget", "uncertainty", "nonlinearity"):
        with pytest.raises(ss.OutOfTime, match="time limit was reached"):
            getattr(late, quantity)
    assert "(simulation, relative error" in str(late)
    assert found.uncertainty > 0


@pytest.mark.parametrize(
    "formula", ["0.5 - a*Min(v, Max(w, u))", "0.5 - 0.2*Max(a, b)*tanh(v/w)", "Max(0.2, 0.5 - a*Min(v, w, u))"]
)
def test_the_larger_and_the_smaller_of_two_parameters(formula):
    """The derivative is that of the one that counts: against thresholds at shifted values."""
    values = {name: x for name, x in {"a": 0.4, "b": 0.3, "w": 0.35, "u": 0.62}.items() if name in formula}

    def threshold(**changed):
        law = ss.FrictionLaw(formula).bind(**values | changed)
        return ss.pure_slip_damping(law, **POINT, method="simulation", rtol=1e-9).value

    uncertain = ss.FrictionLaw(formula).bind(**{name: ufloat(x, x / 1000) for name, x in values.items()})
    found = ss.pure_slip_damping(uncertain, **POINT, method="simulation", rtol=1e-9)
    for name, x in values.items():
        slope = (threshold(**{name: x * 1.0001}) - threshold(**{name: x * 0.9999})) / (2e-4 * x)
        assert found.sensitivity[name] == pytest.approx(slope, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(("error", "count"), [("1.0(3)", 0), ("1.0(5)", 1)])
def test_a_tenth_between_the_orders_is_warned_of(error, count):
    """Of c = 0.1 N exp(a) the second order over the first is sqrt(1 + 1.5 s^2): 1.07 and 1.17."""
    law = ss.FrictionLaw("0.5 - 0.1*exp(a)*v", parameters=[ss.Parameter("a", positive=False)]).bind(a=error)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        _ = ss.pure_slip_damping(law, **POINT).uncertainty
    assert len(said) == count

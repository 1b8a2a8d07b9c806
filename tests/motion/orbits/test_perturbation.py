"""The threshold to second order: its order of accuracy, its closed form, and the averages it starts from."""

import warnings

import numpy as np
import pytest

import stickslip_sym as ss
from derivations import d8_second_order
from stickslip_sym.core.symbols import N, V, k, m
from stickslip_sym.motion.orbits.expansion import expand
from support.sweeps import sweep

FOUR = ["exponential", "polynomial", "hyperbolic", "gaussian"]
AGREES = 1e-12  # two ways to the same sum in double precision
ORDER = 0.1  # of a slope fitted over four octaves of eta, where the next order is still seen


def threshold(law, method, **changes):
    point = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0, "method": method, "rtol": 1e-11}
    return ss.pure_slip_damping(law, **(point | changes)).value


@pytest.mark.parametrize("name", FOUR)
def test_the_error_falls_with_its_order_in_eta(name):
    law, k = ss.laws.catalogue[name].typical(), 400.0 * 4.0 ** np.arange(4)
    exact = threshold(law, "orbit", k=k)
    harmonic = 9.81 * expand(law.bound, [0.5]).harmonic
    for value, order in ((harmonic, 2), (threshold(law, "second_order", k=k), 4)):
        error = np.abs(value / exact - 1)
        slope, _ = np.polyfit(np.log(1 / np.sqrt(k)), np.log(error), 1)  # eta goes with k^-1/2
        assert slope == pytest.approx(order, abs=ORDER)


@sweep("name", ["polynomial", "cubic", "quintic"], "cubic")
def test_closed_form_of_polynomial_laws_is_the_sum(name):
    law = ss.laws.catalogue[name].typical()
    form = d8_second_order.threshold(law.expr).xreplace(law.point)
    for point in ({V: 0.5, N: 9.81, m: 1, k: 100}, {V: 1.1, N: 3.0, m: 0.2, k: 7}):
        values = {str(symbol): value for symbol, value in point.items()}
        assert threshold(law, "second_order", **values) == pytest.approx(float(form.subs(point)), rel=AGREES)


def test_closed_form_of_law_4_in_plain_numbers():
    weak = 9.81 * 0.3 * (12 - 15 * 0.25) / 8
    second = 31149 / 81920 * (9.81 * 0.3) ** 3 * 0.5**6 / 100
    assert threshold(ss.laws.polynomial.typical(), "second_order") == pytest.approx(weak + second, rel=AGREES)


def test_expansion_says_what_is_not_resolved():
    assert not expand(ss.laws.stribeck.typical().bound, [0.5]).resolved
    law = ss.FrictionLaw("0.5 - 0.1*sqrt(v)")
    assert not expand(law.bound, [0.5]).resolved
    point = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
    stated = ss.pure_slip_damping(law, **point, method="second_order")
    exact = ss.pure_slip_damping(law, **point, method="simulation", rtol=1e-11)
    off = abs(stated.value / exact.value - 1)
    assert 1e-8 < off <= stated.relative_error + exact.relative_error


@pytest.mark.parametrize("method", ["second_order", "orbit", "simulation", "auto"])
def test_slopes_that_overflow_are_refused(method):
    """A quotient of constants that divides by 0, and squares of slopes beyond the largest double."""
    point = {"V": 0.5, "N": 1.0, "m": 1.0, "k": 100.0, "method": method}
    with pytest.raises(ss.NotConverged), warnings.catch_warnings(action="ignore"):
        ss.pure_slip_damping(ss.FrictionLaw("mu_s - a*v^2").bind(mu_s=0.5, a="1e200"), **point)
    with pytest.raises((ss.InputError, ss.NotConverged)):
        ss.pure_slip_damping(ss.FrictionLaw("mu_s - a*v/b").bind(mu_s=0.5, a=1, b=0), **point)

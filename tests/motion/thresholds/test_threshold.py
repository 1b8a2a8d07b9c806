"""Thresholds by every method: their values, their bounds, and what is refused."""

import math

import numpy as np
import pytest
from sweeps import sweep

import stickslip_sym as ss

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}


@pytest.fixture(scope="module")
def exponential():
    return ss.laws.exponential.typical()


def test_without_an_oscillator_the_error_is_unknown(exponential):
    found = ss.pure_slip_damping(exponential, V=0.5, N=9.81)
    assert (found.method, found.relative_error) == ("harmonic", None)
    assert "relative error unknown" in str(found)
    straight = ss.pure_slip_damping(ss.laws.catalogue["linear"].typical(), V=0.5, N=9.81)
    assert straight.value == pytest.approx(0.15 * 9.81, rel=1e-15)
    assert straight.relative_error < 1e-13


def test_arrays_broadcast(exponential):
    V, k = np.array([[0.2], [0.5], [0.8]]), np.array([50.0, 100.0])
    for method in ("auto", "harmonic", "second_order", "orbit"):
        found = ss.pure_slip_damping(exponential, V=V, N=9.81, m=1.0, k=k, method=method)
        assert found.value.shape == found.relative_error.shape == found.method.shape == (3, 2)
        single = ss.pure_slip_damping(exponential, V=0.8, N=9.81, m=1.0, k=50.0, method=method)
        assert found.value[2, 0] == pytest.approx(single.value, rel=1e-9)
        assert found.method[2, 0] == single.method
    assert ss.pure_slip_damping(exponential, V=V, N=9.81).value.shape == (3, 1)
    assert ss.pure_slip_damping(exponential, V=np.empty(0), N=9.81, m=1.0, k=1.0).value.shape == (0,)


@pytest.mark.parametrize("size", [1e-6, 1e6])
@pytest.mark.parametrize("name", ["m", "k", "N", "V"])
def test_twelve_decades_of_each_quantity(exponential, name, size):
    """An answer within the tolerance, or an outcome that says why not."""
    point = POINT | {name: size}
    # m and k matter by their product only, and N and k m by the ratio of their squares.
    both = point | {"m": point["m"] * np.array([1, 64]), "k": point["k"] / np.array([1, 64])}
    found = ss.pure_slip_damping(exponential, **both, rtol=1e-3)
    assert np.isfinite(found.value).all()
    assert (found.relative_error <= 1e-3).all()
    assert found.value[1] == pytest.approx(found.value[0], rel=1e-9)


KINKED = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
JUMP = ss.FrictionLaw("0.4 - 0.1*v", static="0.45")


@pytest.mark.parametrize(
    ("law", "why"), [(KINKED, "kink at v = 0.7"), (JUMP, "static coefficient 0.45 lies above")]
)
@pytest.mark.parametrize("method", ["second_order", "orbit"])
def test_rough_laws_belong_to_simulation(law, why, method):
    with pytest.raises(ss.InputError, match=f'{why}.*method="simulation"'):
        ss.pure_slip_damping(law, **POINT, method=method)
    found = ss.pure_slip_damping(law, **POINT, rtol=1e-6)
    assert found.method == "simulation"


def test_a_small_static_excess():
    """zeta = (dF/(V sqrt(m k)))^2/(4 pi) for Coulomb friction; the deviation falls with the excess."""
    jump, off = 0.02 / 2.0 ** np.arange(4), []
    for excess in jump:
        law = ss.FrictionLaw("0.3", static=repr(0.3 + float(excess)))
        zeta = ss.pure_slip_damping(law, **POINT, method="simulation", rtol=1e-7).value / (2 * 10.0)
        off.append(abs(zeta / ((excess * 9.81 / (0.5 * 10.0)) ** 2 / (4 * math.pi)) - 1))
    order, _ = np.polyfit(np.log(jump), np.log(off), 1)
    assert order == pytest.approx(2, abs=0.1)
    assert off[-1] < 1e-4


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rtol": 2.0}, "rtol = 2 is outside 1e-13 to 1"),
        ({"m": None}, "give both the mass m and the stiffness k"),
        ({"m": None, "k": None, "method": "orbit"}, 'method="orbit" needs the mass m'),
        ({"V": [0.5, 0.0]}, "V = 0 must be positive"),
        ({"N": -1.0}, "N = -1 must not be negative"),
        ({"k": [1.0, 2.0], "V": [1.0, 2.0, 3.0]}, "the shapes do not broadcast"),
        ({"V": "fast"}, "V = 'fast' is not a number"),
        ({"m": float("inf")}, "m holds a value that is not finite"),
        ({"V": np.ma.array([0.5, 0.6], mask=[0, 1])}, "V has masked entries"),
    ],
)
def test_wrong_input(exponential, changes, message):
    with pytest.raises(ss.InputError, match=message):
        ss.pure_slip_damping(exponential, **(POINT | changes))


def test_a_slope_of_zero_needs_no_damping():
    law = ss.laws.polynomial.bind(mu_s="0.5", mu_m="0.2", v_m="1")
    assert ss.pure_slip_damping(law, V=1.0, N=9.81, method="equilibrium").value == 0


@sweep("formula", ["mu_k", "mu_k - a*v", "mu_k + a*(cos(v) + v)", "mu_k*cos(a*v)"], "mu_k", "mu_k - a*v")
def test_no_threshold_is_minus_zero(formula):
    law = ss.FrictionLaw(formula)
    law = law.bind(**{name: {"a": 0.0, "mu_k": 0.37}[name] for name in law.parameters})
    for method in ("auto", "equilibrium", "least_squares", "harmonic", "second_order", "orbit"):
        assert not np.signbit(ss.pure_slip_damping(law, **POINT | {"V": [0.3, 0.9]}, method=method).value).any()
        assert str(ss.pure_slip_damping(law, **POINT, method=method)).startswith("0 kg/s")

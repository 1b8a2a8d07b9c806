"""Coefficients that vanish at rest faster than any power, such as exp(-g/v): enclosed, computed, and written."""

import random

import mpmath
import numpy as np
import pytest
from flint import arb

import stickslip_sym as ss
from stickslip_sym import quadrature
from stickslip_sym.criteria.decay import bound_below
from support.sweeps import sample, some, sweep

RNG = random.Random(4010)


def a_law():
    """Return a random law with a term c v^k exp(-g/v^b + h) beside others."""
    c, g, k, b = RNG.uniform(-0.3, 0.3), RNG.uniform(0.2, 2), RNG.choice([0, 1, 0.5]), RNG.choice([1, 2, 0.5])
    inner = f"-{g:.3f}/v^{b}" + RNG.choice(["", " - 0.5*v", " + 0.2/v^0.25"])
    return RNG.choice(["", "0.4 - 0.1*v + ", "0.3*exp(-v) + "]) + f"({c:.3f})*v^{k}*exp({inner})"


LAWS = [a_law() for _ in range(2)]


@sample(2)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
def test_what_vanishes_at_rest_is_enclosed(law, criterion):
    V = f"{10 ** RNG.uniform(-1.5, 1):.3g}"
    enclosure = ss.enclose(law, criterion, V=V, N=1, digits=20)
    assert enclosure.digits >= 20
    assert float(quadrature.damping(law, criterion, V=V, N=1, digits=12)) == pytest.approx(
        float(enclosure), rel=1e-12
    )


def test_an_enclosure_keeps_its_digits_however_slow_the_belt():
    """The average of exp(-1/v) is about exp(-1/(2 V)); a bound that is absolute would swallow it."""
    for V in ("0.01", "0.001", "0.0001"):
        enclosure = ss.enclose("exp(-1/v)", V=V, N=1, digits=25)
        exact = ss.derive("exp(-1/v)").evaluate(30, V=V, N=1)
        assert enclosure.digits >= 25
        assert abs(exact / mpmath.mpmathify(enclosure.mid) - 1) < 1e-25


def test_fast_functions_of_it_agree_with_balls():
    criterion = "least_squares"
    law = ss.FrictionLaw("0.4 - 0.1*v + b*exp(-g/v)").bind(b="0.3", g="0.7")
    fast = ss.slope_average(law, criterion)
    speeds = np.array([1e-4, 4e-3, 0.03, 0.2, 1.0, 7.0, 1e3])
    exact = [float(ss.enclose(law, criterion, V=V, N=2)) for V in speeds]
    assert fast(V=speeds, N=2.0) == pytest.approx(exact, rel=1e-14)
    namespace = {}
    exec(fast.code("python"), namespace)
    assert namespace["damping"](speeds, 2.0, 0.3, 0.7) == pytest.approx(exact, rel=1e-14)


@sweep(
    ("law", "criterion"),
    [(law, criterion) for law in ("Min(0.4, exp(-1/v))", "exp(-1/v + 1/sqrt(v))")
     for criterion in ("least_squares", "harmonic")],
    ("Min(0.4, exp(-1/v))", "least_squares"),
)  # fmt: skip
def test_code_is_written_of_what_is_smaller_than_any_float_at_rest(law, criterion):
    """Where exp(-1/v) underflows a table cannot resolve it, and need not."""
    namespace = {}
    speeds = np.array(some([3e-4, 6.2e-4, 8e-4, 0.01, 0.3, 2.0], 3))
    exec(ss.slope_average(law, criterion).code("python"), namespace)
    exact = [float(ss.quadrature.damping(law, criterion, V=V, N=1, digits=20)) for V in speeds]
    assert namespace["damping"](speeds, 1.0) == pytest.approx(exact, rel=1e-13, abs=1e-290)


def test_a_certificate_in_balls_is_refused_in_words():
    with pytest.raises(ss.InputError, match="vanishes at rest faster than any power"):
        ss.enclose("exp(-1/v)", V=1, N=1).certificate()


LOG_NORMAL = ["0.6*exp(-0.1*(log(v/0.005)/log(10))^2)", "0.2 + 0.3*exp(-0.5*log(v/0.1)^2)", "0.1*v*exp(-log(v)^2)"]


@sample(4)
@sweep(("text", "criterion"), [(text, name) for text in LOG_NORMAL for name in ("least_squares", "harmonic")],
       (LOG_NORMAL[0], "least_squares"), (LOG_NORMAL[1], "harmonic"), (LOG_NORMAL[2], "harmonic"))  # fmt: skip
@pytest.mark.parametrize("V", ["1e-6", "0.05", "0.5", "40"])
def test_log_normal_laws_are_enclosed_around_what_quadrature_gives(text, criterion, V):
    """They vanish at rest faster than any power of v, without a ball around v = 0."""
    enclosure = ss.enclose(text, criterion, V=V, N=1, digits=18)
    by_quadrature = ss.quadrature.damping(text, criterion, V=V, N=1, digits=18)
    assert float(enclosure) == pytest.approx(float(by_quadrature), rel=1e-14)
    assert enclosure.digits >= 18
    assert ss.slope_average(text, criterion)(V=float(V), N=1) == pytest.approx(float(by_quadrature), rel=1e-13)


@sample(3)
@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@pytest.mark.parametrize("text", ["0.1*exp(log(v)/v)", "v*exp(-1/v - log(v)^2)", "exp(-1/v)*exp(v/(1 + v))/v^3"])
def test_exponents_of_powers_and_logarithms_are_bounded_by_one_proof(text, criterion):
    enclosure = ss.enclose(text, criterion, V="0.3", N=1, digits=18)
    by_quadrature = ss.quadrature.damping(text, criterion, V="0.3", N=1, digits=18)
    assert float(enclosure) == pytest.approx(float(by_quadrature), rel=1e-14)


@pytest.mark.parametrize("text", ["v^(-3)*exp(-1/v)", "v^(-3)*exp(-1/v + 1/sqrt(v))", "v^(-3)*exp(-log(v)^2)"])
def test_what_is_bounded_from_rest_to_a_speed_is_no_larger_there(text):
    """And where it falls again there is no bound: beyond the speed at which it is largest."""
    expr = ss.FrictionLaw(text).expr
    v = np.geomspace(1e-4, 3, 4000)
    values = ss.FrictionLaw(text).mu(v)
    for end in np.geomspace(1e-3, 3, 30):
        bound = bound_below(expr, {}, arb(end))
        below = values[v <= end].max()
        assert not bound.is_finite() or bool(bound >= below * (1 - 1e-9))
        assert not bound.is_finite() or end <= v[values.argmax()] * 1.001
    assert bound_below(expr, {}, arb(0.01)).is_finite()

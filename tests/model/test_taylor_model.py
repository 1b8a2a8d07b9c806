"""Coefficients that are finite at rest where each of their terms is not: series, limits, balls, tables."""

import numpy as np
import pytest
import sympy as sp
from flint import acb, arb
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core import symbols
from stickslip_sym.core.balls import ball_function
from stickslip_sym.core.precision import working_precision
from stickslip_sym.model.taylor_model import balls_from_rest, taylor_model
from support.sweeps import sample

BITS = 200
REMOVABLE = {
    "0.3 + 0.1*(1 - exp(-v/{w}))*{w}/v": (0.4, -0.05),
    "0.3 + 0.1*(sqrt(1 + v/{w}) - 1)*{w}/v": (0.35, -0.0125),
    "0.3 + 0.1*(exp(-v/{w}) - exp(-2*v/{w}))*{w}/v": (0.4, -0.15),
    "0.3 + 0.1*(1 - cos(v/{w}))*({w}/v)^2": (0.35, 0.0),
    "0.3 + 0.1*(v/{w})/(exp(v/{w}) - 1)": (0.4, -0.05),
    "0.3 + 0.1*log(1 + v/{w})*{w}/v": (0.4, -0.05),
    "0.3 + 0.1*sin(v/{w})*{w}/v": (0.4, 0.0),
    "0.3 + 0.1*atan(v/{w})*{w}/v": (0.4, 0.0),
    "0.3 + 0.1*(v/{w})/sinh(v/{w})": (0.4, 0.0),
    "0.3 + 0.1*(sqrt(2 + v/{w}) - sqrt(2))*{w}/v": (0.3 + 0.1 / 8**0.5, -0.1 / 8 / 2**1.5),
}
"""Formulas with a width, and mu(0+) and mu'(0+) for a width of 1."""


def law_of(text, width):
    return ss.FrictionLaw(text.format(w=repr(width)))


@sample(4)
@pytest.mark.parametrize("text", REMOVABLE)
@given(width=st.floats(-4, 2).map(lambda p: round(10.0**p, 9)))
def test_value_and_slope_at_rest_of_laws_whose_terms_are_infinite_there(text, width):
    law, (onset, slope) = law_of(text, width), REMOVABLE[text]
    assert law.onset == pytest.approx(onset, rel=1e-14)
    assert law.slope(0.0) == pytest.approx(slope / width, rel=1e-12, abs=1e-12 / width)
    v = width * np.array([1e-15, 1e-9, 1e-5])
    assert law.mu(v) == pytest.approx(onset + law.slope(0.0) * v, rel=1e-9)
    table = law.bound.table
    assert table.values(v) == pytest.approx(law.slope(0.0) * v, rel=1e-4, abs=1e-10)


@sample(4)
@pytest.mark.parametrize("text", REMOVABLE)
@given(
    width=st.floats(-2, 1).map(lambda p: round(10.0**p, 4)),
    share=st.floats(0.01, 0.99),
    phase=st.floats(-3.0, 3.0),
)
def test_a_ball_around_rest_holds_the_values_beside_it(text, width, share, phase):
    """Of mu and of its slope, by the formula where it does not cancel."""
    law = law_of(text, width)
    mu = law.kinetic.segments[0][1]
    with working_precision(BITS):
        model = taylor_model(mu, law.point)
        reach = float(model.radius) / 8
        place = acb(reach * share) * acb(complex(np.exp(1j * phase)))
        for derivative in (False, True):
            slope = sp.diff(mu, symbols.v) if derivative else None
            of_balls = balls_from_rest(mu, law.point, slope=slope)
            exact = ball_function(mu if slope is None else slope, symbols.v, law.point)(place, False)
            around = acb(arb(0, reach), arb(0, reach))
            assert of_balls(around, False).contains(exact.mid())
            assert of_balls(place, False).overlaps(exact)
            assert of_balls(place, False).real.rel_accuracy_bits() > BITS // 3 or exact.real.contains(0)


def test_a_remainder_that_is_left_out_would_be_noticed():
    """The bound is no ornament: without it a ball holds not what it should."""
    law = law_of("0.3 + 0.1*(1 - exp(-v/{w}))*{w}/v", 1)
    mu = law.kinetic.segments[0][1]
    with working_precision(BITS):
        model = taylor_model(mu, law.point)
        place = acb(float(model.radius) * 0.99)
        exact = ball_function(mu, symbols.v, law.point)(place, False)
        assert model.ball(place, False).overlaps(exact)
        bare = type(model)(model.low, model.polynomial.truncate(20), 20, arb(0), model.radius, model.unit)
        assert not bare.ball(place, False).overlaps(exact)


@pytest.mark.parametrize("text", ["1/v", "log(v)", "0.3 + (1 - 2*exp(-v))/v", "v*log(v)/(v - v^2)", "exp(1/v)"])
def test_what_is_infinite_at_rest_has_no_series(text):
    with working_precision(BITS):
        assert taylor_model(ss.FrictionLaw(text).kinetic.segments[0][1], {}) is None


def test_the_radius_of_a_series_may_be_far_below_the_scales_of_arguments():
    """Here the logarithm ends 1/100 beyond rest, which no argument says."""
    v = symbols.v
    with working_precision(BITS):
        assert taylor_model(sp.log(1 + 100 * (1 - sp.exp(-v))) / v, {}) is not None


def test_a_series_holds_around_rest_as_far_as_its_function_allows():
    """That of a logarithm to a quarter of the distance at which it ends; one of an exponential on wider balls."""
    v = symbols.v
    with working_precision(BITS):
        assert taylor_model(sp.log(1 + v) / v, {}).radius >= 0.2
        assert balls_from_rest((1 - sp.exp(-v)) / v, {})(acb(arb(0.1, 0.11)), False).is_finite()

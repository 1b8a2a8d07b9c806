"""What mu has risen since mu(0+), against many digits: on a slow belt it is all that drives the mass."""

import mpmath
import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core.symbols import v
from stickslip_sym.model.at_rest import stable_difference

CLOSE = 2e-14  # relative: a few roundings of formulas of ten operations
SPEEDS = (1e-14, 3e-9, 5e-5, 0.3)
a, b, start = sp.symbols("a b start", positive=True)
NODES = [
    sp.exp(-a * v), a**v, sp.log(1 + v / a), sp.tanh(a * v), sp.tanh(a * (v - b)), sp.atan(v / a),
    sp.atan(a * v - b), sp.asinh(a * v), sp.asinh(v - b), sp.sinh(v + a), sp.cosh(a * v), sp.cosh(v - b),
    sp.sech(a * v), sp.sin(v + a), sp.cos(v + a), sp.sqrt(v), sp.sqrt(v + a), (v / a) ** b, (a + v) ** b,
    ((a + v) / 4) ** 20, (a + v) ** -3, 1 / (1 + v**2), v**3 - a * v, (a + v) ** sp.Rational(-2, 3),
]  # fmt: skip


def exact(expr, point, low, high):
    with mpmath.workdps(60):
        function = sp.lambdify([v, *point], expr, "mpmath")
        values = [mpmath.mpf(value) for value in point.values()]
        return function(mpmath.mpf(high), *values) - function(mpmath.mpf(low), *values)


@given(
    st.sampled_from(NODES), st.sampled_from(NODES),
    st.sampled_from([a + 2 * b, a * b, a / (2 + b**2), sp.exp(-a)]),
    st.floats(0.3, 2), st.floats(0.3, 2), st.booleans(),
)  # fmt: skip
def test_a_difference_keeps_its_digits(node, other, way, first, second, from_rest):
    """Sums, products, quotients and functions of the nodes, from 0 and from a speed above."""
    expr = way.xreplace({a: node, b: other})
    low = 0.0 if from_rest else 0.7
    point = {a: first, b: second}
    gained = sp.lambdify(
        [v, start, a, b], stable_difference(expr, v, sp.Integer(0) if from_rest else start), "math"
    )
    for high in (low + step for step in SPEEDS):
        true = exact(expr, point, low, high)
        parts = sum(abs(exact(part, point, low, high)) for part in (node, other))  # which may cancel, to any order
        error = abs(gained(high, low, *point.values()) - true)
        assert float(error) <= 1e-12 * float(abs(true)) + 1e-14 * float(parts)


def test_a_difference_of_values_loses_them():
    """The negative control."""
    plain, point = sp.lambdify([v, a], sp.exp(-a * v), "math"), {a: 0.7}
    true = exact(sp.exp(-a * v), point, 0.0, SPEEDS[0])
    assert abs(plain(SPEEDS[0], 0.7) - plain(0.0, 0.7) - true) > 1e-5 * abs(true)


def test_what_has_no_rule_or_value_is_subtracted():
    assert stable_difference(sp.erf(a * v), v, start) == sp.erf(a * v) - sp.erf(a * start)
    assert stable_difference(v * sp.log(v), v, sp.Integer(0)) is None
    law = ss.FrictionLaw("mu_s + v*log(v) - (v + b)^(1/2)").bind(mu_s=0.5, b=0)  # b is no 0 in the formula
    assert law.rises()[0][1](np.array(0.25)) == pytest.approx(0.25 * np.log(0.25) - 0.5, rel=1e-14)


def test_pieces_and_measured_points():
    """The pieces above the first count from mu(0+) as well, also where the law jumps."""
    points = [0, "1e-9", "2e-9", "5e-9", 1], ["0.5", "0.4999", "0.4997", "0.45", "0.3"]
    jumps = "Piecewise((0.5*exp(-v), v < 1e-9), (0.3 + 0.1*1e-9/v, v < 1e-3), (0.2, True))"
    for law in (ss.FrictionLaw.from_samples(*points), ss.FrictionLaw(jumps)):
        ends = [place for place, _ in law.rises()] + [1.0]
        function = law.function("mpmath")
        for low, high, (_, gained) in zip(ends, ends[1:], law.rises(), strict=False):
            for speed in np.linspace(low, high, 7)[1:-1]:
                with mpmath.workdps(60):
                    true = function(mpmath.mpf(speed)) - function(mpmath.mpf(0))
                assert gained(np.array(speed)) == pytest.approx(float(true), rel=CLOSE, abs=1e-22)

"""A refutation shows two values that differ; what is right is not refuted; lost digits are noticed."""

import random
import re

import mpmath
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.core.precision import ball_of_mpmath, working_precision
from stickslip_sym.core.symbols import V, u
from stickslip_sym.criteria.enclosure import average_enclosure
from stickslip_sym.formula.exact import formula_ball, to_digits
from stickslip_sym.formula.proof import gate
from stickslip_sym.formula.proof.proving import prove_equal
from support.sweeps import some, sweep

W = sp.Symbol("w", positive=True)


def test_right_and_tampered_integrals():
    """Kinks, logarithms and roots at the ends: never a wrong refutation, and every tampered value is refuted."""
    rng = random.Random(13)
    for _ in range(2):
        c, place = sp.Rational(rng.randint(1, 9), 7), sp.Rational(rng.randint(1, 9), 5)
        power = rng.choice([sp.Rational(-1, 2), sp.Rational(1, 3), 2])
        kinked = sp.Piecewise((c * u**power, u < place * W), (c * sp.log(u / W), True))
        end = sp.Min(place * W, 2 * V)
        low = c * end ** (power + 1) / (power + 1)
        high = c * (2 * V * (sp.log(2 * V / W) - 1) - end * (sp.log(end / W) - 1))
        integral = sp.Integral(kinked, (u, 0, 2 * V))
        assert prove_equal(integral, low + high).status is ss.Status.CHECKED
        verdict = prove_equal(integral, (low + high) * (1 + sp.Rational(1, 10**18)))
        assert verdict.status is ss.Status.REFUTED
        left, right = re.match(r"left (\S+), right (\S+) at ", verdict.evidence).groups()
        assert left != right


def test_a_formula_without_a_value_is_not_returned():
    """Its points with a value agree with the definition; for V > 1/2 there is none, as of 0 log(0)."""
    with pytest.raises(ss.NoClosedForm, match="refuted"):
        ss.derive("Piecewise((v, v < 1), (log(v - 1), True))", search=False)


def test_an_infinite_integral_is_not_refuted():
    x = sp.Symbol("x", real=True)
    assert prove_equal(sp.Integral(sp.exp(-(x**2)) * sp.cos(x), (x, 0, sp.oo)), V).status is ss.Status.ESTIMATED


def test_digits_lost_by_cancellation_are_noticed():
    """The shifted tanh at the point where 20 and 30 digits agreed on a wrong value."""
    form = ss.derive(ss.FrictionLaw("mu_k + (mu_s - mu_k)*tanh((v_1 - v)/w)"))
    values = {"V": "8.12003", "N": "53.9933", "mu_k": "0.00365727", "mu_s": "0.0014794", "v_1": "103.417"}
    assert float(form.evaluate(20, w="0.395005", **values)) == pytest.approx(-3.299041e-195, rel=1e-6)


@sweep("digits", [5, 20], 20)
def test_every_digit_is_right_at_extremes(digits):
    """Against the same formulas at 9000 digits, by a plain evaluation that bounds nothing."""
    x, y = sp.symbols("x y", positive=True)
    log = sp.log(1 + sp.exp(-x * y))
    pieces = [sp.exp(-x), sp.tanh(x / y), log, sp.sqrt(1 + x**2), sp.atan(y), sp.exp(-x - y)]
    rng = random.Random(digits)
    for _ in some(range(25), 12):
        first, second, third = rng.sample(pieces, 3)
        expr = (first * second - third * y + x) - (x + first * second) + rng.choice([0, 1]) * (sp.tanh(x) - 1)
        expr = expr + third * y if rng.random() < 0.3 else expr
        point = {s: sp.Rational(f"{10 ** rng.uniform(-2.5, 2.5):.4g}") for s in (x, y)}
        if expr.free_symbols - point.keys() or expr == 0:
            continue
        with mpmath.workdps(9000):
            expected = mpmath.mpmathify(function_of([x, y], expr, "mpmath")(*map(to_mpf, point.values())))
        got = to_digits(expr, point, digits)
        with mpmath.workdps(digits + 5):
            assert abs(got - expected) <= abs(expected) * mpmath.mpf(10) ** (1 - digits)


x, y = sp.symbols("x y", positive=True)
BY_MPMATH = {
    "hypergeometric": sp.hyper((sp.Rational(3, 4), sp.Rational(5, 4)), (sp.Rational(3, 2), 2), -x * sp.sqrt(x)),
    "digamma": sp.digamma(sp.sqrt(x)),
}


@pytest.mark.parametrize("kind", BY_MPMATH)
def test_mpmath_s_value_is_within_its_ball(kind):
    """Functions that Arb does not enclose there, of arguments that carry an error; a wrong value is outside."""
    expr = BY_MPMATH[kind] * sp.exp(-y) - y
    rng = random.Random(41)
    for _ in range(4):
        point = {x: sp.Rational(f"{10 ** rng.uniform(2, 3):.4g}"), y: sp.Rational(f"{rng.uniform(0.1, 1):.4g}")}
        with mpmath.workdps(60):
            right = function_of([x, y], expr, "mpmath")(*map(to_mpf, point.values()))
        with working_precision(120):
            value, alone = formula_ball(expr, point)
            assert not alone
            assert ball_of_mpmath(right, 0).real in value.real
            assert ball_of_mpmath(right * (1 + mpmath.mpf("1e-25")), 0).real not in value.real
        with mpmath.workdps(30):
            assert abs(to_digits(expr, point, 20) - right) <= abs(right) * mpmath.mpf("1e-20")


@pytest.mark.parametrize("error", [InputError, NotConverged])
@pytest.mark.parametrize(("fails", "status"), [(2, ss.Status.CHECKED), (1, ss.Status.ESTIMATED)])
def test_points_without_a_value_say_nothing(monkeypatch, error, fails, status):
    """Others are drawn in their place; with too few the formula is neither checked nor refuted."""
    calls = []

    def sometimes(*given):
        calls.append(given)
        if len(calls) % fails == 0:
            raise error("not here")
        return average_enclosure(*given)

    def fail(*_):
        raise error("not here")

    profile, closed = sp.exp(-symbols.v), -sp.exp(-V) + 1
    right = ss.derive(ss.FrictionLaw("exp(-v)")).averages[0][1].closed
    monkeypatch.setattr(gate, "average_enclosure", sometimes)
    monkeypatch.setattr(ss.quadrature, "average", fail)
    assert gate.verify(profile, ss.criteria.least_squares, right).status is status
    if status is ss.Status.CHECKED:
        assert gate.verify(profile, ss.criteria.least_squares, closed).status is ss.Status.REFUTED

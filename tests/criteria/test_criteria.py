"""A user's criterion: every way to its value agrees, or it is refused."""

import inspect
from functools import partial

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from support.exported_code import PROGRAMS, runs, values_of
from support.sweeps import sample, sweep

s = ss.symbols.s
R = sp.Rational
WEIGHTS = {
    "asymmetric": R(3, 4) * (1 - s**2) * (1 + s),
    "not 0 at the ends": R(3, 2) * s**2,
    "not 0 at one end, and negative": R(1, 2) - s,
}
LAWS = {
    "smooth": "mu_m + (mu_s - mu_m)*exp(-alpha*v)",
    "in pieces, with a jump": "Piecewise((mu_s, v < v_w), mu_m + (mu_s - mu_m)*exp(-v/v_w)/2)",
    "without a rule": "0.3*exp(-v)/(2 + tanh(v))",
    "a wave for ever": "0.3*exp(-sin(v)^2)",
}
VALUES = {"mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0, "v_w": 0.7}


@sample(1)
@sweep(
    ("weight", "law"), [(weight, law) for weight in WEIGHTS for law in LAWS],
    ("not 0 at the ends", "in pieces, with a jump"),
    ("asymmetric", "without a rule"),
)  # fmt: skip
def test_a_user_s_criterion_by_all_methods(weight, law, tmp_path):
    """Also as a method for thresholds and critical speeds, and as code in every language."""
    criterion = ss.Criterion(weight, WEIGHTS[weight], "nobody")
    law = ss.FrictionLaw(LAWS[law])
    law = law.bind(**{name: VALUES[name] for name in law.parameters})
    average = ss.slope_average(law, criterion)

    def threshold(**point):
        return ss.pure_slip_damping(law, **point, m=1, k=100, method=criterion).value

    def written(language, **point):
        numbers = [(VALUES | point)[name] for name in names]
        return values_of(language, average.code(language), [("damping", numbers)], tmp_path)[0]

    methods = [average, threshold]
    if law.parameters:  # what has no rule has no branches to be written
        form, module = ss.derive(law, criterion), {}
        assert f"-{criterion.label}}}" in ss.export_latex(form)
        methods += [form, lambda **point: float(form.evaluate(20, **point))]
        exec(average.code("python"), module)
        names = inspect.signature(module["damping"]).parameters
        methods += [partial(written, language) for language in filter(runs, PROGRAMS)]
    for V in (0.45, 3.0):
        expected = float(ss.quadrature.damping(law, criterion, V=V, N=2, digits=20))
        assert abs(expected) > 1e-3
        assert [method(V=V, N=2.0) for method in methods] == pytest.approx([expected] * len(methods), rel=1e-12)
    if weight == "asymmetric":
        (speed, *_) = ss.critical(law, "V", c=0.1, N=2.0, method=criterion)
        assert average(V=speed.value, N=2.0) == pytest.approx(0.1, rel=1e-9)


def test_random_weights_and_thin_layers():
    """Relative accuracy at low and high speeds: each weight vanishes at the ends in its own way."""
    rng = np.random.default_rng(3)
    law = ss.laws.exponential.typical()
    for _ in range(2):
        a, b, root = int(rng.integers(0, 3)), int(rng.integers(0, 3)), R(int(rng.integers(3, 9)), 2)
        shape = (1 + s) ** a * (1 - s) ** b * (s + root)
        criterion = ss.criteria.Criterion("random", shape / sp.integrate(sp.expand(shape), (s, -1, 1)), "seeded")
        moments = [sp.integrate(sp.expand(criterion.weight * (1 + s) ** k), (s, -1, 1)) for k in range(5)]
        assert [criterion.mean_power(k) for k in range(5)] == moments
        form = ss.derive(law, criterion)
        V = 10 ** rng.uniform(-6, 5, 8)
        expected = [float(form.evaluate(20, V=speed, N=1)) for speed in V]
        assert form(V=V, N=1.0) == pytest.approx(expected, rel=1e-13)
        assert float(ss.quadrature.damping(law, criterion, V=V[0], N=1, digits=17)) == pytest.approx(expected[0])


@pytest.mark.parametrize(
    ("weight", "message"),
    [
        (R(3, 4) * (1 - s**4), "integrates to 6/5.*multiply it by 5/6"),
        (s, "integrates to 0"),
        (sp.Symbol("q") / 2, "depends on q; it may hold s only"),
        (sp.cos(s) / (2 * sp.sin(1)), "must be a polynomial in s with rational coefficients"),
        (1 / (2 + s), "must be a polynomial in s"),
        (sp.oo, "must be a polynomial in s"),
        (s < 1, "is an expression in s"),
        (43 * s**42 / 2, "is of degree 42; take one of degree 40 at most"),
    ],
)
def test_a_weight_that_is_no_average_is_refused(weight, message):
    with pytest.raises(ss.InputError, match=message):
        ss.criteria.Criterion("mine", weight, "nobody")


def test_weights_are_of_degree_40_at_most():
    assert ss.criteria.Criterion("high", 41 * s**40 / 2, "nobody").weight == 41 * s**40 / 2


def test_a_logarithm_needs_a_weight_that_vanishes():
    law = ss.FrictionLaw("0.3 - 0.01*log(v/0.1)")
    flat = ss.criteria.Criterion("flat", sp.Integer(1) / 2, "nobody")
    with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
        ss.derive(law, flat)
    with pytest.raises(ss.InputError, match=r"infinite at v = 0\+"):
        ss.quadrature.damping(law, flat, V=1, N=1, digits=15)


def test_criteria_are_equal_by_their_weights():
    weight, source = R(5, 8) * (1 - s**2) * (1 + s**2), ss.criteria.least_squares.source
    mine = ss.Criterion("least_squares", weight, source)
    assert mine == ss.criteria.least_squares
    assert hash(mine) == hash(ss.criteria.least_squares)
    assert mine != ss.Criterion("least_squares", R(3, 4) * (1 - s**2), source)
    assert ss.criteria.equilibrium not in (mine, ss.criteria.harmonic)
    in_floats = ss.Criterion("mine", 0.75 * (1 - sp.Symbol("s") ** 2))  # and in the user's own s
    assert in_floats == ss.Criterion("mine", R(3, 4) * (1 - s**2))
    thirds = ss.Criterion("mine", 1 / 3 * sp.Symbol("s") ** 2 + (0.1 + 0.2) * sp.Symbol("s") + 7 / 18)
    assert thirds.weight == s**2 / 3 + R(3, 10) * s + R(7, 18)
    with pytest.raises(ss.InputError, match="is an expression in s, got str"):
        ss.Criterion("text", "__import__('os')")

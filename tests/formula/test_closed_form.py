"""Closed forms: proved, equal to the paper's, and the same number in every precision."""

import random

import mpmath
import numpy as np
import pytest
import sympy as sp
from forms import some

import stickslip_sym as ss
from derivations import paper
from stickslip_sym.formula.finding import rules
from stickslip_sym.formula.proof import gate
from stickslip_sym.formula.proof.proving import prove_equal

PRINTED = paper.equations()
PAPER = ["exponential", "polynomial"]  # the catalogue as a whole: test_catalogue.py
AGREED_DIGITS = 45
FLOAT_ERROR = 1e-13  # what a call promises


@pytest.fixture
def scene():
    """Twenty seeded scenes and parameters, log-uniform over four decades each."""
    rng = random.Random(16)

    def draw(names):
        return {name: f"{10 ** rng.uniform(-2, 2):.8g}" for name in names}

    return draw


@pytest.mark.parametrize(("name", "label"), [("exponential", "(17)"), ("polynomial", "(18)")])
def test_least_squares_is_the_paper_s(name, label):
    form = ss.derive(ss.laws.catalogue[name])
    assert prove_equal(form.expr, PRINTED[label]).status is ss.Status.PROVED
    assert form.verdict.status is ss.Status.PROVED
    assert "digits at 12 seeded points" in form.verdict.evidence


@pytest.mark.parametrize("criterion", ss.criteria.catalogue)
@pytest.mark.parametrize("name", PAPER)
def test_agrees_with_the_definition_to_45_digits(name, criterion, scene):
    """Enclosed in eight scenes; by quadrature, which takes longer, in two."""
    law = ss.laws.catalogue[name]
    form = ss.derive(law, criterion)
    for number in range(8):
        values = scene([*law.parameters, "V", "N"])
        place = {"V": values.pop("V"), "N": values.pop("N"), "digits": 50}
        bound = law.bind(**values)
        middle = ss.enclose(bound, criterion, **place).mid
        got = form.evaluate(**place, **values)
        with mpmath.workdps(50):
            exact = [mpmath.mpf(middle.numerator) / middle.denominator]
            if number % 4 == 0:
                exact.append(ss.quadrature.damping(bound, criterion, **place))
            for expected in exact:
                assert abs(got - expected) <= abs(expected) * mpmath.mpf(10) ** -AGREED_DIGITS


WRITTEN = {
    "a*exp(-p*v) + b*exp(-q*v)": "PROVED", "a*v^6*exp(-p*v)": "PROVED", "a/(1 + v/p) + b*v^2": "PROVED",
    "a*exp(-(v/p)^2) + b*tanh(v/q)": "PROVED", "a*exp(-p*(v + q))": "PROVED", "a*exp(-(p + q)*v)": "PROVED",
    "exp(-v)*exp(-p*v)": "PROVED", "(a + b*v)^3*exp(-p*(v + q))": "PROVED", "a*sqrt(v)": "PROVED",
    "a*v^p": "PROVED", "1/(v + p)^2": "PROVED", "mu_0 + a*exp(-v/p) + b*v*exp(-v/q) + d*v^2": "PROVED",
    "0.2 + 0.1*exp(-v/0.003) + 0.1*exp(-v/100)": "PROVED", "mu_m + d/(1 + (v/p)^3)": "PROVED",
    "mu_m + d/(1 + (v/p)^4)": "PROVED", "mu_m + d/(1 + (v/p)^1.7)": "PROVED", "mu_m + d/(1 + (v/p)^q)": "CHECKED",
    "mu_m + d*(1 + (v/p)^8)^(-1/8)": "PROVED",
}  # fmt: skip


@pytest.mark.parametrize(("text", "status"), some(WRITTEN.items(), 0, 1, 3, 6, 10, 12, 13, 14, 16))
def test_a_law_has_its_closed_form_and_a_call_all_its_digits(text, status):
    """At random parameters: of a thin layer nothing may be left at V, yet it carries up to the whole criterion."""
    form = ss.derive(ss.FrictionLaw(text))
    assert form.verdict.status.value == status
    rng = np.random.default_rng(5)
    exponents = {node.exp for node in form.law.expr.atoms(sp.Pow)}
    columns = {
        name: 10 ** (rng.uniform(0, 0.3, 12) if symbol in exponents else rng.uniform(-3, 3, 12))
        for name, symbol in form.arguments.items()
    }
    exact = [float(form.evaluate(20, **{name: column[i] for name, column in columns.items()})) for i in range(12)]
    assert form(**columns) == pytest.approx(exact, rel=FLOAT_ERROR)


def test_a_result_beyond_double_range_is_an_error():
    form = ss.derive(ss.laws.polynomial.typical())
    with pytest.raises(ss.InputError, match="beyond the range of float64"):
        form(V=1e200, N=9.81)


def test_a_parameter_of_zero():
    form = ss.derive(ss.laws.exponential.typical(mu_s="0.2"))
    assert form(V=0.5, N=9.81) == 0
    assert form.evaluate(40, V="0.5", N="9.81") == 0
    with pytest.raises(ss.InputError, match=r"divides by zero at alpha = 0"):
        form.evaluate(20, V="0.5", N="9.81", alpha=0, mu_s=1)


def test_wrong_arguments():
    form = ss.derive(ss.laws.exponential)
    good = {"V": 0.5, "N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
    assert form(**good) == pytest.approx(2.545949602905104, rel=1e-15)
    cases = {
        "no value for alpha; give alpha=...": {k: v for k, v in good.items() if k != "alpha"},
        "'mu_d' is not an argument of this closed form": good | {"mu_d": 0.3},
        "V = -0.5 must not be negative": good | {"V": [0.5, -0.5]},
        "N holds a value that is not finite": good | {"N": float("inf")},
        "alpha = 'fast' is not a number": good | {"alpha": "fast"},
        "the shapes do not broadcast": good | {"V": [1.0, 2.0], "N": [1.0, 2.0, 3.0]},
    }
    for message, arguments in cases.items():
        with pytest.raises(ss.InputError, match=message):
            form(**arguments)
    with pytest.raises(ss.InputError, match="V = -1 must not be negative"):
        form.evaluate(20, **good | {"V": -1})
    with pytest.raises(ss.InputError, match="digits = 0 is outside"):
        form.evaluate(0, **good)
    with pytest.raises(ss.InputError, match=r"no criterion 'least_square' .did you mean 'least_squares'"):
        ss.derive(ss.laws.exponential, "least_square")


def test_no_closed_form_names_the_term():
    with pytest.raises(ss.NoClosedForm, match=r"the term d\*tanh\(exp\(v\)\) has no closed form.*Take"):
        ss.derive(ss.FrictionLaw("mu_0 + d*tanh(exp(v))"))


@pytest.mark.parametrize(
    ("rule", "criterion", "factor"),
    [("antiderivative", "least_squares", -1), ("antiderivative", "least_squares", sp.exp(ss.symbols.V)),
     ("harmonic_average", "harmonic", 2)],
)  # fmt: skip
def test_a_wrong_rule_is_refuted_and_gives_no_value_either(fresh_averages, monkeypatch, rule, criterion, factor):
    right = getattr(rules, rule)
    monkeypatch.setattr(rules, rule, lambda *args: ("wrong", factor * right(*args)[1]))
    law = ss.laws.exponential.typical()
    with pytest.raises(ss.NoClosedForm, match="refuted"):
        ss.derive(law, criterion)
    exact = ss.quadrature.damping(law, criterion, V=0.5, N=9.81, digits=20)
    assert ss.slope_average(law, criterion)(V=0.5, N=9.81) == pytest.approx(float(exact), rel=1e-13)


ENDING = ["mu_s + d*log(1 - v/v_c)", "mu_s + d*v*log(1 - v/v_c)", "mu_s + d*sqrt(1 - v/v_c)"]


@pytest.mark.parametrize(
    ("text", "criterion"), some([(text, way) for text in ENDING for way in ("least_squares", "harmonic")], 0, 5)
)
def test_a_law_that_ends_at_a_speed(text, criterion):
    rng = np.random.default_rng(6)
    form = ss.derive(ss.FrictionLaw(text), criterion)
    for _ in range(6):
        values = {"mu_s": 0.4, "d": rng.uniform(0.05, 0.3), "v_c": 10 ** rng.uniform(-2, 2)}
        place = {"V": values["v_c"] * rng.uniform(0.001, 0.49), "N": rng.uniform(1, 9)}
        expected = float(ss.quadrature.damping(form.law.bind(**values), criterion, **place, digits=20))
        assert form(**place, **values) == pytest.approx(expected, rel=1e-12)
        assert ss.slope_average(form.law, criterion)(**place, **values) == pytest.approx(expected, rel=1e-12)
        assert float(form.evaluate(20, **place, **values)) == pytest.approx(expected, rel=1e-14)
    with pytest.raises(ss.InputError, match="ends at"):
        form(**values | {"V": 0.51 * values["v_c"], "N": 1.0})


def test_sympy_is_the_last_resort_and_is_stopped_in_time():
    import time

    said = []
    start = time.monotonic()
    with pytest.raises(ss.NoClosedForm):
        ss.derive(ss.FrictionLaw("a*cos(exp(v))"), time_limit=3, progress=said.append)
    assert time.monotonic() - start < 6
    assert any("SymPy's integrator for at most 2 s" in line for line in said)


def test_the_gate_alone_refutes(monkeypatch):
    """A step that proved nothing would not help a wrong result past the quadrature."""
    form = ss.derive(ss.laws.exponential)
    ((term, average),) = form.averages
    verdict = gate.verify(term.profile, form.criterion, average.closed * (1 + sp.Rational(1, 10**20)))
    assert verdict.status is ss.Status.REFUTED
    assert verdict.point


def test_latex_and_repr(law):
    form = ss.derive(law)
    assert form.latex().startswith("c = \\frac{")
    assert r"\mu_{\mathrm{s}} - \mu_{\mathrm{m}}" in form.latex()
    assert form._repr_latex_() == f"$\\displaystyle {form.latex()}$"
    assert repr(form) == f"ClosedForm: {law.name}, least_squares, PROVED"
    assert "\\mu(v) = " in law._repr_latex_()


def test_what_grows_at_rest_has_a_criterion_while_the_weight_vanishes_faster():
    """Be its factor a number or a parameter; the harmonic weight vanishes like a root, the other once."""
    rng = random.Random(4)
    for criterion, limit in (("harmonic", 0.5), ("least_squares", 1.0)):
        for slower in (True, False):
            order = sp.Rational(rng.randint(1, 9), 10) * sp.Rational(limit) + (0 if slower else sp.Rational(limit))
            for factor in ("0.3", "b"):
                law = ss.FrictionLaw(f"{factor}*v^(-{order})")
                if slower:
                    assert ss.derive(law, criterion).verdict.status is ss.Status.PROVED
                else:
                    with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
                        ss.derive(law, criterion)
        with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
            ss.derive(ss.FrictionLaw(f"b/v^({sp.Rational(limit)})"), criterion)


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf"), 1e300])
def test_a_time_limit_is_a_number_of_seconds(seconds):
    with pytest.raises(ss.InputError, match="is not a number of seconds from 0 to 86400"):
        ss.derive(ss.laws.exponential, time_limit=seconds)


def test_numbers_beyond_numpys_integers_stay_doubles():
    law = ss.FrictionLaw("0.3*exp(-1e20*v) + 1e-30*v")
    assert law.mu([1e-20, 1.0]) == pytest.approx([0.3 * np.exp(-1), 1e-30], rel=1e-15)

"""Closed forms: proved, equal to the paper's, the same number in every precision, and never a wrong one."""

import random
import sys
import time
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from derivations import paper
from stickslip_sym.formula.finding import rules, search
from stickslip_sym.formula.proof import gate
from stickslip_sym.formula.proof.proving import prove_equal
from support.sweeps import sample, some, sweep

PRINTED = paper.equations()
PAPER = ["exponential", "polynomial"]  # the catalogue as a whole: test_catalogue.py
AGREED_DIGITS = 45
FLOAT_ERROR = 1e-13  # what a call promises


# -- right -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "label"), [("exponential", "(17)"), ("polynomial", "(18)")])
def test_least_squares_is_the_paper_s(name, label):
    form = ss.derive(ss.laws.catalogue[name])
    assert prove_equal(form.expr, PRINTED[label]).status is ss.Status.PROVED
    assert form.verdict.status is ss.Status.PROVED
    assert "digits at 12 random points" in form.verdict.evidence


@sample(3)
@pytest.mark.parametrize("criterion", ss.criteria.catalogue)
@pytest.mark.parametrize("name", PAPER)
def test_agrees_with_the_definition_to_45_digits(name, criterion):
    """Enclosed at operating points over four decades; by quadrature, which takes longer, at two."""
    law, rng = ss.laws.catalogue[name], random.Random(16)
    form = ss.derive(law, criterion)
    for number in some(range(8), 4):
        values = {key: f"{10 ** rng.uniform(-2, 2):.8g}" for key in [*law.parameters, "V", "N"]}
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


LAWS = [
    "a*exp(-p*v) + b*exp(-q*v)", "a*v^6*exp(-p*v)", "a/(1 + v/p) + b*v^2", "a*exp(-(v/p)^2) + b*tanh(v/q)",
    "a*exp(-p*(v + q))", "a*exp(-(p + q)*v)", "exp(-v)*exp(-p*v)", "(a + b*v)^3*exp(-p*(v + q))", "a*v^delta",
    "0.2 + 0.1*exp(-v/0.003) + 0.1*exp(-v/100)", "a*sqrt(v)", "1/(v + p)^2", "mu_0 + a*exp(-v/p) + b*v*exp(-v/q)",
    "-v*log(v)", "mu_0 + (a - b)*log(v/v_0)", "Piecewise((f_0, v < v_w), (f_w + (f_0 - f_w)*v_w/v, True))",
    "mu_0 + d*log(1 + v^2/w^2)", "(1 + a*v)/(1 + b*v + d*v^2)", "log(1 + v/a)/(1 + v/b)", "a/(1 + (v/w)^3)",
    "a/(1 + (v/w)^4)", "a/(1 + (v/w)^delta)", "a*(1 + (v/w)^8)^(-1/8)", "Min(Max(a - b*v, 0), 1)",
    "Max(b, a*exp(-v/w))", "Max(b, a - v/w)", "Max(b, a - v^2)", "Max(b, w*log(1 + v/a))", "Abs(v - a + b)",
    "Min(3*v + a, v + b)", "mu_0 - a*(coth(v/w) - w/v)",
]  # fmt: skip
HARMONIC = ["b*log(1 + v/a)^2", "Piecewise((a + d*v^3, v < b), (a*b/v + d*b*v^2, True))", "a/sqrt(1 + (v/w)^2)",
            "mu_0 + a*log(v/w)"]  # fmt: skip
CHECKED = {HARMONIC[1], HARMONIC[3]}  # the others are proved


@sample(3)
@sweep(
    ("text", "criterion"),
    [*((text, "least_squares") for text in LAWS), *((text, "harmonic") for text in HARMONIC)],
    ("a*exp(-p*v) + b*exp(-q*v)", "least_squares"), ("exp(-v)*exp(-p*v)", "least_squares"),
    ("Piecewise((f_0, v < v_w), (f_w + (f_0 - f_w)*v_w/v, True))", "least_squares"),
    ("a/(1 + (v/w)^delta)", "least_squares"), ("Abs(v - a + b)", "least_squares"),
    ("b*log(1 + v/a)^2", "harmonic"),
)  # fmt: skip
def test_values_are_those_of_the_definition(text, criterion):
    """For random parameters over two decades, a call over six; kinks may lie below rest."""
    digits = 1e-14 if "(1 + (v/w)^" in text else FLOAT_ERROR
    form = ss.derive(text, criterion, search=False)
    assert form.verdict.status is (ss.Status.CHECKED if text in CHECKED else ss.Status.PROVED)
    rng = random.Random(7)
    for _ in some(range(6), 3):
        values = {name: f"{10 ** rng.uniform(-1, 1):.4g}" for name in form.arguments}
        place = {"V": values.pop("V"), "N": values.pop("N")}
        bound = form.law.bind(**values)
        if "*log(v" in text:  # infinite at rest: no enclosure
            expected = float(ss.quadrature.damping(bound, criterion, **place, digits=20))
        else:
            expected = float(ss.enclose(bound, criterion, **place, digits=18).mid)
        assert float(form.evaluate(20, **place, **values)) == pytest.approx(expected, rel=1e-14, abs=1e-15)
        floats = {name: float(value) for name, value in (place | values).items()}
        assert form(**floats) == pytest.approx(expected, rel=digits, abs=1e-15)
    for _ in range(12):
        wide = {
            name: 10 ** (rng.uniform(-0.5, 0.7) if name == "delta" else rng.uniform(-3, 3))
            for name in form.arguments
        }
        assert form(**wide) == pytest.approx(float(form.evaluate(20, **wide)), rel=digits)


ENDING = ["mu_s + d*log(1 - v/v_c)", "mu_s + d*v*log(1 - v/v_c)", "mu_s + d*sqrt(1 - v/v_c)"]


@sweep(
    ("text", "criterion"),
    [(text, way) for text in ENDING for way in ("least_squares", "harmonic")],
    (ENDING[0], "least_squares"),
)
def test_a_law_that_ends_at_a_speed(text, criterion):
    rng = np.random.default_rng(6)
    form = ss.derive(ss.FrictionLaw(text), criterion)
    for _ in some(range(6), 2):
        values = {"mu_s": 0.4, "d": rng.uniform(0.05, 0.3), "v_c": 10 ** rng.uniform(-2, 2)}
        place = {"V": values["v_c"] * rng.uniform(0.001, 0.49), "N": rng.uniform(1, 9)}
        expected = float(ss.quadrature.damping(form.law.bind(**values), criterion, **place, digits=20))
        assert form(**place, **values) == pytest.approx(expected, rel=1e-12)
        assert ss.slope_average(form.law, criterion)(**place, **values) == pytest.approx(expected, rel=1e-12)
        assert float(form.evaluate(20, **place, **values)) == pytest.approx(expected, rel=1e-14)
    with pytest.raises(ss.InputError, match="ends at"):
        form(**values | {"V": 0.51 * values["v_c"], "N": 1.0})


# -- refused -----------------------------------------------------------------------------------------


def test_digits_or_values_that_cannot_be_had():
    form = ss.derive(ss.laws.exponential)
    good = {"V": 0.5, "N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
    for digits, values, message in (
        (20, good | {"V": -1}, "V = -1 must not be negative"),
        (0, good, "digits = 0 is outside"),
    ):
        with pytest.raises(ss.InputError, match=message):
            form.evaluate(digits, **values)
    for changed in ({"mu_s": 0.2}, {"mu_s": 0.2, "alpha": 1.0}):
        assert form(**good | changed) == form.evaluate(40, **good | changed) == 0
    assert form(**good | {"alpha": 0.0}) == 0 == form.evaluate(20, **good | {"alpha": 0})
    with pytest.raises(ss.InputError, match=r"no criterion 'least_square' .did you mean 'least_squares'"):
        ss.derive(ss.laws.exponential, "least_square")
    with pytest.raises(ss.InputError, match="beyond the range of float64"):
        ss.derive(ss.laws.polynomial.typical())(V=1e200, N=9.81)


@sweep("ratio", ["11", "12.38", "13.08", "40"], "12.38", "40")
def test_digits_where_a_series_cancels_hundreds(ratio):
    """A 2F2 of -4 r^2 beside a fourth root, whose rational powers SymPy could not take apart."""
    law = ss.FrictionLaw("0.1*erf(v) + 0.3*asinh(v/2)")
    value = ss.derive(law, "harmonic").evaluate(30, V=ratio, N=1)
    assert float(value) == pytest.approx(float(ss.enclose(law, "harmonic", V=ratio, N=1, digits=20)), rel=1e-15)


def test_numbers_beyond_numpys_integers_stay_doubles():
    law = ss.FrictionLaw("0.3*exp(-1e20*v) + 1e-30*v")
    assert law.mu([1e-20, 1.0]) == pytest.approx([0.3 * np.exp(-1), 1e-30], rel=1e-15)


@sweep(
    ("criterion", "limit", "factor"),
    [("harmonic", 0.5, "0.3"), ("least_squares", 1.0, "b")],
    ("least_squares", 1.0, "b"),
)
def test_what_grows_at_rest_has_a_criterion_while_the_weight_vanishes_faster(criterion, limit, factor):
    """Be its factor a number or a parameter; the harmonic weight vanishes like a root, the other once."""
    rng = random.Random(4)
    for slower in (True, False):
        order = sp.Rational(rng.randint(1, 9), 10) * sp.Rational(limit) + (0 if slower else sp.Rational(limit))
        law = ss.FrictionLaw(f"{factor}*v^(-{order})")
        if slower:
            assert ss.derive(law, criterion).verdict.status is ss.Status.PROVED
        else:
            with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
                ss.derive(law, criterion)
    with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
        ss.derive(ss.FrictionLaw(f"{factor}/v^({sp.Rational(limit)})"), criterion)


# -- SymPy's integrator ------------------------------------------------------------------------------


@sweep(("criterion", "bound"), [("harmonic", 0.5), ("least_squares", 1.0)], ("least_squares", 1.0))
def test_a_divergent_integral_has_no_value(criterion, bound):
    """The average of v^-n exists for n below the order at which the weight vanishes at rest."""
    form = ss.derive(ss.FrictionLaw("mu_0 + mu_1*(v/v_1)^(-n)"), criterion)
    assert form.verdict.status is ss.Status.PROVED
    assert r"\quad n <" in form.latex()
    given = {"V": 0.5, "N": 1.0, "mu_0": 0.2, "mu_1": 0.3, "v_1": 1.0}
    below = form.law.bind(mu_0=0.2, mu_1=0.3, v_1=1, n=bound - 0.1)
    expected = float(ss.quadrature.damping(below, criterion, V=0.5, N=1, digits=15))
    assert form(**given, n=bound - 0.1) == pytest.approx(expected, rel=1e-12)
    for n in (bound, bound + 0.25, [bound - 0.1, bound + 0.1]):
        with pytest.raises(ss.InputError, match=r"exists for n < .* only"):
            form(**given, n=n)
    with pytest.raises(ss.InputError, match=r"exists for n < .* only"):
        form.evaluate(20, **given, n=bound + 0.25)


HOPELESS = "mu_0 + d*cos(exp(v))"


def test_sympy_is_the_last_resort_and_is_stopped_in_time(fresh_averages):
    said = []
    with pytest.raises(ss.NoClosedForm, match="found nothing in the steps that it is granted"):
        ss.derive(ss.FrictionLaw(HOPELESS), progress=said.append)
    assert any("SymPy's integrator" in line for line in said)
    start = time.monotonic()
    with pytest.raises(ss.NoClosedForm, match=r"time limit of 0\.5 s"):
        ss.derive(ss.FrictionLaw("mu_0 + d*cos(exp(v^2))"), time_limit=0.5)
    assert time.monotonic() - start < 5  # it is ended, however busy the machine is


@pytest.mark.parametrize(
    ("outcome", "message"),
    [
        (SimpleNamespace(returncode=1, stderr=b"Traceback\nImportError: no resource", stdout=b""),
         "SymPy's integrator failed without a look at it: its process ended with 1: ImportError: no resource"),
        (SimpleNamespace(returncode=-9, stderr=b"", stdout=b""), "its process ended with -9"),
    ],
)  # fmt: skip
def test_a_process_that_fails_is_no_missing_closed_form(fresh_averages, monkeypatch, outcome, message):
    monkeypatch.setattr(search.subprocess, "run", lambda *_, **__: outcome)
    with pytest.raises(ss.NoClosedForm, match=message) as caught:
        ss.derive(ss.FrictionLaw(HOPELESS))
    assert "found nothing" not in str(caught.value)


def test_what_became_of_a_search_is_said(fresh_averages, monkeypatch):
    class Broken:
        def doit(self):
            raise NotImplementedError("not today")

    assert search.carried_out(Broken()) == "gave up with NotImplementedError: not today"
    with pytest.raises(ss.NoClosedForm, match=r"the term d\*cos\(exp\(v\)\) has no .*was not asked.*Take"):
        ss.derive(ss.FrictionLaw(HOPELESS), search=False)
    x = sp.Symbol("x", positive=True)
    assert search.search_antiderivative(sp.cos(x), sp.Integer(1), x) == sp.sin(x)
    monkeypatch.setitem(sys.modules, "resource", None)  # as on a platform without limits of memory
    before = sys.gettrace()
    search.confine(10**9)
    sys.settrace(before)
    with pytest.raises(search.NothingFound, match="in the steps that it is granted"):
        search.search_antiderivative(sp.cos(x), sp.Integer(1), x, 100)


# -- never a wrong one -------------------------------------------------------------------------------


@pytest.mark.parametrize("off", [-1, 2, 1 + sp.Rational(1, 10**25), sp.exp(ss.symbols.V)])
@pytest.mark.parametrize(
    ("rule", "criterion"), [("antiderivative", "least_squares"), ("harmonic_average", "harmonic")]
)
def test_a_wrong_rule_gives_neither_a_form_nor_a_value(fresh_averages, monkeypatch, rule, criterion, off):
    right = getattr(rules, rule)
    monkeypatch.setattr(rules, rule, lambda *args: ("wrong", off * right(*args)[1]))
    with pytest.raises(ss.NoClosedForm, match="refuted"):
        ss.derive(ss.laws.exponential, criterion, search=False)
    if off == 2:
        law = ss.laws.exponential.typical()
        expected = float(ss.quadrature.damping(law, criterion, V=0.5, N=9.81, digits=20))
        assert ss.slope_average(law, criterion)(V=0.5, N=9.81) == pytest.approx(expected, rel=1e-13)


def test_the_gate_alone_refutes():
    """A step that proved nothing would not help a wrong result past the quadrature."""
    form = ss.derive(ss.laws.exponential)
    ((term, average),) = form.averages
    verdict = gate.verify(term.profile, form.criterion, average.closed * (1 + sp.Rational(1, 10**20)))
    assert verdict.status is ss.Status.REFUTED
    assert verdict.point


@pytest.mark.parametrize(
    "formula", ["v/(1 + v^2) + atan(v)", "v/(4 + v^2) - atan(v/2)/2", "v^2/(1 + v^2) + atan(v)"]
)
def test_terms_whose_variables_cancel_in_a_sum(formula):
    form = ss.derive(formula, "equilibrium")
    assert form.verdict.status is ss.Status.PROVED
    assert form(V=0.7, N=2.0) == pytest.approx(-2 * ss.FrictionLaw(formula).slope(0.7), rel=1e-13)


@sample(1)
@pytest.mark.parametrize("formula", ["mu_s - q*v**p", "mu_k + q*(1 + v/w)**p", "mu_s - q*v**p + a*v"])
def test_limits_that_hang_on_a_power_are_open(formula):
    form = ss.derive(formula)
    assert form.limits.far is None or not form.limits.far.has(sp.Limit)
    assert "Its limit for $V \\to \\infty$ was not found." in ss.export_latex(form)


@pytest.mark.parametrize("ratio", ["62", "1e5", "1e13"])
def test_a_value_far_out_takes_no_long(ratio):
    """The series of v erf(v/w) has as many terms as (V/w)^2; its definition is enclosed in no time."""
    form, start = ss.derive("v*erf(v/w)", "harmonic"), time.process_time()
    value = form.evaluate(25, V=ratio, N=2, w=1)
    assert time.process_time() - start < 3
    with mpmath.workdps(40):
        exact = mpmath.mpmathify(ss.enclose("v*erf(v)", "harmonic", V=ratio, N=2, digits=30).mid)
        assert abs(value - exact) < 1e-24
    assert form(V=float(ratio), N=2.0, w=1.0) == pytest.approx(float(value), rel=1e-14)

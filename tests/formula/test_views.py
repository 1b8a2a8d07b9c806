"""A closed form is the sum of its terms: every view of it is made of them, and none says something else."""

import random
import time
from dataclasses import replace
from types import SimpleNamespace

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core import deadline, symbols
from stickslip_sym.formula.average import Average, average_of_profile
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.output.content import content
from support.sweeps import sample, sweep

POINT = {"V": 0.5, "N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}


def views(form):
    """What each view of a closed form says at a point, or as text."""
    code = {}
    exec(form.code("python"), code)
    try:
        sensitivity = form.sensitivity("alpha").expr
    except ss.NoClosedForm:
        sensitivity = "refused"
    return {
        "expression": form.expr,
        "value of the expression": float(form.expr.subs({form.arguments[name]: x for name, x in POINT.items()})),
        "call": form(**POINT),
        "evaluate": float(form.evaluate(20, **POINT)),
        "latex": form.latex(),
        "python": float(code["damping"](**POINT)),
        "limit": form.limits.at_rest,
        "sensitivity": sensitivity,
        "verdict": form.verdict.status,
        "repr": repr(form),
    }


def test_every_view_changes_with_one_coefficient():
    form = ss.derive(ss.laws.exponential)
    constant, term = form.terms
    tampered = replace(form, terms=(constant, replace(term, amplitude=2 * term.amplitude)))
    right, wrong = views(form), views(tampered)
    assert all(right[name] != wrong[name] for name in right)
    for name in ("value of the expression", "call", "evaluate", "python"):
        assert right[name] == pytest.approx(2.545949602905104, rel=1e-12)
        assert wrong[name] == pytest.approx(2 * right[name], rel=1e-12)
    assert right["verdict"] is ss.Status.PROVED
    assert wrong["verdict"] is ss.Status.REFUTED
    assert "REFUTED" in "".join(tampered.code("c").splitlines()[:3])


# -- sensitivities -----------------------------------------------------------------------------------

CUBIC = ss.FrictionLaw("0.4 - a*v/w + b*(v/u)^3").bind(a=0.12, w=0.49, b=0.43, u=0.9)  # whose terms share a scale
SENSITIVE = [
    ("exponential", "least_squares", "alpha"), ("exponential", "harmonic", "alpha"),
    ("sech", "least_squares", "v_s"), ("arctangent", "harmonic", "v_s"), ("stribeck", "least_squares", "v_s"),
    ("polynomial", "harmonic", "mu_s"), ("hyperbolic", "equilibrium", "v_s"), (CUBIC, "harmonic", "a"),
    (CUBIC, "least_squares", "u"), (CUBIC, "equilibrium", "w"),
]  # fmt: skip


@sample(3)
@sweep(("law", "criterion", "parameter"), SENSITIVE, *SENSITIVE[:3], *SENSITIVE[6:9])
def test_a_sensitivity_is_the_quotient_of_differences(law, criterion, parameter):
    law = law if law is CUBIC else ss.laws.catalogue[law].typical()
    form = ss.derive(law, criterion)
    found = form.sensitivity(parameter)
    assert found.verdict.status is ss.Status.PROVED
    middle, step = sp.Rational(law.values[parameter]), sp.Rational(1, 10**12)
    with mpmath.workdps(40):
        sides = [form.evaluate(40, V="0.4", N=2, **{parameter: middle + side * step}) for side in (1, -1)]
        quotient = (sides[0] - sides[1]) / (2 * mpmath.mpf(int(step.p)) / int(step.q))
    assert found(V=0.4, N=2.0) == pytest.approx(float(quotient), rel=1e-12)
    assert abs(found(V=0.4, N=2.0)) > 1e-6


def test_a_sensitivity_needs_a_parameter_of_the_law():
    with pytest.raises(ss.InputError, match=r"'alfa' is no parameter of the law.*did you mean 'alpha'"):
        ss.derive(ss.laws.exponential).sensitivity("alfa")


def test_a_place_where_mu_jumps_has_no_sensitivity():
    """The derivative of mu does not see the jump move; the derivative of the formula does."""
    form = ss.derive(ss.FrictionLaw("Piecewise((a, v < v_1), (b, True))"))
    assert form.sensitivity("a").verdict.status is not ss.Status.REFUTED
    with pytest.raises(ss.NoClosedForm, match=r"refuted|no closed form"):
        form.sensitivity("v_1")


def test_a_refused_sensitivity_says_that_a_function_has_no_value():
    form = ss.derive("Piecewise((0.5 - v/5, v < a), (0.5 - a/5, True))", "harmonic", search=False)
    with pytest.raises(ss.NoClosedForm, match="a side is not finite at N = "):
        form.sensitivity("a")


# -- values and time ---------------------------------------------------------------------------------


def test_what_failed_is_not_tried_again(monkeypatch, fresh_averages):
    average = average_of_profile(sp.tanh(sp.exp(ss.symbols.v)), ss.criteria.least_squares)
    asked = []
    integrated = Average._integrated
    monkeypatch.setattr(Average, "_integrated", lambda *a, **k: asked.append(1) or integrated(*a, **k))
    for _ in range(3):
        with pytest.raises(ss.NoClosedForm, match="SymPy's integrator was not asked"):
            average.find()
    assert len(asked) == 1


def test_a_time_limit_ends_a_derivation(monkeypatch, fresh_averages):
    """The clock is moved on by each check of it."""
    now = time.monotonic()
    ticks = iter(np.arange(0.0, 1e6, 5.0))
    monkeypatch.setattr(deadline.time, "monotonic", lambda: now + next(ticks))
    with pytest.raises(
        ss.NoClosedForm, match=r"the time limit of 60 s was reached while (averaging|comparing|prov)"
    ):
        ss.derive(ss.laws.kragelskii, time_limit=60)


def test_a_notebook_names_the_law_of_a_form_or_shows_it():
    law = ss.laws.catalogue["linear"]
    assert ss.derive(law, "equilibrium")._repr_html_().count(law.text) == 0
    assert law.name in ss.derive(law, "equilibrium")._repr_html_()
    assert "p - q*v, equilibrium" in ss.derive(ss.FrictionLaw("p - q*v"), "equilibrium")._repr_html_()
    assert ss.criteria.find("equilibrium") is ss.criteria.equilibrium


def test_json_of_measured_points_is_a_table_of_cubics():
    rng = np.random.default_rng(16)
    v = [0.0, *np.sort(np.round(rng.uniform(0.1, 2, 4), 3))]
    form = ss.derive(ss.FrictionLaw.from_samples(v, np.round(rng.uniform(0.2, 0.5, 5), 3), extrapolate=True))
    said = content(form)
    assert said.keys() == {"cubics", "verdict"}
    table = said["cubics"]
    i = int(rng.integers(4))
    place, row = sp.Rational(table["places"][i]), map(sp.Rational, table["cubics"][i])
    x = float(v[i] + 0.3 * (v[i + 1] - v[i]))
    assert float(sum(c * (x - place) ** j for j, c in enumerate(row))) == pytest.approx(form.law.mu(x), rel=1e-13)
    assert len(str(said)) < 3000
    assert content(ss.derive("mu_s - a*v"))["expr"] == "N*a"


def test_a_decimal_in_a_sympy_formula_is_read_as_it_was_written():
    v, rng = sp.Symbol("v"), random.Random(16)
    for _ in range(20):
        numbers = [round(rng.uniform(0.001, 2), rng.randint(1, 6)) for _ in range(3)]
        a, b, c = numbers
        law = ss.FrictionLaw(a - b * sp.tanh(c * v))
        assert law.expr == ss.FrictionLaw(f"{a!r} - {b!r}*tanh({c!r}*v)").expr
    exact = sp.Float("0.1", 40)
    assert ss.FrictionLaw(exact + v).expr.subs(symbols.v, 0) == sp.Rational(exact) != sp.Rational(1, 10)


def test_roots_that_are_printed_alike_are_two():
    """Roots of one formula have one name until they get letters; the steps of a law of the catalogue have such."""
    derivation = ss.derive("rational", "harmonic").derivation
    assert derivation.latex().count("\\begin{equation*}") >= len(derivation.steps)


@pytest.mark.parametrize(
    ("law", "text"),
    [
        ("0.4 + 0.07*v/(0.3 + v) + v^2/7", "v**2/7 + 0.07*(v/(v + 0.3)) + 0.4"),
        ("33/20*v + 2.87 - 0.917*exp(-v/1.5)", "1.65*v + 2.87 - 0.917*exp(-2*v/3)"),
        ("33/20*v + 2/5", "33*v/20 + 2/5"),
    ],
)
def test_a_formula_with_decimals_has_no_tenths_beside_them(law, text):
    assert ss.FrictionLaw(law).text == text


@pytest.mark.parametrize(("shares", "operations", "apart"), [(3, 100, False), (4, 60, False), (4, 61, True)])
def test_shares_stay_apart_where_they_are_many_and_their_sum_is_long(shares, operations, apart):
    long = sp.Add(*sp.symbols(f"a:{operations + 1}"))
    form = SimpleNamespace(_shares=[None] * shares, _sum=long)
    assert long.count_ops() == operations
    assert ClosedForm._is_long.func(form) == apart

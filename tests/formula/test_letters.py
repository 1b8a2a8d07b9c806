"""Laws with numbers are derived in letters: no formula of one explodes, and the numbers come back."""

import random

import mpmath
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.symbols import v
from stickslip_sym.model.expression.letters import name_constants, substitute_numbers
from stickslip_sym.model.same_shape import law_of_same_shape
from support.sweeps import sample, some, sweep

FAMILIES = (
    "{0} + {1}*exp(-{2}*v)", "{0} + {1}*exp(-(v/{2})^{3})", "{0}*(1 + v/{1})^(-{2}) + {3}*v",
    "({0} + {1}*v)*exp(-v/{2})", "{0} + {1}*exp(-v/{2})*tanh(v/{3})", "{0} - {1}*log(1 + v/{2}) + {3}*v^1.5",
    "{0}*v^{1}*exp(-{2}*v)", "{0} + {1}/(1 + v/{2}) - {3}*atan(v/{0})",
)  # fmt: skip


def numbers(rng, count, digits):
    return [f"{rng.uniform(0.2, 2.5):.{digits}f}" for _ in range(count)]


@sample(2)
@sweep("family", range(len(FAMILIES)), 0, 1)
@pytest.mark.parametrize("digits", [4, 15])
def test_numbers_of_any_length_give_the_formula_in_letters(family, digits):
    formula = FAMILIES[family].format(*numbers(random.Random(family), 4, digits))
    form = ss.derive(formula, search=False)
    assert form.verdict.status is ss.Status.PROVED
    assert form.general is not None
    assert not [n for n in form.general.expr.atoms(sp.Rational) if max(abs(n.p), n.q) > 1000]
    assert sp.expand(substitute_numbers(form.general.law.expr, form.meanings) - form.law.expr) == 0
    expected = ss.quadrature.damping(form.law, "least_squares", V="0.7", N=3, digits=30)
    assert abs(form.evaluate(30, V="0.7", N=3) / expected - 1) < 1e-27
    assert form(V=0.7, N=3.0) == pytest.approx(float(expected), rel=1e-12)
    assert ss.slope_average(formula)(V=0.7, N=3.0) == form(V=0.7, N=3.0)


NAMED = ("exponential", "stribeck_viscous", "logarithmic", "tanh", "kragelskii", "hyperbolic")


@sweep("name", NAMED, "exponential", "stribeck_viscous", "kragelskii")
def test_letters_are_those_of_the_catalogues_law_of_the_same_shape(name):
    law, rng = ss.laws[name], random.Random(name)
    values = {p: str(rng.randint(1001, 1999) / 2000 + (p == "mu_s")) for p in law.parameters}
    numbers_of = {law.parameters[p].symbol: sp.Rational(value) for p, value in values.items()}
    special = ss.FrictionLaw(substitute_numbers(law.expr, numbers_of))
    assert special.parameters == {}
    found = law_of_same_shape(special)
    assert found is not None
    assert found == (law, numbers_of)
    # What is one part of another shape is not taken for it.
    assert law_of_same_shape(ss.FrictionLaw(special.expr + sp.asin(1 / (2 + v)) / 9)) is None


def test_a_letter_is_one_number_wherever_it_stands():
    found = name_constants(ss.FrictionLaw("0.123 + 0.456*exp(-v/0.789)*v^1.23456 - 0.456*tanh(v/0.789)").expr)
    assert sorted(map(float, found.meanings.values())) == [0.123, 0.456, 0.789, 1.23456]


@mpmath.workdps(30)
def test_a_sum_of_parameters_beside_the_speed_is_one_letter():
    form = ss.derive("mu_0 + d*exp(-(a_1 + a_2*P + a_3*P^2)*v)")
    assert form.verdict.status is ss.Status.PROVED
    assert list(form.meanings.values()) == [sp.sympify(1) * sum(
        form.arguments[a] * form.arguments["P"] ** n for n, a in enumerate(("a_1", "a_2", "a_3"))
    )]  # fmt: skip
    assert set(form.arguments) == {"V", "N", "mu_0", "d", "a_1", "a_2", "a_3", "P"}
    derivative = form.sensitivity("a_2")
    h = sp.Rational(1, 10**12)
    at = {"V": "0.5", "N": 2, "mu_0": "0.2", "d": "0.3", "a_1": 1, "a_3": "0.5", "P": 2}
    slope = (form.evaluate(40, a_2=1 + h, **at) - form.evaluate(40, a_2=1 - h, **at)) / (2 * float(h))
    del at["mu_0"]
    assert float(derivative.evaluate(20, a_2=1, **at)) == pytest.approx(float(slope), rel=1e-9)


@pytest.mark.parametrize("formula", ["0.1234/(1 + 0.345*v + 0.789*v^2)", "0.5 + 0.1*v - 0.0321*v^3"])
def test_numbers_that_decide_stay(formula):
    """Of the sign of a discriminant, and of a polynomial, which rounds as one term."""
    law = ss.FrictionLaw(formula)
    assert not any(term.shapes for term in law.terms)
    assert ss.derive(law).verdict.status is ss.Status.PROVED


@pytest.mark.parametrize("order", ["0.8123456", "0.5000001"])
def test_an_exponent_too_low_for_the_weight_is_refused_as_a_number_is(order):
    for formula in some((f"0.3*exp(-v)*v^(-{order})", f"v^(-{order})"), 1):
        with pytest.raises(ss.NoClosedForm, match=r"not integrable at v = 0\+"):
            ss.derive(formula, "harmonic")
        with pytest.raises(ss.InputError, match="has no value"):
            ss.slope_average(formula, "harmonic")(V=1.0, N=1.0)
        assert ss.derive(formula, "least_squares").verdict.status is ss.Status.PROVED


def test_long_numbers_are_printed_as_letters_with_their_values():
    form = ss.derive("0.2134 + 0.3127*exp(-4.713*v)")
    shown, letters = form.readable
    assert shown is form.general
    values = {str(letter): str(value) for letter, value in letters.items()}
    assert values == {"mu_s": "5261/10000", "mu_m": "1067/5000", "alpha": "4713/1000"}  # as of `exponential`
    text = ss.export_latex(form)
    assert "where $" in text
    assert "4.713" in text
    assert not ss.derive("0.2 + 0.3*exp(-v)").readable[1]

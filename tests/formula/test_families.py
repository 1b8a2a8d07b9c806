"""Families of laws that have closed forms: each is found by a rule, proved or checked, and has the right value."""

import pytest

import stickslip_sym as ss
from support.sweeps import sample, some, sweep

PROVED = {
    "(1 - exp(-v/v_w))/v": {"v_w": "0.3"},
    "A*exp(-(v_0/v)^(1/3))": {"A": "0.5", "v_0": "0.3"},
    "A*exp(-v_0/v^n)": {"A": "0.5", "v_0": "0.3", "n": "0.7"},
    "mu_0 + a*exp(-b*v)*cos(w*v + f)": {"mu_0": "0.2", "a": "0.1", "b": "0.5", "w": 2, "f": "0.3"},
    "0.3 + 0.1*exp(-0.5*v)*sin(0.5*v)": {},
    "a*exp(-b*v)*sin(w*v)^2": {"a": "0.1", "b": "0.5", "w": 2},
    "a*v*exp(-b*v)*sin(v)*cos(3*v)": {"a": "0.1", "b": "0.5"},
    "a*sin(w*v)^3": {"a": "0.1", "w": 2},
    "a*exp(-b*v)*log(1 + v/v_0)": {"a": "0.1", "b": "0.5", "v_0": "0.2"},
    "a*exp(-b*v)*(1 + v/v_0)^(-1.001)": {"a": "0.1", "b": "0.5", "v_0": "0.2"},
    "a*exp(-b*v)*(1 + v/v_0)^p": {"a": "0.1", "b": "0.5", "v_0": "0.2", "p": "0.4"},
    "a*log(1 + exp(-v/v_0))": {"a": "0.1", "v_0": "0.2"},
    "a*log(1 + 3*exp(v/v_0))": {"a": "0.1", "v_0": "0.2"},
    "a*log(cosh(v/v_0))": {"a": "0.1", "v_0": "0.2"},
    "sqrt((v - v_0)^2 + w^2)": {"v_0": "0.3", "w": "0.2"},
    "a/((v - v_0)^2 + w^2)": {"a": "0.1", "v_0": "0.3", "w": "0.2"},
    "a*((1 + v/v_1)*(1 + v/v_2))^(-1/2)": {"a": "0.1", "v_1": "0.5", "v_2": "0.2"},
    "a*sqrt(1 + v/v_1)*(1 + v/v_2)^(-1/2)": {"a": "0.1", "v_1": "0.5", "v_2": "0.2"},
    "A/(a + b*v^(-1/2) + d/v)": {"A": "0.5", "a": 1, "b": "0.2", "d": "0.3"},
    "A/(1 + b*v^(1/3))": {"A": "0.5", "b": "0.2"},
    "a*exp(v/w)*erfc(sqrt(v/w))": {"a": "0.5", "w": "0.3"},
    "a*exp(-v/w)*erf(sqrt(v/u))": {"a": "0.5", "w": "0.3", "u": "0.4"},
    "mu_0/(1 + (v/v_s)^delta)": {"mu_0": "0.5", "v_s": "0.3", "delta": "1.7"},
    "a/(b + d*v + f*v^2)": {"a": "0.5", "b": "0.3", "d": "1.7", "f": "0.2"},
    "A*exp(-q^2*log(v/v_m)^2)": {"A": "0.3", "q": "1.2", "v_m": "0.4"},
}
"""Formulas with values of their parameters."""
ENDING = {
    "sqrt(q/log(A/v))": {"q": "0.1", "A": 9},
    "a*sqrt(1 - (v/v_m)^2)": {"a": "0.4", "v_m": 3},
}
"""The same of laws that end at a slip speed."""
DIGITS = 25
SPEEDS = "0.7", "0.013"  # of the belt


def assert_value(form, values, V):
    law = form.law.bind(**values)
    expected = ss.quadrature.damping(law, form.criterion, V=V, N=3, digits=40)
    assert abs(form.evaluate(DIGITS + 5, V=V, N=3, **values) / expected - 1) < 10**-DIGITS
    floats = {name: float(value) for name, value in values.items()}
    assert form(V=float(V), N=3.0, **floats) == pytest.approx(float(expected), rel=1e-12)


@sample(3)
@sweep("formula", list(PROVED), *list(PROVED)[::4])
def test_a_family_with_a_closed_form_is_proved(formula):
    form = ss.derive(formula, search=False)
    assert form.verdict.status is ss.Status.PROVED, form.verdict
    for V in some(SPEEDS, 1):
        assert_value(form, PROVED[formula], V)


@sample(1)
@pytest.mark.parametrize(("criterion", "status"), [("least_squares", "PROVED"), ("harmonic", "CHECKED")])
def test_what_is_finite_together_is_averaged_together(criterion, status):
    form = ss.derive("a*(exp(-v/v_1) - exp(-v/v_2))/v", criterion, search=False)
    assert form.verdict.status is ss.Status[status]
    for V in some(SPEEDS, 1):
        assert_value(form, {"a": "0.1", "v_1": "0.5", "v_2": "0.2"}, V)


@sample(1)
@pytest.mark.parametrize("formula", ENDING)
def test_a_law_that_ends_is_proved_below_its_end(formula):
    form = ss.derive(formula, search=False)
    assert form.verdict.status is ss.Status.PROVED
    for V in some(("0.7", "0.05"), 1):
        assert_value(form, ENDING[formula], V)
    (relation,) = form.domain
    assert relation.rhs == 0
    with pytest.raises(ss.InputError, match="mu ends, or has a pole, before; take a lower speed"):
        form.evaluate(20, V=9, N=1, **ENDING[formula])


@sample(1)
@pytest.mark.parametrize(("criterion", "status"), [("least_squares", "PROVED"), ("harmonic", "CHECKED")])
def test_the_sine_integral(criterion, status):
    form = ss.derive("mu_0 + a*sinc(v/w)", criterion, search=False)
    assert form.verdict.status is ss.Status[status]
    for V in some(SPEEDS, 1):
        assert_value(form, {"mu_0": "0.3", "a": "0.1", "w": "0.2"}, V)
    if status == "PROVED":
        exec(form.certificate(), {"__name__": "page"})


def test_a_damped_wave_has_a_harmonic_average_by_bessel_functions_of_a_complex_argument():
    formula = "mu_0 + a*exp(-b*v)*cos(w*v + f)"
    form = ss.derive(formula, "harmonic", search=False)
    assert form.verdict.status is ss.Status.CHECKED
    for V in some(SPEEDS, 1):
        assert_value(form, PROVED[formula], V)


@pytest.mark.parametrize(
    ("formula", "simple"),
    [("mu_0*(sin(v)^2 + cos(v)^2)", "mu_0"), ("mu_0*sin(b*v)^2 + mu_0*cos(b*v)^2 - a*v", "mu_0 - a*v"),
     ("a*cosh(v)^2 - a*sinh(v)^2", "a"), ("sin(v)^2 + cos(2*v)^2", "sin(v)^2 + cos(2*v)^2")],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:the formula has no v")
def test_a_sum_that_is_one_is_seen(formula, simple):
    assert ss.FrictionLaw(formula).text == ss.FrictionLaw(simple).text

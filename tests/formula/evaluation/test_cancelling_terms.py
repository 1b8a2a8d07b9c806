"""Laws whose terms are infinite alone and finite together: call, enclosure, quadrature and code say one thing."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.model.terms import terms_of
from support.exported_code import values_of
from support.sweeps import fewer, sample, sweep

EPS = np.finfo(float).eps
FINITE_TOGETHER = {
    "mu_k + d*(1 - exp(-v/w))*w/v": "at rest",
    "mu_k + d*(sqrt(1 + v/w) - 1)*w/v": "at rest",
    "mu_k + d*(exp(-v/w) - exp(-2*v/w))*w/v": "at rest",
    "mu_k + d*(v/w)/(exp(v/w) - 1)": "one term",
    "mu_k + d*log(1 + v/w)*w/v": "one term",
    "d*(v/w)*(1 - exp(-w/v))": "far out",
}


def law_of(text, **values):
    law = ss.FrictionLaw(text)
    return law.bind(**{name: value for name, value in values.items() if name in law.parameters})


@sample(1)
@sweep(
    ("text", "criterion"), [(text, name) for text in FINITE_TOGETHER for name in ("least_squares", "harmonic")],
    ("mu_k + d*(1 - exp(-v/w))*w/v", "harmonic"), ("d*(v/w)*(1 - exp(-w/v))", "least_squares"),
)  # fmt: skip
@fewer(3)
@given(width=st.floats(-2, 1), ratio=st.floats(-9, 9))
def test_call_enclosure_and_code_agree(text, criterion, width, ratio):
    """Over 18 decades of V over the width, within 16 units of the larger of c and N <|mu'|>."""
    law = law_of(text, mu_k=0.2, d=0.3, w=10.0**width)
    average, V = ss.slope_average(law, criterion), 10.0 ** (width + ratio)
    exact = float(ss.enclose(law, criterion, V=V, N=2.0, digits=17))
    assert average(V=V, N=2.0) == pytest.approx(exact, rel=16 * EPS)
    numbers = [{"V": V, "N": 2.0, "mu_k": 0.2, "d": 0.3, "w": 10.0**width}[name] for name in average.arguments]
    (written,) = values_of("python", average.code("python"), [("damping", numbers)], None)
    assert written == pytest.approx(exact, rel=16 * EPS)


@pytest.mark.parametrize("text", FINITE_TOGETHER)
def test_terms_that_cancel_are_one_and_the_sum_is_the_law(text):
    law = ss.FrictionLaw(text)
    varying = [term for term in law.terms if term.profile.has(ss.symbols.v)]
    assert len(varying) == 1
    point = {symbol: 0.3 + 0.2 * k for k, symbol in enumerate(sorted(law.expr.free_symbols, key=str))}
    total = sum(term.expr.evalf(20, subs=point) for term in law.terms)
    assert float(total - law.expr.evalf(20, subs=point)) == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("text", ["a/v + b*exp(-v)/v", "a/sqrt(v) + b*(exp(-v) - 1)/v", "a*v - b*v^2*exp(-1/v)"])
def test_terms_that_do_not_cancel_are_parted(text):
    assert len(terms_of(ss.FrictionLaw(text).expr)) == 2


@sweep(
    ("text", "criterion"),
    [(text, name) for text in FINITE_TOGETHER for name in ("least_squares", "harmonic")],
    ("mu_k + d*(1 - exp(-v/w))*w/v", "harmonic"),
    ("mu_k + d*(v/w)/(exp(v/w) - 1)", "least_squares"),
)
def test_quadrature_has_the_digits_that_terms_lose_at_rest(text, criterion):
    law = law_of(text, mu_k="0.2", d="0.3", w="0.4")
    exact = ss.enclose(law, criterion, V="0.5", N=1, digits=30)
    value = ss.quadrature.damping(law, criterion, V="0.5", N=1, digits=25)
    binary = Fraction(int(value.man)) * Fraction(2) ** int(value.exp)
    assert abs(binary - exact.mid) <= abs(exact.mid) / 10**24


def test_a_threshold_of_a_law_that_is_finite_at_rest():
    law = ss.FrictionLaw("0.3 + 0.1*(1 - exp(-v))/v")
    threshold = ss.pure_slip_damping(law, V=0.5, N=10, m=1, k=100)
    assert threshold.value == pytest.approx(ss.slope_average(law, "harmonic")(V=0.5, N=10), rel=1e-3)


# -- what was wrong, or refused in words that were not true ------------------------------------------


def test_what_is_not_enclosed_is_no_zero():
    law = "0.5*exp((v/0.1)^2)*erfc(v/0.1)"
    assert ss.slope_average(law)(V=2, N=1) == pytest.approx(0.03744470781436335, rel=1e-14)


def test_a_wide_enclosure_beyond_floats_is_shown():
    assert str(Enclosure.of(-(10**400), 10**401)) == "[-1.00e+400, 1.00e+401]"
    assert str(Enclosure.of(-1, 2)) == "[-1.00, 2.00]"


@sweep(
    ("criterion", "width"),
    [("least_squares", 3e-10), ("harmonic", 3e-10), ("harmonic", 1e-7)],
    ("harmonic", 3e-10),
)
@fewer(1)
@given(V=st.floats(0.2, 2.0))
def test_a_narrow_peak_is_no_end_of_a_law(criterion, width, V):
    law = f"0.5 + 0.1/(1 + ((v - 0.18)/{width})^2)"
    exact = ss.enclose(law, criterion, V=V, N=1, digits=17)
    assert ss.slope_average(law, criterion)(V=V, N=1) == pytest.approx(float(exact), rel=1e-13, abs=1e-30)


def test_a_pole_of_even_order_is_an_end():
    with pytest.raises(ss.InputError, match=r"ends at v = 0\.5"):
        ss.slope_average("0.3 + 0.1/(v - 0.5)^2")(V=0.5, N=1)


def test_a_logarithm_over_v_has_an_average():
    law = law_of("mu_k + d*log(1 + v/v_0)*v_0/v", mu_k=0.2, d=0.3, v_0=0.4)
    exact = float(ss.enclose(law, V=0.5, N=1, digits=17))
    assert math.isclose(ss.slope_average(law)(V=0.5, N=1), exact, rel_tol=8 * EPS)


WITHOUT_SERIES = [
    ("0.2 + 0.6*exp(-(0.3*log(v/0.005)/log(10))^2)", "equilibrium", 1e-9, 1e6),
    ("0.2 + 0.6*exp(-(0.3*log(v/0.005)/log(10))^2)", "harmonic", 1e-9, 1e6),
    ("0.3 + 0.2/(1 + log(v/0.1)^2)", "equilibrium", 1e-9, 1e6),
    ("0.3 + 0.1*(v/0.2)/(exp(v/0.2) - 1)", "equilibrium", 1e-9, 50.0),
    ("0.3 + 0.1*(coth(v/0.1) - 0.1/v)", "harmonic", 1e-9, 1e6),
    ("0.5*exp((v/0.1)^2)*erfc(v/0.1)", "harmonic", 1e-9, 0.7),
]


@sample(1)
@sweep(("text", "criterion", "low", "high"), WITHOUT_SERIES, WITHOUT_SERIES[0], WITHOUT_SERIES[3])
def test_code_of_laws_with_logarithms_is_written(text, criterion, low, high):
    """Over decades about the law's own speed; farther out code gives NaN, and a call asks balls."""
    average = ss.slope_average(text, criterion)
    exec(average.code("python"), module := {})
    V = np.geomspace(low, high, 7)
    exact = [float(ss.enclose(text, criterion, V=float(x), N=2.0, digits=17)) for x in V]
    assert module["damping"](V, 2.0) == pytest.approx(exact, rel=16 * EPS)


def test_a_product_of_what_overflows_has_floats():
    """exp(x^2) erfc(x) beyond x = 27, by its asymptotic series; a product of other arguments stays as it is."""
    law, x = ss.FrictionLaw("0.5*exp(v^2)*erfc(v)"), 400.0
    assert law.mu(x) == pytest.approx(0.5 / math.sqrt(math.pi) / x * (1 - 0.5 / x**2), rel=1e-9)
    other = ss.FrictionLaw("0.5*exp(v)*erfc(v)")
    assert other.mu(2.0) == pytest.approx(0.5 * math.exp(2.0) * math.erfc(2.0), rel=1e-14)

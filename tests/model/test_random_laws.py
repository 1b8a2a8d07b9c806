"""What holds of every law with values: random laws of the catalogue, random formulas, kinks."""

import json

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.model.law_content import law_in, law_out, text_of_law
from support.strategies import formulas, laws

SPEEDS = np.array([1e-13, 1e-9, 1e-3, 0.05, 0.3, 1.0, 2.7])


@given(laws(static=True))
def test_a_law_is_kept_whole_as_text(law):
    assert law.mu(1e-12) == pytest.approx(law.onset, abs=1e-3)
    again = law_in(json.loads(text_of_law(law)))
    assert again == law
    assert again.mu(SPEEDS) == pytest.approx(law.mu(SPEEDS), rel=1e-14)
    assert again.static_value == law.static_value
    content = law_out(law)
    if "formula" in content:  # another formula is another law
        assert law_in(content | {"formula": content["formula"] + " + 0.001*v"}) != law


LINES = ", ".join(f"0.5 + a*({i * i}/50 - {i}/7*v)" for i in range(9))


@pytest.mark.parametrize(
    "formula",
    ["Min(Max(mu_s - a*v, mu_d), 1)", f"Max({LINES})",
     "mu_s" + "".join(f" + 0.01*Abs(v - 0.{place})" for place in range(10, 49)),
     "*".join(f"(1 + 0.1*Max(v - v_{i}, 0))" for i in range(1, 5))],
)  # fmt: skip
def test_a_saved_law_loads_as_equal(formula, tmp_path):
    law = ss.FrictionLaw(formula)
    ss.save(law, tmp_path / "law.json")
    assert ss.load(tmp_path / "law.json") == law


ORDERS = st.recursive(
    st.sampled_from("abdf"),
    lambda parts: st.builds("{}({}, {})".format, st.sampled_from(["Min", "Max"]), parts, parts),
    max_leaves=6,
)


@given(ORDERS, ORDERS, st.lists(st.floats(0.1, 2), min_size=4, max_size=4))
def test_nested_min_and_max_of_parameters(onset, level, values):
    law = ss.FrictionLaw(f"Max({onset} - 0.5*v, {level})")
    assert law_in(law_out(law)) == law
    point = dict(zip("abdf", values, strict=True))
    high, low = (eval(text, {"Min": min, "Max": max} | point) for text in (onset, level))
    bound = law.bind(**{name: point[name] for name in law.parameters})
    assert bound.mu(SPEEDS) == pytest.approx(np.maximum(high - 0.5 * SPEEDS, low), rel=1e-13, abs=1e-15)
    assert [float(kink) for kink in bound.kinks()] == pytest.approx([2 * (high - low)] if high > low else [])


@given(laws())
def test_rises_and_slopes_are_those_of_the_coefficient(law):
    begins = [begin for begin, _ in law.rises()]
    assert begins == sorted(begins)
    assert begins[0] == 0
    for v in SPEEDS:
        rise = [function for begin, function in law.rises() if begin < v][-1](np.array(v))
        with mpmath.workdps(40):
            mu = law.function("mpmath")
            exact = mu(mpmath.mpf(v)) - mu(mpmath.mpf(10) ** -38)
            step = mpmath.mpf(v) * mpmath.mpf("1e-12")
            slope = (mu(mpmath.mpf(v) + step) - mu(mpmath.mpf(v) - step)) / (2 * step)
        assert rise == pytest.approx(float(exact), rel=1e-12, abs=1e-17)
        if not any(abs(float(kink) / v - 1) < 1e-9 for kink in law.kinks()):
            assert law.slope(v) == pytest.approx(float(slope), rel=1e-9, abs=1e-12)


@given(formulas(), st.sampled_from([" ", "  ", "\n"]))
def test_spaces_and_signs_of_products_mean_nothing(formula, blank):
    law = ss.FrictionLaw(formula)
    for sign, spelled in (("*", f"{blank}*{blank}"), ("*", "·"), ("^", "**")):
        assert ss.FrictionLaw(formula.replace(sign, spelled)).expr == law.expr
    assert ss.FrictionLaw(law.text).mu(SPEEDS) == pytest.approx(law.mu(SPEEDS), rel=1e-13)
    assert ss.FrictionLaw(formula.replace("0.5", "0.6", 1)) != law

"""Bounds on what is read: an input on either side of each."""

import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core import symbols
from stickslip_sym.model.expression.letters import name_constants
from stickslip_sym.model.expression.parsing import parse_expression

v = symbols.v


@pytest.mark.parametrize(
    ("allowed", "refused", "why"),
    [("0.3".ljust(2000), "0.3".ljust(2001), "at most 2000 are allowed"),
     (f"0.{'1' * 398}", f"0.{'1' * 399}", "at most 400 characters"),
     ("sin(1000000)", "sin(1000001)", "at most 1000000 in size"),
     ("(10^20)^60", "(10^20)^64", "grows too large"),
     ("sqrt(1e76 + 1)", "sqrt(1e78 + 1)", "too many digits")],
)  # fmt: skip
def test_numbers_and_texts(allowed, refused, why):
    assert parse_expression(allowed, sp.Symbol).is_number
    with pytest.raises(ss.InputError, match=why):
        parse_expression(refused, sp.Symbol)


def test_a_power_of_a_sum_that_later_algebra_cannot_hold():
    with pytest.raises(ss.InputError, match="too high a power of a sum"):
        ss.FrictionLaw("(a + v)^17")


@pytest.mark.parametrize(
    ("plain", "long"),
    [(sp.exp(-v) / 100, sp.exp(-v) / 101), (v ** sp.Rational(1, 6), v ** sp.Rational(1, 7)),
     (sp.exp(-v) / 101 + 9 * v**2, sp.exp(-v) / 101 + 10 * v**2)],
)  # fmt: skip
def test_a_number_that_is_not_seen_at_a_glance_gets_a_letter(plain, long):
    assert len(name_constants(long).meanings) == len(name_constants(plain).meanings) + 1

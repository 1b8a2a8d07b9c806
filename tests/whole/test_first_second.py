"""Numbers as users give them, and what is computed only when it is asked for."""

import numpy as np
import pytest
from commands import inside

import stickslip_sym as ss
from stickslip_sym.core.numbers import exact, fraction


@pytest.mark.parametrize("command", ["damping", "derive", "simulate"])
def test_a_typo_is_answered_by_a_suggestion(command):
    assert "did you mean 'exponential'?" in inside(command, "exponentail", "-V", "0.5").stderr


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["damping", "exponential", "-V", "0.5", "-N", "1", "--rtol", "ab"], "rtol = 'ab'"),
        (["derive", "exponential", "--time-limit", "1e"], "time_limit = '1e'"),
        (["derive", "exponential", "-p", "alpha"], "NAME=VALUE"),
        (["derive", "exponential", "-p", "alpha=1", "-p", "alpha=2"], "given twice"),
    ],
)
def test_what_is_no_text_is_still_read(line, said):
    error = inside(*line).stderr
    assert said in error
    assert len(error.splitlines()) == 1


def test_fractions_are_exact_numbers():
    from decimal import Decimal
    from fractions import Fraction

    import mpmath
    import sympy as sp

    rng = np.random.default_rng(8)
    for x in (rng.normal(size=20) * 10.0 ** rng.integers(-300, 300, 20)).tolist():
        kinds = [
            x,
            repr(x),
            np.float64(x),
            Decimal(x),
            Fraction(x),
            mpmath.mpf(x),
            sp.Float(x, 60),
            sp.Rational(x),
        ]
        for number in kinds:
            got = fraction(number, "x")
            assert float(got) == x
            assert exact(number, "x") == sp.Rational(got.numerator, got.denominator)
    assert fraction("5.", "x") == 5
    assert fraction(" -.5e1/3 ", "x") == Fraction(-5, 3)
    for wrong in (True, float("nan"), -np.inf, Decimal("inf"), mpmath.inf, sp.pi, sp.oo, "0x1", "1/0", None, [1]):
        with pytest.raises(ss.InputError):
            fraction(wrong, "x")

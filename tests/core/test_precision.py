"""The user's precision of mpmath: it decides nothing here, and stays what it is."""

from fractions import Fraction

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import binary_fraction
from stickslip_sym.core.precision import mp


@given(number=st.floats(allow_nan=False, allow_infinity=False), digits=st.sampled_from([1, 4, 15, 50]))
def test_a_float_is_the_binary_fraction_that_it_is(number, digits):
    """SymPy's own Rational is the negative control: it rounds to the precision of the moment."""
    with mpmath.workdps(digits):
        exact = binary_fraction(number)
    assert Fraction(int(exact.p), int(exact.q)) == Fraction(number)
    with mpmath.workdps(1):
        assert sp.Rational(0.1) != binary_fraction(0.1)


@pytest.mark.parametrize(
    "expr", ["exp(-x/3)", "erf(x)", "Abs(x)*LambertW(x)", "polylog(2, -x)", "lerchphi(-x, 2, 1/3)"]
)
def test_functions_of_a_context_compute_in_its_precision(expr):
    """The same as with mpmath's own context at that precision; the precision of the other is not asked."""
    x = sp.Symbol("x")
    expr = sp.sympify(expr)
    with mpmath.workdps(40):
        expected = function_of([x], expr, "mpmath")(mpmath.mpf("0.25"))
    with mpmath.workdps(3), mp.workdps(40):
        value = function_of([x], expr, mp.context)(mp.mpf("0.25"))
        assert mpmath.mp.dps == 3
    assert value._mpf_ == expected._mpf_

"""Limits that users meet, and how results show themselves: each on the cheapest case that has it."""

import inspect
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.numbers import exact, fraction

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
POLYNOMIAL = ss.laws.polynomial.typical()


@mpmath.workdps(20)
def test_every_kind_of_number_is_read_exactly():
    rng = np.random.default_rng(8)
    for x in (rng.normal(size=20) * 10.0 ** rng.integers(-300, 300, 20)).tolist():
        kinds = x, repr(x), np.float64(x), Decimal(x), Fraction(x), mpmath.mpf(x), sp.Float(x, 60), sp.Rational(x)
        for number in kinds:
            got = fraction(number, "x")
            assert float(got) == x
            assert exact(number, "x") == sp.Rational(got.numerator, got.denominator)
    assert fraction("5.", "x") == 5
    assert fraction(" -.5e1/3 ", "x") == Fraction(-5, 3)
    for wrong in (True, float("nan"), -np.inf, Decimal("inf"), mpmath.inf, sp.pi, sp.oo, "0x1", "1/0", None, [1]):
        with pytest.raises(ss.InputError):
            fraction(wrong, "x")


def nested(depth):
    return ss.FrictionLaw("(" * depth + "v" + ")" * depth)


def quantity(**change):
    return ss.pure_slip_damping(POLYNOMIAL, **POINT | change, method="harmonic")


def samples(*speeds):
    return ss.FrictionLaw.from_samples([0, *speeds], [4, 3, 2, 1])


LIMITS = [
    (nested, {"depth": 60}, {"depth": 61}, "more than 60 nested"),
    (lambda top: samples(1, 2, top), {"top": 99 * 10**18}, {"top": 101 * 10**18}, "out of all proportion"),
    (lambda least: samples(least, 1, 2), {"least": 1.01e-20}, {"least": 0.99e-20}, "out of all proportion"),
    (quantity, {"N": 0.0}, {"N": -1e-300}, "N = .* must"),
    *((quantity, {name: 1e-9}, {name: 0.0}, f"{name} = .* must") for name in "Vmk"),
    (quantity, {"V": [0.5, 1.0]}, {"V": [0.5, -1.0]}, "V = .* must"),
]


@pytest.mark.parametrize(("call", "allowed", "refused", "message"), LIMITS)
def test_limits_are_where_they_are_said(call, allowed, refused, message):
    assert call(**allowed) is not None
    with pytest.raises(ss.InputError, match=message):
        call(**refused)


def test_symbols_have_the_signs_of_their_quantities():
    signs = {name: (one.symbol.is_positive, one.symbol.is_nonnegative) for name, one in symbols.QUANTITIES.items()}
    assert {signs[name] for name in "VNmk"} == {(True, True)}
    assert {signs[name] for name in "cxt"} == {(None, None)}
    assert signs["v"] == (None, True)


def test_public_results_cannot_be_changed():
    """What stands beside the public functions; what is counted and what grows is no result."""
    modules = {inspect.getmodule(getattr(ss, name)) for name in ss.__all__}
    known = {value for module in modules for value in vars(module).values() if inspect.isclass(value)}
    results = {one for one in known if hasattr(one, "__dataclass_params__") and not one.__name__.startswith("_")}
    assert {"ClosedForm", "Threshold", "Fit", "Trajectory", "Regime", "Study"} <= {one.__name__ for one in results}
    grow = {"WorkBudget", "Cells", "Derivation", "Reference", "Table"}
    assert {one.__name__ for one in results if not one.__dataclass_params__.frozen} <= grow


def test_units_of_parameters_are_typeset():
    form = ss.derive(ss.FrictionLaw("p - q*v^3", units={"q": "s^3/m^3"}), "equilibrium")
    assert r"\mathrm{s^{3}/m^{3}}" in ss.export_latex(form, fragment=True)

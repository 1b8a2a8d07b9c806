"""Limits that users meet, and how results show themselves: each on the cheapest case that has it."""

import inspect
from decimal import Decimal
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import sympy as sp
from operating_points import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.numbers import exact, fraction
from stickslip_sym.output import tables

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
MEASURED = [0, 1, 2, 3], [0.5, 0.4, 0.35, 0.33]
POLYNOMIAL = ss.laws.polynomial.typical()


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


@pytest.mark.parametrize(("criterion", "reach"), [("equilibrium", 3.0), ("least_squares", 1.5), ("harmonic", 1.5)])
def test_measured_law_is_averaged_to_its_last_speed(criterion, reach):
    average = ss.slope_average(ss.FrictionLaw.from_samples(*MEASURED), criterion)
    assert np.isfinite(average(V=np.array([reach / 2, reach]), N=1.0)).all()
    with pytest.raises(ss.InputError, match="measured up to"):
        average(V=1.001 * reach, N=1.0)


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
    *(
        (quantity, {name: 1e-9}, {name: zero}, f"{name} = .* must")
        for name in "Vmk"
        for zero in (0.0, [0.5, -1.0])
    ),
]


@pytest.mark.parametrize(("call", "allowed", "refused", "message"), LIMITS)
def test_limits_are_where_they_are_said(call, allowed, refused, message):
    assert call(**allowed) is not None
    with pytest.raises(ss.InputError, match=message):
        call(**refused)


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
def test_quadrature_splits_at_kinks(criterion):
    law = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
    weight = sp.lambdify(symbols.s, ss.criteria.catalogue[criterion].weight, "mpmath")
    with mpmath.workdps(30):
        exact = 2 * mpmath.mpf("0.2") * mpmath.quad(weight, [-1, mpmath.mpf("0.7") / mpmath.mpf("0.5") - 1])
    value = ss.quadrature.damping(law, criterion, V="0.5", N=2, digits=20)
    assert float(abs(value / exact - 1)) < 1e-18


def test_symbols_have_the_signs_of_their_quantities():
    signs = {name: (one.symbol.is_positive, one.symbol.is_nonnegative) for name, one in symbols.QUANTITIES.items()}
    assert {signs[name] for name in "VNmk"} == {(True, True)}
    assert {signs[name] for name in "cxt"} == {(None, None)}
    assert signs["v"] == (None, True)


def test_public_results_cannot_be_changed():
    """What stands beside the public functions; a derivation, a map's cells and a file's rows grow."""
    modules = {inspect.getmodule(getattr(ss, name)) for name in ss.__all__}
    known = {value for module in modules for value in vars(module).values() if inspect.isclass(value)}
    results = {one for one in known if hasattr(one, "__dataclass_params__") and not one.__name__.startswith("_")}
    assert {"ClosedForm", "Threshold", "Fit", "Trajectory", "Regime", "Study"} <= {one.__name__ for one in results}
    grow = {"Cells", "Derivation", "Table"}
    assert {one.__name__ for one in results if not one.__dataclass_params__.frozen} <= grow


def test_notebooks_show_what_was_computed():
    assert r"\mu(v) = " in ss.FrictionLaw("mu_s - a*v**2")._repr_html_()
    curve = ss.FrictionLaw.from_samples(*MEASURED)._repr_html_()
    assert "piecewise cubic" in curve
    assert r"\mu(v) = " not in curve
    motion = ss.simulate(POLYNOMIAL, paper_oscillator(), t_end=1.0)
    assert all(f"{event.t:.9g}" in motion._repr_html_() for event in motion.events)
    (cycle,) = ss.limit_cycles(POLYNOMIAL, paper_oscillator(c=3.2))
    assert ">stable pure-slip" in cycle._repr_html_()
    (unstable,) = ss.limit_cycles(ss.laws.exponential.typical(), paper_oscillator(c=2.3))
    assert (cycle.stable, unstable.stable, "unstable" in repr(unstable)) == (True, False, True)


@pytest.mark.parametrize(
    ("formula", "unit", "written"),
    [("p - v/q", "m/s", r"\mathrm{m/s}"), ("p - q*v^3", "s^3/m^3", r"\mathrm{s^{3}/m^{3}}")],
)
def test_units_of_parameters_are_typeset(formula, unit, written):
    form = ss.derive(ss.FrictionLaw(formula, units={"q": unit}), "equilibrium")
    assert written in ss.export_latex(form, fragment=True)


def test_durations_have_the_unit_that_suits_them():
    texts = {2.5: "2.5 s", 1.0: "1 s", 0.5: "500 ms", 2e-6: "2 us", 5e-9: "5 ns"}
    assert {seconds: tables.duration(seconds) for seconds in texts} == texts

"""Limits that users meet, and how results show themselves: each on the cheapest case that has it."""

import inspect

import numpy as np
import pytest
import sympy as sp
from mpmath import mp
from operating_points import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.core.symbols import v
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.output import tables

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
AVERAGES = [ss.criteria.least_squares, ss.criteria.harmonic]
MEASURED = [0, 1, 2, 3], [0.5, 0.4, 0.35, 0.33]


@pytest.mark.parametrize(("criterion", "reach"), [("equilibrium", 3.0), ("least_squares", 1.5), ("harmonic", 1.5)])
def test_measured_law_is_averaged_to_its_last_speed(criterion, reach):
    average = ss.slope_average(ss.FrictionLaw.from_samples(*MEASURED), criterion)
    assert np.isfinite(average(V=np.array([reach / 2, reach]), N=1.0)).all()
    with pytest.raises(ss.InputError, match="measured up to"):
        average(V=1.001 * reach, N=1.0)


@pytest.mark.parametrize("factor", [sp.Rational(99, 100), sp.Rational(101, 100)])
def test_speeds_of_samples_have_a_largest_and_a_smallest(factor):
    for speeds in ([0, 1, 2, 10**20 * factor], [0, 1 / (10**20 * factor), 1, 2]):
        if factor < 1:
            assert ss.FrictionLaw.from_samples(speeds, [4, 3, 2, 1]).v_max == speeds[-1]
        else:
            with pytest.raises(ss.InputError):
                ss.FrictionLaw.from_samples(speeds, [4, 3, 2, 1])


def test_brackets_are_read_to_sixty_levels():
    def nested(depth):
        return "(" * depth + "v" + ")" * depth

    assert ss.FrictionLaw(nested(60)).expr == v
    assert ss.FrictionLaw(" + ".join(["(v)"] * 100)).expr == 100 * v
    with pytest.raises(ss.InputError, match="more than 60 nested"):
        ss.FrictionLaw(nested(61))


def test_integrable_pole_has_an_average():
    assert ss.derive(ss.FrictionLaw("0.4 - 0.3/sqrt(v)"), "least_squares").derivation.status is ss.Status.PROVED


@pytest.mark.parametrize("criterion", AVERAGES, ids=lambda one: one.name)
def test_quadrature_splits_at_kinks(criterion):
    law = ss.FrictionLaw("Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)")
    weight = sp.lambdify(symbols.s, criterion.weight, "mpmath")
    with mp.workdps(30):
        exact = 2 * mp.mpf("0.2") * mp.quad(weight, [-1, mp.mpf("0.7") / mp.mpf("0.5") - 1])
    value = ss.quadrature.damping(law, criterion, V="0.5", N=2, digits=20)
    assert float(abs(value / exact - 1)) < 1e-18


def test_static_coefficient_is_in_the_way_of_orbits():
    for share in (1.001, 1.7, 1.0):
        law = ss.FrictionLaw("0.2 + 0.3*exp(-v)", static=0.5 * share)
        if share == 1:
            assert ss.pure_slip_damping(law, **POINT, method="orbit").value > 0
        else:
            with pytest.raises(ss.InputError, match="static"):
                ss.pure_slip_damping(law, **POINT, method="orbit")


@pytest.mark.parametrize(("name", "zero"), [("V", False), ("N", True), ("m", False), ("k", False)])
def test_quantities_have_their_signs(name, zero):
    law = ss.laws.polynomial.typical()
    for value in (-1.0, [0.5, -1e-300]) + (() if zero else (0.0,)):
        with pytest.raises(ss.InputError, match=rf"{name} = .* must"):
            ss.pure_slip_damping(law, **POINT | {name: value}, method="harmonic")
    if zero:
        assert ss.pure_slip_damping(law, **POINT | {name: 0.0}, method="harmonic").value == 0


@pytest.mark.parametrize("seconds", [-1e-3, float("nan"), float("inf")])
def test_no_limit_of_time_is_refused(seconds):
    law = ss.laws.polynomial.typical()
    for call in (
        lambda: ss.pure_slip_damping(law, **POINT, time_limit=seconds),
        lambda: ss.critical(law, "N", c=1.0, V=0.5, m=1.0, k=100.0, time_limit=seconds),
        lambda: ss.simulate(law, paper_oscillator(), t_end=1.0, time_limit=seconds),
    ):
        with pytest.raises(ss.InputError, match=r"seconds|time_limit"):
            call()


def test_symbols_have_the_signs_of_their_quantities():
    for name in "VNmk":
        assert symbols.QUANTITIES[name].symbol.is_positive
    assert symbols.QUANTITIES["v"].symbol.is_nonnegative
    assert not symbols.QUANTITIES["v"].symbol.is_positive
    for name in "cxt":
        assert symbols.QUANTITIES[name].symbol.is_real
        assert symbols.QUANTITIES[name].symbol.is_positive is None


def test_public_results_cannot_be_changed():
    """What stands beside the public functions; a derivation, a map's cells and a file's rows grow."""
    modules = {inspect.getmodule(getattr(ss, name)) for name in ss.__all__}
    known = {value for module in modules for value in vars(module).values() if inspect.isclass(value)}
    results = {one for one in known if hasattr(one, "__dataclass_params__") and not one.__name__.startswith("_")}
    assert {"ClosedForm", "Threshold", "Fit", "Trajectory", "Regime", "Study"} <= {one.__name__ for one in results}
    assert {one.__name__ for one in results if not one.__dataclass_params__.frozen} <= {
        "Cells",
        "Derivation",
        "Table",
    }


def test_defaults_are_those_of_the_documentation():
    defaults = {
        (ss.quadrature.damping, "digits"): 50,
        (ClosedForm.evaluate, "digits"): 50,
        (ss.pure_slip_damping, "rtol"): None,  # 1e-3, or what the parameters deserve
        (ss.pure_slip_damping, "method"): "auto",
        (ss.compare, "rtol"): 1e-10,
    }
    for (function, name), value in defaults.items():
        assert inspect.signature(function).parameters[name].default == value


def test_stick_slip_is_never_faster_than_the_belt():
    cycle = ss.stick_slip_cycle(ss.laws.polynomial.typical(), paper_oscillator())
    assert cycle.v_max == 0.5
    assert cycle.v_min < 0.0


def test_notebook_shows_a_formula_or_what_was_measured():
    assert r"\mu(v) = " in ss.FrictionLaw("mu_s - a*v**2")._repr_html_()
    curve = ss.FrictionLaw.from_samples(*MEASURED)._repr_html_()
    assert "piecewise cubic" in curve
    assert r"\mu(v) = " not in curve


def test_notebook_shows_every_event():
    motion = ss.simulate(ss.laws.polynomial.typical(), paper_oscillator(), t_end=1.0)
    page = motion._repr_html_()
    assert 1 <= len(motion.events) <= 8
    assert "..." not in page
    assert all(f"{event.t:.9g}" in page for event in motion.events)


def test_notebook_says_whether_a_cycle_is_stable():
    law, osc = ss.laws.polynomial.typical(), paper_oscillator(c=3.2)
    (cycle,) = ss.limit_cycles(law, osc)
    assert cycle.stable
    assert ">stable pure-slip" in cycle._repr_html_()
    (unstable,) = ss.limit_cycles(ss.laws.exponential.typical(), paper_oscillator(c=2.3))
    assert not unstable.stable
    assert "unstable" in repr(unstable)


@pytest.mark.parametrize(
    ("formula", "unit", "written"),
    [("p - v/q", "m/s", r"\mathrm{m/s}"), ("p - q*v^3", "s^3/m^3", r"\mathrm{s^{3}/m^{3}}")],
)
def test_units_of_parameters_are_typeset(formula, unit, written):
    form = ss.derive(ss.FrictionLaw(formula, units={"q": unit}), "equilibrium")
    assert written in ss.export_latex(form, fragment=True)


@pytest.mark.parametrize(
    ("seconds", "text"), [(2.5, "2.5 s"), (1.0, "1 s"), (0.5, "500 ms"), (2e-6, "2 us"), (5e-9, "5 ns")]
)
def test_durations_have_the_unit_that_suits_them(seconds, text):
    assert tables.duration(seconds) == text

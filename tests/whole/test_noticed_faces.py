"""What users read and the limits they meet: each stated outcome, on the cheapest case that has it."""

import inspect
import os
from pathlib import Path

import mpmath
import numpy as np
import pytest
import sympy as sp
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.cli.shared.reading import LARGEST, check_size
from stickslip_sym.comparison.crosscheck import crosscheck
from stickslip_sym.core import deadline, lambdify, lerch
from stickslip_sym.core.numbers import exact
from stickslip_sym.core.symbols import v
from stickslip_sym.formula.derivation import proving
from stickslip_sym.formula.evaluation import bounds, fitting
from stickslip_sym.formula.export import document
from stickslip_sym.formula.integration import integrals, theorems
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.maps import drawing
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.simulation.slip_phase import attracted_to_rest
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.output import tables
from stickslip_sym.output.files import write_texts

SCENE = {"N": 9.81, "m": 1.0, "k": 100.0}
x = sp.Symbol("x", real=True)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1e-400", "below what double precision can hold"),
        ("-1e-400", "below what double precision can hold"),
        ("1e400", "beyond what double precision can hold"),
        (str(1.01 / LARGEST), None),
        (str(0.99 / LARGEST), "too small"),
        (str(0.99 * LARGEST), None),
        (str(1.01 * LARGEST), "too large"),
        ("0", None),
    ],
)
def test_sizes_of_numbers_that_no_scene_has(text, says):
    if says is None:
        check_size("N", exact(text, "N"))
    else:
        with pytest.raises(ss.InputError, match=says):
            check_size("N", exact(text, "N"))


@pytest.mark.parametrize("strength", ["0.3", "3", "-0.3"])
def test_laws_that_have_no_average_are_refused_however_weak(strength):
    with pytest.raises(ss.NoClosedForm, match="not integrable"):
        ss.derive(ss.FrictionLaw(f"0.4 + {strength}/v"), "least_squares")


def test_a_law_with_an_integrable_pole_has_an_average():
    assert ss.derive(ss.FrictionLaw("0.4 - 0.3/sqrt(v)"), "least_squares").derivation.status is ss.Status.PROVED


@pytest.mark.parametrize("seconds", [-1e-3, 1.001 * deadline.LONGEST, float("nan"), float("inf")])
def test_times_that_are_no_limit_are_refused(seconds):
    with pytest.raises(ss.InputError, match="not a number of seconds"), deadline.time_limit(seconds):
        pass


def test_the_time_left_is_that_of_the_tightest_limit():
    assert deadline.time_left() == np.inf
    with deadline.time_limit(None), deadline.time_limit(100.0), deadline.time_limit(1000.0):
        assert 99.0 < deadline.time_left() <= 100.0
    with deadline.time_limit(0.0), deadline.time_limit(deadline.LONGEST):
        assert deadline.time_left() <= 0.0
    assert deadline.time_left() == np.inf


@pytest.mark.parametrize("method", ["equilibrium", "least_squares", "harmonic", "second_order"])
def test_a_transition_speed_has_the_method_that_was_asked_for(method):
    law = ss.laws.polynomial.typical()
    (with_mass,) = ss.transition_speed(law, c=2.0, **SCENE, method=method)
    assert with_mass.method == method
    back = ss.pure_slip_damping(law, V=with_mass.value, **SCENE, method=method)
    assert back.value == pytest.approx(2.0, rel=1e-9)
    if method == "second_order":
        with pytest.raises(ss.InputError, match="needs the mass"):
            ss.transition_speed(law, c=2.0, N=9.81, method=method)
    else:
        (without,) = ss.transition_speed(law, c=2.0, N=9.81, method=method)
        assert (without.method, without.value) == (method, pytest.approx(with_mass.value, rel=1e-12))


def test_a_notebook_shows_a_formula_or_says_what_was_measured():
    formula = ss.FrictionLaw("mu_s - a*v**2")._repr_html_()
    assert r"\mu(v) = " in formula
    curve = ss.FrictionLaw.from_samples([0, 1, 2, 3], [0.5, 0.4, 0.35, 0.33])._repr_html_()
    assert "piecewise cubic" in curve
    assert r"\mu(v) = " not in curve


@pytest.mark.parametrize("power", [2, -1, sp.Rational(1, 2)])
def test_what_is_rounded_once_counts_half_a_unit(power):
    bound = lambdify.function_of([v], bounds.rounding_bound(v**power), "numpy")
    twice = lambdify.function_of([v], bounds.rounding_bound(sp.exp(v)), "numpy")
    for speed in (0.3, 2.0, 17.0):
        assert bound(speed) == pytest.approx(0.5 * speed ** float(power), rel=1e-12)
        assert twice(speed) == pytest.approx(2 * np.exp(speed), rel=1e-12)


def test_only_what_is_known_to_be_positive_is():
    a, b = sp.symbols("a b", positive=True)
    for expr, known in (
        (x**2 + a, True),
        (a * x**2 + b * x + b**2 / a, True),
        (x**2 - a, False),
        (x**2 + b * x + a, False),
        (x + a, False),
        (x**3 + a, False),
        (sp.sin(x), False),
        (sp.exp(x), True),
        (-(x**2) - a, False),
    ):
        assert theorems.is_positive(expr, x) is known


def test_units_of_parameters_are_typeset():
    for unit, written in (("m/s", r"\mathrm{m/s}"), ("kg*m^2", r"\mathrm{kg\,m^{2}}"), ("s^3", r"\mathrm{s^{3}}")):
        form = ss.derive(ss.FrictionLaw("p - q*v", units={"q": unit}), "equilibrium")
        text = document.document([form], given={}, fragment=True, steps=False, missing=(), time_limit=1.0)
        assert written in text


def test_defaults_are_those_of_the_documentation():
    defaults = {
        (ss.quadrature.damping, "digits"): 50,
        (ss.ClosedForm.evaluate, "digits"): 50,
        (crosscheck, "digits"): 50,
        (ss.pure_slip_damping, "rtol"): None,  # 1e-3, or what the parameters deserve
        (ss.pure_slip_damping, "method"): "auto",
    }
    for (function, name), value in defaults.items():
        assert inspect.signature(function).parameters[name].default == value


@pytest.mark.parametrize("criterion", [ss.criteria.least_squares, ss.criteria.harmonic], ids=lambda one: one.name)
def test_the_integral_of_a_law_is_its_criterion(criterion):
    law = ss.FrictionLaw("0.5 - 0.2*v + 0.1*v**3")
    scene = {symbols.V: 0.5, symbols.N: 2}
    found = sp.N(integrals.law_integral(law.expr, criterion).subs(scene), 15)
    assert float(found) == pytest.approx(
        float(ss.quadrature.damping(law, criterion, V="0.5", N=2, digits=15)), rel=1e-12
    )


def test_what_is_not_equal_for_all_functions_is_refuted_with_one():
    f = sp.Function("f", real=True)
    for wrong in (f(x) + 1, 2 * f(x), f(x) * (1 + f(x))):
        verdict = proving.prove_equal(f(x), wrong)
        assert verdict.status is proving.Status.REFUTED
        values = [side.replace(f, verdict.point[f]).subs(x, verdict.point[x]) for side in (f(x), wrong)]
        assert values[0] != values[1]
        assert f"f(w) = {verdict.point[f].expr}" in verdict.evidence


def test_only_what_decays_comes_to_rest():
    law, rest = ss.FrictionLaw("0.5 - 0.1*v"), {}
    for c in (0.0, 0.981, 2.0):
        scene = Scene.of(law, paper_oscillator(c=c))
        rest[c] = attracted_to_rest(scene, 1, 1e-6)(Point(0.0, *scene.rest))
        assert not attracted_to_rest(scene, 1, 1e-6)(Point(0.0, scene.rest[0] + 1.0, scene.rest[1]))
        assert not attracted_to_rest(scene, -1, 1e-6)(Point(0.0, *scene.rest))
    assert rest[0.0] is False
    assert rest[2.0] is True
    undamped = Scene.of(law, paper_oscillator(N=0.0))
    assert not attracted_to_rest(undamped, 1, 1e-6)(Point(0.0, *undamped.rest))


@pytest.mark.parametrize("slope", ["sqrt(v)", "log(v)", "1/v", "exp(-v**(3/2))", "1/(5*v + 1)", "gamma(v)"])
def test_a_function_that_is_not_analytic_around_rest_has_no_series(slope):
    assert fitting.taylor(sp.sympify(slope, locals={"v": symbols.v}), ss.criteria.harmonic, 0.0) is None


def test_the_lerch_transcendent_has_the_digits_of_the_working_precision():
    for digits in (15, 50):
        with mpmath.workdps(digits):
            for z, order, a in ((-0.9, 2, 1.5), (-0.01, 1, 0.25), (-1, 3, 7.0)):
                exact = mpmath.nsum(
                    lambda k, z=z, s=order, a=a: mpmath.mpf(z) ** k / (k + a) ** s, [0, mpmath.inf]
                )
                assert abs(lerch.lerch(mpmath.mpf(z), order, a) / exact - 1) < mpmath.mpf(10) ** (2 - digits)


def test_a_cycle_that_sticks_is_never_faster_than_the_belt_unless_it_overtakes():
    law = ss.laws.polynomial.typical()
    cycle = ss.stick_slip_cycle(law, paper_oscillator())
    assert cycle.v_max == 0.5
    assert cycle.v_min < 0.0
    fast = ss.stick_slip_cycle(ss.FrictionLaw("0.2", static=0.5), paper_oscillator(c=0.0, V=0.01))
    assert fast is None or fast.v_max >= 0.01


def test_a_notebook_shows_the_changes_of_phase():
    motion = ss.simulate(ss.laws.polynomial.typical(), paper_oscillator(), t_end=1.0)
    assert 1 <= len(motion.events) <= 8
    page = motion._repr_html_()
    assert "..." not in page
    for event in motion.events:
        assert f"{event.t:.9g}" in page


@pytest.mark.parametrize(("off", "status"), [("1e-30", "CHECKED"), ("5e-23", "REFUTED"), ("1e-20", "REFUTED")])
def test_what_differs_by_less_than_rounding_counts_as_equal(off, status):
    """Numbers that no normal form tells apart, as they hold different constants."""
    one = sp.Symbol("one", positive=True) * sp.gamma(sp.Rational(1, 3))
    near = one * (1 + sp.Rational(off) * sp.zeta(3) / sp.Rational(str(sp.N(sp.zeta(3), 40))))
    assert proving.prove_equal(one, near).status.value == status


def test_brackets_that_are_closed_do_not_count_as_nested():
    assert ss.FrictionLaw(" + ".join(["(v)"] * 100)).expr == 100 * v


def test_a_new_file_has_the_permissions_of_any_other(tmp_path):
    before = os.umask(0o027)
    try:
        write_texts({tmp_path / "new": "text"})
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640


def test_errors_of_transition_speeds_are_known_where_the_orbit_is():
    (known,) = ss.transition_speed(ss.laws.polynomial.typical(), c=2.0, **SCENE, rtol=0.1)
    assert 0 < known.error <= 0.1
    (unknown,) = ss.transition_speed(ss.laws.polynomial.typical(), c=2.0, N=9.81)
    assert (unknown.method, unknown.error) == ("harmonic", None)


def test_a_pipe_is_written_into(tmp_path):
    reading, writing = os.pipe()
    write_texts({Path(f"/dev/fd/{writing}"): "told", tmp_path / "kept": "kept"})
    os.close(writing)
    with os.fdopen(reading) as pipe:
        assert pipe.read() == "told"
    assert (tmp_path / "kept").read_text() == "kept"


@pytest.mark.parametrize(("stable", "kind"), [(True, ">stable pure-slip"), (False, ">unstable pure-slip")])
def test_a_notebook_says_whether_a_cycle_is_stable(stable, kind):
    cycle = LimitCycle(amplitude=0.5, period=0.6, floquet=-0.1 if stable else 0.1, stable=stable)
    assert kind in cycle._repr_html_()
    assert repr(cycle).count("unstable") == (not stable)


@pytest.mark.parametrize(
    ("seconds", "text"), [(2.5, "2.5 s"), (1.0, "1 s"), (0.5, "500 ms"), (2e-6, "2 us"), (5e-9, "5 ns")]
)
def test_durations_have_the_unit_that_suits_them(seconds, text):
    assert tables.duration(seconds) == text


@pytest.mark.parametrize(("value", "half"), [(2.0, 0.1), (-2.0, 0.1), (0.0, 0.05)])
def test_a_single_cell_has_edges_beside_its_value(value, half):
    assert drawing.edges(np.array([value])) == pytest.approx([value - half, value + half])

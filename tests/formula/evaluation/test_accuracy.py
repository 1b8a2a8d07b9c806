"""Every criterion of every law, held to a few units of epsilon N <|mu'|>.

The whole table: benchmarks/measure_accuracy.py.
"""

import inspect
import shutil
from itertools import product

import accuracy
import mpmath
import numpy as np
import pytest
import sympy as sp
from accuracy import MOST_UNITS, MOST_UNITS_BY_BALLS, MOST_UNITS_OF_THE_PAPER, by_definition, compiled
from forms import FORMS, NO_HARMONIC, NO_LEAST_SQUARES, form_of, some

import stickslip_sym as ss
from derivations import paper

PAPER = ("exponential", "polynomial")
SLOW_REFERENCE = {
    "tanh", "sech", "brown_mcphee", "simscape", "arcsinh", "gaussian", "gaussian_viscous", "stribeck",
    "stribeck_viscous",
}  # fmt: skip
SAMPLES = 12
KINDS = [
    ("exponential", "least_squares"), ("exponential", "harmonic"), ("polynomial", "least_squares"),
    ("tanh", "least_squares"), ("rational", "harmonic"), ("arctangent", "harmonic"), ("logarithmic", "harmonic"),
    ("two_exponentials", "least_squares"),
]  # fmt: skip
"""One of every kind of branch and of formula."""


def most(name):
    return MOST_UNITS_OF_THE_PAPER if name in PAPER else MOST_UNITS


@pytest.mark.parametrize("regime", ["middle", "small", "large"])
@pytest.mark.parametrize(("name", "criterion"), some(FORMS, *KINDS))
def test_over_all_decades(name, criterion, regime):
    if (regime != "middle" and name in SLOW_REFERENCE) or (name, regime) == ("quintic", "large"):
        pytest.skip("the reference takes minutes, or V^4 leaves the range of double precision")
    form = form_of(name, criterion)
    columns = accuracy.samples(form.law, regime, 3 if name in SLOW_REFERENCE else SAMPLES, seed=1)
    assert accuracy.units(form, columns, form(**columns)).max() <= most(name)


def test_the_exponential_law_where_its_branches_meet():
    """Some ten thousand speeds in each stretch: a few may all be lucky."""
    average = ss.slope_average(ss.laws.exponential)
    V = np.concatenate([start * np.linspace(1, 1.02, 20_000) for start in (1.97, 2.0, 2.24, 2.8, 4.0, 19.0, 22.6)])
    speed = V.astype(np.longdouble)
    term, right = np.exp(-speed), np.zeros_like(speed)
    for k in range(60):  # of exp(-r) sum <s^2k> r^2k/(2k)!, where nothing cancels
        right += term * 5 / ((2 * k + 1) * (2 * k + 5))
        term *= speed**2 / ((2 * k + 1) * (2 * k + 2))
    values = average(V=V, N=1.0, mu_s=1.0, mu_m=0.5, alpha=1.0)
    assert np.abs(values / (right / 2) - 1).max() <= MOST_UNITS_OF_THE_PAPER * accuracy.EPSILON


@pytest.mark.parametrize("name", some(["exponential", "gaussian", "lorentzian", "tanh", "polynomial"], 0, 3))
def test_the_slope_at_one_point(name):
    form = form_of(name, "equilibrium")
    for regime in ("middle", "large"):
        columns = accuracy.samples(form.law, regime, SAMPLES, seed=5)
        assert accuracy.units(form, columns, form(**columns)).max() <= MOST_UNITS


def test_the_printed_formula_fails_that_test():
    """The negative control: (17) as lambdify gives it."""
    form = form_of("exponential", "least_squares")
    symbols = [*form.arguments.values()]
    names = [paper.exponential.get(symbol.name, symbol) for symbol in symbols]
    printed = sp.lambdify(names, paper.equations()["(17)"], "numpy")
    columns = accuracy.samples(form.law, "middle", SAMPLES, seed=1)
    with np.errstate(all="ignore"):
        values = printed(*(columns[name] for name in form.arguments))
    assert accuracy.units(form, columns, values).max() > 1e6


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
def test_the_exponential_law_over_six_hundred_decades(criterion):
    form = form_of("exponential", criterion)
    rng = np.random.default_rng(17)
    x = 10 ** rng.uniform(-300, 300, 60)
    alpha = np.sqrt(x) * 10 ** rng.uniform(-3, 3, 60)
    columns = {"V": x / alpha, "N": 10 ** rng.uniform(-3, 3, 60), "mu_s": 0.5, "mu_m": 0.2, "alpha": alpha}
    columns = {name: np.broadcast_to(column, (60,)) for name, column in columns.items()}
    exact = [form.evaluate(20, **{name: float(column[i]) for name, column in columns.items()}) for i in range(60)]
    for value, right in zip(form(**columns), exact, strict=True):
        tolerance = max(abs(right) * MOST_UNITS_OF_THE_PAPER * accuracy.EPSILON, mpmath.mpf(2) ** -1074)
        assert abs(mpmath.mpf(float(value)) - right) <= tolerance


@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
def test_the_polynomial_law_near_its_zero_and_far_from_it(criterion):
    form = form_of("polynomial", criterion)
    rng = np.random.default_rng(18)
    zero = np.sqrt(21 / 26) if criterion == "least_squares" else np.sqrt(0.8)
    ratio = np.concatenate([zero * (1 + 10 ** rng.uniform(-16, -1, 60)), 10 ** rng.uniform(-150, 150, 60)])
    v_m = 10 ** rng.uniform(-2, 2, 120)
    columns = {"V": ratio * v_m, "N": v_m, "mu_s": rng.uniform(0.3, 0.6, 120), "mu_m": rng.uniform(0, 0.3, 120)}
    columns["v_m"] = v_m
    assert accuracy.units(form, columns, form(**columns)).max() <= MOST_UNITS_OF_THE_PAPER


WITHOUT = [(name, "harmonic") for name in sorted(NO_HARMONIC)] + [
    (n, "least_squares") for n in sorted(NO_LEAST_SQUARES)
]


@pytest.mark.parametrize(("name", "criterion"), some(WITHOUT, ("stribeck", "harmonic"), ("sech", "harmonic")))
def test_laws_without_a_closed_form(name, criterion):
    average = ss.slope_average(ss.laws.catalogue[name], criterion)
    columns = accuracy.samples(average.law, "middle", 4, seed=3)
    got = average(**columns)
    assert accuracy.units(average, columns, got, by_definition(average, columns)).max() <= MOST_UNITS_BY_BALLS


KINKED = [
    "0.3 + 0.1*Abs(v - 0.7)", "0.2 + Max(0.3 - 0.4*v, 0)", "0.3*exp(-v)*cos(3*v)",
    "Piecewise((0.5, v < 0.4), 0.2)", "Piecewise((exp(-v), v < 0.7), (0.3, v < 5), v)",
]  # fmt: skip
BOTH = ("least_squares", "harmonic")


@pytest.mark.parametrize(("text", "criterion"), some(list(product(KINKED, BOTH)), 1, 6, 8))
def test_kinks_and_waves(text, criterion):
    average = ss.slope_average(ss.FrictionLaw(text), criterion)
    columns = {"V": np.array([0.21, 0.351, 0.36, 0.5, 3.0]), "N": np.full(5, 2.0)}
    got = average(**columns)
    assert accuracy.units(average, columns, got, by_definition(average, columns)).max() <= MOST_UNITS_BY_BALLS


def test_confluent_parameters():
    two = form_of("two_exponentials", "least_squares")
    values = {"V": 0.3, "N": 9.81, "mu_m": 0.2, "d_1": 0.1, "d_2": 0.2, "v_1": 0.5, "v_2": 0.5}
    one = form_of("exponential", "least_squares")
    assert two(**values) == pytest.approx(one(V=0.3, N=9.81, mu_s=0.3, mu_m=0.0, alpha=2.0), rel=1e-14)
    assert one(V=0.3, N=9.81, mu_s=0.2, mu_m=0.2, alpha=2.0) == 0
    assert one(V=0.3, N=9.81, mu_s=0.5, mu_m=0.2, alpha=0.0) == 0
    # What falls and what rises cancel to ten digits at small speeds: the inputs still say what is left.
    viscous = form_of("exponential_viscous", "least_squares")
    columns = {"V": 1e-11, "N": 2.0, "mu_s": 0.5, "mu_k": 0.25, "alpha": 3.0, "mu_v": 0.75 * (1 - 1e-10)}
    columns = {name: np.array([value]) for name, value in columns.items()}
    assert accuracy.units(viscous, columns, viscous(**columns)).max() <= MOST_UNITS_BY_BALLS


TEXTS = [
    ("exponential", "least_squares"), ("exponential", "harmonic"), ("polynomial", "least_squares"),
    ("hyperbolic", "least_squares"), ("two_exponentials", "harmonic"),
    ("tanh", "least_squares"), ("arcsinh", "harmonic"), ("exponential_viscous", "least_squares"),
    ("quintic", "harmonic"), ("hyperbolic", "equilibrium"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "criterion"), some(TEXTS, 0, 4, 5))
def test_texts(name, criterion, tmp_path):
    form = form_of(name, criterion)
    columns = accuracy.samples(form.law, "middle", 3 if name in SLOW_REFERENCE else 12, seed=4)
    module = {}
    exec(compile(form.code("python"), "text", "exec"), module)
    got = module["damping"](**columns)
    exact = accuracy.reference(form, columns)
    assert accuracy.units(form, columns, got, exact).max() <= most(name)
    scalars = {key: float(column[0]) for key, column in columns.items()}
    assert module["damping"](**scalars) == pytest.approx(float(got[0]), rel=1e-15)
    if shutil.which("gcc"):
        function = compiled(form.code("c"), tmp_path, len(form.arguments))
        got = [function(*row) for row in zip(*(columns[key] for key in form.arguments), strict=True)]
        assert accuracy.units(form, columns, got, exact).max() <= most(name)


JUMPING = [
    ("mu_0 + b*Abs(v - v_1)", "least_squares", {"mu_0": 0.3, "b": 0.1, "v_1": 0.7}),
    ("Piecewise((mu_s - b*v, v < v_1), mu_m)", "least_squares", {"mu_s": 0.5, "b": 0.1, "v_1": 0.4, "mu_m": 0.2}),
    ("Piecewise((1 - v, v < p), (0.2*v, v < q), 0.1)", "harmonic", {"p": 0.8, "q": 0.4}),  # a piece is not there
]


@pytest.mark.parametrize("case", some(range(3), 2))
def test_text_of_a_law_with_kinks_and_jumps(case, tmp_path):
    law, criterion, values = JUMPING[case]
    form = ss.derive(ss.FrictionLaw(law).bind(**values), criterion)
    module = {}
    exec(compile(form.code("python"), "text", "exec"), module)
    point = {"V": 0.5, "N": 2.0} | values
    given = {name: point[name] for name in inspect.signature(module["damping"]).parameters}
    expected = pytest.approx(float(form.evaluate(20, V=0.5, N=2.0)), rel=1e-14)
    assert form(V=0.5, N=2.0) == expected
    assert module["damping"](**given) == expected
    if shutil.which("gcc"):
        assert compiled(form.code("c"), tmp_path, len(given))(*given.values()) == expected


SIGNED = [
    ("0.2 + 0.3*exp(-a*v)", -2.0), ("0.3*tanh(a*v)", -2.0), ("0.3/(1 + a*v)", -0.5), ("0.3*exp(-a*v)", 0.0),
    ("0.3*exp(-a*v^2)", 2.0), ("0.3*exp(-a*v^2)", -1.0), ("0.3*(1 + v)^a", 0.0), ("0.3*exp(v^2) + a", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "a", "criterion"), some([(*one, way) for one in SIGNED for way in BOTH], 0, 3, 4, 10)
)
def test_parameters_of_any_sign(text, a, criterion):
    law = ss.FrictionLaw(text, parameters=[ss.Parameter("a", positive=False)])
    average = ss.slope_average(law.bind(a=a), criterion)
    columns = {"V": np.array([0.01, 0.5, 0.9]), "N": np.full(3, 2.0)}
    got = average(**columns)
    expected = by_definition(average, columns)
    assert got == pytest.approx([float(value) for value in expected], rel=1e-13, abs=1e-15)
    assert average(V=0.5, N=2.0) == pytest.approx(got[1], rel=1e-14, abs=1e-15)

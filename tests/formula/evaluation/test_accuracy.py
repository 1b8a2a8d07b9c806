"""Every criterion of every law, held to a few units of epsilon N <|mu'|>.

The whole table: benchmarks/measure_accuracy.py.
"""

import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from itertools import pairwise, product

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from derivations import paper
from stickslip_sym.formula.evaluation.branch_builder import branches_of
from stickslip_sym.formula.slope_average import SlopeAverage
from support import accuracy
from support.accuracy import MOST_UNITS, MOST_UNITS_BY_BALLS, MOST_UNITS_OF_THE_PAPER, by_definition
from support.closed_forms import FORMS, NO_HARMONIC, NO_LEAST_SQUARES, form_of
from support.sweeps import sample, sweep

PAPER = ("exponential", "polynomial")
BOTH = ("least_squares", "harmonic")
SLOW_REFERENCE = {
    "tanh", "sech", "brown_mcphee", "simscape", "arcsinh", "gaussian", "gaussian_viscous", "stribeck",
    "stribeck_viscous",
}  # fmt: skip
KINDS = [
    ("exponential", "least_squares"), ("exponential", "harmonic"), ("polynomial", "least_squares"),
    ("tanh", "least_squares"), ("rational", "harmonic"), ("arctangent", "harmonic"), ("logarithmic", "harmonic"),
    ("two_exponentials", "least_squares"), ("exponential", "equilibrium"), ("tanh", "equilibrium"),
]  # fmt: skip
"""One of every kind of branch and of formula."""
AT_ONE_POINT = [(name, "equilibrium") for name in ("exponential", "gaussian", "lorentzian", "tanh", "polynomial")]


@sample(6)
@pytest.mark.parametrize("regime", ["middle", "small", "large"])
@sweep(("name", "criterion"), [*FORMS, *AT_ONE_POINT], *KINDS)
def test_over_all_decades(name, criterion, regime):
    if criterion == "equilibrium" and regime == "small":
        regime = "middle"
    if (regime != "middle" and name in SLOW_REFERENCE) or (name, regime) == ("quintic", "large"):
        pytest.skip("the reference takes minutes, or V^4 leaves the range of double precision")
    form = form_of(name, criterion)
    columns = accuracy.samples(form.law, regime, 3 if name in SLOW_REFERENCE else 12, seed=1)
    most = MOST_UNITS_OF_THE_PAPER if name in PAPER and criterion in BOTH else MOST_UNITS
    assert accuracy.units(form, columns, form(**columns)).max() <= most


def test_the_printed_formula_fails_that_test():
    """The negative control: (17) as lambdify gives it."""
    form = form_of("exponential", "least_squares")
    symbols = [*form.arguments.values()]
    names = [paper.exponential.get(symbol.name, symbol) for symbol in symbols]
    printed = sp.lambdify(names, paper.equations()["(17)"], "numpy")
    columns = accuracy.samples(form.law, "middle", 12, seed=1)
    with np.errstate(all="ignore"):
        values = printed(*(columns[name] for name in form.arguments))
    assert accuracy.units(form, columns, values).max() > 1e6


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


@sample(1)
@sweep(
    ("name", "scale", "power", "criterion"),
    [(*law, criterion) for law in (("exponential", "alpha", -1), ("polynomial", "v_m", 1)) for criterion in BOTH],
    ("exponential", "alpha", -1, "harmonic"), ("polynomial", "v_m", 1, "least_squares"),
)  # fmt: skip
@mpmath.workdps(30)
def test_over_six_hundred_decades(name, scale, power, criterion):
    """First a product of three extreme numbers, which may be out of range where the damping is not."""
    form, rng = form_of(name, criterion), np.random.default_rng(17)
    extreme = {key: 10 ** rng.uniform(-200, 200, 60) for key in ("V", "N", scale)}
    V = 10 ** rng.uniform(-300, 300, 60)  # and the speed of the law with it
    near = {"V": V, scale: V**power * 10 ** rng.uniform(-3, 3, 60), "N": rng.uniform(1, 9, 60)}
    columns = {key: np.concatenate([extreme[key], near[key]]) for key in extreme} | {"mu_s": 0.5, "mu_m": 0.2}
    columns = {key: np.broadcast_to(column, 120) for key, column in columns.items()}
    right = [form.evaluate(20, **{key: float(column[i]) for key, column in columns.items()}) for i in range(120)]
    inside = [i for i, c in enumerate(right) if abs(c) < 1e290]
    assert len(inside) > 80
    for value, i in zip(form(**{key: column[inside] for key, column in columns.items()}), inside, strict=True):
        units = MOST_UNITS if i < 60 else MOST_UNITS_OF_THE_PAPER
        tolerance = max(abs(right[i]) * units * accuracy.EPSILON, mpmath.mpf(2) ** -1074)
        assert abs(mpmath.mpf(float(value)) - right[i]) <= tolerance


@pytest.mark.parametrize("criterion", BOTH)
def test_the_polynomial_law_near_its_zero_and_far_from_it(criterion):
    form = form_of("polynomial", criterion)
    rng = np.random.default_rng(18)
    zero = np.sqrt(21 / 26) if criterion == "least_squares" else np.sqrt(0.8)
    ratio = np.concatenate([zero * (1 + 10 ** rng.uniform(-16, -1, 60)), 10 ** rng.uniform(-150, 150, 60)])
    v_m = 10 ** rng.uniform(-2, 2, 120)
    columns = {"V": ratio * v_m, "N": v_m, "mu_s": rng.uniform(0.3, 0.6, 120), "mu_m": rng.uniform(0, 0.3, 120)}
    columns["v_m"] = v_m
    assert accuracy.units(form, columns, form(**columns)).max() <= MOST_UNITS_OF_THE_PAPER


def test_no_extended_precision_is_needed():
    """As on Windows and on ARM, where a long double is a double."""
    text = (
        "print([repr(float(ss.slope_average(name, criterion)(V=0.31, N=9.81, **{\n"
        "    key: float(value) for key, value in ss.laws[name].typical().values.items()})))\n"
        "    for name, criterion in (('exponential', 'least_squares'), ('tanh', 'harmonic'))])\n"
    )
    head = "import numpy as np\nnp.longdouble = np.float64\nimport stickslip_sym as ss\n"
    command = [sys.executable, "-c", head + text]
    printed = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout
    with redirect_stdout(StringIO()) as here:
        exec(text, {"ss": ss})
    assert printed == here.getvalue()


# -- against enclosures of the definition ------------------------------------------------------------

PROFILES = [
    "exp(-v)", "v*exp(-v)", "exp(-v^2)", "1/(1 + v)", "1/(1 + v^2)", "log(1 + v)", "asinh(v)", "atan(v)",
    "tanh(v)", "sech(v)", "v^3 - 3*v", "v^0.25", "exp(-v^1.5)", "exp(-v^1.5)*tanh(v)", "exp(-sqrt(v))",
    "exp(-v^1.5)*tanh(50*v)", "(1 + v^8)^(-1/8)", "Piecewise((1 - v, v < 1), (0, True))",
    "Piecewise((v, v < 1), (2, v < 3), (exp(-v), True))",
]  # fmt: skip
"""Between them: every kind of branch, a logarithm far out, powers that are not whole, kinks and jumps, narrow
transitions that a rule may step over, and that end a power series early."""
ROOTS = ["log(1 + sqrt(v))", "v^0.75/(1 + v)"]
"""Far out a series in a root of 1/r, one beside another times log(r)."""
SOME = [(ROOTS[0], "harmonic"), (ROOTS[1], "least_squares"),
        ("exp(-v)", "least_squares"), ("tanh(v)", "harmonic"), ("v^0.25", "harmonic"),
        ("exp(-v^1.5)*tanh(50*v)", "least_squares"), ("exp(-v^1.5)", "harmonic"), (PROFILES[-1], "harmonic"),
        ("log(1 + v)", "harmonic")]  # fmt: skip


@sample(4)
@sweep(("text", "criterion"), list(product([*PROFILES, *ROOTS], BOTH)), *SOME, ids=str)
def test_every_branch_over_its_whole_range(text, criterion):
    """Also near its ends, and far beyond all scales; a number has the same digits in an array."""
    law = ss.FrictionLaw(text)
    branches = branches_of(law.expr, ss.criteria.find(criterion))
    rng = np.random.default_rng(38)
    last = 40 if text in ROOTS else 80  # the definition is not enclosed beyond
    ends = np.log2([2.0**-40, *branches.starts[1:], 2.0**last])
    places = [x for low, high in pairwise(ends) for x in (low + 1e-9, rng.uniform(low, high), high - 1e-9)]
    average = ss.slope_average(law, criterion)
    columns = {"V": 2.0 ** np.array(places), "N": np.ones(len(places))}
    exact = by_definition(average, columns)
    assert accuracy.units(average, columns, branches(columns["V"]), exact).max() <= MOST_UNITS
    assert [branches(float(r)) for r in columns["V"]] == list(branches(columns["V"]))


@pytest.mark.parametrize("criterion", BOTH)
def test_a_power_far_from_one(criterion):
    """Where V^-0.7 and V to the nearest float of that differ by many units."""
    form = ss.derive("v^0.3", criterion)
    columns = {"V": 10.0 ** np.array([-20, -9, 9, 20, 100]), "N": np.ones(5)}
    right = np.array([form.evaluate(30, **point) for point in ({"V": float(x), "N": 1} for x in columns["V"])])
    assert np.abs((form(**columns) / right - 1).astype(float)).max() <= MOST_UNITS_OF_THE_PAPER * accuracy.EPSILON


KINKED = [
    "0.3 + 0.1*Abs(v - 0.7)", "0.2 + Max(0.3 - 0.4*v, 0)", "0.3*exp(-v)*cos(3*v)",
    "Piecewise((0.5, v < 0.4), 0.2)", "Piecewise((exp(-v), v < 0.7), (0.3, v < 5), v)", "0.3*exp(-sin(v)^2)",
]  # fmt: skip
SIGNED = [
    ("0.2 + 0.3*exp(-a*v)", -2.0), ("0.3*tanh(a*v)", -2.0), ("0.3/(1 + a*v)", -0.25), ("0.3*exp(-a*v)", 0.0),
    ("0.3*exp(-a*v^2)", 2.0), ("0.3*exp(-a*v^2)", -1.0), ("0.3*(1 + v)^a", 0.0), ("0.3*exp(v^2) + a", 1.0),
]  # fmt: skip
CASES = [(ss.FrictionLaw(text), criterion) for text, criterion in product(KINKED, BOTH)]
CASES += [
    (ss.FrictionLaw(text, parameters=[ss.Parameter("a", positive=False)]).bind(a=a), criterion)
    for (text, a), criterion in product(SIGNED, BOTH)
]
CASES += [(ss.laws.catalogue[name].typical(), "harmonic") for name in sorted(NO_HARMONIC)]
CASES += [(ss.laws.catalogue[name].typical(), "least_squares") for name in sorted(NO_LEAST_SQUARES)]


@sample(3)
@sweep("case", range(len(CASES)), 1, 6, 12, 15, 16, 22)
def test_laws_of_any_shape(case):
    """Kinks, jumps and waves; parameters of any sign; laws without a closed form."""
    average = ss.slope_average(*CASES[case])
    columns = {"V": np.array([0.01, 0.21, 0.351, 0.36, 0.5, 0.9, 1.9]), "N": np.full(7, 2.0)}
    columns |= {name: np.full(7, float(value)) for name, value in average.law.values.items()}
    columns = {name: column for name, column in columns.items() if name in average.arguments}
    got = average(**columns)
    assert accuracy.units(average, columns, got, by_definition(average, columns)).max() <= MOST_UNITS_BY_BALLS


# -- terms that cancel -------------------------------------------------------------------------------

CANCELLING = {
    "a*exp(-p*v) - a*exp(-q*v)": {"N": 2.0, "a": 3.0, "p": 1.0, "q": 1.0},
    "a/(1 + v/p) - a/(1 + v/q)": {"N": 2.0, "a": 3.0, "p": 0.5, "q": 0.5},
    "(p*a - q)*exp(-v)": {"N": 2.0, "a": 3.3, "p": 2.1, "q": 6.93},
    "(p - q - a)*exp(-v)": {"N": 2.0, "a": 3.0, "p": 4.1, "q": 1.1},
    "(p^2 - q)/(1 + v)": {"N": 2.0, "p": 3.1, "q": 9.61},
}
"""Laws whose terms, or whose amplitude, vanish at these values."""
HIDING = ["a*v + a*w*exp(-v/w)", "a*v^2 + a*w^2*exp(-v^2/w^2)", "a*v - a*w*log(1 + v/w)"]
"""Laws whose terms cancel at low speeds, where their slope as it is computed does not."""


def cancelling(text):
    """Return an average, and operating points at which more and more of it cancels."""
    rng = np.random.default_rng(31)
    if text in CANCELLING:
        values, off = CANCELLING[text], 10 ** rng.uniform(-5.5, -0.5, 8)
        columns = {name: np.full(8, value) for name, value in values.items()}
        columns |= {"V": 10 ** rng.uniform(-1, 1, 8), "q": values["q"] * (1 + off)}
    else:
        w = 10 ** rng.uniform(-2, 2, 12)
        columns = {"V": w * 10 ** rng.uniform(-7, 1, 12), "N": np.full(12, 2.0), "a": np.full(12, 0.3), "w": w}
    return ss.slope_average(ss.FrictionLaw(text)), columns


@sample(4)
@pytest.mark.parametrize("text", [*CANCELLING, *HIDING])
def test_a_call_near_where_terms_cancel(text):
    average, columns = cancelling(text)
    got, right = average(**columns), by_definition(average, columns)
    assert accuracy.units(average, columns, got, right).max() <= MOST_UNITS_BY_BALLS
    assert [average(**{k: float(x[i]) for k, x in columns.items()}) for i in range(len(got))] == list(got)


def test_the_terms_alone_fail_that_test(monkeypatch):
    """The negative control: every sum is believed."""
    average, columns = cancelling(HIDING[0])
    right = by_definition(average, columns)
    monkeypatch.setattr(SlopeAverage, "_unit", lambda self, values: np.full(1, np.inf))
    assert accuracy.units(average, columns, average(**columns), right).max() > 1e3


@pytest.mark.parametrize("law", ["0.3 - 0.1/v", "0.3*coth(v/0.2) - 0.1/v"])
@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
def test_an_average_that_diverges_is_no_number(law, criterion):
    with pytest.raises(ss.InputError, match="its integral diverges"):
        ss.slope_average(law, criterion)(V=0.5, N=1.0)

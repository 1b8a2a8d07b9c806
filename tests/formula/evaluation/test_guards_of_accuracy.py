"""What decides which way a number is computed: each that is taken is within its bound, a poor one is not taken.

Scenes are drawn across the switch of the ways, where a guard that is too generous lets a poor value through.
"""

import math
import shutil
import subprocess

import accuracy
import mpmath
import numpy as np
import pytest
import sympy as sp
from accuracy import (
    MOST_UNITS,
    MOST_UNITS_BY_GAUSS,
    MOST_UNITS_OF_THE_PAPER,
    by_definition,
    compiled,
)

import stickslip_sym as ss
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.core.symbols import v
from stickslip_sym.criteria import gauss
from stickslip_sym.criteria.criterion import harmonic, least_squares
from stickslip_sym.formula.code.writer import code
from stickslip_sym.formula.derivation import closed_form
from stickslip_sym.formula.evaluation import branches, closed, fitting
from stickslip_sym.formula.evaluation.bounds import slope_with_bound
from stickslip_sym.formula.evaluation.conditioning import conditioned
from stickslip_sym.formula.evaluation.profile import profile_of

EPSILON = accuracy.EPSILON

# -- terms that cancel -------------------------------------------------------------------------------


def apart(count, low, high, seed):
    """Draw how far apart two numbers are, relatively, over some decades."""
    return 10 ** np.random.default_rng(seed).uniform(low, high, count)


CANCELLING = {
    "a*exp(-p*v) - a*exp(-q*v)": {"N": 2.0, "a": 3.0, "p": 1.0, "q": 1.0},
    "a/(1 + v/p) - a/(1 + v/q)": {"N": 2.0, "a": 3.0, "p": 0.5, "q": 0.5},
    "(p*a - q)*exp(-v)": {"N": 2.0, "a": 3.3, "p": 2.1, "q": 6.93},
    "(p - q - a)*exp(-v)": {"N": 2.0, "a": 3.0, "p": 4.1, "q": 1.1},
    "(p^2 - q)/(1 + v)": {"N": 2.0, "p": 3.1, "q": 9.61},
}
"""Laws whose terms, or whose amplitude, vanish at these values."""


@pytest.mark.parametrize("text", CANCELLING)
def test_a_call_is_accurate_however_near_its_terms_are_to_cancelling(text):
    average = ss.slope_average(ss.FrictionLaw(text))
    off = apart(8, -5.5, -0.5, seed=31)
    values = CANCELLING[text]
    columns = {name: np.full(8, value) for name, value in values.items()}
    columns |= {"V": 10 ** np.random.default_rng(32).uniform(-1, 1, 8), "q": values["q"] * (1 + off)}
    right = by_definition(average, columns)
    for got in (average(**columns), [average(**{k: float(x[i]) for k, x in columns.items()}) for i in range(8)]):
        assert accuracy.units(average, columns, got, right).max() <= MOST_UNITS_BY_GAUSS


HIDING = ["a*v + a*w*exp(-v/w)", "a*v^2 + a*w^2*exp(-v^2/w^2)", "a*v - a*w*log(1 + v/w)"]
"""Laws whose terms cancel at low speeds, where their slope as it is computed does not."""


def in_python(average, columns, _):
    module = {}
    exec(compile(code({"damping": average.function}, "a law", "python"), "text", "exec"), module)
    return module["damping"](**columns)


def in_c(average, columns, directory):
    function = compiled(code({"damping": average.function}, "a law", "c"), directory, len(average.arguments))
    return [function(*row) for row in zip(*(columns[name] for name in average.arguments), strict=True)]


def in_octave(average, columns, directory):
    arrays = ", ".join("[" + ", ".join(repr(float(x)) for x in columns[name]) + "]" for name in average.arguments)
    text = code({"damping": average.function}, "a law", "octave")
    (directory / "a.m").write_text(f'{text}\nprintf("%.17g\\n", damping({arrays}));\n')
    command = ["octave-cli", "--norc", "--quiet", "a.m"]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True, timeout=120, check=True)
    return [float(line) for line in done.stdout.split()]


WAYS = {"python": in_python, "gcc": in_c, "octave-cli": in_octave}


@pytest.fixture(params=WAYS)
def way(request):
    if shutil.which(request.param) is None and request.param != "python":
        pytest.skip(f"there is no {request.param}")
    return WAYS[request.param]


def scenes(text, offsets):
    """Return a law's average, scenes at speeds that are the scale w times an offset, and right values."""
    average = ss.slope_average(ss.FrictionLaw(text))
    w = 10 ** np.random.default_rng(34).uniform(-2, 2, len(offsets))
    ones = np.ones_like(w)
    columns = {"V": w * offsets, "N": 2 * ones, "a": 0.3 * ones, "w": w}
    return average, columns, by_definition(average, columns)


@pytest.fixture(scope="module")
def hidden():
    """Scenes over the decades in which more and more cancels."""
    return [scenes(text, apart(12, -7, 1, seed=33)) for text in HIDING]


def test_texts_take_another_way_where_terms_cancel(hidden, way, tmp_path):
    for i, (average, columns, right) in enumerate(hidden):
        (place := tmp_path / str(i)).mkdir()
        got = way(average, columns, place)
        assert accuracy.units(average, columns, got, right).max() <= MOST_UNITS, average


def test_a_call_takes_another_way_where_terms_cancel(hidden):
    for average, columns, right in hidden:
        assert accuracy.units(average, columns, average(**columns), right).max() <= MOST_UNITS, average


def test_the_terms_alone_fail_that_test(hidden):
    """The negative control: the Python text with its guard taken out."""
    average, columns, right = hidden[0]
    module = {}
    text = code({"damping": average.function}, "a law", "python")
    exec(text.replace("cancelled.any()", "False"), module)
    assert accuracy.units(average, columns, module["damping"](**columns), right).max() > 1e3


def test_texts_end_where_the_slope_itself_cancels(way, tmp_path):
    """The rules agree to what the slope is good for, never to the last digit, however often panels are halved."""
    average, columns, right = scenes("a*v - a*w*tanh(v/w)", np.array([1e-6]))
    (got,) = way(average, columns, tmp_path)
    assert abs(got - float(right[0])) <= MOST_UNITS * EPSILON * 2.0 * 0.3


# -- Gauss rules -------------------------------------------------------------------------------------


def test_an_average_of_waves_has_the_error_it_states_or_none():
    """The mean of cos(q(1 + s)) with the harmonic weight is cos(q) 2 J_1(q)/q."""
    turns = np.concatenate([10 ** np.random.default_rng(35).uniform(0, 6, 12), [10.0, 1e3, 3e6]])
    value, _, error = gauss.average(
        lambda x, q: (np.cos(q * x), 2 + 2 * q * x), np.ones_like(turns), [turns], harmonic, scale=1 / turns
    )
    right = [mpmath.cos(q) * 2 * mpmath.besselj(1, q) / q for q in map(mpmath.mpf, turns)]
    for got, bound, expected in zip(value, error, right, strict=True):
        assert abs(mpmath.mpf(float(got)) - expected) <= float(bound)
    assert np.isfinite(error[turns <= 1e3]).all()
    assert np.isinf(error[turns >= 1e6]).all()  # more waves than the panels can hold


@pytest.mark.parametrize("criterion", [least_squares, harmonic])
def test_the_stated_error_covers_an_error_of_the_slope_within_its_bound(criterion):
    rng = np.random.default_rng(36)
    for units in 10 ** rng.uniform(0, 6, 8):

        def off(x, signs, units=units):
            slope = np.exp(-x)
            return slope * (1 + signs * units * EPSILON), units * slope

        speed = 10 ** rng.uniform(-2, 1, 6)
        (plain, _, error), (low, _, _), (high, _, _) = (
            gauss.average(off, speed, [np.full(6, sign)], criterion) for sign in (0.0, -1.0, 1.0)
        )
        assert (np.abs(high - plain) <= error).all()
        assert (np.abs(low - plain) <= error).all()


# -- branches ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("variable", [1.0, 2.0, -1.0, -2.0, -0.5])
@pytest.mark.parametrize(("shift", "stretch", "decay"), [(0.0, 1.0, 0.0), (0.25, 3.0, 0.0), (0.0, 1.0, 0.5)])
def test_a_series_is_what_it_says(variable, shift, stretch, decay):
    rng = np.random.default_rng(37)
    coefficients = tuple(rng.uniform(0.1, 1, 4))
    branch = branches.Series(0.0, coefficients, decay, variable, shift, stretch)
    r = 10 ** rng.uniform(-2, 2, 20)
    for one, got in zip(r, branch(r), strict=True):
        terms = [c * ((mpmath.mpf(one) ** variable - shift) * stretch) ** k for k, c in enumerate(coefficients)]
        factor = mpmath.exp(-decay * one)
        allowed = 16 * EPSILON * float(factor * (1 + decay * one) * sum(map(abs, terms)))
        # A shift cancels, and takes the rounding of what it is taken from with it.
        allowed *= 1 + abs(shift / (one**variable - shift))
        for value in (got, branch(one)):
            assert abs(value - factor * mpmath.fsum(terms)) <= allowed


PROFILES = [
    (sp.exp(-v), least_squares), (sp.log(1 + v), least_squares), (sp.tanh(v), harmonic),
    (sp.exp(-sp.sqrt(v)), harmonic), (1 / (1 + v), harmonic),
]  # fmt: skip
"""Between them: every kind of branch, a logarithm far out, and a function with no series at 0."""


@pytest.mark.parametrize(("mu", "criterion"), PROFILES)
def test_every_branch_serves_its_whole_range(mu, criterion):
    """Also between the points at which it was made, near its ends, and 400 binary orders beyond the last.

    A range may reach beyond where the next branch, which takes less time, begins.
    """
    profile = profile_of(mu, criterion)
    slope = slope_with_bound(conditioned(sp.diff(mu, v)), [v])
    rng = np.random.default_rng(38)
    ends = [min(end, 2.0**450) for end in profile.ends]
    for branch, start, end in zip(profile.branches, profile.starts, ends, strict=True):
        if branch is None:
            continue
        low, high = math.log2(start) if start else -450, math.log2(end)
        places = np.concatenate(
            [low + rng.uniform(0, 1, 20), rng.uniform(low, high, 20), high - rng.uniform(0, 1, 20)]
        )
        r = 2.0 ** np.clip(places, low, high - 1e-9)
        extended = r.astype(np.longdouble)
        value, size, error = gauss.average(
            slope, extended, [], criterion, scale=np.ones_like(extended), tolerance=2.0**-60
        )
        assert (error <= EPSILON * size).all()
        over = extended**-branch.power
        assert (np.abs(branch(r) + value * over) <= MOST_UNITS_OF_THE_PAPER * EPSILON * size * over).all()
        got = [branch(float(one)) for one in r]
        assert (np.abs(np.array(got) + value * over) <= MOST_UNITS_OF_THE_PAPER * EPSILON * size * over).all()


def test_a_closed_form_serves_only_where_its_terms_do_not_cancel():
    """Looked at closely where it begins: a few points alone may all be lucky."""
    profile = profile_of(sp.exp(-v), least_squares)
    (start, branch) = next(
        pair for pair in zip(profile.starts, profile.branches, strict=True) if isinstance(pair[1], closed.Closed)
    )
    r = start * 2 ** np.random.default_rng(1).uniform(0, 0.5, 2000)
    slope = slope_with_bound(sp.diff(sp.exp(-v), v), [v])
    extended = r.astype(np.longdouble)
    value, size, _ = gauss.average(slope, extended, [], least_squares, scale=np.ones_like(extended))
    off = np.abs(branch(r) * extended**branch.power + value)
    assert (off <= MOST_UNITS_OF_THE_PAPER * EPSILON * size).all()


@pytest.mark.parametrize("criterion", [least_squares, harmonic])
def test_a_power_series_is_none_or_right_wherever_the_pole_is(criterion):
    rng = np.random.default_rng(39)
    found = 0
    for distance in 10 ** rng.uniform(-1.5, 2, 14):
        pole = sp.Rational(float(distance))
        slope = -pole / (v + pole) ** 2
        series = fitting.taylor(slope, criterion, 0.0)
        assert series is not None or distance < 1
        assert series is None or distance > 0.25  # a pole that is nearer leaves too short a range
        if series is None:
            continue
        found += 1
        coefficients, radius = series
        exactly = [criterion.mean_power(k) * (-1) ** k * (k + 1) / pole ** (k + 1) for k in range(20)]
        with mpmath.workdps(40):
            reach = mpmath.mpf(radius) / 4  # as far as a series is used
            right = [to_mpf(c) * reach**k for k, c in enumerate(exactly)]
            off = [abs(c * reach**k - right[k]) for k, c in enumerate(coefficients[:20])]
            assert max(off) <= mpmath.mpf("1e-20") * max(map(abs, right))
    assert found > 4


# -- quadrature and the gate -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a*exp(-alpha*v)", {"a": "0.3", "alpha": "3"}),
        ("a*exp(-alpha*v)", {"a": "0.3", "alpha": "300"}),
        ("a*exp(-alpha*v)", {"a": "0.3", "alpha": "1e-6"}),
        ("a/(1 + v/w)", {"a": "0.3", "w": "0.01"}),
        ("a*log(1 + v/w)", {"a": "0.3", "w": "0.002"}),
        ("a*w^2/(w^2 + (v - b)^2)", {"a": "0.3", "w": "0.01", "b": "0.3"}),
    ],
)
def test_quadrature_has_the_digits_that_are_asked_for(text, values):
    """Poles near the interval and cancellation, where a rule converges slowly."""
    law = ss.FrictionLaw(text).bind(**values)
    form = ss.derive(law, search=False)
    right = form.evaluate(80, V="0.7", N=3)
    for digits in (5, 9, 14, 20, 31):
        got = ss.quadrature.damping(law, V="0.7", N=3, digits=digits)
        with mpmath.workdps(80):
            assert abs(got - right) <= abs(right) * mpmath.mpf(10) ** (1 - digits)


def test_the_gate_refutes_what_is_wrong_in_any_digit_that_it_says_it_compared():
    law = ss.laws.exponential
    form = ss.derive(law, search=False)
    stated = int(form.gate.evidence.split(" digits")[0].split()[-1])
    for off in (1, 8, 16, stated - 3, stated - 2, stated - 1, stated):
        wrong = form.expr * (1 + sp.Rational(3, 10**off))
        assert closed_form.verify(law, least_squares, wrong).status is ss.Status.REFUTED


def test_no_coefficient_of_an_entire_function_is_cut_off():
    """Those of exp(-v) fall like 2^k/k!, to 1e-64 of the first."""
    coefficients, radius = fitting.taylor(-sp.exp(-v), harmonic, 0.0)
    assert radius == 24
    for k, coefficient in enumerate(coefficients):
        right = to_mpf(harmonic.mean_power(k) * (-1) ** k / sp.factorial(k))
        assert abs(coefficient - right) <= mpmath.mpf("1e-12") * abs(right)

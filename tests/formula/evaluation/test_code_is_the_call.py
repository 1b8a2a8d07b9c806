"""Code in C, Python and Octave against calls: laws of the literature, speeds over twenty-one decades."""

import inspect
from dataclasses import replace

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.formula.evaluation.branches import PanelTable
from stickslip_sym.formula.evaluation.term_function import TermFunction
from support.exported_code import PROGRAMS, runs, values_of
from support.sweeps import sample, sweep

LAWS = {
    "1/(1 + exp((v - v_0)/w))": {"v_0": 0.1, "w": 0.02},
    "mu_0 + a*v*log(1 + v/v_0)": {"mu_0": 0.3, "a": 0.1, "v_0": 0.2},
    "mu_0 - d*log(1 + v/v_0)": {"mu_0": 0.5, "d": 0.02, "v_0": 0.1},
    "d*v/sqrt(v^2 + h^2)": {"d": 0.3, "h": 0.05},
    "mu_s/(1 - v/v_c)": {"mu_s": 0.3, "v_c": 40.0},
    "a/cosh(v/w)": {"a": 0.3, "w": 0.7},
    "a*exp(-(v/w)^1.4144337)": {"a": 0.3, "w": 0.0788816},
    "b*tanh(v/w) - d*v + a": {"a": 0.3, "b": 0.2, "d": 0.01, "w": 0.3},
    "a*atan(v/w) + b*exp(-v/q)": {"a": 0.1, "b": 0.3, "w": 0.2, "q": 3.0},
    "Max(a - b*v, d)": {"a": 0.5, "b": 0.3, "d": 0.2},
    "a + b*Abs(v - q)": {"a": 0.3, "b": 0.1, "q": 0.7},
    "Piecewise((a, v < q), (d, True))": {"a": 0.5, "d": 0.3, "q": 0.4},
    "a*v^(-0.25)": {"a": 0.3},
    "(a + b*v)/(1 + d*v + v^2)": {"a": 0.3, "b": 0.1, "d": 0.5},
    "Piecewise((0.5, v < 0.4), (0.2, True))": {},
}
UNITS = 64  # of eps N times the size of the largest term: code adds terms up as they are


def drawn(seed):
    """Return a law with values, an average, speeds, and what a call gives there; NaN where it refuses."""
    rng = np.random.default_rng(seed)
    text = list(LAWS)[seed % len(LAWS)]
    values = {name: value * 10 ** rng.uniform(-0.3, 0.3) for name, value in LAWS[text].items()}
    criterion = ("least_squares", "harmonic", "equilibrium")[seed // len(LAWS) % 3]
    law = ss.FrictionLaw(text).bind(**values)
    average = ss.slope_average(law, criterion)
    V = np.concatenate([10 ** rng.uniform(-12, 9, 20), 10 ** rng.uniform(-2, 2, 10), [0.0, -1.0, np.nan]])
    expected = []
    for speed in V:
        try:
            expected.append(average(V=float(speed), N=2.0))
        except ss.StickSlipError:
            expected.append(np.nan)
    return law, average, V, np.array(expected)


def sizes(average, V):
    """The sum of the sizes of the terms, in the unit that errors are counted in."""
    with np.errstate(all="ignore"):
        values = [V, 2.0, *(float(average.law.values[name]) for name in list(average.arguments)[2:])]
        return sum(np.abs(np.broadcast_to(term(values), V.shape)) for term in average.functions)


@sample(2)
@sweep("seed", range(45), 15, 33, 5, 29)
def test_code_equals_the_call(seed, tmp_path):
    law, average, V, expected = drawn(seed)
    point = {"N": 2.0} | {name: float(value) for name, value in law.values.items()}
    allowed = UNITS * np.finfo(float).eps * np.fmax(np.nan_to_num(sizes(average, V)), np.abs(expected))
    exec(average.code("python"), module := {})
    names = inspect.signature(module["damping"]).parameters
    for language in filter(runs, PROGRAMS):
        speeds = V if language in ("c", "javascript") else [V]  # the others take an array
        calls = [("damping", [point.get(name, speed) for name in names]) for speed in speeds]
        got = np.ravel(values_of(language, average.code(language), calls, tmp_path))
        where = f"{language}: {law.text} {dict(law.values)} {average.criterion.name}"
        assert np.isnan(got[np.isnan(expected)]).all(), where
        written = ~np.isnan(got)
        assert (np.abs(got - expected)[written] <= allowed[written] + 1e-300).all(), where
        assert np.isfinite(expected[written]).all(), where
        # What a call takes from balls, near the end of a law, code leaves out.
        assert written.sum() >= np.isfinite(expected).sum() - 2, where


@sample(1)
@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@pytest.mark.parametrize(
    "text", ["a*(1 + v/w)^(-n)", "a*v^p/(1 + (v/w)^n)", "a*log(1 + (v/w)^n)", "a/(1 + (v/w)^p)"]
)
def test_powers_without_a_common_step_are_written_each_alone(text, criterion):
    """Measured exponents are fractions over 2^52: a polynomial in the step that they share fits no memory."""
    scales = {"a": 0.1, "w": 0.25}
    law = ss.FrictionLaw(text)
    shapes = {name: value for name, value in {"n": 1.4567, "p": 0.7771}.items() if name in law.parameters}
    average = ss.slope_average(law.bind(**scales, **shapes), criterion)
    exec(average.code("python"), module := {})
    V = 10.0 ** np.linspace(-12, 12, 9)
    got = module["damping"](V, 2.0, **scales)
    exact = [float(ss.enclose(average.law, criterion, V=speed, N=2.0)) for speed in V]
    assert got == pytest.approx(exact, rel=UNITS * np.finfo(float).eps)


ANDERSSON = [("andersson", "least_squares")]  # its transition is far narrower than its scale


@sweep(
    ("name", "criterion"),
    [(name, criterion) for name in ss.laws for criterion in ss.criteria.catalogue],
    *ANDERSSON,
)
def test_what_is_written_is_checked(name, criterion):
    """The verdict is that of the branches which the text holds, each against an enclosure of the definition."""
    text = ss.slope_average(ss.laws[name].typical(), criterion).code("python")
    assert "As written CHECKED" in text or "As written PROVED: a constant law" in text


def test_a_wrong_coefficient_in_a_text_refutes_it(monkeypatch):
    average = ss.slope_average(ss.laws.tanh.typical())
    right = average.functions[-1].branches()
    rows = [getattr(branch, "rows", None) for branch in right.branches]
    wrong = tuple(
        b if row is None else PanelTable(row * (1 + 1e-13)) for b, row in zip(right.branches, rows, strict=True)
    )
    assert "As written CHECKED" in average.code("c")
    monkeypatch.setattr(TermFunction, "branches", lambda *args: replace(right, branches=wrong))
    assert "As written REFUTED" in average.code("c")


JUMPING = ["Piecewise((0.5 - 0.1*v, v < 0.3), (0.4 - 0.1*v, True))", "0.5 - 0.1*Max(v - 0.3, 0)"]


@pytest.mark.parametrize("text", JUMPING)
def test_an_average_that_jumps_or_begins_at_half_a_kink_is_checked(text, monkeypatch):
    """Where a weight is not 0 at its ends, a jump of mu at 2 V joins it at once."""
    uniform = ss.criteria.Criterion("uniform", sp.Rational(1, 2), "a test")
    average = ss.slope_average(text, uniform)
    written = average.code("python")
    assert "As written CHECKED" in written
    V = np.array([0.1, 0.15 * (1 - 1e-14), 0.15 * (1 + 1e-14), 0.2, 1.0])
    exact = [float(ss.enclose(text, uniform, V=speed, N=1)) for speed in V]
    assert values_of("python", written, [("damping", [V, 1.0])], None)[0] == pytest.approx(exact, abs=1e-14)
    function = average.functions[-1]
    right = function.branches()
    late = tuple(start * (1 + 1e-9 * (start > 0)) for start in right.starts)
    monkeypatch.setattr(TermFunction, "branches", lambda *args: replace(right, starts=late))
    assert "As written REFUTED" in average.code("python")

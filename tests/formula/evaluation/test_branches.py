"""Every branch of every law at its ends, against 40 digits of the definition.

A branch that was compared at a speed between its ends once was 8 % off at another.
"""

from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pytest
import sympy as sp
from flint import arb

import stickslip_sym as ss
from stickslip_sym.core.precision import working_precision
from stickslip_sym.formula.evaluation.branch_builder import compared
from stickslip_sym.formula.evaluation.branches import Branches, PanelTable, Sum
from stickslip_sym.formula.evaluation.reference_average import BITS, ReferenceAverage
from stickslip_sym.formula.evaluation.term_function import TermFunction
from stickslip_sym.numerics.known import Unknown
from support import accuracy
from support.sweeps import sample, sweep

DIGITS = 40
VANISHING = [
    "v",
    "1 - exp(-v)",
    "tanh(v)",
    "log(1 + v)",
    "1 - 1/(1 + v)",
    "v/(1 + v^2)",
    "atan(v)",
    "sqrt(1 + v) - 1",
]
"""Functions that vanish at rest, of which powers are taken."""
FALLING = ["exp(-v)", "1/(1 + v)", "(1 + v)^(-0.7)", "1/(1 + v^3)", "exp(-v^1.37)", "1/(1 + v^1.4)",
           "1/sqrt(1 + v + v^2)", "log(1 + v)/(1 + v)", "sech(v)", "exp(-v^2)", "1 - atan(v)"]  # fmt: skip
FEATURES = ["exp(-((v - 1)/{w})^2)", "tanh((v - 1)/{w})", "Max(1 - v/{w}, 0)", "exp(-v/{w})", "tanh(v/{w})"]
"""What varies within w, from 0.1 to 100."""


def random_law(seed):
    """Return a law of one term, or of two."""
    rng = np.random.default_rng(seed)
    factors = [str(rng.choice(FALLING))]
    if rng.random() < 0.6:
        factors.append(f"({rng.choice(VANISHING)})^{rng.choice(['0.4', '0.7', '1.5', '(1/3)', '2', '3'])}")
    if rng.random() < 0.3:
        factors.append(rng.choice(FEATURES).format(w=f"{10 ** rng.uniform(-1, 2):.3g}"))
    text = "*".join(f"({factor})" for factor in factors)
    return f"0.3*{text} + 0.1*{rng.choice(FALLING)}" if rng.random() < 0.3 else text


def speeds(average):
    """Return speeds at both sides of where branches meet, between them, and far beyond the first and the last."""
    V, rng = [], np.random.default_rng(3)
    values = [1.0, 1.0, *(float(average.law.values[name]) for name in list(average.arguments)[2:])]
    for function in average.functions:
        branches = function.branches(function.shape_values(values))
        if isinstance(branches, Unknown):
            continue  # a call asks balls
        point = {average.law.parameters[name].symbol: average.law.values[name] for name in average.law.values}
        scale = float(function.term.scale.xreplace(point))
        ends = [branches.starts[1] * 2.0**-30 if len(branches.starts) > 1 else 2.0**-30, *branches.starts[1:]]
        ends.append(max(ends[-1], 1.0) * 2.0**9)
        V += [scale * end * (1 + side * 1e-9) for end in ends for side in (-1, 1)]
        V += [scale * low * (high / low) ** rng.random() for low, high in pairwise(ends)]
    return np.array(V)


def errors(law, criterion):
    """Return the largest error of a call at those speeds, in units of eps N <|mu'|>."""
    average = ss.slope_average(law, criterion)
    V = speeds(average)
    if not V.size:
        return 0.0
    columns = {"V": V, "N": np.ones(V.size)}
    columns |= {name: np.full(V.size, float(average.law.values[name])) for name in list(average.arguments)[2:]}
    exact = accuracy.by_definition(average, columns, DIGITS)
    return accuracy.units(average, columns, average(V=V, N=1.0), exact).max()


CATALOGUE = [(name, criterion) for name in ss.laws for criterion in ss.criteria.catalogue]


@sweep(
    ("name", "criterion"),
    CATALOGUE,
    ("lorentzian", "least_squares"),
    ("gaussian", "equilibrium"),
    ("rational", "harmonic"),
)
def test_branches_of_the_catalogue_hold_at_their_ends(name, criterion):
    assert errors(ss.laws[name].typical(), criterion) <= accuracy.MOST_UNITS


@sample(1)
@sweep("seed", range(100), 3, 41)
def test_branches_of_random_laws_hold_at_their_ends(seed):
    criterion = list(ss.criteria.catalogue)[seed % 3]
    assert errors(random_law(seed), criterion) <= accuracy.MOST_UNITS, random_law(seed)


CLOSE_TO_REST = [
    ("(1 - exp(-v/0.1))^0.4", "least_squares"), ("0.2 + 0.3/(1 + (v/0.1)^3)", "least_squares"),
    ("0.2 + 0.3/(1 + (v/0.1)^3)", "harmonic"), ("0.2 + 0.3*(1 + v/0.1)*exp(-v/0.1)", "least_squares"),
]  # fmt: skip


@sample(1)
@sweep(("text", "criterion"), CLOSE_TO_REST, CLOSE_TO_REST[0], CLOSE_TO_REST[3])
def test_what_vanishes_at_rest_has_all_its_digits_there(text, criterion):
    """Relative to the value itself, down to V over the scale of 1e-20; exported code is the call."""
    average = ss.slope_average(text, criterion)
    V = 0.1 * 10.0 ** np.arange(-20, 1, 4)
    with mpmath.workdps(DIGITS):
        right = np.array(accuracy.by_definition(average, {"V": V, "N": np.ones(6)}, DIGITS))
        assert max(abs(average(V=V, N=1.0) / right - 1)) <= accuracy.MOST_UNITS * accuracy.EPSILON
        exec(average.code("python"), module := {})
        assert max(abs(module["damping"](V, 1.0) / right - 1)) <= accuracy.MOST_UNITS * accuracy.EPSILON


FAR_APART = [("tanh(v)*exp(-1e-15*v)", "harmonic", 1e7), ("log(1 + v + 1e-26*v^2)", "harmonic", 1e26),
             ("log((1e-30 + v)/(1 + v))", "harmonic", 1e-32)]  # fmt: skip


@sweep(("text", "criterion", "V"), FAR_APART, FAR_APART[0])
def test_features_far_apart(text, criterion, V):
    average = ss.slope_average(text, criterion)
    right = float(ss.enclose(text, criterion, V=V, N=1, digits=20))
    assert average(V=V, N=1.0) == pytest.approx(right, rel=1e-14)


def test_a_branch_that_is_off_at_one_end_only_is_refuted(monkeypatch):
    """The negative control: a term of the series at rest that no speed between its ends would show."""
    average = ss.slope_average("0.3/(1 + v)")
    right = average.functions[0].branches()
    first = right.branches[0]
    (function, coefficients), *rest = first.parts
    off = Sum(first.power, first.variable, ((function, (*coefficients[:-1], 1e8 * coefficients[-1])), *rest))
    assert "As written CHECKED" in average.code("c")
    monkeypatch.setattr(
        TermFunction, "branches", lambda *args: replace(right, branches=(off, *right.branches[1:]))
    )
    assert "As written REFUTED" in average.code("c")


REMOVABLE = [
    ("(1 + v/v_0)^(-n)", {"v_0": 0.3, "n": 2.0}), ("1/((1 + v/v_1)*(1 + v/v_2))", {"v_1": 0.3, "v_2": 0.3}),
    ("(1 + p*v)/(1 + q*v + r*v^2)", {"p": 0.1, "q": 0.5, "r": 0.0}),
    ("Max(mu_k, mu_s - a*v)", {"mu_k": 0.3, "mu_s": 0.3, "a": 0.2}),
    ("exp(-((v - v_0)/w)^2)", {"v_0": 0.0, "w": 0.3}),
]  # fmt: skip


@sample(2)
@sweep(("text", "values"), REMOVABLE, *REMOVABLE[:2], *REMOVABLE[3:])
def test_where_parameters_meet_a_form_has_the_value_of_its_definition(text, values):
    """Alone, to many digits, and beside an element that is nothing special."""
    form = ss.derive(text)
    right = float(ss.enclose(ss.FrictionLaw(text).bind(**values), V=0.5, N=1, digits=18))
    beside = {name: [1.1 * value or 0.1, value] for name, value in values.items()}
    got = form(V=0.5, N=1.0, **values), form.evaluate(20, V=0.5, N=1, **values), form(V=0.5, N=1.0, **beside)[1]
    assert [float(value) for value in got] == pytest.approx([right] * 3, rel=1e-14)


@sample(5)
@pytest.mark.parametrize("criterion", ["equilibrium", "least_squares", "harmonic"])
@pytest.mark.parametrize(
    "text",
    [
        "Piecewise((0.5 - 0.2*v, v < 0.7), 0.36)",
        "Max(0.5 - 0.2*v, 0.3)",
        "0.5 - 0.1*Min(v, 1) + 0.02*Max(v - 2, 0)",
        "Max(0.5*exp(-v), 0.2)",
    ],
)
def test_laws_in_pieces_have_branches(text, criterion):
    """Balls for every value of an array would take a thousand times as long."""
    average = ss.slope_average(text, criterion)
    assert all(isinstance(function.branches(), Branches) for function in average.functions)
    V = np.geomspace(1e-3, 1e3, 13) * 1.0003
    exact = accuracy.by_definition(average, {"V": V, "N": np.ones(V.size)})
    assert average(V=V, N=1.0) == pytest.approx(np.array(exact, dtype=float), rel=1e-13)


@pytest.mark.parametrize(
    ("name", "criterion", "farthest"),
    [("hyperbolic", "harmonic", 16), ("exponential", "harmonic", 32), ("logarithmic", "least_squares", 4)],
)
def test_how_far_out_a_series_holds(name, criterion, farthest):
    """Up to there go panels, and what is written as code."""
    (branches,) = (
        function.branches() for function in ss.slope_average(ss.laws[name].typical(), criterion).functions
    )
    assert branches.starts[-1] == farthest


def branches_of(text, criterion):
    (branches,) = (function.branches() for function in ss.slope_average(text, criterion).functions)
    return branches


def test_what_has_no_series_has_a_table_of_some_octaves():
    """One that is wider by half ends where floats do, and then there would be none."""
    assert branches_of("exp(-log(v)^2)", "equilibrium").starts[1] == 2.0**-24


def test_a_wave_has_a_table_of_a_few_periods():
    assert branches_of("sin(v)", "harmonic").starts[-1] == 32


def test_a_table_holds_some_hundred_numbers():
    (table,) = (branch for branch in branches_of("sech(v)", "harmonic").branches if isinstance(branch, PanelTable))
    assert table.rows.size < 400


@pytest.mark.parametrize(("off", "status"), [(8, "CHECKED"), (30, "REFUTED")])
def test_code_may_differ_from_the_definition_by_some_units(off, status):
    """The average of v^2 is -2 V, one branch of one number."""
    profile, criterion = ss.symbols.v**2, ss.criteria.catalogue["least_squares"]
    branches = branches_of("v^2", "least_squares")
    (((function, (coefficient,)),),) = [branch.parts for branch in branches.branches]
    moved = replace(branches.branches[0], parts=((function, (coefficient * (1 + off * accuracy.EPSILON),)),))
    verdict = compared(replace(branches, branches=(moved,)), profile, criterion, {})
    assert verdict.status.value == status


def test_some_dozens_of_pieces_an_octave_follow_a_slope():
    def value(profile):
        with working_precision(BITS):
            return ReferenceAverage(profile, ss.criteria.catalogue["harmonic"], None, {})(arb(1))

    assert value(sp.sin(100 * ss.symbols.v)).is_finite()
    with pytest.raises(ss.NotConverged):
        value(sp.sin(500 * ss.symbols.v))

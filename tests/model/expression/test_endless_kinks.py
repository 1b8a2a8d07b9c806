"""Kinks that move beyond all speeds as a parameter falls to 0, as q/a of Max(q - a*v, 0), and points that meet."""

import inspect
import random

import mpmath
import numpy as np
import pytest

import stickslip_sym as ss
from support.sweeps import sample

SPEEDS = np.array([0.0, 0.1, 1.0, 20.0, 1e6])
RNG = random.Random(407)
LAWS = {
    "Max(q - a*v, 0) + b*v": lambda v, q, b: q + b * v,
    "Min(a*v, q) - b*v": lambda v, q, b: -b * v,
    "Abs(a*v - q) + b*v": lambda v, q, b: q + b * v,
}


@sample(2)
@pytest.mark.parametrize("formula", LAWS)
def test_a_kink_beyond_all_speeds_is_none(formula):
    q, b = round(RNG.uniform(0.3, 0.6), 3), round(RNG.uniform(0.01, 0.2), 3)
    law, near = (ss.FrictionLaw(formula).bind(a=a, q=q, b=b) for a in (0, "1e-14"))
    assert law.mu(SPEEDS) == pytest.approx(LAWS[formula](SPEEDS, q, b))
    for criterion in ("equilibrium", "least_squares", "harmonic"):
        value = float(ss.enclose(law, criterion, V=1, N=2))
        assert value == pytest.approx(float(ss.enclose(near, criterion, V=1, N=2)), abs=1e-12)
        assert ss.slope_average(law, criterion)(V=1.0, N=2.0) == pytest.approx(value, abs=1e-13)
        assert float(ss.quadrature.damping(law, criterion, V=1, N=2)) == pytest.approx(value, abs=1e-13)


def test_what_has_no_limit_is_refused():
    """0/0 may be any place; and of a place over a difference the side is not known."""
    with pytest.raises(ss.InputError, match="no real number at these values"):
        ss.FrictionLaw("Max(q - a*v, 0)").bind(a=0, q=0)
    with pytest.raises(ss.InputError, match="no real number at these values"):
        ss.FrictionLaw("Piecewise((0.3, v < p/(a - b)), (0.2, True))").bind(a=1, b=1, p=1)


MEETING = {
    "Max(mu_k, mu_s - a*v)": {"mu_k": 0.3, "mu_s": 0.3, "a": 0.2},
    "(1 + p*v)/(1 + q*v + r*v^2)": {"p": 0.5, "q": 0.7, "r": 0},
    "exp(-a*v)*cos(b*v)": {"a": 0.3, "b": 0},
    "exp(-((v - v_0)/w)^2)": {"v_0": 0, "w": 0.4},
    "(1 + v/v_0)^(-n)": {"v_0": 0.5, "n": 2},
    "Max(q - a*v, 0) + b*v": {"a": 0, "q": 0.3, "b": 0.1},
}


@pytest.mark.parametrize("formula", MEETING)
def test_code_is_written_where_parameters_meet(formula):
    criterion = RNG.choice(["least_squares", "harmonic"])
    law = ss.FrictionLaw(formula).bind(**MEETING[formula])
    fast, namespace = ss.slope_average(law, criterion), {}
    exec(fast.code("python"), namespace)
    written = namespace["damping"]
    values = {"V": np.array([0.03, 0.7, 40.0]), "N": 2.0} | {key: float(x) for key, x in law.values.items()}
    names = list(inspect.signature(written).parameters)
    expected = [float(ss.enclose(law, criterion, V=V, N=2)) for V in values["V"]]
    assert written(*(values[name] for name in names)) == pytest.approx(expected, rel=1e-13, abs=1e-15)
    assert fast(V=values["V"], N=2.0) == pytest.approx(expected, rel=1e-13, abs=1e-15)


def test_points_are_the_same_as_floats_and_as_text():
    v, mu = (
        [0.0, *np.sort(np.round(np.random.default_rng(7).uniform(0.1, 2, 5), 3))],
        [0.3, 0.25, 0.31, 0.2, 0.22, 0.21],
    )
    law = ss.FrictionLaw.from_samples(v, mu)
    assert law == ss.FrictionLaw.from_samples([str(float(x)) for x in v], list(map(str, mu)))
    assert law != ss.FrictionLaw.from_samples(v, [*mu[:-1], 0.2100001])


@pytest.mark.parametrize(
    "formula", ["(1 + v/v_0)^(-n)", "1/((1 + v/v_1)*(1 + v/v_2))", "(1 + p*v)/(1 + q*v + r*v^2)"]
)
def test_evaluate_keeps_its_digits_where_parameters_meet(formula):
    values = MEETING.get(formula, {"v_1": 0.5, "v_2": 0.5})
    criterion = RNG.choice(["least_squares", "harmonic"])
    value = ss.derive(formula, criterion).evaluate(40, V="0.7", N=2, **values)
    with mpmath.workdps(60):
        exact = ss.enclose(ss.FrictionLaw(formula).bind(**values), criterion, V="0.7", N=2, digits=50).mid
        assert abs(value / mpmath.mpf(exact.numerator) * exact.denominator - 1) < 1e-39

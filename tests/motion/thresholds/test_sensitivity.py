"""How thresholds change with quantities and parameters: exact derivatives, against differences of many digits."""

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.motion.thresholds.grazing import grazing_sensitivity
from stickslip_sym.motion.thresholds.methods import Computed, Method
from support.operating_points import SMOOTH, smooth_points
from support.sweeps import sample, sweep

POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
KINK = "Piecewise((mu_s - a*v, v < v_1), (mu_s - a*v_1 + b*(v - v_1), True))"
JUMPS = {
    "down": "Piecewise((mu_s - a*v, v < v_1), (mu_s - a*v_1 - d + b*(v - v_1), True))",
    "up": "Piecewise((mu_s - 2*a*v, v < v_1), (mu_s - 2*a*v_1 + d - b*(v - v_1), True))",
}
POINTS = [0, 0.05, 0.1, 0.21, 0.43, 1.03, 2.0], [0.50, 0.44, 0.40, 0.34, 0.29, 0.27, 0.26]


def value_of(law, point, name):
    return point[name] if name in point else float(law.values[name])


def moved(law, point, along):
    """Return a law and a point, quantities and parameters multiplied by the exponentials of numbers."""
    new = {name: value_of(law, point, name) * np.exp(by) for name, by in along.items()}
    return law.bind(**{name: new[name] for name in law.parameters}), {name: new[name] for name in point}


def error_along(law, point, method, seed, step, rtol=1e-12):
    """Return the error of the derivative along a seeded direction, relative to the largest part of it.

    The direction changes all quantities and parameters by their logarithms; the difference is of the eighth order.
    """
    found = ss.pure_slip_damping(law, **point, method=method, rtol=rtol)
    names = sorted(found.sensitivity)
    rng = np.random.default_rng(seed)
    along = dict(zip(names, rng.choice([-1, 1], len(names)) * rng.uniform(0.5, 1, len(names)), strict=True))
    parts = [found.sensitivity[name] * value_of(law, point, name) * by for name, by in along.items()]
    total = 0.0
    for k, weight in {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}.items():
        for sign in (1, -1):
            law_there, there = moved(law, point, {name: sign * k * step * by for name, by in along.items()})
            total += sign * weight * ss.pure_slip_damping(law_there, **there, method=method, rtol=rtol).value
    return abs(sum(parts) - total / step) / max(abs(found.value), *map(abs, parts))


@sweep("count", [4, 100], 4)
def test_orbit_against_differences(count):
    """Of 100 the worst was off by 3e-13; the second order has its own derivatives, however strong friction is."""
    for law, point in smooth_points(np.random.default_rng(3), count):
        assert error_along(law, point, "second_order", 6, 4e-3) < 1e-8, (law, point)
        try:
            assert error_along(law, point, "orbit", 6, 4e-3) < 1e-8, (law, point)
        except ss.NotConverged:  # too strong a friction for the orbit
            continue


AT_JUMPS = [(0.55, 20.0), (0.6, 20.0), (0.8, 20.0), (1.0, 1.0), (1.0, 20.0)]


@sweep(("V", "N"), AT_JUMPS, *AT_JUMPS[1:])
def test_jumps_that_are_touched_or_at_the_belt_speed(V, N):
    """Where the highest slip speed touches a drop of mu, up to V = 0.6 m/s, and where mu drops at V."""
    law = ss.FrictionLaw("Piecewise((mu_s + a*exp(-b*v), v < v_1), (mu_s - d, True))")
    law = law.bind(mu_s=0.5, a=0.1, b=3, v_1=1, d=0.2)
    point = POINT | {"V": V, "N": N}
    assert error_along(law, point, "simulation", 7, 1e-4, 1e-10) < 1e-7


@sample(3)
@pytest.mark.parametrize("name", ["smooth", "kink", "down", "up", "static", "points"])
def test_simulation_against_differences(name):
    """With a kink, a jump down that is crossed, one up at which the mass slides, a static jump, and points."""
    formulas = {"smooth": "mu_s*exp(-a*v) + b*v", "kink": KINK, "static": "mu_s*exp(-a*v) + b*v", **JUMPS}
    if name == "points":
        law = ss.FrictionLaw.from_samples(*POINTS)
    else:
        law = ss.FrictionLaw(formulas[name], static="mu_st" if name == "static" else None)
        given = {"mu_s": 0.5, "a": 0.4, "b": 0.1, "v_1": 0.3, "d": 0.05, "mu_st": 0.57}
        law = law.bind(**{key: given[key] for key in law.parameters})
    assert error_along(law, POINT | {"V": 0.45}, "simulation", 7, 5e-3, 1e-11) < 1e-8


def test_stiff_slips_against_differences():
    """Of a light mass, whose implicit steps have a wedge of their own."""
    law, light = ss.laws.exponential.typical(), POINT | {"m": 1e-6}
    assert error_along(law, light, "simulation", 7, 5e-3, 1e-10) < 1e-7


AVERAGED = [
    (text, criterion)
    for text in ("mu_m + (mu_s - mu_m)*exp(-alpha*v)", JUMPS["down"])
    for criterion in ("equilibrium", "least_squares", "harmonic")
]


@sample(1)
@sweep(("text", "criterion"), AVERAGED, AVERAGED[2], AVERAGED[4])
def test_averages_against_differences_of_quadratures(text, criterion):
    """With 24 digits, whose differences have 12."""
    given = {"mu_s": "0.5", "mu_m": "0.2", "alpha": "3", "a": "0.4", "b": "0.1", "v_1": "0.3", "d": "0.05"}
    law = ss.FrictionLaw(text)
    law = law.bind(**{name: given[name] for name in law.parameters})
    found = ss.pure_slip_damping(law, V=0.5, N=9.81, method=criterion).sensitivity
    step = sp.Rational(1, 10**7)
    for name in {"V", "v_1", "d", "alpha"} & set(found):  # in the others it is linear
        ends = []
        for sign in (1, -1):
            values = {"V": sp.Rational(1, 2), "N": sp.Rational("9.81")} | law.values
            values[name] += sign * step
            there = {key: values.pop(key) for key in "VN"}
            ends.append(ss.quadrature.damping(law.bind(**values), criterion, **there, digits=24))
        with mpmath.workdps(24):
            difference = float((ends[0] - ends[1]) / 2 * 10**7)
        assert found[name] == pytest.approx(difference, rel=1e-10, abs=1e-11), name


@sample(2)
@pytest.mark.parametrize("criterion", ["least_squares", "harmonic"])
@pytest.mark.parametrize("delta", [7, 60])
def test_averages_of_a_steep_fall(delta, criterion):
    """Stribeck's law with a large exponent falls as a step; c is as mu_s - mu_m, and of degree -1 in speeds."""
    law = ss.laws.stribeck.typical(delta=delta, v_s="0.2")
    c = float(ss.enclose(law, criterion, V="0.8", N="9.81", digits=15))
    found = ss.pure_slip_damping(law, V=0.8, N=9.81, method=criterion).sensitivity
    assert (0.5 - 0.2) * found["mu_s"] == pytest.approx(c, rel=1e-11)
    assert 0.8 * found["V"] + 0.2 * found["v_s"] == pytest.approx(-c, rel=1e-11)


SPEEDS = {"1": 0, "s/m": -1, "m/s": 1, "s^2/m^2": -2, "s^3/m^3": -3}
"""The power of m/s that a unit is."""


@pytest.mark.parametrize("method", ["equilibrium", "least_squares", "harmonic", "second_order", "orbit"])
def test_eulers_identities(method):
    """N c_N + m c_m + k c_k = c, m c_m = k c_k, and all with a speed in its unit adds to 0, N as one."""
    # The first call of a law makes its function.
    count = 3 if method in ("least_squares", "harmonic") else len(SMOOTH)
    for law, point in smooth_points(np.random.default_rng(5), count):
        try:
            found = ss.pure_slip_damping(law, **point, method=method, rtol=1e-10 if method != "orbit" else 1e-12)
        except ss.NotConverged:
            continue
        size = {name: value * value_of(law, point, name) for name, value in found.sensitivity.items()}
        scale = max(map(abs, size.values()))
        assert size["N"] + size["m"] + size["k"] == pytest.approx(found.value, abs=1e-9 * scale)
        assert size["m"] == pytest.approx(size["k"], abs=1e-12 * scale)
        speeds = {"V": 1, "N": 1} | {name: SPEEDS[p.unit] for name, p in law.parameters.items()}
        assert sum(power * size[name] for name, power in speeds.items()) == pytest.approx(0, abs=1e-9 * scale)


def test_arrays_each_point_by_its_own_method():
    law = ss.laws.exponential.typical()
    V = np.array([[0.2, 0.5], [1.0, 4.0]])
    found = ss.pure_slip_damping(law, **POINT | {"V": V}, rtol=1e-3)
    assert len(set(found.method.ravel())) > 1
    for place in np.ndindex(V.shape):
        one = ss.pure_slip_damping(law, **POINT | {"V": V[place]}, method=str(found.method[place]), rtol=1e-3)
        for name, column in found.sensitivity.items():
            assert column.shape == V.shape
            assert column[place] == pytest.approx(one.sensitivity[name], rel=1e-12)


def test_a_method_of_ones_own():
    """It changes as the threshold does, if it does not say how; `test_extending` has one that does."""
    own = Method("own", lambda points, rtol: Computed(2 * points.N, 0 * points.N))
    law = ss.laws.exponential.typical(mu_s="0.50(2)")
    found = ss.pure_slip_damping(law, **POINT, method=own)
    assert repr(found).startswith("Threshold: 19.62 +/- 0.17 kg/s")
    assert found.sensitivity == ss.pure_slip_damping(law, **POINT, method="simulation").sensitivity


def test_changes_that_are_lost_in_rounding_are_not_stated():
    """Of `rational` on a belt of 1e12 m/s all friction acts within 1e-12 of a swing."""
    law, osc = ss.laws.rational.typical(), ss.Oscillator(V=1e12, N=1, m=1, k=1, c=0)
    with pytest.raises(ss.NotConverged, match="lost in rounding"):
        grazing_sensitivity(law, osc)
    weak = grazing_sensitivity(law, ss.Oscillator(V=5.0, N=1e-6, m=1, k=1, c=0))
    by_slope = ss.pure_slip_damping(law, V=5.0, N=1e-6, m=1, k=1, method="second_order").sensitivity
    assert weak["N"] == pytest.approx(by_slope["N"], rel=1e-5)

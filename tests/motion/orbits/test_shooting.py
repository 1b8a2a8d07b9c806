"""Orbits of strong friction: shooting from both ends against collocation and another integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import stickslip_sym as ss
from stickslip_sym.motion.orbits.expansion import averages, slopes
from stickslip_sym.motion.orbits.orbit import orbits
from stickslip_sym.motion.orbits.shooting import shoot

EXPONENTIAL = ss.laws.exponential.typical()
SPEEDS = np.linspace(0.01, 1.0, 101)
LAWS = ["exponential", "polynomial", "hyperbolic", "gaussian", "lorentzian", "arctangent", "sech", "kragelskii"]


def shots(law, V, strength, A, start=1.0):
    """Shoot from the harmonic damping, or from a multiple of it."""
    with np.errstate(all="ignore"):
        return shoot(slopes(law), V, strength, A, start * strength * averages(law, V, A)[0])


def halves(law, V, strength, d, method, rtol):
    """Follow the slip from the graze both ways to w = 1: time, ratio of u there, and the highest w."""
    ends = []
    for direction in (1.0, -1.0):

        def rates(_, y, direction=direction):
            w, u = y
            g = -strength * law.slope(V * max(w, 0.0))
            return [direction * u, direction * ((g - d) * u + 1 - w)]

        def arrives(_, y, direction=direction):
            return direction * (y[0] - 1)

        def crest(t, y):
            return y[1] if t > 0 else 1.0

        arrives.terminal, arrives.direction = True, -1.0
        crest.direction = -1.0
        found = solve_ivp(rates, (0, 60), [0.0, 0.0], method, events=(arrives, crest), rtol=rtol, atol=rtol / 100)
        assert found.status == 1
        ends.append((found.t[-1], found.y[1, -1], found.y_events[1]))
    (ahead, u, (top, *_)), (back, other, _) = ends
    return ahead + back, u / other, top[0]


@pytest.mark.parametrize("name", LAWS)
def test_shooting_finds_the_orbits_of_collocation(name):
    """Grazing ones and lower ones, at seeded speeds and frictions that both ways manage."""
    rng = np.random.default_rng(LAWS.index(name))
    law = ss.laws.catalogue[name].typical()
    V, strength = 10 ** rng.uniform(-1.3, 0, 12), 10 ** rng.uniform(-1, 0.4, 12)
    A = np.where(rng.random(12) < 0.5, 1.0, rng.uniform(0.1, 1.0, 12))
    known, found = orbits(law, V, strength, A, rtol=1e-13), shots(law, V, strength, A)
    resolved = known.relative_error < 1e-11
    assert resolved.sum() > 8
    scale = found.scale[resolved]
    assert (np.abs(found.d - known.d)[resolved] < 1e-13 * np.maximum(1, scale)).all()
    assert (np.abs(found.d - known.d) <= 2 * (found.error + known.error * known.scale))[resolved].all()
    for mine, theirs in (
        (found.period, 2 * np.pi / known.frequency),
        (1 - found.highest, known.lowest),
        (found.exponent, known.exponent),
    ):
        # The lowest velocity of collocation is that at one of its points.
        near = 1e-2 if theirs is known.lowest else 1e-9 * (1 + scale)
        assert (np.abs(mine - theirs)[resolved] < near).all()


@pytest.mark.parametrize(("V", "strength"), [(0.2, 9.81), (0.5, 9.81), (1.0, 15.0)])
def test_a_strong_orbit_is_that_of_another_integrator(V, strength):
    found = shots(EXPONENTIAL, *np.atleast_1d(V, strength, 1.0))
    d = float(found.d[0])
    period, growth, top = halves(EXPONENTIAL, V, strength, d, "LSODA", 1e-11)
    assert abs(growth - 1) < 1e-7
    assert period == pytest.approx(found.period[0], abs=1e-7)
    assert top == pytest.approx(found.highest[0], abs=1e-8)
    # Another damping, a hundred thousandth off, does not close.
    assert abs(halves(EXPONENTIAL, V, strength, d * (1 + 1e-5), "LSODA", 1e-11)[1] - 1) > 1e-6


@pytest.mark.parametrize("start", [0.5, 0.9, 2.5])
def test_the_first_guess_does_not_matter(start):
    """Down to dampings with which the equilibrium repels without turns, up to some with which it draws so."""
    V, strength = np.array([0.1, 0.3, 0.6, 1.0]), np.full(4, 9.81)
    near, far = (shots(EXPONENTIAL, V, strength, np.ones(4), factor) for factor in (1.0, start))
    assert np.abs(far.d / near.d - 1).max() < 1e-13
    assert np.abs(far.period / near.period - 1).max() < 1e-9


def test_one_speed_among_many_is_that_speed_alone():
    scene = {"N": 9.81, "m": 1.0, "k": 1.0, "method": "orbit"}
    many = ss.pure_slip_damping(EXPONENTIAL, V=SPEEDS, rtol=1e-10, **scene).value
    for row in (3, 20, 50, 77, 100):
        alone = ss.pure_slip_damping(EXPONENTIAL, V=SPEEDS[row], rtol=1e-12, **scene)
        assert abs(many[row] / alone.value - 1) < 6e-14 + 2e-10 * (row < 14)  # collocation's, at its own tolerance


def test_few_tries_are_made():
    """A way all round takes 34,000 evaluations: its growth hides the root behind 5 orders of magnitude."""
    calls = []
    slope = slopes(EXPONENTIAL)

    def counted(v):
        calls.append(v.size)
        return slope(v)

    V, strength = SPEEDS[14:], np.full(87, 9.81)
    with np.errstate(all="ignore"):
        found = shoot(counted, V, strength, np.ones(87), strength * averages(EXPONENTIAL, V)[0])
    assert np.isfinite(found.d).all()
    assert len(calls) < 8000


def test_a_law_without_a_value_is_not_found():
    """Nor are other rows harmed."""

    def torn(v):
        return np.where(v > 0.8, np.nan, -0.9 * np.exp(-3 * v))

    V, ones, guess = np.array([0.3, 0.5]), np.ones(2), np.array([0.4, 0.4])
    with np.errstate(all="ignore"):
        found, whole = shoot(torn, V, ones, ones, guess), shoot(slopes(EXPONENTIAL), V, ones, ones, guess)
    assert np.isnan(found.d[1])
    assert abs(found.d[0] / whole.d[0] - 1) < 1e-13

"""Speeds in another unit: with v, V and N times a power of two, the damping is the same to the last digits."""

from fractions import Fraction
from functools import partial

import numpy as np
import pytest

import stickslip_sym as ss
from support.sweeps import sweep

TERMS = [
    "0.1*tanh((v - {b})/{w})", "0.1*exp(-((v - {b})/{w})^2)", "1/(1 + (v/{a})^2)", "0.05*exp(-v/{w})",
    "Piecewise((0, v < {b}), (0.05, True))", "0.02*sin(v/{u})*exp(-v/{a})", "-0.1*Max(v - {b}, 0)/{a}",
]  # fmt: skip
"""Narrow within w of b, or not."""
METHODS = ["simulation", "orbit", "second_order", "harmonic", "least_squares"]


def answers(seed, factor):
    """Return thresholds, and limit cycles over the belt speed, of a random law with all speeds times a factor."""
    rng = np.random.default_rng(seed)
    places = {"a": rng.uniform(0.1, 1), "b": rng.uniform(0.1, 1), "w": 10 ** rng.uniform(-7, -1), "u": 0.05}
    places = {name: f"({Fraction(place) * factor})" for name, place in places.items()}
    terms = ["0.2", "0.3*exp(-v/{a})", *rng.choice(TERMS, 2, replace=False)]
    law = ss.FrictionLaw(" + ".join(terms).format(**places))
    V, N, c = rng.uniform(0.2, 0.8) * float(factor), 10 ** rng.uniform(-1, 1) * float(factor), rng.uniform(0.2, 3)
    point = {"V": V, "N": N, "m": 1, "k": 100}
    calls = [partial(threshold, law, point, method) for method in METHODS]
    for call in [*calls, partial(cycles, law, ss.Oscillator(**point, c=c))]:
        try:
            yield call()
        except (ss.InputError, ss.NotConverged) as error:
            yield type(error)


def threshold(law, point, method):
    return ss.pure_slip_damping(law, **point, method=method).value


def cycles(law, osc):
    return [cycle.amplitude / osc.V for cycle in ss.limit_cycles(law, osc)]


@sweep(("seed", "power"), [(seed, power) for seed in range(40) for power in (-60, -20, 20)], (2, -60), (6, 20))
def test_the_unit_of_speed_means_nothing(seed, power):
    for plain, scaled in zip(answers(seed, Fraction(1)), answers(seed, Fraction(2) ** power), strict=True):
        if isinstance(plain, type):
            assert scaled is plain
        else:
            assert scaled == pytest.approx(plain, rel=1e-10)

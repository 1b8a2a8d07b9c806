"""Thresholds of laws in pieces: python -m pytest tests/benchmarks/bench_pieces.py -n 0

`python tests/benchmarks/bench_pieces.py` prints the same in one run, with what steps in time alone take, and with
what a threshold costs among 150 that are found together. Maps are in `bench_planes`.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from families import family_of
from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym.motion.regimes.touch import touching_dampings
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.thresholds.grazing import grazing_damping

SPEEDS = np.linspace(0, 1.3, 12)
MEASURED = ss.FrictionLaw.from_samples(SPEEDS, 0.2 + 0.3 * np.exp(-3 * SPEEDS), extrapolate=True)
KINKED = ss.FrictionLaw("0.5 - 0.3*Min(v, 0.7)")
LAWS = {"measured": MEASURED, "kinked": KINKED, "logarithmic": ss.laws.logarithmic.typical()}
MANY = 150


@pytest.mark.parametrize("law", LAWS)
def test_threshold(benchmark, law):
    benchmark(grazing_damping, LAWS[law], paper_oscillator(), rtol=1e-8)


def table():
    """Print CPU milliseconds a threshold."""

    def cost(call, times):
        costs = []
        for _ in range(times):
            begin = time.process_time()
            call()
            costs.append(time.process_time() - begin)
        return min(costs) * 1e3

    arrive = Levels.arrive
    print(f"{'CPU ms':>20}{'levels':>10}{'in time':>10}{'together':>10}")
    for name, law in LAWS.items():
        costs = []
        for way in (arrive, lambda *_: None):
            Levels.arrive = way
            costs.append(cost(lambda law=law: grazing_damping(law, paper_oscillator(), rtol=1e-8), 5))
        Levels.arrive = arrive
        family = family_of(law, np.linspace(0.2, 0.9, MANY), np.linspace(0.3, 4, MANY))
        costs.append(cost(lambda family=family: touching_dampings(family, np.full(MANY, 0.1)), 2) / MANY)
        print(f"{name:>20}" + "".join(f"{value:10.2f}" for value in costs))


if __name__ == "__main__":
    table()

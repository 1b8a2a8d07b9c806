"""Thresholds and maps of laws in pieces: python -m pytest tests/benchmarks/bench_pieces.py -n 0

`python tests/benchmarks/bench_pieces.py` prints the same in one run, with what steps in time alone take.
"""

import sys
import time
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from scenes import paper_oscillator

import stickslip_sym as ss
from stickslip_sym.motion.simulation.levels import Levels
from stickslip_sym.motion.thresholds.grazing import grazing_damping

SPEEDS = np.linspace(0, 1.3, 12)
MEASURED = ss.FrictionLaw.from_samples(SPEEDS, 0.2 + 0.3 * np.exp(-3 * SPEEDS), extrapolate=True)
KINKED = ss.FrictionLaw("0.5 - 0.3*Min(v, 0.7)")
LAWS = {"measured": MEASURED, "kinked": KINKED, "logarithmic": ss.laws.logarithmic.typical()}
PLANE = {"x": ("V", np.linspace(0.1, 0.6, 20)), "y": ("c", np.linspace(0.3, 5, 15)), "N": 9.81, "m": 1, "k": 100}
WITHOUT_C = {"x": ("V", np.linspace(0.3, 0.8, 6)), "y": ("N", np.linspace(2, 20, 5)), "c": 2, "m": 1, "k": 100}


@pytest.mark.parametrize("law", LAWS)
def test_threshold(benchmark, law):
    benchmark(grazing_damping, LAWS[law], paper_oscillator(), rtol=1e-8)


@pytest.mark.parametrize("plane", [PLANE, WITHOUT_C], ids=["V by c", "V by N"])
@pytest.mark.parametrize("law", LAWS)
def test_map(benchmark, law, plane):
    benchmark.pedantic(ss.motion_map, (LAWS[law],), plane, rounds=1)


def table():
    """Print CPU milliseconds, as they are and without steps from level to level."""

    def cost(call, times):
        costs = []
        for _ in range(times):
            begin = time.process_time()
            call()
            costs.append(time.process_time() - begin)
        return min(costs) * 1e3

    arrive = Levels.arrive
    print(f"{'CPU ms':>28}{'levels':>10}{'in time':>10}{'ratio':>8}")
    for name, law in LAWS.items():
        for what, call, times in (
            ("threshold", lambda law=law: grazing_damping(law, paper_oscillator(), rtol=1e-8), 5),
            ("cell of V by c", lambda law=law: ss.motion_map(law, **PLANE), 1),
            ("cell of V by N", lambda law=law: ss.motion_map(law, **WITHOUT_C), 1),
        ):
            cells = {"threshold": 1, "cell of V by c": 300, "cell of V by N": 30}[what]
            costs = []
            for way in (arrive, lambda *_: None):
                Levels.arrive = way
                costs.append(cost(call, times) / cells)
            Levels.arrive = arrive
            print(f"{name + ', ' + what:>28}{costs[0]:10.2f}{costs[1]:10.2f}{costs[1] / costs[0]:8.1f}")


if __name__ == "__main__":
    table()

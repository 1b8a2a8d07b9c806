"""Time of basins by geometry: python -m pytest tests/benchmarks/bench_basins.py -n 0"""

import numpy as np
import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
ENDS = {"x0": (-2.0, 2.0), "v0": (0.0, 2.0)}


@pytest.mark.parametrize("side", [10, 100, 1000])
def test_a_map_of_starts(benchmark, side):
    """The 200 motions that are followed as a check take most of it."""
    places = {name: np.linspace(*ends, side) for name, ends in ENDS.items()}
    found = benchmark.pedantic(ss.basin_map, (LAW, OSC), places, rounds=3)
    assert found.disagreements == 0


def test_shares_over_the_belt_speed(benchmark):
    speeds = ("V", np.linspace(0.5, 2.5, 100))
    found = benchmark.pedantic(ss.basin_sweep, (LAW, OSC, speeds), ENDS, rounds=1)
    assert [change.kind for change in found.changes] == ["Hopf", "graze"]

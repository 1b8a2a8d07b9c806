"""Time of maps of 10,000 cells: python -m pytest tests/benchmarks/bench_maps.py -n 0"""

import numpy as np
import pytest

import stickslip_sym as ss

PLANE = {"x": ("V", np.linspace(0.01, 1, 100)), "y": ("c", np.linspace(0, 6, 100)), "N": 9.81, "m": 1, "k": 100}


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("name", ["exponential", "polynomial"])
def test_the_plane_of_the_paper(benchmark, name, workers):
    law = ss.laws.catalogue[name].typical()
    found = benchmark.pedantic(ss.motion_map, (law,), PLANE | {"workers": workers}, rounds=1)
    assert found.motion.size == 10_000

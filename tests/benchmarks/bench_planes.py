"""Maps whose cells are scenes of their own: python -m pytest tests/benchmarks/bench_planes.py -n 0

`python tests/benchmarks/bench_planes.py [LAW ...]` prints for all laws, in one run, CPU milliseconds a cell: of
planes of 300 cells, and of a tenth of their cells decided scene by scene.
"""

import sys
import time

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.maps.together import Asked, alone

V, N, K = np.linspace(0.1, 0.9, 20), np.linspace(2, 30, 15), np.geomspace(10, 1000, 15)
PLANES = {
    "V by N": {"x": ("V", V), "y": ("N", N), "c": 2, "m": 1, "k": 100},
    "V by k": {"x": ("V", V), "y": ("k", K), "c": 2, "m": 1, "N": 9.81},
    "V by c": {"x": ("V", V), "y": ("c", np.linspace(0.2, 6, 15)), "m": 1, "k": 100, "N": 9.81},
}
SPEEDS = np.linspace(0, 1.3, 12)
PIECES = {
    "measured": ss.FrictionLaw.from_samples(SPEEDS, 0.2 + 0.3 * np.exp(-3 * SPEEDS), extrapolate=True),
    "kinked": ss.FrictionLaw("0.5 - 0.3*Min(v, 0.7)"),
    "held": ss.laws.exponential.typical().with_static("0.6"),
}
LAWS = PIECES | {name: law.typical() for name, law in ss.laws.catalogue.items()}


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("law", ["measured", "exponential", "logarithmic"])
def test_plane(benchmark, law, plane):
    found = benchmark.pedantic(ss.motion_map, (LAWS[law],), PLANES[plane], rounds=1)
    assert found.motion.size == 300


def scene_by_scene(law, plane):
    """Decide every tenth cell by itself; return how many."""
    (x, across), (y, along) = plane["x"], plane["y"]
    cells = [(one, other) for one in across for other in along][::10]
    for one, other in cells:
        values = plane | {x: one, y: other}
        osc = ss.Oscillator(**{name: values[name] for name in "VNmk"})
        alone(Asked(law, osc, np.array([float(values["c"])])), rtol=1e-8)
    return len(cells)


def table(names):
    """Print what a cell costs."""
    print(f"{'CPU ms a cell':>30}{'together':>10}{'alone':>10}{'ratio':>8}  regimes")
    for name in names or LAWS:
        for title, plane in PLANES.items():
            begin = time.process_time()
            found = ss.motion_map(LAWS[name], **plane)
            together = (time.process_time() - begin) / 300 * 1e3
            alone_too = ""
            if title != "V by c":
                begin = time.process_time()
                count = scene_by_scene(LAWS[name], plane)
                each = (time.process_time() - begin) / count * 1e3
                alone_too = f"{each:10.1f}{each / together:8.1f}"
            counts = ", ".join(f"{n} {motion.value}" for motion, n in found.count().items())
            print(f"{name + ', ' + title:>30}{together:10.2f}{alone_too:18}  {counts}", flush=True)


if __name__ == "__main__":
    table(sys.argv[1:])

"""Time of basins by geometry beside simulated starts: python -m pytest tests/benchmarks/bench_basins.py -n 0"""

import numpy as np
import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
ENDS = {"x0": (-2.0, 2.0), "v0": (0.0, 2.0)}


@pytest.mark.parametrize("side", [10, 100, 1000])
def test_a_map_of_starts(benchmark, side):
    """The 200 starts that are simulated as a check take most of it."""
    places = {name: np.linspace(*ends, side) for name, ends in ENDS.items()}
    found = benchmark.pedantic(ss.basin_map, (LAW, OSC), places, rounds=3)
    assert found.disagreements == 0


UNSETTLED = {
    "mu jumps": (
        ss.FrictionLaw("Piecewise((0.5 - 0.1*v, v < 0.3), (0.3, True))"),
        ss.Oscillator(m=1, k=100, c=1, V=0.5, N=9.81),
    ),
    "overtakes": (ss.laws.exponential.typical(alpha=0.8), ss.Oscillator(m=1, k=1, c=0.01, V=1, N=0.2)),
}


@pytest.mark.parametrize("name", UNSETTLED)
@pytest.mark.parametrize("way", ["400 starts one by one", "400 starts in lines of 100"])
def test_starts_that_geometry_does_not_settle(benchmark, name, way):
    benchmark.group = f"starts that geometry does not settle: {name}"
    law, osc = UNSETTLED[name]
    x0, v0 = np.linspace(-5, 5, 100) * osc.length, np.linspace(-1, 2, 4) * osc.V

    def one_by_one():
        return [ss.classify(law, osc, x0=x, v0=v) for v in v0 for x in x0]

    if "one" in way:
        benchmark.pedantic(one_by_one, rounds=1)
    else:
        benchmark.pedantic(ss.basin_map, (law, osc), {"x0": x0, "v0": v0}, rounds=1)


def test_shares_over_the_belt_speed(benchmark):
    speeds = ("V", np.linspace(0.5, 2.5, 100))
    found = benchmark.pedantic(ss.basin_sweep, (LAW, OSC, speeds), ENDS, rounds=1)
    assert [change.kind for change in found.changes] == ["Hopf", "graze"]


def test_the_share_by_counting_starts(benchmark):
    """What sampling takes for two digits: 200 starts leave a standard error of 0.03."""
    rng = np.random.default_rng(1)
    starts = [(rng.uniform(*ENDS["x0"]), rng.uniform(*ENDS["v0"])) for _ in range(200)]

    def count():
        return sum(ss.classify(LAW, OSC, x0=x, v0=v) is ss.Motion.REST for x, v in starts) / 200

    assert benchmark.pedantic(count, rounds=1) == pytest.approx(0.3071, abs=0.1)

"""What one call of each method costs: ``python -m pytest tests/benchmarks/bench_calls.py -n 0``."""

import subprocess
import sys
from functools import partial

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.thresholds.methods import methods

LAW = ss.laws.exponential.typical()
POINT = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
SPEEDS = np.linspace(0.01, 1.0, 101)
MANY = np.linspace(0.01, 1.0, 100_000)
PLANE = {"x": ("V", np.linspace(0.01, 1, 100)), "y": ("c", np.linspace(0, 6, 100)), "N": 9.81, "m": 1, "k": 100}
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
BISTABLE_OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
BOX = {"x0": (-2.0, 2.0), "v0": (0.0, 2.0)}


FORM = ss.derive(LAW)


def process(code, line=""):
    """What an answer costs from the prompt."""
    return partial(subprocess.run, [sys.executable, "-c", code, *line.split()], capture_output=True, check=False)


COMMAND = "from stickslip_sym.cli.start import main; main()"
CALLS = {
    "one array of 1e5 speeds": {"closed form": partial(FORM, V=MANY, N=9.81), "numpy.exp": partial(np.exp, MANY)},
    "one value": {
        "closed form": partial(FORM, V=0.5, N=9.81),
        "50 digits": partial(FORM.evaluate, 50, V=0.5, N=9.81),
        "quadrature, 50 digits": partial(ss.quadrature.damping, LAW, V=0.5, N=9.81, digits=50),
    },
    "one threshold, its error included": {
        method: partial(ss.pure_slip_damping, LAW, **POINT, method=method, rtol=1e-10) for method in methods()
    },
    "one threshold, as good as asked for": {
        f"rtol={rtol}": partial(ss.pure_slip_damping, LAW, **POINT, rtol=rtol) for rtol in (0.3, 1e-2, 1e-4, 1e-10)
    },
    "101 speeds": {
        method: partial(ss.pure_slip_damping, LAW, **(POINT | {"V": SPEEDS}), method=method, rtol=1e-10)
        for method in ("second_order", "orbit", "auto")
    },
    "the first answer, in a process of its own": {
        "import scipy.optimize": process("import scipy.optimize"),
        "help": process(COMMAND, "--help"),
        "a typo in a law's name": process(COMMAND, "damping exponentail -V 0.5 -N 9.81"),
        "a threshold of the catalogue": process(COMMAND, "damping exponential -V 0.5 -N 9.81 -m 1 -k 100"),
        "a new law, proved": process(COMMAND, "derive mu_m+(mu_s-mu_m)/(1+v/v_s)"),
    },
    "critical values and cycles": {
        "speed": partial(ss.critical, LAW, "V", c=2.5, N=9.81, m=1.0, k=100.0),
        "cycles": partial(ss.limit_cycles, LAW, ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)),
    },
}


@pytest.mark.parametrize(
    "call",
    [
        pytest.param(call, id=name, marks=pytest.mark.benchmark(group=group))
        for group, calls in CALLS.items()
        for name, call in calls.items()
    ],
)
def test_call(benchmark, call):
    call()  # the first one makes functions
    benchmark(call)


@pytest.mark.benchmark(group="ten cycles at rtol = 1e-10")
@pytest.mark.parametrize("method", ["events", "solve_ivp"])
def test_motion(benchmark, method):
    osc = ss.Oscillator(m=1, k=100, c=1, V=0.5, N=9.81)
    motion = benchmark(ss.simulate, LAW, osc, t_end=6.6, x0=osc.onset(LAW), method=method)
    assert len(motion.starts_of(ss.Phase.STICK)) == 10


@pytest.mark.benchmark(group="the plane of the paper, 10,000 cells")
@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("name", ["exponential", "polynomial"])
def test_plane(benchmark, name, workers):
    law = ss.laws.catalogue[name].typical()
    plane = benchmark.pedantic(ss.motion_map, (law,), PLANE | {"workers": workers}, rounds=1)
    assert plane.motion.size == 10_000


@pytest.mark.parametrize("side", [10, 100, 1000])
def test_a_map_of_starts(benchmark, side):
    """The 200 motions that are followed as a check take most of it."""
    places = {name: np.linspace(*ends, side) for name, ends in BOX.items()}
    found = benchmark.pedantic(ss.basin_map, (BISTABLE, BISTABLE_OSC), places, rounds=3)
    assert found.disagreements == 0


def test_shares_over_the_belt_speed(benchmark):
    speeds = ("V", np.linspace(0.5, 2.5, 100))
    found = benchmark.pedantic(ss.basin_sweep, (BISTABLE, BISTABLE_OSC, speeds), BOX, rounds=1)
    assert [change.kind for change in found.changes] == ["Hopf", "graze"]

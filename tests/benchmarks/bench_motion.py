"""What a motion costs: ``python -m pytest tests/benchmarks/bench_motion.py -n 0``.

The motion of the paper's section 3 with c = 1 kg/s, from P on: by `simulate`, and by its reference with
`solve_ivp` and events. The error noted beside a time is the largest one of the times of all returns to the belt's
speed, over the period, against a reference.
"""

import math
import sys
from functools import cache
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import motions
from operating_points import paper_oscillator

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()
OSC = paper_oscillator(1.0)
ONSET = OSC.onset(LAW)
CYCLES = 10


@cache
def exact():
    """Return slip time and period in s, by the reference of the tests, which is good to 1e-13."""
    times = [t for t, _ in motions.reference(LAW, OSC, ONSET, OSC.V, 2 * CYCLES / OSC.omega)]
    return times[1], times[2]


def duration(cycles):
    """Return a time a little after the last return."""
    slip, period = exact()
    return (cycles - 1) * period + slip + 1e-3


def error(returns):
    slip, period = exact()
    return max(abs(t - i * period - slip) for i, t in enumerate(returns)) / period


def simulated(cycles, rtol, method):
    """Return the times of the returns to the belt's speed."""
    motion = ss.simulate(LAW, OSC, t_end=duration(cycles), x0=ONSET, rtol=rtol, method=method)
    return motion.starts_of(ss.Phase.STICK)


@pytest.mark.parametrize("cycles", [1, CYCLES], ids=["one transit", "ten cycles"])
@pytest.mark.parametrize("method", ["events", "solve_ivp"])
def test_motion(benchmark, method, cycles):
    benchmark.group = f"{cycles} cycles at rtol = 1e-10"
    returns = benchmark(simulated, cycles, 1e-10, method)
    assert len(returns) == cycles
    benchmark.extra_info["error"] = error(returns)


@pytest.mark.benchmark(group="the cycle")
def test_cycle(benchmark):
    benchmark(ss.stick_slip_cycle, LAW, OSC, rtol=1e-12)


@pytest.mark.benchmark(group="ten rounds of slip at rtol = 1e-10")
def test_slip_that_decays(benchmark):
    """Near rest no round repeats another, and every one is integrated."""
    osc = paper_oscillator(2.3)
    x0 = osc.N * float(LAW.mu(osc.V)) / osc.k
    motion = benchmark(ss.simulate, LAW, osc, t_end=10 * 2 * math.pi / osc.omega, x0=x0, v0=0.1)
    assert len(motion.events) == 1

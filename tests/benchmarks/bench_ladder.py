"""What each rung of the ladder costs; run with ``pytest tests/benchmarks/bench_ladder.py``."""

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.orbits.expansion import expand
from stickslip_sym.motion.thresholds.rungs import rungs

LADDER = list(rungs())

LAW = ss.laws.exponential.typical()
SCENE = {"V": 0.5, "N": 9.81, "m": 1.0, "k": 100.0}
SPEEDS = np.linspace(0.01, 1.0, 101)


@pytest.mark.benchmark(group="one threshold, its error included")
@pytest.mark.parametrize("method", LADDER)
def test_rung(benchmark, method):
    ss.pure_slip_damping(LAW, **SCENE, method=method)
    benchmark(ss.pure_slip_damping, LAW, **SCENE, method=method, rtol=1e-10)


@pytest.mark.benchmark(group="one threshold, as good as asked for")
@pytest.mark.parametrize("rtol", [0.3, 0.1, 1e-2, 1e-4, 1e-10])
def test_auto(benchmark, rtol):
    benchmark(ss.pure_slip_damping, LAW, **SCENE, rtol=rtol)


@pytest.mark.benchmark(group="101 speeds")
def test_expansion(benchmark):
    benchmark(expand, LAW, SPEEDS)


@pytest.mark.benchmark(group="101 speeds")
@pytest.mark.parametrize("method", ["second_order", "orbit", "auto"])
def test_speeds(benchmark, method):
    benchmark(ss.pure_slip_damping, LAW, **(SCENE | {"V": SPEEDS}), method=method, rtol=1e-10)


@pytest.mark.benchmark(group="inverse and cycles")
def test_transition_speed(benchmark):
    benchmark(ss.transition_speed, LAW, c=2.5, N=9.81, m=1.0, k=100.0)


@pytest.mark.benchmark(group="inverse and cycles")
def test_limit_cycles(benchmark):
    benchmark(ss.limit_cycles, LAW, ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81))

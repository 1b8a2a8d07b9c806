"""What each way to the number costs; run with ``pytest tests/benchmarks/bench_spine.py``."""

import numpy as np
import pytest

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()
SCENE = {"V": 0.5, "N": 9.81}
SPEEDS = np.linspace(0.01, 1.0, 100_000)


@pytest.fixture(scope="module")
def form():
    form = ss.derive(LAW)
    form(**SCENE)
    return form


@pytest.mark.benchmark(group="one array of 1e5 speeds")
def test_call(benchmark, form):
    benchmark(form, V=SPEEDS, N=9.81)


@pytest.mark.benchmark(group="one array of 1e5 speeds")
def test_numpy_exp(benchmark):
    benchmark(np.exp, SPEEDS)


@pytest.mark.benchmark(group="one value")
def test_scalar_call(benchmark, form):
    benchmark(form, **SCENE)


@pytest.mark.benchmark(group="one value")
def test_fifty_digits(benchmark, form):
    benchmark(form.evaluate, 50, **SCENE)


@pytest.mark.benchmark(group="one value")
def test_quadrature_fifty_digits(benchmark):
    benchmark(ss.quadrature.damping, LAW, **SCENE, digits=50)


@pytest.mark.benchmark(group="one value")
def test_event_driven_threshold(benchmark):
    benchmark(ss.pure_slip_damping, LAW, **SCENE, m=1, k=100, method="simulation")

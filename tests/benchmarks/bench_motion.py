"""What a motion costs; run with ``pytest tests/benchmarks/bench_motion.py -n 0``.

For one table of all: ``python tests/benchmarks/bench_motion.py``.

Four ways to the motion of the paper's section 3 with c = 1 kg/s, from P on: a user's own script with `solve_ivp`
and two event functions, and the paper's Newmark steps of 1e-4 s. The error is the largest one
of the times of all returns to the belt's speed, over the period, against 20 digits.
"""

import math
import sys
import time
from functools import cache
from itertools import pairwise
from pathlib import Path

import mpmath
import pytest
from scipy.integrate import solve_ivp

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from many_digits import exact_return
from scenes import paper_oscillator

import stickslip_sym as ss

LAW = ss.laws.exponential.typical()
OSC = paper_oscillator(1.0)
ONSET = OSC.onset(LAW)
TOLERANCES = [10.0**-digits for digits in range(6, 14)]
CYCLES = 10


@cache
def exact():
    """Return slip time and period in s."""
    with mpmath.workdps(25):
        tau, q = exact_return(LAW, OSC)
    return float(tau) / OSC.omega, float(tau - q) / OSC.omega


def duration(cycles):
    """Return a time a little after the last return."""
    slip, period = exact()
    return (cycles - 1) * period + slip + 1e-3


def error(returns):
    slip, period = exact()
    return max(abs(t - i * period - slip) for i, t in enumerate(returns)) / period


# -- the four ways: each returns the times of the returns --------------------------------------------


def plain(cycles, rtol):
    """What a user writes."""
    m, k, c, V, N = OSC.m, OSC.k, OSC.c, OSC.V, OSC.N

    def mu(v):
        return 0.2 + 0.3 * math.exp(-3.0 * v)

    def slip(t, y):
        return [y[1], (N * mu(V - y[1]) - c * y[1] - k * y[0]) / m]

    def stick(t, y):
        return [V, 0.0]

    def back_to_belt(t, y):
        return y[1] - V

    def onset(t, y):
        return c * V + k * y[0] - 0.5 * N

    back_to_belt.terminal = onset.terminal = True
    back_to_belt.direction = onset.direction = 1
    t, y, returns, end = 0.0, [ONSET, V], [], duration(cycles)
    while True:
        for rates, event in ((slip, back_to_belt), (stick, onset)):
            found = solve_ivp(rates, (t, end), y, method="DOP853", rtol=rtol, atol=rtol * OSC.length, events=event)
            if found.status != 1:
                return returns
            t, y = found.t_events[0][0], [found.y_events[0][0][0], V]
            if event is back_to_belt:
                returns.append(t)


def ours(cycles, rtol):
    motion = ss.simulate(LAW, OSC, t_end=duration(cycles), x0=ONSET, rtol=rtol)
    return motion.starts_of(ss.Phase.STICK)


def newmark(cycles, step):
    """The steps of `stickslip_sym.newmark`, with plain numbers in place of arrays."""
    m, k, c, V, N, h, band = OSC.m, OSC.k, OSC.c, OSC.V, OSC.N, step, 1e-4
    x, v, a, returns, stuck = ONSET, V, 0.0, [], True
    effective = m + c * h / 2 + k * h * h / 4
    for i in range(int(duration(cycles) / h) + 1):
        stick = abs(v - V) <= band and abs(c * v + k * x) <= 0.5 * N
        if stick:
            if not stuck:
                returns.append(i * h)
            x, v, a = x + h * V, V, 0.0
        else:
            v_free, x_free, v_new = v + h / 2 * a, x + h * v + h * h / 4 * a, v
            for _ in range(3):
                relative = v_new - V
                force = (-1.0 if relative > 0 else 1.0) * N * (0.2 + 0.3 * math.exp(-3.0 * abs(relative)))
                a = (force - c * v_free - k * x_free) / effective
                v_new = v_free + h / 2 * a
            x, v = x_free + h * h / 4 * a, v_new
        stuck = stick
    return returns


WAYS = {
    "plain script": lambda cycles, rtol: plain(cycles, rtol),
    "scipy": lambda cycles, rtol: ours(cycles, rtol),
    "newmark": lambda cycles, rtol: newmark(cycles, 1e-4),
}


@pytest.mark.parametrize("cycles", [1, CYCLES], ids=["one transit", "ten cycles"])
@pytest.mark.parametrize("way", WAYS)
def test_way(benchmark, way, cycles):
    benchmark.group = f"{cycles} cycles at rtol = 1e-10"
    returns = benchmark(WAYS[way], cycles, 1e-10)
    assert way == "newmark" or len(returns) == cycles
    benchmark.extra_info["error"] = error(returns)


def to_steady_state(rtol):
    """Simulate from a start off the cycle until two periods agree."""
    motion = ss.simulate(LAW, OSC, t_end=CYCLES * exact()[1], x0=0.2, v0=0.0, rtol=rtol)
    periods = [b - a for a, b in pairwise(motion.starts_of(ss.Phase.STICK))]
    assert math.isclose(periods[-1], periods[-2], rel_tol=1e-9)
    return periods[-1]


@pytest.mark.parametrize("way", ["cycle", "steady state"])
def test_cycle(benchmark, way):
    benchmark.group = "the cycle"
    if way == "cycle":
        benchmark(ss.stick_slip_cycle, LAW, OSC, rtol=1e-12)
    else:
        benchmark(to_steady_state, 1e-12)


SLIPPING = paper_oscillator(2.3)
"""Where starts near rest come to it in slip: no round repeats another."""


def test_ten_rounds_of_slip(benchmark):
    """Here every round is integrated."""
    benchmark.group = "ten rounds of slip at rtol = 1e-10"
    t_end = 10 * 2 * math.pi / SLIPPING.omega
    x0 = SLIPPING.N * float(LAW.mu(SLIPPING.V)) / SLIPPING.k
    motion = benchmark(ss.simulate, LAW, SLIPPING, t_end=t_end, x0=x0, v0=0.1)
    assert len(motion.events) == 1


def table():
    """Print times and errors over the tolerances, and the ratios at equal accuracy."""

    def best(call):
        times = []
        for _ in range(5):
            begin = time.perf_counter()
            result = call()
            times.append(time.perf_counter() - begin)
        return min(times), result

    for cycles in (1, CYCLES):
        print(f"\n{cycles} cycles: milliseconds (error)")
        print(f"{'rtol':>8}" + "".join(f"{way:>24}" for way in WAYS))
        found = {way: [] for way in WAYS}
        for rtol in TOLERANCES:
            for way, call in WAYS.items():
                if way == "newmark" and found[way]:
                    continue
                seconds, returns = best(lambda call=call, rtol=rtol, cycles=cycles: call(cycles, rtol))
                found[way].append((seconds, error(returns)))
            cells = (f"{found[way][-1][0] * 1e3:11.3f} ({found[way][-1][1]:8.1e})" for way in WAYS)
            print(f"{rtol:8.0e}" + "".join(f"{cell:>24}" for cell in cells))
        for limit in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
            costs = {
                way: min((seconds for seconds, wrong in rows if wrong <= limit), default=math.nan)
                for way, rows in found.items()
            }
            ratios = ", ".join(f"{way} {cost / costs['scipy']:.3f}" for way, cost in costs.items())
            print(f"error <= {limit:.0e}: {ratios} (1 is scipy; nan: not reached)")
    print()
    for rtol in (1e-10, 1e-12):
        cycle, _ = best(lambda r=rtol: ss.stick_slip_cycle(LAW, OSC, rtol=r))
        steady, _ = best(lambda r=rtol: to_steady_state(r))
        print(f"rtol = {rtol:.0e}: cycle {cycle * 1e3:.3f} ms, simulated {steady / cycle:.1f} times")


if __name__ == "__main__":
    table()

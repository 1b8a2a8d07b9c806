"""What a start of an ensemble costs, beside other ways; run with ``python tests/benchmarks/bench_ensemble.py``.

The bistable benchmark, ten cycles: every start by itself with `simulate` and both its engines and with a script
that a user writes (`solve_ivp` with an event), and 100, 1e4 and 1e5 starts together. Processor seconds, least of
three; one by one over a part of the same starts. What differs from `simulate` is counted: the number of sticks, or
an end off by 1e-6.
"""

import math
import time

import numpy as np
from scipy.integrate import solve_ivp

import stickslip_sym as ss

LAW = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2)
OSC = ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
T_END = 10 * ss.stick_slip_cycle(LAW, OSC).period
X0, V0 = np.random.default_rng(1).uniform((-2, 0), (2, 2), (100_000, 2)).T
PART = 60  # starts of the slow ways


def plain(x0, v0):
    """What a user writes: final x, and the number of sticks."""
    V, ONSET = OSC.V, OSC.onset(LAW)

    def slip(side):
        def rates(t, y):
            return [y[1], side * (0.5 + 0.5 * math.exp(-2 * abs(V - y[1]))) - 0.1 * y[1] - y[0]]

        return rates

    def back_to_belt(t, y):
        return y[1] - V

    back_to_belt.terminal = True
    t, y, sticks = 0.0, [x0, v0], 0
    while t < T_END:
        side = 1 if y[1] < V or (y[1] == V and y[0] >= ONSET) else -1
        back_to_belt.direction = side
        found = solve_ivp(slip(side), (t, T_END), y, method="DOP853", rtol=1e-10, atol=1e-10, events=back_to_belt)
        if found.status != 1:
            return found.y[0, -1], sticks
        t, x = found.t_events[0][0], found.y_events[0][0][0]
        y = [x, V]
        if abs(x + 0.1 * V) < 1:
            sticks += 1
            left = T_END - t
            t, y = (t + (ONSET - x) / V, [ONSET, V]) if ONSET - x < V * left else (T_END, [x + V * left, V])
    return y[0], sticks


def alone(x0, v0, engine="scipy"):
    motion = ss.simulate(LAW, OSC, x0=x0, v0=v0, t_end=T_END, engine=engine)
    return motion.x[-1], motion.starts_of(ss.Phase.STICK).size


def together(count):
    found = ss.ensemble(LAW, OSC, x0=X0[:count], v0=V0[:count], t_end=T_END)
    return list(zip(found.x, found.sticks, strict=True))


def one_by_one(way):
    return [way(x0, v0) for x0, v0 in zip(X0[:PART], V0[:PART], strict=True)]


WAYS = {
    "simulate": (lambda: one_by_one(alone), PART, 3),
    "simulate, heyoka": (lambda: one_by_one(lambda x0, v0: alone(x0, v0, "heyoka")), PART, 3),
    "solve_ivp, one by one": (lambda: one_by_one(plain), PART, 1),
    "ensemble of 100": (lambda: together(100), 100, 3),
    "ensemble of 1e4": (lambda: together(10_000), 10_000, 3),
    "ensemble of 1e5": (lambda: together(100_000), 100_000, 1),
}


def main():
    together(10)
    alone(0.0, 0.0, "heyoka")
    reference = one_by_one(alone)
    least = {}
    for name, (way, count, repeats) in WAYS.items():
        times = []
        for _ in range(repeats):
            begin = time.process_time()
            found = way()
            times.append(time.process_time() - begin)
        least[name] = 1e3 * min(times) / count
        differ = sum(a[1] != b[1] or abs(a[0] - b[0]) > 1e-6 for a, b in zip(found[:PART], reference, strict=True))
        ratio = least[name] / least["simulate"]
        print(f"{name:24} {least[name]:8.3f} ms a start, {ratio:6.4f} of simulate, {differ} differ")


if __name__ == "__main__":
    main()

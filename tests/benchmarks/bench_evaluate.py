"""Ratios of times within one run: ``python tests/benchmarks/bench_evaluate.py``.

The stable function of the exponential law against plain lambdify of (17) and one np.exp; its harmonic form against
scipy.special.ive; the polynomial law against the same arithmetic by hand.
"""

import time

import numpy as np
import scipy.special
import sympy as sp

import stickslip_sym as ss

SIZE = 1_000_000
SPEEDS = {
    "small": np.linspace(0.01, 0.7, SIZE),
    "common": np.linspace(0.01, 3, SIZE),
    "shuffled": np.random.default_rng(1).uniform(0.01, 3, SIZE),
    "large": np.linspace(1, 30, SIZE),
    "mixed": 10 ** np.random.default_rng(0).uniform(-4, 2, SIZE),
}
ROUNDS = 15
EXPONENTIAL = {"N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
POLYNOMIAL = {"N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "v_m": 1.0}


def by_hand(V, N, mu_s, mu_m, v_m):
    return N * (mu_s - mu_m) * (21 * v_m**2 - 26 * V**2) / (14 * v_m**3)


def times(*calls):
    """Return CPU seconds of calls, one row for each of some rounds in which they take turns."""

    def seconds(call):
        start = time.thread_time()
        call()
        return time.thread_time() - start

    return np.array([[seconds(call) for call in calls] for _ in range(ROUNDS + 2)])[2:]


def ratios():
    """Print the median of the ratios within each round."""
    form = ss.derive(ss.laws.exponential)
    plain = sp.lambdify(list(form.arguments.values()), form.expr, "numpy")
    rng = np.random.default_rng(2)
    each = EXPONENTIAL | {"alpha": rng.uniform(1, 6, SIZE), "mu_s": rng.uniform(0.4, 0.6, SIZE)}
    print("1e6 values         call over np.exp; batch of parameters over call; call over lambdify")
    for name, V in SPEEDS.items():
        values = [V, *(EXPONENTIAL[key] for key in form.arguments if key != "V")]
        rounds = times(
            lambda V=V: np.exp(V),
            lambda V=V: form(V=V, **EXPONENTIAL),
            lambda V=V: form(V=V, **each),
            lambda values=values: plain(*values),
        )
        exp, call, batch, text = rounds.T
        pairs = (call / exp, batch / call, call / text)
        print(f"least_squares {name:10}", *(f"{np.median(pair):7.2f}" for pair in pairs))
    harmonic, V = ss.derive(ss.laws.exponential, "harmonic"), SPEEDS["mixed"]
    stable, ive = times(lambda: harmonic(V=V, **EXPONENTIAL), lambda: scipy.special.ive(1, V)).T
    print(f"harmonic: {np.median(stable / ive):.2f} x ive")
    cubic, V = ss.derive(ss.laws.polynomial), SPEEDS["small"]
    stable, hand = times(lambda: cubic(V=V, **POLYNOMIAL), lambda: by_hand(V, **POLYNOMIAL)).T
    print(f"polynomial: {np.median(stable / hand):.2f} x by hand")


if __name__ == "__main__":
    ratios()

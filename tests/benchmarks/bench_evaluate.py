"""What a call of a closed form costs; run with ``pytest tests/benchmarks/bench_evaluate.py``.

Ratios within one run: the stable function of the exponential law against plain lambdify of (17) and one
np.exp, its harmonic form against scipy.special.ive, the polynomial law against the same arithmetic by hand.
"""

import time
import tracemalloc

import numpy as np
import pytest
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
EXPONENTIAL = {"N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "alpha": 3.0}
POLYNOMIAL = {"N": 9.81, "mu_s": 0.5, "mu_m": 0.2, "v_m": 1.0}


@pytest.fixture(scope="module")
def forms():
    found = {
        "least_squares": ss.derive(ss.laws.exponential),
        "harmonic": ss.derive(ss.laws.exponential, "harmonic"),
        "polynomial": ss.derive(ss.laws.polynomial),
    }
    for name, form in found.items():
        form(V=0.5, **(POLYNOMIAL if name == "polynomial" else EXPONENTIAL))
    return found


@pytest.mark.parametrize("speeds", SPEEDS)
@pytest.mark.parametrize("way", ["stable", "lambdify", "np.exp"])
def test_exponential_least_squares(benchmark, forms, way, speeds):
    benchmark.group = f"exponential, least_squares, 1e6 {speeds}"
    form, V = forms["least_squares"], SPEEDS[speeds]
    if way == "stable":
        benchmark(form, V=V, **EXPONENTIAL)
    elif way == "lambdify":
        plain = sp.lambdify(list(form.arguments.values()), form.expr, "numpy")
        values = [V, *(EXPONENTIAL[name] for name in form.arguments if name != "V")]
        benchmark(plain, *values)
    else:
        benchmark(np.exp, -V)


@pytest.mark.parametrize("way", ["stable", "ive"])
def test_exponential_harmonic(benchmark, forms, way):
    benchmark.group = "exponential, harmonic, 1e6 mixed"
    V = SPEEDS["mixed"]
    if way == "stable":
        benchmark(forms["harmonic"], V=V, **EXPONENTIAL)
    else:
        benchmark(scipy.special.ive, 1, V)


def by_hand(V, N, mu_s, mu_m, v_m):
    return N * (mu_s - mu_m) * (21 * v_m**2 - 26 * V**2) / (14 * v_m**3)


@pytest.mark.parametrize("way", ["stable", "by hand"])
def test_polynomial(benchmark, forms, way):
    benchmark.group = "polynomial, least_squares, 1e6 small"
    benchmark(forms["polynomial"] if way == "stable" else by_hand, V=SPEEDS["small"], **POLYNOMIAL)


@pytest.mark.parametrize(
    "name", ["exponential", "polynomial", "hyperbolic", "tanh", "two_exponentials", "stribeck"]
)
def test_scalar_call(benchmark, name):
    benchmark.group = "one value"
    form = ss.derive(ss.laws.catalogue[name].typical())
    form(V=0.5, N=9.81)
    form(V=0.5, N=9.81)
    benchmark(form, V=0.5, N=9.81)


@pytest.mark.parametrize("name", ss.laws.catalogue)
def test_first_call(benchmark, name):
    """The first call of a process finds branches; those of terms that laws share are found once."""
    from stickslip_sym.formula.evaluation.profile import profile_of

    benchmark.group = "first call"

    def fresh():
        profile_of.cache_clear()
        return (ss.slope_average(ss.laws.catalogue[name].typical()),), {}

    benchmark.pedantic(lambda average: average(V=0.5, N=9.81), setup=fresh, rounds=2)


def test_memory(benchmark, forms):
    """Peak memory over the result's, in arrays of the input's size."""
    V = SPEEDS["mixed"]

    def peak():
        tracemalloc.start()
        forms["least_squares"](V=V, **EXPONENTIAL)
        most = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return most / V.nbytes

    benchmark.extra_info["arrays"] = benchmark.pedantic(peak, rounds=2)
    assert benchmark.extra_info["arrays"] < 12


def ratios():
    """Print the ratios that the benchmarks above measure, best of nine each."""

    def best(call):
        times = []
        for _ in range(9):
            start = time.perf_counter()
            call()
            times.append(time.perf_counter() - start)
        return min(times)

    form = ss.derive(ss.laws.exponential)
    plain = sp.lambdify(list(form.arguments.values()), form.expr, "numpy")
    for name, V in SPEEDS.items():
        stable = best(lambda V=V: form(V=V, **EXPONENTIAL))
        values = [V, *(EXPONENTIAL[key] for key in form.arguments if key != "V")]
        print(f"least_squares {name}: {stable / best(lambda values=values: plain(*values)):.2f} x lambdify, "
              f"{stable / best(lambda V=V: np.exp(-V)):.1f} x np.exp")  # fmt: skip
        rng = np.random.default_rng(2)
        each = EXPONENTIAL | {"alpha": rng.uniform(1, 6, SIZE), "mu_s": rng.uniform(0.4, 0.6, SIZE)}
        batch = best(lambda V=V, each=each: form(V=V, **each))
        print(f"  with parameters of its own for each element: {batch / stable:.2f} x that")
    harmonic, V = ss.derive(ss.laws.exponential, "harmonic"), SPEEDS["mixed"]
    stable = best(lambda: harmonic(V=V, **EXPONENTIAL))
    print(f"harmonic: {stable / best(lambda: scipy.special.ive(1, V)):.2f} x ive")
    cubic, V = ss.derive(ss.laws.polynomial), SPEEDS["small"]
    stable, plain_time = best(lambda: cubic(V=V, **POLYNOMIAL)), best(lambda: by_hand(V, **POLYNOMIAL))
    print(f"polynomial: {stable / plain_time:.2f} x by hand")


if __name__ == "__main__":
    ratios()

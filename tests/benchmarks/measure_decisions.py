"""How honest decisions on few rows are: synthetic measurements, c beside the true threshold, every law fitted.

``python measure_decisions.py STORE --first 760 --sets 2000 --seconds 480`` fits sets until the time is up, and
writes each as a line of STORE, from which another run goes on. ``python measure_decisions.py STORE --judge``
prints, for each number of rows, how many decisions of the stored sets are confidently wrong, how many intervals
of 95 % hold the true threshold, and how many decisions are useful: right, and stated. Beside them stands the rule
of AICc weights and normal errors. The true law is one of the catalogue, its values within some 25 % of the typical
ones; smoothed laws, whose friction builds up where nothing was measured, are counted with all others, and apart.

The threshold is least_squares, an integral of mu, which costs nothing; a set takes some 2 s, nearly all for fits.
"""

import argparse
import json
import time
import warnings
from collections import defaultdict
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.special import ndtr

import stickslip_sym as ss
from stickslip_sym.comparison.decision import Decision, unmeasured_part
from stickslip_sym.core import symbols
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.at_rest import reals

COUNTS = (5, 6, 7, 8, 10, 12, 16, 24, 40, 60)
NOISES = ("normal", "small", "rounded", "proportional", "t5", "correlated")
N = 9.81
SEED = 1852
NODES, SHARES = np.polynomial.legendre.leggauss(120)
SMOOTHED = ("andersson", "brown_mcphee", "simscape", "bengisu_akay")
SURE = 0.99  # probability, beyond which a wrong decision is a confident one
STATED = 0.95


# -- synthetic measurements --------------------------------------------------------------------------


@cache
def functions(name):
    """A law's mu and its derivatives to the parameters, as functions of the speed and all parameters."""
    law = ss.laws[name]
    parameters = [parameter.symbol for parameter in law.parameters.values()]
    rows = [law.expr, *(law.expr.diff(parameter) for parameter in parameters)]
    return function_of([symbols.v, *parameters], rows, "numpy")


def threshold(name, values, V):
    """The least_squares slope average as an integral of mu over 0 to 2 V, and its derivatives to the values."""
    weights, speeds = -2.5 * N / V * NODES**3 * SHARES, V * (1 + NODES)
    with np.errstate(all="ignore"):
        rows = functions(name)(speeds, *(values[parameter] for parameter in ss.laws[name].parameters))
    integrals = [float(weights @ np.broadcast_to(reals(row), speeds.shape)) for row in rows]
    return integrals[0], np.array(integrals[1:])


def true_law(rng):
    """A law of the catalogue with random values."""
    law = ss.laws[str(rng.choice(list(ss.laws)))]
    for _ in range(100):
        scales = {name: float(value) * np.exp(rng.normal(0, 0.25)) for name, value in law.typical().values.items()}
        bound = law.bind(**scales)
        mu = bound.mu(np.linspace(0.02, 1.3, 50))
        if (mu > 0.02).all() and (mu < 2).all():
            return bound
    return law.typical()


def with_noise(rng, kind, mu):
    """Coefficients as measured."""
    normal = rng.normal(size=len(mu))
    if kind == "correlated":
        for i in range(1, len(mu)):
            normal[i] = 0.6 * normal[i - 1] + 0.8 * normal[i]
    return {
        "normal": lambda: mu + 0.005 * normal,
        "small": lambda: mu + 0.001 * normal,
        "rounded": lambda: np.round(mu, 4),
        "proportional": lambda: mu * (1 + 0.02 * normal),
        "t5": lambda: mu + 0.005 * rng.standard_t(5, size=len(mu)),
        "correlated": lambda: mu + 0.005 * normal,
    }[kind]()


def measured_set(seed):
    """A seeded set: the law, its rows, the belt speed, the true threshold and the damping."""
    rng = np.random.default_rng([SEED, seed])
    count, kind = COUNTS[seed % len(COUNTS)], NOISES[seed // len(COUNTS) % len(NOISES)]
    law = true_law(rng)
    spaced = [
        lambda: np.linspace(0.05, 1.2, count),
        lambda: np.geomspace(0.02, 1.3, count),
        lambda: np.sort(rng.uniform(0.02, 1.3, count)),
    ]
    v = np.unique(np.round(spaced[rng.integers(3)](), 4))
    mu = with_noise(rng, kind, law.mu(v))
    V, ratio = float(np.round(rng.uniform(0.2, 0.6), 3)), float(rng.uniform(0.7, 1.3))
    exact, _ = threshold(law.name, {name: float(value) for name, value in law.values.items()}, V)
    c = ratio * exact if exact > 0.02 else float(rng.uniform(0.1, 1.0))
    return SimpleNamespace(seed=seed, count=count, kind=kind, law=law, v=v, mu=mu, V=V, threshold=exact, c=c)


# -- fits, stored ------------------------------------------------------------------------------------


def stored_fits(seed):
    """All that is needed to weigh the fits of a set again, as JSON."""
    one = measured_set(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fits = ss.fit(one.v, one.mu)
    kept = [
        {
            "name": fit.name, "values": dict(fit.values), "covariance": fit.covariance.tolist(),
            "chi_squared": fit.chi_squared, "dof": fit.dof, "inflation": fit.inflation,
        }
        for fit in fits
    ]  # fmt: skip
    return {"seed": seed, "true": one.law.name, "fits": kept, "rejected": sorted(fits.rejected)}


def fits_of(one, record):
    """The fits of a set as the package makes them of what was stored."""
    measured = ss.results.Measurements.of(one.v, one.mu)
    fits = [
        ss.results.Fit(
            free_law=ss.laws[row["name"]], values=row["values"], covariance=np.array(row["covariance"]),
            measured=measured, chi_squared=row["chi_squared"], dof=row["dof"], inflation=row["inflation"],
        )
        for row in record["fits"]
    ]  # fmt: skip
    return ss.results.Fits(fits, measured, dict.fromkeys(record["rejected"], ""))


def records_of(store):
    """The sets that a file holds; a line that was cut off holds none."""
    records = {}
    for line in store.read_text().splitlines() if store.exists() else ():
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        records[record["seed"]] = record
    return records


# -- decisions ---------------------------------------------------------------------------------------


def estimates(fits, V):
    """The threshold by each fit, with its standard error."""
    found = {}
    for fit in fits:
        value, slopes = threshold(fit.name, fit.values, V)
        places = [list(fit.free_law.parameters).index(name) for name in fit.values]
        variance = slopes[places] @ fit.covariance @ slopes[places]
        error = float(np.sqrt(max(variance, 0.0)))
        unmeasured = unmeasured_part(fit.law, float(fit.measured.v[0]), V, N)
        found[fit.name] = SimpleNamespace(value=value, uncertainty=error, unmeasured=unmeasured)
    return found


def by_akaike(fits, found, one):
    """The probability that c is below, and the interval, by AICc weights and normal errors of each law alone."""
    fits = [fit for fit in fits if len(one.v) >= len(fit.values) + 2]
    if not fits:
        return 0.5, (-np.inf, np.inf)
    criteria = np.array([fit.aicc for fit in fits])
    weights = np.exp((criteria.min() - criteria) / 2) if np.isfinite(criteria).any() else np.ones(len(fits))
    values = np.array([found[fit.name].value for fit in fits])
    errors = np.maximum([found[fit.name].uncertainty for fit in fits], 1e-300)
    weights = np.where(weights >= 0.01 * weights.max(), weights, 0.0)
    weights /= weights.sum()
    mean = weights @ values
    error = np.sqrt(weights @ (errors**2 + (values - mean) ** 2))
    return float(weights @ ndtr((values - one.c) / errors)), (mean - 1.96 * error, mean + 1.96 * error)


def judged(chance, stated, interval, one):
    """Whether a decision is confidently wrong, its interval holds, and it is useful."""
    is_below = one.threshold > one.c
    wrong = stated and not 1 - SURE <= chance <= SURE and (chance > 0.5) != is_below
    useful = stated and (chance > 0.5) == is_below
    return np.array([wrong, interval[0] - 1e-9 <= one.threshold <= interval[1] + 1e-9, useful], dtype=float)


def outcome(record):
    """How the decision of a set fares, and that of AICc; and whether its law builds up friction unmeasured."""
    one = measured_set(record["seed"])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fits = fits_of(one, record)
        found = estimates(fits, one.V)
        decision = Decision.of_measured(one.c, 0.0, fits.average(lambda law: found[law.name]))
        chance, interval = by_akaike(fits, found, one)
    low, high = decision.range or (-np.inf, np.inf)
    least = decision.chance if decision.chance is not None else 0.5
    ours = judged(least, decision.below is not None, (low, high if high > 0 else np.inf), one)
    theirs = judged(chance, not 1 - STATED <= chance <= STATED, interval, one)
    unmeasured = one.law.name in SMOOTHED and one.law.name in record["rejected"]
    return one, ours, theirs, unmeasured


def judge(store):
    rows = defaultdict(list)
    for record in records_of(store).values():
        one, ours, theirs, unmeasured = outcome(record)
        keys = [one.count, one.kind, "all", "unmeasured" if unmeasured else "measured"]
        for key in [*keys, "n >= 8"] if one.count >= 8 else keys:
            rows[key].append((ours, theirs))
    print(f"{'':12} {'sets':>5}   wrong %, interval holds %, useful %, each +- standard error; the same by AICc")
    for key in sorted(rows, key=str):
        ours, theirs = np.mean(rows[key], axis=0)
        count = len(rows[key])
        shown = "   ".join(
            " ".join(f"{100 * share:5.1f}+-{100 * np.sqrt(share * (1 - share) / count):.1f}" for share in shares)
            for shares in (ours, theirs)
        )
        print(f"{key!s:12} {count:5}   {shown}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("store", type=Path)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--sets", type=int, default=2000)
    parser.add_argument("--seconds", type=float, default=480)
    parser.add_argument("--judge", action="store_true")
    arguments = parser.parse_args()
    if arguments.judge:
        judge(arguments.store)
        return
    done, end = records_of(arguments.store), time.monotonic() + arguments.seconds
    with arguments.store.open("a") as file:
        for seed in range(arguments.first, arguments.first + arguments.sets):
            if time.monotonic() > end:
                break
            if seed not in done:
                begin = time.process_time()
                record = stored_fits(seed) | {"seconds": round(time.process_time() - begin, 2)}
                print(json.dumps(record), file=file, flush=True)
                print(f"{seed}: {record['true']}, {record['seconds']} s", flush=True)


if __name__ == "__main__":
    main()

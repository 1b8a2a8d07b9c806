"""How honest decisions on few rows are: synthetic measurements, c beside the true threshold, every law fitted.

``python measure_decisions.py --first 0 --sets 2000`` prints, for each number of rows, how many decisions are
confidently wrong, how many intervals of 95 % hold the true threshold, and how many decisions are useful: right,
and stated. Beside them stands the rule of AICc weights and normal errors. The true law is one of the catalogue,
its values within some 25 % of the typical ones. Sets of a smoothed law that was not measured where its friction
builds up are counted apart: friction that nobody measured is in its threshold.

The threshold is least_squares, an integral of mu, which costs nothing; 2,000 sets take two hours of CPU time.
"""

import argparse
import warnings
from collections import defaultdict
from types import SimpleNamespace

import numpy as np
from scipy.special import ndtr
from uncertainties import covariance_matrix

import stickslip_sym as ss
from stickslip_sym.comparison.decision import Decision

COUNTS = (5, 6, 7, 8, 10, 12, 16, 24, 40, 60)
NOISES = ("normal", "small", "rounded", "proportional", "t5", "correlated")
N = 9.81
SEED = 1852
NODES, SHARES = np.polynomial.legendre.leggauss(120)
SMOOTHED = ("andersson", "brown_mcphee", "simscape", "bengisu_akay")
SURE = 0.99  # probability, beyond which a wrong decision is a confident one
STATED = 0.95


def threshold(law, V):
    """The least_squares slope average as an integral of mu over 0 to 2 V, with its standard error."""
    weights, speeds = -2.5 * N / V * NODES**3 * SHARES, V * (1 + NODES)
    value = float(weights @ law.at_speeds(speeds))
    names = list(law.uncertain)
    if not names:
        return SimpleNamespace(value=value, uncertainty=0.0)
    covariance = np.array(covariance_matrix([law.uncertain[name] for name in names]))
    slopes = np.array([weights @ law.partial(name).at_speeds(speeds) for name in names])
    return SimpleNamespace(value=value, uncertainty=float(np.sqrt(max(slopes @ covariance @ slopes, 0.0))))


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
    exact = threshold(law, V).value
    c = ratio * exact if exact > 0.02 else float(rng.uniform(0.1, 1.0))
    return SimpleNamespace(count=count, kind=kind, law=law, v=v, mu=mu, V=V, threshold=exact, c=c)


def by_akaike(fits, one):
    """The probability that c is below, and the interval, by AICc weights and normal errors of each law alone."""
    fits = [fit for fit in fits if len(one.v) >= len(fit.values) + 2]
    if not fits:
        return 0.5, (-np.inf, np.inf)
    criteria = np.array([fit.aicc for fit in fits])
    weights = np.exp((criteria.min() - criteria) / 2) if np.isfinite(criteria).any() else np.ones(len(fits))
    found = [threshold(fit.law.bind(**fit.uncertain), one.V) for fit in fits]
    values = np.array([each.value for each in found])
    errors = np.maximum([each.uncertainty for each in found], 1e-300)
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


def outcome(seed):
    """How the decision of a set fares, and that of AICc; and whether its law could be fitted at all."""
    one = measured_set(seed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        fits = ss.fit(one.v, one.mu)
        decision = Decision.of_measured(one.c, 0.0, fits.average(lambda law: threshold(law, one.V)))
        chance, interval = by_akaike(fits, one)
    low, high = decision.range or (-np.inf, np.inf)
    if decision.averaged.dof > 0:
        speeds = decision.averaged.speeds
        low, high = decision.averaged.interval() if speeds >= 6 else decision.averaged.range()
    ours = judged(decision.chance or 0.5, decision.below is not None, (low, high), one)
    theirs = judged(chance, not 1 - STATED <= chance <= STATED, interval, one)
    unmeasured = one.law.name in SMOOTHED and one.law.name in fits.rejected
    return one, ours, theirs, unmeasured


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--sets", type=int, default=60)
    arguments = parser.parse_args()
    rows = defaultdict(list)
    for seed in range(arguments.first, arguments.first + arguments.sets):
        one, ours, theirs, unmeasured = outcome(seed)
        for key in ("unmeasured",) if unmeasured else (one.count, one.kind, "all"):
            rows[key].append((ours, theirs))
    print(f"{'':12} {'sets':>5}   wrong %, interval holds %, useful %; the same by AICc and normal errors")
    for key, pairs in rows.items():
        ours, theirs = 100 * np.mean(pairs, axis=0)
        shown = "   ".join(" ".join(f"{value:5.1f}" for value in values) for values in (ours, theirs))
        print(f"{key!s:12} {len(pairs):5}   {shown}")


if __name__ == "__main__":
    main()

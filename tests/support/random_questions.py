"""Random laws at random operating points, for questions that several functions of the package answer."""

import math
import warnings
from random import Random

import numpy as np

import stickslip_sym as ss
from stickslip_sym.core.errors import NO_RESULT
from support import narrow_laws

PLAIN = (
    "exponential", "polynomial", "hyperbolic", "gaussian", "lorentzian", "tanh", "logarithmic", "brown_mcphee",
    "stribeck", "rational",
)  # fmt: skip
REGULARISED = ("tanh(v/{e})", "2/pi*atan(v/{e})", "v/sqrt(v^2 + {e}^2)")
PIECES = (
    "0.5 - {a}*Min(v, {b}*{V}) + {c}*Max(v - {V}, 0)",
    "0.4 - {a}*Abs(v - {b}*{V})",
    "0.5 - {a}*v/{V} + Piecewise((0, v < {b}*{V}), ({c}/4, True))",
)
NESTED = (
    "0.2 + 0.2*exp(-sqrt(0.01 + (v/{s})^2))",
    "0.3 + 0.1*tanh(1 - v/{s})*exp(-v/(3*{s}))",
    "0.5 - 0.1*log(1 + v/{s}) + 0.02*sin(v/{s})",
    "0.25 + 0.2/(1 + (v/{s})^2)^0.7",
)
KINDS = ("plain", "narrow", "regularised", "pieces", "plain", "nested", "static", "measured")
DAMPINGS = (0.3, 0.9, 0.99, 1.01, 1.1, 3.0)
"""Over the threshold."""


class NoAnswer(str):
    """Why a function does not answer."""

    @property
    def ending(self):
        """How a mass moves that has no peak of velocity."""
        return next((words for words in ("creeps to rest", "falls for ever") if words in self), "")


def asked(function, *args, **kwargs):
    """Return what a function returns, or why it does not answer."""
    try:
        return function(*args, **kwargs)
    except (*NO_RESULT, ss.OutOfTime) as error:
        return NoAnswer(f"{type(error).__name__}: {error}")


def drawn(seed):
    """Return a law with all its values, and an oscillator without damping: eta from 1e-4 to 1e4."""
    random, kind = Random(seed), KINDS[seed % len(KINDS)]
    V = 10 ** random.uniform(-2, 1)
    widest = (-4, 4) if random.random() < 0.5 else (-1.5, 1.5)
    eta, m, k = 10 ** random.uniform(*widest), 10 ** random.uniform(-1, 1), 10 ** random.uniform(1, 3)
    if kind == "narrow":
        law, V, _ = narrow_laws.narrow_law(random.choice(list(narrow_laws.SHAPES)), seed)
    else:
        law = _law(random, kind, V)
    return law, ss.Oscillator(m=m, k=k, V=V, N=eta * V * math.sqrt(k * m))


def _law(random, kind, V):
    scale = V * 10 ** random.uniform(-0.8, 0.8)
    if kind == "measured":
        rng = np.random.default_rng(random.randrange(2**32))
        v = np.r_[0, np.sort(rng.uniform(0.02, 4, int(rng.integers(4, 12)))) * V].round(9)
        mu = (0.2 + 0.3 * np.exp(-v / scale) + 0.01 * rng.standard_normal(v.size)).round(6)
        return ss.FrictionLaw.from_samples(v, mu, extrapolate=True)
    if kind in ("plain", "static"):
        law = ss.laws.catalogue[random.choice(PLAIN)].typical()
        law = law.bind(**{name: float(x) * 10 ** random.uniform(-0.2, 0.2) for name, x in law.values.items()})
        onset = law.onset * random.uniform(1.01, 1.5)
        return law.with_static(str(round(onset, 6))) if kind == "static" and onset > 0 else law
    formulas = {"regularised": REGULARISED, "pieces": PIECES, "nested": NESTED}
    formula = random.choice(formulas[kind]).format(
        a=f"{random.uniform(0.02, 0.3):.3g}", b=f"{random.uniform(0.1, 1.9):.4g}", V=f"{V:.6g}",
        c=f"({random.uniform(-0.1, 0.2):.3g})", s=f"{scale:.6g}", e=f"{V * 10 ** random.uniform(-8, -1):.4g}",
    )  # fmt: skip
    if kind == "regularised":
        formula = f"(0.25 + 0.2*exp(-v/{scale:.6g}))*{formula}"
    with warnings.catch_warnings(action="ignore", category=ss.InputWarning):
        return ss.FrictionLaw(formula)

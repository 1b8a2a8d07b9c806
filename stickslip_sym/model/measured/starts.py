"""Where a fit starts: values of the parameters that describe the measurements already.

For given values of the others, the parameters in which mu is linear are the solution of a linear problem. So only
the others are sought, by seeded trials on the scale that their unit gives: a speed among the measured speeds, an
exponent about 1.
"""

import numpy as np
from numpy.typing import NDArray
from sympy.physics import units

from stickslip_sym.model.expression.units import parse_unit
from stickslip_sym.model.measured.parametric import FittedLaw, Parametric

__all__ = ["starts"]

FloatArray = NDArray[np.float64]

_SEED = 1785
_TRIALS = 40  # for each parameter that is sought
_BEYOND = 3.0  # factor above the largest and below the smallest measured speed, between which speeds are sought
_EXPONENTS = 0.2, 4.0  # the range of pure numbers that are sought
_APART = 0.7  # natural logarithms by which some value differs between two starts
_LEAST = 1e-4  # start of a positive value that would be below 0, over its natural size


def starts(law: FittedLaw, model: Parametric, v: FloatArray, mu: FloatArray, weights: FloatArray, count: int) -> (
    list[FloatArray]
):  # fmt: skip
    """Return up to `count` starts that differ, the best first.

    Parameters
    ----------
    law, model : FittedLaw, Parametric
        The law, and the same at the speeds `v`.
    v, mu, weights : ndarray of shape (n,)
        Weights multiply residuals.
    count : int
    """
    rng = np.random.default_rng(_SEED)
    sought = np.flatnonzero(~model.linear)
    powers = {i: _power(law.parameters[model.names[i]].unit) for i in sought}
    tried: list[tuple[float, FloatArray]] = []
    for _ in range(_TRIALS * len(sought) if len(sought) else 1):
        p = np.zeros(len(model.names))
        for i in sought:
            p[i] = _draw(rng, powers[i], v)
            if not model.positive[i]:
                p[i] *= rng.choice([-1, 1])
        p = _with_linear(model, p, mu, weights)
        misfit = float(np.sum((weights * (model.mu(p) - mu)) ** 2))
        if np.isfinite(misfit):
            tried.append((misfit, p))
    chosen: list[FloatArray] = []
    for _, p in sorted(tried, key=lambda trial: trial[0]):
        if len(chosen) < count and all(_differ(p[sought], other[sought]) for other in chosen):
            chosen.append(p)
    return chosen


def _differ(one: FloatArray, other: FloatArray) -> bool:
    with np.errstate(divide="ignore", invalid="ignore"):
        return bool((~(np.abs(np.log(one / other)) <= _APART)).any())


def _power(unit: str | None) -> int | None:
    """Return which power of a speed a unit is; None if it is not known, or no power of a speed."""
    if unit is None:
        return None
    powers = parse_unit(unit).as_powers_dict()
    length, time = powers.get(units.meter, 0), powers.get(units.second, 0)
    return int(length) if length == -time and int(length) == length else None


def _draw(rng: np.random.Generator, power: int | None, v: FloatArray) -> float:
    """Return a positive value of a plausible size."""
    if power is None:
        power = int(rng.choice([-1, 0, 1]))
    if power == 0:
        return float(np.exp(rng.uniform(*np.log(_EXPONENTS))))
    above = v[v > 0]
    low, high = (above.min() / _BEYOND, above.max() * _BEYOND) if len(above) else (0.1, 1.0)
    return float(np.exp(rng.uniform(np.log(low), np.log(high)))) ** power


def _with_linear(model: Parametric, p: FloatArray, mu: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the values with the best linear ones; what would be negative and must not is held near 0."""
    p = p.copy()
    solved = np.flatnonzero(model.linear)
    if not len(solved):
        return p
    p[solved] = 0.0
    design = model.jacobian(p)
    least = _LEAST * np.ptp(mu) / np.maximum(np.abs(design).max(axis=0), 1e-300) + 1e-300
    for _ in range(len(solved)):
        target, matrix = weights * (mu - model.mu(p)), weights[:, None] * design[:, solved]
        if not (np.isfinite(target).all() and np.isfinite(matrix).all()):
            return np.full_like(p, np.nan)
        sizes = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        p[solved] = np.linalg.lstsq(matrix / sizes, target, rcond=None)[0] / sizes
        below = [i for i in solved if model.positive[i] and p[i] <= 0]
        if not below:
            break
        p[below] = least[below]
        solved = np.array([i for i in solved if i not in below], dtype=int)
        p[solved] = 0.0
        if not len(solved):
            break
    return p

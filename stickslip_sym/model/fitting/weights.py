"""How likely each of several fitted laws is, and the noise that all of them share.

What counts are the speeds: rows at one speed say nothing of a law's shape, and count as their mean. With n speeds,
S the weighted sum of squares of those means about a law of k parameters, and nu = n - k of the law with the least
S/(n - k), its weight is exp(-3 k/2) S^(-(nu + 1)/2): for many speeds between Akaike's and Schwarz's, and finite
from n = k + 1 on. The noise is one for all: its variance is the mean of S/(n - k) by weight, with the mean of
n - k as its degrees of freedom. Where sigma is known, and some law describes the rows, the weight is
exp(-3 k/2 - S/2), and the variance 1.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np
from scipy.special import chdtrc

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.numbers import ROOT_OF_ROUNDING
from stickslip_sym.core.probabilities import UNLIKELY, USUAL_PROBABILITY
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.noise import SAME_COEFFICIENT, last_decimal

RANKED = 8
"""Speeds, from which the greatest weight is worth naming a law."""
_PENALTY = 1.5  # of the logarithm of a weight, for a parameter; Akaike's is 1, Schwarz's log(n)/2
_AS_WELL = 1.3  # times the least variance of residuals
_NORMAL_DOF = 1 / ROOT_OF_ROUNDING  # degrees of freedom that make Student's distribution the normal one
_SPEEDS_OF_CURVE = np.geomspace(1e-3, 1.0, 50)  # of the highest measured one, where curves are compared


class Fitted(Protocol):
    """What is asked of a fit: its parameters, the law that they make, and what the law leaves of each row."""

    @property
    def values(self) -> Mapping[str, float]:
        """The fitted parameters."""

    @property
    def law(self) -> FrictionLaw:
        """The law with the fitted values."""

    @property
    def chi_squared(self) -> float:
        """The sum of squared residuals, each times its weight."""

    @property
    def inflation(self) -> float:
        """How many rows count as one, by the correlation of residuals."""

    @property
    def residuals(self) -> FloatArray:
        """Measured less fitted coefficients."""


class Weighing(NamedTuple):
    """The weights of fits, which sum to 1, and the noise: its variance for a row of weight 1, and its freedom.

    So many rows as `inflation` count as one. `dof` is 0 where no law has fewer parameters than there are speeds:
    nothing was checked then.
    """

    weights: FloatArray
    variance: float
    dof: float
    inflation: float


def weigh(measured: Measurements, fits: Sequence[Fitted]) -> Weighing:
    """Return the weights of fits to measurements, and their noise."""
    inflation = _inflation(len(measured), fits)
    k = np.array([len(fit.values) for fit in fits])
    dof = speeds_that_count(measured) / inflation - k
    checked = dof >= 1
    if not checked.any():
        weights = np.exp(_PENALTY * (k.min() - k))
        return Weighing(weights / weights.sum(), 0.0, 0.0, inflation)
    least = np.maximum(dof, 1) * rounding_variance(measured)
    squares = np.maximum([_squares_of_means(measured, fit) for fit in fits], least)
    variances = np.where(checked, squares / np.maximum(dof, 1), np.inf)
    best = int(np.argmin(variances))
    believed = measured.sigma is not None and bool(
        np.max(chdtrc(dof[checked], squares[checked])) >= 1 - USUAL_PROBABILITY
    )
    if believed:
        misfits = squares / 2
    else:
        misfits = (dof[best] + 1) / 2 * np.log(squares / squares[best])
    logarithms = -misfits - _PENALTY * k
    logarithms = np.where(checked, logarithms, -np.inf)
    weights = _shared_by_curve(np.exp(logarithms - logarithms.max()), measured, fits)
    weights /= weights.sum()
    if believed:
        return Weighing(weights, 1.0, _NORMAL_DOF, inflation)
    likely = likely_laws(weights)
    shares = weights[likely] / weights[likely].sum()
    return Weighing(weights, float(shares @ variances[likely]), float(shares @ dof[likely]), inflation)


def _inflation(rows: int, fits: Sequence[Fitted]) -> float:
    """Return how many rows count as one: the fewest by a law that describes them about as well as the best.

    A law that does not describe them leaves residuals that are correlated too, and so may one that follows noise.
    """
    variances = [fit.chi_squared / max(rows - len(fit.values), 1) for fit in fits]
    near = [
        fit.inflation
        for fit, variance in zip(fits, variances, strict=True)
        if variance <= _AS_WELL * min(variances)
    ]
    return min(near)


def likely_laws(weights: FloatArray) -> BoolArray:
    """Return which laws may be meant: those whose weight is not far below the greatest."""
    return np.asarray(weights >= UNLIKELY * weights.max())


def speeds_that_count(measured: Measurements) -> int:
    """Return how many speeds say something of a law's shape, beside differences between branches."""
    return min(len(measured.speeds), len(measured) - measured.differences)


def _squares_of_means(measured: Measurements, fit: Fitted) -> float:
    """Return the sum of squares of weighted residuals, where rows at one speed count as their weighted mean."""
    weights = measured.weights
    _, index = np.unique(measured.v, return_inverse=True)
    sums = np.bincount(index, weights**2 * fit.residuals)
    return float(np.sum(sums**2 / np.bincount(index, weights**2)))


def rounding_variance(measured: Measurements) -> float:
    """Return the variance of a row of weight 1 that rounding of the coefficients alone has."""
    largest = float(np.max(np.abs(measured.mu)))
    # A rounding error is evenly spread over one decimal.
    rounding = last_decimal(measured.mu) ** 2 / 12 + (np.finfo(np.float64).eps * largest) ** 2
    return max(float(np.mean(measured.weights**2)) * rounding, float(np.finfo(np.float64).tiny))


def _shared_by_curve(weights: FloatArray, measured: Measurements, fits: Sequence[Fitted]) -> FloatArray:
    """Return weights where laws whose fitted curves are one share the greatest of theirs."""
    speeds = _SPEEDS_OF_CURVE * float(measured.v[-1])
    curves = [fit.law.at_speeds(speeds) for fit in fits]
    near = SAME_COEFFICIENT * float(np.max(np.abs(measured.mu)))
    shared = weights.copy()
    left = list(range(len(fits)))
    while left:
        same = [i for i in left if np.abs(curves[i] - curves[left[0]]).max() <= near]
        together = float(weights[same].sum())
        if together > 0:
            shared[same] = weights[same] * (weights[same].max() / together)
        left = [i for i in left if i not in same and i != left[0]]
    return shared

"""How noise is correlated from row to row, and how finely coefficients are written."""

import math
from statistics import NormalDist

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.numbers import SAME
from stickslip_sym.core.probabilities import UNLIKELY

_LAGS = 4  # rows apart, up to which noise may be correlated: as many sweeps may be interleaved
_ROWS_OF_A_LAG = 8  # of fewer for each lag, a partial correlation that is noise counts most rows away
SAME_COEFFICIENT = 1e-6  # of the largest coefficient, by which two may differ that are one
_DECIMALS_OF_SAME = -round(math.log10(SAME))  # with so many decimals any coefficient is the one that is written
_MOST_CORRELATED = 0.95  # beyond it the rows are too few to tell noise from a trend
_CORRELATED = NormalDist().inv_cdf(1 - UNLIKELY / _LAGS)
"""Standard deviations of a partial correlation, beyond which white noise seldom has one of so many lags."""


def correlation_of(e: FloatArray, k: int) -> tuple[float, float, int]:
    """Return how many residuals in a row count as one, and the partial correlation that says so, with its lag.

    The noise is autoregressive, of the order up to four, with a partial correlation that white noise would not
    show, that leaves the fewest. By Levinson's and Durbin's recursion; 1, 0 and 0 if there is none.
    """
    count = len(e)
    strongest = (1.0, 0.0, 0)
    weights = np.zeros(0)
    left = 1.0
    r = np.zeros(0)
    for lag in range(1, min(_LAGS, count // _ROWS_OF_A_LAG) + 1):
        # The k parameters follow part of the noise, which so seems less correlated by about (k + 3 r)/n.
        r = np.append(r, (float(np.sum(e[lag:] * e[:-lag]) / np.sum(e**2)) * count + k) / (count - 3))
        partial = float(np.clip((r[-1] - weights @ r[-2::-1]) / left, -_MOST_CORRELATED, _MOST_CORRELATED))
        weights = np.append(weights - partial * weights[::-1], partial)
        left *= 1 - partial**2
        gain = max(1 - float(weights.sum()), 1 - _MOST_CORRELATED)
        inflation = min(left / gain**2, (1 + _MOST_CORRELATED) / (1 - _MOST_CORRELATED))
        if partial > _CORRELATED * np.sqrt(count) / (count - 3) and inflation > strongest[0]:
            strongest = inflation, partial, lag
    return strongest


def last_decimal(mu: FloatArray) -> float:
    """Return the size of the last decimal that coefficients are written with; 0 if they were computed."""
    for decimals in range(1, _DECIMALS_OF_SAME):
        if np.abs(mu - mu.round(decimals)).max() <= SAME:
            return float(10.0**-decimals)
    return 0.0

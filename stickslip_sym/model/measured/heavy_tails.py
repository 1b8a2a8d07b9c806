"""Noise with heavy tails: rows far off a smooth curve, as many as no normal noise has, weigh less.

Stray rows of an instrument are far off, and few; noise with heavy tails has many rows a little off for each that
is far. Huber's weights keep each row's pull on a fit below that of a row 1.345 standard deviations off, with 95 %
of the efficiency of least squares where the noise is normal after all.

P. J. Huber, Robust estimation of a location parameter, Ann. Math. Statist. 35 (1964) 73.
"""

from statistics import NormalDist

import numpy as np
from scipy.special import pdtrc

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.probabilities import FAR_OFF, VERY_UNLIKELY
from stickslip_sym.model.measured.noise import last_decimal
from stickslip_sym.model.measured.sweep_branches import ROWS_TO_SAMPLE, splines

_ROWS_OF_ONE_NOISE = 100  # rows at neighbouring speeds, whose noise is of one size
DEVIATIONS_OUTLYING = 6.0  # robust standard deviations: no noise, where a little off is beyond `FAR_OFF`
_MANY = 5
"""Times the rows a little off that normal noise has: its size is known to 12 % only, which doubles that. And rows
a little off for one that is no noise: a stray row makes its two neighbours seem so."""
NORMAL_DEVIATION = 1 / NormalDist().inv_cdf(3 / 4)  # of normal noise, over the median of abs(residual)
_LEAST_NOISE_IN_DECIMALS = 2  # last decimals, below which the size of noise is not resolved
_HUBER = 1.345
_REWEIGHTINGS = 20  # of weights and curve in turn; they settle to 1e-3 in some ten


def have_heavy_tails(v: FloatArray, y: FloatArray) -> bool:
    """Return whether coefficients at ascending speeds scatter with heavier tails than normal noise."""
    if len(y) < 2 * _ROWS_OF_ONE_NOISE:
        return False
    bends = _bends(v, y)
    scales = _local_scale(bends)
    if scales.min() <= _LEAST_NOISE_IN_DECIMALS * last_decimal(y):
        return False  # sizes of the noise cannot be told in so coarse digits
    sizes = np.abs(bends) / np.maximum(scales, np.finfo(np.float64).tiny)
    far = int((sizes >= DEVIATIONS_OUTLYING).sum())
    off = int((sizes >= FAR_OFF).sum()) - far
    expected = VERY_UNLIKELY * len(sizes)
    return off > _MANY * max(far, expected) and float(pdtrc(off - 1, expected)) < VERY_UNLIKELY**2


def _bends(v: FloatArray, y: FloatArray) -> FloatArray:
    """Return by how much each row is off the line through its neighbours, with the variance of one row."""
    before = v[1:-1] - v[:-2]
    after = v[2:] - v[1:-1]
    span = before + after
    share = np.divide(after, span, out=np.full(len(span), 0.5), where=span > 0)
    bends = y[1:-1] - share * y[:-2] - (1 - share) * y[2:]
    return np.asarray(bends / np.sqrt(1 + share**2 + (1 - share) ** 2))


def huber_weights(v: FloatArray, y: FloatArray) -> FloatArray:
    """Return a factor between 0 and 1 for the square of each row's residual, by a smooth curve of the speed."""
    every = slice(None, None, max(len(y) // ROWS_TO_SAMPLE, 1))
    all_columns = splines(v)
    columns = all_columns[every]
    some = y[every]
    weights: FloatArray = np.ones(len(some))
    factors = np.zeros(columns.shape[1])
    for _ in range(_REWEIGHTINGS):
        weighted = columns.multiply(weights[:, None]).tocsr()
        factors = np.linalg.lstsq((columns.T @ weighted).toarray(), weighted.T @ some, rcond=None)[0]
        weights = _weights_of(some - columns @ factors)
    return _weights_of(y - all_columns @ factors)


def _weights_of(residuals: FloatArray) -> FloatArray:
    limits = _HUBER * _local_scale(residuals)
    return np.minimum(1.0, limits / np.maximum(np.abs(residuals), np.finfo(np.float64).tiny))


def _local_scale(residuals: FloatArray) -> FloatArray:
    """Return the robust standard deviation of the noise at each of many rows, by blocks of neighbours."""
    count = max(len(residuals) // _ROWS_OF_ONE_NOISE, 1)
    size, longer = divmod(len(residuals), count)
    sizes = np.abs(residuals)
    begin = longer * (size + 1)
    blocks = sizes[:begin].reshape(longer, size + 1), sizes[begin:].reshape(count - longer, size)
    medians = [NORMAL_DEVIATION * np.median(rows, axis=1) for rows in blocks]
    return np.concatenate([np.repeat(medians[0], size + 1), np.repeat(medians[1], size)])

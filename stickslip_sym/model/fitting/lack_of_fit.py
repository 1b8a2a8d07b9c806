"""Whether a law describes the rows that it was fitted to: an F test of two further terms."""

import numpy as np
from scipy.special import fdtrc

from stickslip_sym.core.aliases import FloatArray

_TERMS = 2
_LEFT = 0.2  # of a polynomial's norm: what the law does not explain of it, for it to be a term


def chance_of_residuals(
    residuals: FloatArray, derivatives: FloatArray, polynomials: FloatArray, rounding: float
) -> float | None:
    """Return how likely noise alone makes two further terms explain so much; None for fewer rows than k + 3.

    The terms are the lowest two polynomials that are not the law's own, to first order in its k parameters. Exact
    for independent normal noise and a law that is linear in its parameters.

    - `residuals`: what the law leaves of each row, times its weight, shape (n,).
    - `derivatives`: of the law's rows by its parameters, shape (n, k).
    - `polynomials`: candidates for terms, the lowest first, shape (n, q).
    - `rounding`: the variance of residuals that are rounding; no smaller one is held against the law.
    """
    n, k = derivatives.shape
    free = n - k - _TERMS
    if free < 1:
        return None
    own, _ = np.linalg.qr(derivatives / np.linalg.norm(derivatives, axis=0))
    terms = np.zeros((n, 0))
    for polynomial in polynomials.T:
        left = polynomial - own @ (own.T @ polynomial)
        left -= terms @ (terms.T @ left)
        if np.linalg.norm(left) > _LEFT * np.linalg.norm(polynomial):
            terms = np.column_stack([terms, left / np.linalg.norm(left)])
        if terms.shape[1] == _TERMS:
            break
    else:
        return None
    explained = float(np.sum((terms.T @ residuals) ** 2))
    rest = max(float(residuals @ residuals) - explained, free * rounding)
    return float(fdtrc(_TERMS, free, explained / _TERMS / (rest / free)))


def polynomials_of_rank(v: FloatArray, k: int) -> FloatArray:
    """Return Legendre polynomials of the rank of each row's speed, the constant first, as columns.

    They are those among which a law of k parameters leaves two, and as many again.
    """
    speeds, rank = np.unique(v, return_inverse=True)
    share = 2 * rank / max(len(speeds) - 1, 1) - 1
    return np.polynomial.legendre.legvander(share, min(len(speeds) - 1, k + 2 * _TERMS))

"""Coefficients of short formulas: power series of slope averages, and polynomials through values."""

import mpmath
import numpy as np
from flint import arb, arb_series
from numpy.polynomial import chebyshev

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Mpf
from stickslip_sym.core.balls import rational, series_function, working_precision
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.exact import in_mpmath

__all__ = ["TERMS", "chebyshev_fit", "chebyshev_nodes", "economised", "taylor", "to_monomials"]

TERMS = 30
"""The most terms of a series."""

DIGITS = 40  # in which coefficients are computed
_BITS = 300  # the same for those of power series, before they cancel
_LAST = 12  # coefficients by which a radius of convergence is judged
_NEAR, _FAR = 3.5, 1 / 16  # one over the distance of a singularity: too near for a series, and far away


def taylor(slope: Expr, criterion: Criterion, decay: float) -> tuple[list[Mpf], float] | None:
    """Return the coefficients of exp(decay r) F(r), and a radius within which they serve.

    None where the slope is not analytic at v = 0, or has a singularity near by.
    """
    count = 2 * TERMS
    with working_precision(_BITS, count):
        try:
            series = series_function(slope, symbols.v, {})(arb_series([0, 1], prec=count))
        except (ValueError, ZeroDivisionError):  # a pole, or a function without a series here
            return None
        g = [series[k] for k in range(count)]
        if not all(c.is_finite() for c in g):
            return None
        # The radius of convergence, by the root test on the last coefficients.
        rate = max(float(abs(c).upper()) ** (1 / k) for k, c in enumerate(g) if k >= count - _LAST)
        if rate > _NEAR:
            return None
        means = [-c * arb(rational(criterion.mean_power(k))) for k, c in enumerate(g)]
        result = arb_series(means, prec=count) * arb_series([0, arb(decay)], prec=count).exp()
        coefficients = [result[k] for k in range(count)]
    # What may be 0 is: the balls are small beside every coefficient that matters.
    return [mpmath.mpf(0) if c.contains(0) else in_mpmath(c) for c in coefficients], 24.0 if rate < _FAR else 0.25


def economised(coefficients: list[Mpf], end: float) -> tuple[float, ...]:
    """Return a polynomial with as few terms as equal a given one on [0, end] to double precision."""
    with mpmath.workdps(DIGITS):

        def polynomial(z: Mpf) -> Mpf:
            return mpmath.polyval(coefficients[::-1], z)

        least = min(abs(polynomial(0)), abs(polynomial(end))) * mpmath.mpf(2) ** -57
        for terms in range(2, len(coefficients)):
            fitted, error = mpmath.chebyfit(polynomial, [0, end], terms, error=True)
            if error < least:
                return tuple(float(c) for c in reversed(fitted))
    return tuple(float(c) for c in coefficients)


def chebyshev_nodes(n: int) -> FloatArray:
    """Return the n zeros of the Chebyshev polynomial of degree n, in extended precision."""
    real = np.longdouble
    pi = 4 * np.arctan(real(1))
    return np.asarray(np.cos(pi * (np.arange(n, dtype=real) + real(0.5)) / n))


def chebyshev_fit(y: FloatArray) -> FloatArray:
    """Return the Chebyshev coefficients of the polynomial through values at Chebyshev nodes."""
    n = len(y)
    angles = np.arange(n)[:, None] * (2 * np.arange(n) + 1) % (4 * n)
    quarter = 2 * np.arctan(np.longdouble(1)) / n  # of a turn, over n
    coefficients: FloatArray = (np.cos(angles * quarter) * y).sum(axis=1) * (2 / np.longdouble(n))
    coefficients[0] /= 2
    return coefficients


def to_monomials(coefficients: FloatArray) -> FloatArray:
    """Return the coefficients in powers of t of a Chebyshev sum, as many as there are."""
    found: FloatArray = np.zeros_like(coefficients)
    monomials = chebyshev.cheb2poly(coefficients)
    found[: len(monomials)] = monomials
    return found

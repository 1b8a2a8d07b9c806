"""Chebyshev polynomials on [-1, 1]: nodes, and from values there to all else, in floats and in balls.

Coefficients stand on the last axis, ascending.
"""

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import cast

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx
from numpy.polynomial import chebyshev

from stickslip_sym.core.aliases import FloatArray, IntArray

_REAL = 1e-3
"""Imaginary part of a root that rounding has parted from another: a double root is off by about the square root of
rounding, 1e-8, times the condition of polynomials of a few dozen terms."""


class Grid:
    """Chebyshev's n nodes, ascending, and matrices by which values at them are multiplied from the right."""

    def __init__(self, n: int) -> None:
        self.n = n
        steps = 2 * np.arange(n) + 1 - 2 * n
        orders = np.arange(n)
        cosines = _cosines(np.outer(steps, orders), n)
        weights = np.where(orders == 0, 1.0, 2.0) / n
        self.nodes: FloatArray = _cosines(steps, n)
        self.coefficients: FloatArray = cosines * weights
        """From values to coefficients."""
        self.polynomials: FloatArray = cosines.T
        """From coefficients to values."""

    @cached_property
    def lebesgue(self) -> float:
        """By how many errors of its values the polynomial through them may be off: most at the ends."""
        return float(np.abs(self.coefficients.sum(axis=1)).sum())

    @cached_property
    def slopes(self) -> FloatArray:
        """From values to slopes at the nodes."""
        rows = [np.asarray(chebyshev.chebval(self.nodes, chebyshev.chebder(row))) for row in np.eye(self.n)]
        return np.asarray(self.coefficients @ np.array(rows))

    @cached_property
    def powers(self) -> FloatArray:
        """From coefficients to those of the powers of t."""
        rows = [chebyshev.cheb2poly(row) for row in np.eye(self.n)]
        return np.array([np.pad(row, (0, self.n - row.size)) for row in rows])

    def between(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """Return the nodes of intervals, a row for each."""
        centres = (low + high) / 2
        halves = (high - low) / 2
        return np.asarray(centres[..., None] + halves[..., None] * self.nodes)


def _cosines(steps: IntArray, n: int) -> FloatArray:
    """Return the cosines of multiples of pi/(2n) to the last digit: an angle of many turns would be rounded."""
    within_half_a_turn = np.abs((steps + 2 * n) % (4 * n) - 2 * n)
    return np.asarray(np.sin(np.pi / (2 * n) * (n - within_half_a_turn)))


class BallGrid:
    """The same in ball arithmetic, for any nodes in [-1, 1], which have no radius."""

    def __init__(self, nodes: Sequence[arb]) -> None:
        self.nodes = [node.mid() for node in nodes]
        self._polynomials = [arb_poly([1]), arb_poly([0, 1])]
        for _ in nodes[2:]:
            self._polynomials.append(arb_poly([0, 2]) * self._polynomials[-1] - self._polynomials[-2])
        # The matrix of the rounded nodes is inverted: that of cosines would miss what the nodes are rounded by.
        self._matrix = arb_mat([[polynomial(x) for polynomial in self._polynomials] for x in self.nodes]).inv()

    def coefficients(self, values: Sequence[arb]) -> list[arb]:
        """Return the coefficients of the polynomial through values at the nodes."""
        return list((self._matrix * arb_mat([[value] for value in values])).entries())

    def powers(self, coefficients: Sequence[arb]) -> arb_poly:
        """Return a polynomial in powers of t."""
        terms = (c * polynomial for c, polynomial in zip(coefficients, self._polynomials, strict=False))
        return sum(terms, arb_poly([0]))


@lru_cache(maxsize=32)
def grid(n: int) -> Grid:
    """Return n nodes in floats."""
    return Grid(n)


def ball_grid(n: int) -> BallGrid:
    """Return Chebyshev's n nodes in balls of the working precision."""
    return _ball_grid(n, ctx.prec)


@lru_cache(maxsize=8)
def _ball_grid(n: int, _bits: int) -> BallGrid:
    return BallGrid([-(arb(2 * k + 1) / (2 * n)).cos_pi() for k in range(n)])


def gauss_grid(n: int) -> tuple[BallGrid, list[arb]]:
    """Return the nodes of the Gauss-Legendre rule in balls of the working precision, and its weights."""
    return _gauss_grid(n, ctx.prec)


@lru_cache(maxsize=8)
def _gauss_grid(n: int, _bits: int) -> tuple[BallGrid, list[arb]]:
    nodes, weights = zip(*(arb.legendre_p_root(n, k, weight=True) for k in range(n)), strict=True)
    return BallGrid(nodes), [weight.mid() for weight in weights]


def polynomial_values(coefficients: FloatArray, t: FloatArray) -> FloatArray:
    """Return the values of a polynomial at each t, or of rows of them at the columns of t."""
    return np.asarray(chebyshev.chebval(t, coefficients.T, tensor=False))


def derivative_coefficients(coefficients: FloatArray) -> FloatArray:
    """Return the coefficients of the slope."""
    return np.asarray(chebyshev.chebder(coefficients, axis=-1))


def tail(coefficients: FloatArray, count: int) -> FloatArray:
    """Return the largest of the last coefficients: about what a polynomial leaves out."""
    return cast("FloatArray", np.abs(coefficients[..., -count:]).max(axis=-1))


def real_roots(coefficients: FloatArray) -> FloatArray:
    """Return the roots of one polynomial between -1 and 1, ascending; a double root may be there once or twice."""
    roots = chebyshev.chebroots(chebyshev.chebtrim(coefficients))
    real = (np.abs(roots.imag) < _REAL) & (np.abs(roots.real) < 1)
    return np.sort(roots.real[real])

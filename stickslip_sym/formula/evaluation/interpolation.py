"""Polynomials through values in ball arithmetic."""

from collections.abc import Sequence
from functools import lru_cache

from flint import arb, arb_mat, arb_poly


class Interpolation:
    """Polynomials through values at nodes in [-1, 1], as sums of Chebyshev's.

    The weights are those of the quadrature rule with these nodes; there are none for Chebyshev's.
    """

    def __init__(self, nodes: Sequence[arb], weights: Sequence[arb] = ()) -> None:
        self.nodes, self.weights = [node.mid() for node in nodes], [weight.mid() for weight in weights]
        self._polynomials = [arb_poly([1]), arb_poly([0, 1])]
        for _ in nodes[2:]:
            self._polynomials.append(arb_poly([0, 2]) * self._polynomials[-1] - self._polynomials[-2])
        self._matrix = arb_mat([[polynomial(x) for polynomial in self._polynomials] for x in self.nodes]).inv()

    def coefficients(self, values: Sequence[arb]) -> list[arb]:
        """Return the coefficients of the Chebyshev sum through values at the nodes."""
        return list((self._matrix * arb_mat([[value] for value in values])).entries())

    def monomials(self, coefficients: Sequence[arb]) -> arb_poly:
        """Return a Chebyshev sum in powers of t."""
        pairs = zip(coefficients, self._polynomials, strict=False)
        return sum((c * polynomial for c, polynomial in pairs), arb_poly([0]))


@lru_cache(maxsize=4)
def chebyshev(n: int) -> Interpolation:
    """Return interpolation at Chebyshev's n nodes, by the working precision of the first call."""
    return Interpolation([((2 * k + 1) * arb.pi() / (2 * n)).cos() for k in range(n)])


@lru_cache(maxsize=2)
def legendre(n: int) -> Interpolation:
    """Return interpolation at the nodes of a Gauss-Legendre rule, by the working precision of the first call."""
    nodes, weights = zip(*(arb.legendre_p_root(n, k, weight=True) for k in range(n)), strict=True)
    return Interpolation(nodes, weights)

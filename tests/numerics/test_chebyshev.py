"""Chebyshev polynomials against NumPy's, and in balls against exact powers."""

import numpy as np
import pytest
from flint import arb, fmpq
from numpy.polynomial import chebyshev as reference

from stickslip_sym.numerics import chebyshev


@pytest.mark.parametrize("n", [2, 3, 15, 17, 64])
def test_matrices_are_those_of_polynomials(n):
    """Of random coefficients: values, coefficients from these, slopes, powers, and a tail."""
    grid, random = chebyshev.grid(n), np.random.default_rng(n)
    assert grid.nodes == pytest.approx(reference.chebpts1(n), abs=2e-16)
    for coefficients in random.normal(size=(3, n)):
        values = reference.chebval(grid.nodes, coefficients)
        assert coefficients @ grid.polynomials == pytest.approx(values, abs=1e-15 * n**2)
        assert values @ grid.coefficients == pytest.approx(coefficients, abs=1e-15 * n**2)
        slope = chebyshev.derivative_coefficients(coefficients)
        assert slope == pytest.approx(reference.chebder(coefficients))
        slopes = chebyshev.polynomial_values(slope, grid.nodes)
        assert values @ grid.slopes == pytest.approx(slopes, abs=1e-15 * n**4)
        if n < 20:  # higher powers cancel
            powers = (coefficients @ grid.powers)[::-1]
            assert np.polyval(powers, grid.nodes) == pytest.approx(values, abs=1e-8)
        assert chebyshev.tail(coefficients, 2) == np.abs(coefficients[-2:]).max()


@pytest.mark.parametrize("n", [2, 5, 17, 40])
def test_errors_of_values_are_errors_of_the_polynomial(n):
    """By no more than Lebesgue's constant, which signs at the nodes reach: 2/pi log(n) and about one."""
    grid = chebyshev.grid(n)
    places = np.linspace(-1, 1, 501)
    for signs in np.random.default_rng(n).choice([-1.0, 1.0], (20, n)):
        off = reference.chebval(places, signs @ grid.coefficients)
        assert np.abs(off).max() <= grid.lebesgue * (1 + 1e-12)
    worst = np.sign(grid.coefficients.sum(axis=1))
    assert reference.chebval(1.0, worst @ grid.coefficients) == pytest.approx(grid.lebesgue)
    assert grid.lebesgue == pytest.approx(2 / np.pi * np.log(n) + 0.9625, abs=0.05)


def test_nodes_of_many_intervals():
    x = chebyshev.grid(5).between(np.array([0.0, 2.0]), np.array([1.0, 6.0]))
    assert x[1] == pytest.approx(4 + 2 * reference.chebpts1(5))
    rows = np.array([[1.0, 2.0], [3.0, -1.0]])
    assert chebyshev.polynomial_values(rows, np.array([0.5, 0.25])).tolist() == [2.0, 2.75]


def test_roots_between_the_ends_simple_and_double():
    def polynomial(*roots):
        return reference.poly2cheb(np.polynomial.polynomial.polyfromroots(roots))

    assert chebyshev.real_roots(polynomial(-0.5, 0.25, 2.0)) == pytest.approx([-0.5, 0.25])
    double = chebyshev.real_roots(polynomial(0.3, 0.3, -0.9))
    assert double[0] == pytest.approx(-0.9)
    assert len(double) > 1
    assert double[1:] == pytest.approx(np.full(len(double) - 1, 0.3), abs=1e-6)
    assert chebyshev.real_roots(polynomial(0.2 + 0.1j, 0.2 - 0.1j)).size == 0


@pytest.mark.parametrize(("distance", "count"), [(5e-4, 2), (3e-3, 0)])
def test_roots_that_rounding_may_have_parted_count(distance, count):
    """Two complex ones stand for a double root if they are that close to the axis, and for none else."""
    pair = np.polynomial.polynomial.polyfromroots([0.3 + distance * 1j, 0.3 - distance * 1j]).real
    assert chebyshev.real_roots(reference.poly2cheb(pair)).size == count


@pytest.mark.parametrize("n", [3, 12])
def test_balls_hold_the_polynomial_through_given_values(n):
    """Of exact powers, whose coefficients in powers of t come back within small balls."""
    grid = chebyshev.ball_grid(n)
    wanted = [fmpq(3 * k - 4, k + 2) for k in range(n)]
    values = [sum((arb(c) * x**k for k, c in enumerate(wanted)), arb(0)) for x in grid.nodes]
    powers = grid.powers(grid.coefficients(values))
    for k, c in enumerate(wanted):
        assert powers[k].contains(arb(c))
        assert powers[k].rad() < 1e-6  # of 53 bits, the inverse of a matrix loses half
    assert all(float(a) < float(b) for a, b in zip(grid.nodes, grid.nodes[1:], strict=False))

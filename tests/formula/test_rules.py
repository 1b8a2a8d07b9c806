"""Every rule of integration by itself: what it gives, with random numbers in it, against quadrature."""

import math

import mpmath
import numpy as np
import pytest
import sympy as sp

from stickslip_sym.core.lambdify import function_of
from stickslip_sym.formula.exact import without_squares
from stickslip_sym.formula.finding.antiderivatives import antiderivative
from stickslip_sym.formula.finding.harmonics import average_of_pieces, harmonic_average
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.model.terms import grouped

u, V, x = sp.Symbol("u", positive=True), sp.Symbol("V", positive=True), sp.Symbol("x", real=True)
HALF = sp.Rational(1, 2)

AVERAGED = {
    "a polynomial": lambda p, q, r: p * u**3 - q * u + r,
    "a pole": lambda p, q, r: p / (u + q),
    "a pole of degree 3": lambda p, q, r: (p + u) / (u + q) ** 3,
    "imaginary poles": lambda p, q, r: (p * u + q) / (u**2 + r),
    "double imaginary poles": lambda p, q, r: (p * u + q) / (u**2 + r) ** 2,
    "a quadratic": lambda p, q, r: (p * u + q) / (u**2 + r * u + 1 + r**2),
    "a squared quadratic": lambda p, q, r: (p * u + q) / (u**2 + r * u + 1 + r**2) ** 2,
    "real roots": lambda p, q, r: (p * u + q) / (u**2 + (r + 4) * u + 3),
    "an exponential": lambda p, q, r: u**2 * sp.exp(-p * u + q),
    "a sine": lambda p, q, r: u**2 * sp.sin(p * u + q),
    "a cosine": lambda p, q, r: (1 + r * u) * sp.cos(p * u + q),
    "a logarithm": lambda p, q, r: u**2 * sp.log(p * u + q),
    "a logarithm that falls": lambda p, q, r: u**2 * sp.log(q + 2 - p * u / 8),
    "a logarithm of a quadratic": lambda p, q, r: u * sp.log(u**2 + q * u + 1 + q**2),
    "an arctangent": lambda p, q, r: (u + u**2) * sp.atan(p * u - q),
    "an arctangent that falls": lambda p, q, r: (u + u**2) * sp.atan(q - p * u),
    "an inverse hyperbolic sine": lambda p, q, r: r * sp.asinh(p * u + q),
    "an inverse hyperbolic sine that falls": lambda p, q, r: r * sp.asinh(q - p * u),
    "a root": lambda p, q, r: u * sp.sqrt(p * u),
    "a shifted root": lambda p, q, r: u * sp.sqrt(p * u + q),
    "a shifted root that falls": lambda p, q, r: u * sp.sqrt(q + 2 - p * u / 4),
    "a shifted power that falls": lambda p, q, r: (q + 2 - p * u / 4) ** sp.Rational(-1, 3),
    "a shifted power": lambda p, q, r: u * (p * u + q) ** sp.Rational(-1, 3),
    "an error function": lambda p, q, r: p * sp.erf(u * r),
    "a Gaussian": lambda p, q, r: u * sp.exp(-p * u**2),
    "a stretched exponential": lambda p, q, r: sp.exp(-p * sp.sqrt(u)),
    "a power of a binomial": lambda p, q, r: u * (p + q * u**4) ** (-sp.Rational(1, 8)),
    "a root of a square": lambda p, q, r: p / sp.sqrt(1 + q * u**2),
}
INTEGRATED = {name: family for name, family in AVERAGED.items() if name != "a power of a binomial"} | {
    "a power of tanh": lambda p, q, r: u * sp.tanh(p * u + q) ** 3,
    "a power of sech": lambda p, q, r: u * sp.sech(p * u + q) ** 3,
    "a shifted error function": lambda p, q, r: u * sp.erf(p * u + q),
    "a shifted Gaussian": lambda p, q, r: u * sp.exp(-p * u**2 + q * u),
    "the root of a quadratic": lambda p, q, r: u * sp.sqrt(u**2 + r * u + 1 + r**2),
    "an exponential times tanh": lambda p, q, r: u * sp.exp(-p * u) * sp.tanh(q * u),
    "an exponential over a line": lambda p, q, r: sp.exp(-p * u) / (u + q) ** 2,
    "a stretched exponential of no rule for averages": lambda p, q, r: u * sp.exp(-p * u ** sp.Rational(3, 4)),
}


def drawn(family, seed):
    """Return a term of a family with random numbers."""
    return family(*(sp.Rational(int(n), 7) for n in np.random.default_rng(seed).integers(2, 15, 3)))


@pytest.mark.parametrize("name", AVERAGED)
def test_a_harmonic_average_is_that_by_quadrature(name):
    term, speed = drawn(AVERAGED[name], 1), mpmath.mpf("0.8")
    found = harmonic_average(term, u, V)
    assert found is not None
    of_u, of_V = function_of([u], term, "mpmath"), function_of([V], found[1], "mpmath")
    average = mpmath.quad(
        lambda angle: of_u(2 * speed * mpmath.sin(angle / 2) ** 2) * mpmath.cos(angle), [0, 1.5, mpmath.pi]
    )
    assert abs(of_V(speed) - 2 * average / (mpmath.pi * speed)) < 1e-11


@pytest.mark.parametrize("name", INTEGRATED)
def test_an_antiderivative_grows_by_the_integral(name):
    term, kernel = drawn(INTEGRATED[name], 3), 1 - u
    found = antiderivative(term, kernel, u)
    assert found is not None
    of_u, primitive = function_of([u], term * kernel, "mpmath"), function_of([u], found[1], "mpmath")
    low, high = mpmath.mpf("0.3"), mpmath.mpf("1.4")
    grown = primitive(high) - primitive(low)
    assert abs(grown - mpmath.quad(of_u, [low, high])) < 1e-11


def test_a_rule_is_not_taken_for_what_it_does_not_fit():
    for term in (sp.exp(u) * sp.tanh(u), sp.exp(-u) * sp.tanh(u + 1), sp.exp(-u) * sp.tanh(1 - u)):
        found = antiderivative(term, sp.Integer(1), u)
        assert found is None or found[0] != "Lerch transcendent"


def test_averages_of_polynomials_with_kinks():
    rng = np.random.default_rng(4)
    first, second = sorted(float(place) for place in rng.uniform(0.1, 1.5, 2))
    ends = [sp.Integer(0), sp.Float(first), sp.Float(second), 2 * V]
    pieces = [sp.Add(*[int(c) * u**n for n, c in enumerate(rng.integers(-9, 9, 4))]) for _ in range(3)]
    found = function_of([V], average_of_pieces(pieces, ends, u, V), "mpmath")(mpmath.mpf("0.8"))
    of_u = [function_of([u], piece, "mpmath") for piece in pieces]
    angles = [mpmath.acos(1 - place / 0.8) for place in (0, first, second, 1.6)]
    average = sum(
        mpmath.quad(lambda angle, f=f: f(0.8 * (1 - mpmath.cos(angle))) * mpmath.cos(angle), [low, high])
        for f, low, high in zip(of_u, angles, angles[1:], strict=False)
    )
    assert found == pytest.approx(float(2 * average / (math.pi * 0.8)), abs=1e-9)


def test_one_minus_tanh_squared_is_sech_squared():
    assert without_squares(1 - sp.tanh(x) ** 2) == sp.sech(x) ** 2
    for other in (1 + sp.tanh(x) ** 2, 1 - sp.tanh(x) ** 3, 1 - sp.cos(x) ** 2, 2 - sp.tanh(x) ** 2):
        assert without_squares(other) == other


def test_a_sum_is_what_its_groups_add_up_to():
    """Also with factors of 1, and without those of 0."""
    for f in (
        u + sp.exp(-u) + 3 * u**2,
        u + x * u**2 + 1 / (u + 1),
        x * u + (1 - x) * u + sp.exp(u),
        u - u * x + x * u,
    ):
        groups = grouped(f, u)
        assert sp.expand(f - sum(rest * constant for rest, constant in groups.items())) == 0
        assert 0 not in groups.values()


def test_radicands_are_factored_and_powers_are_not():
    a, b = sp.symbols("a b", positive=True)
    assert normal_form(sp.sqrt(a**2 + 2 * a * b + b**2) - a - b) == 0

"""The damping coefficient c of exponential, least_squares, proved for all parameters.

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):
c = -N int_-1^1 w(s) mu'(V (1 + s)) ds. SymPy and mpmath suffice; an AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, exp


def vanishes(expr):
    """Whether an expression is 0 by algebra: over one denominator, expanded."""
    return sp.expand(sp.powsimp(sp.expand(sp.fraction(sp.together(expr))[0]))) == 0


def rise(A, low, high):
    """Return what an antiderivative rises by between two speeds."""
    return A.subs(v, high) - A.subs(v, low)


def at(i, expr, free=None):
    """Return an expression at the i-th of many points: with numbers for its symbols, but for the one left free."""
    numbers = {x: Rational(random.Random(f"{i} {x}").randint(500, 1500), 1000) for x in expr.free_symbols - {free}}
    return sp.N(expr.subs(numbers), 50)


def compare(c, integrand, x, end, kinks):
    """Assert that c is the integral over x from 0 to an end, by mpmath, to 30 digits at twelve points."""
    mpmath.mp.dps = 50
    for i in range(12):
        places = [at(i, sp.sympify(place)) for place in (*kinks, *(end * j / 4 for j in range(5)))]
        ends = sorted({mpmath.mpmathify(place) for place in places if place.is_real and 0 <= place <= places[-1]})
        integral = mpmath.quad(sp.lambdify(x, at(i, integrand, x), "mpmath"), ends)
        assert abs(at(i, c) - integral) <= 1e-30 * max(abs(integral), 1e-10), f"the definition at point {i}"


# -- exponential, least_squares --------------------------------------------------------------------
V, N, mu_s, mu_m, alpha = sp.symbols("V N mu_s mu_m alpha", positive=True)
v = Symbol("v", nonnegative=True)
s = Symbol("s", real=True)
mu = mu_m + (mu_s - mu_m) * exp(-alpha * v)
# Won & Chung 2016, eq. (16), integrated by parts
w = Rational(5, 8) - 5 * s**4 / 8
c = 5 * N * (mu_s - mu_m) * (V**3 * alpha**3 - 3 * V**2 * alpha**2 + 6 * V * alpha + (V**3 * alpha**3 + 3 * V**2 * alpha**2 + 6 * V * alpha + 6) * exp(-2 * V * alpha) - 6) / (2 * V**5 * alpha**4)  # fmt: skip  # noqa: E501
K = -5 * (v - V) ** 3 / (2 * V**5)  # by parts, with v = V (1 + s): c = N int_0^2V mu K dv
assert vanishes(K - sp.diff(w, s).subs(s, v / V - 1) / V**2), "the kernel"
assert sp.integrate(w, (s, -1, 1)) == 1, "the weight is an average"
g1 = exp(-v)  # in units of its scale; F1(V) = -<g'(V (1 + s))>
A1_0 = 5 * (v - V) ** 3 * exp(-v) / (2 * V**5) + 15 * (v - V) ** 2 * exp(-v) / (2 * V**5) + 15 * (v - V) * exp(-v) / V**5 + 15 * exp(-v) / V**5  # fmt: skip  # noqa: E501
assert vanishes(sp.diff(A1_0, v) - g1 * K), "A1_0: the derivative of the antiderivative"
F1 = rise(A1_0, 0, 2 * V)
# The law is a sum of terms a g(v/b), which add N a/b F(V/b) each: criteria are linear, and scale
law = mu_m + (mu_s - mu_m) * g1.subs(v, alpha * v)
assert vanishes(mu - law), "the split of the law into terms"
total = N * (alpha * (mu_s - mu_m) * F1.subs(V, V * alpha))
assert vanishes(c - total), "the sum of the averages"
compare(c, N * mu * K, v, 2 * V, [])
at_rest = N * alpha * (mu_s - mu_m)  # as V and all slip speeds fall to 0, c tends to -N mu'(0)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
far = 0  # as V grows, and slow slip loses its weight, c tends to -N mu', compared at one v
assert abs(far + at(0, N * sp.diff(mu, v).subs(v, 10**200))) < 1e-25, "the limit for high belt speeds"
print("proved: exponential, least_squares")

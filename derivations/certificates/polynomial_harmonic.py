"""The damping coefficient c of polynomial, harmonic, proved for all parameters.

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):
c = -N int_-1^1 w(s) mu'(V (1 + s)) ds. SymPy and mpmath suffice; an AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, cos, gamma, pi, sin, sqrt


def vanishes(expr):
    """Whether an expression is 0 by algebra: over one denominator, expanded."""
    return sp.expand(sp.powsimp(sp.expand(sp.fraction(sp.together(expr))[0]))) == 0


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


# -- polynomial, harmonic --------------------------------------------------------------------------
V, N, n, mu_s, mu_m, v_m = sp.symbols("V N n mu_s mu_m v_m", positive=True)
v = Symbol("v", nonnegative=True)
s, theta = sp.symbols("s theta", real=True)
mu = mu_s + v**3 * (mu_s - mu_m) / (2 * v_m**3) - v * (3 * mu_s - 3 * mu_m) / (2 * v_m)
# first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003
w = 2 * sqrt(1 - s**2) / pi
c = 3 * N * (4 * v_m**2 - 5 * V**2) * (mu_s - mu_m) / (8 * v_m**3)
K = 2 * cos(theta) / (pi * V)  # by parts, with v = V (1 - cos(theta)): c = N int_0^pi mu K dtheta
assert abs(at(0, K - sp.diff(w, s).subs(s, -cos(theta)) * sin(theta) / V)) < 1e-25, "the kernel"
# The moments b_n = n <(1 + s)^(n - 1)>, as integrals of powers: DLMF 5.12
b = 2 ** (n + 2) * n * gamma(n + Rational(1, 2)) / (2 * sqrt(pi) * gamma(n + 2))
ratio = (2 * n + 1) * (n + 1) / (n * (n + 2))
assert vanishes(sp.expand_func(b.subs(n, n + 1) / b) - ratio), "the ratio of the moments"
g1 = v**3 - 3 * v  # in units of its scale; F1(V) = -<g'(V (1 + s))>
g1_0 = v**3
F1_0 = sp.sympify(-15 * V**2 / 4)
assert vanishes(F1_0 + sum(a * b.subs(n, j) * V ** (j - 1) for (j,), a in sp.Poly(g1_0, v).terms() if j)), "F1_0: the moments"  # fmt: skip  # noqa: E501
g1_1 = -3 * v
F1_1 = sp.sympify(3)
assert vanishes(F1_1 + sum(a * b.subs(n, j) * V ** (j - 1) for (j,), a in sp.Poly(g1_1, v).terms() if j)), "F1_1: the moments"  # fmt: skip  # noqa: E501
assert vanishes(g1 - (g1_0 + g1_1)), "g1 is the sum of its parts"
F1 = F1_0 + F1_1
# The law is a sum of terms a g(v/b), which add N a/b F(V/b) each: criteria are linear, and scale
law = mu_s + -(mu_m - mu_s) / 2 * g1.subs(v, v / v_m)
assert vanishes(mu - law), "the split of the law into terms"
total = N * (-(mu_m - mu_s) / (2 * v_m) * F1.subs(V, V / v_m))
assert vanishes(c - total), "the sum of the averages"
compare(c, N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K, theta, pi, [])
at_rest = 3 * N * (mu_s - mu_m) / (2 * v_m)  # as V and all slip speeds fall to 0, c tends to -N mu'(0)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
# as V grows, and slow slip loses its weight, mu' is like v^p, its average like V^p <(1 + s)^p>
far = -15 * N * V**2 * (mu_s - mu_m) / (8 * v_m**3)
like = -sp.Integral(w * (1 + s) ** 2, (s, -1, 1)) * N * sp.diff(mu, v).subs(v, 10**200) * (V / 10**200) ** 2
assert abs(at(0, far / like) - 1) < 1e-25, "the limit for high belt speeds"
print("proved: polynomial, harmonic")

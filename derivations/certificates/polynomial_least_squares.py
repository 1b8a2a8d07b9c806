"""The damping coefficient c of polynomial, least_squares, proved for all parameters.

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):
c = -N int_-1^1 w(s) mu'(V (1 + s)) ds. SymPy and mpmath suffice; an AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol


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


# -- polynomial, least_squares ---------------------------------------------------------------------
V, N, mu_s, mu_m, v_m = sp.symbols("V N mu_s mu_m v_m", positive=True)
v = Symbol("v", nonnegative=True)
s = Symbol("s", real=True)
mu = mu_s + v**3 * (mu_s - mu_m) / (2 * v_m**3) - v * (3 * mu_s - 3 * mu_m) / (2 * v_m)
# Won & Chung 2016, eq. (16), integrated by parts
w = Rational(5, 8) - 5 * s**4 / 8
c = N * (21 * v_m**2 - 26 * V**2) * (mu_s - mu_m) / (14 * v_m**3)
K = -5 * (v - V) ** 3 / (2 * V**5)  # by parts, with v = V (1 + s): c = N int_0^2V mu K dv
assert vanishes(K - sp.diff(w, s).subs(s, v / V - 1) / V**2), "the kernel"
assert sp.integrate(w, (s, -1, 1)) == 1, "the weight is an average"
g1 = v**3 - 3 * v  # in units of its scale; F1(V) = -<g'(V (1 + s))>
g1_0 = v**3
A1_0_0 = 5 * v**4 / (8 * V**2) - 3 * v**5 / (2 * V**3) + 5 * v**6 / (4 * V**4) - 5 * v**7 / (14 * V**5)
assert vanishes(sp.diff(A1_0_0, v) - g1_0 * K), "A1_0_0: the derivative of the antiderivative"
F1_0 = rise(A1_0_0, 0, 2 * V)
g1_1 = -3 * v
A1_1_0 = 15 * v**3 / (2 * V**3) - 15 * v**2 / (4 * V**2) - 45 * v**4 / (8 * V**4) + 3 * v**5 / (2 * V**5)
assert vanishes(sp.diff(A1_1_0, v) - g1_1 * K), "A1_1_0: the derivative of the antiderivative"
F1_1 = rise(A1_1_0, 0, 2 * V)
assert vanishes(g1 - (g1_0 + g1_1)), "g1 is the sum of its parts"
F1 = F1_0 + F1_1
# The law is a sum of terms a g(v/b), which add N a/b F(V/b) each: criteria are linear, and scale
law = mu_s + -(mu_m - mu_s) / 2 * g1.subs(v, v / v_m)
assert vanishes(mu - law), "the split of the law into terms"
total = N * (-(mu_m - mu_s) / (2 * v_m) * F1.subs(V, V / v_m))
assert vanishes(c - total), "the sum of the averages"
compare(c, N * mu * K, v, 2 * V, [])
at_rest = 3 * N * (mu_s - mu_m) / (2 * v_m)  # as V and all slip speeds fall to 0, c tends to -N mu'(0)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
# as V grows, and slow slip loses its weight, mu' is like v^p, its average like V^p <(1 + s)^p>
far = -13 * N * V**2 * (mu_s - mu_m) / (7 * v_m**3)
like = -sp.Integral(w * (1 + s) ** 2, (s, -1, 1)) * N * sp.diff(mu, v).subs(v, 10**200) * (V / 10**200) ** 2
assert abs(at(0, far / like) - 1) < 1e-25, "the limit for high belt speeds"
print("proved: polynomial, least_squares")

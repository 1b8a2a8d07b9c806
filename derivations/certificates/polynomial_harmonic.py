"""The damping coefficient c, proved for every value of its parameters.

- polynomial, harmonic

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds v = V (1 + s) from 0 to 2 V, with a weight w(s):

    c = -N integral of w(s) mu'(V (1 + s)) ds over -1 <= s <= 1.

Nothing but SymPy and mpmath is needed. An AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, asin, cos, gamma, pi, sin, sqrt


def vanishes(expr):
    """Whether an expression is 0 by algebra: exponentials for hyperbolic functions, one denominator, expanded."""
    expr = sp.sympify(expr)
    expr = expr.rewrite((sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.coth, sp.csch), sp.exp)
    return sp.expand(sp.powsimp(sp.expand(sp.fraction(sp.together(expr))[0]))) == 0


def same(a, b):
    """Whether two expressions have the same value to 25 digits at a random point."""
    point = {x: sp.Rational(random.randint(20, 60), 40) for x in a.free_symbols | b.free_symbols}
    a, b = (sp.N(side.subs(point), 30) for side in (a, b))
    return abs(a - b) <= 1e-25 * (abs(a) or 1)


def compare(c, integrand, variable, end, kinks, parameters):
    """Assert that c is the integral from 0 to an end, by mpmath, to 30 digits at twelve seeded points."""
    random.seed(12)
    for _ in range(12):
        point = {x: sp.Rational(random.randint(20, 60), 40) for x in parameters}
        with mpmath.workdps(50):
            places = [sp.N(sp.sympify(x).subs(point), 60) for x in (*kinks, *(end * i / 4 for i in range(5)))]
            places = [mpmath.mpmathify(x) for x in places if x.is_real and 0 <= x <= sp.N(end.subs(point), 60)]
            value = mpmath.quad(sp.lambdify(variable, integrand.subs(point), "mpmath"), sorted(set(places)))
            formula = mpmath.mpmathify(sp.N(c.subs(point), 40))
        assert abs(formula - value) <= mpmath.mpf("1e-30") * (abs(formula) or 1), f"the definition at {point}"


# -- polynomial, harmonic --------------------------------------------------------------------------
V, N, mu_s, mu_m, v_m = sp.symbols("V N mu_s mu_m v_m", positive=True)
v = Symbol("v", nonnegative=True)
mu = mu_s + v**3 * (mu_s - mu_m) / (2 * v_m**3) - v * (3 * mu_s - 3 * mu_m) / (2 * v_m)
# first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003
s = Symbol("s", real=True)
w = 2 * sqrt(1 - s**2) / pi
c = 3 * N * (4 * v_m**2 - 5 * V**2) * (mu_s - mu_m) / (8 * v_m**3)

# By parts, with v = V (1 - cos(theta)): c = N integral of mu K over 0 <= theta <= pi
theta = Symbol("theta", real=True)
K = 2 * cos(theta) / (pi * V)
assert same(K, sp.diff(w, s).subs(s, -cos(theta)) * sin(theta) / V), "the kernel"
# The moments b_n = n <(1 + s)^(n - 1)>, as integrals of powers: DLMF 5.12
n = Symbol("n", positive=True)
b = 2 ** (n + 2) * n * gamma(n + Rational(1, 2)) / (2 * sqrt(pi) * gamma(n + 2))
ratio = (n + 1) * (2 * n + 1) / (n * (n + 2))
assert vanishes(sp.expand_func(b.subs(n, n + 1) / b) - ratio), "the ratio of the moments"
# The profile g1(v), speeds in units of its scale, and its average F1(V)
g1 = v**3 - 3 * v
g1_0 = v**3
F1_0 = sp.sympify(-15 * V**2 / 4)
moments = [b.subs(n, j) * a * V ** (j - 1) for (j,), a in sp.Poly(g1_0, v).terms() if j]
assert vanishes(F1_0 + sum(moments)), "F1_0: the moments of the weight"
g1_1 = -3 * v
F1_1 = sp.sympify(3)
moments = [b.subs(n, j) * a * V ** (j - 1) for (j,), a in sp.Poly(g1_1, v).terms() if j]
assert vanishes(F1_1 + sum(moments)), "F1_1: the moments of the weight"
assert vanishes(g1 - (g1_0 + g1_1)), "g1 is the sum of its parts"
F1 = F1_0 + F1_1
# The law is a sum of a g(v/b), which add N a/b F(V/b) each: the criterion is linear, and scales
law = mu_s + -(mu_m - mu_s) / 2 * g1.subs({v: v / v_m}, simultaneous=True)
assert vanishes(mu - law), "the split of the law into terms"
total = N * (-(mu_m - mu_s) / 2 / v_m * F1.subs({V: V / v_m}, simultaneous=True))
assert vanishes(c - total), "the sum of the averages"
# By mpmath, without any of the above
parameters = (V, N, mu_s, mu_m, v_m)
angles = [2 * asin(sqrt(place / (2 * V))) for place in []]
integrand = N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K
compare(c, integrand, theta, pi, angles, parameters)
# As V falls to 0, c tends to -N mu'(0): the weight has unit integral, the slope is continuous
at_rest = 3 * N * (mu_s - mu_m) / (2 * v_m)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
print("proved: polynomial, harmonic")

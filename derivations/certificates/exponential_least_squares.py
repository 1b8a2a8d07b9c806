"""The damping coefficient c, proved for every value of its parameters.

- exponential, least_squares

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds v = V (1 + s) from 0 to 2 V, with a weight w(s):

    c = -N integral of w(s) mu'(V (1 + s)) ds over -1 <= s <= 1.

Nothing but SymPy and mpmath is needed. An AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, exp


def vanishes(expr):
    """Whether an expression is 0 by algebra: exponentials for hyperbolic functions, one denominator, expanded."""
    expr = sp.sympify(expr)
    expr = expr.rewrite((sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.coth, sp.csch), sp.exp)
    return sp.expand(sp.powsimp(sp.expand(sp.fraction(sp.together(expr))[0]))) == 0


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


# -- exponential, least_squares --------------------------------------------------------------------
V, N, mu_s, mu_m, alpha = sp.symbols("V N mu_s mu_m alpha", positive=True)
v = Symbol("v", nonnegative=True)
mu = mu_m + (mu_s - mu_m) * exp(-alpha * v)
# Won & Chung 2016, eq. (16), integrated by parts
s = Symbol("s", real=True)
w = Rational(5, 8) - 5 * s**4 / 8
c = 5 * N * (mu_s - mu_m) * (V**3 * alpha**3 - 3 * V**2 * alpha**2 + 6 * V * alpha + (V**3 * alpha**3 + 3 * V**2 * alpha**2 + 6 * V * alpha + 6) * exp(-2 * V * alpha) - 6) / (2 * V**5 * alpha**4)  # fmt: skip  # noqa: E501

# By parts, with v = V (1 + s): c = N integral of mu K over 0 <= v <= 2 V
K = -5 * (v - V) ** 3 / (2 * V**5)
assert vanishes(K - sp.diff(w, s).subs(s, v / V - 1) / V**2), "the kernel"
assert sp.integrate(w, (s, -1, 1)) == 1, "the weight is an average"
# The profile g1(v), speeds in units of its scale, and its average F1(V)
g1 = exp(-v)
A1_0 = 5 * (v - V) ** 3 * exp(-v) / (2 * V**5) + 15 * (v - V) ** 2 * exp(-v) / (2 * V**5) + 15 * (v - V) * exp(-v) / V**5 + 15 * exp(-v) / V**5  # fmt: skip  # noqa: E501
assert vanishes(sp.diff(A1_0, v) - g1 * K), "A1_0: the derivative of the antiderivative"
F1 = A1_0.subs(v, 2 * V) - A1_0.subs(v, 0)
# The law is a sum of a g(v/b), which add N a/b F(V/b) each: the criterion is linear, and scales
law = mu_m + (mu_s - mu_m) * g1.subs({v: v / (1 / alpha)}, simultaneous=True)
assert vanishes(mu - law), "the split of the law into terms"
total = N * ((mu_s - mu_m) / (1 / alpha) * F1.subs({V: V / (1 / alpha)}, simultaneous=True))
assert vanishes(c - total), "the sum of the averages"
# By mpmath, without any of the above
parameters = (V, N, mu_s, mu_m, alpha)
compare(c, N * mu * K, v, 2 * V, [], parameters)
# As V falls to 0, c tends to -N mu'(0): the weight has unit integral, the slope is continuous
at_rest = N * alpha * (mu_s - mu_m)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
print("proved: exponential, least_squares")

"""The damping coefficient c, proved for every value of its parameters.

- exponential, harmonic

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds v = V (1 + s) from 0 to 2 V, with a weight w(s):

    c = -N integral of w(s) mu'(V (1 + s)) ds over -1 <= s <= 1.

Nothing but SymPy and mpmath is needed. An AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, asin, besseli, cos, exp, gamma, pi, sin, sqrt


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


def by_series(name, g, equation, rest, q, first, y, generators, roots, m):
    """Return y/V, once it is proved to be the average of g = sum g_j v^j, which is -sum b_j g_j V^(j-1).

    A differential equation of g is a recurrence of the g_j, so the b_j g_j have one: a differential equation
    of V F(V). Power series that satisfy it and agree in the coefficients that it leaves free are equal, and both
    sides are analytic for V > 0.
    """
    left = sum(a * sp.diff(g, v, i) for i, a in enumerate(equation)) - rest
    assert vanishes(left), f"{name}: the differential equation of the profile"
    # a v^l g^(i) adds a j (j - 1) ... (j - i + 1) g_j to the coefficient of v^(j-i+l): sum_k p_k(n) g_(n+k) = 0
    terms = [(i, power, a) for i, a_i in enumerate(equation) for (power,), a in sp.Poly(a_i, v).terms()]
    low, r = min(i - power for i, power, _ in terms), len(q) - 1
    p = [sum(a * sp.ff(n + k, i) for i, power, a in terms if i - power - low == k) for k in range(r + 1)]
    # With b_(n+k) = b_n over_k that is sum_k q_k(n) b_(n+k) g_(n+k) = 0, but for a common factor
    over = [sp.prod([ratio.subs(n, n + i) for i in range(k)]) for k in range(r + 1)]
    common = sp.factor(p[r] / over[r] / q[r])
    assert all(vanishes(p[k] - common * over[k] * q[k]) for k in range(r + 1)), f"{name}: the recurrence"
    # It leaves the coefficients below first + r free: a factor of a degree above 1 has no rational zero
    zeros = sp.Poly(sp.fraction(common)[0] * q[r], n).ground_roots()
    fixes = all(x.is_Rational and (x.q > 1 or x < first) for x in zeros)
    start = low + (sp.degree(rest, v) + 1 if rest != 0 else 0)
    assert fixes and first >= max(1, start), f"{name}: the free coefficients"  # noqa: PT018
    # As an operator, theta = V d/dV: sum_k V^(r-k) q_k(theta - k) V F(V) is a polynomial below V^(first+r)
    squares, powers, left = [root**2 - square for root, square in roots.items()], [y], 0
    for _ in range(max(sp.degree(q_k, n) for q_k in q if q_k != 0)):
        slopes = [rule * sp.diff(powers[-1], x) for x, (_, rule, _) in generators.items()]
        slope = V * (sp.diff(powers[-1], V) + sum(slopes))
        powers.append(sp.reduced(slope, squares, *generators, order="grevlex")[1])
    for k, q_k in enumerate(q):
        left += V ** (r - k) * sum(a * powers[i] for (i,), a in sp.Poly(q_k, n).compose(sp.Poly(n - k, n)).terms())
    left = sp.cancel(sp.reduced(left, squares, *generators, order="grevlex")[1])
    polynomial = left.is_polynomial(V) and not left.has(*generators)
    assert polynomial and sp.Poly(left, V).degree() < first + r, f"{name}: the operator"  # noqa: PT018
    # With the first terms of the functions, and a symbol times V^m for the rest, the free coefficients are equal
    starts = {x: begin + V**m * Symbol(f"rest_{x}") for x, (_, _, begin) in generators.items() if begin != x}
    series = sum(b.subs(n, j) * sp.diff(g, v, j).subs(v, 0) / sp.factorial(j) * V**j for j in range(1, first + r))
    top, below = (sp.Poly(part, V) for part in sp.fraction(sp.together(y.subs(starts) + series)))
    free = [a for (i,), a in top.terms() if i < first + r + min(below.monoms())[0]]
    assert all(map(vanishes, free)), f"{name}: the first coefficients"
    functions = {x: function for x, (function, _, _) in generators.items()}
    for x, (function, rule, begin) in generators.items():
        near = {a: Rational(3, 2) for a in function.free_symbols} | {V: Rational(1, 10**8)}
        assert same(sp.diff(function, V), rule.subs(functions)), f"{name}: the derivative of {x}"
        assert x not in roots or same(function**2, roots[x].subs(functions)), f"{name}: the square of {x}"
        rest = 0 if begin == x else sp.N((function - begin).subs(near), 15)
        assert abs(rest) < 10 ** (4 - 8 * m), f"{name}: the first terms of {x}"
    return y.subs(functions) / V


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


# -- exponential, harmonic -------------------------------------------------------------------------
V, N, mu_s, mu_m, alpha = sp.symbols("V N mu_s mu_m alpha", positive=True)
v = Symbol("v", nonnegative=True)
mu = mu_m + (mu_s - mu_m) * exp(-alpha * v)
# first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003
s = Symbol("s", real=True)
w = 2 * sqrt(1 - s**2) / pi
c = 2 * N * (mu_s - mu_m) * exp(-V * alpha) * besseli(1, V * alpha) / V

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
g1 = exp(-v)
besseli_1, exp_2, besseli_3 = sp.symbols("besseli_1 exp_2 besseli_3", complex=True)
generators, roots = {}, {}  # of each function of V its derivative, and its first terms at V = 0
generators[besseli_1] = (besseli(1, V), besseli_3 - besseli_1 / V, V**3 / 16 + V / 2)  # DLMF 10.29, 10.25
generators[exp_2] = (exp(-V), -exp_2, V**2 / 2 - V**3 / 6 - V + 1)  # DLMF 4.7, 4.2
generators[besseli_3] = (besseli(0, V), besseli_1, V**2 / 4 + 1)  # DLMF 10.29, 10.25
# 1 has no zero for v > 0; g and y are analytic there
equation = ([1, 1], 0)
q = [2 * n + 1, n**2 + 2 * n]
y = 2 * besseli_1 * exp_2
F1 = by_series("F1", exp(-v), *equation, q, 1, y, generators, roots, 4)
# The law is a sum of a g(v/b), which add N a/b F(V/b) each: the criterion is linear, and scales
law = mu_m + (mu_s - mu_m) * g1.subs({v: v / (1 / alpha)}, simultaneous=True)
assert vanishes(mu - law), "the split of the law into terms"
total = N * ((mu_s - mu_m) / (1 / alpha) * F1.subs({V: V / (1 / alpha)}, simultaneous=True))
assert vanishes(c - total), "the sum of the averages"
# By mpmath, without any of the above
parameters = (V, N, mu_s, mu_m, alpha)
angles = [2 * asin(sqrt(place / (2 * V))) for place in []]
integrand = N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K
compare(c, integrand, theta, pi, angles, parameters)
# As V falls to 0, c tends to -N mu'(0): the weight has unit integral, the slope is continuous
at_rest = N * alpha * (mu_s - mu_m)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
print("proved: exponential, harmonic")

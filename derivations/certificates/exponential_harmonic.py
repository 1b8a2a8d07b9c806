"""The damping coefficient c of exponential, harmonic, proved for all parameters.

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):
c = -N int_-1^1 w(s) mu'(V (1 + s)) ds. SymPy and mpmath suffice; an AssertionError names the step that fails.
"""

import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, besseli, cos, exp, gamma, pi, sin, sqrt


def vanishes(expr):
    """Whether an expression is 0 by algebra: over one denominator, expanded."""
    return sp.expand(sp.powsimp(sp.expand(sp.fraction(sp.together(expr))[0]))) == 0


def at(i, expr, free=None):
    """Return an expression at the i-th of many points: with numbers for its symbols, but for the one left free."""
    numbers = {x: Rational(random.Random(f"{i} {x}").randint(500, 1500), 1000) for x in expr.free_symbols - {free}}
    return sp.N(expr.subs(numbers), 50)


def by_series(name, g, equation, rest, q, count, y, functions, roots, m):
    """Return y/V, proved to be the average of g = sum g_n v^n: that is sum y_n V^(n-1) with y_n = -b_n g_n.

    A differential equation of g is a recurrence of the g_n. So the y_n have one, and y = V F(V) has a differential
    equation. It fixes y_n for n >= count: power series that satisfy it, and agree below V^count, are equal. Both
    sides are analytic for V > 0, where they are equal then too.
    """
    order, gap = len(equation) - 1, sum(a * sp.diff(g, v, i) for i, a in enumerate(equation)) - rest
    assert vanishes(gap), f"{name}: the differential equation of the profile"
    # It takes v^n to sum_k p_k(n) v^(n+k+low-order): sum_k p_k(n - k) g_(n-k) = 0 but for the powers in the rest
    (low,), p = sp.Poly(sum(a * sp.ff(n, i) * v ** (order - i) for i, a in enumerate(equation)), v).terms_gcd()
    # So is sum_k q_k(n - k) y_(n-k), if each q_k(n - k) b_(n-k) is to p_k(n - k) as q_0(n) b_n is to p_0(n)
    for k, q_k in enumerate(q):
        b_k = sp.prod([ratio.subs(n, n + i) for i in range(k)])  # b_(n+k)/b_n
        gap = q_k * p.nth(0).subs(n, n + k) - p.nth(k) * q[0].subs(n, n + k) * b_k
        assert vanishes(gap), f"{name}: the recurrence"
    # It fixes y_n if neither q_0(n) nor what was divided out is 0: factors without a rational zero never are
    leading = sp.Poly(q[0] * sp.fraction(sp.factor(p.nth(0) / q[0]))[0], n).primitive()[1].as_expr()
    fixes = leading.free_symbols <= {n} and all(x.q > 1 or x < count for x in sp.Poly(leading, n).ground_roots())
    assert fixes * count > max(len(q) - 1, p.degree(), order - low + sp.degree(rest, v)), f"{name}: what it fixes"
    # With theta = V d/dV it says that sum_k V^k q_k(theta) y is a polynomial below V^count
    squares, powers = [root**2 - square for root, square in roots.items()], [y]
    rules = [y, *squares, *(rule for _, rule, _ in functions.values())]
    assert all(sp.sympify(rule).is_polynomial(*functions) for rule in rules), f"{name}: what is no polynomial"
    for _ in range(max(sp.degree(q_k, n) for q_k in q)):
        slope = sp.diff(powers[-1], V) + sum(sp.diff(powers[-1], x) * f[1] for x, f in functions.items())
        powers.append(sp.reduced(V * slope, squares, *functions, order="grevlex")[1])
    left = sum(V**k * a * powers[i] for k, q_k in enumerate(q) for (i,), a in sp.Poly(q_k, n).terms())
    left = sp.cancel(sp.reduced(left, squares, *functions, order="grevlex")[1])
    degree = sp.degree(left, V) if left.is_polynomial(V) and not left.has(*functions) else count
    assert degree < count, f"{name}: the operator"
    # With the first terms of the functions, and a symbol times V^m for the rest of each, y begins as it must
    starts = {x: begin + V**m * Symbol(f"rest_{x}") for x, (_, _, begin) in functions.items()}
    series = sum(b.subs(n, j) * sp.diff(g, v, j).subs(v, 0) / sp.factorial(j) * V**j for j in range(1, count))
    top, below = (sp.Poly(part, V) for part in sp.fraction(sp.together(y.subs(starts) + series)))
    assert all(vanishes(a) for (i,), a in top.terms() if i < count + min(below.monoms())[0]), f"{name}: the start"
    meanings = {x: function for x, (function, _, _) in functions.items()}
    for x, (function, rule, begin) in functions.items():
        gaps = [sp.diff(function, V) - sp.sympify(rule).subs(meanings), (x**2 - roots.get(x, x**2)).subs(meanings)]
        assert all(abs(at(0, gap)) < 1e-25 for gap in gaps), f"{name}: the derivative, or the square, of {x}"
        rest = at(0, (function - begin).subs(V, Rational(1, 10**8)))
        assert abs(rest) < 10 ** (4 - 8 * m), f"{name}: the first terms of {x}"
    return y.subs(meanings) / V


def compare(c, integrand, x, end, kinks):
    """Assert that c is the integral over x from 0 to an end, by mpmath, to 30 digits at twelve points."""
    mpmath.mp.dps = 50
    for i in range(12):
        places = [at(i, sp.sympify(place)) for place in (*kinks, *(end * j / 4 for j in range(5)))]
        ends = sorted({mpmath.mpmathify(place) for place in places if place.is_real and 0 <= place <= places[-1]})
        integral = mpmath.quad(sp.lambdify(x, at(i, integrand, x), "mpmath"), ends)
        assert abs(at(i, c) - integral) <= 1e-30 * max(abs(integral), 1e-10), f"the definition at point {i}"


# -- exponential, harmonic -------------------------------------------------------------------------
V, N, n, mu_s, mu_m, alpha = sp.symbols("V N n mu_s mu_m alpha", positive=True)
v = Symbol("v", nonnegative=True)
s, theta = sp.symbols("s theta", real=True)
mu = mu_m + (mu_s - mu_m) * exp(-alpha * v)
# first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003
w = 2 * sqrt(1 - s**2) / pi
c = 2 * N * (mu_s - mu_m) * exp(-V * alpha) * besseli(1, V * alpha) / V
K = 2 * cos(theta) / (pi * V)  # by parts, with v = V (1 - cos(theta)): c = N int_0^pi mu K dtheta
assert abs(at(0, K - sp.diff(w, s).subs(s, -cos(theta)) * sin(theta) / V)) < 1e-25, "the kernel"
# The moments b_n = n <(1 + s)^(n - 1)>, as integrals of powers: DLMF 5.12
b = 2 ** (n + 2) * n * gamma(n + Rational(1, 2)) / (2 * sqrt(pi) * gamma(n + 2))
ratio = (2 * n + 1) * (n + 1) / (n * (n + 2))
assert vanishes(sp.expand_func(b.subs(n, n + 1) / b) - ratio), "the ratio of the moments"
g1 = exp(-v)  # in units of its scale; F1(V) = -<g'(V (1 + s))>
functions, roots = {}, {}  # of V: what each is, its derivative, its first terms at V = 0
besseli_1, exp_V, besseli_0 = sp.symbols("besseli_1 exp_V besseli_0", complex=True)
functions[besseli_1] = (besseli(1, V), besseli_0 - besseli_1 / V, V**3 / 16 + V / 2)  # DLMF 10.29, 10.25
functions[exp_V] = (exp(-V), -exp_V, V**2 / 2 - V**3 / 6 - V + 1)  # DLMF 4.7, 4.2
functions[besseli_0] = (besseli(0, V), besseli_1, V**2 / 4 + 1)  # DLMF 10.29, 10.25
equation = ([1, 1], 0)
q = [n**2 - 1, 2 * n + 1]
y = 2 * besseli_1 * exp_V
F1 = by_series("F1", g1, *equation, q, 2, y, functions, roots, 4)
# The law is a sum of terms a g(v/b), which add N a/b F(V/b) each: criteria are linear, and scale
law = mu_m + (mu_s - mu_m) * g1.subs(v, alpha * v)
assert vanishes(mu - law), "the split of the law into terms"
total = N * (alpha * (mu_s - mu_m) * F1.subs(V, V * alpha))
assert vanishes(c - total), "the sum of the averages"
compare(c, N * mu.subs(v, 2 * V * sin(theta / 2) ** 2) * K, theta, pi, [])
at_rest = N * alpha * (mu_s - mu_m)  # as V and all slip speeds fall to 0, c tends to -N mu'(0)
assert vanishes(at_rest + N * sp.diff(mu, v).subs(v, 0)), "the limit for low belt speeds"
far = 0  # as V grows, and slow slip loses its weight, c tends to -N mu', compared at one v
assert abs(far + at(0, N * sp.diff(mu, v).subs(v, 10**200))) < 1e-25, "the limit for high belt speeds"
print("proved: exponential, harmonic")

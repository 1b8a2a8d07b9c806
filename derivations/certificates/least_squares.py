"""A proof, step by step: The least-squares fit for any mu: (12) to (16).

Nothing but SymPy 1.13 or later is needed. NotProved names the step that fails, under python -O too.
"""

import sympy as sp
from sympy import Integral, Symbol


class NotProved(Exception):
    """A step that fails."""


def check(condition, message):
    """Raise, under python -O too, unless a condition is known to hold."""
    if condition is None or not bool(condition):
        raise NotProved(message)


def split(f, limits):
    """Return an integral as a sum of constants times integrals, those of polynomials done."""
    total, (x, *_) = 0, limits
    for term in sp.Add.make_args(sp.expand(f)):
        constant, rest = term.as_independent(x, as_Add=False)
        total += constant * (sp.integrate if rest.is_polynomial(x) else sp.Integral)(rest, limits)
    return total


def vanishes(expr):
    """Whether an expression is 0: its integrals split, over one denominator, expanded."""
    expr = sp.sympify(expr).replace(sp.Integral, split)
    return sp.expand(sp.fraction(sp.together(expr))[0]) == 0


N, V = sp.symbols("N V", positive=True)
a, b, xdot = sp.symbols("a b xdot", real=True)
u = Symbol("u", nonnegative=True)
mu = sp.Function("mu", real=True)  # any function

# 1. substitute x' = V - u in (12): u = |v_r| = V - x' runs from 2V to 0 as x' runs from -V to V, and dx' = -du
left = Integral(xdot**2 * (a * (V - xdot) - b + mu(V - xdot)) ** 2, (xdot, -V, V))
left = left.transform(xdot, (V - u, u))  # xdot = V - u
right_1 = Integral((V - u) ** 2 * (a * u - b + mu(u)) ** 2, (u, 0, 2 * V))
check(vanishes(left - right_1), "step 1 (13)")

# 2. differentiate under the integral with respect to a: the integrand is a polynomial in a and b, and the limits
# do not depend on them
left = Integral(2 * u * (V - u) ** 2 * (a * u - b + mu(u)), (u, 0, 2 * V))
right_2 = 32 * a * V**5 / 15 - 4 * b * V**4 / 3 + 2 * Integral(u * (V - u) ** 2 * mu(u), (u, 0, 2 * V))
check(vanishes(left - right_2), "step 2 (14) a")

# 3. and with respect to b: likewise
left = Integral((V - u) ** 2 * (2 * b - 2 * a * u - 2 * mu(u)), (u, 0, 2 * V))
right_3 = 4 * b * V**3 / 3 - 4 * a * V**4 / 3 - 2 * Integral((V - u) ** 2 * mu(u), (u, 0, 2 * V))
check(vanishes(left - right_3), "step 3 (14) b")

# 4. solve both equations for a: they are linear in a and b
left = a
(solution,) = sp.linsolve([right_2, right_3], [a, b])
left = left.subs(dict(zip([a, b], solution, strict=True)), simultaneous=True)
right_4 = 5 * Integral((V - u) ** 3 * mu(u), (u, 0, 2 * V)) / (2 * V**5)
check(vanishes(left - right_4), "step 4 (15) a")

# 5. and for b: likewise
left = b
left = left.subs(dict(zip([a, b], solution, strict=True)), simultaneous=True)
right_5 = Integral((8 * V - 5 * u) * (V - u) ** 2 * mu(u), (u, 0, 2 * V)) / (2 * V**4)
check(vanishes(left - right_5), "step 5 (15) b")

# 6. the solution is a minimum: the first principal minor of the Hessian: S is a quadratic in a and b whose Hessian
# does not depend on mu
left = sp.diff(right_2, a)
check(sp.factor(left).is_positive, "step 6")

# 7. and the determinant of the Hessian: both minors positive: positive definite, and unique
left = sp.diff(right_3, b) * sp.diff(right_2, a) - sp.diff(right_3, a) * sp.diff(right_2, b)
check(sp.factor(left).is_positive, "step 7")

# 8. put a into (11), c = a N: the pure-slip condition
left = a * N
left = left.subs(dict(zip([a, b], solution, strict=True)), simultaneous=True)
right_8 = 5 * N * Integral((V - u) ** 3 * mu(u), (u, 0, 2 * V)) / (2 * V**5)
check(vanishes(left - right_8), "step 8 (16)")

print("proved: The least-squares fit for any mu: (12) to (16)")

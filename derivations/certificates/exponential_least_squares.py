"""The damping coefficient c of exponential, least_squares: a statement, data, and a checker that [...]

A mass is pressed by the force N on a belt of speed V; mu(v) is the coefficient of friction at the slip speed v. A
criterion averages the falling slope over the slip speeds V (1 + s) from 0 to 2 V with a weight w(s):

    c = -N int_-1^1 w(s) mu'(V (1 + s)) ds.

Where mu jumps, its slope mu' holds the jump times a delta function. Run this page: it prints what it proved, or an
error, mostly NotProved, says which step fails.
It needs nothing but Python 3.11, SymPy 1.13 and its mpmath 1.3, or later ones.
"""

import itertools
import random

import mpmath
import sympy as sp
from sympy import Rational, Symbol, exp

claims = []

# == STATEMENT: exponential, least_squares =========================================================

V, N, mu_s, mu_m, alpha = sp.symbols("V N mu_s mu_m alpha", positive=True)
v = Symbol("v", nonnegative=True)
s = Symbol("s", real=True)
mu = mu_m + (mu_s - mu_m) * exp(-alpha * v)
# Won & Chung 2016, eq. (16), integrated by parts
w = Rational(5, 8) - 5 * s**4 / 8
c = 5 * N * (mu_s - mu_m) * (V**3 * alpha**3 - 3 * V**2 * alpha**2 + 6 * V * alpha + (V**3 * alpha**3 + 3 * V**2 * alpha**2 + 6 * V * alpha + 6) * exp(-2 * V * alpha) - 6) / (2 * V**5 * alpha**4)  # fmt: skip  # noqa: E501

# == DATA: supplied by a generator; CHECKER trusts no line of it ===================================

g1 = exp(-v)
A1_0 = 5 * (v - V) ** 3 * exp(-v) / (2 * V**5) + 15 * (v - V) ** 2 * exp(-v) / (2 * V**5) + 15 * (v - V) * exp(-v) / V**5 + 15 * exp(-v) / V**5  # fmt: skip  # noqa: E501
parts1 = [("antiderivatives", g1, [A1_0])]
# mu is the sum of a g(v/b): a, b, values of the shapes of g, g, and the parts of its average
terms = [
    (mu_m, sp.Integer(1), {}, sp.Integer(1), []),
    (mu_s - mu_m, 1 / alpha, {}, g1, parts1),
]
claims.append((mu, w, c, terms, None))


# == CHECKER: the same text on every page. It takes STATEMENT at its word, and no line of DATA ==================


class NotProved(Exception):
    """A step that fails, or a hypothesis that is not known to hold."""


def check(condition, message):
    """Raise, with `python -O` too, unless a condition is known to hold."""
    if condition is None or not bool(condition):
        raise NotProved(message)


# -- Where formulas are continuous, or analytic ---------------------------------------------------------------

V, N, v, s = (sp.Symbol(name, **{kind: True}) for name, kind in
              (("V", "positive"), ("N", "positive"), ("v", "nonnegative"), ("s", "real")))  # fmt: skip


EVERYWHERE = {"exp", "sin", "cos", "sinh", "cosh", "erf", "erfc", "erfi", "Si", "im", "re"}  # DLMF 4, 6.2, 7.2
"""Functions that are analytic at every argument; `im` and `re` of what is analytic in a real variable."""
ON_THE_REALS = {"tanh", "sech", "atan", "asinh"}  # 4.28, 4.23, 4.37
"""Functions that are analytic at every real argument."""
WHERE_POSITIVE = {
    "log": lambda z: [z], "coth": lambda z: [z], "csch": lambda z: [z],  # 4.2, 4.28
    "asin": lambda z: [1 - z, 1 + z], "acos": lambda z: [1 - z, 1 + z],  # 4.23
    "atanh": lambda z: [1 - z, 1 + z], "acosh": lambda z: [z - 1],  # 4.37
    "lowergamma": lambda a, z: [a, z], "expint": lambda n, z: [z], "Ei": lambda z: [z],  # 8.2, 8.19, 6.2
    "polylog": lambda n, z: [] if (z / sp.I).is_real else [1 - z],  # 25.12: off the cut from 1 on
    "lerchphi": lambda z, n, a: [1 - z, a],  # 25.14
    "besseli": lambda n, z: [], "besselj": lambda n, z: [],  # 10.25, 10.2: entire at whole orders
    "elliptic_k": lambda m: [1 - m], "elliptic_e": lambda m: [1 - m],  # 19.2
    "elliptic_pi": lambda n, m: [1 - n, 1 - m],
    "hyper": lambda a, b, z: [1 - z] if len(a) > len(b) else [],  # 16.2
}  # fmt: skip
"""What must be positive for other functions to be analytic. The numbers are sections of the Digital Library of
Mathematical Functions. SymPy's derivatives are taken for these functions, and for no other."""
CONSTANT = {"gamma", "zeta", "dirichlet_eta", "Min", "Max"}
"""Functions that may be applied to what does not vary."""
KNOWN = {*EVERYWHERE, *ON_THE_REALS, *WHERE_POSITIVE, *CONSTANT}


def needed(f, analytic):
    """Return what must be positive for a function to be analytic, or continuous; None where that is not known."""
    name, arguments = ("exp", [f.exp]) if f.is_Pow else (f.func.__name__, f.args)
    if name in EVERYWHERE:
        return []
    if name in ON_THE_REALS:
        return [] if arguments[0].is_real else None
    if name not in WHERE_POSITIVE or (name.startswith("bessel") and not arguments[0].is_Integer):
        return None
    if name == "hyper" and not (len(f.args[0]) <= len(f.args[1]) + 1 and all(b.is_positive for b in f.args[1])):
        return None
    if not analytic and name == "lowergamma" and arguments[1].is_nonnegative:
        return arguments[:1]  # like z^a at 0
    if not analytic and name == "polylog" and arguments[0] in (2, 3, 4, 5) and is_decay(arguments[1]):
        return []  # its series converges at 1
    return WHERE_POSITIVE[name](*arguments)


def is_decay(z):
    """Whether an expression is exp(-y), y >= 0."""
    return isinstance(z, sp.exp) and z.args[0].is_nonpositive


def positive(e, x):
    """Whether an expression is known to be positive for all x > 0 and all parameters."""
    if e.is_positive:
        return True
    if e.is_Mul or e.is_Pow:
        powers = [factor.as_base_exp() for factor in sp.Mul.make_args(e)]
        return all(exponent.is_real and positive(base, x) for base, exponent in powers)
    if e.is_polynomial(x) and sp.degree(e, x) == 2:
        a, b, c = sp.Poly(e, x).all_coeffs()
        if b.is_real and a.is_positive and sp.factor(4 * a * c - b**2).is_positive:
            return True
    if e.is_polynomial(x) and all(a.is_Rational for a in sp.Poly(e, x).all_coeffs()):
        return bool(sp.Poly(e, x).count_roots(0, sp.oo) == 0 and e.subs(x, 1).is_positive)
    if e.is_Add and all(positive(term, x) for term in e.args):
        return True
    if e.is_Add and e.args[0] == 1 and isinstance(1 - e, sp.exp) and (1 - e).args[0].is_negative:
        return True
    return positive_root(sp.expand(e), x)


def positive_root(e, x):
    """Whether c sqrt(R) + L is: c > 0, and L > 0 or c^2 R > L^2; at double zeros of this, L > 0."""
    roots = [node for node in e.atoms(sp.Pow) if node.exp == sp.Rational(1, 2) and node.has(x)]
    if len(roots) != 1 or not e.is_Add or not x.is_positive:
        return False
    c, rest = e.coeff(roots[0]), e.coeff(roots[0], 0)
    if not (c.is_positive and rest.is_real) or rest.has(roots[0]) or sp.expand(e - c * roots[0] - rest) != 0:
        return False
    above = sp.expand(c**2 * roots[0].base - rest**2)
    if positive(rest, x) or not above.is_polynomial(x):
        return positive(rest, x) and (positive(roots[0].base, x) or bool(roots[0].base.is_nonnegative))
    constant, factors = sp.factor_list(above, x)
    if not sp.sympify(constant).is_positive:
        return False
    for factor, power in factors:
        if not positive(factor, x):
            zeros = sp.roots(factor, x)
            whole = power % 2 == 0 and sum(zeros.values()) == sp.degree(factor, x)
            if not whole or not all(z.is_nonpositive or rest.subs(x, z).is_positive for z in zeros):
                return False
    return True


def regular(e, x, analytic=False, poles=False):
    """Whether an expression is known to be continuous for all x that its assumptions allow, or analytic there.

    With `poles` those of the whole expression do not matter: what equals a function without poles has none.
    """
    if not e.has(x) or e == x:
        return True
    arguments = [a for a in e.args if not isinstance(a, sp.Tuple)]
    if e.is_Add or e.is_Mul:
        return all(regular(a, x, analytic, poles) for a in arguments)
    if e.is_Pow and e.base != sp.E:
        whole = e.exp.is_Integer and (e.exp > 0 or poles)
        from_zero = not analytic and e.base.is_nonnegative and e.exp.is_positive and not e.exp.has(x)
        nonzero = positive(e.base, x) or positive(sp.factor(e.base), x)
        nonzero = nonzero or (e.exp.is_Integer and (positive(-e.base, x) or positive(sp.factor(-e.base), x)))
        if not (whole or from_zero or nonzero):
            return False
        return all(regular(a, x, analytic, poles and bool(e.exp.is_Integer)) for a in arguments)
    conditions = needed(e, analytic)
    if conditions is None or not all(positive(p, x) or positive(sp.factor(p), x) for p in conditions):
        return False
    return all(regular(a, x, analytic) for a in arguments)


def known(e):
    """Refuse inexact numbers, infinity, functions outside the table, and classes that are not SymPy's."""
    e = sp.sympify(e)
    modules = {str(type(node).__module__).partition(".")[0] for node in sp.preorder_traversal(e)}
    check(modules == {"sympy"}, "a class that is not SymPy's")
    check(not e.has(sp.Float, sp.oo, -sp.oo, sp.zoo, sp.nan, sp.Wild, sp.Integral, sp.Derivative, sp.Subs), f"{e}")
    functions = {node.func for node in e.atoms(sp.Function)}
    check(all(f is getattr(sp, f.__name__, None) for f in functions), "a function that is not SymPy's")
    names = {f.__name__ for f in functions} - {"Piecewise"}
    check(names <= KNOWN, f"no rule is known here for {', '.join(sorted(names - KNOWN))}")
    return e


# -- Whether formulas are equal -------------------------------------------------------------------------------


def in_units(kind, *values):
    """Return the least or the largest of some values in terms of one of them, which is positive, as a unit."""
    unit = min(values, key=lambda x: (not x.has(V), str(x)))
    return unit * kind(*(sp.cancel(x / unit) for x in values)) if unit.is_positive else kind(*values)


def logarithm(z):
    """Return the logarithm of a quotient of what is positive as a difference."""
    above, below = sp.fraction(sp.together(z))
    return sp.log(above) - sp.log(below) if positive(above, V) and positive(below, V) else sp.log(z)


def first_order(node):
    """Return Li_1(z) = -log(1 - z), Li_0(z) = z/(1 - z) and Im Li_1(i y) = atan(y): DLMF 25.12, 4.23."""
    z = node.args[0] if isinstance(node, sp.im) else node
    if isinstance(node, sp.im):
        y = z.args[1] / sp.I
        return sp.atan(y) if z.args[0] == 1 and y.is_real else node
    return {1: -sp.log(1 - z.args[1]), 0: z.args[1] / (1 - z.args[1])}.get(z.args[0], node)


def without_number(node):
    """Write (1 + V)^(d - 1) as (1 + V)^d/(1 + V), with a symbol for (1 + V)^d."""
    number, rest = node.exp.as_coeff_Add()
    base = sp.factor(node.base)
    return base**number * sp.Symbol(sp.srepr(base**rest)) if base.is_Add else base**node.exp


def vanishes(e, signs=()):
    """Whether an expression without pieces is 0: by algebra, or by algebra whichever letters are the larger ones.

    `signs` are expressions that are not negative.
    """
    e = sp.sympify(e)
    check(not e.has(sp.Piecewise), "a function in pieces where there should be none")
    return vanishes_by_algebra(e) or (e.has(sp.Min, sp.Max) and all(map(vanishes_by_algebra, in_orders(e, signs))))


def in_orders(e, signs):
    """Yield an expression without least and largest values, for each order of what they are of."""
    nodes = [node for node in e.atoms(sp.Min, sp.Max) if not any(a.has(sp.Min, sp.Max) for a in node.args)]
    if not nodes:
        yield e
        return
    node = min(nodes, key=str)
    first, second, *others = node.args
    orders = [(second - first, first, second), (first - second, second, first)]  # what is not negative, less, more
    for gap, less, more in [order for order in orders if not_negative(order[0], signs)][:1] or orders:
        chosen = node.func(less if isinstance(node, sp.Min) else more, *others)
        yield from in_orders(e.xreplace({node: chosen}), [*signs, gap])


def not_negative(e, signs):
    """Whether an expression is known not to be negative: as it is, or as it is no less than a sum of `signs`."""
    e, *signs = (without_positive_factors(gap) for gap in (e, *signs))
    sums = [sum(some) for count in range(4) for some in itertools.combinations(signs, count)]
    return any(sp.expand(e - total).is_nonnegative for total in sums)


def without_positive_factors(e):
    """Return an expression of the same sign."""
    return sp.Mul(*[factor for factor in sp.Mul.make_args(sp.factor(e)) if not factor.is_positive])


def vanishes_by_algebra(e):
    """Whether an expression is 0 over one denominator, expanded."""
    if e == 0:
        return True
    e = e.replace(sp.Min, lambda *x: in_units(sp.Min, *x)).replace(sp.Max, lambda *x: in_units(sp.Max, *x))
    e = e.replace(lambda node: isinstance(node, sp.im) and isinstance(node.args[0], sp.polylog), first_order)
    e = e.replace(lambda node: isinstance(node, sp.polylog), first_order)
    e = e.replace(sp.lerchphi, lambda z, k, a: 1 / (1 - z) if k == 0 else sp.lerchphi(z, k, a))
    e = e.replace(sp.dirichlet_eta, lambda k: (1 - 2 ** (1 - k)) * sp.zeta(k) if k != 1 else sp.log(2))
    e = e.replace(sp.acos, lambda x: sp.acos(sp.factor(x))).replace(sp.log, logarithm)
    e = e.replace(sp.Pow, lambda x, p: sp.factor(x) ** p if p.is_Rational and x.is_Add else x**p)
    e = e.rewrite((sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.coth, sp.csch), sp.exp)
    e = e.replace(lambda node: node.is_Pow and node.base.is_Add and not node.exp.is_Rational, without_number)
    top = sp.expand(sp.fraction(sp.together(e))[0])
    return top == 0 or sp.expand(sp.powsimp(top)) == 0


def place_of(condition, x, strict=True):
    """Return the place of the condition x < place, or x <= place where it need not be strict; refuse any other.

    SymPy joins x < p and x < q by Or, where both pieces are one.
    """
    if isinstance(condition, sp.Or):
        return sp.Max(*[place_of(part, x, strict) for part in condition.args])
    less = isinstance(condition, sp.StrictLessThan | sp.StrictGreaterThan)
    check(
        less or (not strict and isinstance(condition, sp.LessThan | sp.GreaterThan)),
        f"{condition} is no {x} < place",
    )
    check(condition.lts == x or condition.gts == -x, f"{condition} is no {x} < place")
    place = condition.gts if condition.lts == x else -condition.lts
    check(not place.has(v, V), f"{condition} is no {x} < place")
    return place


def conditions_in(e):
    """Return all conditions of the functions in pieces in an expression, but that which always holds."""
    nodes = e.atoms(sp.Piecewise)
    check(all(node.args[-1].cond is sp.true for node in nodes), "pieces that end")
    return {holds for node in nodes for _, holds in node.args if holds is not sp.true}


def agree(e, x=v, at=None, below=()):
    """Whether an expression in pieces of x is 0 but at the places, whatever their order; or at one value of x.

    `below` are places with whether x is below them.
    """
    conditions, below = conditions_in(e), dict(below)
    truth = {holds: is_below(place_of(holds, x), below) for holds in conditions}
    decided = {holds: sp.sympify(known) for holds, known in truth.items() if known is not None}
    if decided:
        return agree(e.xreplace(decided), x, at, below)
    if not conditions:
        signs = [place - x if is_less else x - place for place, is_less in below.items()]
        if at is None:
            return vanishes(e, signs)
        return vanishes(e) or vanishes(e.subs(x, at), [gap.subs(x, at) for gap in signs])
    places = {part for holds in conditions for part in parts_of(place_of(holds, x))}
    first = min(places - below.keys(), key=str)
    left = {p: True for p in places if sp.cancel(p - first).is_nonnegative}
    right = {p: False for p in places if sp.cancel(first - p).is_nonnegative}
    return agree(e, x, at, {**below, **left}) and agree(e, x, at, {**below, **right})


def parts_of(place):
    """Return the places of which a place is the least or the largest."""
    if isinstance(place, sp.Min | sp.Max):
        return [part for argument in place.args for part in parts_of(argument)]
    return [place]


def is_below(place, below):
    """Return whether x is below a place, by whether it is below others; None where that is not decided."""
    if not isinstance(place, sp.Min | sp.Max):
        return below.get(place)
    values, decisive = [is_below(part, below) for part in place.args], isinstance(place, sp.Max)
    if decisive in values:
        return decisive
    return None if None in values else not decisive


def pieces_of(g):
    """Return the pieces of a function of v, and the places between them, each at least the one before."""
    if not isinstance(g, sp.Piecewise):
        check(not g.has(sp.Piecewise), "pieces within a formula")
        return [g], []
    check(g.args[-1].cond is sp.true, "the last piece ends")
    places = []
    for piece, holds in g.args:
        check(not piece.has(sp.Piecewise), "pieces within pieces")
        if holds is not sp.true:
            place = place_of(holds, v)
            before = places[-1] if places else sp.Integer(0)
            places.append(place if (place - before).is_nonnegative else sp.Max(before, place))
    return [piece for piece, _ in g.args], places


# -- Averages by antiderivatives ------------------------------------------------------------------------------


def at_rest(A):
    """Return the limit of a function as v falls to 0."""
    if regular(A, v):
        return sp.sympify(A).subs(v, 0)
    return sum(limit_of_term(term) for term in sp.Add.make_args(sp.expand(A)))


def limit_of_term(term):
    """Return the limit of a product: v^p log(v)^n vanishes for p > 0, and exp(-a/v), E_1(a/v) outweigh powers."""
    decays = [f for f in sp.Mul.make_args(term) if decays_at_rest(f)]
    if decays:
        others = [f for f in sp.Mul.make_args(term) if f.has(v) and f not in decays]
        check(all(f.as_base_exp()[0] == v for f in others), f"the limit of {term}")
        return sp.Integer(0)
    term = term.replace(sp.erf, lambda z: sp.Integer(-1) if falls_at_rest(z) else sp.erf(z))
    # log((1 - exp(-a v))/(b v)), of the quotient's limit a/b
    term = term.replace(sp.log, lambda z: sp.log(quotient_at_rest(z)) if z.subs(v, 0) is sp.nan else sp.log(z))
    bases = [f.as_base_exp() for f in sp.Mul.make_args(term)]
    logs = [b**n for b, n in bases if isinstance(b, sp.log) and b.args[0].subs(v, 0) == 0]
    check(all(f.as_base_exp()[1].is_Integer and f.as_base_exp()[1] > 0 for f in logs), f"the limit of {term}")
    rest = sp.Mul(*[b**n for b, n in bases if b**n not in logs])
    if not logs:
        check(regular(rest, v), f"the limit of {term}")
        return rest.subs(v, 0)
    power = rest.as_powers_dict()[v]
    check(power.is_positive and not power.has(v) and regular(rest / v**power, v), f"the limit of {term}")
    fronts = [f.as_base_exp()[0].args[0] / v for f in logs]
    check(all(front.is_positive and regular(front, v) for front in fronts), f"the limit of {term}")
    return sp.Integer(0)


def decays_at_rest(f):
    """Whether a factor is exp(-a/v + b) or E_1(a/v), a > 0."""
    if isinstance(f, sp.exp):
        rate = -sp.expand(f.exp).coeff(v, -1)
        return rate.is_positive and not (rate.has(v) or sp.expand(f.exp + rate / v).has(v))
    return (
        isinstance(f, sp.expint) and f.args[0] == 1 and (f.args[1] * v).is_positive and not (f.args[1] * v).has(v)
    )


def falls_at_rest(z):
    """Whether an expression is a log(v) + b, a > 0."""
    rate, rest = sp.expand(z).coeff(sp.log(v)), sp.expand(z).coeff(sp.log(v), 0)
    return rate.is_positive and not rest.has(v)


def quotient_at_rest(z):
    """Return the limit of a quotient of two functions that vanish at 0, by their slopes there."""
    above, below = sp.fraction(sp.together(z))
    check(regular(above, v, True) and regular(below, v, True), f"the limit of {z}")
    value = (sp.diff(above, v) / sp.diff(below, v)).subs(v, 0)
    check(vanishes(above.subs(v, 0)) and vanishes(below.subs(v, 0)) and value.is_positive, f"the limit of {z}")
    return value


def by_antiderivatives(g, K, antiderivatives):
    """Return the integral of g K over v from 0 to 2 V, by the fundamental theorem on each piece of g.

    Piece i of g holds for places[i-1] <= v < places[i]: from the Piecewise itself. On each interval the
    antiderivative is continuous, by the walk of `regular`, and has the derivative g K inside.
    """
    pieces, places = pieces_of(g)
    check(len(pieces) == len(antiderivatives), "one antiderivative for each piece")
    ends = [sp.Integer(0), *[sp.Min(place, 2 * V) for place in places], 2 * V]
    total, x = 0, sp.Symbol("x", positive=True)
    for piece, A, low, high in zip(pieces, antiderivatives, ends, ends[1:], strict=False):
        A = known(A)
        check(A.free_symbols <= {v, V} | g.free_symbols, "a symbol that the profile has not")
        check(
            agree((derivative(A, v) - piece * K).subs(v, x), x),
            f"the derivative of {A} is not {piece} times the kernel",
        )
        check(regular(A.subs(v, x), x), f"{A} is not known to be continuous between {low} and {high}")
        check(low == 0 or low.is_positive or regular(A, v), f"{A} is not known to be continuous at v = {low}")
        total += A.subs(v, high) - (at_rest(A) if low == 0 else A.subs(v, low))
    return total


# -- Averages by power series ---------------------------------------------------------------------------------


def outer_slopes(f):
    """Return an expression's derivatives by its arguments, closed: DLMF 10.29, 10.6, 15.5, 16.3, 19.4."""
    if isinstance(f, sp.besseli | sp.besselj) and f.args[0] in (0, 1):
        n, z = f.args
        sign = 1 if isinstance(f, sp.besseli) else -1
        return [(z, f.func(0, z) - f / z if n == 1 else sign * f.func(1, z))]
    if isinstance(f, sp.hyper):
        upper, lower, z = list(f.args[0]), list(f.args[1]), f.args[2]
        raised = [a for a in upper if a + 1 in lower]
        if raised:  # (z d/dz + a) F(a, ..; a + 1, ..; z) = a F(..; ..; z)
            upper.remove(raised[0])
            lower.remove(raised[0] + 1)
            less = (1 - z) ** -upper[0] if len(upper) == 1 and not lower else sp.hyper(upper, lower, z)
            return [(z, raised[0] * (less - f) / z)]
        return [(z, f.fdiff(3))]
    return [(argument, f.fdiff(i)) for i, argument in enumerate(f.args, 1) if argument.free_symbols]


def derivative(e, x):
    """Return a derivative: that of elementary functions is SymPy's."""
    closed = [f for f in e.atoms(sp.besseli, sp.besselj, sp.hyper) if f.has(x)]
    if not closed:
        return sp.diff(e, x)
    names = {f: sp.Dummy() for f in closed}
    inside = e.xreplace(names)
    total = sp.diff(inside, x)
    for f, name in names.items():
        total += sp.diff(inside, name) * sum(slope * derivative(z, x) for z, slope in outer_slopes(f) if z.has(x))
    return total.xreplace({name: f for f, name in names.items()})


def truncated(e, m):
    """Return a polynomial in V without the powers from V^m on."""
    return sum(a * V**i for (i,), a in sp.Poly(sp.expand(e), V).terms() if i < m)


def first_terms(e, m):
    """Return the Taylor polynomial at V = 0 below V^m, by the series of DLMF 10.25, 10.2, 16.2, 19.5."""
    if not e.has(V) or e == V:
        return e
    if e.is_Add:
        return sp.Add(*[first_terms(a, m) for a in e.args])
    if e.is_Mul and not e.is_rational_function(V):
        total = sp.Integer(1)
        for a in e.args:
            total = truncated(total * first_terms(a, m), m)
        return total
    half = sp.Rational(1, 2)
    if isinstance(e, sp.besseli | sp.besselj):
        n, z = e.args
        sign = 1 if isinstance(e, sp.besseli) else -1
        return truncated(
            (first_terms(z, m) / 2) ** n * series([], [n + 1], sign * z**2 / 4, m) / sp.factorial(n), m
        )
    if isinstance(e, sp.hyper):
        return series(*e.args, m)
    if isinstance(e, sp.elliptic_k | sp.elliptic_e):
        return sp.pi / 2 * series([half if isinstance(e, sp.elliptic_k) else -half, half], [1], e.args[0], m)
    if isinstance(e, sp.elliptic_pi):
        n, z = first_terms(e.args[0], m), e.args[1]
        check(n.subs(V, 0) == 0, f"the series of {e}")
        total = 0
        for k in range(m):
            front = sp.rf(half, k) / sp.factorial(k)
            total += truncated(front * n**k * series([half, half + k], [k + 1], z, m), m)
        return sp.pi / 2 * total
    x = sp.Symbol("x", nonnegative=True)
    check(regular(e.subs(V, x), x, analytic=True), f"{e} is not known to be analytic at V = 0")
    slopes = [e]
    for _ in range(m - 1):
        slopes.append(sp.diff(slopes[-1], V))
    check(not any(slope.subs(V, 0).has(sp.nan, sp.zoo, sp.oo) for slope in slopes), f"{e} at V = 0")
    return sum(slope.subs(V, 0) * V**i / sp.factorial(i) for i, slope in enumerate(slopes))


def series(upper, lower, z, m):
    """Return the first terms of the hypergeometric series of z, which vanishes at V = 0."""
    z = first_terms(z, m)
    check(sp.sympify(z).subs(V, 0) == 0, "a series at another place than 0")
    total, term = sp.Integer(1), sp.Integer(1)
    for k in range(1, m):
        term = truncated(term * z, m)
        front = sp.prod([sp.rf(a, k) for a in upper]) / sp.prod([sp.rf(b, k) for b in lower]) / sp.factorial(k)
        total += front * term
    return sp.expand(total)


def by_series(g, w, equation, rest, q, count, y, functions, roots):
    """Return y/V, proved to be the average of g = sum g_n v^n: that is sum y_n V^(n-1) with y_n = -b_n g_n.

    A differential equation of g is a recurrence of the g_n. So the y_n have one, and y = V F(V) has a differential
    equation. It fixes y_n for n >= count: power series that satisfy it, and agree below V^count, are equal. Both
    sides are analytic for V > 0, where they are equal then too.
    """
    b, ratio = moments(w)
    check(isinstance(count, int), "a number of terms that is none")
    check(not any(sp.sympify(a).has(V, n) for a in (*equation, rest)), "an equation in other symbols than v")
    check(not any(sp.sympify(a).has(V, v) for a in q), "an operator in other symbols than n")
    check(regular(g, v, analytic=True), f"{g} is not known to be analytic for v >= 0")
    gap = sum(a * derivative_of_order(g, i) for i, a in enumerate(equation)) - rest
    check(vanishes(gap), "the differential equation of the profile")
    # It takes v^n to sum_k p_k(n) v^(n+k+low-order): sum_k p_k(n - k) g_(n-k) = 0 but for the powers in the rest
    order = len(equation) - 1
    (low,), p = sp.Poly(sum(a * sp.ff(n, i) * v ** (order - i) for i, a in enumerate(equation)), v).terms_gcd()
    # So is sum_k q_k(n - k) y_(n-k), if each q_k(n - k) b_(n-k) is to p_k(n - k) as q_0(n) b_n is to p_0(n)
    for k, q_k in enumerate(q):
        b_k = sp.prod([ratio.subs(n, n + i) for i in range(k)])  # b_(n+k)/b_n
        gap = q_k * p.nth(0).subs(n, n + k) - p.nth(k) * q[0].subs(n, n + k) * b_k
        check(vanishes(gap), "the recurrence")
    check(p.degree() <= len(q) - 1, "the recurrence ends too early")
    # It fixes y_n if neither q_0(n) nor what was divided out is 0: factors without a rational zero never are
    divided = sp.fraction(sp.factor(p.nth(0) / q[0]))[0]
    content, leading = sp.Poly(q[0] * divided, n).primitive()
    leading = sp.Poly(leading.as_expr(), n)
    fixes = leading.free_symbols <= {n} and all(x.q > 1 or x < count for x in leading.ground_roots())
    check(fixes and sp.sympify(content) != 0, "what the recurrence fixes")
    check(count > max(len(q) - 1, order - low + sp.degree(rest, v)), "how many terms the recurrence does not fix")
    meanings = meanings_of(functions, roots)
    # With theta = V d/dV it says that sum_k V^k q_k(theta) y is a polynomial below V^count
    squares, powers = [root**2 - square for root, square in roots.items()], [sp.sympify(y)]
    for rule in (y, *squares, *(slope for _, slope in functions.values())):
        check(sp.sympify(rule).is_polynomial(*functions), "a rule is no polynomial in the functions")
    for _ in range(max(sp.degree(q_k, n) for q_k in q)):
        slope = sp.diff(powers[-1], V) + sum(sp.diff(powers[-1], x) * f[1] for x, f in functions.items())
        powers.append(sp.reduced(V * slope, squares, *functions, order="grevlex")[1] if functions else V * slope)
    left = sum(V**k * a * powers[i] for k, q_k in enumerate(q) for (i,), a in sp.Poly(q_k, n).terms())
    left = sp.cancel(sp.reduced(left, squares, *functions, order="grevlex")[1] if functions else left)
    check(left.is_polynomial(V) and not left.has(*functions) and sp.degree(left, V) < count, "the operator")
    # With the first terms of the functions, and a symbol times V^m for the rest of each, y begins as it must
    pole = min(sp.Poly(sp.fraction(sp.together(y))[1], V).monoms())[0]
    m = count + pole + 1
    starts = {x: beginning(f[0], functions, m) + V**m * sp.Dummy() for x, f in functions.items()}
    begin = sum(
        b.subs(n, j) * derivative_of_order(g, j).subs(v, 0) / sp.factorial(j) * V**j for j in range(1, count)
    )
    top, below = (sp.Poly(part, V) for part in sp.fraction(sp.together(y.subs(starts) + begin)))
    first = count + min(below.monoms())[0]
    check(all(vanishes(a) for (i,), a in top.terms() if i < first), "the first terms of the average")
    F, x = y.subs(meanings) / V, sp.Symbol("x", positive=True)
    check(regular(F.subs(V, x), x, analytic=True, poles=True), f"{F} is not known to be analytic for V > 0")
    return F


def derivative_of_order(g, i):
    """Return the i-th derivative of a profile."""
    return sp.diff(g, v, i) if i else g


def meanings_of(functions, roots):
    """Return what each function of V is, once its slope, and its square, are those that the data state.

    (F, k) means (z d/dz)^k F of a hypergeometric function F of z, a power of V: DLMF 16.3.
    """
    check(all(x == sp.Symbol(x.name) for x in functions), "a name of a function that means something else")
    check(roots.keys() <= functions.keys(), "a root that is no function")
    meanings = {x: known(f) for x, (f, _) in functions.items() if not isinstance(f, tuple)}
    for x, (f, _) in functions.items():
        if isinstance(f, tuple):
            F, k = f
            check(isinstance(meanings[F], sp.hyper), "a power of z d/dz of another function")
            meanings[x], z = meanings[F], meanings[F].args[2]
            for _ in range(k):
                meanings[x] = z / sp.diff(z, V) * derivative(meanings[x], V)
    for x, (f, slope) in functions.items():
        F, k = f if isinstance(f, tuple) else (x, 0)
        above = next((name for name, (g, _) in functions.items() if g == (F, k + 1)), None)
        if above is not None or isinstance(f, tuple):
            gap = theta_slope(meanings[F], k, above, F, functions) - slope
        else:
            gap = derivative(f, V) - sp.sympify(slope).subs(meanings)
        check(vanishes(gap), f"the derivative of {x}")
    for x, square in roots.items():
        check(vanishes(meanings[x] ** 2 - sp.sympify(square).subs(meanings)), f"the square of {x}")
    return meanings


def theta_slope(F, k, above, name, functions):
    """Return the derivative by V of (z d/dz)^k F by the next power, or by the equation of F."""
    upper, lower, z = F.args
    rate = sp.diff(z, V) / z
    check(sp.expand(rate * V).is_number, "a hypergeometric function of no power of V")
    if above is not None:
        return rate * above
    t, names = sp.Dummy("t"), {(0,): name}
    names |= {(f[1],): x for x, (f, _) in functions.items() if isinstance(f, tuple) and f[0] == name}
    left = sp.Poly(t * sp.prod([t + b - 1 for b in lower]) - z * sp.prod([t + a for a in upper]), t)
    check(left.degree() == k + 1, "the order of a hypergeometric function")
    return -rate * sum(a * names[i] for i, a in left.terms() if i != (k + 1,)) / left.LC()


def beginning(f, functions, m):
    """Return the first terms of a function of V as it is stated."""
    if not isinstance(f, tuple):
        return first_terms(f, m)
    F, k = functions[f[0]][0], f[1]
    power = sp.degree(F.args[2], V)
    return sum(a * V**i * sp.Rational(i, power) ** k for (i,), a in sp.Poly(first_terms(F, m), V).terms())


# -- The criterion ------------------------------------------------------------------------------------------------

n = sp.Symbol("n", positive=True)


def moments(w):
    """Return b_n = n <(1 + s)^(n-1)>, and b_(n+1)/b_n: DLMF 5.12 for the harmonic weight."""
    if is_harmonic(w):
        half = sp.Rational(1, 2)
        b = 2 ** (n + 1) * n * sp.gamma(n + half) / (sp.sqrt(sp.pi) * sp.gamma(n + 2))
        return b, (2 * n + 1) * (n + 1) / (n * (n + 2))
    from_rest = sp.Poly(sp.expand(w.subs(s, s - 1)), s)
    b = n * sum(a * 2**j / (n + j) for (j,), a in from_rest.terms())
    return 2**n * b, sp.cancel(2 * b.subs(n, n + 1) / b)


def is_harmonic(w):
    """Whether a weight is that of the first harmonic."""
    return w == 2 * sp.sqrt(1 - s**2) / sp.pi


def by_moments(g, w):
    """Return the average of a sum of powers a v^p: that of v^p is -b_p V^(p-1)."""
    order = sp.Rational(1, 2) if is_harmonic(w) else min(sp.Poly(sp.expand(w.subs(s, s - 1)), s).monoms())[0]
    b, total = moments(w)[0], 0
    for term in sp.Add.make_args(sp.expand(g)):
        a, power = term.as_independent(v, as_Add=False)
        base, p = power.as_base_exp()
        check(power == 1 or (base == v and not p.has(v)), f"{term} is no power of v")
        if power != 1:
            check((p + order).is_positive, f"{term} is not known to have an average")
            total -= a * b.subs(n, p) * V ** (p - 1)
    return total


def average_of(g, w, parts):
    """Return F(V) = -<g'(V (1 + s))> of a profile g, as the sum of those of its parts, and what is not proved."""
    g = known(g)
    if not g.has(v):
        return sp.Integer(0), []
    for f in formulas_in(parts):
        known(f)
    check(agree(g - sum(part[1] for part in parts)), f"{g} is not the sum of its parts")
    total, compared = sp.Integer(0), []
    for kind, part, *data in parts:
        if kind == "antiderivatives":
            K = sp.diff(w, s).subs(s, v / V - 1) / V**2  # by parts, with v = V (1 + s)
            total += by_antiderivatives(part, K, *data) + boundary(part, w)
        elif kind == "moments":
            total += by_moments(part, w)
        elif kind == "series":
            constant, *data = data
            check(not sp.sympify(constant).has(v) and constant != 0, "a constant")
            total += constant * by_series(part / constant, w, *data)
        elif kind == "derivative":
            average, missing = under_the_integral(part, w, *data)
            total, compared = total + average, compared + missing
        else:
            check(kind == "compared", f"a proof of the kind {kind}")
            total, compared = total + data[0], [*compared, part]
    return total, compared


def boundary(g, w):
    """Return what integration by parts leaves at v = 0 and at v = 2 V, where the weight is not 0."""
    low, high = w.subs(s, -1), w.subs(s, 1)
    last = pieces_of(g)[0]
    check(high == 0 or len(last) == 1, "a weight that is not 0 at s = 1, of a profile in pieces")
    return (low * at_rest(last[0]) if low != 0 else 0) / V - (
        high * last[-1].subs(v, 2 * V) if high != 0 else 0
    ) / V


def under_the_integral(g, w, source, parts, variable):
    """Return the average of v g'(v), or of dg/dp, of a profile g by that of g: its derivative."""
    check(not source.has(sp.Piecewise), "a profile in pieces, which may move")
    x = sp.Symbol("x", positive=True)
    change = v * sp.diff(source, v) if variable == v else sp.diff(source, variable)
    check(agree(g - change), f"{g} is not a derivative")
    for f in (source, change, *([v * sp.diff(source, v, 2)] if variable == v else [])):
        check(regular(f.subs(v, x), x), f"{f} is not known to be continuous")
        at_rest(f)
    F, compared = average_of(source, w, parts)
    return (sp.diff(V * F, V) if variable == v else sp.diff(F, variable)), compared


def sum_of_terms(mu, w, terms):
    """Return c/N by the split of mu into terms a g(v/b), which add a/b F(V/b) each: criteria are linear."""
    law, total, compared = sp.Integer(0), sp.Integer(0), []
    for a, scale, shapes, g, parts in terms:
        a, scale = known(a), known(scale)
        check(scale.is_positive and not (a.has(v, V, N) or scale.has(v, V, N)), "an amplitude, or a scale")
        check(not {V, N, v, s, n} & shapes.keys(), "a shape that is a speed or a force")
        shapes = {x: known(value) for x, value in shapes.items()}
        check(not any(value.has(sp.I) for value in (a, scale, *shapes.values())), "an imaginary number")
        law += a * at_scale(sp.sympify(g), scale, shapes)
        F, missing = average_at(g, w, parts, shapes)
        total += a / scale * F.subs(V, V / scale)
        compared += missing
    check(agree(mu - law), "the split of mu into terms")
    return total, compared


def average_at(g, w, parts, shapes):
    """Return the average of a profile at values of its shapes: that of all shapes, or with the values put in."""
    try:
        for x, value in shapes.items():
            # A rational function of real numbers is real where it is finite.
            is_real = kinds(x) == ["real"] and value.is_rational_function(*value.free_symbols)
            check(is_real or all(getattr(value, f"is_{kind}") for kind in kinds(x)), f"{x} = {value}")
        F, missing = average_of(g, w, parts)
        return F.subs(shapes, simultaneous=True), missing
    except NotProved:
        if not shapes:
            raise
        return average_of(with_values(g, shapes), w, with_values(parts, shapes))


def with_values(data, shapes):
    """Return data with values for the shapes."""
    if isinstance(data, dict):
        return {x: with_values(e, shapes) for x, e in data.items()}
    if isinstance(data, list | tuple):
        return type(data)(with_values(e, shapes) for e in data)
    return data.subs(shapes, simultaneous=True) if isinstance(data, sp.Basic) else data


def at_scale(g, scale, shapes):
    """Return g(v/scale), with values for the shapes."""
    if not isinstance(g, sp.Piecewise):
        return g.subs({v: v / scale, **shapes}, simultaneous=True)
    places = [holds is sp.true or v < scale * place_of(holds, v).subs(shapes) for _, holds in g.args]
    return sp.Piecewise(
        *[(at_scale(piece, scale, shapes), holds) for (piece, _), holds in zip(g.args, places, strict=True)]
    )


def kinds(x):
    """Return the kind of a symbol: positive, nonnegative or real, and nothing else."""
    for kind in ("positive", "nonnegative", "real"):
        if x == sp.Symbol(x.name, **{kind: True}):
            return [kind]
    raise NotProved(f"{x} is assumed to be something else than positive, nonnegative or real")


def decided(e, x, place, side):
    """Return an expression in pieces of x at x = place, or just below (-1) or above (1) it."""
    values = {}
    for holds in conditions_in(e):
        gap = sp.cancel(place_of(holds, x, strict=False) - place)
        if gap.is_positive or gap.is_negative:
            values[holds] = sp.true if gap.is_positive else sp.false
        elif gap == 0:
            is_strict = isinstance(holds, sp.StrictLessThan | sp.StrictGreaterThan)
            values[holds] = sp.true if side == -1 or (side == 0 and not is_strict) else sp.false
    return e.xreplace(values)


def slope_at_the_belt(mu, c, jumps):
    """Check that c = -N mu'(V), and at a kink of mu the mean of both slopes."""
    x = sp.Symbol("x", positive=True)
    for e in ends_of_branches(mu):
        check(regular(e.subs(v, x), x, analytic=True), f"{e} is not known to be smooth")
    slope = -N * derivative(mu, v).subs(v, V)
    places = {place_of(holds, v) for holds in conditions_in(mu)}
    own = {place_of(holds, V, strict=False) for holds in conditions_in(c)}
    check(all(any(sp.cancel(place - q) == 0 for q in places) for place in own), "the places of c")
    strict = {holds: place_of(holds, V, strict=False) > V for holds in conditions_in(c)}
    check(agree(c.xreplace(strict) - slope, V), "c is not -N mu'(V)")
    for place in places - set(jumps):
        below, here, above = (decided(e, V, place, side) for e, side in ((slope, -1), (c, 0), (slope, 1)))
        gap = here.xreplace(strict) - (below + above) / 2
        check(agree(gap, V, place), f"c is not the mean of both slopes at V = {place}")


def ends_of_branches(e):
    """Return the formulas of which an expression in pieces consists."""
    nodes = e.atoms(sp.Piecewise)
    if not nodes:
        return [e]
    node = max(nodes, key=sp.count_ops)
    return [end for piece, _ in node.args for end in ends_of_branches(e.xreplace({node: piece}))]


def jumps_of(mu):
    """Return the places where mu jumps, or is not known not to, and by how much."""
    jumps = {}
    for place in {place_of(holds, v) for holds in conditions_in(mu)}:
        below, above = (decided(mu, v, place, side) for side in (-1, 1))
        if not agree(above - below, v, place):
            jumps[place] = sp.factor((above - below).subs(v, place))
    return jumps


def factors_of(e):
    """Return the factors of an expression that are not known not to be 0."""
    bases = [f.as_base_exp()[0] for f in sp.Mul.make_args(sp.factor(sp.fraction(sp.together(e))[0]))]
    open_ = [f for f in bases if not (f.is_nonzero or positive(f, V) or positive(-f, V))]
    return {-f if f.could_extract_minus_sign() else f for f in open_}


def divided_by(e):
    """Return the factors that a formula divides by, and that are not known not to be 0."""
    below = [node.base for node in e.atoms(sp.Pow) if node.exp.is_negative and node.base != sp.E]
    return {f for base in below for f in factors_of(base)}


def formulas_in(data):
    """Return all formulas in the data of an average."""
    if isinstance(data, dict):
        return formulas_in([*data.keys(), *data.values()])
    if isinstance(data, list | tuple):
        return [f for item in data for f in formulas_in(item)]
    return [] if data is None or isinstance(data, str) else [sp.sympify(data)]


def exceptions(c, terms):
    """Return what must not be 0: factors that c, or the proofs of the averages, divide by."""
    factors = {f for f in divided_by(c) if not f.has(v)}
    for amplitude, scale, shapes, g, parts in terms:
        free = {V, *shapes, *sp.sympify(g).free_symbols} - {v}
        inner = {f for data in formulas_in(parts) for f in divided_by(data)}
        inner |= {f for part in parts if part[0] == "series" for f in factors_of(part[5][0])}  # of q_0(n)
        inner = {f for f in inner if f.free_symbols <= free}
        factors |= {f for e in inner for f in factors_of(e.subs({V: V / scale, **shapes}, simultaneous=True))}
        factors |= {f for e in (amplitude, scale, *shapes.values()) for f in divided_by(sp.sympify(e))}
    return sorted(factors, key=str)


def numbers_at(i, e, free=()):
    """Return an expression at the i-th of some points: with numbers for its symbols, but for those left free."""
    at = {x: sp.Rational(random.Random(f"{i} {x}").randint(500, 1500), 1000) for x in e.free_symbols - set(free)}
    return e.subs(at)


def compare(mu, w, c):
    """Compare c with its definition at three points, to 20 digits: SymPy itself is checked, by mpmath."""
    with mpmath.workdps(40):
        for i in range(3):
            value = mpmath.mpmathify(sp.N(numbers_at(i, c), 40))
            if w is None:
                f = sp.lambdify(v, numbers_at(i, -N * mu, [v]), "mpmath")
                defined = mpmath.diff(f, mpmath.mpmathify(numbers_at(i, V)))
            else:
                defined = integral(numbers_at(i, N * mu, [v]), w, numbers_at(i, V))
            check(
                abs(value - defined) <= 1e-20 * max(abs(defined), 1e-10), f"the definition at point {i}: {value}"
            )


def integral(mu, w, speed):
    """Return int mu(v) w'(v/V - 1)/V^2 dv over [0, 2 V], and what it leaves at the ends, with v = 2 V t^8."""
    f, slope = (sp.lambdify(x, e, "mpmath") for x, e in ((v, mu), (s, sp.diff(w, s))))
    place, top = [place_of(holds, v) for holds in conditions_in(mu)], mpmath.mpmathify(speed)

    def integrand(t):
        u = 2 * t**8  # v/V
        with mpmath.workdps(40 + 3 * max(0, int(-mpmath.log10(u)))):  # as coth(v) - 1/v cancels
            return f(top * u) * slope(u - 1) * 16 * t**7 / top

    if is_harmonic(w):  # u = 1 - cos(pi t^8), whose root at the ends is gone

        def integrand(t):
            a = mpmath.pi * t**8
            u = 2 * mpmath.sin(a / 2) ** 2
            with mpmath.workdps(40 + 3 * max(0, int(-mpmath.log10(u)))):
                return f(top * u) * 16 * mpmath.cos(a) * t**7 / top

    kinks = [mpmath.mpmathify(p / (2 * speed)) for p in place if 0 < p < 2 * speed]
    kinks = [2 * mpmath.asin(mpmath.sqrt(u)) / mpmath.pi if is_harmonic(w) else u for u in kinks]
    ends = {mpmath.mpf(0), *(mpmath.root(u, 8) for u in kinks), *(mpmath.mpf(j) / 4 for j in range(1, 5))}
    total = mpmath.quad(integrand, sorted(ends))
    low, high = w.subs(s, -1), w.subs(s, 1)
    total += mpmath.mpmathify(low) * f(mpmath.mpf(0)) / top if low != 0 else 0
    return total - (mpmath.mpmathify(high) * f(2 * top) / top if high != 0 else 0)


def prove(mu, w, c, terms, source=None):
    """Prove that c = -N int_-1^1 w(s) mu'(V (1 + s)) ds, and print what was proved; w = None is c = -N mu'(V)."""
    mu, c, compared = known(mu), known(c), []
    check(not mu.has(sp.I), "an imaginary number")
    check(not mu.has(V, N) and not c.has(v), "mu is a function of v, and c of V and N")
    parameters = sorted((mu.free_symbols | c.free_symbols) - {V, N, v}, key=str)
    names = [x.name for x in parameters]
    check(not set(names) & {"V", "N", "v", "s", "n"}, "V, N, v, s or n means something else")
    check(
        len(set(names)) == len(names) and all(map(str.isidentifier, names)), "names that are not those of letters"
    )
    of_kind = {
        kind: [str(x) for x in [V, N, *parameters] if kinds(x) == [kind]]
        for kind in ("positive", "nonnegative", "real")
    }
    jumps = jumps_of(mu)
    if source is not None:
        law, parameter = known(source[0]), source[1]
        check(agree(sp.diff(law, parameter) - mu), "mu is not the derivative of the law")
        check(not any(place.has(parameter) for place in jumps_of(law)), "a jump that moves")
    if w is None:
        slope_at_the_belt(mu, c, jumps)
    else:
        w = known(w)
        polynomial = w.is_polynomial(s) and all(a.is_Rational for a in sp.Poly(w, s).all_coeffs())
        check(is_harmonic(w) or (polynomial and sp.integrate(w, (s, -1, 1)) == 1), "w is no average known here")
        total, compared = sum_of_terms(mu, w, terms)
        check(vanishes(c - N * total), "c is not the sum of the averages")
    compare(mu, w, c)
    print(f"compared at points only: c = {c}" if compared else f"proved: c = {c}")
    print(f"for mu(v) = {mu}")
    print("and c = -N mu'(V)" if w is None else f"and c = -N int_-1^1 w(s) mu'(V (1 + s)) ds, w(s) = {w}")
    print("for all " + "; ".join(f"{', '.join(names)} {kind}" for kind, names in of_kind.items() if names))
    for part in compared:
        print(f"not proved, and compared at points: the average of {part}")
    if source is not None:
        print(f"mu is the derivative by {parameter} of {law}, whose criterion is linear in it")
    for place, jump in jumps.items():
        print(f"mu jumps at v = {place}, by {jump}: mu' has there this jump times a delta function")
        if w is not None:
            print(f"  of which c has the term -N w({place}/V - 1) ({jump})/V where 0 < {place} < 2 V")
    is_continuous = w is not None and all(regular(e, x) for e in ends_of_branches(mu) for x in [v, *parameters])
    if factors := exceptions(c, terms):
        where = " = 0, or ".join(map(str, factors))
        if is_continuous:
            print(f"where {where} = 0, by continuity: c is its limit, as mu and so its average is continuous")
        else:
            print(f"not proved where {where} = 0: there a formula divides by 0")
    if w is not None and all(regular(derivative(e, v), v) for e in ends_of_branches(mu)) and not jumps:
        first = mu.xreplace({holds: sp.true for holds in conditions_in(mu) if place_of(holds, v).is_positive})
        if not first.has(sp.Piecewise):
            print(f"as V falls to 0, c tends to -N mu'(0) = {sp.factor((-N * derivative(first, v)).subs(v, 0))}")


for claim in claims:
    prove(*claim)

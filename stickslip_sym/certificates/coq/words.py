"""Formulas in the words of a script in Coq, and in the generators that its tactic `field` can tell apart.

`field` proves equations of rational functions. It takes every other function for a letter of its own, so equal
values need equal text: exponents are split into monomials, of which each has one step, and roots have radicands
without squares.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import combinations
from math import gcd

import sympy as sp

from stickslip_sym.certificates.coq.printer import MADE, Unsupported
from stickslip_sym.core.aliases import Condition, Expr, Relation
from stickslip_sym.core.numbers import ROOT_OF_ROUNDING

_HALF = sp.Rational(1, 2)
HYPERBOLIC = (sp.tanh, sp.sinh, sp.cosh, sp.coth, sp.sech, sp.csch)


def call(name: str, *arguments: Expr) -> Expr:
    """Return a function by its name in Coq."""
    return sp.Function(name)(*arguments)


def exponential(argument: Expr) -> Expr:
    """Return an exponential that SymPy leaves as it is."""
    return call("exp", argument)


# -- the words of a script ---------------------------------------------------------------------------


def rewrite_for_coq(expr: Expr, speed: Expr) -> Expr:
    """Write powers and special functions as a script has them; those of the speed that vanish at rest apart."""
    expr = expr.replace(sp.im, _inverse_tangent_integral)
    if expr.has(sp.Catalan):
        expr = expr.subs(sp.Catalan, call("Ti2", sp.S.One))
    if expr.has(sp.polylog, sp.zeta, sp.dirichlet_eta):
        expr = _write_by_polylogarithms(expr)
    expr = expr.replace(sp.lowergamma, _lower_gamma)
    return reduce_squared_roots(expr.replace(is_power, lambda node: _write_power(node, speed)))


def reduce_squared_roots(expr: Expr) -> Expr:
    """Write whole powers of a square root by the root itself at most."""
    root = sp.Function("sqrt")

    def is_square(node: Expr) -> bool:
        return bool(node.is_Pow and isinstance(node.base, root) and node.exp.is_Integer and node.exp not in (0, 1))

    return expr.replace(is_square, lambda node: node.base.args[0] ** (node.exp // 2) * node.base ** (node.exp % 2))


def is_power(node: Expr) -> bool:
    """Tell whether a node is a power whose exponent is no whole number."""
    return bool(node.is_Pow and node.base is not sp.E and not node.exp.is_Integer)


def _inverse_tangent_integral(argument: Expr) -> Expr:
    """Write im(polylog(k, I*y)), of which the first is atan(y)."""
    if not isinstance(argument, sp.polylog) or not argument.args[0].is_Integer:
        raise Unsupported(f"a script in Coq has no im({argument})")
    order = argument.args[0]
    y = sp.expand(argument.args[1] / sp.I)
    if order == 1:
        return sp.atan(y)
    return call(f"Ti{order}", y)


def _write_by_polylogarithms(expr: Expr) -> Expr:
    """Write pi^2, zeta(3) and pi^4 by the polylogarithms at -1 that they are values of."""
    at = [call(f"polylog{order}", sp.S.NegativeOne) for order in (2, 3, 4)]
    values = {
        sp.pi**2: -12 * at[0],
        sp.zeta(3): -4 * at[1] / 3,
        sp.dirichlet_eta(3): -at[1],
        sp.pi**4: -720 * at[2] / 7,
    }
    others = (sp.polylog, sp.zeta, sp.log, sp.erf)
    expr = expr.replace(lambda node: node.is_Mul and node.has(sp.pi**2) and not node.has(*others), sp.expand)
    expr = expr.xreplace(values)
    return expr.replace(sp.polylog, _polylog)


def _polylog(order: Expr, argument: Expr) -> Expr:
    if order not in (1, 2, 3, 4):
        raise Unsupported(f"a script in Coq has no polylogarithm of order {order}")
    return call(f"polylog{order}", argument)


def _lower_gamma(order: Expr, z: Expr) -> Expr:
    """Write gamma(k/p, y^p)."""
    k, p = order.as_numer_denom()
    if not (k.is_Integer and k > 0):
        raise Unsupported(f"a script in Coq has no lower incomplete gamma function of order {order}")
    return call("lower_gamma", k, p, sp.powdenest(z ** (1 / p), force=True))


def _write_power(node: Expr, speed: Expr) -> Expr:
    """Write a power by a whole power of the base and a root, or by x^p of Coq."""
    base, p = node.args
    if isinstance(base, sp.Function) and base.func.__name__ in MADE:
        return node
    whole = sp.floor(p) if p.is_Rational else p.as_coeff_Add()[0]
    if not whole.is_Integer:
        whole = sp.S.Zero
    if p - whole == _HALF:
        return base**whole * call("sqrt", base)
    at_rest = base.has(speed) and base.subs(speed, 0) == 0
    return base**whole * call(*(("power", p - whole, base) if at_rest else ("Rpower", base, p - whole)))


# -- generators that `field` can tell apart ----------------------------------------------------------


class Generators:
    """The exponentials of some formulas, each a power of that of one step of its monomial."""

    def __init__(self, exprs: Iterable[Expr]) -> None:
        self.steps: dict[Expr, Expr] = {}
        for expr in exprs:
            for node in _write_by_exponentials(expr).atoms(sp.exp):
                for rate, monomial in monomials(reduce_squared_roots(_write_by_roots(node.exp))):
                    known = self.steps.get(monomial)
                    self.steps[monomial] = rate if known is None else sp.sign(known) * _common(known, rate)

    def exponentials(self, exprs: Iterable[Expr]) -> set[Expr]:
        """Return the exponentials of formulas once hyperbolic functions are written by them."""
        return {node for expr in exprs for node in _write_by_exponentials(expr).atoms(sp.exp)}

    def argument(self, node: Expr) -> Expr:
        """Return the argument of an exponential as `of` would leave it."""
        return reduce_squared_roots(_write_by_roots(node.args[0]))

    def of(self, expr: Expr) -> Expr:
        """Write a formula in these exponentials, in roots without squares, and without hyperbolic functions."""
        expr = _write_by_exponentials(expr)
        return reduce_squared_roots(_write_by_roots(expr).replace(sp.exp, self._powers))

    def _powers(self, argument: Expr) -> Expr:
        """Write an exponential as a product of whole powers of those of its steps."""
        parts = [
            (exponential(self.steps[m] * m), rate / self.steps[m])
            for rate, m in monomials(reduce_squared_roots(argument))
        ]
        return sp.Mul(*[base**power for base, power in parts])


def _write_by_exponentials(expr: Expr) -> Expr:
    """Write hyperbolic functions by exponentials that do not grow."""

    def plus(u: Expr) -> Expr:
        return 1 + sp.exp(-2 * u)

    def minus(u: Expr) -> Expr:
        return 1 - sp.exp(-2 * u)

    def twice(u: Expr) -> Expr:
        return 2 * sp.exp(-u)

    expr = expr.replace(sp.tanh, lambda u: minus(u) / plus(u))
    expr = expr.replace(sp.coth, lambda u: plus(u) / minus(u))
    expr = expr.replace(sp.sech, lambda u: twice(u) / plus(u))
    expr = expr.replace(sp.csch, lambda u: twice(u) / minus(u))
    expr = expr.replace(sp.cosh, lambda u: plus(u) / twice(u))
    return expr.replace(sp.sinh, lambda u: minus(u) / twice(u))


def _write_by_roots(expr: Expr) -> Expr:
    """Write each square root by that of a polynomial without squares."""

    def root(inside: Expr) -> Expr:
        radicand, divisor = square_free(inside)
        if is_monomial(radicand):
            parts: Sequence[Expr] = sp.Mul.make_args(radicand)
        else:
            parts = two_factors(radicand) or [radicand]
        return sp.Mul(*[call("sqrt", part) for part in parts]) / divisor

    return expr.replace(sp.Function("sqrt"), root)


def is_monomial(radicand: Expr) -> bool:
    """Tell whether a radicand is a product of letters and numbers, whose root is that of their roots."""
    return bool(radicand.is_Mul and all(part.is_Atom and part.is_nonnegative for part in radicand.args))


def two_factors(radicand: Expr) -> list[Expr]:
    """Return the two positive factors of a radicand, whose root is the product of theirs, if it has two."""
    factors = sp.Mul.make_args(sp.factor(radicand))
    if len(factors) != 2 or not all(factor.is_positive for factor in factors):
        return []
    return [sp.expand(factor) for factor in factors]


def _common(first: Expr, second: Expr) -> Expr:
    """Return the largest rational number of which both are whole multiples."""
    return sp.Rational(gcd(first.p * second.q, second.p * first.q), first.q * second.q)


def monomials(expr: Expr) -> Iterator[tuple[Expr, Expr]]:
    """Yield the rational factor of each term of a sum, and the rest of it."""
    for term in sp.Add.make_args(sp.expand(expr)):
        if term != 0:
            yield term.as_coeff_Mul(rational=True)


def square_free(inside: Expr) -> tuple[Expr, Expr]:
    """Return a radicand without squares, and a divisor: the root is that of the radicand, divided by it."""
    above, below = sp.fraction(sp.together(inside))
    front = sp.S.One
    radicand = sp.S.One
    for factor, power in _factor_list(above * below):
        front *= factor ** (power // 2)
        radicand *= factor ** (power % 2)
    return sp.expand(radicand), below / front


def _factor_list(expr: Expr) -> list[tuple[Expr | int, int]]:
    constant, factors = sp.factor_list(expr)
    if not constant.is_Integer:
        return [(constant, 1), *factors]
    numbers = [(number, power) for number, power in sp.factorint(constant).items() if number != 1]
    return [*numbers, *factors]


# -- what stands in a formula ------------------------------------------------------------------------


def functions_of(*exprs: Expr) -> list[Expr]:
    """Return the functions of formulas, inner ones first."""
    nodes = {node for expr in exprs for node in expr.atoms(sp.Function)}
    nodes = {node for node in nodes if not isinstance(node, sp.Min | sp.Max | sp.Piecewise)}
    return sorted(nodes, key=lambda node: (len(node.atoms(sp.Function)), str(node)))


def roots_of(*exprs: Expr) -> list[Expr]:
    """Return the square roots of formulas, in order."""
    return [node for node in functions_of(*exprs) if node.func.__name__ == "sqrt"]


def denominators(*exprs: Expr, without: Sequence[Expr] = ()) -> list[Expr]:
    """Return the factors of denominators that have no known sign: a formula excludes their zeros.

    Those with a letter of `without` are left out: they are the slip speed's, which the proof looks after.
    """
    factors = set[Expr]()
    for node in {node for expr in exprs for node in expr.atoms(sp.Pow)}:
        if node.exp.is_Integer and node.exp.is_negative:
            try:
                factors |= {factor for factor, _ in sp.factor_list(node.base)[1]}
            except sp.PolynomialError:
                factors.add(node.base)
    unknown = {factor for factor in factors if not (factor.is_positive or factor.is_negative)}
    return sorted((factor for factor in unknown if not factor.has(sp.Function, *without)), key=str)


def bounds_of(*exprs: Expr) -> set[Expr]:
    """Return what is the smaller or the larger of others."""
    return {node for expr in exprs for node in expr.atoms(sp.Min, sp.Max)}


def factor_out_range(bound: Expr, speed: Expr) -> tuple[Expr, Expr] | None:
    """Return a factor and the smaller of 2 V and others, whose product a bound is; None without such a form."""
    moving = [argument for argument in bound.args if argument.has(speed)]
    if not isinstance(bound, sp.Min) or len(moving) != 1:
        return None
    factor = sp.simplify(moving[0] / (2 * speed))
    if factor.has(speed) or not factor.is_positive:
        return None
    return factor, sp.Min(*(_divide_extremum(argument, factor) for argument in bound.args))


def _divide_extremum(expr: Expr, factor: Expr) -> Expr:
    if isinstance(expr, sp.Min | sp.Max):
        return expr.func(*(_divide_extremum(argument, factor) for argument in expr.args))
    return sp.simplify(expr / factor)


def place_in_condition(condition: Condition, speed: Expr) -> Expr:
    """Return the place of a condition speed < place, or speed <= place, which SymPy may turn round, or scale."""
    place = speed
    if isinstance(condition, sp.core.relational.Relational):
        difference = sp.expand(condition.lts - condition.gts)
        rate = difference.coeff(speed)
        if rate.is_positive:
            place = sp.simplify(speed - difference / rate)
    if place.has(speed):
        raise Unsupported(f"a script in Coq has pieces for v < place, and none for {condition}")
    return place


def solve_conditions_for_speed(expr: Expr, speed: Expr) -> Expr:
    """Write the conditions of pieces as speed < place."""
    conditions = [node for node in expr.atoms(sp.core.relational.Relational) if node.has(speed)]
    return expr.xreplace({node: _ordered(node, speed) for node in conditions})


def _ordered(relation: Relation, speed: Expr) -> Relation:
    kind: type[Relation] = sp.LessThan
    if isinstance(relation, sp.StrictLessThan | sp.StrictGreaterThan):
        kind = sp.StrictLessThan
    return kind(speed, place_in_condition(relation, speed), evaluate=False)


def places_of(expr: Expr, speed: Expr) -> list[Expr]:
    """Return the places of the pieces of an expression."""
    conditions = {holds for node in expr.atoms(sp.Piecewise) for _, holds in node.args} - {sp.true}
    return sorted({place_in_condition(holds, speed) for holds in conditions}, key=str)


def differs(expr: Expr, value: Expr) -> bool:
    """Tell whether numbers for the letters show that an expression is not a value; False where none does."""
    known = expr.replace(sp.Function("sqrt"), sp.sqrt).replace(sp.Function("exp"), sp.exp)
    numbers = {x: sp.Rational(7 + 3 * i, 11 + i) for i, x in enumerate(sorted(known.free_symbols, key=str))}
    gap = sp.N(known.xreplace(numbers) - value)
    return bool(gap.is_number and gap.is_real and abs(gap) > ROOT_OF_ROUNDING)


def depth(node: Expr) -> int:
    """Return how many functions stand one within another."""
    return max(map(depth, node.args), default=0) + isinstance(node, sp.Function)


# -- what the tactics cannot prove -------------------------------------------------------------------


def require_regular(speed: Expr, *exprs: Expr, at_rest: bool) -> None:
    """Refuse formulas whose logarithms, roots or quotients are not known to exist at all slip speeds.

    The tactic for positivity knows the signs of letters, and quadratic polynomials with numbers for coefficients.
    """
    nodes = {node for expr in exprs for node in sp.preorder_traversal(expr)}
    for node in {node for node in nodes if node.has(speed)}:
        name = node.func.__name__
        inside = node.args[0] if node.args else node
        if at_rest and name == "power" and not node.args[0].is_positive:
            raise Unsupported(
                f"a script in Coq has no power of v whose exponent {node.args[0]} may not be positive"
            )
        is_quotient = node.is_Pow and node.exp.is_Integer and node.exp.is_negative
        if (name in ("log", "Rpower") or is_quotient) and not _is_shown_positive(inside, speed, at_rest):
            raise Unsupported(f"a script in Coq cannot tell that {_shown(inside)}, in {_shown(node)}, is positive")
        if name == "sqrt" and not (_is_shown_positive(inside, speed, at_rest) or inside.is_nonnegative):
            raise Unsupported(f"a script in Coq cannot tell that {_shown(inside)} is not negative")


def require_independent(roots: Sequence[Expr]) -> None:
    """Refuse roots of which one is the product of two others, which `field` takes for letters of their own."""
    radicands = [root.args[0] for root in roots]
    for first, second in combinations(radicands, 2):
        product = square_free(first * second)[0]
        if product in radicands and product not in (first, second):
            raise Unsupported(
                f"a script in Coq has no root of {_shown(product)} beside those of {_shown(first)} and "
                f"{_shown(second)}, whose product it is"
            )


def _is_shown_positive(expr: Expr, speed: Expr, at_rest: bool) -> bool:
    """Tell whether an expression is positive by its signs, from rest on, or as a quadratic with numbers."""
    if at_rest and expr.subs(speed, 0) == 0:
        return False
    if any(form.is_positive for form in (expr, sp.expand(expr))):
        return True
    if expr.is_Mul or (expr.is_Pow and expr.exp.is_Integer):
        return all(
            _is_shown_positive(factor.as_base_exp()[0], speed, at_rest) for factor in sp.Mul.make_args(expr)
        )
    if not expr.is_polynomial(speed) or sp.degree(expr, speed) != 2:
        return False
    a, b, c = sp.Poly(expr, speed).all_coeffs()
    return bool(a.is_number and a.is_positive and (4 * a * c - b**2).is_positive)


def _shown(expr: Expr) -> str:
    return str(expr).replace("_u", "u")[:60]

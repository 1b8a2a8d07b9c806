"""The shape in which a result is printed."""

from functools import lru_cache

import sympy as sp
from sympy.core.random import rng

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.proof.normal_form import eta_by_zeta, in_units

__all__ = ["tidy"]

_LARGEST = 1500  # operations of an expression that is still factored
_MOST_FUNCTIONS = 12  # in it, each a variable of the polynomial to factor
_OPAQUE = (sp.Function, sp.Min, sp.Max)


def tidy(expr: Expr, model: Expr, small: Expr) -> Expr:
    """Rewrite a result as a person would print it.

    The common factors come out, what multiplies a function is collected and factored, and each factor has the
    sign that it has in `model` (the formula of the law), or that is positive for a small value of the symbol
    `small`.
    """
    expr = expr.replace(sp.dirichlet_eta, eta_by_zeta)
    expr = expr.replace(lambda node: isinstance(node, sp.Min | sp.Max), in_units)
    # To algebra every function is a symbol: SymPy would otherwise take exp(-x/3) and exp(-1000 x) for powers of
    # one generator, of a degree that nothing survives.
    functions = _outermost(expr)
    opaque = expr.xreplace(functions)
    if len(functions) > _MOST_FUNCTIONS or opaque.count_ops() > _LARGEST:
        return expr
    back = {symbol: node for node, symbol in functions.items()}
    order = sorted(back, key=lambda symbol: sp.default_sort_key(back[symbol]))
    shapes = (
        _factored(opaque, order, model, small),
        sp.Add(*[_factored(term, order, model, small) for term in sp.Add.make_args(opaque)]),
    )
    return min(shapes, key=lambda shape: int(shape.count_ops())).xreplace(back)


def _outermost(expr: Expr) -> dict[Expr, Expr]:
    """Return a symbol for each function that does not stand inside another."""
    found: dict[Expr, Expr] = {}
    walk = sp.preorder_traversal(expr)
    for node in walk:
        if isinstance(node, _OPAQUE):
            # Each a name of its own: the order of variables decides how long factoring takes.
            found.setdefault(node, sp.Dummy(f"f{len(found)}", real=True))
            walk.skip()
    return found


def _factored(expr: Expr, functions: list[Expr], model: Expr, small: Expr) -> Expr:
    sign, factors = 1, []
    for factor in sp.Mul.make_args(sp.Mul(*map(_rooted, sp.Mul.make_args(_factor(expr))))):
        if factor.is_Add and _should_flip(factor, model, small):
            sign, factor = -sign, -factor
        if factor.is_Add and factor.has(*functions):
            factor = sp.collect(factor, functions, _factor)
        factors.append(factor)
    return sp.Mul(sign, *factors)


def _rooted(factor: Expr) -> Expr:
    """Bring out the roots that all terms of a sum share, which to factoring are no common factor."""
    total, exponent = factor.as_base_exp()
    if not total.is_Add or not exponent.is_Integer:
        return factor
    powers = [term.as_powers_dict() for term in total.args]
    shared = {
        base: min(power[base] for power in powers)
        for base in set(powers[0]).intersection(*powers[1:])
        if all(power[base].is_Rational and power[base] > 0 for power in powers)
    }
    common = sp.Mul(*[base**exponent for base, exponent in shared.items() if not base.is_number])
    return common**exponent * sp.Add(*[term / common for term in total.args]) ** exponent


@lru_cache(maxsize=128, typed=True)
def _factor(expr: Expr) -> Expr:
    """Factor a polynomial, once, with the same random numbers every time: with some it takes minutes."""
    before = rng.getstate()
    rng.seed(0)
    try:
        return sp.factor(expr)
    finally:
        rng.setstate(before)


def _should_flip(factor: Expr, model: Expr, small: Expr) -> bool:
    for node in sp.preorder_traversal(model):
        if node.is_Add:
            node = node.primitive()[1]
        if node in (factor, -factor):
            return bool(node == -factor)
    leading = factor.subs(small, 0)
    if leading.is_negative or leading.is_positive:
        return bool(leading.is_negative)
    # Its sign is not known, or it vanishes because its terms cancel: let the fewer ones carry a minus.
    signs = [term.could_extract_minus_sign() for term in sp.Add.make_args(sp.expand(factor))]
    return bool(2 * sum(signs) > len(signs))

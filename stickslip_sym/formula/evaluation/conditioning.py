"""Slopes in a form that is accurate at every speed, and the speeds at which they change."""

from itertools import pairwise

import sympy as sp
from sympy.codegen.cfunctions import expm1

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr

__all__ = ["conditioned", "speed_scales", "without_squares"]


def conditioned(slope: Expr) -> Expr:
    """Rewrite a slope so that nothing overflows or cancels that need not.

    Hyperbolic functions become exponentials of what is not positive, 1 - tanh^2 is sech^2, 1 - exp is expm1,
    and fractions are brought over one denominator.
    """
    if slope.has(sp.Piecewise):
        return without_squares(slope)
    expr = without_squares(slope).replace(sp.cosh, lambda a: 1 / sp.sech(a))
    expr = expr.replace(sp.sech, lambda a: 2 * sp.exp(-a) / (1 + sp.exp(-2 * a)))
    if expr.is_rational_function(symbols.v):
        by_terms = sp.Add(*[sp.factor(term) for term in sp.Add.make_args(expr)])
        expr = min(sp.factor(expr), by_terms, key=lambda form: int(form.count_ops()))
    else:
        expr = sp.factor_terms(expr)
    return expr.replace(_is_one_minus_exponential, _as_expm1)


def without_squares(expr: Expr) -> Expr:
    """Write 1 - tanh^2 as sech^2, which does not cancel."""
    return expr.replace(
        lambda node: _tanh_squared(node) is not None, lambda node: sp.sech(_tanh_squared(node)) ** 2
    )


def _tanh_squared(node: Expr) -> Expr | None:
    """Return a where a sum is 1 - tanh(a)^2."""
    if not (node.is_Add and len(node.args) == 2 and node.args[0] == 1):
        return None
    square = -node.args[1]
    return square.base.args[0] if square.is_Pow and square.exp == 2 and isinstance(square.base, sp.tanh) else None


def _is_one_minus_exponential(node: Expr) -> bool:
    return bool(
        node.is_Add
        and len(node.args) == 2
        and abs(node.args[0]) == 1
        and isinstance(-node.args[1] * node.args[0], sp.exp)
    )


def _as_expm1(node: Expr) -> Expr:
    sign, exponential = node.args[0], -node.args[1] * node.args[0]
    return -sign * expm1(exponential.args[0])


def speed_scales(expr: Expr, v: Expr) -> list[Expr]:
    """Return the slip speeds on the scale of which an expression changes, as monomials of its parameters.

    In a sum of monomials a v^p that is the speed at which two of them balance, and in the argument of a function
    the speed at which the argument is 1.
    """
    found: dict[Expr, None] = {}
    for node in sp.postorder_traversal(expr):
        if node.is_Add and node.has(v):
            terms = [_monomial(term, v) for term in node.args]
            known = [term for term in terms if term is not None]
            for (a, p), (b, q) in pairwise(known):
                if p != q:
                    found[sp.powdenest(sp.Abs(a / b) ** (1 / (q - p)), force=True)] = None
        elif (isinstance(node, sp.Function) and not isinstance(node, sp.Piecewise)) or (
            node.is_Pow and node.exp.has(v)
        ):
            for argument in node.args:
                powers: dict[Expr, Expr] = {}
                for a, p in filter(None, (_monomial(term, v) for term in sp.Add.make_args(sp.expand(argument)))):
                    powers[p] = powers.get(p, 0) + a
                for p, a in powers.items():
                    if p != 0 and a != 0:
                        found[sp.powdenest(sp.Abs(a) ** (-1 / p), force=True)] = None
    return [scale for scale in found if not scale.has(v)]


def _monomial(term: Expr, v: Expr) -> tuple[Expr, Expr] | None:
    """Return (a, p) of a term a v^p."""
    coefficient, rest = sp.expand_power_base(term, force=True).as_independent(v, as_Add=False)
    base, exponent = rest.as_base_exp()
    if rest == 1:
        return coefficient, sp.Integer(0)
    return (coefficient, exponent) if base == v and not exponent.has(v) else None

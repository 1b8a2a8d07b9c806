"""The limit of a coefficient of friction at rest as a formula in its parameters."""

from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import elementary, fold
from stickslip_sym.model.expression.pieces import kinked


@lru_cache
def symbolic_limit_at_rest(expr: Expr) -> Expr:
    """Return the limit of an expression in v and parameters as v falls to 0; `sympy.nan` if none is found.

    Where it depends on the sign of a place, it is a Piecewise.
    """
    for node in kinked(expr):
        cases = []
        for part, condition in node.args:
            if (holds := condition.xreplace({symbols.v: sp.Integer(0)})) != sp.false:
                cases.append((symbolic_limit_at_rest(expr.xreplace({node: part})), holds))
            if holds == sp.true:
                break
        return sp.nan if any(limit is sp.nan for limit, _ in cases) else sp.Piecewise(*cases)
    # SymPy says in these ways that it finds no limit.
    try:
        limit = fold(elementary(expr), _value_at_zero)
        if not limit.is_finite:  # SymPy takes for ever for functions of steep logarithms
            limit = sp.limit(elementary(expr), symbols.v, 0, "+")
    except (ArithmeticError, NotImplementedError, TypeError, ValueError):
        return sp.nan
    return sp.nan if limit.has(symbols.v, sp.Limit, sp.AccumBounds, sp.I, sp.nan) else limit


def _value_at_zero(node: Expr, parts: list[Expr]) -> Expr:
    """Return a node at v = 0, a logarithm there as minus infinity; NaN where that does not decide its limit."""
    if node == symbols.v:
        return sp.Integer(0)
    if isinstance(node, sp.log) and parts[0] == 0:
        return -sp.oo
    if node.is_Pow and not parts[0].is_finite:  # SymPy has 0 where the sign of the exponent is not known
        return sp.Integer(0) if parts[0].is_infinite and parts[1].is_negative else sp.nan
    if sp.zoo in parts and not (node.is_Add or node.is_Mul):
        return sp.nan
    return node.func(*parts) if parts else node

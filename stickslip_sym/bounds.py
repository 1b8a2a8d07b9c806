"""Bounds that are computed beside a formula: of its rounding error, and of its values over a range of speeds.

Both are expressions generated from the formula, so every law has them, and both are upper bounds: where
one is infinite, the formula is just not used.
"""

from typing import Any

import sympy as sp

__all__ = ["largest_size", "rounding_bound"]

_TINY = sp.Float(2.0**-1022)  # what underflow may lose, in units of machine epsilon


def rounding_bound(expr: Any) -> Any:
    """Return an expression for the rounding error of evaluating `expr` in float64, in units of machine epsilon.

    Inputs are exact, every operation and elementary function adds units of its result and what underflow
    may lose, and errors propagate to first order.
    """
    if expr.is_Symbol or expr.is_Integer:
        return sp.Integer(0)
    if expr.is_Atom:
        return abs(expr)
    bounds = [rounding_bound(argument) for argument in expr.args]
    if expr.is_Add:
        # The difference of two inputs has one rounding, however much it cancels.
        own = abs(expr) if len(expr.args) == 2 else sp.Add(*map(sp.Abs, expr.args))
        return own + sp.Add(*bounds)
    if expr.is_Mul:
        carried = [
            bound * sp.Mul(*[sp.Abs(other) for j, other in enumerate(expr.args) if j != i])
            for i, bound in enumerate(bounds)
        ]
        return len(expr.args) * sp.Abs(expr) + sp.Add(*carried) + _TINY
    if isinstance(expr, sp.Min | sp.Max):
        return sp.Add(*bounds)
    carried = [
        sp.Abs(_partial(expr, i)) * bound for i, bound in enumerate(bounds) if not _is_exact(expr.args[i], bound)
    ]
    underflow = _TINY * expr**2 if expr.is_Pow and expr.exp.could_extract_minus_sign() else _TINY
    return 2 * sp.Abs(expr) + sp.Add(*carried) + underflow


def _is_exact(argument: Any, bound: Any) -> bool:
    """Tell whether an argument carries no error: so does a small fraction, such as the order of a function."""
    return bound == 0 or bool(argument.is_Rational and argument.q <= 64)


def _partial(expr: Any, i: int) -> Any:
    dummies = [sp.Dummy(positive=True) for _ in expr.args]
    derivative = sp.diff(expr.func(*dummies), dummies[i])
    return derivative.xreplace(dict(zip(dummies, expr.args, strict=True)))


def largest_size(expr: Any, x: Any, high: Any) -> Any:
    """Return an upper bound of abs(expr) for x in [0, high]; infinite where none is found.

    Sizes of sums and products are bounded term by term, so the bound is cheap, and far from sharp.
    """
    if not expr.has(x):
        return sp.Abs(expr)
    if expr == x:
        return high
    if expr.is_Add:
        return sp.Add(*[largest_size(term, x, high) for term in expr.args])
    if expr.is_Mul:
        return sp.Mul(*[largest_size(factor, x, high) for factor in expr.args])
    if isinstance(expr, _AT_MOST_ONE):
        return sp.Integer(1)
    if isinstance(expr, sp.exp):
        exponent = expr.exp
        return sp.exp(0 if exponent.is_nonpositive else largest_size(exponent, x, high))
    if expr.is_Pow and not expr.exp.has(x):
        base, exponent = expr.args
        if exponent.is_nonnegative:
            return largest_size(base, x, high) ** exponent
        if exponent.is_negative and base.is_positive and _rises(base, x):
            return base.subs(x, 0) ** exponent
    return sp.oo


_AT_MOST_ONE = (sp.sin, sp.cos, sp.tanh, sp.sech, sp.erf)


def _rises(expr: Any, x: Any) -> bool:
    """Tell whether a sum is known not to fall with x >= 0."""
    return bool(sp.diff(expr, x).is_nonnegative)

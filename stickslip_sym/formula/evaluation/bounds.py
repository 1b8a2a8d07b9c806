"""Bounds of rounding errors, computed beside a formula.

A bound is an expression generated from the formula, so every law has it. It is an upper bound to first order:
where it is infinite, the formula is just not used.
"""

from collections.abc import Callable

import numpy as np
import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.lambdify import function_of

__all__ = ["rounding_bound", "slope_with_bound"]

_TINY = sp.Float(2.0**-1022)  # what underflow may lose, in units of machine epsilon


def rounding_bound(expr: Expr) -> Expr:
    """Return an expression for the rounding error of evaluating `expr` in float64, in units of machine epsilon.

    Inputs are exact, every operation adds half a unit of its result, a function two units, both what underflow may
    lose, and errors propagate to first order.
    """
    if expr.is_Symbol or expr.is_Integer:
        return sp.Integer(0)
    if expr.is_Atom:
        return abs(expr)
    if isinstance(expr, sp.Piecewise):
        return sp.Piecewise(*[(rounding_bound(branch), condition) for branch, condition in expr.args])
    bounds = [rounding_bound(argument) for argument in expr.args]
    if expr.is_Add:
        # The difference of two inputs has one rounding, however much it cancels.
        count = len(expr.args)
        own = _size(expr) if count == 2 else (count - 1) * sp.Add(*map(_size, expr.args))
        return own / 2 + sp.Add(*bounds)
    if expr.is_Mul:
        carried = [
            bound * sp.Mul(*[_size(other) for j, other in enumerate(expr.args) if j != i])
            for i, bound in enumerate(bounds)
        ]
        return (len(expr.args) - 1) * _size(expr) / 2 + sp.Add(*carried) + _TINY
    if isinstance(expr, sp.Min | sp.Max):
        return sp.Add(*bounds)
    carried = [
        _size(_partial(expr, i)) * bound for i, bound in enumerate(bounds) if not _is_exact(expr.args[i], bound)
    ]
    underflow = _TINY * (1 + expr**2) if expr.is_Pow and expr.exp.could_extract_minus_sign() else _TINY
    # A reciprocal, a square and a square root are rounded once; of other functions libraries promise less.
    own = sp.Rational(1, 2) if expr.is_Pow and expr.exp in (-1, 2, sp.Rational(1, 2)) else 2
    return own * _size(expr) + sp.Add(*carried) + underflow


def _size(expr: Expr) -> Expr:
    """Return abs(expr), as it stands: SymPy would look at length for a sign that is not needed."""
    return sp.Abs(expr, evaluate=False)


def _is_exact(argument: Expr, bound: Expr) -> bool:
    """Tell whether an argument carries no error: so does a small fraction, such as the order of a function."""
    return bound == 0 or bool(argument.is_Rational and argument.q <= 64)


def _partial(expr: Expr, i: int) -> Expr:
    dummies = [sp.Dummy(positive=True) for _ in expr.args]
    derivative = sp.diff(expr.func(*dummies), dummies[i])
    return derivative.xreplace(dict(zip(dummies, expr.args, strict=True)))


def slope_with_bound(slope: Expr, arguments: list[Expr]) -> Callable[..., tuple[Expr, Expr]]:
    """Compile a slope, and the bound of its rounding error in machine epsilons."""
    compiled = function_of(arguments, [slope, rounding_bound(slope)], "numpy")

    def guarded(*columns: Expr) -> tuple[Expr, Expr]:
        try:
            value, bound = compiled(*columns)
        except TypeError:
            # Some functions of SciPy know double precision only; the bound then counts in its epsilon.
            value, bound = compiled(*(np.asarray(column, dtype=np.float64) for column in columns))
            bound = bound * (np.finfo(np.float64).eps / np.finfo(columns[0].dtype).eps)
        return value, bound

    return guarded

"""A closed form as a NumPy function that knows its own rounding error.

Beside each formula a first-order bound of its rounding error is generated from the expression
(a running error analysis) and computed with it. A value is returned only where that bound is small:

1. the closed form itself, good where its terms do not cancel;
2. the expansion of the slope average around v = V, from the law's own derivatives, good for small V;
3. arbitrary precision for what is left: slow, and always right.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
import sympy as sp

from stickslip_sym import symbols
from stickslip_sym.codegen import function_of
from stickslip_sym.criteria import Criterion
from stickslip_sym.errors import InputError, NotConverged

__all__ = ["StableFunction", "exact_value"]

ACCEPTED = 1e-13
"""Relative rounding error up to which a float64 formula is used."""

_MOST_TERMS = 12  # of the expansion; its last term bounds what is left out
_MOST_DIGITS = 20_000  # of working precision, before a value counts as out of reach


def rounding_bound(expr: Any) -> Any:
    """Return an expression for the rounding error of evaluating `expr`, in units of machine epsilon.

    Inputs are exact, every operation and elementary function adds one unit of its result, and errors
    propagate to first order.
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
        return len(expr.args) * sp.Abs(expr) + sp.Add(*carried)
    slopes = [sp.Abs(_partial(expr, i)) for i in range(len(expr.args))]
    return 2 * sp.Abs(expr) + sp.Add(*[slope * bound for slope, bound in zip(slopes, bounds, strict=True)])


def _partial(expr: Any, i: int) -> Any:
    dummies = [sp.Dummy(positive=True) for _ in expr.args]
    derivative = sp.diff(expr.func(*dummies), dummies[i])
    return derivative.xreplace(dict(zip(dummies, expr.args, strict=True)))


def expansion(slope: Any, criterion: Criterion) -> tuple[Any, Any]:
    """Expand the slope average around v = V; return its sum and the size of its last term (0 if exact).

    c = -N sum_j mu^(2j+1)(V) V^2j <s^2j>_w / (2j)!
    """
    s, V, N = symbols.s, symbols.V, symbols.N
    derivative = slope.subs(symbols.v, V)
    terms = []
    for j in range(_MOST_TERMS):
        moment = sp.integrate(sp.expand(criterion.weight * s ** (2 * j)), (s, -1, 1))
        terms.append(-N * derivative * V ** (2 * j) * moment / sp.factorial(2 * j))
        derivative = sp.factor_terms(sp.diff(derivative, V, 2))
        if derivative == 0:
            return sp.Add(*terms), sp.Integer(0)
    return sp.Add(*terms), sp.Abs(terms[-1])


def to_digits(expr: Any, digits: int) -> Any:
    """Evaluate an expression without symbols to `digits` significant digits, whatever it cancels.

    Raises
    ------
    NotConverged
        If 20 000 digits of working precision do not settle it.
    """
    # Hyperbolic functions of a large argument hide the error of the argument from SymPy's evalf.
    number = expr.rewrite((sp.sinh, sp.cosh, sp.tanh), sp.exp)
    try:
        value = sp.expand(number).evalf(digits + 3, maxn=_MOST_DIGITS, strict=True)
    except sp.core.evalf.PrecisionExhausted:
        raise NotConverged(f"{digits} digits of {expr} are out of reach of {_MOST_DIGITS} digits") from None
    if not value.is_Float and not value.is_Rational:
        raise InputError(f"the closed form has no finite value at these parameters: it gives {value}")
    with mpmath.workdps(digits):
        return mpmath.mpf(value._mpf_ if value.is_Float else (sp.Float(value, digits + 3))._mpf_)


def exact_value(expr: Any, slope: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate a closed form at exact values to `digits` digits; at V = 0 by its limit -N mu'(0+)."""
    if point[symbols.V] == 0:
        expr = -symbols.N * sp.limit(slope, symbols.v, 0, "+")
    return to_digits(expr.xreplace(dict(point)), digits)


@dataclass(frozen=True)
class _Candidate:
    """A formula compiled together with the bound of its error."""

    function: Any

    @classmethod
    def compile(cls, arguments: Sequence[Any], formula: Any, truncation: Any = 0) -> "_Candidate":
        epsilon = sp.Float(np.finfo(np.float64).eps)
        error = epsilon * rounding_bound(formula) + truncation
        return cls(function_of(arguments, [formula, error], "numpy"))

    def __call__(self, columns: list[Any]) -> tuple[Any, Any]:
        """Return the values, and where they are good."""
        with np.errstate(all="ignore"):  # what overflows here is not accepted below
            value, error = (np.broadcast_to(part, columns[0].shape) for part in self.function(*columns))
            return value, np.isfinite(value) & (error <= ACCEPTED * np.abs(value))


class StableFunction:
    """A closed form over arrays.

    Parameters
    ----------
    expr : sympy.Expr
        The closed form.
    slope : sympy.Expr
        The slope of the law it came from, for small V.
    criterion : Criterion
    arguments : sequence of Symbol
        In the order of the columns that `__call__` takes.
    """

    def __init__(self, expr: Any, slope: Any, criterion: Criterion, arguments: Sequence[Any]) -> None:
        self.arguments = list(arguments)
        self.expr = expr
        self.slope = slope
        self._candidates = [_Candidate.compile(self.arguments, expr)]
        if criterion.weight is not None:
            formula, last = expansion(slope, criterion)
            self._candidates.append(_Candidate.compile(self.arguments, formula, last))

    def __call__(self, columns: Sequence[Any]) -> Any:
        """Evaluate at flat float64 arrays of one length, one for each argument."""
        result = np.full(columns[0].shape, np.nan)
        open_ = np.arange(result.size)
        for candidate in self._candidates:
            value, good = candidate([column[open_] for column in columns])
            result[open_[good]] = value[good]
            open_ = open_[~good]
            if not open_.size:
                return result
        for i in open_:
            point = {a: sp.Rational(float(column[i])) for a, column in zip(self.arguments, columns, strict=True)}
            result[i] = float(exact_value(self.expr, self.slope, point, 17))
        return result

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

import numpy as np
import sympy as sp

from stickslip_sym import symbols
from stickslip_sym.bounds import largest_size, rounding_bound
from stickslip_sym.codegen import function_of
from stickslip_sym.criteria import Criterion
from stickslip_sym.errors import InputError
from stickslip_sym.exact import to_digits

__all__ = ["StableFunction", "exact_value"]

ACCEPTED = 1e-13
"""Relative rounding error up to which a float64 formula is used."""

_MOST_TERMS = 12  # of the expansion
_LARGEST_DERIVATIVE = 200  # operations of a derivative that is still used in it


def expansion(slope: Any, criterion: Criterion) -> tuple[Any, Any] | None:
    """Expand the slope average around v = V; return the sum and a bound of what it leaves out, or None.

        c = -N sum_j mu^(2j+1)(V) V^2j <s^2j>_w / (2j)!

    The bound is the next term with its derivative at the worst place in [0, 2V]. Only that sees a layer near
    v = 0 that is too thin to show in the derivatives at V.
    """
    v, V, N = symbols.v, symbols.V, symbols.N
    if slope.has(sp.Piecewise):
        return None
    derivative: Any = slope
    terms: list[Any] = []
    for j in range(_MOST_TERMS + 1):
        moment = criterion.even_moment(j) / sp.factorial(2 * j)
        if derivative == 0:
            return sp.Add(*terms), sp.Integer(0)
        if j == _MOST_TERMS or derivative.count_ops() > _LARGEST_DERIVATIVE:
            worst = largest_size(derivative, v, 2 * V)
            return None if worst.has(sp.oo) else (sp.Add(*terms), N * V ** (2 * j) * moment * worst)
        terms.append(-N * derivative.subs(v, V) * V ** (2 * j) * moment)
        derivative = sp.factor_terms(sp.diff(derivative, v, 2))
    raise AssertionError("the loop returns")


def exact_value(expr: Any, slope: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate a closed form at exact values to `digits` digits; at V = 0 by its limit -N mu'(0+)."""
    if point[symbols.V] == 0:
        expr = -symbols.N * sp.limit(slope, symbols.v, 0, "+")
        if expr.is_infinite:
            raise InputError("the slope of mu is infinite at v = 0, so the criterion has no value at V = 0")
    return to_digits(expr, point, digits)


@dataclass(frozen=True)
class _Candidate:
    """A formula compiled together with the bound of its error."""

    function: Any

    @classmethod
    def compile(cls, arguments: Sequence[Any], formula: Any, error: Any, truncation: Any) -> "_Candidate":
        epsilon = sp.Float(np.finfo(np.float64).eps)
        return cls(function_of(arguments, [formula, epsilon * error + truncation], "numpy"))

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
        self._candidates = _candidates(self.arguments, expr)
        expanded = expansion(slope, criterion) if criterion.weight is not None else None
        if expanded is not None:
            self._candidates += _candidates(self.arguments, *expanded)

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
        if not np.isfinite(result).all():
            raise InputError("the damping coefficient is beyond the range of float64; use evaluate(digits=...)")
        return result


_IN_NUMPY = (
    sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.asinh, sp.acos, sp.atan,
    sp.erf, sp.besseli, sp.besselj, sp.lowergamma, sp.gamma, sp.Abs, sp.Min, sp.Max, sp.Piecewise, sp.sign,
)  # fmt: skip
"""The functions that NumPy and SciPy have. A form with others is evaluated in arbitrary precision."""


def _candidates(arguments: Sequence[Any], formula: Any, truncation: Any = 0) -> list[_Candidate]:
    """Compile a formula, if NumPy and SciPy have all its functions and its rounding error is known."""
    try:
        error = rounding_bound(formula)
    except (sp.core.function.ArgumentIndexError, ValueError, TypeError):
        return []  # no derivative with respect to the order of a special function
    functions = (formula + error + truncation).atoms(
        sp.Function, sp.Min, sp.Max, sp.meijerg, sp.Subs, sp.Derivative
    )
    if not all(isinstance(function, _IN_NUMPY) for function in functions):
        return []
    return [_Candidate.compile(arguments, formula, error, truncation)]

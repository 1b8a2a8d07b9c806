"""Formulas at exact values, to any number of digits."""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import mpmath
import sympy as sp

from stickslip_sym.codegen import function_of
from stickslip_sym.errors import InputError, NotConverged
from stickslip_sym.values import to_mpf

__all__ = ["to_digits"]

_GUARD = 15
_MOST_DIGITS = 10_000  # of working precision, before a value counts as out of reach
_LOST = 8  # powers of the largest or smallest input that may cancel


def to_digits(expr: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate an expression at exact rational values to `digits` significant digits, whatever it cancels.

    The working precision doubles until two results agree. It starts beyond what powers of the inputs can
    cancel: two results may agree and both miss a term like 1 - exp(-V) that has rounded to 0. A zero is
    believed only where an input, or a difference of inputs, is exactly 0, or where the arithmetic of rationals
    gives it: everywhere else it is a sign that all digits cancelled.

    Raises
    ------
    InputError
        Where the formula divides by zero or is not real.
    NotConverged
        If the bound on the working precision does not settle it.
    """
    if not expr.atoms(sp.Function) - expr.atoms(*_PIECES):
        value = _by_pieces(expr, point)
        if value is not None:
            with mpmath.workdps(digits):
                return to_mpf(value)
    arguments = tuple(symbol for symbol in point if expr.has(symbol))
    function, sums = _compiled(expr, arguments)
    values = [point[symbol] for symbol in arguments] + [node.xreplace(dict(point)) for node in sums]
    before = None
    precision = digits + _GUARD + _LOST * max((_decades(value) for value in values), default=0)
    while precision <= _MOST_DIGITS:
        with mpmath.workdps(precision):
            result = _call(function, [to_mpf(value) for value in values], point)
            settled = before is not None and abs(result - before) <= abs(result) * mpmath.mpf(10) ** -(digits + 1)
            if settled and (result != 0 or not arguments or any(value == 0 for value in values)):
                break
        if before is not None and (value := _by_pieces(expr, point)) is not None:
            result = to_mpf(value)
            break
        before, precision = result, 2 * precision
    else:
        value = expr.xreplace(dict(point))
        if not value.is_Rational:
            raise NotConverged(f"{digits} digits are out of reach of {_MOST_DIGITS} digits of working precision")
        result = to_mpf(value)  # a sum of rationals that cancels for good
    with mpmath.workdps(digits):
        return +result


_PIECES = (sp.Min, sp.Max, sp.Piecewise)


def _by_pieces(expr: Any, point: Mapping[Any, Any]) -> Any | None:
    """Return the exact value of an expression in pieces, if those that apply make it a rational number."""
    nodes = expr.atoms(*_PIECES)
    if not nodes:
        return None
    exact = expr.xreplace({node: node.xreplace(dict(point)) for node in nodes}).xreplace(dict(point))
    return exact if exact.is_Rational else None


def _decades(value: Any) -> int:
    """Return the size of the decimal exponent of a rational."""
    return int(abs(int(value.p).bit_length() - int(value.q).bit_length()) * math.log10(2)) if value else 0


@lru_cache(maxsize=128)
def _compiled(expr: Any, arguments: tuple[Any, ...]) -> tuple[Callable[..., Any], tuple[Any, ...]]:
    """Compile an expression with its sums of inputs as arguments of their own, to be computed exactly."""
    sums = tuple(sp.ordered(node for node in expr.atoms(sp.Add) if _is_sum_of_inputs(node)))
    names = {node: sp.Dummy("sum") for node in sums}
    return function_of([*arguments, *names.values()], expr.xreplace(names), "mpmath"), sums


def _is_sum_of_inputs(node: Any) -> bool:
    return all(
        term.is_Symbol
        or term.is_Rational
        or (term.is_Mul and len(term.args) == 2 and term.args[0].is_Rational and term.args[1].is_Symbol)
        for term in node.args
    )


def _call(function: Callable[..., Any], values: list[Any], point: Mapping[Any, Any]) -> Any:
    try:
        result = mpmath.mpmathify(function(*values))
    except (ZeroDivisionError, ValueError):
        result = mpmath.nan
    except mpmath.NoConvergence as error:
        raise NotConverged(f"a special function of the closed form could not be evaluated: {error}") from None
    if isinstance(result, mpmath.mpc) and result.imag == 0:
        result = result.real
    if isinstance(result, mpmath.mpc) or not mpmath.isfinite(result):
        zeros = ", ".join(f"{symbol} = 0" for symbol, value in point.items() if value == 0)
        hint = f": it divides by zero at {zeros}; take a small value, or use quadrature.damping" if zeros else ""
        raise InputError(f"the closed form has no finite real value at these parameters{hint}")
    return result

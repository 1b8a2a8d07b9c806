"""Formulas at exact values, to any number of digits."""

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any

import mpmath
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import to_mpf
from stickslip_sym.formula.evaluation.bounded import Bounded, Uncertain, bounded
from stickslip_sym.formula.evaluation.conditioning import without_squares

__all__ = ["exact_value", "to_digits"]

_GUARD = 15
_MOST_DIGITS = 10_000  # of working precision, before a value counts as out of reach
_ELEMENTARY = (sp.exp, sp.log, sp.sin, sp.cos, sp.tan, sp.sinh, sp.cosh, sp.tanh, sp.sech, sp.asinh, sp.atan,
               sp.Abs, sp.Min, sp.Max, sp.Piecewise)  # fmt: skip
"""Functions that mpmath rounds to the last digits; of others a second look at more digits is taken."""


def to_digits(expr: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate an expression at exact rational values to `digits` significant digits, whatever it cancels.

    The working precision rises until the bound of the rounding error is small beside the value. A zero is
    believed only where the arithmetic of rationals gives it: everywhere else all digits cancelled.

    Raises
    ------
    InputError
        Where the formula divides by zero or is not real.
    NotConverged
        If the bound on the working precision does not settle it.
    """
    known = {
        symbol: Bounded(Fraction(int(value.p), int(value.q)), mpmath.mpf(0)) for symbol, value in point.items()
    }
    special = bool(expr.atoms(sp.Function) - expr.atoms(*_ELEMENTARY))
    precision = digits + _GUARD
    before: Any = None
    first = True
    while precision <= _MOST_DIGITS:
        with mpmath.workdps(precision):
            value, error, lost = _at(expr, known, point)
            if isinstance(value, Fraction):
                before = mpmath.mpf(value.numerator) / value.denominator
                break
            if lost is None:
                allowed = abs(value) * mpmath.mpf(10) ** -(digits + 1)
                enough = error <= allowed
                settled = enough and (not special or (before is not None and abs(value - before) <= allowed))
                before = value if enough else None
                if settled:
                    break
                missing = 0 if enough else _missing(value, error, digits)
            else:
                missing = precision
        if not first and (missing or lost) and (exact := expr.xreplace(dict(point))).is_Rational:
            # A sum of what is the same that cancels for good.
            before = mpmath.mpf(int(exact.p)) / int(exact.q)
            break
        first = False
        precision += max(missing + 5, precision // 4)
    else:
        raise NotConverged(f"{digits} digits are out of reach of {_MOST_DIGITS} digits of working precision")
    with mpmath.workdps(digits):
        return +before


def _missing(value: Any, error: Any, digits: int) -> int:
    """Return the digits that are missing in a value, or how many to add where it may be 0."""
    if abs(value) <= error:
        return int(mpmath.mp.dps)
    return max(0, math.ceil(digits + 1 + int(mpmath.mag(error) - mpmath.mag(value) + 1) * math.log10(2)))


def _at(expr: Any, known: Mapping[Any, Bounded], point: Mapping[Any, Any]) -> tuple[Any, Any, str | None]:
    """Return a value, its error bound, and what hid it."""
    try:
        value, error = bounded(expr, known)
    except Uncertain as hidden:
        return mpmath.nan, mpmath.inf, str(hidden)
    except (ZeroDivisionError, ValueError, OverflowError):
        raise _no_value(point) from None
    except mpmath.mp.NoConvergence as failure:
        raise NotConverged(f"a special function of the closed form could not be evaluated: {failure}") from None
    if isinstance(value, mpmath.mpc):
        if abs(value.imag) > error:
            raise _no_value(point)
        value = value.real
    return value, error, None


def _no_value(point: Mapping[Any, Any]) -> InputError:
    zeros = ", ".join(f"{symbol} = 0" for symbol, value in point.items() if value == 0)
    hint = f": it divides by zero at {zeros}; take a small value, or use quadrature.damping" if zeros else ""
    return InputError(f"the closed form has no finite real value at these parameters{hint}")


def exact_value(expr: Any, slope: Any, point: Mapping[Any, Any], digits: int) -> Any:
    """Evaluate a closed form at exact values to `digits` digits; at V = 0 by its limit -N mu'(0+)."""
    if point[symbols.V] == 0:
        at_rest = _slope_at_rest(slope)
        if at_rest is None:
            return -to_mpf(point[symbols.N]) * _numeric_slope_at_rest(slope, point)
        expr = -symbols.N * at_rest
        if expr.is_infinite:
            raise InputError(_INFINITE)
    return to_digits(_uncancelled(expr), point, digits)


_INFINITE = "the slope of mu is infinite at v = 0, so the criterion has no value at V = 0"


@lru_cache(maxsize=128)
def _slope_at_rest(slope: Any) -> Any:
    """Return the limit of a slope at v = 0+; None where SymPy finds none, as for exponents without a value."""
    try:
        return sp.limit(slope, symbols.v, 0, "+")
    except (TypeError, ValueError, NotImplementedError):  # as SymPy says that it finds none
        return None


def _numeric_slope_at_rest(slope: Any, point: Mapping[Any, Any]) -> Any:
    """Return the limit of a slope at v = 0+ from two speeds that are next to nothing."""
    near, nearer = (to_digits(slope, {**point, symbols.v: sp.Rational(1, 10**k)}, 20) for k in (100, 200))
    if abs(nearer) < abs(near) / 2:
        return 0 * nearer
    if abs(nearer - near) > abs(near) * 1e-12:
        raise InputError(_INFINITE)
    return nearer


_uncancelled = lru_cache(maxsize=128)(without_squares)

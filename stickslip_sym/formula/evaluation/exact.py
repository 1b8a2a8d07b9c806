"""Formulas at exact values, to any number of digits."""

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import mpmath
import sympy as sp

from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.formula.evaluation.bounded import Bounded, Uncertain, bounded

__all__ = ["to_digits"]

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

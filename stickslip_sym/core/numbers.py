"""Numbers as users give them, read exactly.

A float is the binary number that it is; text such as "0.3" is the decimal that it says, and "300 mm/s" too.
Fifty digits of a result mean something only if the input is known to fifty digits too. What is computed in
double precision is read by `real` and `read_array`.
"""

import math
import re
import sys
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from operator import truediv
from types import UnionType
from typing import TYPE_CHECKING, SupportsFloat, TypeVar

import mpmath
import numpy as np
import sympy as sp
from mpmath.libmp import from_rational, to_rational

from stickslip_sym.core.aliases import Expr, FloatArray, Mpf, Rational
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Name
from stickslip_sym.core.units import has_error, si_number, strip_unit, unknown_unit

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

T = TypeVar("T")
Number = int | float | str | Fraction | Decimal | SupportsFloat

EPSILON = sys.float_info.epsilon
"""From 1 to the next double."""
DOUBLE_BITS = sys.float_info.mant_dig
"""Bits of a double."""
DOUBLE_DIGITS = sys.float_info.dig + 2
"""Decimal digits that tell any two doubles apart."""
NEGLIGIBLE = 2.0**-66
"""Of a value: what doubles do not see."""
LARGEST = NEGLIGIBLE / sys.float_info.min
"""Short of overflow. Its inverse is as good as 0: what is negligible beside that still has all digits."""
SEED = 20160428
"""Of all random numbers: who asks twice gets the same answer."""
ROUNDING = 1e-14
"""What a sum of some hundred terms in doubles is off by, over its largest."""
LEAST_RTOL = 10 * ROUNDING
"""The least relative error that is promised of what is computed in doubles: there is a digit beyond it."""
SAME = 1e-12
"""Relative distance of two numbers that stand for one: it is more than the rounding of a handful of operations."""
ROOT_OF_ROUNDING = EPSILON**0.5
"""Root of the rounding of a double: relative size of what may be told apart where squares or differences count."""
NEXT_TO_ZERO = LARGEST ** (-1 / 3)  # in place of 0: its third power, and one over that, are numbers
_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?")
NUMBER_BITS = 4000
"""Of a number that is no rational one, or of the longer part of a fraction: beyond the digits of any answer."""
MOST_NUMBER_CHARACTERS = 400
"""Characters of a number as it is written; enough for any decimal that has a meaning here."""


def exact(value: Number, name: str) -> Rational:
    """Return a number of any library, or text, as the SymPy rational it denotes; `name` is for messages."""
    number = fraction(value, name)
    return sp.Rational(number.numerator, number.denominator)


def fraction(value: Number, name: str) -> Fraction:
    """Return a number as the fraction it denotes: floats are binary, text is a decimal or a ratio like "1/3"."""
    if isinstance(value, str):
        return _read_fraction(value, name)
    value = strip_unit(value, name)
    try:
        if hasattr(value, "_mpf_") and mpmath.isfinite(mpmath.make_mpf(value._mpf_)):  # of any context, or SymPy's
            return Fraction(*map(int, to_rational(value._mpf_)))
        if isinstance(value, sp.Rational):
            return Fraction(int(value.p), int(value.q))
        if isinstance(value, bool | sp.Basic) or hasattr(value, "__len__"):
            raise TypeError
        return Fraction(value if isinstance(value, int | Fraction | Decimal) else float(value))
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            Name(name), f" = {value!r} is not a finite real number; give a number such as 0.5 or '0.5'"
        ) from None


def binary_fraction(number: float) -> Rational:
    """Return a float as the rational that it is; `sympy.Rational` would round it to mpmath's precision."""
    return sp.Rational(*float(number).as_integer_ratio())


_TURNS_A_MINUTE = {"rpm", "rev/min", "r/min", "1/min", "u/min"}
_ROTATION = (
    ": n turns a minute on a track of radius r are a slip speed of 2 pi r n/60, such as 0.094 m/s for 30 at 30 mm"
)


def _read_fraction(text: str, name: str) -> Fraction:
    text = si_number(text, name)
    parts = text.strip().split("/")
    if len(text) <= MOST_NUMBER_CHARACTERS and len(parts) <= 2 and all(map(_DECIMAL.fullmatch, parts)):
        with suppress(ZeroDivisionError):
            return reduce(truediv, map(Fraction, parts))
    _refuse_error(text, name)
    if (unit := unknown_unit(text)) is not None:
        turning = _ROTATION if unit.casefold() in _TURNS_A_MINUTE else ""
        raise InputError(
            Name(name), f" = {text.strip()[:60]!r} has the unit {unit!r}, which is not known here{turning}"
        )
    raise InputError(Name(name), f" = {text[:60]!r} is not a number; write it like 0.5, 5e-1 or 1/2")


def _refuse_error(text: str, name: str) -> None:
    """Refuse a number with a standard error, where only a plain one is used."""
    if has_error(text):
        raise InputError(
            Name(name),
            f" = {text.strip()[:60]!r} has a standard error, and none is used here; give the number alone",
        )


def real(name: str, value: Number) -> float:
    """Return a number as a float, or refuse what is none and what is not finite."""
    bare = fraction(value, name) if isinstance(value, str) else strip_unit(value, name)
    try:
        number = float(bare)
    except (TypeError, ValueError, OverflowError):
        _refuse_error(str(value), name)
        raise InputError(Name(name), f" = {str(value)[:60]!r} is not a number; give a float such as 0.5") from None
    if not math.isfinite(number):
        raise InputError(Name(name), f" = {number} is not finite; give a float such as 0.5")
    return number


def require_type(name: str, value: object, required: type | UnionType, what: str) -> None:
    """Refuse an argument that is not of the required type."""
    if not isinstance(value, required):
        raise InputError(Name(name), f" is {what}, got {type(value).__name__}: {value!r:.60}")


def read_array(name: str, value: "ArrayLike", *, finite: bool = True) -> FloatArray:
    """Return a number or numbers as an array of real ones, itself where it is one; NaN is refused if `finite`.

    Text such as "500 mm/s" and quantities of pint or astropy are converted; masked values are refused.
    """
    if isinstance(value, str):
        return np.asarray(real(name, value))
    value = strip_unit(value, name)
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise InputError(Name(name), " holds masked values; leave them out first")
    if isinstance(value, list | tuple) and any(hasattr(item, "unit") or hasattr(item, "units") for item in value):
        value = [strip_unit(item, name) for item in value]
    try:
        array = np.asarray(value)
        if array.dtype.kind in "mM" or (array.dtype.kind == "O" and any(item is None for item in array.flat)):
            raise TypeError
        if array.dtype.kind not in "fiub":
            array = array.astype(np.float64, casting="safe" if array.dtype.kind == "c" else "unsafe")
    except (TypeError, ValueError, OverflowError):
        shown = "an integer beyond float64" if isinstance(value, int) else repr(value)[:60]
        raise InputError(Name(name), f" = {shown} is not a number or an array of numbers; try 0.5") from None
    if finite and not np.isfinite(array).all():
        bad = array[~np.isfinite(array)].flat[0]
        raise InputError(Name(name), f" holds a value that is not finite: {bad}; give a float such as 0.5")
    return array


def read_rtol(rtol: Number, *, least: float = LEAST_RTOL, most: float = 1e-3) -> float:
    """Return a tolerance as a float, or refuse one that double precision cannot hold, or that means nothing."""
    number = real("rtol", rtol)
    if not least <= number <= most:
        raise InputError(Name("rtol"), f" = {number:g} is outside {least:g} to {most:g}")
    return number


def to_mpf(number: Expr, context: mpmath.MPContext = mpmath.mp) -> Mpf:
    """Round a SymPy number to the working precision of a context of mpmath."""
    if number.is_Float:
        return +context.make_mpf(number._mpf_)
    return context.make_mpf(from_rational(int(number.p), int(number.q), *context._prec_rounding))


def bits(rational: Expr) -> int:
    """Return the length in bits of the longer of a rational's numerator and denominator."""
    return max(int(rational.p).bit_length(), int(rational.q).bit_length())


def is_within(constant: Expr, limit: int) -> bool:
    """Return whether a constant expression is real and at most `limit` in size."""
    value = constant.evalf(5)
    return bool(value.is_Number and abs(value) <= limit)

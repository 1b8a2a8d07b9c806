"""Numbers as users give them, read exactly.

A float is the binary number that it is; text such as "0.3" is the decimal that it says.
Fifty digits of a result mean something only if the input is known to fifty digits too. What is computed in
double precision is read by `real` and `read_array`.
"""

import math
import re
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, SupportsFloat, TypeVar

import sympy as sp

from stickslip_sym.core.aliases import Expr, FloatArray, Mpf
from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = [
    "Number", "bits", "exact", "fraction", "fractions_of", "lookup", "read_array", "read_rtol", "real",
    "suggestion", "to_mpf", "within",
]  # fmt: skip

T = TypeVar("T")
Number = int | float | str | Fraction | Decimal | SupportsFloat

_DECIMAL = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,4})?")
_LONGEST = 400  # characters of a number; enough for any decimal that has a meaning here


def exact(value: Number, name: str) -> Expr:
    """Return `value` as the exact SymPy rational it denotes.

    Parameters
    ----------
    value : int, float, numpy scalar, Fraction, Decimal, mpmath.mpf, sympy number or decimal text
        Floats are taken as exact binary numbers, text as an exact decimal or a ratio like "1/3".
    name : str
        What the number is, for the message.

    Raises
    ------
    InputError
        If it is no finite real number.
    """
    number = fraction(value, name)
    return sp.Rational(number.numerator, number.denominator)


def fraction(value: Number, name: str) -> Fraction:
    """Return `value` as the exact fraction it denotes, as `exact` does, without SymPy but for its own numbers.

    Raises
    ------
    InputError
        If it is no finite real number.
    """
    if isinstance(value, str):
        return _from_text(value, name)
    finite = not isinstance(value, float | Decimal) or math.isfinite(value)
    if isinstance(value, int | float | Fraction | Decimal) and not isinstance(value, bool) and finite:
        return Fraction(value)
    number = None if isinstance(value, int | float | Fraction | Decimal) else _from_a_library(value)
    if number is None:
        raise InputError(f"{name} = {value!r} is not a finite real number; give a number such as 0.5 or '0.5'")
    return number


def _from_a_library(value: SupportsFloat) -> Fraction | None:
    """Return a number of SymPy, mpmath, NumPy or others as a fraction; None if it is no finite real one."""
    import mpmath

    if isinstance(value, sp.Expr):
        if not (value.is_Rational or value.is_Float):
            return None
        rational = sp.Rational(value)
        return Fraction(int(rational.p), int(rational.q))
    if isinstance(value, mpmath.mpf):
        if not mpmath.isfinite(value):
            return None
        sign, mantissa, exponent, _ = value._mpf_
        return Fraction((-1) ** sign * int(mantissa)) * Fraction(2) ** int(exponent)
    if hasattr(value, "__float__") and not hasattr(value, "__len__") and math.isfinite(as_float := float(value)):
        return Fraction(as_float)
    return None


def real(name: str, value: Number) -> float:
    """Return a number as a float, or refuse what is none and what is not finite."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {str(value)[:60]!r} is not a number; give a float such as 0.5") from None
    if not math.isfinite(number):
        raise InputError(f"{name} = {number} is not finite; give a float such as 0.5")
    return number


def read_array(name: str, value: "ArrayLike", *, finite: bool = True) -> FloatArray:
    """Return a number or numbers as an array of real numbers, as it is where it is one.

    Parameters
    ----------
    name : str
        What they are, for the message.
    value : array_like
    finite : bool
        Whether to refuse NaN and infinity.

    Raises
    ------
    InputError
    """
    import numpy as np

    try:
        array = np.asarray(value)
        if array.dtype.kind in "mM" or (array.dtype.kind == "O" and any(item is None for item in array.flat)):
            raise TypeError
        if array.dtype.kind not in "fiub":
            array = array.astype(np.float64, casting="safe" if array.dtype.kind == "c" else "unsafe")
    except (TypeError, ValueError, OverflowError):
        shown = "an integer beyond float64" if isinstance(value, int) else repr(value)[:60]
        raise InputError(f"{name} = {shown} is not a number or an array of numbers; try 0.5") from None
    if finite and not np.isfinite(array).all():
        bad = array[~np.isfinite(array)].flat[0]
        raise InputError(f"{name} holds a value that is not finite: {bad}; give a float such as 0.5")
    return array


def read_rtol(rtol: Number, *, least: float = 1e-13, most: float = 1e-3) -> float:
    """Return a tolerance as a float, or refuse one that double precision cannot hold, or that means nothing."""
    number = real("rtol", rtol)
    if not least <= number <= most:
        raise InputError(f"rtol = {number:g} is outside {least:g} to {most:g}")
    return number


def _from_text(text: str, name: str) -> Fraction:
    parts = text.strip().split("/")
    if len(text) <= _LONGEST and len(parts) <= 2 and all(_DECIMAL.fullmatch(part) for part in parts):
        numerator, *rest = (Fraction(part) for part in parts)
        if not rest:
            return numerator
        if rest[0] != 0:
            return numerator / rest[0]
    raise InputError(f"{name} = {text[:60]!r} is not a number; write it like 0.5, 5e-1 or 1/2")


def to_mpf(number: Expr) -> Mpf:
    """Round a SymPy number to the current working precision of mpmath."""
    import mpmath

    if number.is_Float:
        return +mpmath.make_mpf(number._mpf_)
    return mpmath.mpf(int(number.p)) / int(number.q)


def bits(rational: Expr) -> int:
    """Return the length in bits of the longer of a rational's numerator and denominator."""
    return max(int(rational.p).bit_length(), int(rational.q).bit_length())


def within(constant: Expr, limit: int) -> bool:
    """Return whether a constant expression is real and at most `limit` in size."""
    value = constant.evalf(5)
    return bool(value.is_Number and abs(value) <= limit)


def fractions_of(values: Mapping[str, Number]) -> dict[str, Fraction]:
    """Read a mapping of names to numbers exactly."""
    return {name: fraction(value, name) for name, value in values.items()}


def lookup(kind: str, name: str, table: Mapping[str, T]) -> T:
    """Return the entry of a table, or raise an `InputError` that suggests the closest name."""
    if isinstance(name, str) and name in table:
        return table[name]
    known = ", ".join(table)
    raise InputError(f"there is no {kind} {str(name)[:60]!r}{suggestion(str(name), table)}; known: {known}")


def suggestion(wrong: str, known: Mapping[str, object] | list[str]) -> str:
    """Return ' (did you mean ...?)' when a known name is close to the wrong one, else an empty text."""
    from difflib import get_close_matches

    close = get_close_matches(wrong, list(known), n=1, cutoff=0.6)
    return f" (did you mean {close[0]!r}?)" if close else ""

"""Products of powers of floats that over- or underflow only where their value does."""

import math
import operator
from collections.abc import Sequence
from functools import reduce
from typing import TypeVar

import numpy as np

from stickslip_sym.core.aliases import FloatArray, Numbers

__all__ = ["extremes", "largest_exponent", "multiply_by_power", "plain_product", "scaled_product"]

R = TypeVar("R", float, FloatArray)
_MOST_FACTORS = 8
_LARGEST = 4000  # binary exponents beyond this are clipped: the value is 0 or infinite


def extremes(value: Numbers) -> tuple[float, float]:
    """Return the smallest and the largest of an array's elements, or a float twice."""
    return (value, value) if isinstance(value, float) else (float(value.min()), float(value.max()))


def largest_exponent(low: float, high: float) -> float:
    """Return the largest size of the binary exponent of numbers between two; infinite for a 0."""
    if low < 0:
        low, high = (-high, -low) if high < 0 else (0.0, high)
    if not (low > 0 and high < math.inf):
        return math.inf
    return max(abs(math.log2(low)), abs(math.log2(high)))


def plain_product(number: float, factors: Sequence[tuple[Numbers, float]]) -> Numbers:
    """Multiply powers of floats and arrays; first all floats, then the arrays."""
    arrays = []
    for value, exponent in factors:
        if isinstance(value, float):
            number *= _power(value, exponent)
        else:
            arrays.append((value, exponent))
    result: Numbers = number
    denominator: Numbers | None = None
    for value, exponent in arrays:
        if exponent > 0:
            result = result * _power(value, exponent)
        else:
            power = _power(value, -exponent)
            denominator = power if denominator is None else denominator * power
    return result if denominator is None else result / denominator


def _power(value: R, exponent: float) -> R:
    """Raise to a power, whole ones by multiplication: that is faster than pow."""
    if exponent < 0:
        return 1 / _power(value, -exponent)
    if exponent != int(exponent) or exponent > _MOST_FACTORS:
        power: R = value**exponent
        return power
    return reduce(operator.mul, [value] * int(exponent))


def multiply_by_power(value: FloatArray, base: FloatArray, exponent: float, work: FloatArray) -> None:
    """Multiply in place by a power of an array, a whole one by squaring; `work` is an array to compute in."""
    size = abs(exponent)
    if not size:
        return
    if size != int(size) or size > _MOST_FACTORS:
        np.power(base, size, out=work)
    else:
        work[...] = base
        for bit in bin(int(size))[3:]:
            work *= work
            if bit == "1":
                work *= base
    if exponent > 0:
        value *= work
    else:
        value /= work


def scaled_product(number: float, factors: Sequence[tuple[Numbers, float]], rest: FloatArray) -> FloatArray:
    """Multiply a number, powers of arrays, and an array, with mantissas and exponents apart.

    An element is NaN where 0 is raised to a negative power.
    """
    mantissa, binary = np.frexp(number * np.asarray(rest))
    binary = binary.astype(np.float64)
    for value, exponent in factors:
        if exponent == 0:
            continue
        part, shift = np.frexp(np.asarray(value))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            power = np.where(
                part == 0, 0.0 if exponent > 0 else np.nan, np.sign(part) ** exponent * np.abs(part) ** exponent
            )
        whole = np.floor(shift * exponent)
        mantissa, carry = np.frexp(mantissa * power * np.exp2(shift * exponent - whole))
        binary = binary + whole + carry
    with np.errstate(over="ignore", under="ignore"):
        return np.asarray(
            np.ldexp(mantissa, np.clip(binary, -_LARGEST, _LARGEST).astype(np.int64).astype(np.int32))
        )

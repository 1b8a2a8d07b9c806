"""Products of powers of floats that over- or underflow only where their value does."""

import math
from collections.abc import Sequence

import numpy as np

from stickslip_sym.core.aliases import FloatArray, Numbers
from stickslip_sym.formula.evaluation.room import Room, multiply_by_power

__all__ = ["extremes", "largest_exponent", "plain_product", "power_of", "scaled_product"]

_MOST_FACTORS = 8
_LARGEST = 4000  # binary exponents beyond this are clipped: the value is 0 or infinite


def extremes(value: Numbers) -> tuple[float, float]:
    """Return the smallest and the largest of an array's elements, or a float twice."""
    if isinstance(value, float):
        return value, value
    return float(np.minimum.reduce(value)), float(np.maximum.reduce(value))


def largest_exponent(low: float, high: float) -> float:
    """Return the largest size of the binary exponent of numbers between two; infinite for a 0."""
    if low < 0:
        low, high = (-high, -low) if high < 0 else (0.0, high)
    if not (low > 0 and high < math.inf):
        return math.inf
    return max(abs(math.log2(low)), abs(math.log2(high)))


def plain_product(
    number: float, factors: Sequence[tuple[FloatArray, float]], count: int, room: Room
) -> FloatArray:
    """Multiply a number and powers of arrays of a length, in the room's memory unless it is one array as it is."""
    if not factors:
        return np.full(count, number)
    (first, exponent), *others = sorted(factors, key=lambda factor: factor[1] < 0)  # those that divide come last
    if number == 1 and exponent == 1 and not others:
        return first
    result = room("product", count)
    if exponent == 1:
        np.multiply(first, number, out=result)
    else:
        result.fill(number)
        multiply_by_power(result, first, exponent, room)
    for value, exponent in others:
        multiply_by_power(result, value, exponent, room)
    return result


def power_of(value: float, exponent: float) -> float:
    """Raise to a power, whole ones by multiplication, as it is done for arrays."""
    if exponent < 0:
        return 1 / power_of(value, -exponent)
    if exponent != int(exponent) or exponent > _MOST_FACTORS:
        return float(value**exponent)
    return math.prod([value] * int(exponent))


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

"""Arrays to compute in, and what is computed in place.

To take memory from the system for each block, and to give it back, costs as much as to compute. So the arrays of a
block are made once, used again for the next one, and stay in the processor's cache.
"""

from collections.abc import Sequence

import numpy as np

from stickslip_sym.core.aliases import FloatArray

__all__ = ["Room", "horner_into", "multiply_by_exponential", "multiply_by_power", "power_into"]

_MOST_FACTORS = 8


class Room:
    """Arrays by names, for one call: who asks for a name again gets the same memory.

    Attributes
    ----------
    kept : dict
        What is the same for all blocks of the call, by who keeps it.
    """

    def __init__(self) -> None:
        self._arrays: dict[str, FloatArray] = {}
        self.kept: dict[object, object] = {}

    def __call__(self, name: str, count: int) -> FloatArray:
        """Return an array of a length, with anything in it."""
        found = self._arrays.get(name)
        if found is None or found.size < count:
            found = self._arrays[name] = np.empty(count)
        return found[:count]


def horner_into(coefficients: Sequence[float], z: FloatArray, out: FloatArray) -> None:
    """Evaluate a polynomial, in an array that is not z."""
    if len(coefficients) == 1:
        out.fill(coefficients[0])
        return
    np.multiply(z, coefficients[-1], out=out)
    for coefficient in coefficients[-2:0:-1]:
        out += coefficient
        out *= z
    out += coefficients[0]


def power_into(r: FloatArray, exponent: float, out: FloatArray) -> FloatArray:
    """Return r to the power 1, 2, -1, -2 or -1/2: r itself, or what is written into `out`."""
    if exponent == 1:
        return r
    if exponent == 2:
        return np.multiply(r, r, out=out)
    np.divide(1, np.sqrt(r, out=out) if exponent == -0.5 else r, out=out)
    if exponent == -2:
        out *= out
    return out


def multiply_by_power(value: FloatArray, base: FloatArray, exponent: float, room: Room) -> None:
    """Multiply by a power of another array, a whole one by squaring."""
    size = abs(exponent)
    if not size:
        return
    power = base
    if size != int(size) or size > _MOST_FACTORS:
        power = np.power(base, size, out=room("power", base.size))
    elif size > 1:
        power = np.multiply(base, base, out=room("power", base.size))
        for i, bit in enumerate(bin(int(size))[3:]):
            if i:
                power *= power
            if bit == "1":
                power *= base
    if exponent > 0:
        value *= power
    else:
        value /= power


def multiply_by_exponential(value: FloatArray, r: FloatArray, rate: float, room: Room) -> None:
    """Multiply by exp(-rate r)."""
    factor = np.multiply(r, -rate, out=room("exponential", r.size))
    np.exp(factor, out=factor)
    value *= factor

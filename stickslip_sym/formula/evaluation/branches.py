"""The branches of a function of one positive variable: each a short formula for a range of it.

A branch gives F(r) = r^power G(r), and computes G only where the power must join the other factors of the result,
so that nothing over- or underflows on the way to a number that does neither.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.formula.evaluation.room import (
    Room,
    horner_into,
    multiply_by_exponential,
    multiply_by_power,
    power_into,
)

__all__ = [
    "CENTERS", "MIDDLE", "STRETCHES", "Branch", "LogTail", "Loop", "Profile", "R", "Series", "Table", "filled",
    "horner",
]  # fmt: skip

R = TypeVar("R", float, FloatArray)
"""One r as a float, or an array of r."""


class Branch(Protocol):
    """A formula for one range of r."""

    @property
    def power(self) -> float:
        """The power of r that is left to the caller."""

    @property
    def is_light(self) -> bool:
        """Whether computing G costs less than picking elements out of an array and putting them back."""

    def __call__(self, r: R) -> R:
        """Return G for r in the range."""

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`; the power is 0, or that of the branch."""


class Loop(Protocol):
    """All branches of a function at once, compiled."""

    def __call__(self, speeds: FloatArray, factor: float, number: float, out: FloatArray) -> None:
        """Write number F(factor speeds) into `out`; no power over- or underflows."""


def filled(branch: Branch, r: FloatArray) -> FloatArray:
    """Return G for an array."""
    out = np.empty(r.shape)
    branch.fill(r, out, Room())
    return out


def horner(coefficients: Sequence[float], z: float) -> float:
    """Evaluate a polynomial."""
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * z + coefficient
    return value


_POWERS: dict[float, Callable[[float], float]] = {
    1.0: lambda r: r,
    2.0: lambda r: r * r,
    -1.0: lambda r: 1 / r,
    -2.0: lambda r: (1 / r) * (1 / r),
    -0.5: lambda r: 1 / math.sqrt(r),
}


@dataclass(frozen=True)
class Series:
    """G = exp(-decay r) sum_k coefficients[k] z^k with z a power of r: 1, 2, -1, -2 or -1/2.

    `shift` and `stretch` bring z to the range of a fit: the sum is in (z - shift) stretch.
    """

    power: float
    coefficients: tuple[float, ...]
    decay: float = 0.0
    variable: float = 1.0
    shift: float = 0.0
    stretch: float = 1.0
    is_light = True

    def __call__(self, r: R) -> R:
        """Return G."""
        if not isinstance(r, float):
            return filled(self, r)
        z = _POWERS[self.variable](r)
        if not (self.shift == 0 and self.stretch == 1):
            z = (z - self.shift) * self.stretch
        total = horner(self.coefficients, z)
        return total * math.exp(-self.decay * r) if self.decay else total

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`."""
        z = t = power_into(r, self.variable, room("z", r.size))
        if not (self.shift == 0 and self.stretch == 1):
            t = np.subtract(z, self.shift, out=room("t", r.size))
            t *= self.stretch
        # Coefficients of both signs may cancel: there each rounding of a product would count.
        joined = number if min(self.coefficients) >= 0 and t is z else 1.0
        horner_into([joined * c for c in self.coefficients], t, out)
        if number != joined:
            out *= number
        if self.decay:
            multiply_by_exponential(out, r, self.decay, room)
        steps = power / self.variable
        if steps > 0 and steps == int(steps):
            multiply_by_power(out, z, steps, room)
        else:
            multiply_by_power(out, r, power, room)


@dataclass(frozen=True)
class Table:
    """G as polynomials in panels of half an octave: 2^(k-1) <= r < 2^(k-1/2) and 2^(k-1/2) <= r < 2^k.

    `rows[i]` holds the coefficients of panel i in t, -1 <= t <= 1; the first panel starts at 2^(first - 1).
    """

    power: float
    first: int
    rows: FloatArray  # panels by coefficients
    is_light = False

    @cached_property
    def _columns(self) -> FloatArray:
        return np.ascontiguousarray(self.rows.T)

    @cached_property
    def _lists(self) -> list[list[float]]:
        return list(self.rows.tolist())

    def __call__(self, r: R) -> R:
        """Return G."""
        if isinstance(r, float):
            mantissa, exponent = math.frexp(r)
            half = mantissa >= MIDDLE
            return horner(
                self._lists[2 * (exponent - self.first) + half], (mantissa - CENTERS[half]) * STRETCHES[half]
            )
        return filled(self, r)

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`."""
        mantissas, exponents = np.frexp(r)
        upper = (mantissas >= MIDDLE).astype(np.intp)
        panel = 2 * (exponents - self.first) + upper
        mantissas -= _CENTERS.take(upper)
        mantissas *= _STRETCHES.take(upper)
        *rest, last = self._columns
        taken = room("taken", r.size)
        last.take(panel, out=out, mode="clip")  # which needs no room of its own; no panel is outside
        for column in reversed(rest):
            out *= mantissas
            out += column.take(panel, out=taken, mode="clip")
        if number != 1:
            out *= number
        multiply_by_power(out, r, power, room)


MIDDLE = 0.703125  # close to sqrt(1/2), and short
CENTERS = ((0.5 + MIDDLE) / 2, (1 + MIDDLE) / 2)
STRETCHES = (2 / (MIDDLE - 0.5), 2 / (1 - MIDDLE))
_CENTERS, _STRETCHES = np.array(CENTERS), np.array(STRETCHES)


@dataclass(frozen=True)
class LogTail:
    """G = constant + slope log(r), the leading term for r beyond all scales."""

    power: float
    constant: float
    slope: float
    is_light = False

    def __call__(self, r: R) -> R:
        """Return G."""
        if self.slope:
            return (math.log(r) if isinstance(r, float) else np.log(r)) * self.slope + self.constant
        return 0 * r + self.constant

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`."""
        np.multiply(self(r), number, out=out)
        multiply_by_power(out, r, power, room)


@dataclass(frozen=True, eq=False)
class Profile:
    """F(r) by branches.

    Attributes
    ----------
    starts : tuple of float
        Where each branch begins; the first at 0.
    branches : tuple of Branch or None
        None where there is none.
    ends : tuple of float
        Up to where each branch serves: the next one may begin before, where it takes less time.
    """

    starts: tuple[float, ...]
    branches: tuple[Branch | None, ...]
    ends: tuple[float, ...]

    @cached_property
    def steepest(self) -> float:
        """The largest size of a branch's power."""
        return max((abs(branch.power) for branch in self.branches if branch is not None), default=0.0)

    def cover(self, low: float, high: float) -> tuple[list[Branch | None], list[float]]:
        """Return the fewest branches that serve from `low` to `high`, and where one follows another."""
        which = bisect_right(self.starts, low) - 1
        branches, edges = [self.branches[which]], []
        while (end := self.ends[which]) <= high:
            which = bisect_right(self.starts, end) - 1
            branches.append(self.branches[which])
            edges.append(end)
        return branches, edges

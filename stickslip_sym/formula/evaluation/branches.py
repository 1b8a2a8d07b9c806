"""The branches of a function of one positive variable: each a short formula for a range of it.

A branch gives F(r) = r^power G(r), and computes G only: the power joins the other factors of the result, so
that nothing over- or underflows on the way to a number that does neither.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.lambdify import function_of

__all__ = [
    "CENTERS", "MIDDLE", "STRETCHES", "Branch", "Closed", "Formula", "LogTail", "Series", "Table", "as_closed",
    "as_formula",
]  # fmt: skip


class Branch(Protocol):
    """A formula for one range of r."""

    @property
    def power(self) -> float:
        """The power of r that is left to the caller."""

    def array(self, r: Any) -> Any:
        """Return G for an array of r in the range."""

    def scalar(self, r: float) -> float:
        """Return G for one r in the range."""


_POWERS: dict[float, Callable[[Any], Any]] = {
    1.0: lambda r: r,
    2.0: lambda r: r * r,
    -1.0: lambda r: 1 / r,
    -2.0: lambda r: (1 / r) * (1 / r),
    -0.5: lambda r: r**-0.5,
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

    def _variable(self, r: Any) -> Any:
        z = _POWERS[self.variable](r)
        return z if self.shift == 0 and self.stretch == 1 else (z - self.shift) * self.stretch

    def array(self, r: Any) -> Any:
        """Return G for an array of r."""
        total = _horner(self.coefficients, self._variable(r))
        if self.decay:
            factor = r * -self.decay
            np.exp(factor, out=factor)
            total *= factor
        return total

    def scalar(self, r: float) -> float:
        """Return G for one r."""
        z = self._variable(r)
        total = 0.0
        for coefficient in reversed(self.coefficients):
            total = total * z + coefficient
        return total * math.exp(-self.decay * r) if self.decay else total


def _horner(coefficients: tuple[float, ...], z: Any) -> Any:
    """Evaluate a polynomial at an array, in place."""
    if len(coefficients) == 1:
        return np.full_like(z, coefficients[0])
    total = z * coefficients[-1]
    for coefficient in coefficients[-2:0:-1]:
        total += coefficient
        total *= z
    total += coefficients[0]
    return total


@dataclass(frozen=True)
class Closed:
    """G = sum_i f_i(r) sum_k coefficients_i[k] r^k: a closed form, with 1 among the functions f_i."""

    power: float
    parts: tuple[tuple[Any, tuple[float, ...], Callable[[Any], Any] | None, Callable[[float], float] | None], ...]
    """Each with f as an expression in V, the coefficients, and f compiled for arrays and for single numbers."""

    def array(self, r: Any) -> Any:
        """Return G for an array of r."""
        total: Any = None
        for _, coefficients, vector, _ in self.parts:
            part = _horner(coefficients, r)
            if vector is not None:
                part *= vector(r)
            if total is None:
                total = part
            else:
                total += part
        return total

    def scalar(self, r: float) -> float:
        """Return G for one r."""
        total = 0.0
        for _, coefficients, _, single in self.parts:
            part = 0.0
            for coefficient in reversed(coefficients):
                part = part * r + coefficient
            total += part if single is None else part * single(r)
        return total


@dataclass(frozen=True)
class Table:
    """G as polynomials in panels of half an octave: 2^(k-1) <= r < 2^(k-1/2) and 2^(k-1/2) <= r < 2^k.

    `rows[i]` holds the coefficients of panel i in t, -1 <= t <= 1; the first panel starts at 2^(first - 1).
    """

    power: float
    first: int
    rows: Any  # numpy.ndarray, panels by coefficients

    @cached_property
    def _columns(self) -> Any:
        return np.ascontiguousarray(self.rows.T)

    @cached_property
    def _lists(self) -> list[list[float]]:
        return list(self.rows.tolist())

    def array(self, r: Any) -> Any:
        """Return G for an array of r."""
        mantissa, exponent = np.frexp(r)
        upper = mantissa >= MIDDLE
        panel = 2 * (exponent - self.first) + upper
        t = (mantissa - np.where(upper, CENTERS[1], CENTERS[0])) * np.where(upper, STRETCHES[1], STRETCHES[0])
        *rest, last = self._columns
        total = last.take(panel)
        for column in reversed(rest):
            total *= t
            total += column.take(panel)
        return total

    def scalar(self, r: float) -> float:
        """Return G for one r."""
        mantissa, exponent = math.frexp(r)
        upper = mantissa >= MIDDLE
        t = (mantissa - CENTERS[upper]) * STRETCHES[upper]
        total = 0.0
        for coefficient in reversed(self._lists[2 * (exponent - self.first) + upper]):
            total = total * t + coefficient
        return total


MIDDLE = 0.703125  # close to sqrt(1/2), and short
CENTERS = ((0.5 + MIDDLE) / 2, (1 + MIDDLE) / 2)
STRETCHES = (2 / (MIDDLE - 0.5), 2 / (1 - MIDDLE))


@dataclass(frozen=True)
class Formula:
    """G by a formula in r, compiled for arrays and for single numbers."""

    power: float
    expr: Any
    vector: Callable[[Any], Any]
    single: Callable[[float], float]

    def array(self, r: Any) -> Any:
        """Return G for an array of r."""
        return self.vector(r)

    def scalar(self, r: float) -> float:
        """Return G for one r."""
        return self.single(r)


@dataclass(frozen=True)
class LogTail:
    """G = constant + slope log(r), the leading term for r beyond all scales."""

    power: float
    constant: float
    slope: float

    def array(self, r: Any) -> Any:
        """Return G for an array of r."""
        return np.log(r) * self.slope + self.constant if self.slope else np.full_like(r, self.constant)

    def scalar(self, r: float) -> float:
        """Return G for one r."""
        return self.constant + (self.slope * math.log(r) if self.slope else 0.0)


def as_formula(raw: Any) -> tuple[Branch, Any]:
    """Take a closed form in V as it stands."""
    expr = sp.factor_terms(raw)
    vector, single = (function_of([symbols.V], expr, backend) for backend in ("numpy", "math"))
    return Formula(0.0, expr, vector, single), expr


def as_closed(raw: Any) -> tuple[Branch, Any]:
    """Write a closed form as polynomials in V times functions, over one power of V; also as an expression."""
    V = symbols.V
    groups: dict[Any, dict[int, Any]] = {}
    for term in sp.Add.make_args(sp.expand(raw)):
        coefficient, rest = term.as_independent(V, as_Add=False)
        monomials, others = sp.sift(
            sp.Mul.make_args(rest), lambda factor: factor.as_base_exp()[0] == V, binary=True
        )
        function, power = sp.Mul(*others), sp.Mul(*monomials).as_base_exp()[1] if monomials else sp.Integer(0)
        if not power.is_Integer:
            function, power = function * V ** (power - sp.floor(power)), sp.floor(power)
        group = groups.setdefault(function, {})
        group[int(power)] = group.get(int(power), 0) + coefficient
    lowest = min(min(group) for group in groups.values())
    parts, expr = [], sp.Integer(0)
    for function, group in groups.items():
        coefficients = [group.get(k, sp.Integer(0)) for k in range(lowest, max(group) + 1)]
        if function == 1:
            vector = single = None
        else:
            vector, single = (function_of([V], function, backend) for backend in ("numpy", "math"))
        parts.append((function, tuple(float(c) for c in coefficients), vector, single))
        expr += function * sp.horner(sp.Add(*[c * V**k for k, c in enumerate(coefficients)]), V)
    return Closed(float(lowest), tuple(parts)), expr * V**lowest

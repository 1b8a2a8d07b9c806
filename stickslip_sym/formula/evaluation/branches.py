"""The branches of a function of one positive variable: each a short formula for a range of it.

A branch gives F(r) = r^power G(r), and computes G only: the power joins the other factors of the result, so
that nothing over- or underflows on the way to a number that does neither.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.lambdify import function_of

__all__ = [
    "CENTERS", "MIDDLE", "STRETCHES", "Branch", "Closed", "Formula", "LogTail", "Series", "Table", "as_closed",
    "as_formula",
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

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`; `work` is an array of the same length to compute in."""


_POWERS: dict[float, Callable[[R], R]] = {
    1.0: lambda r: r,
    2.0: lambda r: r * r,
    -1.0: lambda r: 1 / r,
    -2.0: lambda r: (1 / r) * (1 / r),
    -0.5: lambda r: r**-0.5,
}


class Compiled:
    """An expression in V, computed by the library that is fast for one number, or for arrays."""

    def __init__(self, expr: Expr) -> None:
        self.expr = expr
        self._single, self._array = (function_of([symbols.V], expr, backend) for backend in ("math", "numpy"))

    def __call__(self, r: R) -> R:
        """Return the value at r."""
        value: R = self._single(r) if isinstance(r, float) else self._array(r)
        return value

    @cached_property
    def rate(self) -> float | None:
        """The k of exp(-k V); None if it is no such exponential."""
        found = sp.log(self.expr).expand(force=True) / symbols.V if isinstance(self.expr, sp.exp) else sp.nan
        return -float(found) if found.is_Rational else None

    def multiply(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Multiply what is in `out` by the value at r."""
        if self.rate is None:
            out *= self._array(r)
        else:
            _decay(r, self.rate, out, work)


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
            return _filled(self, r)
        z = _POWERS[self.variable](r)
        if not (self.shift == 0 and self.stretch == 1):
            z = (z - self.shift) * self.stretch
        total = _horner(self.coefficients, z)
        return total * math.exp(-self.decay * r) if self.decay else total

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`."""
        z = r
        if self.variable == 2:
            z = np.multiply(r, r, out=work)
        elif self.variable != 1:
            work[...] = _POWERS[self.variable](r)
            z = work
        if not (self.shift == 0 and self.stretch == 1):
            z = np.subtract(z, self.shift, out=work)
            z *= self.stretch
        _horner_into(self.coefficients, z, out)
        if self.decay:
            _decay(r, self.decay, out, work)


def _filled(branch: Branch, r: FloatArray) -> FloatArray:
    out = np.empty_like(r)
    branch.fill(r, out, np.empty_like(r))
    return out


def _decay(r: FloatArray, rate: float, out: FloatArray, work: FloatArray) -> None:
    """Multiply what is in `out` by exp(-rate r)."""
    np.multiply(r, -rate, out=work)
    np.exp(work, out=work)
    out *= work


def _horner(coefficients: Sequence[float], z: float) -> float:
    """Evaluate a polynomial."""
    value = 0.0
    for coefficient in reversed(coefficients):
        value = value * z + coefficient
    return value


def _horner_into(coefficients: Sequence[float], z: FloatArray, out: FloatArray) -> None:
    """Evaluate a polynomial in place, in an array that is not z."""
    if len(coefficients) == 1:
        out.fill(coefficients[0])
        return
    np.multiply(z, coefficients[-1], out=out)
    for coefficient in coefficients[-2:0:-1]:
        out += coefficient
        out *= z
    out += coefficients[0]


@dataclass(frozen=True)
class Closed:
    """G = sum_i f_i(r) sum_k coefficients_i[k] r^k: a closed form; f_i is None where it is 1."""

    power: float
    parts: tuple[tuple[Compiled | None, tuple[float, ...]], ...]

    @property
    def is_light(self) -> bool:
        """Whether its functions are exponentials."""
        return all(function is None or function.rate is not None for function, _ in self.parts)

    def __call__(self, r: R) -> R:
        """Return G."""
        if not isinstance(r, float):
            return _filled(self, r)
        return sum(
            (1.0 if function is None else function(r)) * _horner(coefficients, r)
            for function, coefficients in self.parts
        )

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`."""
        part, room = out, np.empty_like(r)
        for function, coefficients in self.parts:
            _horner_into(coefficients, r, part)
            if function is not None:
                function.multiply(r, part, work)
            if part is not out:
                out += part
            part = room


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
            return _horner(
                self._lists[2 * (exponent - self.first) + half], (mantissa - CENTERS[half]) * STRETCHES[half]
            )
        return _filled(self, r)

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`."""
        mantissas, exponents = np.frexp(r)
        upper = (mantissas >= MIDDLE).astype(np.intp)
        panel = 2 * (exponents - self.first) + upper
        mantissas -= _CENTERS.take(upper)
        mantissas *= _STRETCHES.take(upper)
        *rest, last = self._columns
        last.take(panel, out=out, mode="clip")  # which needs no room of its own; no panel is outside
        for column in reversed(rest):
            out *= mantissas
            out += column.take(panel, out=work, mode="clip")


MIDDLE = 0.703125  # close to sqrt(1/2), and short
CENTERS = ((0.5 + MIDDLE) / 2, (1 + MIDDLE) / 2)
STRETCHES = (2 / (MIDDLE - 0.5), 2 / (1 - MIDDLE))
_CENTERS, _STRETCHES = np.array(CENTERS), np.array(STRETCHES)


@dataclass(frozen=True)
class Formula:
    """G by a formula in r."""

    power: float
    compiled: Compiled
    is_light = False

    def __call__(self, r: R) -> R:
        """Return G."""
        return self.compiled(r)

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`."""
        out[...] = self.compiled(r)


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

    def fill(self, r: FloatArray, out: FloatArray, work: FloatArray) -> None:
        """Write G into `out`."""
        out[...] = self(r)


def as_formula(raw: Expr) -> tuple[Branch, Expr]:
    """Take a closed form in V as it stands."""
    expr = sp.factor_terms(raw)
    return Formula(0.0, Compiled(expr)), expr


def as_closed(raw: Expr) -> tuple[Branch, Expr]:
    """Write a closed form as polynomials in V times functions, over one power of V; also as an expression."""
    V = symbols.V
    groups: dict[Expr, dict[int, Expr]] = {}
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
        parts.append((None if function == 1 else Compiled(function), tuple(float(c) for c in coefficients)))
        expr += function * sp.horner(sp.Add(*[c * V**k for k, c in enumerate(coefficients)]), V)
    return Closed(float(lowest), tuple(parts)), expr * V**lowest

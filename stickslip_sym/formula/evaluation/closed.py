"""Closed forms as branches: formulas compiled from an expression."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.formula.evaluation.branches import Branch, R, filled, horner
from stickslip_sym.formula.evaluation.room import (
    Room,
    horner_into,
    multiply_by_exponential,
    multiply_by_power,
    power_into,
)

__all__ = ["Closed", "Compiled", "Formula", "as_closed", "as_formula"]


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

    def multiply(self, value: FloatArray, r: FloatArray, room: Room) -> None:
        """Multiply in place by the expression at r."""
        if self.rate is None:
            value *= self._array(r)
        else:
            multiply_by_exponential(value, r, self.rate, room)


@dataclass(frozen=True)
class Closed:
    """G = sum_i f_i(r) sum_k coefficients_i[k] z^k with z = 1/r; f_i is None where it is 1."""

    power: float
    parts: tuple[tuple[Compiled | None, tuple[float, ...]], ...]

    @property
    def is_light(self) -> bool:
        """Whether its functions are exponentials."""
        return all(function is None or function.rate is not None for function, _ in self.parts)

    @cached_property
    def _mirrored(self) -> float:
        """The sign s where there are two polynomials, p(z) alone and s p(-z) with a function; 0 elsewhere.

        The law exp(-v) is of this kind under every criterion, for weights are even.
        """
        if len(self.parts) != 2 or self.parts[0][0] is not None:
            return 0.0
        (_, first), (_, second) = self.parts
        reflected = [c * (-1) ** k for k, c in enumerate(first)]
        return next((sign for sign in (1.0, -1.0) if list(second) == [sign * c for c in reflected]), 0.0)

    def __call__(self, r: R) -> R:
        """Return G."""
        if not isinstance(r, float):
            return filled(self, r)
        return sum(
            (1.0 if function is None else function(r)) * horner(coefficients, 1 / r)
            for function, coefficients in self.parts
        )

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`."""
        z = power_into(r, -1.0, room("z", r.size))
        part = out
        for function, coefficients in self.parts:
            if part is not out and self._mirrored:
                self._reflect(out, z, part, room)
            else:
                horner_into(coefficients, z, part)
            if function is not None:
                function.multiply(part, r, room)
            if part is not out:
                out += part
            part = room("part", r.size)
        if number != 1:
            out *= number
        multiply_by_power(out, r, power, room)  # not of z, which is rounded once more

    def _reflect(self, first: FloatArray, z: FloatArray, out: FloatArray, room: Room) -> None:
        """Write s p(-z) into `out`, given p(z): twice the even part less that, in half the passes."""
        square = np.multiply(z, z, out=room("square", z.size))
        horner_into([2 * c for c in self.parts[0][1][::2]], square, out)
        np.subtract(out, first, out=out)
        if self._mirrored < 0:
            np.negative(out, out=out)


@dataclass(frozen=True)
class Formula:
    """G by a formula in r."""

    power: float
    compiled: Compiled
    is_light = False

    def __call__(self, r: R) -> R:
        """Return G."""
        return self.compiled(r)

    def fill(self, r: FloatArray, out: FloatArray, room: Room, number: float = 1.0, power: float = 0.0) -> None:
        """Write number r^power G into `out`."""
        np.multiply(self.compiled(r), number, out=out)
        multiply_by_power(out, r, power, room)


def as_formula(raw: Expr) -> tuple[Branch, Expr]:
    """Take a closed form in V as it stands."""
    expr = sp.factor_terms(raw)
    return Formula(0.0, Compiled(expr)), expr


def as_closed(raw: Expr) -> tuple[Branch, Expr]:
    """Write a closed form as polynomials in 1/V times functions, times one power of V; also as an expression."""
    V, z = symbols.V, sp.Dummy("z", positive=True)
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
    highest = max(max(group) for group in groups.values())
    parts, expr = [], sp.Integer(0)
    for function, group in sorted(groups.items(), key=lambda item: item[0] != 1):
        coefficients = [group.get(k, sp.Integer(0)) for k in range(highest, min(group) - 1, -1)]
        parts.append((None if function == 1 else Compiled(function), tuple(float(c) for c in coefficients)))
        expr += function * sp.horner(sp.Add(*[c * z**k for k, c in enumerate(coefficients)]), z).xreplace(
            {z: 1 / V}
        )
    return Closed(float(highest), tuple(parts)), expr * V**highest

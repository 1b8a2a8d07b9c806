"""Where a coefficient of friction varies quickly, and over which width: read from its formula, not from samples.

A function such as tanh(u) or exp(u) changes where |u| is about 1, near the zeros and the turning points of u. A
denominator, a root and a logarithm change near the complex zeros of what stands in them: the real part is the
place, the imaginary part the width. A sum A + C exp(u), as in a logistic function, changes where both terms are as
large. What stands in functions, but is no polynomial in v or in its logarithm, is looked at part by part.
"""

import math
from collections.abc import Iterator
from functools import reduce
from operator import add, mul
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from flint import fmpq, fmpq_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import number_at, rational
from stickslip_sym.core.functions import fold, row
from stickslip_sym.core.numbers import DOUBLE_DIGITS, LARGEST
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_V

_LARGEST_LOG_SPEED = math.log(LARGEST)


class _Argument(NamedTuple):
    """A polynomial in the slip speed v, or in log(v)."""

    polynomial: fmpq_poly
    of_logarithm: bool = False

    @property
    def is_constant(self) -> bool:
        return bool(self.polynomial.degree() < 1)


class Transition(NamedTuple):
    """A slip speed near which a coefficient may change over a width, in m/s; the speed is positive."""

    speed: float
    width: float


def transitions(expr: Expr, point: Substitution) -> list[Transition]:
    """Return where a smooth piece of a coefficient may vary quickly, at values of its parameters."""
    quick = list[Transition]()
    exponents = dict[Expr, fmpq_poly]()

    def argument(node: Expr, parts: list[_Argument | None]) -> _Argument | None:
        """Return a node as a polynomial, None where it is none; note where a function of it changes."""
        if node == symbols.v:
            return _Argument(fmpq_poly([0, 1]))
        arguments = [part for part in parts if part is not None]
        kinds = {part.of_logarithm for part in arguments if not part.is_constant}
        if arguments and len(arguments) == len(parts) and len(kinds) < 2:
            polynomials = [part.polynomial for part in arguments]
            if node.is_Add or node.is_Mul:
                return _Argument(reduce(add if node.is_Add else mul, polynomials), True in kinds)
            if node.is_Pow and len(parts) == 2 and node.exp.is_Integer:
                power = int(node.exp)
                if 0 < power * max(polynomials[0].degree(), 1) <= HIGHEST_POWER_OF_V:
                    return _Argument(polynomials[0] ** power, True in kinds)
        if not node.has(symbols.v):
            constant = _constant_polynomial(node, point)
            return None if constant is None else _Argument(constant)
        if node.is_Add and len(arguments) == len(parts) - 1 and not kinds:
            moving = node.args[parts.index(None)]
            rest = reduce(add, (part.polynomial for part in arguments))
            factor, function = moving.as_independent(symbols.v, as_Add=False)
            weight = _constant_polynomial(factor, point)
            if function in exponents and weight and rest:
                level = math.log(abs(float(rest[0] / weight[0])))
                quick.extend(_argument_transitions(exponents[function] - fmpq(*level.as_integer_ratio())))
        elif (node.is_Pow and len(parts) == 2) or isinstance(node, sp.log):
            base = parts[0]
            if base is not None:
                quick.extend(_speed_transitions(_base_transitions(base.polynomial), base.of_logarithm))
            return _logarithm_of_power(node, point)
        elif row(node) is not None:
            for part in arguments:
                quick.extend(_speed_transitions(_argument_transitions(part.polynomial), part.of_logarithm))
            if isinstance(node, sp.exp) and arguments and not arguments[0].of_logarithm:
                exponents[node] = arguments[0].polynomial
        return None

    fold(expr, argument)
    return [change for change in dict.fromkeys(quick) if 0 < change.speed < math.inf]


def _constant_polynomial(node: Expr, point: Substitution) -> fmpq_poly | None:
    """Return a number as a polynomial; None where it has no finite real value."""
    value = number_at(node, point)
    if not value.is_finite:
        return None
    return fmpq_poly([rational(value if value.is_Rational else sp.Rational(value.n(2 * DOUBLE_DIGITS)))])


def _logarithm_of_power(node: Expr, point: Substitution) -> _Argument | None:
    """Return the logarithm of a power of v, with a factor, as a polynomial in log(v); None for all else."""
    if not isinstance(node, sp.log):
        return None
    factor, moving = node.args[0].as_independent(symbols.v, as_Add=False)
    base, exponent = moving.as_base_exp()
    constants = [_constant_polynomial(number, point) for number in (sp.log(factor), exponent)]
    if base != symbols.v or None in constants:
        return None
    return _Argument(fmpq_poly([constant[0] for constant in constants if constant is not None]), True)


def _speed_transitions(changes: Iterator[Transition], of_logarithm: bool) -> Iterator[Transition]:
    """Yield changes at slip speeds, where they are those of a function of log(v) perhaps."""
    for place, width in changes:
        if not of_logarithm:
            yield Transition(place, width)
        elif abs(place) < _LARGEST_LOG_SPEED:
            yield Transition(math.exp(place), math.exp(place) * width)


def complex_zeros(polynomial: fmpq_poly) -> list[complex]:
    """Return the complex zeros of a polynomial, if it is not of too high a degree."""
    pairs: Any = polynomial.complex_roots() if 0 < polynomial.degree() <= HIGHEST_POWER_OF_V else ()
    return [complex(float(zero.real), float(zero.imag)) for zero, _ in pairs]


def _base_transitions(base: fmpq_poly) -> Iterator[Transition]:
    """Yield the changes of a power or a logarithm."""
    yield from (Transition(zero.real, abs(zero.imag)) for zero in complex_zeros(base))


def _argument_transitions(argument: fmpq_poly) -> Iterator[Transition]:
    """Yield the changes of a function: its width is the distance over which the argument changes by 1."""
    slope = argument.derivative()
    derivatives = [slope]
    while derivatives[-1].degree() > 0:
        derivatives.append(derivatives[-1].derivative())
    rows = [
        np.array([float(c) for c in of.coeffs()[::-1]]) / math.factorial(k) for k, of in enumerate(derivatives, 1)
    ]
    for z in complex_zeros(argument) + complex_zeros(slope):
        rates = [float(abs(np.polyval(row, z))) ** (1 / k) for k, row in enumerate(rows, 1)]
        yield Transition(z.real, abs(z.imag) + 1 / max(rates))

"""Where a coefficient of friction varies quickly, and over which width: read from its formula, not from samples.

A function such as tanh(u) or exp(u) changes where |u| is about 1, near the zeros and the turning points of u. A
denominator, a root and a logarithm change near the complex zeros of what stands in them: the real part is the
place, the imaginary part the width. A sum A + C exp(u), as in a logistic function, changes where both terms are as
large. What stands in functions, but is no polynomial in v, is looked at part by part.
"""

import math
from collections.abc import Iterator, Mapping
from functools import reduce
from operator import add, mul
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from flint import fmpq, fmpq_poly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import number_at, rational
from stickslip_sym.core.functions import fold, row

_HIGHEST = 24  # degree of a polynomial whose zeros are computed: higher ones take milliseconds
_DIGITS = 60  # of a constant that is no rational number


class Transition(NamedTuple):
    """A slip speed near which a coefficient may change over a width, in m/s; the speed is positive."""

    speed: float
    width: float


def transitions(expr: Expr, point: Mapping[Expr, Expr]) -> list[Transition]:
    """Return where a smooth piece of a coefficient may vary quickly, at values of its parameters."""
    quick, exponents = list[Transition](), dict[Expr, fmpq_poly]()

    def polynomial(node: Expr, parts: list[fmpq_poly | None]) -> fmpq_poly | None:
        """Return a node as a polynomial in v, None where it is none; note where a function of them changes."""
        if node == symbols.v:
            return fmpq_poly([0, 1])
        polynomials = [part for part in parts if part is not None]
        if polynomials and len(polynomials) == len(parts):
            if node.is_Add or node.is_Mul:
                return reduce(add if node.is_Add else mul, polynomials)
            if node.is_Pow and len(parts) == 2 and node.exp.is_Integer:
                power = int(node.exp)
                if 0 < power * max(polynomials[0].degree(), 1) <= _HIGHEST:
                    return polynomials[0] ** power
        if not node.has(symbols.v):
            return _constant(node, point)
        if node.is_Add and len(polynomials) == len(parts) - 1:
            moving, rest = node.args[parts.index(None)], reduce(add, polynomials)
            factor, function = moving.as_independent(symbols.v, as_Add=False)
            weight = _constant(factor, point)
            if function in exponents and weight and rest and rest.degree() == 0:
                level = math.log(abs(float(rest[0] / weight[0])))
                quick.extend(_of_argument(exponents[function] - fmpq(*level.as_integer_ratio())))
        elif (node.is_Pow and len(parts) == 2) or isinstance(node, sp.log):
            quick.extend(_of_base(parts[0]) if parts[0] else ())
        elif row(node) is not None:
            for argument in polynomials:
                quick.extend(_of_argument(argument))
            if isinstance(node, sp.exp) and polynomials:
                exponents[node] = polynomials[0]
        return None

    fold(expr, polynomial)
    return [change for change in dict.fromkeys(quick) if 0 < change.speed < math.inf]


def _constant(node: Expr, point: Mapping[Expr, Expr]) -> fmpq_poly | None:
    """Return a number as a polynomial; None where it has no finite real value."""
    value = number_at(node, point)
    if not value.is_finite:
        return None
    return fmpq_poly([rational(value if value.is_Rational else sp.Rational(value.n(_DIGITS)))])


def _zeros(polynomial: fmpq_poly) -> list[complex]:
    """Return the complex zeros of a polynomial, if it is not of too high a degree."""
    pairs: Any = polynomial.complex_roots() if 0 < polynomial.degree() <= _HIGHEST else ()
    return [complex(float(zero.real), float(zero.imag)) for zero, _ in pairs]


def _of_base(base: fmpq_poly) -> Iterator[Transition]:
    """Yield the changes of a power or a logarithm."""
    yield from (Transition(zero.real, abs(zero.imag)) for zero in _zeros(base))


def _of_argument(argument: fmpq_poly) -> Iterator[Transition]:
    """Yield the changes of a function: its width is the distance over which the argument changes by 1."""
    slope = argument.derivative()
    derivatives = [slope]
    while derivatives[-1].degree() > 0:
        derivatives.append(derivatives[-1].derivative())
    rows = [
        np.array([float(c) for c in of.coeffs()[::-1]]) / math.factorial(k) for k, of in enumerate(derivatives, 1)
    ]
    for z in _zeros(argument) + _zeros(slope):
        rates = [float(abs(np.polyval(row, z))) ** (1 / k) for k, row in enumerate(rows, 1)]
        yield Transition(z.real, abs(z.imag) + 1 / max(rates))

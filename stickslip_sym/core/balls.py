"""SymPy expressions as functions of balls: complex numbers with a radius, in Arb's arithmetic.

A ball function returns a ball that holds every value which the expression takes on its argument. Only the
functions of the table are translated. Where Arb integrates it asks whether a function is analytic on a whole
ball: a branch cut that is not reported gives a tight ball around a wrong number, so each function's cut is tested.
"""

import operator
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import reduce
from typing import Any, Protocol, TypeAlias, TypeVar, cast

import mpmath
import sympy as sp
from flint import acb, arb, arb_series, ctx, fmpq

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import CONSTANTS, FUNCTIONS, Function, fold, row

__all__ = [
    "BallFunction", "ball", "ball_function", "ball_value", "holds_at", "number_at", "rational", "series_function",
    "working_precision",
]  # fmt: skip

Z = TypeVar("Z", acb, arb_series)
BallFunction = Callable[[acb, bool], acb]
"""A function of a ball; the flag asks for a ball that is not finite where it is not analytic."""
Otherwise = Callable[[Expr, list[acb]], acb]
"""From a function that has no ball here, and the balls of its arguments, to a ball around its value."""

_LARGEST_POWER = 64  # of an integer exponent that is multiplied out; a power by logarithm fails around 0
_NUMBER_BITS = 4000  # of a number that is no rational one: beyond the digits of any answer
_lock = threading.RLock()  # Arb's precision is one setting of the whole process
_NOWHERE = acb("nan")


@contextmanager
def working_precision(bits: int, terms: int | None = None) -> Iterator[None]:
    """Compute with so many bits, and terms of a power series, inside the block, and as before after it.

    Other threads wait.
    """
    with _lock:
        before = ctx.prec, ctx.cap
        ctx.prec, ctx.cap = bits, ctx.cap if terms is None else terms
        try:
            yield
        finally:
            ctx.prec, ctx.cap = before


def rational(value: Expr) -> fmpq:
    """Return an exact SymPy rational as Arb's."""
    return fmpq(int(value.p), int(value.q))


def ball(value: Expr) -> acb:
    """Return a ball around a SymPy number: a rational is exact, a Float known to one unit of its last place."""
    if value.is_Rational:
        return acb(rational(value))
    sign, mantissa, exponent, _ = value._mpf_
    unit = exponent + mantissa.bit_length() - value._prec  # of the last place, as a power of two
    return acb(arb(((-1) ** sign * int(mantissa), exponent), arb((1, unit))))


def ball_value(expr: Expr, point: Mapping[Expr, Expr | acb], otherwise: Otherwise | None = None) -> acb:
    """Return a ball around the value of an expression at values of its symbols.

    Parameters
    ----------
    expr : sympy.Expr
    point : mapping
        Numbers for its symbols, or balls.
    otherwise : callable, optional
        Takes a function that is not among those enclosed, or has no finite ball there, and the balls of its
        arguments; returns a ball in its place.

    Raises
    ------
    InputError
        For a function that is not in the table, unless `otherwise` takes it.
    """
    return cast(acb, fold(_chosen(expr, point), _Translation(_Balls, _balls_of(point), otherwise)))


def ball_function(expr: Expr, variable: Expr, point: Mapping[Expr, Expr | acb]) -> BallFunction:
    """Return an expression as a function of one symbol, the others being numbers.

    It holds constants of the present working precision.

    Raises
    ------
    InputError
        For a function that is not in the table.
    """
    return _moving(expr, _Translation(_Balls, _balls_of(point) | {variable: lambda z, analytic: z}))


def series_function(
    expr: Expr, variable: Expr, point: Mapping[Expr, Expr | acb]
) -> Callable[[arb_series], arb_series]:
    """Return an expression as a function of a power series, with balls for coefficients; as `ball_function`."""
    function = _moving(expr, _Translation(_Series, _balls_of(point) | {variable: lambda z, analytic: z}))

    def of_series(series: arb_series) -> arb_series:
        value = function(series, False)
        return arb_series([value], prec=ctx.cap) if isinstance(value, arb) else value

    return of_series


def _balls_of(point: Mapping[Expr, Expr | acb]) -> "dict[Expr, _Part]":
    return {symbol: value if isinstance(value, acb) else ball(value) for symbol, value in point.items()}


def _moving(expr: Expr, translation: "_Translation") -> Callable[..., Any]:
    value = fold(expr, translation)
    if callable(value):
        return value
    constant = translation.arithmetic.constant(value)
    return lambda z, analytic: constant


_Part: TypeAlias = acb | Callable[..., Any]
"""A ball where no variable stands in an expression, else a function of the variable and of the flag."""


class _Arithmetic(Protocol):
    """The numbers that an expression is translated into."""

    @staticmethod
    def constant(value: acb) -> Any:
        """Return a ball as such a number."""

    @staticmethod
    def power(base: Any, exponent: acb, analytic: bool) -> Any:
        """Return a power that is no small whole number."""

    @staticmethod
    def apply(function: Function, arguments: list[Any], analytic: bool) -> Any:
        """Return the value of a function of the table."""


class _Balls:
    @staticmethod
    def constant(value: acb) -> acb:
        return value

    @staticmethod
    def power(base: acb, exponent: acb, analytic: bool) -> acb:
        """Return z^p: by the logarithm, and for p > 0 around 0, where there is none, within the largest size."""
        if not analytic and exponent.real > 0 and exponent.imag == 0 and base.contains(0):
            largest = arb(base.abs_upper())
            size = largest**exponent.real if largest > 0 else arb(0)
            around = arb(0, size.abs_upper())
            return acb(around, around)
        return base.pow(exponent, analytic)

    @staticmethod
    def apply(function: Function, arguments: list[acb], analytic: bool) -> acb:
        if function.ball is None:
            raise _not_enclosed(function.name)
        return _NOWHERE if analytic and function.cut(*arguments) else function.ball(*arguments)


class _Series:
    @staticmethod
    def constant(value: acb) -> arb:
        # A number, which joins any series: a series of it would keep for good the number of terms of the moment.
        return value.real

    @staticmethod
    def power(base: arb_series, exponent: acb, analytic: bool) -> arb_series:
        del analytic
        return (base.log() * exponent.real).exp()

    @staticmethod
    def apply(function: Function, arguments: list[arb_series], analytic: bool) -> arb_series:
        del analytic
        (inner,) = arguments
        if function.series is not None:
            return function.series(inner)
        x = sp.Dummy()
        slope = series_function(function.kind(x).diff(x), x, {})(inner) * inner.derivative()
        onset = _Balls.apply(function, [acb(inner[0])], False)
        return slope.integral() + onset.real


def _not_enclosed(name: str) -> InputError:
    return InputError(f"{name} is not among the functions that are enclosed")


class _Translation:
    """The algebra of balls, and of functions of a variable with values in them.

    A part of an expression without the variable is computed once; any other becomes a function.
    """

    def __init__(
        self, arithmetic: type[_Arithmetic], values: Mapping[Expr, _Part], otherwise: Otherwise | None = None
    ) -> None:
        self.arithmetic, self.values, self.otherwise = arithmetic, values, otherwise

    def __call__(self, node: Expr, parts: list[_Part]) -> _Part:
        if node.is_Number:
            return ball(node)
        if node in self.values:
            return self.values[node]
        if node in CONSTANTS:
            return CONSTANTS[node].ball()
        if node.is_Add or node.is_Mul:
            return self._joined(operator.add if node.is_Add else operator.mul, parts)
        if node.is_Pow and len(parts) == 2:
            return self._raised(node, *parts)
        if isinstance(node, sp.hyper):
            return self._hypergeometric(node, parts)
        if (function := row(node)) is None:
            if self.otherwise is not None and isinstance(node, sp.Function):
                return self.otherwise(node, cast(list[acb], parts))
            raise _not_enclosed(type(node).__name__)
        if self.otherwise is None or any(map(callable, parts)):
            return self._applied(function, parts)
        value = function.ball(*parts) if function.ball else _NOWHERE
        return value if value.is_finite() else self.otherwise(node, cast(list[acb], parts))

    def _applied(self, function: Function, parts: list[_Part]) -> _Part:
        if not any(map(callable, parts)):
            return _Balls.apply(function, cast(list[acb], parts), False)
        apply, moving = self.arithmetic.apply, [self._function(part) for part in parts]
        return lambda z, analytic: apply(function, [part(z, analytic) for part in moving], analytic)

    def _hypergeometric(self, node: Expr, parts: list[_Part]) -> acb:
        top, balls = len(node.args[0]), cast(list[acb], parts)
        if any(map(callable, parts)):
            raise _not_enclosed("hyper")
        value = balls[-1].hypgeom([*balls[:top]], [*balls[top:-1]])
        return value if self.otherwise is None or value.is_finite() else self.otherwise(node, balls)

    def _function(self, part: _Part) -> Callable[..., Any]:
        if callable(part):
            return part
        constant = self.arithmetic.constant(part)
        return lambda z, analytic: constant

    def _joined(self, join: Callable[[Any, Any], Any], parts: list[_Part]) -> _Part:
        """Return a sum or a product, its constant part computed once."""
        fixed = [part for part in parts if not callable(part)]
        moving = [part for part in parts if callable(part)]
        if not moving:
            return reduce(join, fixed)
        if fixed:
            moving.append(self._function(reduce(join, fixed)))
        return lambda z, analytic: reduce(join, [part(z, analytic) for part in moving])

    def _raised(self, node: Expr, base: _Part, exponent: _Part) -> _Part:
        if node.exp.is_Integer and abs(node.exp) <= _LARGEST_POWER:
            count = int(node.exp)
            if callable(base):
                return lambda z, analytic: _whole_power(base(z, analytic), count)
            return acb(_whole_power(base, count))
        if callable(exponent):
            logarithm = self._applied(FUNCTIONS[sp.log], [base])
            return self._applied(FUNCTIONS[sp.exp], [self._joined(operator.mul, [exponent, logarithm])])
        power = self.arithmetic.power
        if callable(base):
            return lambda z, analytic: power(base(z, analytic), exponent, analytic)
        return base.pow(exponent) if base != 0 else _Balls.power(base, exponent, False)


def _whole_power(z: Z, exponent: int) -> Z:
    """Multiply out: Arb's own power of a ball around 0 is not a number."""
    power = reduce(operator.mul, [z] * abs(exponent)) if abs(exponent) < 4 else _squared_up(z, abs(exponent))
    return power if exponent > 0 else 1 / power


def _squared_up(z: Z, exponent: int) -> Z:
    half = _whole_power(z, exponent // 2)
    return half * half * z if exponent % 2 else half * half


# -- numbers, and which piece of an expression holds -----------------------------------------------


def number_at(expr: Expr, point: Mapping[Expr, Expr]) -> Expr:
    """Return the value of a real expression as a SymPy number, without ever expanding a power of long fractions.

    Returns
    -------
    sympy.Rational or sympy.Float
        Exact where sums, products, whole powers, Abs, Min, Max and pieces suffice, else to 4000 bits; NaN where
        there is no finite real value.
    """
    exact = fold(expr, _Rationals(point)) if not expr.has(sp.Piecewise) else None
    if exact is not None:
        return exact
    with working_precision(_NUMBER_BITS + 64):
        value = ball_value(expr, point)
        if not (value.is_finite() and value.imag.contains(0)):
            return sp.nan
        mantissa, power = value.real.mid().man_exp()
    with mpmath.workprec(_NUMBER_BITS + 64):
        return sp.Float(mpmath.ldexp(int(mantissa), int(power)), precision=_NUMBER_BITS)


class _Rationals:
    """The algebra of exact rationals, and of None for what is none or takes a longer computation."""

    def __init__(self, point: Mapping[Expr, Expr]) -> None:
        self.point = point

    def __call__(self, node: Expr, parts: list[Expr | None]) -> Expr | None:
        if not parts:
            value = self.point.get(node, node)
            return value if value.is_Rational else None
        numbers = [part for part in parts if part is not None]
        if len(numbers) < len(parts):
            return None
        if node.is_Add or node.is_Mul or isinstance(node, sp.Min | sp.Max | sp.Abs | sp.sign):
            return node.func(*numbers)
        if node.is_Pow and len(numbers) == 2 and numbers[1].is_Integer and abs(numbers[1]) <= _LARGEST_POWER:
            value = numbers[0] ** numbers[1]
            return value if value.is_Rational else None
        return None


def holds_at(condition: Expr, point: Mapping[Expr, Expr]) -> bool:
    """Return whether a condition on real numbers holds at values of its symbols."""
    if condition in (sp.true, sp.false):
        return bool(condition)
    if isinstance(condition, sp.And | sp.Or):
        return (all if isinstance(condition, sp.And) else any)(holds_at(part, point) for part in condition.args)
    left, right = (number_at(side, point) for side in condition.args)
    return bool(condition.func(left, right))


def _chosen(expr: Expr, point: Mapping[Expr, Any]) -> Expr:
    """Return an expression with each kink replaced by what holds at a point."""
    nodes = expr.atoms(sp.Piecewise, sp.Min, sp.Max)
    return expr.xreplace({node: _decided(node, point) for node in nodes}) if nodes else expr


def _decided(node: Expr, point: Mapping[Expr, Any]) -> Expr:
    if isinstance(node, sp.Piecewise):
        return next(_chosen(part, point) for part, holds in node.args if holds_at(holds, point))
    values = {argument: number_at(argument, point) for argument in node.args}
    best = node.func(*values.values())
    return next(_chosen(argument, point) for argument, value in values.items() if value == best)

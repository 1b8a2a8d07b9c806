"""SymPy expressions as functions of balls: complex numbers with a radius, in Arb's arithmetic.

A ball function returns a ball that holds every value which the expression takes on its argument. Only the
functions of the table are translated. Where Arb integrates it asks whether a function is analytic on a whole
ball: a branch cut that is not reported gives a tight ball around a wrong number, so each function's cut is tested.
"""

import copyreg
import operator
from collections.abc import Callable, Iterable, Mapping
from functools import reduce
from typing import Any, TypeAlias, TypeVar, cast

import sympy as sp
from flint import acb, arb, arb_series, ctx, fmpq
from mpmath.libmp import mpf_pos, round_nearest

from stickslip_sym.core.aliases import Condition, Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import CONSTANTS, Function, fold, row
from stickslip_sym.core.interrupts import held_back
from stickslip_sym.core.numbers import NUMBER_BITS, bits
from stickslip_sym.core.precision import GUARD_BITS, middle_in_mpmath, working_precision

Z = TypeVar("Z", acb, arb_series)
BallFunction = Callable[[acb, bool], acb]
"""A function of a ball; the flag asks for a ball that is not finite where it is not analytic."""
Otherwise = Callable[[Expr, list[acb]], acb]
"""From a function that has no finite ball, and the balls of its arguments, to a ball around its value."""
Point: TypeAlias = Mapping[Expr, Expr | acb]
"""Numbers or balls for symbols."""
_Part: TypeAlias = acb | Callable[..., Any]
"""A ball where no variable stands in an expression, else a function of the variable and of the flag."""

_NOWHERE = acb("nan")
copyreg.pickle(arb, lambda ball: (arb, tuple(tuple(map(int, end.man_exp())) for end in (ball.mid(), ball.rad()))))


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


def ball_value(expr: Expr, point: Point, otherwise: Otherwise | None = None) -> acb:
    """Return a ball around the value of an expression at values of its symbols.

    A function that is not in the table is refused, unless `otherwise` encloses it.
    """
    decided = resolve_kinks(expr, point) if expr.has(sp.Piecewise) else expr
    return cast(acb, fold(decided, _Balls(point, otherwise=otherwise)))


def ball_function(expr: Expr, variable: Expr, point: Point) -> BallFunction:
    """Return an expression as a function of one symbol; it holds constants of the present working precision."""
    return _Balls(point, variable).function(expr)


def series_function(expr: Expr, variable: Expr, point: Point) -> Callable[[arb_series], arb_series]:
    """Return an expression as a function of a power series, with balls for coefficients; as `ball_function`."""
    function = _Series(point, variable).function(expr)

    def of_series(series: arb_series) -> arb_series:
        value = function(series, False)
        return arb_series([value], prec=ctx.cap) if isinstance(value, arb) else value

    return of_series


class _Balls:
    """The algebra of balls, and of functions of a variable with values in them.

    A part of an expression without the variable is computed once; any other becomes a function.
    """

    def __init__(self, point: Point, variable: Expr | None = None, otherwise: Otherwise | None = None) -> None:
        self.values: dict[Expr, _Part] = {
            symbol: value if isinstance(value, acb) else ball(value) for symbol, value in point.items()
        }
        if variable is not None:
            self.values[variable] = lambda z, analytic: z
        self.otherwise = otherwise

    def function(self, expr: Expr) -> Callable[..., Any]:
        """Return an expression as a function of the variable and of the flag."""
        return self._moving(fold(expr, self))

    def _moving(self, part: _Part) -> Callable[..., Any]:
        if callable(part):
            return part
        constant = self.constant(part)
        return lambda z, analytic: constant

    def __call__(self, node: Expr, parts: list[_Part]) -> _Part:
        if node.is_Number:
            return ball(node)
        if node in self.values:
            return self.values[node]
        if node in CONSTANTS:
            return CONSTANTS[node].ball()
        fixed = [part for part in parts if not callable(part)]
        if len(fixed) == len(parts):
            return self._constant(node, fixed)
        if (node.is_Add or node.is_Mul) and len(fixed) > 1:
            parts = [self._constant(node, fixed), *filter(callable, parts)]
        return self._applied(node, [self._moving(part) for part in parts])

    def _constant(self, node: Expr, balls: list[acb]) -> acb:
        """Return a node of balls; of a function that has no finite one what `otherwise` says."""
        function = row(node)
        if node.is_Add or node.is_Mul or (node.is_Pow and len(balls) == 2):
            return acb(_BALLS._applied(node, map(_BALLS._moving, balls))(_NOWHERE, False))
        if isinstance(node, sp.Min | sp.Max):
            return acb(reduce(arb.min if isinstance(node, sp.Min) else arb.max, [part.real for part in balls]))
        value = _NOWHERE
        if isinstance(node, sp.hyper):
            top = len(node.args[0])
            value = balls[-1].hypgeom([*balls[:top]], [*balls[top:-1]])
        elif function is not None and function.ball is not None:
            value = function.ball(*balls)
        elif self.otherwise is None or not isinstance(node, sp.Function):
            raise _not_enclosed(node.func)
        if self.otherwise is None or value.is_finite():
            return value
        return self.otherwise(node, balls)

    def _applied(self, node: Expr, parts: Iterable[Callable[..., Any]]) -> Callable[..., Any]:
        """Return a node as a function, from its arguments as functions."""
        if node.is_Add or node.is_Mul:
            join = operator.add if node.is_Add else operator.mul
            terms = list(parts)
            if len(terms) == 2:  # most of them, and faster so
                left, right = terms
                return lambda z, analytic: join(left(z, analytic), right(z, analytic))
            return lambda z, analytic: reduce(join, [term(z, analytic) for term in terms])
        first, *others = parts
        if node.is_Pow and others:
            if node.exp.is_Integer:
                count = int(node.exp)
                return lambda z, analytic: _whole_power(first(z, analytic), count)
            (exponent,) = others
            return lambda z, analytic: self.power(first(z, analytic), exponent(z, analytic), analytic)
        function = row(node)
        if function is None or function.ball is None:
            raise _not_enclosed(node.func)
        arguments = [first, *others]
        return lambda z, analytic: self.apply(function, [part(z, analytic) for part in arguments], analytic)

    # What follows is computed of balls here, and of power series in the class below.

    def constant(self, value: acb) -> Any:
        """Return a ball as a number of the arithmetic."""
        return value

    def power(self, base: Any, exponent: Any, analytic: bool) -> Any:
        """Return z^p: by the logarithm, and for p > 0 around 0, where there is none, within the largest size."""
        # A ball that is not finite holds 0 too, but says nothing of its size.
        if not analytic and exponent.real > 0 and exponent.imag == 0 and base.is_finite() and base.contains(0):
            if base == 0:
                size = arb(0)
            else:
                size = arb(base.abs_upper()) ** exponent.real
            around = arb(0, size.abs_upper())
            return acb(around, around)
        return base.pow(exponent, analytic)

    def apply(self, function: Function, arguments: list[Any], analytic: bool) -> Any:
        """Return the value of a function of the table."""
        if analytic and function.cut(*arguments):
            return _NOWHERE
        return cast(Any, function.ball)(*arguments)


class _Series(_Balls):
    """The algebra of balls, and of functions of a power series."""

    def constant(self, value: acb) -> arb:
        """Return a number, which joins any series: a series of it would keep its number of terms for good."""
        return value.real

    def power(self, base: Any, exponent: Any, analytic: bool) -> arb_series:
        """Return a power by the logarithm."""
        return cast(arb_series, (base.log() * exponent).exp())

    def apply(self, function: Function, arguments: list[arb_series], analytic: bool) -> arb_series:
        """Return the function of a series, by the integral of its derivative where the table has no rule."""
        if function.series is not None:
            return function.series(*arguments)
        (inner,) = arguments
        x = sp.Dummy()
        slope = series_function(function.kind(x).diff(x), x, {})(inner) * inner.derivative()
        onset: acb = super().apply(function, [acb(inner[0])], False)
        return slope.integral() + onset.real


_BALLS = _Balls({})


def _not_enclosed(kind: type[Expr]) -> InputError:
    return InputError(f"{kind.__name__} is not among the functions that are enclosed")


def _whole_power(z: Z, exponent: int) -> Z:
    """Multiply out: Arb's own power of a ball around 0 is not a number."""
    if exponent < 0:
        return 1 / _whole_power(z, -exponent)
    if exponent == 1:
        return z
    half = _whole_power(z, exponent // 2)
    if exponent % 2:
        return half * half * z
    return half * half


def integrated(integrand: BallFunction, low: acb, high: acb, **bounds: Any) -> acb:
    """Return a ball around an integral by Arb's adaptive rules: the one door to `acb.integral`.

    An exception in the integrand must not pass through Arb, which goes on calling with the exception pending. It
    is kept and raised afterwards, and the rest of the integrand counts as 0, so that Arb ends at once.

    - `bounds`: on Arb's work, as `eval_limit`.
    """
    failures: list[BaseException] = []

    def guarded(z: acb, analytic: bool) -> acb:
        if failures or interrupt.came:
            return acb(0)
        try:
            return integrand(z, analytic)
        except BaseException as failure:
            failures.append(failure)
            return acb(0)

    while True:
        with held_back() as interrupt:
            total = acb.integral(guarded, low, high, **bounds)
        if failures:
            raise failures.pop()
        if not interrupt.came:  # else a handler of the user's lets the program go on: once more, undisturbed
            return total


# -- numbers, and which piece of an expression holds -----------------------------------------------


def number_at(expr: Expr, point: Point) -> Expr:
    """Return the value of a real expression as a SymPy number, without ever expanding a power of long fractions.

    It is exact where sums, products, whole powers, Abs, Min, Max and pieces suffice, else a Float of 4000 bits;
    NaN where there is no finite real value.
    """
    if expr.has(sp.Piecewise):
        expr = resolve_kinks(expr, point)
    if (exact := fold(expr, _rationals(point))) is not None:
        return exact
    with working_precision(NUMBER_BITS + GUARD_BITS):
        value = ball_value(expr, point)
        if not (value.is_finite() and value.imag.contains(0)):
            return sp.nan
    return sp.Float._new(mpf_pos(middle_in_mpmath(value.real)._mpf_, NUMBER_BITS, round_nearest), NUMBER_BITS)


def place_at(place: Expr, point: Point) -> Expr:
    """Return the value of the place of a kink as `number_at`, and infinity where what it is divided by falls to 0.

    As of Max(q - a v, 0), a >= 0: the kink q/a moves beyond all speeds.
    """
    value = fold(place, _rationals(point, endless=True))
    if value is None:
        return number_at(place, point)
    return value


def _rationals(point: Point, *, endless: bool = False) -> Callable[[Expr, list[Expr | None]], Expr | None]:
    """Return the algebra of exact rationals, and of None for what is none or takes a longer computation.

    `endless` takes the inverse of a positive parameter that is 0 for infinity.
    """

    def value(node: Expr, parts: list[Expr | None]) -> Expr | None:
        known = [part for part in parts if part is not None]
        if len(known) < len(parts):
            return None
        if not known:
            number = point.get(node, node)
        elif endless and node.is_Pow and known[0] == 0 and node.base.is_positive and node.exp.is_negative:
            return sp.oo
        elif node.is_Add or node.is_Mul or isinstance(node, sp.Abs | sp.sign | sp.Min | sp.Max):
            number = node.func(*known)
        elif node.is_Pow and len(known) == 2 and known[1].is_Integer and _is_short_power(*known):
            number = known[0] ** known[1]
        else:
            return None
        if isinstance(number, acb):
            return None
        if number.is_Rational or (endless and number in (sp.oo, -sp.oo)):
            return number
        return None

    return value


def _is_short_power(base: Expr, exponent: Expr) -> bool:
    """Whether a whole power is no longer than a number may be."""
    return not base.is_Rational or bits(base) * abs(int(exponent)) <= NUMBER_BITS


_COMPARISONS = {
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne,
}  # fmt: skip


def resolve_kinks(expr: Expr, point: Point) -> Expr:
    """Return an expression with each kink replaced by what holds at a point; its other symbols stay."""
    if isinstance(expr, sp.Piecewise):  # looking through all pieces takes long where they are many
        return _decided(expr, point)
    return expr.xreplace({node: _decided(node, point) for node in expr.atoms(sp.Piecewise, sp.Min, sp.Max)})


def _decided(node: Expr, point: Point) -> Expr:
    if isinstance(node, sp.Piecewise):
        return next(resolve_kinks(part, point) for part, holds in node.args if _holds(holds, point))
    values = {argument: number_at(argument, point) for argument in node.args}
    best = node.func(*values.values())
    return next(resolve_kinks(argument, point) for argument, value in values.items() if value == best)


def _holds(condition: Condition, point: Point) -> bool:
    if isinstance(condition, sp.And | sp.Or):
        return (all if isinstance(condition, sp.And) else any)(_holds(part, point) for part in condition.args)
    if not isinstance(condition, sp.core.relational.Relational):
        return bool(condition)
    left, right = (place_at(side, point) for side in condition.args)
    return bool(_COMPARISONS[condition.rel_op](left, right))  # SymPy's relations ask for assumptions, at length

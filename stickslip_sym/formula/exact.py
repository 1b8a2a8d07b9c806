"""Formulas at exact values, to any number of digits, in ball arithmetic.

Two precisions that agree prove little: log(1 + exp(-1000)) is 0 in both. A ball carries the bound of its error, so
the precision rises until the radius is small. What Arb does not enclose, such as a hypergeometric function of a
large argument, mpmath evaluates; its value counts as a ball as wide as two precisions differ.
"""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache

import mpmath
import sympy as sp
from flint import acb, arb, ctx

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Mpf, Substitution
from stickslip_sym.core.balls import ball_value
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.functions import arguments, write_sech
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.precision import GUARD_BITS, ball_of_mpmath, middle_in_mpmath, mp, refined, rounded
from stickslip_sym.criteria.quadrature import MOST_DIGITS, MOST_DIGITS_LOST
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.numerics.known import Unknown

_MOST_EXACT_BITS = math.ceil(MOST_DIGITS * math.log2(10))
"""Of working precision, before a value counts as out of reach."""
_BITS_LOST = math.ceil(MOST_DIGITS_LOST * math.log2(10))
"""Beyond those asked for, before a formula is taken apart by exact arithmetic, which takes long."""


def to_digits(expr: Expr, point: Substitution, digits: int) -> Mpf:
    """Evaluate an expression at exact rational values to `digits` significant digits, as `to_ball` does."""
    value, _ = to_ball(expr, point, digits)
    return rounded(middle_in_mpmath(value), digits)


def to_ball(expr: Expr, point: Substitution, digits: int) -> tuple[arb, bool]:
    """Return a ball around an expression, its relative radius below 10^-digits, and whether Arb alone made it.

    A zero is believed only where the arithmetic of rationals gives it: everywhere else all digits cancelled.
    """
    goal = math.ceil(digits * math.log2(10)) + 4
    alone = True

    def computed() -> arb:
        nonlocal alone
        try:
            value, alone = formula_ball(expr, point)
        except (ZeroDivisionError, ValueError, OverflowError):
            raise _no_value(point) from None
        if value.is_finite() and not value.imag.contains(0):
            raise _no_value(point)
        return value.real

    for most in (min(goal + _BITS_LOST, _MOST_EXACT_BITS), _MOST_EXACT_BITS):
        value = refined(computed, goal, most)
        if value.is_finite() and value.rel_accuracy_bits() >= goal:
            return value, alone
        # What is the same and cancels for good, SymPy's rationals see; other powers it would factor for minutes.
        if all((2 * node.exp.xreplace(dict(point))).is_integer for node in expr.atoms(sp.Pow)):
            expr = expr.xreplace(dict(point))
            if expr.has(sp.zoo, sp.nan, sp.oo, -sp.oo):
                raise _no_value(point)
    if value.is_finite():
        raise NotConverged(f"{digits} digits are out of reach of {_MOST_EXACT_BITS} bits of working precision")
    raise _no_value(point)


def formula_ball(expr: Expr, point: Mapping[Expr, Expr | acb]) -> tuple[acb, bool]:
    """Return a ball around an expression at the working precision, and whether Arb alone made it."""
    asked: list[Expr] = []

    def otherwise(node: Expr, arguments: list[acb]) -> acb:
        asked.append(node)
        return _evaluate_by_mpmath(node, arguments)

    return ball_value(expr, point, otherwise), not asked


def _evaluate_by_mpmath(node: Expr, arguments: list[acb]) -> acb:
    """Return a ball around a function as mpmath evaluates it, its error seen by moved arguments and by digits."""
    if not all(argument.is_finite() for argument in arguments):
        return acb("nan")
    entire = isinstance(node, sp.hyper) and len(node.ap) == len(node.bq) > 2
    if entire and arguments[-1].abs_lower() > _MOST_EXACT_BITS * math.log(2):  # so many cancel
        raise NotConverged("a hypergeometric series of the closed form is too long")
    function = _compile_packed(
        node.func, tuple(len(a) if isinstance(a, sp.Tuple) else 0 for a in node.args), mp.context
    )
    places = [middle_in_mpmath(argument) for argument in arguments]

    def value(places: list[Mpf]) -> Mpf:
        return mp.mpmathify(function(*places))

    try:
        with mp.workprec(ctx.prec):
            rough = value(places)
            error = mp.ldexp(abs(rough), 2 - ctx.prec)
            for i, argument in enumerate(arguments):
                if radius := middle_in_mpmath(arb(argument.rad())):
                    step = mp.mpc(radius, radius) if argument.imag != 0 else radius
                    moved = [value([*places[:i], places[i] + way * step, *places[i + 1 :]]) for way in (1, -1)]
                    error += 2 * sum(abs(value - rough) for value in moved)
        with mp.workprec(ctx.prec + GUARD_BITS):
            fine = value(places)
            error += 2 * abs(fine - rough)
    except mp.NoConvergence as failure:
        raise NotConverged(f"a special function of the closed form could not be evaluated: {failure}") from None
    return ball_of_mpmath(fine, error)


@lru_cache
def _compile_packed(kind: type[Expr], lengths: tuple[int, ...], context: mpmath.MPContext) -> Callable[..., Mpf]:
    """Compile a function, of whose arguments some are tuples of so many."""
    node = kind(*(sp.Tuple(*sp.symbols(f"x:{n}", cls=sp.Dummy)) if n else sp.Dummy() for n in lengths))
    return function_of(arguments(node), node, context)


def _no_value(point: Substitution) -> InputError:
    zeros = ", ".join(f"{symbol} = 0" for symbol, value in point.items() if value == 0)
    hint = f": it divides by zero at {zeros}; take a small value, or use quadrature.damping" if zeros else ""
    return InputError(f"the closed form has no finite real value at these parameters{hint}")


def exact_value(expr: Expr, slope: Expr, point: Substitution, digits: int) -> Mpf:
    """Evaluate a closed form at exact values to `digits` digits; at V = 0 by its limit -N mu'(0+)."""
    if point[symbols.V] == 0:
        limit = symbolic_limit_at_rest(slope, point)
        if isinstance(limit, Unknown) or limit.is_infinite:
            raise InputError("the slope of mu is infinite at v = 0, so the criterion has no value at V = 0")
        expr = -symbols.N * limit
    return to_digits(write_sech(expr), point, digits)

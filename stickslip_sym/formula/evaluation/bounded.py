"""Values of formulas together with bounds of their rounding errors, in mpmath at its working precision.

Two precisions that agree prove little: log(1 + exp(-1000)) is 0 in both. So each operation adds its own rounding
to what it takes over from its arguments, and a sum in which all digits cancel, or a term that vanished beside a
larger one, shows in the bound. What is rational stays exact, so that zeros are zeros and kinks have a side.
"""

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

import mpmath
import sympy as sp

from stickslip_sym.core.lambdify import function_of

__all__ = ["Bounded", "Uncertain", "bounded"]

_LONGEST = 1 << 16  # bits of a fraction that is kept exact
_STEP = 2.0**-40  # of an argument's size, over which the slope of a function is taken
_SLOPE_BITS = 120  # of precision for that
_PHASE = 2.0**-8  # radians of error in the argument of what oscillates, beyond which its value says nothing
_ROUNDING = 4  # half units in the last place that an operation may add
_OSCILLATING = (sp.sin, sp.cos, sp.tan, sp.besselj, sp.bessely)


class Uncertain(ArithmeticError):
    """At this precision not even the sign, or the branch, of something within a formula is known."""


class Bounded(NamedTuple):
    """A value and the bound of its absolute error; a fraction is exact."""

    value: Any
    error: Any

    @property
    def is_exact(self) -> bool:
        """Whether the value is a rational number known exactly."""
        return isinstance(self.value, Fraction)


def bounded(expr: Any, known: Mapping[Any, Bounded]) -> Bounded:
    """Evaluate an expression at mpmath's working precision.

    Parameters
    ----------
    expr : sympy.Expr
    known : mapping
        Symbols, or whatever else has a value already.

    Raises
    ------
    Uncertain
        Where more digits are needed to go on.
    ZeroDivisionError, ValueError
        Where the formula has no value.
    """
    return _Evaluation(known)(expr)


def _unit() -> Any:
    return mpmath.ldexp(_ROUNDING, -mpmath.mp.prec)


def _exact(value: Any) -> Bounded:
    fraction = Fraction(value)
    if max(fraction.numerator.bit_length(), fraction.denominator.bit_length()) > _LONGEST:
        return _rounded(Bounded(fraction, 0))
    return Bounded(fraction, mpmath.mpf(0))


def _rounded(given: Bounded) -> Bounded:
    """Return a value in floating point."""
    if not given.is_exact:
        return given
    value = mpmath.mpf(given.value.numerator) / given.value.denominator
    whole = given.value.denominator == 1 and given.value.numerator.bit_length() <= mpmath.mp.prec
    return Bounded(value, mpmath.mpf(0) if whole else _unit() * abs(value))


class _Evaluation:
    """One evaluation; each node is computed once."""

    def __init__(self, known: Mapping[Any, Bounded]) -> None:
        self.found = dict(known)

    def __call__(self, node: Any) -> Bounded:
        found = self.found.get(node)
        if found is None:
            found = self.found[node] = self._compute(node)
            if not found.is_exact and not (mpmath.isfinite(found.value) and mpmath.isfinite(found.error)):
                raise ValueError(f"{node.func} has no finite value")
        return found

    def _compute(self, node: Any) -> Bounded:
        if node.is_Rational:
            return _exact(Fraction(int(node.p), int(node.q)))
        if node.is_Float:
            return _exact(Fraction(*map(int, sp.Rational(node).as_numer_denom())))
        if node is sp.I:
            return Bounded(mpmath.mpc(0, 1), mpmath.mpf(0))
        if isinstance(node, sp.Piecewise):
            return self(next(branch for branch, condition in node.args if self._holds(condition)))
        if node.is_Atom:
            value = function_of([], node, "mpmath")()
            return Bounded(mpmath.mpmathify(value), _unit() * abs(value))
        if node.is_Add:
            return _sum([self(term) for term in node.args])
        if node.is_Mul:
            return _product([self(factor) for factor in node.args])
        if node.is_Pow:
            return _power(self(node.base), self(node.exp))
        if isinstance(node, sp.Min | sp.Max):
            return _extreme([self(part) for part in node.args], max if isinstance(node, sp.Max) else min)
        return self._function(node)

    def _function(self, node: Any) -> Bounded:
        leaves = _leaves(node)
        arguments = [self(leaf) for leaf in leaves]
        if any(argument.value in (0, 1) for argument in arguments if argument.is_exact):
            # exp(0), log(1): what is rational there is so exactly.
            plain = {
                leaf: sp.Rational(argument.value.numerator, argument.value.denominator)
                for leaf, argument in zip(leaves, arguments, strict=True)
                if argument.is_exact
            }
            value = node.xreplace(plain)
            if value.is_Rational:
                return self._compute(value)
        arguments = [_rounded(argument) for argument in arguments]
        if isinstance(node, sp.re | sp.im):
            ((value, error),) = arguments
            return Bounded(mpmath.re(value) if isinstance(node, sp.re) else mpmath.im(value), error)
        if isinstance(node, sp.Abs):
            return Bounded(abs(arguments[0].value), arguments[0].error)
        function = _compiled(node, tuple(leaves))
        return _propagated(function, arguments, isinstance(node, _OSCILLATING))

    def _holds(self, condition: Any) -> bool:
        if condition in (sp.true, sp.false):
            return bool(condition)
        if isinstance(condition, sp.And | sp.Or):
            return (all if isinstance(condition, sp.And) else any)(self._holds(part) for part in condition.args)
        if isinstance(condition, sp.Not):
            return not self._holds(condition.args[0])
        value, error = _sum([self(condition.lhs), _product([self(condition.rhs), _exact(-1)])])
        if not isinstance(value, Fraction) and abs(value) <= error:
            raise Uncertain(f"which side of {condition} holds is not known")
        return bool(condition.func(sp.Integer((value > 0) - (value < 0)), 0))


def _sum(terms: list[Bounded]) -> Bounded:
    exact = sum((term.value for term in terms if term.is_exact), Fraction(0))
    others = [term for term in terms if not term.is_exact]
    if not others:
        return _exact(exact)
    if exact:
        others.append(_rounded(Bounded(exact, 0)))
    value = mpmath.fsum(term.value for term in others)
    return Bounded(value, mpmath.fsum(term.error for term in others) + _unit() * abs(value))


def _product(factors: list[Bounded]) -> Bounded:
    exact = math.prod((factor.value for factor in factors if factor.is_exact), start=Fraction(1))
    others = [factor for factor in factors if not factor.is_exact]
    if not others or not exact:
        return _exact(exact)
    if exact != 1:
        others.append(_rounded(Bounded(exact, 0)))
    value, error = others[0]
    for other in others[1:]:
        error = error * (abs(other.value) + other.error) + abs(value) * other.error
        value = value * other.value
        error += _unit() * abs(value)
    return Bounded(value, error)


def _power(base: Bounded, exponent: Bounded) -> Bounded:
    if exponent.value == 0 and exponent.is_exact:
        return _exact(1)
    if base.is_exact and base.value == 0:
        x = _rounded(exponent)
        if x.value > x.error:
            return _exact(0)
        raise ZeroDivisionError("a power of 0 that is not positive")
    if base.is_exact and exponent.is_exact:
        root = _exact_power(base.value, exponent.value)
        if root is not None:
            return root
    whole = exponent.is_exact and exponent.value.denominator == 1
    b, x = _rounded(base), _rounded(exponent)
    size, slack = abs(b.value), 4 * (abs(x.value) + 1) * b.error
    if slack >= size:
        raise Uncertain("the base of a power is not known well enough")
    value = mpmath.power(b.value, int(exponent.value) if whole else x.value)
    relative = abs(x.value) * b.error / (size - slack) + 3 * _unit()
    if not whole:
        relative += abs(mpmath.log(b.value)) * x.error
    return Bounded(value, abs(value) * relative)


def _exact_power(base: Fraction, exponent: Fraction) -> Bounded | None:
    """Return a rational power of a rational if it is rational, and no longer than what is kept exact."""
    bits = max(base.numerator.bit_length(), base.denominator.bit_length())
    if exponent.denominator == 2 and base > 0:
        roots = math.isqrt(base.numerator), math.isqrt(base.denominator)
        if roots[0] ** 2 != base.numerator or roots[1] ** 2 != base.denominator:
            return None
        base, exponent = Fraction(*roots), 2 * exponent
    if exponent.denominator != 1 or bits * abs(exponent.numerator) > _LONGEST:
        return None
    return _exact(base**exponent.numerator)


def _extreme(parts: list[Bounded], select: Callable[[list[Any]], Any]) -> Bounded:
    if all(part.is_exact for part in parts):
        return _exact(select([part.value for part in parts]))
    values = [_rounded(part) for part in parts]
    if any(isinstance(part.value, mpmath.mpc) for part in values):
        raise ValueError("Min and Max compare real numbers")
    value = select([part.value for part in values])
    high, low = (select([part.value + sign * part.error for part in values]) for sign in (1, -1))
    return Bounded(value, max(high - value, value - low, mpmath.mpf(0)))


def _propagated(function: Callable[..., Any], arguments: list[Bounded], oscillating: bool) -> Bounded:
    """Evaluate a function, and follow its arguments' errors by taking it at their ends."""
    values = [argument.value for argument in arguments]
    result = mpmath.mpmathify(function(*values))
    error = _unit() * abs(result)
    for i, (value, doubt) in enumerate(arguments):
        if doubt == 0:
            continue
        if oscillating and doubt > _PHASE:
            raise Uncertain("the phase of an oscillation is not known")

        def moved(step: Any, i: int = i, value: Any = value) -> Any:
            step = step * mpmath.mpc(1, 1) if isinstance(value, mpmath.mpc) else step
            try:
                found = mpmath.mpmathify(function(*values[:i], value + step, *values[i + 1 :]))
            except (ZeroDivisionError, ValueError):
                raise Uncertain("a function may have no value there") from None
            if isinstance(found, mpmath.mpc) and not isinstance(result, mpmath.mpc):
                raise Uncertain("a function may not be real there")
            return abs(found - result)

        step = min(abs(value), 1) * _STEP
        if doubt <= step:
            # A slope needs few digits, and special functions are cheap there.
            with mpmath.workprec(min(mpmath.mp.prec, _SLOPE_BITS + max(0, mpmath.mag(value)))):
                error += 2 * (moved(step) / step) * doubt
        else:
            error += 2 * (moved(doubt) + moved(-doubt))
    return Bounded(result, error)


def _leaves(node: Any) -> list[Any]:
    """Return the arguments of a function that are no plain numbers; hypergeometric ones stand in tuples."""
    found: dict[Any, None] = {}
    for argument in node.args:
        for part in argument if isinstance(argument, sp.Tuple) else (argument,):
            if not part.is_Rational:
                found[part] = None
    return list(found)


_SLOTS = [sp.Dummy(f"slot{i}") for i in range(12)]


def _compiled(node: Any, leaves: tuple[Any, ...]) -> Callable[..., Any]:
    slots = tuple(_SLOTS[: len(leaves)])
    named = dict(zip(leaves, slots, strict=True))
    arguments = [
        sp.Tuple(*[named.get(part, part) for part in argument])
        if isinstance(argument, sp.Tuple)
        else named.get(argument, argument)
        for argument in node.args
    ]
    return _function_of(node.func(*arguments), slots)


@lru_cache(maxsize=512)
def _function_of(expr: Any, slots: tuple[Any, ...]) -> Callable[..., Any]:
    return function_of(slots, expr, "mpmath")

"""An expression at a point, integrals and all, with the error of what comes out.

Integrals are split where the integrand has a kink, a jump or an infinite value, and taken by two degrees
of the tanh-sinh rule, which goes near the ends, where an integrand may be infinite. What the two differ by is an
error.
"""

from collections.abc import Mapping
from itertools import combinations, pairwise

import mpmath
import sympy as sp
from flint import arb
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.balls import working_precision
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.formula.exact import formula_ball, from_mpmath, in_mpmath
from stickslip_sym.formula.proof.normal_form import single_limit

__all__ = ["NotFinite", "certain_value"]

_PRECISIONS = (98, 196, 392, 784)  # bits, from 30 digits, at which a formula is taken until its error is small
_ENOUGH = 83  # bits of a value, 25 digits, that are enough
_DIGITS = 60  # of the quadrature: next to an end, a root's integral below the rounding of x is below 1e-30
_DEGREES = (7, 8)  # of the tanh-sinh rule: it halves its step so many times
_LOST = 30  # digits that count as rounding
_NEAR_BITS = 400  # for the integrand there
_NEAR = tuple(sp.Rational(1, 10**k) for k in (12, 24))  # of the way to a place where the integrand may be infinite


class NotFinite(ArithmeticError):
    """An expression that has no finite value, for certain; the message says where it fails."""


def certain_value(expr: Expr, point: Mapping[Expr, Expr]) -> tuple[Mpf, Mpf]:
    """Return an expression at exact values of its symbols and examples of its functions, and an error bound.

    Raises
    ------
    NotFinite
        If it has none.
    NotConverged
        If its value could not be had with any certainty.
    """
    for function, example in point.items():
        if isinstance(example, sp.Lambda):
            expr = expr.replace(function, example)
    expr = expr.replace(lambda node: isinstance(node, sp.Derivative | sp.Subs), lambda node: node.doit())
    if expr.has(AppliedUndef):
        raise NotConverged(f"{expr} holds a function without a value")
    values = {key: value for key, value in point.items() if not isinstance(value, sp.Lambda)}
    integrals = expr.atoms(sp.Integral)
    inner = set().union(*(arg.atoms(sp.Integral) for node in integrals for arg in node.args))
    outer = {node: sp.Dummy(real=True) for node in integrals - inner}
    known = {symbol: from_mpmath(*_integral(node.subs(values))) for node, symbol in outer.items()}
    expr = expr.xreplace(outer).xreplace(values)
    if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise NotFinite(f"it is {expr}")
    for bits in _PRECISIONS:
        with working_precision(bits):
            try:
                value, _ = formula_ball(expr, known)
            except InputError as failure:
                raise NotConverged(str(failure)) from None
            except (ZeroDivisionError, ValueError, OverflowError) as failure:
                raise NotFinite(str(failure) or "a function has no value there") from None
            if value.is_finite() and (value.rel_accuracy_bits() >= _ENOUGH or bits == _PRECISIONS[-1]):
                return in_mpmath(value), in_mpmath(arb(value.rad()))
    raise NotConverged("its value is not certain")


def _integral(integral: Expr) -> tuple[Mpf, Mpf]:
    """Return an integral of numbers and its error."""
    if not isinstance(integral, sp.Integral) or integral.function.is_polynomial(*integral.variables):
        return certain_value(integral.doit(), {})
    try:
        variable, low, high = single_limit(integral)
    except ValueError as failure:
        raise NotConverged(str(failure)) from None
    if not (low.is_real and high.is_real and low.is_finite and high.is_finite):
        raise NotConverged(f"the limits of {integral} are not finite")
    # As limits of the variable only: its assumptions are the user's, and must not decide anything here.
    x = sp.Dummy(variable.name, real=True)
    f = integral.function.xreplace({variable: x})
    between = [place for place in _places(f, x) if min(low, high) < place < max(low, high)]
    ends = [low, *sorted(between, key=sp.N, reverse=bool(low > high)), high]
    for left, right in pairwise(ends):
        _require_integrable(f, x, left, right - left)
        _require_integrable(f, x, right, left - right)
    function = function_of([x], f, "mpmath")
    with mpmath.workdps(_DIGITS):
        nodes = [mpmath.mpmathify(function_of([], end, "mpmath")()) for end in ends]

        def inside(place: Mpf) -> Mpf:
            return function(place) if place not in nodes else mpmath.mpf(0)  # the rule's weight there is nothing

        try:
            rough, fine = (mpmath.quad(inside, nodes, maxdegree=degree) for degree in _DEGREES)
        except (ZeroDivisionError, ValueError):
            raise NotConverged("the integrand has no value somewhere") from None
        return fine, 2 * abs(fine - rough) + abs(fine) * mpmath.mpf(10) ** (_LOST - _DIGITS)


def _places(f: Expr, x: Expr) -> list[Expr]:
    """Return the real places where an integrand may have a kink, a jump, or no finite value."""
    suspects = {relation.lhs - relation.rhs for relation in f.atoms(Relational)}
    suspects |= {node.args[0] for node in f.atoms(sp.Abs, sp.sign, sp.log)}
    suspects |= {a - b for node in f.atoms(sp.Min, sp.Max) for a, b in combinations(node.args, 2)}
    suspects |= {node.base for node in f.atoms(sp.Pow) if not (node.exp.is_Integer and node.exp > 0)}
    found: set[Expr] = set()
    for suspect in suspects:
        numerator = sp.numer(sp.together(suspect))
        if numerator.has(x) and numerator.is_polynomial(x):
            polynomial = sp.Poly(numerator, x)
            if polynomial.degree() == 1:
                found.add(-polynomial.nth(0) / polynomial.nth(1))
            elif polynomial.domain.is_QQ or polynomial.domain.is_ZZ:
                found |= set(polynomial.real_roots())
    return [place for place in found if place.is_real]


def _require_integrable(f: Expr, x: Expr, place: Expr, way: Expr) -> None:
    """Refuse an integrand that grows like 1/x or faster towards a place."""
    sizes = []
    for share in _NEAR:
        with working_precision(_NEAR_BITS):
            try:
                found, _ = formula_ball(f.xreplace({x: place + share * way}), {})
            except (InputError, NotConverged, ArithmeticError, ValueError):
                return
            if not found.rel_accuracy_bits() > 3:
                return
            sizes.append(abs(in_mpmath(found)) * mpmath.mpf(share.p) / share.q)
    if sizes[0] > 0 and sizes[1] > sizes[0] / 2:
        raise NotFinite(f"the integrand grows like 1/x or faster at {place}")

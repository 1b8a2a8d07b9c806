"""An expression at a point, integrals and all, with the error of what comes out.

Integrals are split where the integrand has a kink, a jump or an infinite value, and taken twice, at two precisions
of the tanh-sinh rule: it takes no value at the ends, which may be infinite. What the two differ by is an error.
"""

from collections.abc import Callable, Mapping
from itertools import pairwise

import mpmath
import sympy as sp
from flint import arb
from sympy.core.function import AppliedUndef

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.balls import working_precision
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.formula.exact import formula_ball, from_mpmath, in_mpmath

__all__ = ["NotFinite", "certain_value"]

_PRECISIONS = (98, 196, 392, 784)  # bits, from 30 digits, at which a formula is taken until its error is small
_ENOUGH = 83  # bits of a value, 25 digits, that are enough
_QUADRATURES = (28, 42)  # digits of the two quadratures
_MOST_DEGREE = 9  # of the tanh-sinh rule: it halves its step so many times
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
    functions = {key: value for key, value in point.items() if isinstance(value, sp.Lambda)}
    for function, example in functions.items():
        expr = expr.replace(function, example)
    expr = expr.replace(lambda node: isinstance(node, sp.Derivative | sp.Subs), lambda node: node.doit())
    if expr.has(AppliedUndef):
        raise NotConverged(f"{expr} holds a function without a value")
    if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo) and not expr.has(sp.Integral):
        raise NotFinite(f"it is {expr}")
    plain = {key: value for key, value in point.items() if key not in functions}
    integrals = {node: sp.Dummy(real=True) for node in _outermost_integrals(expr)}
    known = {symbol: from_mpmath(*_integral(node, plain)) for node, symbol in integrals.items()}
    expr = expr.xreplace(integrals).xreplace(plain)
    if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise NotFinite("a function has no value there")
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


def _outermost_integrals(expr: Expr) -> list[Expr]:
    found: dict[Expr, None] = {}
    walk = sp.preorder_traversal(expr)
    for node in walk:
        if isinstance(node, sp.Integral):
            found[node] = None
            walk.skip()
    return list(found)


def _integral(integral: Expr, point: Mapping[Expr, Expr]) -> tuple[Mpf, Mpf]:
    """Return an integral and its error."""
    integral = integral.subs(point)
    if not isinstance(integral, sp.Integral) or integral.function.is_polynomial(*integral.variables):
        return certain_value(integral.doit(), {})
    if len(integral.limits) != 1 or len(integral.limits[0]) != 3:
        raise NotConverged(f"{integral} is not a definite integral over one variable")
    x, low, high = integral.limits[0]
    if not (low.is_real and high.is_real and low.is_finite and high.is_finite):
        raise NotConverged(f"the limits of {integral} are not finite")
    # As limits of the variable only: its assumptions are the user's, and must not decide anything here.
    bare = sp.Dummy(x.name, real=True)
    f = integral.function.xreplace({x: bare})
    sign = 1
    if low > high:
        low, high, sign = high, low, -1
    inside = sorted((place for place in _places(f, bare) if low < place < high), key=sp.N)
    ends = [low, *inside, high]
    for left, right in pairwise(ends):
        _require_integrable(f, bare, left, right - left)
        _require_integrable(f, bare, right, left - right)
    function = function_of([bare], f, "mpmath")
    results = []
    for digits in _QUADRATURES:
        with mpmath.workdps(digits):
            places = [function_of([], end, "mpmath")() for end in ends]
            places = [mpmath.mpmathify(place) for place in places]
            panels = [_panel(function, left, right) for left, right in pairwise(places)]
        results.append(panels)
    with mpmath.workdps(_QUADRATURES[-1]):
        (rough, _), (fine, doubt) = ([mpmath.fsum(column) for column in zip(*panels, strict=True)]
                                     for panels in results)  # fmt: skip
        size = mpmath.fsum(panel[0] for panel in results[-1])
        error = 2 * abs(fine - rough) + doubt + abs(size) * mpmath.mpf(10) ** (2 - _QUADRATURES[-1])
        return sign * fine, error


def _panel(function: Callable[[Mpf], Mpf], left: Mpf, right: Mpf) -> tuple[Mpf, Mpf]:
    """Integrate between two places at which the integrand may be infinite; return also an estimate of the error.

    With x = left + h t^4 near the left end, and likewise at the right one, roots and logarithms are followed far
    below the rounding of x itself.
    """
    middle = (left + right) / 2
    total, doubt = mpmath.mpf(0), mpmath.mpf(0)
    for end, h in ((left, middle - left), (right, middle - right)):

        def part(t: Mpf, end: Mpf = end, h: Mpf = h) -> Mpf:
            distance = h * t**4
            with mpmath.extradps(mpmath.mp.dps):
                x = end + distance
                if x == end:
                    return mpmath.mpf(0)  # the rule's weight there is nothing
                value = function(x)
            return 4 * abs(h) * t**3 * value

        try:
            value, error = mpmath.quad(part, [0, 1], error=True, maxdegree=_MOST_DEGREE)
        except (ZeroDivisionError, ValueError):
            raise NotConverged("the integrand has no value somewhere") from None
        total += value
        doubt += error
    return total, doubt


def _places(f: Expr, x: Expr) -> list[Expr]:
    """Return the real places where an integrand may have a kink, a jump, or no finite value."""
    suspects: set[Expr] = set()
    for node in sp.preorder_traversal(f):
        if isinstance(node, sp.Piecewise):
            for _, condition in node.args:
                suspects |= {part.lhs - part.rhs for part in condition.atoms(sp.core.relational.Relational)}
        elif isinstance(node, sp.Abs | sp.sign | sp.log):
            suspects.add(node.args[0])
        elif isinstance(node, sp.Min | sp.Max):
            suspects |= {first - second for first in node.args for second in node.args if first != second}
        elif node.is_Pow and not (node.exp.is_Integer and node.exp > 0):
            suspects.add(node.base)
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

"""Where a formula is known to be continuous, analytic or positive."""

from collections.abc import Callable

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import Lerch, is_analytic

__all__ = ["is_positive", "is_smooth"]


def is_smooth(expr: Expr, x: Expr, *, inside: bool = True) -> bool:
    """Tell whether an expression is known to be continuous for all x that the assumptions of x allow.

    So an integral over [-1, 1] whose variable is nonnegative would be misjudged: who integrates compares the
    limits with the assumptions of the variable. Unless `inside` of another function, poles do not matter, and
    analytic is asked for: where a formula equals a function without poles except at isolated places, it has none.
    """
    if not expr.has(x) or expr == x:
        return True
    if isinstance(expr, sp.core.function.AppliedUndef | sp.Derivative | sp.Subs):
        return True  # unknown functions are as smooth as the derivation takes them
    rational = expr.is_Add or expr.is_Mul or (expr.is_Pow and expr.exp.is_Integer)
    if expr.is_Pow and not isinstance(expr, sp.exp):
        base, exponent = expr.args
        whole = exponent.is_Integer and (exponent > 0 or not inside)
        from_zero = inside and not exponent.has(x) and base.is_nonnegative and exponent.is_positive
        fine = bool(whole or from_zero or is_positive(base, x))
    else:
        domain = _DOMAINS.get(expr.func) or _DOMAINS.get(expr.func.__base__)
        fine = is_analytic(expr) if domain is None else bool(domain(x, *expr.args))
    return fine and all(
        is_smooth(argument, x, inside=inside or not rational)
        for argument in expr.args
        if not isinstance(argument, sp.Tuple)
    )


def _of_series(x: Expr, upper: Expr, lower: Expr, z: Expr) -> bool:
    converges = len(upper) <= len(lower) or (len(upper) == len(lower) + 1 and _below_one(x, z))
    return converges and not any(b.is_integer and b.is_nonpositive for b in lower)


def _below_one(x: Expr, *arguments: Expr) -> bool:
    return all(is_positive(sp.factor(1 - argument), x) for argument in arguments)


_DOMAINS: dict[type[Expr], Callable[..., bool | None]] = {
    sp.log: lambda x, z: is_positive(z, x) or is_positive(sp.factor(z), x),
    sp.lowergamma: lambda x, s, z: s.is_positive and z.is_nonnegative,
    sp.expint: lambda x, s, z: is_positive(z, x),
    sp.polylog: lambda x, s, z: z.is_imaginary or _below_one(x, z),
    Lerch: lambda x, z, s, a: z.is_nonpositive,
    sp.im: lambda x, z: True,
    sp.hyper: _of_series,
    sp.elliptic_e: _below_one,
    sp.elliptic_k: _below_one,
    sp.elliptic_pi: _below_one,
    sp.besseli: lambda x, order, z: order.is_Integer,
    sp.besselj: lambda x, order, z: order.is_Integer,
}
"""Where a function is analytic that is not so at every real argument."""


def is_positive(expr: Expr, x: Expr) -> bool:
    """Tell whether an expression is known to be positive: by signs, as a quadratic, or by a root.

    For x > 0, c sqrt(R) + L, c > 0, is positive where L is, and where c^2 R > L^2.
    """
    if expr.is_positive:
        return True
    if expr.is_Mul or expr.is_Pow:
        return all(is_positive(factor.as_base_exp()[0], x) for factor in sp.Mul.make_args(expr))
    if expr.is_polynomial(x) and sp.degree(expr, x) == 2:
        a, b, c = sp.Poly(expr, x).all_coeffs()
        return bool(a.is_positive and sp.factor(4 * a * c - b**2).is_positive)
    if expr.is_Add and all(is_positive(term, x) for term in expr.args):
        return True
    if not (expr.is_Add and x.is_positive):
        return False
    expr = sp.expand(expr)
    roots = {node for node in expr.atoms(sp.Pow) if node.exp == sp.Rational(1, 2) and node.has(x)}
    if len(roots) != 1:
        return False
    (root,) = roots
    c, L = expr.coeff(root), expr.coeff(root, 0)
    if not c.is_positive or L.has(root) or sp.expand(expr - c * root - L) != 0:
        return False
    return is_positive(L, x) or _outweighs(c**2 * root.base - L**2, L, x)


def _outweighs(above: Expr, L: Expr, x: Expr) -> bool:
    """Tell whether `above` is positive for x > 0, save at zeros of even order where L is positive."""
    if not above.is_polynomial(x):
        return False
    constant, factors = sp.factor_list(above, x)
    if not sp.sympify(constant).is_positive:
        return False
    for factor, power in factors:
        if is_positive(factor, x):
            continue
        places = sp.roots(factor, x)
        if power % 2 or sum(places.values()) < sp.degree(factor, x):
            return False
        if not all(place.is_nonpositive or L.subs(x, place).is_positive for place in places):
            return False
    return True

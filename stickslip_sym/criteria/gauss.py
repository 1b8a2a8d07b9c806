"""Weights of the criteria in terms that do not cancel at the ends, for Gauss rules over an angle.

With v = 2V sin(phi)^2 a criterion reads

    c = -N * integral_0^(pi/2) w(s) mu'(v) 4 sin(phi) cos(phi) dphi,    s = -cos(2 phi),

and the integrand is smooth at both ends for every weight, square roots too.
"""

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.criterion import Criterion

__all__ = ["angle_weight", "weight_of"]


def weight_of(criterion: Criterion, m: Expr, p: Expr, q: Expr) -> Expr:
    """Return w(s) in terms of m = 1 - s^2, p = 1 + s and q = 1 - s, which do not cancel at the ends."""
    assert criterion.weight is not None
    weight, s = criterion.weight, symbols.s
    if sp.expand(weight.subs(s, -s) - weight) == 0:
        even = sp.powdenest(weight.subs(s, sp.sqrt(1 - m)), force=True)
        return sp.factor(even) if even.is_polynomial(m) else even
    content, factors = sp.factor_list(weight, s)
    result = content
    for factor, power in factors:
        # In the middle s = (p - q)/2 cancels, to an absolute error of one unit.
        known = {1 + s: p, s - 1: -q}
        result *= known.get(factor, factor.subs(s, (p - q) / 2)) ** power
    return result


def angle_weight(criterion: Criterion, m: Expr, p: Expr, q: Expr) -> Expr:
    """Return w(s) ds/dphi in the same terms; m = 4 sin(phi)^2 cos(phi)^2, p = 2 sin(phi)^2, q = 2 cos(phi)^2."""
    return 2 * sp.sqrt(m) * weight_of(criterion, m, p, q)

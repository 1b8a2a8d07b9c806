"""The slope of a coefficient of friction, as an expression in the slip speed."""

from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import write_sech


@lru_cache  # laws with other values share it
def slope_of(mu: Expr) -> Expr:
    """Return the derivative of a coefficient by the slip speed; that of a quotient is one, in factors.

    As the quotient rule gives it, its two terms cancel at high speeds.
    """
    return write_sech(sp.Add(*map(_slope_of_term, sp.Add.make_args(mu))))


def _slope_of_term(term: Expr) -> Expr:
    """Return the slope of a term; powers of a shifted speed stay as they are, for multiplied out they cancel."""
    over, under = sp.fraction(term)
    if over.has(symbols.v) and all(
        one.is_polynomial(symbols.v) and one == sp.expand(one) for one in (over, under)
    ):
        return sp.factor(sp.expand(sp.diff(over, symbols.v) * under - over * sp.diff(under, symbols.v))) / under**2
    return sp.diff(term, symbols.v)

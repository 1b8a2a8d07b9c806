"""A criterion at the ends of its range, V -> 0 and V -> infinity.

An average of -g' over slip speeds from 0 to 2 V has a bounded weight of unit integral. So where g' has a finite
limit as v falls to 0, the average tends to minus that as V does, and likewise at infinity; where g' grows like
v^n, an average grows like the mean of (1 + s)^n. What is left are the leading terms of the slope of mu, of its
last piece for high belt speeds.
"""

from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.tidy import tidy
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.model.expression.slope import slope_of
from stickslip_sym.model.formula_algebra import NotAnalytic
from stickslip_sym.model.leading_terms import LeadingTerms, Scale, ask_leading_terms
from stickslip_sym.numerics.known import Unknown
from stickslip_sym.output.data import DataResult


@dataclass(frozen=True)
class Limits(DataResult):
    """What a criterion tends to.

    Attributes
    ----------
    at_rest : sympy.Expr or None
        Its limit as V falls to 0, or its leading term there if that has V in it; None where it was not found.
    far : sympy.Expr or None
        Its limit as V grows, or its leading term there if that has V in it; None where it was not found.
    """

    at_rest: Expr | None
    far: Expr | None


def limits_of(mu: Expr, model: Expr, criterion: Criterion, *, endless: bool) -> Limits:
    """Return the limits of a criterion of mu(v) for low and for high belt speeds.

    - `model`: how mu is written, whose signs they have.
    - `endless`: whether mu has a value at all speeds.
    """
    pieces, places = pieces_of(slope_of(mu))
    begins = not places or places[0].is_positive  # else the first piece may end at 0
    at_rest = _limit_of_average(pieces[0], criterion, model, far=False) if begins else None
    return Limits(at_rest, _limit_of_average(pieces[-1], criterion, model, far=True) if endless else None)


@lru_cache(maxsize=256)
def _limit_of_average(slope: Expr, criterion: Criterion, model: Expr, *, far: bool) -> Expr | None:
    """Return what a criterion tends to where a slope holds; None where that is not known."""

    def average(of: LeadingTerms) -> Expr:
        if not of.grows:
            return of.limit()
        (exponent, logarithms), first = of.leading
        power = -exponent if far else exponent
        fastest = power.has(Scale)
        integrable = not fastest and (power + criterion.order_at_rest + 1).is_positive is not False
        if not (far or integrable or criterion.weight is None):
            raise NotAnalytic("it has no average")
        if logarithms == 0 and not fastest:
            leading = first * criterion.mean_power(power) * symbols.V**power
        elif criterion.is_polynomial and any(0 < p < 2 for p in criterion.from_rest.real_roots()):
            raise NotAnalytic("it is infinite, of either sign")
        else:
            leading = of.limit()
        if leading == 0:
            raise NotAnalytic("what is less grows then")
        return leading

    limit = ask_leading_terms(slope, average, far=far)
    return None if isinstance(limit, Unknown) else tidy(sp.expand(-symbols.N * limit), model, symbols.V)

"""A criterion at the ends of its range, V -> 0 and V -> infinity.

An average of -g' over slip speeds from 0 to 2 V has a bounded weight of unit integral. So where g' has a finite
limit as v falls to 0, the average tends to minus that as V does, and likewise at infinity; where g' grows like
v^n, an average grows like the mean of (1 + s)^n. What is left is the limit of the slope of a profile: by rules
where they serve, else by SymPy in a process that is killed when its time is up.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import row
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.average import Average
from stickslip_sym.formula.finding import search
from stickslip_sym.formula.tidy import tidy
from stickslip_sym.model.terms import Term

__all__ = ["Limits", "limits_of"]

_SECONDS = 2.0  # that SymPy may take for a profile where no rule serves


@dataclass(frozen=True)
class Limits:
    """What a criterion tends to.

    Attributes
    ----------
    at_rest : sympy.Expr or None
        Its limit as V falls to 0; None where it was not found.
    far : sympy.Expr or None
        Its limit as V grows, or its leading term there if that has V in it; None where it was not found.
    """

    at_rest: Expr | None
    far: Expr | None


def limits_of(averages: Iterable[tuple[Term, Average]], mu: Expr) -> Limits:
    """Return the limits of a criterion of mu(v) for low and for high belt speeds, each a sum over the terms."""
    rest, far = [], []
    for term, average in averages:
        share = -symbols.N * term.amplitude / term.scale
        low, high = _of_profile(average.slope, average.criterion)
        rest.append(None if low is None else share * term.in_parameters(low))
        far.append(None if high is None else share * term.in_parameters(high))
    return Limits(
        *(None if found is None else tidy(found, mu, symbols.V) for found in (_sum(rest), _leading(far)))
    )


def _sum(parts: Iterable[Expr | None]) -> Expr | None:
    found = list(parts)
    return None if None in found else sp.Add(*found)


def _leading(parts: Iterable[Expr | None]) -> Expr | None:
    """Return the part of a sum that grows most as V does."""
    total, V = _sum(parts), symbols.V
    if total is None or not total.has(V):
        return total
    powers = sp.Poly(sp.expand(total), V)
    return sp.factor(powers.LC()) * V ** powers.degree()


@lru_cache(maxsize=256)
def _of_profile(slope: Expr, criterion: Criterion) -> tuple[Expr | None, Expr | None]:
    """Return what an average over -1 tends to as V falls to 0, and as it grows."""
    # Positive, where the slip speed may be 0: only then SymPy knows that exp(-v) falls.
    in_V = slope.xreplace({symbols.v: symbols.V})
    return _slope_at_rest(in_V), _slope_far(in_V, criterion)


def _slope_at_rest(slope: Expr) -> Expr | None:
    if slope.has(sp.Piecewise):
        return None  # its first piece may end at 0
    roots = [power for power in slope.atoms(sp.Pow) if power.base.subs(symbols.V, 0) == 0]
    if all(power.exp.is_nonnegative for power in roots):
        value = slope.subs(symbols.V, 0)  # what is finite there is continuous
        if not value.has(sp.zoo, sp.nan, sp.oo):
            return value
    return search.limit(slope, symbols.V, sp.S.Zero, _SECONDS)


def _slope_far(slope: Expr, criterion: Criterion) -> Expr | None:
    """Return the limit of a criterion over -N, or its leading term, as V grows."""
    V = symbols.V
    monomials: dict[int, Expr] = {}
    for term in sp.Add.make_args(sp.expand(slope)):
        coefficient, power = term.as_independent(V)[0], sp.degree(term, V) if term.is_polynomial(V) else None
        if power is not None:
            monomials[power] = monomials.get(power, 0) + coefficient
            continue
        growth = _growth(term)
        if growth is None or not growth < 0:
            return search.limit(slope, V, sp.oo, _SECONDS)
    monomials = {power: sp.factor(total) for power, total in monomials.items() if sp.factor(total) != 0}
    top = max(monomials, default=0)
    constant = monomials.get(top, sp.S.Zero)
    return constant * criterion.mean_power(top) * V**top


def _growth(expr: Expr) -> Expr | None:
    """Return a bound on the power of V like which an expression grows; None where no rule gives one."""
    V = symbols.V
    if not expr.has(V):
        return sp.S.Zero
    if expr == V:
        return sp.S.One
    if isinstance(expr, sp.exp | sp.sech):
        argument = expr.args[0]
        inside = None if argument.is_Add else _growth(argument)
        dies = inside is not None and inside.is_positive and (argument.is_negative or isinstance(expr, sp.sech))
        return -sp.oo if dies else None
    known = row(expr)
    if known is not None and known.bounded:
        return sp.S.Zero
    parts = [_growth(argument) for argument in expr.args]
    if any(part is None for part in parts):
        return None
    if expr.is_Mul:
        return sp.Add(*parts)
    if expr.is_Add:
        return sp.Max(*parts)
    if expr.is_Pow and not expr.exp.has(V):
        # Terms of opposite signs may leave a base smaller than its largest term: no bound for one over it.
        cancels = expr.base.is_Add and not all(term.is_positive for term in expr.base.args)
        return None if expr.exp.is_negative and cancels else parts[0] * expr.exp
    return None

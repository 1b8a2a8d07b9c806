"""A criterion at the ends of its range, V -> 0 and V -> infinity.

An average of -g' over slip speeds from 0 to 2 V has a bounded weight of unit integral. So where g' has a finite
limit as v falls to 0, the average tends to minus that as V does, and likewise at infinity; where g' grows like
v^n, an average grows like the mean of (1 + s)^n. What is left is the limit of the slope of a profile, of its last
piece for high belt speeds.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import row, write_sech
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.average import Average
from stickslip_sym.formula.tidy import tidy
from stickslip_sym.model.limit_at_rest import symbolic_limit_at_rest
from stickslip_sym.model.terms import Term
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


def limits_of(averages: Iterable[tuple[Term, Average]], mu: Expr) -> Limits:
    """Return the limits of a criterion of mu(v) for low and for high belt speeds, each a sum over the terms."""
    V = symbols.V
    ends: tuple[list[Expr | None], list[Expr | None]] = ([], [])
    for term, average in averages:
        share = -symbols.N * term.amplitude / term.scale
        # With V for v, which is positive where the slip speed may be 0: only then SymPy knows that exp(-v) falls.
        slope = write_sech(average.slope).xreplace({symbols.v: V})
        for limit_at, end in ((_average_limit_at_rest, ends[0]), (_limit_far_out, ends[1])):
            limit = None if limit_at is _limit_far_out and average.domain else limit_at(slope, average.criterion)
            end.append(None if limit is None else share * term.in_parameters(limit))
    low, high = (_leading_limits(end, sign) for end, sign in zip(ends, (-1, 1), strict=True))
    return Limits(*(None if total is None else tidy(total, mu, V) for total in (low, high)))


def _leading_limits(limits: list[Expr | None], sign: int) -> Expr | None:
    """Return the sum of those limits of terms that grow most, as V grows or, with -1, falls; None if it is 0."""
    known = [limit for limit in limits if limit is not None]
    if len(known) < len(limits):
        return None
    parts = [part for limit in known for part in sp.Add.make_args(sp.expand(limit))]
    if any(part.has(sp.oo, -sp.oo) for part in parts):
        total = sp.nan
        if not any(part.has(symbols.V) for part in parts):
            total = sp.Add(*parts)
        if total in (sp.oo, -sp.oo):
            return total
        return None
    powers = {part: part.as_coeff_exponent(symbols.V)[1] for part in parts}
    tops = [p for p in set(powers.values()) if all((sign * (p - q)).is_nonnegative for q in powers.values())]
    if len(tops) != 1:
        return sp.S.Zero if not parts else None
    total = sp.Add(*[part for part in parts if powers[part] == tops[0]])
    if tops[0] == 0:
        return None if total.has(sp.nan) else total
    strength = sp.factor(total / symbols.V ** tops[0])
    if strength == 0:
        return None
    return strength * symbols.V ** tops[0]  # what is less grows then, and is not known


@lru_cache
def _average_limit_at_rest(slope: Expr, criterion: Criterion) -> Expr | None:
    """Return the limit of the average of a slope g'(V), or its leading term, as V falls to 0."""
    V = symbols.V
    if slope.has(sp.Piecewise):
        return None  # its first piece may end at 0
    monomials = [term.as_coeff_exponent(V) for term in sp.Add.make_args(sp.expand(slope))]
    poles = [(c, p) for c, p in monomials if not c.has(V) and p.is_negative]
    rest = slope
    if poles:
        rest = sp.expand(slope) - sp.Add(*[c * V**p for c, p in poles])
    value = rest.subs(V, 0)  # what is finite there is continuous
    roots = [power for power in rest.atoms(sp.Pow) if power.base.subs(V, 0) == 0]
    finite = all(power.exp.is_nonnegative for power in roots) and not value.has(sp.zoo, sp.nan, sp.oo)
    if finite and not poles:
        return value
    if finite:
        (c, p), *others = poles
        integrable = (p + criterion.order_at_rest + 1).is_positive is not False or criterion.weight is None
        if integrable and not others:
            return c * criterion.mean_power(p) * V**p
        return None
    if poles:
        return None
    return _limit_at_rest(slope, criterion)


def _limit_at_rest(slope: Expr, criterion: Criterion) -> Expr | None:
    """Return the limit of the average: infinite as that of the slope is, if no part of the weight is negative."""
    limit = symbolic_limit_at_rest(slope.xreplace({symbols.V: symbols.v}))
    changes = criterion.is_polynomial and any(0 < p < 2 for p in criterion.from_rest.real_roots())
    if limit.has(sp.nan, sp.zoo) or (changes and limit.has(sp.oo, -sp.oo)):
        return None
    return limit


@lru_cache
def _limit_far_out(slope: Expr, criterion: Criterion) -> Expr | None:
    """Return the limit of the average of a slope, or its leading term, as V grows."""
    V = symbols.V
    last = slope.replace(lambda node: isinstance(node, sp.Piecewise), lambda node: node.args[-1].expr)
    terms = sp.Add.make_args(sp.expand(last))
    polynomial = sp.Add(*[term for term in terms if term.is_polynomial(V)])
    growths = [_growth(term) for term in terms if not term.is_polynomial(V)]
    if not all(growth is not None and growth.is_negative for growth in growths):
        return _limit_at_rest(last.xreplace({V: 1 / V}), criterion)
    monomials = {power: c for (power,), c in sp.Poly(polynomial, V).terms() if sp.factor(c) != 0}
    top = max(monomials, default=0)
    return sp.factor(monomials.get(top, sp.S.Zero)) * criterion.mean_power(top) * V**top


def _growth(expr: Expr) -> Expr | None:
    """Return a bound on the power of V like which an expression grows; None where no rule gives one."""
    V = symbols.V
    if not expr.has(V) or expr == V:
        return sp.Integer(expr == V)
    known = row(expr)
    if known is not None and known.decays_superpolynomially(*expr.args):
        inside = None if expr.args[-1].is_Add else _growth(expr.args[-1])
        if inside is not None and inside.is_positive:
            return -sp.oo
    if known is not None and known.bounded:
        return sp.S.Zero
    growths = [_growth(argument) for argument in expr.args]
    parts = [growth for growth in growths if growth is not None]
    if len(parts) < len(growths):
        return None
    if expr.is_Mul or expr.is_Add:
        return (sp.Add if expr.is_Mul else sp.Max)(*parts)
    if expr.is_Pow and not expr.exp.has(V):
        # Terms of opposite signs may leave a base smaller than its largest term: no bound for one over it.
        cancels = expr.base.is_Add and not all(term.is_positive for term in expr.base.args)
        if expr.exp.is_negative and cancels:
            return None
        return parts[0] * expr.exp
    return None

"""Coefficients that vanish at rest faster than any power of v, such as exp(-g/v): how they fall, and bounds.

No ball around v = 0 is finite there. What such a coefficient adds below some speed is bounded by its value at that
speed, since it rises from 0; above it balls are as small as they are anywhere.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import sympy as sp
from flint import acb, arb

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.balls import Point, ball_value, number_at
from stickslip_sym.model.expression.letters import substitute_numbers
from stickslip_sym.model.formula_algebra import NotAnalytic
from stickslip_sym.model.leading_terms import LeadingTerms, Order, ask_leading_terms
from stickslip_sym.numerics.known import Unknown

_CONSTANT: Order = (sp.S.Zero, sp.S.Zero)


@dataclass(frozen=True)
class Decay:
    """exp(E), E a sum of c v^e L^n with L = -log(v), which falls without bound at rest, faster than L grows.

    - `terms`: the numbers c by their orders (e, n).
    """

    terms: Mapping[Order, Expr]

    @property
    def first(self) -> Order:
        """The order of the term that is the largest at rest."""
        return _largest_at_rest(self.terms)

    @property
    def function(self) -> Expr:
        """It at v = 2 V."""
        v = 2 * symbols.V
        return sp.exp(sp.Add(*[c * v**e * (-sp.log(v)) ** n for (e, n), c in self.terms.items()]))

    def ball(self, v: arb) -> arb:
        """Return it at a speed."""
        return _sum_at(self.terms, v).exp()

    def rates(self, power: Expr = sp.S.Zero) -> dict[Order, Expr]:
        """Return by how much more the relative change of v^power times it is than that of v, as a sum like E."""
        rates = {_CONSTANT: power}
        for (e, n), c in self.terms.items():
            for order, change in (((e, n), c * e), ((e, n - 1), -c * n)):
                rates[order] = rates.get(order, sp.S.Zero) + change
        return {order: rate for order, rate in rates.items() if rate != 0}

    def steepness(self, v: float) -> float:
        """Return by how much more its relative error is than that of the speed."""
        return float(_sum_at(self.rates(), arb(v)))

    def rises_below(self, end: arb, power: Expr = sp.S.Zero) -> bool:
        """Whether v^power times it is shown to rise up to a speed.

        The first term of its rate is larger than all others there, and the lower the speed, the more so: the ratio
        v^e L^n falls with v where e L >= n.
        """
        rates = self.rates(power)
        first = _largest_at_rest(rates)
        logarithm = -end.log()
        falls = all(
            bool(_sum_at({_CONSTANT: e - first[0]}, end) * logarithm >= _sum_at({_CONSTANT: n - first[1]}, end))
            for e, n in rates
        )
        others = [abs(_sum_at({order: rate}, end)) for order, rate in rates.items() if order != first]
        return falls and bool(logarithm > 0) and bool(_sum_at({first: rates[first]}, end) > sum(others, arb(0)))

    def below(self, reach: arb, bits: int) -> arb:
        """Return a speed where it is so many bits below what it is at another one, or lower, and rises."""
        step = arb(1)
        wanted = _sum_at(self.terms, reach) - bits * arb.const_log2()
        while not (_sum_at(self.terms, reach / step.exp()) < wanted and self.rises_below(reach / step.exp())):
            step *= 2
        return (reach / step.exp()).mid()


def _largest_at_rest(terms: Mapping[Order, Expr]) -> Order:
    return min(terms, key=lambda order: (order[0], -order[1]))


def _sum_at(terms: Mapping[Order, Expr], v: arb) -> arb:
    """Return a sum of c v^e L^n."""
    total = sp.Add(*[c * symbols.v**e * (-sp.log(symbols.v)) ** n for (e, n), c in terms.items()])
    return ball_value(total, {symbols.v: acb(v)}).real


def _superpolynomial_decay(exponential: Expr, point: Substitution) -> Decay | None:
    """Return how an exponential vanishes at rest, if faster than any power; None for another."""

    def exact(found: LeadingTerms) -> Mapping[Order, Expr]:
        if found.left_out:
            raise NotAnalytic("it is no sum of powers")
        return found.terms

    known = ask_leading_terms(exponential.exp, exact, point)
    if isinstance(known, Unknown) or not known:
        return None
    numbers = [number_at(part, point) for (e, n), c in known.items() for part in (e, n, c)]
    if not all(number.is_real for number in numbers):
        return None
    first = _largest_at_rest(known)
    falls = number_at(known[first], point) < 0 and (first[0] < 0 or (first[0] == 0 and first[1] > 1))
    return Decay({order: substitute_numbers(c, point) for order, c in known.items()}) if falls else None


def _superpolynomial_decays(mu: Expr, point: Substitution) -> list[Decay]:
    """Return the exponentials of a formula that vanish faster than any power."""
    decays = [_superpolynomial_decay(node, point) for node in mu.atoms(sp.exp)]
    return [decay for decay in decays if decay is not None]


def start_of(mu: Expr, point: Substitution, reach: arb, bits: int) -> arb | None:
    """Return a speed below which what vanishes faster than any power counts for nothing; None without such."""
    return min((decay.below(reach, bits) for decay in _superpolynomial_decays(mu, point)), key=float, default=None)


def decay_at_rest(mu: Expr, point: Substitution) -> Decay | None:
    """Return the slowest exponential of a power by which a coefficient, or a term of it, vanishes at rest."""
    leading = [(decay.first, decay.terms[decay.first]) for decay in _superpolynomial_decays(mu, point)]
    slowest = max((one for one in leading if one[0][0] < 0 and one[0][1] == 0), default=None)
    return None if slowest is None else Decay(dict([slowest]))


def vanishing(mu: Expr, point: Substitution) -> tuple[Expr, Expr]:
    """Return a smooth coefficient without its terms that vanish faster than any power, and these."""
    vanished, regular = sp.sift(
        sp.Add.make_args(sp.expand_mul(mu)),
        lambda term: any(
            isinstance(factor, sp.exp) and _superpolynomial_decay(factor, point)
            for factor in sp.Mul.make_args(term)
        ),
        binary=True,
    )
    return sp.Add(*regular), sp.Add(*vanished)


def bound_below(vanished: Expr, point: Substitution, end: arb) -> arb:
    """Return a bound on what vanishes faster than any power, from v = 0 to a speed; not finite without one."""
    around: Point = {**point, symbols.v: acb(arb(end / 2, (end / 2).abs_upper()))}
    total = arb(0)
    for term in sp.Add.make_args(vanished):
        size = arb(1)
        power = sp.S.Zero
        decay = None
        for factor in sp.Mul.make_args(term):
            base, exponent = factor.as_base_exp()
            falls = _superpolynomial_decay(factor, point) if isinstance(factor, sp.exp) else None
            if falls is not None and decay is None:
                decay = falls
            elif base == symbols.v and not exponent.has(symbols.v):
                power += exponent.xreplace(dict(point))
            else:
                size *= abs(ball_value(factor, around).real)
        if decay is None or not decay.rises_below(end, power):
            return arb.nan()
        at_end = ball_value(symbols.v**power, {symbols.v: acb(end)}).real
        total += size * at_end * decay.ball(end)
    return total

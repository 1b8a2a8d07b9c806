"""The theorems of calculus that proofs use; each checks its hypotheses before it applies."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.proof.normal_form import normal_form, single_limit
from stickslip_sym.formula.proof.smoothness import is_smooth

__all__ = ["Antiderivative", "By", "ChangeOfVariable", "PieceByPiece", "ends_of_pieces", "value_at"]


class By(Protocol):
    """A theorem applied to the left side of an equation; raises ValueError where it does not apply."""

    def __call__(self, expr: Expr) -> Expr:
        """Return an expression equal to `expr`."""


def _in_integrals_over(variable: Expr, expr: Expr, change: Callable[..., Expr]) -> Expr:
    """Replace every integral over a variable; `change` takes its integrand and its limits."""

    def changed(integral: Expr) -> Expr:
        found, low, high = single_limit(integral)
        return change(integral.function, low, high) if found == variable else integral

    return expr.replace(lambda node: isinstance(node, sp.Integral), changed)


@dataclass(frozen=True)
class ChangeOfVariable:
    """Substitute ``old = image(new)``, with `image` linear, in every integral over `old`."""

    old: Expr
    new: Expr
    image: Expr

    def __call__(self, expr: Expr) -> Expr:
        """Apply integration by substitution; a linear image is one to one and smooth."""
        slope = sp.diff(self.image, self.new)
        if slope.has(self.new) or not slope.is_nonzero:
            raise ValueError(f"{self.old} = {self.image} is not linear in {self.new}")

        def substitute(integrand: Expr, *limits: Expr) -> Expr:
            if any(part.has(self.new) for part in (integrand, *limits)):
                raise ValueError(f"{self.new} already means something in {integrand}")
            low, high = (sp.expand((limit - self.image.subs(self.new, 0)) / slope) for limit in limits)
            return sp.Integral(integrand.subs(self.old, self.image) * slope, (self.new, low, high))

        return _in_integrals_over(self.old, expr, substitute)


@dataclass(frozen=True)
class PieceByPiece:
    """Evaluate every integral over `variable`, its integrand given in pieces.

    primitives[i] belongs to the piece between places i - 1 and i; with places, the first piece starts at 0. Which
    pieces lie within the limits is left open: each end is taken at most as far as the upper limit.
    """

    primitives: Sequence[Expr]
    variable: Expr
    places: Sequence[Expr] = ()

    def __call__(self, expr: Expr) -> Expr:
        """Apply the fundamental theorem of calculus on each piece, after differentiating its primitive."""

        def evaluate(integrand: Expr, low: Expr, high: Expr) -> Expr:
            if self.places and low != 0:
                raise ValueError(f"the pieces start at 0, the integral at {low}")
            pieces = _branches(integrand) if len(self.primitives) > 1 or self.places else [integrand]
            ends = ends_of_pieces(self.places, high, low)
            if not len(pieces) == len(self.primitives) == len(ends) - 1:
                raise ValueError(f"{len(self.primitives)} antiderivatives for {len(pieces)} pieces")
            parts = zip(self.primitives, pieces, pairwise(ends), strict=True)
            return sp.Add(
                *[_difference(primitive, piece, self.variable, *ends) for primitive, piece, ends in parts]
            )

        return _in_integrals_over(self.variable, expr, evaluate)


def Antiderivative(primitive: Expr, variable: Expr) -> PieceByPiece:
    """Evaluate every integral over `variable` whose integrand is the derivative of `primitive`."""
    return PieceByPiece([primitive], variable)


def ends_of_pieces(places: Sequence[Expr], high: Expr, low: Expr = sp.S.Zero) -> list[Expr]:
    """Return the ends of the pieces within [low, high], in order whatever the places are."""
    ends, before = [low], low
    for place in places:
        before = place if (place - before).is_nonnegative else sp.Max(place, before)
        ends.append(sp.Min(before, high))
    return [*ends, high]


def _branches(integrand: Expr) -> list[Expr]:
    nodes = integrand.atoms(sp.Piecewise)
    if len(nodes) != 1:
        raise ValueError(f"{len(nodes)} laws in pieces stand in one integrand")
    (node,) = nodes
    return [integrand.xreplace({node: branch}) for branch, _ in node.args]


def _difference(primitive: Expr, integrand: Expr, x: Expr, low: Expr, high: Expr) -> Expr:
    """Return primitive(high) - primitive(low), once it is known to be the integral."""
    rest = sp.expand(sp.diff(primitive, x) - integrand)
    if rest != 0 and normal_form(rest) != 0:
        raise ValueError(f"{primitive} is not known to be an antiderivative of {integrand}")
    if x.is_nonnegative and not (low.is_nonnegative and high.is_nonnegative):
        raise ValueError(f"{x} is nonnegative, the limits {low} and {high} are not known to be")
    # Above a place that is positive, or 0 if the primitive has a limit there, x is positive: so log(x) is smooth.
    above = sp.Dummy(x.name, positive=True)
    smooth_above = low.is_nonnegative and is_smooth(primitive.xreplace({x: above}), above)
    if not (is_smooth(primitive, x) or smooth_above):
        raise ValueError(f"{primitive} is not known to be smooth between {low} and {high}")
    return value_at(primitive, x, high) - value_at(primitive, x, low)


@lru_cache(maxsize=256)  # found, and proved
def value_at(primitive: Expr, x: Expr, place: Expr) -> Expr:
    """Return a primitive at a place, or its limit from above at 0 where powers outweigh logarithms.

    Raises
    ------
    ValueError
        If it is not finite there.
    """
    value = primitive.subs(x, place)
    if place == 0 and value.has(sp.zoo, sp.oo, sp.nan):
        value = sp.Add(*[_limit_of_term(term, x) for term in sp.Add.make_args(sp.expand(primitive))])
    if value.has(sp.zoo, sp.oo, sp.nan):
        raise ValueError(f"{primitive} is not finite at {x} = {place}")
    return value


def _limit_of_term(term: Expr, x: Expr) -> Expr:
    """Return the limit of a product as x falls to 0: x^p log(x)^n vanishes for p > 0."""
    factors = [factor.as_base_exp() for factor in sp.Mul.make_args(term)]
    logarithms = [
        (base, n)
        for base, n in factors
        if isinstance(base, sp.log) and base.args[0].subs(x, 0) == 0 and n.is_Integer and n > 0
    ]
    if not logarithms:
        return term.subs(x, 0)
    power = sp.Add(*[n for base, n in factors if base == x and not n.has(x)])
    others = [base**n for base, n in factors if base != x and (base, n) not in logarithms]
    vanishes = power.is_positive and not sp.Mul(*others).subs(x, 0).has(sp.zoo, sp.oo, sp.nan)
    return sp.Integer(0) if vanishes else sp.nan

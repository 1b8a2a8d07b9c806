"""The theorems of calculus that proofs use; each checks its hypotheses before it applies."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TypeAlias

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import must_be_positive
from stickslip_sym.formula.proof.normal_form import normal_form, single_limit
from stickslip_sym.model.expression.pieces import pieces_of
from stickslip_sym.model.leading_terms import symbolic_limit_at_rest
from stickslip_sym.numerics.known import Unknown

_INFINITE = (sp.zoo, sp.oo, -sp.oo, sp.nan)

By: TypeAlias = Callable[[Expr], Expr]
"""A theorem, applied to the left side of an equation, which stays equal; ValueError where it does not apply."""


def _replace_integrals(variable: Expr, expr: Expr, change: Callable[..., Expr]) -> Expr:
    """Replace every integral over a variable; `change` takes its integrand and its limits."""

    def changed(integral: sp.Integral) -> Expr:
        integrated, low, high = single_limit(integral)
        if integrated == variable:
            return change(integral.function, low, high)
        return integral

    return expr.replace(lambda node: isinstance(node, sp.Integral), changed)


@dataclass(frozen=True)
class ChangeOfVariable:
    """Substitute ``old = image(new)``, with `image` linear, in every integral over `old`."""

    old: Expr
    new: Expr
    image: Expr

    def __call__(self, expr: Expr) -> Expr:
        """Apply integration by substitution; a linear image is one to one and smooth."""
        new = self.new
        slope = sp.diff(self.image, new)
        if slope.has(new) or not slope.is_nonzero:
            raise ValueError(f"{self.old} = {self.image} is not linear in {new}")

        def substitute(integrand: Expr, *limits: Expr) -> Expr:
            if any(part.has(new) for part in (integrand, *limits)):
                raise ValueError(f"{new} already means something in {integrand}")
            low, high = (sp.expand((limit - self.image.subs(new, 0)) / slope) for limit in limits)
            return sp.Integral(integrand.subs(self.old, self.image) * slope, (new, low, high))

        return _replace_integrals(self.old, expr, substitute)


@dataclass(frozen=True)
class LinearSolution:
    """Evaluate unknowns by equations that are linear in them: expressions that are 0 for one choice only."""

    equations: Sequence[Expr]
    unknowns: Sequence[Expr]

    def __call__(self, expr: Expr) -> Expr:
        """Put the solution into an expression."""
        (values,) = sp.linsolve(self.equations, self.unknowns)
        if any(value.has(*self.unknowns) for value in values):
            raise ValueError(f"the equations leave {', '.join(map(str, self.unknowns))} open")
        return expr.subs(dict(zip(self.unknowns, values, strict=True)), simultaneous=True)


@dataclass(frozen=True)
class PieceByPiece:
    """Evaluate every integral over `variable` by a primitive of each piece of its integrand.

    An integrand in pieces is integrated from 0. Which pieces lie within the limits is left open: each end is taken
    at most as far as the upper limit. With an `end` the upper limit is assumed to be below it, and primitives need
    to be smooth only there.
    """

    primitives: Sequence[Expr]
    variable: Expr
    end: Expr | None = None

    def parts(self, integrand: Expr, low: Expr, high: Expr) -> list[tuple[Expr, Expr, Expr, Expr]]:
        """Return each primitive, what its derivative must be, and from where to where."""
        pieces, places = _pieces(integrand, self.variable)
        if places and low != 0:
            raise ValueError(f"the pieces start at 0, the integral at {low}")
        if len(pieces) != len(self.primitives):
            raise ValueError(f"{len(self.primitives)} antiderivatives for {len(pieces)} pieces")
        ends = pairwise(ends_of_pieces(places, high, low))
        return [
            (primitive, piece, low, high)
            for primitive, piece, (low, high) in zip(self.primitives, pieces, ends, strict=True)
        ]

    def __call__(self, expr: Expr) -> Expr:
        """Apply the fundamental theorem of calculus on each piece, after differentiating its primitive."""

        def evaluate(*integral: Expr) -> Expr:
            return sp.Add(*[
                _difference_of_primitive(primitive, piece, self.variable, low, high, self.end)
                for primitive, piece, low, high in self.parts(*integral)
            ])  # fmt: skip

        return _replace_integrals(self.variable, expr, evaluate)


def Antiderivative(primitive: Expr, variable: Expr) -> PieceByPiece:
    """Evaluate every integral over `variable` whose integrand is the derivative of `primitive`."""
    return PieceByPiece([primitive], variable)


def ends_of_pieces(places: Sequence[Expr], high: Expr, low: Expr = sp.S.Zero) -> list[Expr]:
    """Return the ends of the pieces within [low, high], in order whatever the places are."""
    ends = [low]
    before = low
    for place in places:
        before = place if (place - before).is_nonnegative else sp.Max(place, before)
        ends.append(sp.Min(before, high))
    return [*ends, high]


def _pieces(integrand: Expr, x: Expr) -> tuple[list[Expr], list[Expr]]:
    """Return the pieces of an integrand and the places where they end, which do not move with x."""
    if not all(node.args[-1][1] == sp.true for node in integrand.atoms(sp.Piecewise)):
        raise ValueError(f"{integrand} is not known everywhere")
    exchange = {x: symbols.v, symbols.v: x}
    pieces, places = (
        [part.xreplace(exchange) for part in parts] for parts in pieces_of(integrand.xreplace(exchange))
    )
    if any(place.has(x) for place in places):
        raise ValueError(f"a piece of {integrand} does not end at one place")
    return pieces, places


def _difference_of_primitive(
    primitive: Expr, integrand: Expr, x: Expr, low: Expr, high: Expr, end: Expr | None = None
) -> Expr:
    """Return primitive(high) - primitive(low), once it is known to be the integral."""
    rest = sp.diff(primitive, x) - integrand
    above = sp.Dummy(x.name, positive=True)
    if end is not None:
        rest = _positive_symbol_below(rest, x, end, above)
    if not (rest.is_polynomial(x) and sp.expand(rest) == 0) and normal_form(rest) != 0:
        raise ValueError(f"{primitive} is not known to be an antiderivative of {integrand}")
    if x.is_nonnegative and not (low.is_nonnegative and high.is_nonnegative):
        raise ValueError(f"{x} is nonnegative, the limits {low} and {high} are not known to be")
    # Above a place that is positive, or 0 if the primitive has a limit there, x is positive: so log(x) is smooth.
    smooth_above = low.is_nonnegative and is_smooth(_positive_symbol_below(primitive, x, end, above), above)
    if not ((end is None and is_smooth(primitive, x)) or smooth_above):
        raise ValueError(f"{primitive} is not known to be smooth between {low} and {high}")
    return value_at(primitive, x, high) - value_at(primitive, x, low)


def _positive_symbol_below(expr: Expr, x: Expr, end: Expr | None, above: Expr) -> Expr:
    """Write a positive symbol for x > 0, or where x is below an end the end over 1 plus the symbol."""
    if end is None:
        return expr.xreplace({x: above})
    moved = expr.xreplace({x: end / (1 + above)}).replace(lambda node: node.is_Add, sp.factor)
    return moved.replace(sp.log, lambda argument: sp.expand_log(sp.log(argument)))


@lru_cache  # found, and proved
def value_at(primitive: Expr, x: Expr, place: Expr) -> Expr:
    """Return a primitive at a place, or its limit from above at 0 where powers outweigh logarithms."""
    value = primitive.subs(x, place)
    if place == 0 and value.has(*_INFINITE):
        value = sp.Add(*[_limit_of_term(term, x) for term in sp.Add.make_args(sp.expand(primitive))])
    if value.has(*_INFINITE):
        raise ValueError(f"{primitive} is not finite at {x} = {place}")
    return value


def _limit_of_term(term: Expr, x: Expr) -> Expr:
    """Return the limit of a product as x falls to 0; NaN where it is not found."""
    value = term.subs(x, 0)
    if not value.has(*_INFINITE):
        return value
    factors = map(_as_large_at_rest, sp.Mul.make_args(term.xreplace({x: symbols.v, symbols.v: x})))
    limit = symbolic_limit_at_rest(sp.Mul(*factors))
    return sp.nan if isinstance(limit, Unknown) else limit


def _as_large_at_rest(factor: Expr) -> Expr:
    """Return exp(-y)/y for E_s(y), y^(s - 1) exp(-y) for Gamma(s, y) where y grows: their ratio tends to 1."""
    if not isinstance(factor, sp.expint | sp.uppergamma):
        return factor
    s, y = factor.args
    limit = symbolic_limit_at_rest(y)
    if isinstance(limit, Unknown) or limit != sp.oo:
        return factor
    return y ** (s - 1 if isinstance(factor, sp.uppergamma) else -1) * sp.exp(-y)


# -- where a formula is known to be continuous, analytic or positive --------------------------------


def is_smooth(expr: Expr, x: Expr, *, analytic: bool = False, inside: bool = True) -> bool:
    """Tell whether an expression is known to be continuous for all x that the assumptions of x allow.

    So an integral over [-1, 1] whose variable is nonnegative would be misjudged: who integrates compares the
    limits with the assumptions of the variable. Analytic is more: no root of what may vanish. Unless `inside` of
    another function poles do not matter: a formula that equals a function without poles elsewhere has none.
    """
    if not expr.has(x) or expr == x:
        return True
    if isinstance(expr, sp.core.function.AppliedUndef | sp.Derivative | sp.Subs):
        return True  # unknown functions are as smooth as the derivation takes them
    rational = expr.is_Add or expr.is_Mul or (expr.is_Pow and expr.exp.is_Integer)
    if expr.is_Pow and not isinstance(expr, sp.exp):
        base, exponent = expr.args
        whole = exponent.is_Integer and (exponent > 0 or not inside)
        from_zero = not analytic and not exponent.has(x) and base.is_nonnegative and exponent.is_positive
        fine = bool(whole or from_zero or is_positive(base, x))
    else:
        needed = must_be_positive(expr)
        fine = needed is not None and all(is_positive(e, x) or is_positive(sp.factor(e), x) for e in needed)
    return fine and all(
        is_smooth(argument, x, analytic=analytic, inside=inside or not rational)
        for argument in expr.args
        if not isinstance(argument, sp.Tuple)
    )


def is_positive(expr: Expr, x: Expr) -> bool:
    """Tell whether an expression is known to be positive: by signs, as a quadratic, as 1 - exp(-y), or by a root.

    For x > 0, c sqrt(R) + L, c > 0, is positive where L is, and where c^2 R > L^2.
    """
    if expr.is_positive:
        return True
    if expr.is_Mul or expr.is_Pow:
        return all(is_positive(factor.as_base_exp()[0], x) for factor in sp.Mul.make_args(expr))
    if expr.is_polynomial(x) and sp.degree(expr, x) == 2:
        a, b, c = sp.Poly(expr, x).all_coeffs()
        return bool(a.is_positive and sp.factor(4 * a * c - b**2).is_positive)
    if expr.is_Add and all(is_positive(term, x) for term in _numbers_added(expr)):
        return True
    if not (expr.is_Add and x.is_positive):
        return False
    whole, decay = expr.as_coeff_Add()
    if whole == 1 and isinstance(-decay, sp.exp) and (-decay).args[0].is_negative:
        return True
    expr = sp.expand(expr)
    roots = {node for node in expr.atoms(sp.Pow) if node.exp == sp.Rational(1, 2) and node.has(x)}
    if len(roots) != 1:
        return False
    (root,) = roots
    c = expr.coeff(root)
    L = expr.coeff(root, 0)
    if not c.is_positive or L.has(root) or sp.expand(expr - c * root - L) != 0:
        return False
    return is_positive(L, x) or _outweighs(c**2 * root.base - L**2, L, x)


def _numbers_added(total: Expr) -> list[Expr]:
    """Return the terms of a sum, its numbers as one: 1 - sqrt(2)/2 is positive."""
    numbers, others = sp.sift(total.args, lambda term: term.is_number, binary=True)
    return [sp.Add(*numbers), *others] if numbers else others


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

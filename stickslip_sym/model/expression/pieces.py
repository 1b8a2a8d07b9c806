"""Laws with kinks and jumps: every one is a `Piecewise` in v, with its places in order.

Abs, Min and Max become pieces when a law is read, so all that comes later (closed forms, quadrature, fast
functions) knows one kind of kink only, one in a term, and knows exactly where it is.
"""

from collections.abc import Sequence
from functools import lru_cache, reduce
from itertools import pairwise
from typing import NamedTuple, TypeAlias

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Relation, Substitution
from stickslip_sym.core.balls import place_at, resolve_kinks
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import power, row
from stickslip_sym.core.remedies import Argument

Cases: TypeAlias = list[tuple[Expr, Expr | None]]
"""Smooth pieces of an expression in order, and the place where each ends; None is beyond every place."""

RELATIONS = (sp.StrictLessThan, sp.StrictGreaterThan)
_MOST_UNORDERED = 6  # parameters in Max and Min whose order is unknown: SymPy compares all pairs, at length
MOST_PIECES = 64
"""Of a law, and arguments of what makes them."""


# -- the pieces of an expression -------------------------------------------------------------------


def kinked(expr: Expr) -> list[sp.Piecewise]:
    """Return the nodes of an expression that are in pieces of v."""
    return [node for node in sp.ordered(expr.atoms(sp.Piecewise)) if node.has(symbols.v)]


def place_of(relation: Relation) -> Expr:
    """Return the place of v < place, which SymPy may turn round into place > v or -place < -v."""
    return relation.gts if relation.lts == symbols.v else -relation.lts


def _end_of_condition(holds: Condition) -> Expr | None:
    """Return the place of a condition v < place; None where it is always true."""
    # SymPy joins the conditions of pieces that became equal by Or.
    if holds == sp.true:
        return None
    return sp.Max(*map(place_of, holds.atoms(*RELATIONS)))


def _branches_and_ends(node: sp.Piecewise) -> Cases:
    """Return the branches of a Piecewise, and where each ends."""
    return [(branch, _end_of_condition(holds)) for branch, holds in node.args]


def _smooth_cases(expr: Expr) -> Cases:
    """Return the smooth pieces of an expression with any number of kinks."""
    if not (nodes := kinked(expr)):
        return [(expr, None)]
    return _smooth([(expr.xreplace({nodes[0]: branch}), end) for branch, end in _branches_and_ends(nodes[0])])


def _smooth(cases: Cases) -> Cases:
    """Return pieces without kinks, and none that is empty; those of a piece hold up to its place."""
    smooth: Cases = []
    for piece, end in cases:
        for branch, inner in _smooth_cases(piece):
            ends = [one for one in (end, inner) if one is not None]
            place = reduce(smaller, ends) if ends else None
            if smooth:
                before = smooth[-1][1]
            else:
                before = sp.S.Zero
            is_empty = before is None or (place is not None and (place - before).is_nonpositive)
            if not is_empty:
                smooth.append((branch, place))
    if len(smooth) > MOST_PIECES:
        raise InputError(f"the kinks of the law part it into more than {MOST_PIECES} pieces")
    return smooth


def piecewise(cases: Cases) -> Expr:
    """Return the law that is piece i for v < place i, and not in an earlier piece.

    A piece may have kinks itself: its own pieces then hold up to its place.
    """
    if any(place is not None and place.has(symbols.v) for _, place in cases):
        raise InputError("the places of a Piecewise are parameters or numbers; they cannot depend on v")
    pairs: Cases = []
    for piece, place in _smooth(cases):
        if pairs and pairs[-1][0] == piece:
            # SymPy would join the two conditions by Or; one place keeps every condition of the one form.
            before = pairs.pop()[1]
            place = None if place is None else sp.Max(before, place)
        pairs.append((piece, place))
    try:
        return sp.Piecewise(*((piece, True if place is None else symbols.v < place) for piece, place in pairs))
    except TypeError:
        raise InputError("the places of a Piecewise are real numbers") from None


def join_kinks(expr: Expr) -> Expr:
    """Return an expression in which no two kinks stand in one term: their pieces are multiplied out."""
    if len(kinked(expr)) < 2:
        return expr
    if expr.is_Add:
        return sp.Add(*map(join_kinks, expr.args))
    return piecewise(_smooth_cases(expr))


def pieces_of(term: Expr) -> tuple[list[Expr], list[Expr]]:
    """Return the smooth pieces of a term, and the places between them."""
    pieces, ends = zip(*_smooth_cases(term), strict=True)
    return list(pieces), list(ends[:-1])


@lru_cache  # laws with other values share them
def places(expr: Expr) -> tuple[Expr, ...]:
    """Return the places of all kinks and jumps in an expression, as they stand there."""
    ends = dict.fromkeys(end for node in kinked(expr) for _, end in _branches_and_ends(node))
    return tuple(end for end in ends if end is not None)


def mean_slope_at_kinks(slope: Expr) -> Expr:
    """Return a slope that is the mean of both sides at each of its kinks: small motions decay with it."""

    def with_mean(term: Expr) -> Expr:
        pieces, ends = pieces_of(term)
        cases: list[tuple[Expr, Condition]] = []
        for (left, right), place in zip(pairwise(pieces), ends, strict=True):
            cases += [(left, symbols.v < place), ((left + right) / 2, symbols.v <= place)]
        return sp.Piecewise(*cases, (pieces[-1], True))

    return sp.Add(*(with_mean(term) if kinked(term) else term for term in sp.Add.make_args(slope)))


def kinks_at(expr: Expr, point: Substitution, what: str = "mu") -> list[Expr]:
    """Return the slip speeds v > 0 at which an expression or its slope may jump, exact and ascending.

    A place that is not real at the values of the parameters is refused.
    """
    speeds = {place: place_at(place, point) for place in places(expr)}
    for place, speed in speeds.items():
        if not speed.is_extended_real:
            raise InputError(
                f"{what} has a kink at v = {str(place)[:40]}, which is no real number at these values; give other "
                "values, or write the law without this kink"
            )
    return sorted(speed for speed in set(speeds.values()) if 0 < speed < sp.oo)


def drop_unreachable_kinks(expr: Expr, point: Substitution) -> Expr:
    """Return an expression without the kinks whose places no speed reaches at the values of the parameters.

    Arithmetic of floats would divide by 0 there.
    """
    if not expr.has(sp.Piecewise) or all(point.values()):
        return expr
    relations = [relation for relation in expr.atoms(*RELATIONS) if relation.has(symbols.v)]
    ends = {relation: place_at(place_of(relation), point) for relation in relations}
    return expr.xreplace(
        {relation: sp.sympify(end > 0) for relation, end in ends.items() if end in (sp.oo, -sp.oo)}
    )


def jumps(expr: Expr, point: Substitution) -> list[tuple[Expr, Expr]]:
    """Return the slip speeds v > 0 where an expression itself may jump, and its right minus its left limit.

    Both are formulas, of the pieces that meet there at the values of the parameters.
    """
    formulas = {place_at(place, point): resolve_kinks(place, point) for place in places(expr)}
    heights: list[tuple[Expr, Expr]] = []
    left = branch_from(expr, point, sp.Integer(0))
    for speed in kinks_at(expr, point):
        place = formulas[speed]
        right = branch_from(expr, point, speed)
        if (height := sp.expand((right - left).subs(symbols.v, place))) != 0:
            heights.append((place, height))
        left = right
    return heights


def rate(expr: Expr, parameter: Expr) -> Expr:
    """Differentiate with respect to a parameter; steps, as of Max and Min of parameters, become pieces."""
    return sp.diff(expr, parameter).replace(
        sp.Heaviside, lambda x, *_: sp.Piecewise((sp.S.Zero, x < 0), (sp.S.One, True))
    )


def branch_from(expr: Expr, values: Substitution, start: Expr) -> Expr:
    """Return an expression with each kink replaced by the piece that holds just above a slip speed.

    `values` are those of the parameters, whose symbols stay. Conditions read v < place, so the piece that holds at
    the speed holds above.
    """
    if expr.has(sp.Piecewise):
        return resolve_kinks(expr, {**values, symbols.v: start})
    return expr


# -- conditions ------------------------------------------------------------------------------------


class Bound(NamedTuple):
    """Where a piece of a law holds: v < place or v > place, or with equality if not `strict`."""

    side: str
    place: Expr
    strict: bool


def bound_of(left: Expr, relation: str, right: Expr) -> Bound | None:
    """Return where a condition on v holds; None for one that is no bound of v."""
    if relation in ("<", "<=", ">", ">="):
        for v, place, side in ((left, right, relation[0]), (right, left, "<>"[relation[0] == "<"])):
            if v == symbols.v:
                return Bound(side, place, len(relation) == 1)
    return None


def piecewise_law(branches: Sequence[tuple[Expr, Bound]], last: Expr) -> Expr:
    """Return the law that is the first piece whose bound holds, else `last`."""
    if any(bound.place.is_zero and bound.strict == (bound.side == ">") for _, bound in branches):
        raise InputError(
            "a piece holds at v = 0 alone; a law is that of slip, so leave this piece out, and give its "
            "coefficient as the static one: ",
            Argument("static"),
        )
    law = last
    for branch, bound in reversed(branches):
        below, above = (branch, law) if bound.side == "<" else (law, branch)
        law = piecewise([(below, bound.place), (above, None)])
    return law


# -- functions that make kinks ---------------------------------------------------------------------


def sign(expr: Expr) -> Expr:
    """Return -1 or 1, in pieces where an expression changes sign with v."""
    if not expr.has(symbols.v):
        if not (value := sp.sign(expr)).is_number:
            raise InputError("sign(...) of parameters alone; write what it is, 1 or -1")
        return value
    return _select(sp.Max, sp.Integer(1), sp.Integer(-1), expr)


def smaller(first: Expr, second: Expr) -> Expr:
    """Return the smaller of two expressions, in pieces, as `larger` does."""
    return _select(sp.Min, second, first, first - second)


def larger(first: Expr, second: Expr) -> Expr:
    """Return the larger of two expressions, in pieces.

    The place where their difference changes sign has to be known: it is linear in v, A*v^p + B, or so within a
    function that rises, and A has a known sign.
    """
    return _select(sp.Max, first, second, first - second)


def _select(constant: type[Expr], above: Expr, below: Expr, difference: Expr) -> Expr:
    """Return `above` where a difference is positive, else `below`; `constant` selects where v has no part."""
    three = sp.Tuple(above, below, difference)
    if kinked(three):
        return piecewise([(_select(constant, *case.args), place) for case, place in _smooth_cases(three)])
    if difference.is_nonnegative or difference.is_nonpositive:
        return above if difference.is_nonnegative else below
    # Expanding could take very long; a difference that is linear has a slope without v as it stands.
    slope = sp.diff(difference, symbols.v)
    offset = difference.subs(symbols.v, 0)
    if slope == 0:
        result = constant(above, below)
        unordered = [node for node in sp.preorder_traversal(result) if isinstance(node, sp.Max | sp.Min)]
        if sum(len(node.args) - 1 for node in unordered) >= _MOST_UNORDERED:
            raise InputError(f"Abs, Min and Max of more than {_MOST_UNORDERED} parameters of unknown order")
        return result
    if not slope.has(symbols.v):
        place = -offset / slope
        if slope.is_positive:
            return piecewise([(below, place), (above, None)])
        if slope.is_negative:
            return piecewise([(above, place), (below, None)])
    elif (simpler := _simplify_same_sign(difference)) is not None:
        return _select(constant, above, below, simpler)
    raise InputError(
        "Abs, Min, Max and sign need arguments that differ by a linear function of v, by A*v^p + B, or by such a "
        "function of it as A*exp(-v/v_0) + B, with a slope of known sign; write Piecewise((..., v < place), ...) "
        "with the place of the kink instead"
    )


def _simplify_same_sign(expr: Expr) -> Expr | None:
    """Return a simpler expression of the sign of A*f + B, f = v^p or a rising function, or of a quotient."""
    offset, rest = expr.as_independent(symbols.v, as_Add=True)
    factor, function = rest.as_independent(symbols.v, as_Add=False)
    base, exponent = function.as_base_exp()
    level = -offset / factor
    known = row(function)
    if factor.is_positive or factor.is_negative:
        if base == symbols.v and not exponent.has(symbols.v) and exponent.is_positive:
            # Where the level is negative the difference has one sign at all speeds, and the place is 0.
            return sp.sign(factor) * (base - power(sp.Max(0, level), 1 / exponent))
        if known is not None and known.inverse is not None and (known.kind is not sp.exp or level.is_positive):
            return sp.sign(factor) * (function.args[0] - known.inverse(level))
    numerator, denominator = sp.fraction(sp.together(expr))
    if denominator.has(symbols.v) and (denominator.is_nonnegative or denominator.is_nonpositive):
        return sp.expand(numerator if denominator.is_nonnegative else -numerator)
    return None

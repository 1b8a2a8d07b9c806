"""Laws with kinks and jumps: every one is a `Piecewise` in v, with its places in order.

Abs, Min and Max become pieces when a law is read, so all that comes later (closed forms, quadrature, fast
functions) knows one kind of kink only, one in a term, and knows exactly where it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import holds_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import power, row

__all__ = [
    "Bound", "absolute", "at_rest", "branch_from", "in_pieces", "joined", "jumps", "larger", "pieces_of",
    "piecewise", "places", "sign", "smaller",
]  # fmt: skip


_MOST_UNORDERED = 6  # arguments of a Max whose order is unknown: SymPy compares all pairs of them, at length
MOST_PIECES = 64
_UNKNOWN_ORDER = "Min and Max of parameters of unknown order stand in each other; say which is larger"


def piecewise(branches: Sequence[tuple[Expr, Expr]], last: Expr) -> Expr:
    """Return the law that is piece i for v < place i (and not in an earlier piece), else `last`.

    A piece may have kinks itself: its own pieces then hold up to its place.
    """
    if any(place.has(symbols.v) for _, place in branches):
        raise InputError("the places of a Piecewise are parameters or numbers; they cannot depend on v")
    pairs: list[tuple[Expr, Expr]] = []
    for piece, end in [*branches, (last, None)]:
        for branch, inner in _cases(piece):
            place = _nearer(end, inner)
            if pairs and pairs[-1][0] == branch:
                # SymPy would join the two conditions by Or; one place keeps every condition of the one form.
                before = pairs.pop()[1]
                place = None if place is None else larger(before, place)
            pairs.append((branch, place))
    if len(pairs) > MOST_PIECES:
        raise InputError(f"the kinks of the law part it into more than {MOST_PIECES} pieces")
    try:
        conditions = [True if place is None else symbols.v < place for _, place in pairs]
    except TypeError:
        raise InputError("the places of a Piecewise are real numbers") from None
    return sp.Piecewise(*[(branch, holds) for (branch, _), holds in zip(pairs, conditions, strict=True)])


def _nearer(first: Expr | None, second: Expr | None) -> Expr | None:
    """Return the smaller of two places; None is beyond every place."""
    if first is None or second is None:
        return second if first is None else first
    return smaller(first, second)


def _cases(expr: Expr) -> list[tuple[Expr, Expr | None]]:
    """Return the smooth pieces of an expression with any number of kinks, and the place where each ends."""
    nodes = _kinked(expr)
    if not nodes:
        return [(expr, None)]
    node = nodes[0]
    found: list[tuple[Expr, Expr | None]] = []
    for branch, condition in node.args:
        end = None if condition == sp.true else _end(condition)
        for part, inner in _cases(expr.xreplace({node: branch})):
            place = _nearer(end, inner)
            if not (found and _is_empty(found[-1][1], place)):
                found.append((part, place))
        if len(found) > MOST_PIECES:
            raise InputError(f"the kinks of the law part it into more than {MOST_PIECES} pieces")
    return found


def _is_empty(before: Expr | None, place: Expr | None) -> bool:
    """Return whether no speed lies from the end of one piece to that of the next."""
    return before is None or (place is not None and bool((place - before).is_nonpositive))


def _kinked(expr: Expr) -> list[Expr]:
    return [node for node in sp.ordered(expr.atoms(sp.Piecewise)) if node.has(symbols.v)]


def _end(condition: Expr) -> Expr:
    """Return the place of a condition v < place; SymPy joins those of equal pieces by Or."""
    relations = condition.atoms(sp.StrictLessThan, sp.StrictGreaterThan)
    return sp.Max(*(relation.gts for relation in relations))


def joined(expr: Expr) -> Expr:
    """Return an expression in which no two kinks stand in one term: their pieces are multiplied out."""
    if len(_kinked(expr)) < 2:
        return expr
    if expr.is_Add:
        return sp.Add(*map(joined, expr.args))
    *cases, (last, _) = _cases(expr)
    return piecewise([(branch, place) for branch, place in cases if place is not None], last)


@dataclass(frozen=True)
class Bound:
    """Where a piece of a law holds: v < place or v > place, or with equality if not `strict`."""

    side: str
    place: Expr
    strict: bool

    def completes(self, other: "Bound") -> bool:
        """Return whether this bound holds wherever the other one does not."""
        return self.side != other.side and self.place == other.place

    @property
    def parts_rest(self) -> bool:
        """Whether v = 0 lies on one side of the bound, and every higher speed on the other."""
        return bool(self.place.is_zero) and self.strict == (self.side == ">")


def in_pieces(branches: Sequence[tuple[Expr, Bound]], last: Expr) -> Expr:
    """Return the law that is the first piece whose bound holds, else `last`.

    Raises
    ------
    InputError
        If a piece is for v = 0 alone: the law is that of slip, at v > 0.
    """
    if any(bound.parts_rest for _, bound in branches):
        raise InputError(
            "a piece holds at v = 0 alone; a law is that of slip, so leave this piece out, and give its "
            "coefficient as the static one, static=..."
        )
    pairs: list[tuple[Expr, Expr]] = []
    for branch, bound in reversed(branches):
        if bound.side == "<":
            pairs = [(branch, bound.place), *pairs]
        else:  # what comes later holds below the place only
            pairs = [*((one, smaller(end, bound.place)) for one, end in pairs), (last, bound.place)]
            last = branch
    return piecewise(pairs, last)


def sign(expr: Expr) -> Expr:
    """Return -1 or 1, in pieces where an expression changes sign with v.

    Raises
    ------
    InputError
        As `larger`, and for parameters of unknown sign.
    """
    if not expr.has(symbols.v):
        if not (value := sp.sign(expr)).is_number:
            raise InputError("sign(...) of parameters alone; write what it is, 1 or -1")
        return value
    return _select(sp.Integer(1), sp.Integer(-1), expr, sp.Max)


def absolute(expr: Expr) -> Expr:
    """Return abs(expr), in pieces where it changes sign with v."""
    return larger(expr, -expr)


def smaller(first: Expr, second: Expr) -> Expr:
    """Return the smaller of two expressions, in pieces, as `larger` does."""
    return _select(second, first, first - second, sp.Min)


def larger(first: Expr, second: Expr) -> Expr:
    """Return the larger of two expressions, in pieces.

    Raises
    ------
    InputError
        If no place is known where their difference changes sign: it is linear in v, A*v^p + B, or so within a
        function that rises, and A has a known sign.
    """
    return _select(first, second, first - second, sp.Max)


def _select(above: Expr, below: Expr, difference: Expr, constant: type[Expr]) -> Expr:
    """Return `above` where a difference is positive, else `below`; `constant` selects where v has no part."""
    if _kinked(sp.Tuple(above, below, difference)):
        cases = _cases(sp.Tuple(above, below, difference))
        *chosen, (last, _) = [(_select(a, b, gap, constant), place) for (a, b, gap), place in cases]
        return piecewise([(branch, place) for branch, place in chosen if place is not None], last)
    if difference.is_nonnegative or difference.is_nonpositive:
        return above if difference.is_nonnegative else below
    # Expanding could take very long; a difference that is linear has a slope without v as it stands.
    slope, offset = sp.diff(difference, symbols.v), difference.subs(symbols.v, 0)
    if slope == 0:
        if any(part.has(sp.Max, sp.Min) and not isinstance(part, constant) for part in (above, below)):
            raise InputError(_UNKNOWN_ORDER)
        result = constant(above, below)
        if len(result.args) > _MOST_UNORDERED and isinstance(result, constant):
            raise InputError(f"Abs, Min and Max of more than {_MOST_UNORDERED} parameters of unknown order")
        return result
    if not slope.has(symbols.v):
        place = -offset / slope
        if slope.is_positive:
            return piecewise([(below, place)], above)
        if slope.is_negative:
            return piecewise([(above, place)], below)
    elif (term := _single_term(difference)) is not None:
        factor, function, offset = term
        if factor.is_negative:
            above, below = below, above
        level = -offset / factor
        if function.is_Pow:
            # Where the level is negative the difference has one sign at all speeds, and the place is 0.
            return piecewise([(below, power(sp.Max(0, level), 1 / function.exp))], above)
        if not isinstance(function, sp.exp) or level.is_positive:
            return _select(above, below, function.args[0] - _inverse(function)(level), constant)
    elif (simpler := _without_denominator(difference)) is not None:
        return _select(above, below, simpler, constant)
    raise InputError(
        "Abs, Min, Max and sign need arguments that differ by a linear function of v, by A*v^p + B, or by such a "
        "function of it as A*exp(-v/v_0) + B, with a slope of known sign; write Piecewise((..., v < place), ...) "
        "with the place of the kink instead"
    )


def _single_term(expr: Expr) -> tuple[Expr, Expr, Expr] | None:
    """Return A, f and B if an expression is A*f + B, A of known sign, f = v^p with p > 0 or a rising function."""
    offset, rest = expr.as_independent(symbols.v, as_Add=True)
    factor, function = rest.as_independent(symbols.v, as_Add=False)
    if not (factor.is_positive or factor.is_negative):
        return None
    base, exponent = function.as_base_exp()
    if base == symbols.v and not exponent.has(symbols.v) and exponent.is_positive:
        return factor, sp.Pow(base, exponent), offset
    return (factor, function, offset) if _inverse(function) is not None else None


def _inverse(function: Expr) -> Any:
    """Return the class of a function's inverse, if it rises and has one; else None."""
    known = row(function)
    return None if known is None else known.inverse


def _without_denominator(expr: Expr) -> Expr | None:
    """Return an expression of the same sign without a positive denominator; None where it has none."""
    numerator, denominator = sp.fraction(sp.together(expr))
    positive = denominator.has(symbols.v) and (denominator.is_nonnegative or denominator.is_nonpositive)
    if not positive:
        return None
    return sp.expand(numerator if denominator.is_nonnegative else -numerator)


def pieces_of(term: Expr) -> tuple[list[Expr], list[Expr]]:
    """Return the smooth pieces of a term, and the places between them."""
    *cases, (last, _) = _cases(term)
    return [*(piece for piece, _ in cases), last], [place for _, place in cases if place is not None]


def places(expr: Expr) -> list[Expr]:
    """Return the places of all kinks and jumps in an expression, as they stand there."""
    found: list[Expr] = []
    for node in sp.ordered(expr.atoms(sp.Piecewise)):
        for _, condition in node.args:
            # SymPy may turn v < place round into place > v; pieces that became equal are joined by Or.
            relations = sp.ordered(condition.atoms(sp.StrictLessThan, sp.StrictGreaterThan))
            found += [relation.gts for relation in relations if relation.lts == symbols.v]
    return list(dict.fromkeys(found))


def branch_from(expr: Expr, values: Mapping[Expr, Expr], start: Expr) -> Expr:
    """Return an expression with each kink replaced by the piece that holds just above a place.

    Parameters
    ----------
    expr : sympy.Expr
    values : mapping of symbols to numbers
        Of the parameters; the result keeps its symbols.
    start : sympy number
        A slip speed. Conditions read v < place, so the piece that holds there holds above.
    """
    return _branch(expr, frozenset({**values, symbols.v: start}.items()))


@lru_cache(maxsize=1024)  # enclosures take each piece of a law of many again and again
def _branch(expr: Expr, point: frozenset[tuple[Expr, Expr]]) -> Expr:
    known = dict(point)
    kinked = [node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)]
    chosen = {node: next(part for part, holds in node.args if holds_at(holds, known)) for node in kinked}
    return expr.xreplace(chosen)


def at_rest(expr: Expr) -> Expr:
    """Return an expression with each kink replaced by what holds just above v = 0.

    Where the sign of a place is not known, a Piecewise over it stays.
    """
    known = {symbols.v: sp.Integer(0)}
    kinked = [node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)]
    chosen = {node: sp.Piecewise(*[(part, holds.xreplace(known)) for part, holds in node.args]) for node in kinked}
    return expr.xreplace(chosen)


def jumps(expr: Expr) -> list[tuple[Expr, Expr]]:
    """Return the places where an expression itself may jump, and by how much: its right minus its left limit."""
    found: list[tuple[Expr, Expr]] = []
    for node in sp.ordered(node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)):
        place: Expr = None
        branches = [branch for branch, _ in node.args]
        for end, left, right in zip(places(node), branches, branches[1:], strict=False):
            # A piece that ends before it begins is empty: the jumps into it and out of it meet at one place.
            place = end if place is None or (end - place).is_positive else sp.Max(place, end)
            height = expr.xreplace({node: right}) - expr.xreplace({node: left})
            height = sp.expand(height.subs(symbols.v, place))
            if height != 0:
                found.append((place, height))
    return found

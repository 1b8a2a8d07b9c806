"""Laws with kinks and jumps: every one is a `Piecewise` in v, with its places in order.

Abs, Min and Max of functions that are linear in v become pieces when a law is read, so all that comes
later (closed forms, quadrature, fast functions) knows one kind of kink only, and knows exactly where it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError

__all__ = [
    "Bound", "absolute", "at_rest", "branch_from", "in_pieces", "jumps", "larger", "pieces_of", "piecewise",
    "places", "sign", "smaller",
]  # fmt: skip


_MOST_UNORDERED = 6  # arguments of a Max whose order is unknown: SymPy compares all pairs of them, at length
_NESTED = "a kink inside a kink is not supported; write one Piecewise with all its places"


def piecewise(branches: Sequence[tuple[Expr, Expr]], last: Expr) -> Expr:
    """Return the law that is piece i for v < place i (and not in an earlier piece), else `last`."""
    if any(place.has(symbols.v) for _, place in branches):
        raise InputError("the places of a Piecewise are parameters or numbers; they cannot depend on v")
    if any(part.has(sp.Piecewise) for pair in [*branches, (last,)] for part in pair):
        raise InputError(_NESTED)
    pairs: list[tuple[Expr, Expr]] = []
    for branch, place in branches:
        if pairs and pairs[-1][0] == branch:
            # SymPy would join the two conditions by Or; one place keeps every condition of the one form.
            place = larger(pairs.pop()[1], place)
        pairs.append((branch, place))
    try:
        conditions = [symbols.v < place for _, place in pairs]
    except TypeError:
        raise InputError("the places of a Piecewise are real numbers") from None
    return sp.Piecewise(
        *[(pair[0], condition) for pair, condition in zip(pairs, conditions, strict=True)], (last, True)
    )


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
    """Return the larger of two expressions, in pieces; their difference is linear in v, or A*v^p + B.

    Raises
    ------
    InputError
        If it is neither, or falls or rises with a slope of unknown sign.
    """
    return _select(first, second, first - second, sp.Max)


def _select(above: Expr, below: Expr, difference: Expr, constant: type[Expr]) -> Expr:
    """Return `above` where a difference is positive, else `below`; `constant` selects where v has no part."""
    if difference.has(sp.Piecewise):
        raise InputError(_NESTED)
    if difference.is_nonnegative or difference.is_nonpositive:
        return above if difference.is_nonnegative else below
    # Expanding could take very long; a difference that is linear has a slope without v as it stands.
    slope, offset = sp.diff(difference, symbols.v), difference.subs(symbols.v, 0)
    if slope == 0:
        if any(part.has(sp.Max, sp.Min) and not isinstance(part, constant) for part in (above, below)):
            raise InputError(_NESTED)
        result = constant(above, below)
        if len(result.args) > _MOST_UNORDERED and isinstance(result, constant):
            raise InputError(f"Abs, Min and Max of more than {_MOST_UNORDERED} parameters of unknown order")
        return result
    if not slope.has(symbols.v):
        if slope.is_positive:
            return piecewise([(below, -offset / slope)], above)
        if slope.is_negative:
            return piecewise([(above, -offset / slope)], below)
    elif (power := _as_power(difference)) is not None:
        factor, exponent, offset = power
        # Where -B/A is negative the difference has one sign at all speeds, and the place is 0.
        place = sp.Max(0, -offset / factor) ** (1 / exponent)
        return piecewise([(below if factor.is_positive else above, place)], above if factor.is_positive else below)
    raise InputError(
        "Abs, Min, Max and sign need arguments that differ by a linear function of v, or by A*v^p + B, with a "
        "slope of known sign; write Piecewise((..., v < place), ...) with the place of the kink instead"
    )


def _as_power(expr: Expr) -> tuple[Expr, Expr, Expr] | None:
    """Return A, p and B if an expression is A*v^p + B, A of known sign and p > 0."""
    offset, rest = expr.as_independent(symbols.v, as_Add=True)
    factor, power = rest.as_independent(symbols.v, as_Add=False)
    base, exponent = power.as_base_exp()
    fits = base == symbols.v and not exponent.has(symbols.v) and exponent.is_positive
    return (factor, exponent, offset) if fits and (factor.is_positive or factor.is_negative) else None


def pieces_of(term: Expr) -> tuple[list[Expr], list[Expr]] | None:
    """Return the smooth pieces of a term and the places between them; None if two kinks stand in one product."""
    kinked = [node for node in term.atoms(sp.Piecewise) if node.has(symbols.v)]
    if not kinked:
        return [term], []
    if len(kinked) > 1:
        return None
    (node,) = kinked
    return [term.xreplace({node: branch}) for branch, _ in node.args], places(node)


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
    known = {**values, symbols.v: start}
    kinked = [node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)]
    chosen = {node: next(part for part, holds in node.args if holds.xreplace(known)) for node in kinked}
    return expr.xreplace(chosen)


def at_rest(expr: Expr, values: Mapping[Expr, Expr]) -> Expr:
    """Return an expression with each kink replaced by what holds just above v = 0.

    Parameters
    ----------
    expr : sympy.Expr
    values : mapping of symbols to numbers
        Of the parameters that have one. Where the sign of a place is not known, a Piecewise over it stays.
    """
    known = {**values, symbols.v: sp.Integer(0)}
    kinked = [node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)]
    chosen = {node: sp.Piecewise(*[(part, holds.xreplace(known)) for part, holds in node.args]) for node in kinked}
    return expr.xreplace(chosen)


def jumps(expr: Expr) -> list[tuple[Expr, Expr]]:
    """Return the places where an expression itself may jump, and by how much: its right minus its left limit."""
    found = []
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

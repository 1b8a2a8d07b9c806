"""Laws with kinks and jumps: every one is a `Piecewise` in v, with its places in order.

Abs, Min and Max of functions that are linear in v become pieces when a law is read, so all that comes
later (closed forms, quadrature, fast functions) knows one kind of kink only, and knows exactly where it is.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp

from stickslip_sym import symbols
from stickslip_sym.errors import InputError

__all__ = ["absolute", "branch_from", "jumps", "larger", "pieces_of", "piecewise", "places", "smaller"]


_MOST_UNORDERED = 6  # SymPy compares all pairs of what stands in a Max, at length
_NESTED = "a kink inside a kink is not supported; write one Piecewise with all its places"


def piecewise(branches: Sequence[tuple[Any, Any]], last: Any) -> Any:
    """Return the law that is branch i for v < place i (and not in an earlier branch), else `last`."""
    if any(place.has(symbols.v) for _, place in branches):
        raise InputError("the places of a Piecewise are parameters or numbers; they cannot depend on v")
    if any(part.has(sp.Piecewise) for pair in [*branches, (last,)] for part in pair):
        raise InputError(_NESTED)
    pairs: list[tuple[Any, Any]] = []
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


def absolute(expr: Any) -> Any:
    """Return abs(expr), in pieces where it changes sign with v."""
    return larger(expr, -expr)


def smaller(first: Any, second: Any) -> Any:
    """Return the smaller of two expressions whose difference is linear in v, in pieces."""
    return _select(second, first, first - second, sp.Min)


def larger(first: Any, second: Any) -> Any:
    """Return the larger of two expressions whose difference is linear in v, in pieces.

    Raises
    ------
    InputError
        If the difference is not linear in v, or falls or rises with a slope of unknown sign.
    """
    return _select(first, second, first - second, sp.Max)


def _select(above: Any, below: Any, difference: Any, constant: Any) -> Any:
    """Return `above` where a difference is positive, else `below`; `constant` selects where v has no part."""
    if difference.has(sp.Piecewise):
        raise InputError(_NESTED)
    if difference.is_nonnegative or difference.is_nonpositive:
        return above if difference.is_nonnegative else below
    # Expanding could take for ever; a difference that is linear has a slope without v as it stands.
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
    raise InputError(
        "Abs, Min and Max need arguments that differ by a linear function of v with a slope of known sign; "
        "write Piecewise((..., v < place), ...) with the place of the kink instead"
    )


def pieces_of(term: Any) -> tuple[list[Any], list[Any]] | None:
    """Return the smooth pieces of a term and the places between them; None if two kinks stand in one product."""
    kinked = [node for node in term.atoms(sp.Piecewise) if node.has(symbols.v)]
    if not kinked:
        return [term], []
    if len(kinked) > 1:
        return None
    (node,) = kinked
    return [term.xreplace({node: branch}) for branch, _ in node.args], places(node)


def places(expr: Any) -> list[Any]:
    """Return the places of all kinks and jumps in an expression, as they stand there."""
    found: list[Any] = []
    for node in sp.ordered(expr.atoms(sp.Piecewise)):
        for _, condition in node.args:
            # SymPy may turn v < place round into place > v; pieces that became equal are joined by Or.
            relations = sp.ordered(condition.atoms(sp.StrictLessThan, sp.StrictGreaterThan))
            found += [relation.gts for relation in relations if relation.lts == symbols.v]
    return list(dict.fromkeys(found))


def branch_from(expr: Any, values: Mapping[Any, Any], start: Any) -> Any:
    """Return an expression with each kink replaced by the branch that holds just above a place.

    Parameters
    ----------
    expr : sympy.Expr
    values : mapping of symbols to numbers
        Of the parameters; the result keeps its symbols.
    start : sympy number
        A slip speed. Conditions read v < place, so the branch that holds there holds above.
    """
    known = {**values, symbols.v: start}
    kinked = [node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)]
    chosen = {node: next(part for part, holds in node.args if holds.xreplace(known)) for node in kinked}
    return expr.xreplace(chosen)


def jumps(expr: Any) -> list[tuple[Any, Any]]:
    """Return the places where an expression itself may jump, and by how much: its right minus its left limit."""
    found = []
    for node in sp.ordered(node for node in expr.atoms(sp.Piecewise) if node.has(symbols.v)):
        place: Any = None
        branches = [branch for branch, _ in node.args]
        for end, left, right in zip(places(node), branches, branches[1:], strict=False):
            # A piece that ends before it begins is none: the jumps into it and out of it meet at one place.
            place = end if place is None or (end - place).is_positive else sp.Max(place, end)
            height = expr.xreplace({node: right}) - expr.xreplace({node: left})
            height = sp.expand(height.subs(symbols.v, place))
            if height != 0:
                found.append((place, height))
    return found

"""Reading a friction coefficient: text or a SymPy expression becomes an expression of this package's symbols."""

import math
from collections.abc import Callable
from functools import reduce
from typing import Any

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import NumberPower, fold, power, row
from stickslip_sym.core.numbers import bits, exact
from stickslip_sym.model.expression.misspelt import check_constant, check_speed
from stickslip_sym.model.expression.normal_form import normal_form
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.parsing import KINKED, MAX_BITS, parse_expression
from stickslip_sym.model.expression.pieces import Bound, in_pieces

__all__ = ["read_formula", "read_static"]

MAX_POWER_OF_V = 24
MAX_POWER_OF_SUM = 16
MAX_TERMS = 600

_PLAIN = (sp.Add, sp.Mul, sp.Pow, sp.Number, sp.NumberSymbol, sp.Symbol, NumberPower)


def read_formula(formula: str | float | Expr, table: dict[str, Parameter], *, constant: bool = False) -> Expr:
    """Read a coefficient; parameters that it uses and `table` does not have are added there.

    Parameters
    ----------
    formula : str, number or sympy.Expr
    table : dict of str to Parameter
        Those that are described: no name in it is suspected of being another one misspelt.
    constant : bool
        Whether the formula needs no v, as that of a static coefficient.

    Raises
    ------
    InputError
        If the formula cannot be read, or holds what a law may not hold.

    Warns
    -----
    InputWarning
        If a name is probably v misspelt.
    """
    seen: set[str] = set()
    undescribed: list[str] = []

    def symbol(name: str) -> Expr:
        seen.add(name)
        if name == "v":
            return symbols.v
        if name not in table:
            check_constant(name)
            table[name] = Parameter(name)
            undescribed.append(name)
        return table[name].symbol

    if isinstance(formula, str):
        expr = parse_expression(formula, symbol)
    elif isinstance(formula, sp.Expr):
        expr = _rebuilt(formula, symbol)
    elif isinstance(formula, int | float) and not isinstance(formula, bool):
        expr = exact(formula, "the coefficient")
    else:
        raise InputError(f"a law is text or a SymPy expression, got {type(formula).__name__}")
    _check_value(expr)
    _check_size(expr)
    expr = normal_form(expr)
    check_speed(undescribed, has_v=constant or "v" in seen, bare=expr.is_Symbol)
    return expr


def _check_value(expr: Expr) -> None:
    if expr.has(sp.zoo, sp.oo, sp.nan, sp.I):
        raise InputError(f"the formula is not finite and real: it reduces to {str(expr)[:60]}")
    for node in expr.atoms(sp.Pow):
        if node.base.is_negative and node.exp.is_integer is False:
            raise InputError(f"{str(node)[:60]} is not real: only whole powers of a negative number are")


def _check_size(expr: Expr) -> None:
    """Refuse powers that later algebra could not expand in any reasonable time."""
    for node in expr.atoms(sp.Pow):
        base, exponent = node.args
        if base == symbols.v and exponent.is_number and abs(exponent) > MAX_POWER_OF_V:
            raise InputError(f"{node} is too high a power of v; at most v^{MAX_POWER_OF_V} is supported")
        if base.is_Add and exponent.is_Integer and abs(exponent) > MAX_POWER_OF_SUM:
            raise InputError(
                f"{str(node)[:60]} is too high a power of a sum; at most (...)^{MAX_POWER_OF_SUM} is supported"
            )
    if _terms(expr) > MAX_TERMS:
        raise InputError(
            f"the formula has over {MAX_TERMS} terms when its products are multiplied out; shorten it"
        )


def _terms(expr: Expr) -> int:
    """Return a bound on the number of terms after expansion."""
    if expr.is_Add:
        return sum(map(_terms, expr.args))
    if expr.is_Mul:
        return math.prod(map(_terms, expr.args))
    if expr.is_Pow and expr.exp.is_Integer:
        terms, power = _terms(expr.base), abs(int(expr.exp))
        return math.comb(terms + power - 1, power)
    return max(map(_terms, expr.args), default=1)


def _rebuilt(expr: Expr, symbol: Callable[[str], Expr]) -> Expr:
    """Return a SymPy expression on this package's symbols and kinks."""

    def rebuilt(node: Expr, parts: list[Any]) -> Any:
        """Return a node of rebuilt parts; of a condition, the bound that it is, None for everywhere."""
        if node.is_Symbol:
            return symbol(node.name)
        if isinstance(node, sp.Float | sp.Rational):
            number = sp.Rational(node)
            if bits(number) > MAX_BITS:
                raise InputError("a number in the formula has too many digits")
            return number
        if node is sp.true or isinstance(node, sp.core.relational.Relational):
            return None if node is sp.true else _bound(node, *parts)
        if isinstance(node, sp.Piecewise):
            *branches, (last, end) = zip(parts[::2], parts[1::2], strict=True)
            if not (end is None or any(end.completes(bound) for _, bound in branches if bound)):
                raise InputError("the last piece of a law holds at all other speeds; its condition is True")
            return in_pieces([(branch, bound) for branch, bound in branches if bound], last)
        if kinked := KINKED.get(type(node).__name__):
            return reduce(kinked, parts) if len(parts) > 1 else kinked(*parts)
        if isinstance(node, sp.erfc):
            return 1 - sp.erf(*parts)
        function = row(node)
        if not (isinstance(node, _PLAIN) or (function is not None and function.in_laws)):
            raise InputError(f"{type(node).__name__} is not allowed in a law: {str(node)[:60]}")
        if node.is_Pow and len(parts) == 2:
            return power(*parts)
        return node.func(*parts) if parts else node

    return fold(expr, rebuilt)


def _bound(relation: Expr, left: Expr, right: Expr) -> Bound:
    """Return where a piece with a condition v < place, or place < v, holds."""
    if isinstance(relation, sp.StrictLessThan | sp.StrictGreaterThan | sp.LessThan | sp.GreaterThan):
        strict = isinstance(relation, sp.StrictLessThan | sp.StrictGreaterThan)
        side = "<" if isinstance(relation, sp.StrictLessThan | sp.LessThan) else ">"
        for v, place, holds in ((left, right, side), (right, left, "<>"[side == "<"])):
            if v == symbols.v:
                return Bound(holds, place, strict)
    raise InputError(f"the pieces of a law end at v < place or v > place; got {relation}")


def read_static(static: str | float | Expr, table: dict[str, Parameter]) -> Expr:
    """Read a static coefficient, as `read_formula` reads a coefficient; it does not depend on v."""
    read = read_formula(static, table, constant=True)
    if read.has(symbols.v):
        raise InputError("the static coefficient is one number; it cannot depend on v")
    return read

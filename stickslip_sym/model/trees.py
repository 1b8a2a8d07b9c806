"""Expressions as nested lists that JSON can hold, exactly, and back.

A list is a head and its arguments, a text is a number, a symbol or a constant:
``["*", "5/2", "N", ["^", "V", "-2"]]``. Reading looks every head up in a table, builds it without evaluating
it, and bounds sizes, so a file from anywhere can be read.
"""

import re
from collections.abc import Mapping
from typing import Any, TypeAlias

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lerch import Lerch
from stickslip_sym.model.expression.parsing import FUNCTIONS

__all__ = ["Tree", "from_tree", "to_tree"]

Tree: TypeAlias = "str | list[Tree]"
"""A text, or a list of a head and its arguments."""

_SPECIAL = (
    sp.acos, sp.asin, sp.acosh, sp.atanh, sp.coth, sp.im, sp.re, sp.sign, sp.Abs, sp.Min, sp.Max,
    sp.besseli, sp.besselj, sp.besselk, sp.bessely, sp.gamma, sp.lowergamma, sp.uppergamma, sp.beta,
    sp.erfc, sp.erfi, sp.expint, sp.Ei, sp.Si, sp.Ci, sp.Shi, sp.Chi, sp.fresnels, sp.fresnelc,
    sp.polylog, sp.dirichlet_eta, sp.zeta, sp.hyper, sp.elliptic_k, sp.elliptic_e, sp.elliptic_pi, Lerch,
)  # fmt: skip
_HEADS: dict[str, type[Expr]] = {
    "+": sp.Add, "*": sp.Mul, "^": sp.Pow, "=": sp.Equality, "!=": sp.Unequality,
    "<": sp.StrictLessThan, ">": sp.StrictGreaterThan, "<=": sp.LessThan, ">=": sp.GreaterThan,
    "tuple": sp.Tuple, "integral": sp.Integral, "derivative": sp.Derivative, "mu": symbols.mu,
    "pieces": sp.Piecewise, "piece": sp.functions.elementary.piecewise.ExprCondPair,
    **{name: function for name, function in FUNCTIONS.items() if isinstance(function, type)},
    **{function.__name__: function for function in _SPECIAL},
}  # fmt: skip
_NAME_OF = {head: name for name, head in _HEADS.items()}
_CONSTANTS: dict[str, Expr] = {
    "pi": sp.pi, "I": sp.I, "Catalan": sp.Catalan, "EulerGamma": sp.EulerGamma, "true": sp.true,
}  # fmt: skip
_SYMBOLS: dict[str, Expr] = {
    **{name: quantity.symbol for name, quantity in symbols.QUANTITIES.items()},
    # No parameter begins with an underscore, so the variables of integration cannot be mistaken for one.
    **{f"_{dummy.name}": dummy for dummy in (symbols.u, symbols.s, symbols.theta)},
}
_KINDS: dict[Any, Any] = {
    sp.Integral: (sp.Expr, sp.Tuple), sp.Derivative: (sp.Expr, sp.Tuple), sp.hyper: (sp.Expr, sp.Tuple),
    sp.Piecewise: sp.functions.elementary.piecewise.ExprCondPair,
    sp.functions.elementary.piecewise.ExprCondPair: (sp.Expr, sp.logic.boolalg.Boolean),
}  # fmt: skip
"""What a head takes if not expressions."""
_EVALUATED_ALWAYS = (sp.Tuple, sp.Integral, sp.Derivative, symbols.mu, sp.hyper)

_NUMBER = re.compile(r"-?\d+(/\d+)?")
_MOST_NODES = 200_000
_DEEPEST = 200
_LONGEST = 4_000  # characters of a number; Python reads no longer ones
_LARGEST_ORDER = 100  # whole number as an argument of a function or a power: SymPy expands some at length


def to_tree(expr: Expr) -> Tree:
    """Return an expression, or a relation, as nested lists of text.

    Raises
    ------
    InputError
        For a function or a symbol that `from_tree` could not read.
    """
    if expr.is_Rational:
        return str(expr)
    for name, constant in (_CONSTANTS | _SYMBOLS).items():
        if expr == constant:
            return name
    if isinstance(expr, sp.Symbol) and not isinstance(expr, sp.Dummy):
        return str(expr.name)
    head = _NAME_OF.get(expr.func) or ("tuple" if isinstance(expr, sp.Tuple) else None)
    if head is None or not expr.args:
        raise InputError(f"{type(expr).__name__} has no written form: {str(expr)[:60]}")
    return [head, *map(to_tree, expr.args)]


def from_tree(tree: object, parameters: Mapping[str, Expr]) -> Expr:
    """Return the expression of a tree; the inverse of `to_tree`.

    Parameters
    ----------
    tree : list or str
    parameters : mapping of str to Symbol
        The symbols that the tree may hold beside those of the oscillator.

    Raises
    ------
    InputError
        For what no tree holds: unknown heads and names, wrong arguments, or too large a size.
    """
    return _Reader(_CONSTANTS | _SYMBOLS | dict(parameters)).read(tree, 0)


class _Reader:
    """One reading: counts the nodes."""

    def __init__(self, names: Mapping[str, Expr]) -> None:
        self.names = names
        self.nodes = 0

    def read(self, tree: object, depth: int) -> Expr:
        self.nodes += 1
        if self.nodes > _MOST_NODES or depth > _DEEPEST:
            raise InputError(f"an expression has over {_MOST_NODES} parts, or over {_DEEPEST} levels")
        if isinstance(tree, str):
            return self._leaf(tree)
        if not isinstance(tree, list) or not tree or not isinstance(tree[0], str) or tree[0] not in _HEADS:
            raise InputError(f"this is no part of an expression: {str(tree)[:60]}")
        head = _HEADS[tree[0]]
        arguments = [self.read(branch, depth + 1) for branch in tree[1:]]
        _check_arguments(tree[0], head, arguments)
        options = {} if head in _EVALUATED_ALWAYS else {"evaluate": False}
        try:
            if head is sp.functions.elementary.piecewise.ExprCondPair:
                return head(*arguments)
            return head(*arguments, **options)
        except (TypeError, ValueError, AttributeError, IndexError):
            raise InputError(f"{tree[0]} cannot have these arguments: {str(tree[1:])[:60]}") from None

    def _leaf(self, text: str) -> Expr:
        if text in self.names:
            return self.names[text]
        if _NUMBER.fullmatch(text) and len(text) <= _LONGEST and not text.endswith("/0"):
            return sp.Rational(text)
        raise InputError(f"{text[:60]!r} is neither a number nor a name that is known here")


def _check_arguments(name: str, head: type[Expr], arguments: list[Expr]) -> None:
    """Refuse arguments of another kind than the head takes, and sizes that SymPy does not finish."""
    expected = _KINDS.get(head, sp.Expr)
    if not arguments or not all(isinstance(argument, expected) for argument in arguments):
        raise InputError(f"{name} cannot have these arguments: {str(arguments)[:60]}")
    if (
        head is sp.Pow
        and arguments[0].is_number
        and any(power.exp.is_Integer and abs(power.exp) > 1 for power in arguments[0].atoms(sp.Pow))
    ):
        raise InputError("a number is a power of a power; write it out")
    if head in (sp.Add, sp.Mul, sp.Tuple, symbols.mu) or issubclass(head, sp.core.relational.Relational):
        return
    for argument in arguments:
        if argument.is_Integer and abs(argument) > _LARGEST_ORDER:
            raise InputError(f"{_NAME_OF[head]} is given {str(argument)[:20]}; at most {_LARGEST_ORDER} is read")

"""Text to SymPy expressions, without ever evaluating text.

The text is parsed by Python's own grammar into a syntax tree, and the tree is translated node by node;
what is not listed here, or in the table of functions, does not exist. Limits on length, depth and the size of
numbers keep the work that a short text can ask for small.
"""

import ast
import re
import warnings
from collections.abc import Callable
from functools import reduce
from typing import NoReturn

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import CONSTANTS, in_laws, power
from stickslip_sym.core.numbers import bits, suggestion, within
from stickslip_sym.model.expression.pieces import Bound, absolute, in_pieces, larger, sign, smaller
from stickslip_sym.model.expression.spelling import ALIASES, INSTEAD, NAME, Source, normalised, refuse

__all__ = ["KINKED", "NAME", "parse_expression"]

KINKED: dict[str, Callable[..., Expr]] = {"Abs": absolute, "Min": smaller, "Max": larger, "sign": sign}
"""The functions that make kinks; Min and Max take two arguments or more."""

PIECEWISE = "Piecewise((formula, v < place), ..., last formula)"
"""How a law in pieces is written; at a place itself, the formula above it holds."""

MAX_LENGTH = 2000
MAX_DEPTH = 60
MAX_EXPONENT = 64
MAX_DIGITS = 60
MAX_ARGUMENT = 1_000_000
MAX_KINKS = 40
MAX_BITS = 4096  # of a number that constant arithmetic may produce
_MAX_ROOT_BITS = 256  # of a number that a root is taken of: SymPy looks for its factors
_NOT_FINITE = frozenset({sp.zoo, sp.nan, sp.oo, -sp.oo})
_RELATIONS = {ast.Lt: ("<", True), ast.LtE: ("<", False), ast.Gt: (">", True), ast.GtE: (">", False)}


def parse_expression(text: str, symbol: Callable[[str], Expr]) -> Expr:
    """Translate a formula into a SymPy expression.

    Parameters
    ----------
    text : str
        A formula in Python's notation; ``^`` is a power like ``**``. Decimal numbers stay exact.
    symbol : callable
        Given a name, returns its symbol (or any SymPy expression), or raises `InputError`.

    Raises
    ------
    InputError
        With the position of the first character that cannot be used, and what is allowed there.
    """
    if not isinstance(text, str):
        raise InputError(f"a formula is text, got {type(text).__name__}")
    if not text.strip():
        raise InputError("the formula is empty; write one like 'mu_m + (mu_s - mu_m)*exp(-alpha*v)'")
    if len(text) > MAX_LENGTH:
        raise InputError(f"the formula has {len(text)} characters; at most {MAX_LENGTH} are allowed")
    source = normalised(text)
    _check_depth(text, source)
    return _Translator(text, source, symbol).translate()


def _check_depth(text: str, source: Source) -> None:
    depth = 0
    for column, character in enumerate(source.text):
        depth += (character == "(") - (character == ")")
        if depth > MAX_DEPTH:
            refuse(text, source.position(column), f"more than {MAX_DEPTH} nested parentheses")


def _coefficient(expr: Expr) -> Expr:
    """Return the rational factor of an expression, which a power raises with it."""
    return expr if expr.is_Rational else expr.as_coeff_Mul(rational=True)[0]


class _Translator:
    """One translation: keeps the text so that a refusal can point at its character."""

    def __init__(self, text: str, source: Source, symbol: Callable[[str], Expr]) -> None:
        self.original = text
        self.source = source
        self.symbol = symbol
        self.kinks = 0
        rows = {name: function.kind for name, function in in_laws().items()}
        self.functions: dict[str, Callable[[Expr], Expr]] = rows | {"erfc": lambda x: 1 - sp.erf(x)}
        self.constants = {constant.name: constant.value for constant in CONSTANTS.values() if constant.in_laws}
        self.callable = [*self.functions, "sqrt", *KINKED, "Piecewise"]

    def translate(self) -> Expr:
        try:
            with warnings.catch_warnings(action="ignore"):  # about texts such as 1or, which are refused anyway
                tree = ast.parse(self.source.text, mode="eval")
        except SyntaxError as error:
            position = self.source.position((error.offset or 1) - 1)
            refuse(self.original, position, f"the formula cannot be read: {error.msg}")
        except (RecursionError, MemoryError, ValueError):
            raise InputError("the formula is nested too deeply; write it in fewer levels") from None
        return self._expression(tree.body, 0)

    def _fail(self, node: ast.AST, reason: str) -> NoReturn:
        refuse(self.original, self.source.position(getattr(node, "col_offset", 0)), reason)

    def _expression(self, node: ast.expr, depth: int) -> Expr:
        if depth > MAX_DEPTH * 4:
            self._fail(node, "the formula is nested too deeply; write it in fewer levels")
        match node:
            case ast.Constant():
                return self._number(node)
            case ast.Name(id=name):
                return self._name(node, name)
            case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
                operand = self._expression(node.operand, depth + 1)
                return -operand if isinstance(node.op, ast.USub) else operand
            case ast.BinOp():
                left = self._expression(node.left, depth + 1)
                right = self._expression(node.right, depth + 1)
                return self._binary(node, left, right)
            case ast.Call():
                return self._call(node, depth)
            case ast.Tuple():
                self._fail(node, "a comma stands between two formulas; a decimal number has a point: write 0.2")
            case ast.Compare():
                self._fail(node, f"a comparison is no number; for a law in pieces write {PIECEWISE}")
            case _:
                kind = type(node).__name__.lower()
                self._fail(node, f"{kind} is not allowed; a formula has numbers, names, + - * / ^ and functions")

    def _number(self, node: ast.Constant) -> Expr:
        text = ast.get_source_segment(self.source.text, node) or ""
        if not re.fullmatch(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?", text) or len(text) > MAX_DIGITS:
            self._fail(node, f"{text[:20]!r} is not a decimal number of at most {MAX_DIGITS} characters")
        return sp.Rational(text)

    def _name(self, node: ast.AST, name: str) -> Expr:
        if name in self.callable or name in ALIASES:
            self._fail(node, f"{name} is a function; write {name}(...)")
        if not NAME.fullmatch(name):
            self._fail(node, f"{name[:45]!r} is not a usable name: ASCII letters, digits, '_', at most 40")
        if name in self.constants:
            return self.constants[name]
        return self._guarded(node, lambda: self.symbol(name))

    def _checked(self, node: ast.AST, result: Expr) -> Expr:
        if result in _NOT_FINITE:
            self._fail(node, "this part of the formula has no finite value")
        if bits(_coefficient(result)) > MAX_BITS:
            self._fail(node, "a number in the formula grows too large")
        return result

    def _binary(self, node: ast.BinOp, left: Expr, right: Expr) -> Expr:
        match node.op:
            case ast.Add():
                result = left + right
            case ast.Sub():
                result = left - right
            case ast.Mult():
                result = left * right
            case ast.Div():
                if right == 0:
                    self._fail(node.right, "division by zero")
                result = left / right
            case ast.Pow():
                result = self._power(node.right, left, right)
            case _:
                self._fail(node, "only + - * / and ^ (or **) combine terms")
        return self._checked(node, result)

    def _power(self, node: ast.AST, base: Expr, exponent: Expr) -> Expr:
        if exponent.is_number and not within(exponent, MAX_EXPONENT):
            self._fail(node, f"a numeric exponent is real and at most {MAX_EXPONENT} in size")
        if base == 0 and exponent.is_number and exponent.is_negative:
            self._fail(node, "division by zero")
        if exponent.is_Integer and (bits(_coefficient(base)) - 1) * abs(exponent) > MAX_BITS:
            self._fail(node, "a number in the formula grows too large")  # before it is computed
        if base.is_Rational and not exponent.is_Integer and bits(base) > _MAX_ROOT_BITS:
            self._fail(node, "a root is taken of a number with too many digits")
        return power(base, exponent)

    def _call(self, node: ast.Call, depth: int) -> Expr:
        if not isinstance(node.func, ast.Name):
            self._fail(node, "only a named function can be called, like exp(...)")
        name = ALIASES.get(node.func.id, node.func.id)
        if name in INSTEAD and name not in self.functions:
            self._fail(node, f"there is no function {name!r}; write {INSTEAD[name]}")
        if name not in self.callable:
            hint, known = suggestion(name, [*self.callable, *ALIASES]), ", ".join(self.callable)
            product = "" if hint else f"; a product is written {name[:40]}*(...)"
            self._fail(node, f"there is no function {name[:40]!r}{hint}{product}; known: {known}")
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            self._fail(node, f"{name} takes plain arguments only")
        if name == "Piecewise":
            return self._piecewise(node, depth)
        several = name in ("Min", "Max")
        if (len(node.args) < 2) if several else (len(node.args) != 1):
            count = "two arguments or more" if several else "one argument; a decimal number has a point, as in 0.2"
            self._fail(node, f"{name} takes {count}")
        arguments = [self._expression(argument, depth + 1) for argument in node.args]
        if name in KINKED:
            self._count_kinks(node, len(arguments))
            kinked = KINKED[name]
            return self._guarded(node, lambda: reduce(kinked, arguments) if several else kinked(*arguments))
        return self._checked(node, self._function(node, name, *arguments))

    def _function(self, node: ast.Call, name: str, argument: Expr) -> Expr:
        if name == "sqrt":
            return self._power(node, argument, sp.S.Half)
        # A tower such as exp(exp(exp(exp(9)))) is short to write, and no computer holds its value.
        if argument.is_number and name not in ("log", "ln") and not within(argument, MAX_ARGUMENT):
            self._fail(node, f"a number in {name}(...) is real and at most {MAX_ARGUMENT} in size")
        return self.functions[name](argument)

    def _count_kinks(self, node: ast.AST, more: int) -> None:
        self.kinks += more
        if self.kinks > MAX_KINKS:
            self._fail(node, f"Abs, Min, Max and Piecewise have more than {MAX_KINKS} arguments in all")

    def _piecewise(self, node: ast.Call, depth: int) -> Expr:
        *branches, last = node.args or [node]
        self._count_kinks(node, len(branches))
        pairs = []
        for branch in branches:
            formula, bound = self._piece(branch)
            if bound is None:
                self._fail(branch, f"a law in pieces is written {PIECEWISE}; only the last one may end in True")
            pairs.append((self._expression(formula, depth + 1), bound))
        formula, end = self._piece(last) if isinstance(last, ast.Tuple) else (last, None)
        if not pairs or (end is not None and not any(end.completes(bound) for _, bound in pairs)):
            self._fail(last, f"a law in pieces is written {PIECEWISE}; the last one may end in True")
        rest = self._expression(formula, depth + 1)
        return self._guarded(node, lambda: in_pieces(pairs, rest))

    def _piece(self, node: ast.expr) -> tuple[ast.expr, Bound | None]:
        """Return the formula of a piece and where it holds; None is everywhere."""
        match node:
            case ast.Tuple(elts=[formula, ast.Constant(value=True)]):
                return formula, None
            case ast.Tuple(elts=[formula, ast.Compare(left=left, ops=[op], comparators=[right])]):
                if type(op) in _RELATIONS:
                    side, strict = _RELATIONS[type(op)]
                    for name, place, holds in ((left, right, side), (right, left, "<>"[side == "<"])):
                        if isinstance(name, ast.Name) and name.id == "v":
                            self.symbol("v")
                            return formula, Bound(holds, self._expression(place, 1), strict)
        self._fail(node, f"a law in pieces is written {PIECEWISE}")

    def _guarded(self, node: ast.AST, make: Callable[[], Expr]) -> Expr:
        """Point at the node whose making was refused."""
        try:
            return make()
        except InputError as error:
            self._fail(node, str(error))

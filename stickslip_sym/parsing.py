"""Text to SymPy expressions, without ever evaluating text.

The text is parsed by Python's own grammar into a syntax tree, and the tree is translated node by node;
what is not listed here does not exist. Limits on length, depth and the size of numbers keep the work
that a short text can ask for small.
"""

import ast
import re
from collections.abc import Callable
from typing import Any, NoReturn

import sympy as sp

from stickslip_sym.errors import InputError
from stickslip_sym.values import suggestion

__all__ = ["FUNCTIONS", "NAME", "parse_expression"]

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""What a name looks like: ASCII letters, digits and underscores, at most 40."""

FUNCTIONS: dict[str, Any] = {
    "exp": sp.exp, "log": sp.log, "sqrt": sp.sqrt,
    "sin": sp.sin, "cos": sp.cos, "tan": sp.tan,
    "sinh": sp.sinh, "cosh": sp.cosh, "tanh": sp.tanh, "sech": sp.sech,
    "asinh": sp.asinh, "atan": sp.atan, "erf": sp.erf,
}  # fmt: skip
"""The functions of one argument that a formula may use."""

MAX_LENGTH = 2000
MAX_DEPTH = 60
MAX_EXPONENT = 64
MAX_DIGITS = 60
_MAX_BITS = 4096  # of a number that constant arithmetic may produce

_CHARACTERS = re.compile(r"[A-Za-z0-9_+\-*/^()., \t\r\n]")
_POWER = re.compile(r"\^")


def parse_expression(text: str, symbol: Callable[[str], Any]) -> Any:
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
    for position, character in enumerate(text):
        if not _CHARACTERS.fullmatch(character):
            _refuse(text, position, f"the character {character!r} has no meaning in a formula")
    _check_depth(text)
    return _Translator(text, symbol).translate()


def _refuse(text: str, position: int, reason: str) -> NoReturn:
    position = min(position, len(text))
    start = max(0, position - 40)
    window = re.sub(r"\s", " ", text[start : position + 30])
    raise InputError(f"{reason} (character {position + 1})\n  {window}\n  {' ' * (position - start)}^")


def _check_depth(text: str) -> None:
    depth = 0
    for position, character in enumerate(text):
        depth += (character == "(") - (character == ")")
        if depth > MAX_DEPTH:
            _refuse(text, position, f"more than {MAX_DEPTH} nested parentheses")


class _Translator:
    """One translation: keeps the text so that a refusal can point at its character."""

    def __init__(self, text: str, symbol: Callable[[str], Any]) -> None:
        self.original = text
        # One line, so that a column is a position; '^' would bind too loosely as Python's xor.
        self.source = _POWER.sub("**", re.sub(r"\s", " ", text))
        self.symbol = symbol

    def translate(self) -> Any:
        stripped = self.source.lstrip()
        self.indent = len(self.source) - len(stripped)
        try:
            tree = ast.parse(stripped, mode="eval")
        except SyntaxError as error:
            column = (error.offset or 1) - 1
            _refuse(self.original, self._position(column), f"the formula cannot be read: {error.msg}")
        except (RecursionError, MemoryError, ValueError):
            raise InputError("the formula is nested too deeply; write it in fewer levels") from None
        return self._expression(tree.body, 0)

    def _position(self, column: int) -> int:
        """Map a column of the parsed source to a position in the text as it was given."""
        target = column + self.indent
        shift = 0
        for match in _POWER.finditer(self.original):
            if match.start() + shift < target:
                shift += 1
        return target - shift

    def _fail(self, node: ast.AST, reason: str) -> NoReturn:
        _refuse(self.original, self._position(getattr(node, "col_offset", 0)), reason)

    def _expression(self, node: ast.expr, depth: int) -> Any:
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
            case _:
                kind = type(node).__name__.lower()
                self._fail(node, f"{kind} is not allowed; a formula has numbers, names, + - * / ^ and functions")

    def _number(self, node: ast.Constant) -> Any:
        text = ast.get_source_segment(self.source.lstrip(), node) or ""
        if not re.fullmatch(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", text) or len(text) > MAX_DIGITS:
            self._fail(node, f"{text[:20]!r} is not a decimal number of at most {MAX_DIGITS} characters")
        return sp.Rational(text)

    def _name(self, node: ast.AST, name: str) -> Any:
        if name in FUNCTIONS:
            self._fail(node, f"{name} is a function; write {name}(...)")
        if not NAME.fullmatch(name):
            self._fail(node, f"{name[:45]!r} is not a usable name: ASCII letters, digits, '_', at most 40")
        try:
            return self.symbol(name)
        except InputError as error:
            self._fail(node, str(error))

    def _binary(self, node: ast.BinOp, left: Any, right: Any) -> Any:
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
                result = self._power(node, left, right)
            case _:
                self._fail(node, "only + - * / and ^ (or **) combine terms")
        if result.is_Rational and max(int(result.p).bit_length(), int(result.q).bit_length()) > _MAX_BITS:
            self._fail(node, "a number in the formula grows too large")
        return result

    def _power(self, node: ast.BinOp, base: Any, exponent: Any) -> Any:
        if exponent.is_number and not abs(exponent) <= MAX_EXPONENT:
            self._fail(node.right, f"a numeric exponent is at most {MAX_EXPONENT} in size")
        if base == 0 and exponent.is_number and exponent.is_negative:
            self._fail(node.right, "division by zero")
        return base**exponent

    def _call(self, node: ast.Call, depth: int) -> Any:
        if not isinstance(node.func, ast.Name):
            self._fail(node, "only a named function can be called")
        name = node.func.id
        if name not in FUNCTIONS:
            known = ", ".join(FUNCTIONS)
            self._fail(node, f"there is no function {name[:40]!r}{suggestion(name, FUNCTIONS)}; known: {known}")
        if len(node.args) != 1 or node.keywords or isinstance(node.args[0], ast.Starred):
            self._fail(node, f"{name} takes one argument")
        return FUNCTIONS[name](self._expression(node.args[0], depth + 1))

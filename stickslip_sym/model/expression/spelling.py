"""Spellings of a formula: what users write, brought to the one notation that is parsed."""

import re
from dataclasses import dataclass
from typing import NoReturn

from stickslip_sym.core.errors import InputError

__all__ = ["ALIASES", "INSTEAD", "NAME", "TAKEN", "Source", "normalised", "refuse"]

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""What a name looks like: ASCII letters, digits and underscores, at most 40."""

ALIASES = {
    "ln": "log", "abs": "Abs", "min": "Min", "max": "Max", "sgn": "sign",
    "arctan": "atan", "arcsinh": "asinh", "arsinh": "asinh",
}  # fmt: skip
"""Other names of functions that are read, with the name that is printed."""

INSTEAD = {
    "log10": "log(x)/log(10)", "log2": "log(x)/log(2)", "log1p": "log(1 + x)", "expm1": "exp(x) - 1",
    "exp2": "2^x", "pow": "x^y", "cbrt": "x^(1/3)", "root": "x^(1/n)", "square": "x^2", "erfi": "erf and exp",
    "cosec": "1/sin(x)", "csc": "1/sin(x)", "sec": "1/cos(x)", "cot": "1/tan(x)",
    "csch": "1/sinh(x)", "coth": "1/tanh(x)", "logistic": "1/(1 + exp(-x))", "sigmoid": "1/(1 + exp(-x))",
    "Heaviside": "Piecewise((0, v < place), 1)", "heaviside": "Piecewise((0, v < place), 1)",
    "where": "Piecewise((formula, v < place), last formula)", "clip": "Min(Max(x, low), high)",
}  # fmt: skip
"""Functions that are not read, with what to write for them."""

TAKEN = frozenset(
    {
        "exp", "log", "sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "sech", "asinh", "atan", "erf", "erfc",
        "Abs", "Min", "Max", "sign", "Piecewise", "pi", *ALIASES, *INSTEAD,
    }
)  # fmt: skip
"""The names of functions and constants, which no parameter may have."""

_FOREIGN = re.compile(r"[^A-Za-z0-9_+\-*/^()., <>=|\t\r\n]")
_BEFORE_OPERAND = frozenset("+-*/^(,<>=")


def refuse(text: str, position: int, reason: str) -> NoReturn:
    """Raise an `InputError` that points at a character of a text."""
    position = min(position, len(text))
    start = max(0, position - 40)
    window = re.sub(r"\s", " ", text[start : position + 30])
    raise InputError(f"{reason} (character {position + 1})\n  {window}\n  {' ' * (position - start)}^")


@dataclass(frozen=True)
class Source:
    """A formula in Python's notation on one line.

    Attributes
    ----------
    text : str
    origin : tuple of int
        For each of its characters, and for its end, the position in what the user wrote.
    """

    text: str
    origin: tuple[int, ...]

    def position(self, column: int) -> int:
        """Return where in the user's text a column comes from."""
        return self.origin[min(max(column, 0), len(self.text))]


def normalised(text: str) -> Source:
    """Return a formula with ``**`` for ``^`` and ``Abs(...)`` for bars.

    Raises
    ------
    InputError
        For a character that has no meaning, and for bars without a partner.
    """
    if foreign := _FOREIGN.search(text):
        refuse(text, foreign.start(), f"the character {foreign[0]!r} has no meaning in a formula")
    # ``^`` would bind too loosely as Python's xor; one line, so that a column is a position.
    spelled = {"^": "**", "\t": " ", "\r": " ", "\n": " "} | _bars(text)
    parts = [spelled.get(i if character == "|" else character, character) for i, character in enumerate(text)]
    start = len(text) - len(text.lstrip())
    origin = [i for i, part in enumerate(parts) for _ in part if i >= start]
    return Source("".join(parts[start:]), (*origin, len(text)))


def _bars(text: str) -> dict[str | int, str]:
    """Return what stands for each bar: one opens where an operand may begin, and closes elsewhere."""
    spelled: dict[str | int, str] = {}
    opened: list[tuple[int, int]] = []  # bars, and how many parentheses were open there
    depth, operand = 0, True
    for position, character in enumerate(text):
        if character == "|":
            if operand:
                opened.append((position, depth))
            elif not opened or opened.pop()[1] != depth:
                refuse(text, position, "a bar without its partner; write |v - a| or Abs(v - a)")
            spelled[position] = "Abs(" if operand else ")"
        elif not character.isspace():
            depth += (character == "(") - (character == ")")
            operand = character in _BEFORE_OPERAND
    if opened:
        refuse(text, opened[-1][0], "a bar without its partner; write |v - a| or Abs(v - a)")
    return spelled

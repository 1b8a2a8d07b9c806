"""Spellings of a formula: what users type, brought to the one notation that is parsed.

Only what has one meaning is read: Greek letters, ``2mu_s``, ``alpha v``, ``)exp(``, a left side ``mu(v) =``. For
anything else the refusal says what to write.
"""

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import CONSTANTS, in_laws

__all__ = ["ALIASES", "INSTEAD", "NAME", "Source", "normalised", "refuse", "taken"]

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""What a name looks like: ASCII letters, digits and underscores, at most 40."""

ALIASES = {"abs": "Abs", "min": "Min", "max": "Max", "sgn": "sign", "piecewise": "Piecewise"}
"""Other names of what makes kinks; those of functions stand in their rows."""

INSTEAD = {
    "log10": "log(x)/log(10)", "log2": "log(x)/log(2)", "log1p": "log(1 + x)", "expm1": "exp(x) - 1",
    "exp2": "2^x", "pow": "x^y", "cbrt": "x^(1/3)", "root": "x^(1/n)", "square": "x^2", "erfi": "erf and exp",
    "cosec": "1/sin(x)", "csc": "1/sin(x)", "sec": "1/cos(x)", "cot": "1/tan(x)", "frac": "a/b",
    "csch": "1/sinh(x)", "coth": "1/tanh(x)", "logistic": "1/(1 + exp(-x))", "sigmoid": "1/(1 + exp(-x))",
    "Heaviside": "Piecewise((0, v < place), 1)", "heaviside": "Piecewise((0, v < place), 1)",
    "where": "Piecewise((formula, v < place), last formula)", "clip": "Min(Max(x, low), high)",
}  # fmt: skip
"""Functions that are not read, with what to write for them."""

_KINKED = ("Abs", "Min", "Max", "sign", "Piecewise")
_LIBRARIES = ("np", "numpy", "math", "sp", "sympy", "scipy", "mpmath")
_WORDS = {
    "if": "write Piecewise((formula, v < place), last formula) for cases",
    "else": "write Piecewise((formula, v < place), last formula) for cases",
    "lambda": "write the formula alone, in v",
    "and": "write one place for each piece: Piecewise((formula, v < place), last formula)",
    "or": "write one place for each piece: Piecewise((formula, v < place), last formula)",
}
"""Words of programs, with what to do; Python would read them as such."""
_SIGNS = {
    "·": "*", "×": "*", "∙": "*", "⋅": "*", "∗": "*", "−": "-", "–": "-", "÷": "/", "≤": "<=", "≥": ">=",
    "[": "(", "]": ")", "{": "(", "}": ")", "\t": " ", "\r": " ", "\n": " ", "\u00a0": " ",
}  # fmt: skip
"""Characters that have one meaning, with the plain ones; a formula is one line, so that a column is a position."""
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_LEFT_SIDE = re.compile(r"\s*\\?(?:mu|μ|µ)\s*(?:\(\s*v\s*\))?\s*=(?!=)")
_TOKEN = re.compile(
    r"(?P<number>(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?)(?P<joined>[A-Za-z0-9_]*)"
    r"|(?P<name>\\?[A-Za-zͰ-Ͽµ_][A-Za-z0-9Ͱ-Ͽµ_]*)|(?P<raised>[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)|(?P<other>\*\*|.)",
    re.DOTALL,
)
_PLAIN = frozenset("+-*/^()., <>=|")
_BEFORE_OPERAND = frozenset("+-*/^(,<>=")


def taken() -> set[str]:
    """Return the names of functions and constants, which no parameter may have."""
    constants = [constant.name for constant in CONSTANTS.values() if constant.in_laws]
    return {*in_laws(), "sqrt", "erfc", *_KINKED, *ALIASES, *INSTEAD, *constants}


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


@dataclass(frozen=True)
class _Token:
    """A word or a sign, and where it stands in what the user wrote."""

    text: str
    position: int
    kind: str

    @property
    def ends_operand(self) -> bool:
        return self.kind in ("name", "number") or self.text == ")"

    @property
    def begins_operand(self) -> bool:
        return self.kind in ("name", "number") or self.text in ("(", "Abs(")


def normalised(text: str) -> Source:
    """Return a formula with ``**`` for ``^``, ``Abs(...)`` for bars, and a ``*`` wherever factors are multiplied.

    Raises
    ------
    InputError
        For a character that has no meaning, for bars without a partner, and for words of programs.
    """
    tokens = _multiplied(text, _without_bars(text, list(_tokens(text))))
    spelled = [("**" if token.text == "^" else token.text, token.position) for token in tokens]
    joined = "".join(part for part, _ in spelled)
    start = len(joined) - len(joined.lstrip())
    origin = [position for part, position in spelled for _ in part][start:]
    return Source(joined[start:], (*origin, len(text)))


def _tokens(text: str) -> Iterator[_Token]:
    """Yield the words and signs of a formula, each in its plain spelling."""
    left = _LEFT_SIDE.match(text)
    for match in _TOKEN.finditer(text, left.end() if left else 0):
        position, word = match.start(), match[0]
        if match["number"]:
            yield from _number(text, match)
        elif match["raised"]:
            yield _Token("^", position, "sign")
            yield _Token(f"({word.translate(_SUPERSCRIPTS)})", position, "number")
        elif match["name"]:
            yield _Token(_name(text, position, word), position, "name")
        else:
            sign = _SIGNS.get(word, word)
            if not _PLAIN.issuperset(sign):
                advice = {":": ": write one formula, without assignments", "%": ": write a decimal number"}.get(
                    sign, ""
                )
                refuse(text, position, f"the character {word!r} has no meaning in a formula{advice}")
            yield _Token(sign, position, "sign")


def _number(text: str, match: re.Match[str]) -> Iterator[_Token]:
    """Yield a number, and a name that stands right after it: 2mu_s is 2*mu_s, but 0x10 and 2j are neither."""
    number, joined, position = match["number"], match["joined"], match.start()
    if not joined:
        yield _Token(number, position, "number")
    elif re.match(r"[A-Za-z]", joined) and not re.fullmatch(r"[xXoObBjJ][0-9a-fA-F_]*|[eE]\d*", joined):
        yield _Token(number, position, "number")
        yield _Token(joined, position + len(number), "name")
    else:
        refuse(text, position, f"{match[0][:20]!r} is not a decimal number")


def _name(text: str, position: int, word: str) -> str:
    """Return a name with its Greek letters spelled out, and a function's in small letters as it is known."""
    spelled = re.sub(r"[Ͱ-Ͽµ]", lambda letter: _greek(text, position, letter[0]), word.removeprefix("\\"))
    if spelled in _WORDS:
        refuse(text, position, f"{spelled!r} is no part of a formula; {_WORDS[spelled]}")
    if word.startswith("\\") and spelled == "cdot":
        return "*"
    called = text[position + len(word) :].lstrip()[:1] == "("
    return spelled.lower() if called and spelled not in taken() and spelled.lower() in taken() else spelled


def _greek(text: str, position: int, letter: str) -> str:
    name = unicodedata.name(letter, "").replace("MICRO SIGN", "GREEK SMALL LETTER MU")
    small, capital = "GREEK SMALL LETTER ", "GREEK CAPITAL LETTER "
    if name.startswith(small) and " " not in (word := name.removeprefix(small)):
        return word.lower().replace("lamda", "lambda_")
    if name.startswith(capital) and " " not in (word := name.removeprefix(capital)):
        return word.capitalize()
    refuse(text, position, f"the character {letter!r} has no meaning in a formula")


def _without_bars(text: str, tokens: list[_Token]) -> list[_Token]:
    """Return ``Abs(`` and ``)`` for bars: one opens where an operand may begin, and closes elsewhere."""
    spelled = []
    opened: list[tuple[int, int]] = []  # bars, and how many parentheses were open there
    depth, operand = 0, True
    for token in tokens:
        if token.text == "|":
            if operand:
                opened.append((token.position, depth))
            elif not opened or opened.pop()[1] != depth:
                refuse(text, token.position, "a bar without its partner; write |v - a| or Abs(v - a)")
            spelled.append(_Token("Abs(" if operand else ")", token.position, "sign"))
            continue
        spelled.append(token)
        if not token.text.isspace():
            depth += (token.text == "(") - (token.text == ")")
            operand = token.text[-1] in _BEFORE_OPERAND
    if opened:
        refuse(text, opened[-1][0], "a bar without its partner; write |v - a| or Abs(v - a)")
    return spelled


def _multiplied(text: str, tokens: list[_Token]) -> Iterator[_Token]:
    """Yield the tokens with a ``*`` where two operands stand side by side, and without the names of libraries."""
    before: _Token | None = None
    skip = 0
    for i, token in enumerate(tokens):
        if skip:
            skip -= 1
            continue
        if token.kind == "name" and token.text in _LIBRARIES and i + 1 < len(tokens) and tokens[i + 1].text == ".":
            skip = 1
            continue
        if token.text.isspace():
            yield token
            continue
        if before is not None and before.ends_operand and token.begins_operand:
            # A name and a parenthesis are a call; parse says what it is if there is no such function.
            if before.kind == "number" and token.kind == "number":
                refuse(text, token.position, "two numbers side by side; write an operator between them")
            if not (before.kind == "name" and token.text == "("):
                yield _Token("*", token.position, "sign")
        yield token
        before = token

r"""Text to SymPy expressions, without ever evaluating text.

A formula is cut into tokens and read by recursive descent; what is not listed here, or in the table of functions,
does not exist. What people type is read where it has one meaning: Greek letters, ``2mu_s``, ``alpha v``, ``√v``,
``e^(-v)``, a left side ``mu(v) =`` or ``@(v)``, MATLAB's ``.*``, and the LaTeX of a paper, ``\frac{v}{v_{s}}``;
for anything else the refusal says what to write. Limits on length, depth and the size of numbers keep the work
that a short text can ask for small.
"""

import keyword
import operator
import re
import unicodedata
from collections.abc import Callable, Container, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import reduce
from itertools import pairwise
from typing import NoReturn

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import CONSTANTS, functions_in_laws, power
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.numbers import MOST_NUMBER_CHARACTERS, NUMBER_BITS, bits, is_within
from stickslip_sym.model.expression.pieces import (
    MOST_PIECES,
    Bound,
    bound_of,
    larger,
    piecewise_law,
    sign,
    smaller,
)

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
"""What a name looks like: ASCII letters, digits and underscores, at most 40."""

KINKED: dict[str, Callable[..., Expr]] = {
    "Abs": lambda x: larger(x, -x), "Min": lambda *parts: reduce(smaller, parts),
    "Max": lambda *parts: reduce(larger, parts), "sign": sign, "Heaviside": lambda x: (1 + sign(x)) / 2,
}  # fmt: skip
"""The functions that make kinks; Min and Max take two arguments or more."""

_ALIASES = {
    "abs": "Abs", "min": "Min", "max": "Max", "sgn": "sign", "piecewise": "Piecewise", "heaviside": "Heaviside",
}  # fmt: skip
"""Other names of what makes kinks; those of functions stand in their rows."""

_INSTEAD = {
    "log10": "log(x)/log(10)", "log2": "log(x)/log(2)", "log1p": "log(1 + x)", "expm1": "exp(x) - 1",
    "exp2": "2^x", "pow": "x^y", "cbrt": "x^(1/3)", "root": "x^(1/n)", "square": "x^2", "erfi": "erf and exp",
    "cosec": "1/sin(x)", "csc": "1/sin(x)", "sec": "1/cos(x)", "cot": "1/tan(x)", "frac": "a/b",
    "csch": "1/sinh(x)", "logistic": "1/(1 + exp(-x))", "sigmoid": "1/(1 + exp(-x))",
    "where": "Piecewise((formula, v < place), last formula)", "clip": "Min(Max(x, low), high)",
}  # fmt: skip
"""Functions that are not read, with what to write for them."""

_CASES = "Piecewise((formula, v < place), last formula)"
_PIECEWISE = "a law in pieces is written Piecewise((formula, v < place), ..., last formula)"
"""At a place itself, the formula above it holds."""
_WORDS = {
    "if": f"write {_CASES} for cases", "else": f"write {_CASES} for cases",
    "and": f"write one place for each piece: {_CASES}", "or": f"write one place for each piece: {_CASES}",
    "lambda": "write the formula alone, in v",
}  # fmt: skip
"""Words of programs, with what to do."""
_LIBRARIES = ("np", "numpy", "math", "sp", "sympy", "scipy", "mpmath")
_SIGNS = {
    "·": "*", "×": "*", "∙": "*", "⋅": "*", "∗": "*", "\\cdot": "*", "−": "-", "–": "-", "÷": "/", "**": "^",
    "∣": "|", "[": "(", "]": ")", "{": "(", "}": ")", "≤": "<=", "≥": ">=",
    "\\times": "*", "\\le": "<=", "\\ge": ">=", ".*": "*", "./": "/", ".^": "^", "\\{": "(", "\\}": ")",
}  # fmt: skip
"""Signs that have one meaning, with the plain ones."""
_LETTERS_OF_GREEK = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi pi rho sigma tau upsilon phi chi "
    "psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega varepsilon vartheta varrho varphi"
)
_GREEK = frozenset(_LETTERS_OF_GREEK.split())
_PLAIN = frozenset({*"+-*/^()|,.<>√", "<=", ">=", "=="})
_RELATIONS = ("<", "<=", ">", ">=")
_OPERATORS = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv}
_BINDING = {"+": 1, "-": 1, "*": 2, "/": 2, "^": 4}
"""How tightly operators bind; a sign binds as a product."""
_ADVICE = {":": ": write one formula, without assignments", "%": ": write a decimal number"}
_SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
_ARGUMENT = r"(?:\\left)?\(\s*v\s*(?:\\right)?\)"
_LEFT_SIDE = re.compile(
    rf"\s*\$*\s*(?:\\?(?:mu|μ|µ)\s*(?:{_ARGUMENT})?\s*=(?!=))?\s*(?:@\s*{_ARGUMENT}|lambda\s+v\s*:)?"
)
_RIGHT_END = re.compile(r"[\s;$]*\Z")
_UPRIGHT = r"\\(?:mathrm|text|mathit|operatorname)\s*\{[A-Za-z0-9]+\}"
_INDEX = rf"_(?:\{{[A-Za-z0-9]+\}}|\{{\s*{_UPRIGHT}\s*\}}|\{{\\rm\s+[A-Za-z0-9]+\}}|{_UPRIGHT})"
_COMMAND = re.compile(r"\\(?:mathrm|mathit|text|operatorname|rm|,|;|:|!| )|[_{}]|\s")
"""What LaTeX has around the letters of a name."""
_TOKEN = re.compile(
    r"(?P<blank>\s+|\\(?:left|right|[Bb]igg?[lr]?)(?![A-Za-z])|\\[,;:! ]|~)"
    r"|(?P<fraction>\\[dt]?frac(?![A-Za-z]))"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(?P<joined>[A-Za-z0-9_]*)"
    r"|(?P<sign>\*\*|<=|>=|==|\\cdot|\\times|\\le(?![A-Za-z])|\\ge(?![A-Za-z])|\\[{}]|\.[*/^])"
    rf"|(?P<name>{_UPRIGHT}(?:{_INDEX})?"
    r"|\\?[A-Za-zͰ-Ͽµ_][A-Za-z0-9Ͱ-Ͽµ]*(?:"
    + _INDEX
    + r"|[A-Za-z0-9Ͱ-Ͽµ_]*))|(?P<raised>⁻?[⁰¹²³⁴⁵⁶⁷⁸⁹]+)|(?P<other>.)",
    re.DOTALL,
)
_NUMBER = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?0*[0-3]?\d{1,2})?")

_MAX_LENGTH = 2000
_MAX_DEPTH = 60
_MAX_EXPONENT = 64
_MAX_ARGUMENT = 1_000_000
_MAX_ROOT_BITS = 256  # of a number that a root is taken of: SymPy looks for its factors
_NOT_FINITE = frozenset({sp.zoo, sp.nan, sp.oo, -sp.oo})


def taken() -> set[str]:
    """Return the names of functions and constants, which no parameter may have."""
    constants = [constant.name for constant in CONSTANTS.values() if constant.in_laws]
    return {
        *functions_in_laws(),
        "sqrt",
        "erfc",
        "re",
        "sinc",
        "Piecewise",
        *KINKED,
        *_ALIASES,
        *_INSTEAD,
        *constants,
    }


def parse_expression(text: str, symbol: Callable[[str], Expr], described: Container[str] = ()) -> Expr:
    """Translate a formula into a SymPy expression; `symbol` gives that of a name, or refuses it.

    A name that is `described`, or stands elsewhere without a parenthesis behind it, is a factor: a(1 + v) is a
    product.

    A formula has + - * / ^ and functions; ``**`` is a power like ``^``. Decimal numbers stay exact. A refusal has
    the position of the first character that cannot be used, and says what is allowed there.
    """
    if not isinstance(text, str):
        raise InputError(f"a formula is text, got {type(text).__name__}")
    if not text.strip():
        raise InputError("the formula is empty; write one like 'mu_m + (mu_s - mu_m)*exp(-alpha*v)'")
    if len(text) > _MAX_LENGTH:
        raise InputError(f"the formula has {len(text)} characters; at most {_MAX_LENGTH} are allowed")
    return _Parser(text, symbol, described).formula()


def _refuse(text: str, position: int, reason: str | InputError) -> NoReturn:
    """Raise an `InputError` that points at a character of a text."""
    position = min(position, len(text))
    start = max(0, position - 40)
    window = re.sub(r"\s", " ", text[start : position + 30])
    raise InputError(reason, f" (character {position + 1})\n  {window}\n  {' ' * (position - start)}^")


@dataclass(frozen=True)
class _Token:
    """A number, a name or a sign in its plain spelling, and where it stands in what the user wrote."""

    kind: str
    text: str
    position: int


def _tokens(text: str) -> list[_Token]:
    """Return the tokens of a formula, the last one of the kind "end"."""
    left = _LEFT_SIDE.match(text)
    right = _RIGHT_END.search(text)
    start = left.end() if left else 0
    stop = right.start() if right else len(text)
    tokens: list[_Token] = []
    for match in _TOKEN.finditer(text, start, max(start, stop)):
        position = match.start()
        word = match[0]
        if match["number"]:
            tokens += _number_and_name(text, match)
        elif match["raised"]:  # a power, like ^-2
            tokens.append(_Token("sign", "^", position))
            number = word.translate(_SUPERSCRIPTS)
            tokens += [_Token("sign", "-", position)] * number.startswith("-")
            tokens.append(_Token("number", number.removeprefix("-"), position))
        elif match["fraction"]:
            tokens.append(_Token("fraction", word, position))
        elif match["name"]:
            tokens.append(_Token("name", _read_name(text, position, word), position))
        elif match["blank"] is None:
            sign = _SIGNS.get(word, word)
            if sign not in _PLAIN:
                _refuse(
                    text, position, f"the character {word!r} has no meaning in a formula{_ADVICE.get(sign, '')}"
                )
            if sign == "." and tokens and tokens[-1].text in _LIBRARIES:
                tokens.pop()  # np.exp is exp
            elif sign == ".":
                _refuse(text, position, "an attribute is not allowed; a formula has numbers, names and functions")
            else:
                tokens.append(_Token("sign", sign, position))
    return [*tokens, _Token("end", "", len(text))]


def _number_and_name(text: str, match: re.Match[str]) -> list[_Token]:
    """Return a number, and a name that stands right after it: 2mu_s is 2*mu_s, but 0x10 and 2j are neither."""
    number = match["number"]
    joined = match["joined"]
    position = match.start()
    power_of_e = joined == "e" and text[match.end() :].lstrip().startswith(("^", "**"))
    if (
        joined
        and not power_of_e
        and (not joined[0].isalpha() or re.fullmatch(r"[xXoObBjJ][0-9a-fA-F_]*|[eE]\d*", joined))
    ):
        _refuse(text, position, f"{match[0][:20]!r} is not a decimal number")
    if not _NUMBER.fullmatch(number) or len(number) > MOST_NUMBER_CHARACTERS:
        reason = f"{number[:20]!r} is not a decimal number of at most {MOST_NUMBER_CHARACTERS} characters"
        _refuse(text, position, reason)
    name = []
    if joined:
        name = [_Token("name", joined, position + len(number))]
    return [_Token("number", number, position), *name]


def _read_name(text: str, position: int, word: str) -> str:
    """Return a name with its Greek letters spelled out, and a function's in small letters as it is known."""
    plain, _, index = word.partition("_")
    letters = _COMMAND.sub("", plain).removeprefix("\\")
    if "{" in word or "\\" in index:
        word_in_letters = letters
        if index:
            word_in_letters = f"{letters}_{_COMMAND.sub('', index)}"
    else:
        word_in_letters = word.removeprefix("\\")
    spelled = re.sub(r"[Ͱ-Ͽµ]", lambda letter: _greek(text, position, letter[0]), word_in_letters)
    if word.startswith("\\"):
        spelled = _command(text, position, spelled, is_letter="{" not in word.partition("_")[0])
    if spelled in _WORDS:
        _refuse(text, position, f"{spelled!r} is no part of a formula; {_WORDS[spelled]}")
    called = text[position + len(word) :].lstrip()[:1] == "("
    if called and spelled not in taken() and spelled.lower() in taken():
        return spelled.lower()
    return spelled


def _command(text: str, position: int, spelled: str, *, is_letter: bool) -> str:
    """Return the name that a command of LaTeX stands for: a Greek letter, a function, or what is set upright."""
    letter = spelled.partition("_")[0]
    if is_letter and letter not in _GREEK and letter.lower() not in {name.lower() for name in taken()}:
        _refuse(text, position, f"the command {letter[:30]!r} is not known here; write the formula in plain names")
    if letter == "lambda":
        return "lambda_" + spelled.removeprefix("lambda")
    return spelled.removeprefix("var")


def _greek(text: str, position: int, letter: str) -> str:
    name = unicodedata.name(letter, "").replace("MICRO SIGN", "GREEK SMALL LETTER MU")
    size, _, word = name.removeprefix("GREEK ").partition(" LETTER ")
    if size not in ("SMALL", "CAPITAL") or not word.isalpha():
        _refuse(text, position, f"the character {letter!r} has no meaning in a formula")
    if size == "SMALL":
        return word.lower().replace("lamda", "lambda_")
    return word.capitalize()


class _Parser:
    """Reads one formula: a method for each rule of the grammar, from sums down to operands."""

    def __init__(self, text: str, symbol: Callable[[str], Expr], described: Container[str]) -> None:
        self.text = text
        self.symbol = symbol
        self.described = described
        self.tokens = _tokens(text)
        self.alone = {one.text for one, after in pairwise(self.tokens) if one.kind == "name" and after.text != "("}
        self.place = self.depth = self.kinks = self.bars = 0
        self.functions: dict[str, Callable[..., Expr]] = {
            "sinc": lambda x: sp.sin(x) / x,
            **{name: function.kind for name, function in functions_in_laws().items()},
            "erfc": lambda x: 1 - sp.erf(x), "sqrt": sp.sqrt, "re": lambda x: x, **KINKED,
        }  # fmt: skip
        self.known = [*self.functions, "Piecewise"]
        self.constants = {constant.name: constant.value for constant in CONSTANTS.values() if constant.in_laws}

    # -- tokens --

    @property
    def next(self) -> _Token:
        return self.tokens[self.place]

    def take(self, *signs: str) -> _Token | None:
        """Return the next token and go beyond it if it is one of some signs; else None."""
        token = self.next
        if token.kind != "sign" or token.text not in signs:
            return None
        self.place += 1
        return token

    def fail(self, token: _Token, reason: str | InputError) -> NoReturn:
        _refuse(self.text, token.position, reason)

    def close(self, opened: _Token, bracket: str) -> None:
        if not self.take(bracket):
            self._fail_after_operand(opened)

    def _fail_after_operand(self, opened: _Token | None) -> NoReturn:
        """Refuse what stands where an operator, or the end of the formula, is expected."""
        token = self.next
        if token.text == ",":
            self.fail(token, "a comma stands between two formulas; a decimal number has a point: write 0.2")
        if token.text in (*_RELATIONS, "=="):
            self.fail(token, f"a comparison is no number; {_PIECEWISE}")
        for bar in (token, opened):
            if bar is not None and bar.text == "|":
                self.fail(bar, "a bar without its partner; write |v - a| or Abs(v - a)")
        if opened is not None:
            self.fail(opened, "the formula cannot be read: this parenthesis is not closed")
        self.fail(token, "the formula cannot be read: an operator is missing here")

    @contextmanager
    def pointing_at(self, token: _Token) -> Iterator[None]:
        """Point at the token whose meaning is refused."""
        try:
            yield
        except InputError as error:
            self.fail(token, error)

    # -- grammar --

    def formula(self) -> Expr:
        result = self.expression()
        if self.next.kind != "end":
            self._fail_after_operand(None)
        return result

    def expression(self, least: int = 0) -> Expr:
        """Return what stands up to an operator that binds no tighter than `least`: -v^-2 is -(v^(-2))."""
        signed = False
        side = 1
        while sign := self.take("+", "-"):
            signed = True
            if sign.text == "-":
                side = -side
        start = self.next
        divisor = None
        if signed:
            result = side * self.expression(max(least, _BINDING["*"]))
        else:
            result = self.operand()
        while True:
            token = self.next
            opens = token.text in ("(", "√") or (token.text == "|" and not self.bars)
            implied = opens or token.kind in ("number", "name", "fraction")  # a product without its sign
            symbol = "*" if implied else token.text
            if _BINDING.get(symbol, 0) <= least:
                return result
            if token.kind == "number" and self.tokens[self.place - 1].kind == "number":
                self.fail(token, "two numbers side by side; write an operator between them")
            if implied and divisor is not None:
                below = self.text[divisor.position : token.position].strip()
                factor = token.text
                self.fail(
                    token, f"a product after a quotient: write /({below}*{factor}...) or /{below}*{factor}..."
                )
            self.place += not implied
            right = self.next
            if symbol == "/":
                divisor = right
            elif symbol != "^":
                divisor = None
            if symbol == "^":  # from the right: v^a^2 is v^(a^2)
                exponent = self.nested(right, lambda: self.expression(_BINDING["^"] - 1))
                result = self._checked(start, self._power(right, result, exponent))
            else:
                operand = self.expression(_BINDING[symbol])
                if symbol == "/" and operand == 0:
                    self.fail(right, "division by zero")
                result = self._checked(token, _OPERATORS[symbol](result, operand))

    def operand(self) -> Expr:
        token = self.next
        if token.kind == "number":
            self.place += 1
            return sp.Rational(token.text)
        if token.kind == "fraction":
            self.place += 1
            return self.nested(token, lambda: self._fraction(token))
        if token.kind == "name":
            self.place += 1
            if self._is_power_of_function(token):
                return self.nested(token, lambda: self._power_of_function(token))
            is_named = self._is_command(token) or token.text in self.described or token.text in self.alone
            product = token.text not in taken() and is_named
            called = not product and self.take("(")
            if called:
                return self.nested(token, lambda: self._call(token))
            return self._name(token)
        if self.take("√"):
            bare = self.next.text != "("
            root = self.nested(token, self.operand)
            if bare and (self.next.kind in ("number", "name") or self.next.text in ("(", "^")):
                self.fail(token, "what the root is of has two readings; write sqrt(...)")
            return self._checked(token, self._power(token, root, sp.S.Half))
        if self.take("(", "|"):
            return self.nested(token, lambda: self._enclosed(token))
        self.fail(token, "the formula cannot be read: a number, a name or a parenthesis is missing here")

    def nested(self, token: _Token, read: Callable[[], Expr]) -> Expr:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            self.fail(token, f"more than {_MAX_DEPTH} nested parentheses and powers")
        result = read()
        self.depth -= 1
        return result

    def _is_command(self, token: _Token) -> bool:
        """Return whether a name is written as LaTeX, with a backslash before it or braces in it."""
        return self.text[token.position] == "\\" or self.text.startswith("{", token.position + len(token.text) - 1)

    def _is_power_of_function(self, token: _Token) -> bool:
        r"""Return whether a name is a function of LaTeX with a power on it, as in \tanh^{2}(v)."""
        return token.text in self.functions and self._is_command(token) and self.next.text == "^"

    def _power_of_function(self, token: _Token) -> Expr:
        self.take("^")
        exponent = self.operand()
        opened = self.take("(")
        if opened is None:
            self.fail(token, f"the argument of {token.text} stands in parentheses: write {token.text}(...)")
        return self._checked(token, self._power(token, self._call(token), exponent))

    def _root_of_order(self, token: _Token) -> Expr:
        r"""Return a root whose order stands in brackets, as in \sqrt[3]{v}."""
        order = self.expression()
        self.close(token, ")")
        opened = self.take("(")
        if opened is None or order == 0:
            self.fail(token, "a root of an order is written \\sqrt[n]{x}, or x^(1/n)")
        argument = self.expression()
        self.close(opened, ")")
        return self._checked(token, self._power(token, argument, 1 / order))

    def _fraction(self, token: _Token) -> Expr:
        parts = []
        for what in ("numerator", "denominator"):
            opened = self.take("(")
            if opened is None:
                self.fail(token, f"the {what} of this fraction stands in braces: \\frac{{a}}{{b}}")
            parts.append(self.expression())
            self.close(opened, ")")
        above, below = parts
        if below == 0:
            self.fail(token, "division by zero")
        return self._checked(token, above / below)

    def _enclosed(self, opened: _Token) -> Expr:
        bar = opened.text == "|"
        self.bars += bar
        inner = self.expression()
        self.close(opened, "|" if bar else ")")
        self.bars -= bar
        if bar:
            return self._kinked(opened, "Abs", [inner])
        return inner

    def _name(self, token: _Token) -> Expr:
        name = token.text
        if name in self.known or name in _ALIASES:
            self.fail(token, f"{name} is a function; write {name}(...)")
        if not NAME.fullmatch(name) or keyword.iskeyword(name):
            self.fail(token, f"{name[:45]!r} is not a usable name: ASCII letters, digits, '_', at most 40")
        if name in self.constants:
            return self.constants[name]
        if name == "e" and self.next.text == "^":  # Euler's number, unless a parameter is described by this name
            with suppress(InputError):
                return self.symbol(name)
            return sp.E
        with self.pointing_at(token):
            return self.symbol(name)

    def _call(self, token: _Token) -> Expr:
        name = _ALIASES.get(token.text, token.text)
        if name == "Piecewise":
            return self._piecewise(token)
        if name == "sqrt" and self.text[self.tokens[self.place - 1].position] == "[" and self._is_command(token):
            return self._root_of_order(token)
        if name not in self.functions:
            if name in _INSTEAD:
                self.fail(token, f"there is no function {name!r}; write {_INSTEAD[name]}")
            hint = suggestion(name, [*self.known, *_ALIASES])
            known = ", ".join(self.known)
            product = ""
            if not hint:
                product = f"; a product is written {name[:40]}*(...)"
            self.fail(token, f"there is no function {name[:40]!r}{hint}{product}; known: {known}")
        arguments = [] if self.next.text == ")" else [self.expression()]
        while self.take(","):
            arguments.append(self.expression())
        self.close(token, ")")
        several = name in ("Min", "Max")
        if (len(arguments) < 2) if several else (len(arguments) != 1):
            count = "two arguments or more" if several else "one argument; a decimal number has a point, as in 0.2"
            self.fail(token, f"{name} takes {count}")
        if name in KINKED:
            return self._kinked(token, name, arguments)
        (argument,) = arguments
        if name == "sqrt":
            return self._checked(token, self._power(token, argument, sp.S.Half))
        # A tower such as exp(exp(exp(exp(9)))) is short to write, and no computer holds its value.
        if argument.is_number and name not in ("log", "ln") and not is_within(argument, _MAX_ARGUMENT):
            self.fail(token, f"a number in {name}(...) is real and at most {_MAX_ARGUMENT} in size")
        return self._checked(token, self.functions[name](argument))

    # -- pieces --

    def _kinked(self, token: _Token, name: str, arguments: list[Expr]) -> Expr:
        self._count_kinks(token, len(arguments))
        with self.pointing_at(token):
            return KINKED[name](*arguments)

    def _piecewise(self, token: _Token) -> Expr:
        pieces = [self._piece()]
        while self.take(","):
            pieces.append(self._piece())
        self.close(token, ")")
        *branches, (place, last, end) = pieces
        self._count_kinks(token, len(branches))
        bounds: list[tuple[Expr, Bound]] = []
        for start, formula, bound in branches:
            if bound is None:
                self.fail(start, f"{_PIECEWISE}; only the last one may end in True")
            bounds.append((formula, bound))
        if not any(end is None or (bound.place == end.place and bound.side != end.side) for _, bound in bounds):
            self.fail(place, f"{_PIECEWISE}; the last one may end in True")
        with self.pointing_at(token):
            return piecewise_law(bounds, last)

    def _piece(self) -> tuple[_Token, Expr, Bound | None]:
        """Return where a piece stands, its formula, and where that holds; None is everywhere."""
        token = self.next
        bound = None
        if token.text == ")":
            self.fail(token, _PIECEWISE)
        if not self._is_pair():
            return token, self.expression(), None
        self.take("(")
        formula = self.expression()
        self.take(",")
        if self.next.text == "True":
            self.place += 1
        else:
            left = self.expression()
            relation = self.take(*_RELATIONS)
            if relation:
                bound = bound_of(left, relation.text, self.expression())
            else:
                bound = None
            if bound is None:
                self.fail(token, _PIECEWISE)
        if not self.take(")"):
            self.fail(token, _PIECEWISE)
        return token, formula, bound

    def _is_pair(self) -> bool:
        """Return whether a comma stands within the parenthesis that begins here, and not deeper."""
        depth = 0
        for token in self.tokens[self.place :]:
            depth += (token.text == "(") - (token.text == ")")
            if depth == 0 or (depth == 1 and token.text == ","):
                return depth == 1
        return False

    # -- limits --

    def _count_kinks(self, token: _Token, more: int) -> None:
        self.kinks += more
        if self.kinks > MOST_PIECES:
            self.fail(token, f"Abs, Min, Max and Piecewise have more than {MOST_PIECES} arguments in all")

    def _power(self, token: _Token, base: Expr, exponent: Expr) -> Expr:
        if exponent.is_number and not is_within(exponent, _MAX_EXPONENT):
            self.fail(token, f"a numeric exponent is real and at most {_MAX_EXPONENT} in size")
        if base == 0 and exponent.is_number and exponent.is_negative:
            self.fail(token, "division by zero")
        if exponent.is_Integer and (bits(_coefficient(base)) - 1) * abs(exponent) > NUMBER_BITS:
            self.fail(token, "a number in the formula grows too large")  # before it is computed
        if base.is_Rational and not exponent.is_Integer and bits(base) > _MAX_ROOT_BITS:
            self.fail(token, "a root is taken of a number with too many digits")
        return power(base, exponent)

    def _checked(self, token: _Token, result: Expr) -> Expr:
        if result in _NOT_FINITE:
            self.fail(token, "this part of the formula has no finite value")
        if bits(_coefficient(result)) > NUMBER_BITS:
            self.fail(token, "a number in the formula grows too large")
        return result


def _coefficient(expr: Expr) -> Expr:
    """Return the rational factor of an expression, which a power raises with it."""
    if expr.is_Rational:
        return expr
    return expr.as_coeff_Mul(rational=True)[0]

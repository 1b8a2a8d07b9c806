r"""LaTeX set to a width: formulas broken into lines, and plain words with mathematics in them.

A line breaks before a plus or a minus, at the outermost brackets where one fits. Widths are those of Computer
Modern at 10 pt, from above, so a formula that is broken here fits the text.
"""

import re
import unicodedata
from collections.abc import Callable, Sequence
from string import ascii_lowercase, ascii_uppercase, digits

from stickslip_sym.core.aliases import Notation
from stickslip_sym.core.errors import InputError
from stickslip_sym.output.notation import latex_name

LINE = 341.0  # points in 120 mm
_SHORT_PART = 0.3  # of a line: nothing is aligned behind a longer left side, and no line is left shorter

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|[A-Za-z]|\d|\s+|.", re.S)
_WIDE = {
    **dict.fromkeys(ascii_lowercase, 5.3), **dict.fromkeys("fhnux", 6.1), **dict.fromkeys("mw", 8.8),
    **dict.fromkeys(ascii_uppercase, 7.7), **dict.fromkeys("DGHKNQX", 8.9), **dict.fromkeys("MW", 10.5),
    **dict.fromkeys(digits, 5.0),
    "+": 12.3, "-": 12.3, "=": 13.4, "<": 13.4, ">": 13.4, ",": 4.5, ";": 4.5, "/": 5.0, "(": 3.9, ")": 3.9,
    "[": 2.8, "]": 2.8, "'": 2.8, r"\{": 5.0, r"\}": 5.0, r"\alpha": 6.4, r"\beta": 5.9, r"\gamma": 5.5,
    r"\delta": 4.6, r"\theta": 4.7, r"\mu": 6.1, r"\pi": 5.8, r"\eta": 5.0, r"\psi": 6.6, r"\int": 11.2,
    r"\infty": 10.0, r"\ln": 10.1, r"\sin": 14.0, r"\cos": 15.1, r"\tan": 16.2, r"\sinh": 19.6, r"\cosh": 20.7,
    r"\tanh": 21.7, r"\coth": 20.6, r"\arctan": 29.5, r"\arcsin": 27.4, r"\arccos": 28.5, r"\min": 18.4,
    r"\max": 20.3, r"\exp": 17.0, r"\to": 15.6, r"\sim": 13.4, r"\approx": 13.4,
    r"\,": 1.7, r"\!": -1.7, r"\;": 2.8, r"\quad": 10.0,
    r"\bigl": 0.8, r"\bigr": 0.8, r"\biggl": 3.5, r"\biggr": 3.5, r"\left": 1.6, r"\right": 1.6,
}  # fmt: skip
"""Points of each sign: its advance or the right edge of its ink, whichever is more, rounded up to a tenth.

A class of letters is as wide as its widest. From the metrics of the fonts cmmi10, cmr10, cmsy10 and cmex10 (a
test holds them against matplotlib's copies), with the space that TeX sets around an operator (20/9 on each side)
or a relation (25/9), behind a function's name, a comma or an integral (5/3), and with what larger brackets are
wider than plain ones."""
_WITH_ARGUMENTS: dict[str, tuple[int, Callable[..., float]]] = {
    r"\frac": (2, lambda top, below: max(top, below) + 3.0), r"\sqrt": (1, lambda inner: inner + 9.0),
    r"\operatorname": (1, lambda inner: inner + 3.4), r"\hat": (1, float),
    **dict.fromkeys((r"\mathrm", r"\mathit", r"\text", r"\textrm"), (1, float)),
    **dict.fromkeys("^_", (1, lambda script: 0.76 * script + 0.6)),
}  # fmt: skip
"""How many arguments a command has, and its width from theirs."""
_OTHER_WIDTH = _WIDE[r"\psi"]  # the widest small Greek letter, and wider than signs such as | and *
_INDENT_WIDTH = 2 * _WIDE[r"\quad"]
_DEPTHS = {"(": 1, "[": 1, r"\{": 1, ")": -1, "]": -1, r"\}": -1}
_FIXED = {r"\left": 1, r"\begin": 1, r"\right": -1, r"\end": -1}


def width(latex: str) -> float:
    """Return the width of a formula in points, seldom too small."""
    return _places(latex)[1]


def _part(tokens: Sequence[str], i: int) -> tuple[float, int]:
    """Return the width of a token with its arguments, or of a group, and where the next one begins."""
    if i >= len(tokens):
        return 0.0, i
    token = tokens[i]
    i += 1
    if token == "{":
        total = 0.0
        while i < len(tokens) and tokens[i] != "}":
            part, i = _part(tokens, i)
            total += part
        return total, i + 1
    if token.isspace():
        return 0.0, i
    count, of_arguments = _WITH_ARGUMENTS.get(token, (0, float))
    if not count:
        return _WIDE.get(token, _OTHER_WIDTH), i
    arguments = []
    for _ in range(count):
        argument, i = _part(tokens, i)
        arguments.append(argument)
    return of_arguments(*arguments), i


def displayed(left: str, right: str, *, relation: str = "=", label: str = "", tag: str = "") -> str:
    """Return a displayed equation, broken to fit the text.

    - `left, right`: the sides.
    - `relation`: what stands between them.
    - `label`: to number it and refer to it.
    - `tag`: to be printed instead of a number.
    """
    line = LINE
    if label or tag:
        line -= width(tag or "(99)") + _WIDE[r"\quad"]
    begin = f"{left} {relation} "
    if width(begin + right) <= line:
        body = f"  {begin}{right}"
    else:
        if width(begin) <= _SHORT_PART * line:
            rows = _broken(right, line - width(begin), line - width(begin) - _INDENT_WIDTH)
            rows = [f"{left} &{relation} {rows[0]}", *(f"&\\quad {row}" for row in rows[1:])]
        else:
            above = _broken(left, line, line - _INDENT_WIDTH)
            below = _broken(right, line - 2 * _INDENT_WIDTH, line - 2 * _INDENT_WIDTH)
            rows = ["& " + above[0], *(f"&\\quad {row}" for row in above[1:])]
            rows += [f"&\\quad {{}}{relation} {below[0]}", *(f"&\\qquad {row}" for row in below[1:])]
        inner = " \\\\\n  ".join(rows)
        body = f"  \\begin{{split}}\n  {inner}\n  \\end{{split}}"
    environment = "equation" if label else "equation*"
    mark = (f"  \\label{{{label}}}\n" if label else "") + (f"  \\tag*{{{tag}}}\n" if tag else "")
    return f"\\begin{{{environment}}}\n{mark}{body}\n\\end{{{environment}}}"


def _broken(latex: str, first: float, later: float) -> list[str]:
    """Break a formula into lines of at most so many points, the first one of another length."""
    places, end = _places(latex)
    rows = []
    begin = 0
    done = 0.0
    line = first
    while end - done > line:
        left = [place for place in places if place[0] > begin]
        # What is wider than a line, and cannot be broken, stands alone at least.
        fitting = [place for place in left if place[2] - done <= line] or left[:1]
        if not fitting:
            break
        good = [place for place in fitting if place[2] - done >= _SHORT_PART * line] or fitting
        depth = min(place[1] for place in good)
        position, _, before = max(place for place in good if place[1] == depth)
        rows.append(latex[begin:position].rstrip())
        begin = position
        done = before
        line = later
    rows.append(latex[begin:])
    return rows[:1] + [f"{{}}{row}" for row in rows[1:]]


def _places(latex: str) -> tuple[list[tuple[int, int, float]], float]:
    r"""Return where a line may end, how deep in brackets and after how many points that is, and the whole width.

    Never inside a group, or between \left and \right.
    """
    tokens = _TOKEN.findall(latex)
    breaks = []
    position = 0
    depth = 0
    fixed = 0
    total = 0.0
    i = 0
    while i < len(tokens):
        token = tokens[i]
        if token in "+-" and not fixed and i and tokens[i - 1].isspace() and tokens[i + 1].isspace():
            breaks.append((position, depth, total))
        fixed += _FIXED.get(token, 0)
        depth += _DEPTHS.get(token, 0)
        part, following = _part(tokens, i)
        total += part
        position += sum(map(len, tokens[i:following]))
        i = following
    return breaks, total


# -- words -----------------------------------------------------------------------------------------


def key(name: str | None) -> str:
    r"""Return a name as it may stand in a ``\label``."""
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name or "").strip("-") or "law"


_SIGNS = {character: "\\" + character for character in "&%$#_{}"} | {
    "\\": r"\textbackslash{}", "^": r"\textasciicircum{}", "~": r"\textasciitilde{}", "|": r"\textbar{}",
    '"': "''", "<": "$<$", ">": "$>$", "−": "$-$", "≤": r"$\le$", "≥": r"$\ge$", "≈": r"$\approx$", "≠": r"$\ne$",
    "∞": r"$\infty$", "√": r"$\surd$", "′": "$'$", "″": "$''$", "→": r"$\to$", "µ": r"$\mu$", "∝": r"$\propto$",
    "∂": r"$\partial$", "°": r"$^{\circ}$",
    **{raised: f"$^{{{plain}}}$" for raised, plain in zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻", "0123456789+-", strict=True)},
    **{lowered: f"$_{{{plain}}}$" for lowered, plain in zip("₀₁₂₃₄₅₆₇₈₉₊₋", "0123456789+-", strict=True)},
}  # fmt: skip
_NOT_SET = re.compile("[ĦħĸĿŀŉŦŧſ]|[^ -~¡-ſ‐-–—‘’‚“”„†‡•…‰‹›€™]")
_WORD = re.compile(
    r"(sqrt)\((\w+)\)|([A-Za-z]\w*)('*)\((\w+)\)|([A-Za-z]\w*)(?:\^(\d))?|(\d)[+]|(\d+(?:\.\d+)?)|( )|(.)", re.S
)
_ARTICLE = re.compile(r" (?!(?:and|as|at|by|for|in|is|of|or|to)\b)[A-Za-z]{2}")
"""What follows an a, A or I that is a word, not a symbol."""
_BETWEEN = {"=": "=", "+": "+", "/": "/"} | {
    sign: _SIGNS[sign].strip("$") for sign in "<>≤≥≈≠→−" if _SIGNS[sign].startswith("$")
}
"""Signs that make one formula of what stands on either side."""


def prose_latex(text: str, names: Notation | None = None) -> str:
    """Return plain words as LaTeX; names of symbols in them become mathematics, and relations between them too.

    - `names`: LaTeX of the symbols; single letters count only if they are among them.

    Raises `InputError` for a character that pdflatex has no sign for.
    """
    text = unicodedata.normalize("NFC", re.sub(r"\s+", " ", text))
    pieces = [_piece(match, names or {}) for match in _WORD.finditer(text)]
    words = "".join(f"${content}$" if is_formula else content for content, is_formula in _join_formulas(pieces))
    # After an abbreviation TeX would leave the space that follows a sentence.
    return re.sub(r"\b(e\.g\.|eq\.) ", r"\1~", words).replace(" - ", " $-$ ")


def _piece(match: re.Match[str], known: Notation) -> tuple[str, bool]:
    """Return a word, a number or a sign as LaTeX, and whether that is a formula."""
    root, radicand, function, primes, argument, name, power, above, number, space, other = match.groups()
    if root:
        return f"\\sqrt{{{known.get(radicand, radicand)}}}", True
    if function:
        if function in known and argument in known:
            return f"{known[function]}{primes}({known[argument]})", True
        called, inside = (f"${known[word]}$" if word in known else _signs(word) for word in (function, argument))
        return f"{called}{primes}({inside})", False
    if above:
        return f"{above}^{{+}}", True
    is_article = name in ("a", "A", "I") and _ARTICLE.match(match.string, match.end())
    if name in known and not is_article:
        return f"{known[name]}{f'^{{{power}}}' if power else ''}", True
    written = _signs(name or number or space or other)
    return written + (f"$^{{{power}}}$" if power else ""), False


def _signs(word: str) -> str:
    return "".join(map(_sign, word))


def _join_formulas(pieces: Sequence[tuple[str, bool]]) -> list[tuple[str, bool]]:
    """Make one formula of those with a relation or an operation between them, and of numbers behind these."""
    joined: list[tuple[str, bool]] = []
    left = list(pieces)
    while left:
        piece = left.pop(0)
        sign, skipped = _operation(left) if piece[1] else ("", 0)
        while sign and skipped < len(left) and _is_operand(left, skipped):
            gap = "" if sign == "/" else " "
            piece = (f"{piece[0]}{gap}{sign}{gap}{left[skipped][0]}", True)
            del left[: skipped + 1]
            while len(left) > 1 and left[0][0] == " " and left[1][1]:  # a product
                piece = (f"{piece[0]} {left[1][0]}", True)
                del left[:2]
            sign, skipped = _operation(left)
        joined.append(piece)
    return joined


def _operation(pieces: Sequence[tuple[str, bool]]) -> tuple[str, int]:
    """Return the sign with which pieces begin, and how many it takes with the spaces around it."""
    contents = [content for content, _ in pieces[:3]]
    spaced = contents[:1] == [" "]
    sign = contents[spaced] if len(contents) > spaced else ""
    known = next((latex for character, latex in _BETWEEN.items() if sign == _SIGNS.get(character, character)), "")
    behind = contents[1 + spaced : 2 + spaced] == [" "]
    if known and spaced == behind:
        return (known, 1 + spaced + behind)
    return ("", 0)


def _is_operand(pieces: Sequence[tuple[str, bool]], position: int) -> bool:
    """Whether a piece is a formula, or a number that is no part of a word or of a power."""
    content, is_formula = pieces[position]
    following = " "
    if position + 1 < len(pieces):
        following = pieces[position + 1][0]
    return is_formula or (content.replace(".", "").isdigit() and following in (" ", ",", ";", ".", ")"))


def _sign(character: str) -> str:
    """Return a character as LaTeX; Greek letters that look like Latin ones have no command."""
    if character in _SIGNS:
        return _SIGNS[character]
    greek = re.fullmatch(r"GREEK (SMALL|CAPITAL) LETTER (FINAL )?(\w+)", unicodedata.name(character, ""))
    written = "{"
    if greek:
        written = latex_name(greek[3].lower() if greek[1] == "SMALL" else greek[3].title())
    if "{" not in written:
        return f"${written}$"
    if _NOT_SET.match(character):
        raise InputError(
            f"the character {character!r} has no sign in pdflatex's fonts; "
            "write names, sources and meanings in Latin letters"
        )
    return character

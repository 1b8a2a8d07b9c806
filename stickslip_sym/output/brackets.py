r"""How tightly printed LaTeX holds together, and brackets around what would fall apart.

What stands in a product, over or under a slash, or behind a minus is judged by how it was printed, not by what
kind of expression it is: a power that became a quotient and a sum that is one factor alone need brackets all the
same.
"""

import re
from enum import IntEnum

__all__ = ["Binding", "binding", "bracketed", "held", "length"]

_TOKEN = re.compile(r"\\[A-Za-z]+|\\.|\s+|.", re.S)
_OPENING = frozenset({"{", "(", "[", r"\{", r"\left", r"\begin"})
_CLOSING = frozenset({"}", ")", "]", r"\}", r"\right", r"\end"})
_TALL = re.compile(r"\\frac|\\int|\\sum|\\left|\\bigg|\\begin")
_SHORT = 48  # characters that one pair of brackets holds in a line
_OPERATORS = (r"{\mathrm{d}", r"{\partial")  # what stands on the fraction of a derivative


class Binding(IntEnum):
    """What a text is read as, from the loosest to the tightest."""

    CASES = 0
    """A choice, whose brace on the left nothing closes on the right."""
    SUM = 1
    OPEN = 2
    """An integral or a derivative, whose end is where its term ends."""
    QUOTIENT = 3
    """With a slash: what follows would be taken for a part of the denominator."""
    PRODUCT = 4
    FACTOR = 5


_KINDS = {
    r"\begin": Binding.CASES, **dict.fromkeys("+-=<>,;", Binding.SUM), r"\int": Binding.OPEN,
    "/": Binding.QUOTIENT, r"\,": Binding.PRODUCT, r"\cdot": Binding.PRODUCT,
}  # fmt: skip


def binding(latex: str) -> Binding:
    """Return what a text is read as."""
    found, depth = Binding.FACTOR, 0
    for token in _TOKEN.finditer(latex):
        text = token[0]
        if depth == 0:
            found = min(found, _KINDS.get(text, Binding.FACTOR))
            if text.isspace():
                found = min(found, Binding.PRODUCT)
            elif text == r"\frac" and latex.startswith(_OPERATORS, token.end()):
                found = min(found, Binding.OPEN)
        depth += (text in _OPENING) - (text in _CLOSING)
    return found


def held(latex: str, least: Binding) -> str:
    """Return a text, in brackets if it holds together less tightly than is needed."""
    return bracketed(latex) if binding(latex) < least else latex


def length(latex: str) -> int:
    """Return about how many characters a formula shows."""
    return len(re.sub(r"\\(mathrm|operatorname|left|right|[bB]igg?[lr])|[{}_^ ]", "", latex))


def bracketed(inner: str) -> str:
    """Return a formula in brackets that differ from those inside, as high as it is."""
    opening, closing = (r"\{", r"\}") if "[" in inner else ("[", "]") if "(" in inner else ("(", ")")
    if _TALL.search(inner):
        # Lines may break between brackets of a given size, not between \left and \right.
        sizes = (r"\left", r"\right") if length(inner) < _SHORT else (r"\biggl", r"\biggr")
    elif opening != "(" or r"\sqrt" in inner:
        sizes = (r"\bigl", r"\bigr")
    else:
        sizes = ("", "")
    return f"{sizes[0]}{opening}{inner}{sizes[1]}{closing}"

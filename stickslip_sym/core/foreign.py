"""Text that others wrote, as names, sources, titles of columns: what steers a terminal is taken out of it."""

import re

_STEERING = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f"  # controls, such as those that begin a sequence of a terminal
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # marks that turn the direction of writing
    "\ud800-\udfff\ufffe\uffff]"  # halves of pairs, which nothing encodes, and no characters
)
_BREAKS = re.compile("[\t\n\r\u2028\u2029]")


def printable(text: str, *, lines: bool = False) -> str:
    """Return text with a replacement character for each that steers a terminal, or that no file can hold.

    - `lines`: whether it may have several, and tabs; otherwise it is one.
    """
    text = _STEERING.sub("\N{REPLACEMENT CHARACTER}", text)
    if lines:
        return text
    return _BREAKS.sub(" ", text)

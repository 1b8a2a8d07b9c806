"""Long files of plain numbers, read as a whole: every row as wide as the first, of digits and points alone.

Anything else, a comment, an empty cell, a comma as the decimal sign, a number that stands for none, is left to the
reading of cells, which says what it is. Numbers are those of the decimals, rounded once, as `float` reads them.
"""

import re
from io import BytesIO, TextIOWrapper

import numpy as np

from stickslip_sym.core.aliases import FloatArray

_PLAIN_BYTES = b"0123456789+-.eE\n"
_NEWLINE = ord("\n")
OVERFLOW = 1e30  # what instruments write in place of a value out of range is larger, like 9.9E37
_NINES = np.array([float(f"{'9' * whole}.{'9' * decimals}0") for whole in range(2, 16) for decimals in range(7)])


def plain_numbers(body: bytes, mark: str, count: int) -> FloatArray | None:
    """Return rows of numbers, `count` in each, parted by a mark; None where anything else is among them."""
    body = body.replace(b"\r\n", b"\n").rstrip(b"\n")
    parting = mark.encode()
    if parting == b"," and b", " in body:
        body = body.replace(b", ", b",")
    if not body or body.translate(None, _PLAIN_BYTES + parting):
        return None
    characters = np.frombuffer(body, np.uint8)
    breaks = np.flatnonzero((characters == _NEWLINE) | (characters == ord(mark)))
    if len(breaks) == 0 or breaks[0] == 0 or breaks[-1] == len(body) - 1 or (np.diff(breaks) == 1).any():
        return None
    ends = np.append(characters[breaks] == _NEWLINE, True)
    if len(ends) % count or (ends.reshape(-1, count) != ([False] * (count - 1) + [True])).any():
        return None
    del breaks, ends
    try:
        rows = np.loadtxt(TextIOWrapper(BytesIO(body), "ascii"), delimiter=mark, comments=None, ndmin=2)
    except ValueError:  # a cell that is no number
        return None
    if rows.shape[1] != count or not (np.abs(rows) < OVERFLOW).all():
        return None
    large = np.abs(rows[np.abs(rows) >= _NINES[0]])
    return None if np.isin(large, _NINES).any() else rows


def lines_before(head: str, number: int) -> int | None:
    """Return how many bytes stand above a line, by its number; None where lines end in other ways than usual."""
    if re.search(r"\r(?!\n)", head) or len(head.splitlines()) != head.count("\n"):
        return None
    return len("".join(head.splitlines(keepends=True)[: number - 1]).encode())

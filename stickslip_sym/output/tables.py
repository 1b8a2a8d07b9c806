"""Plain text tables, and lines of text, no wider than a page."""

import re
from collections.abc import Sequence

__all__ = ["WIDTH", "duration", "table", "wrapped"]

WIDTH = 115  # characters of a line
_GAP = "  "
# Where a line may end, the best place first, what stands there between its parts, and whether it is one only
# outside of brackets: never inside ** or a number.
_FACTOR = r"(?=/|\*(?!\*))"
_BREAKS = (
    (r"(?<=,) ", " ", True),
    (r" (?=[+-] )", " ", True),
    (rf"(?<=\)){_FACTOR}", "", True),
    (r"(?<![+-]) ", " ", False),
    (rf"(?<=[^*/ ]){_FACTOR}", "", False),
)
_WORDS = "|".join(place for place, *_ in _BREAKS)


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows of text under a header, in aligned columns with no trailing blanks.

    Where a row is wider than `WIDTH`, the widest columns go on in further lines. Only words that do not fit side
    by side make a wider line: nothing is cut off.
    """
    lines = [header, *rows]
    columns = list(zip(*lines, strict=True))
    widths = [max(map(len, column)) for column in columns]
    least = [max(len(word) for cell in column for word in re.split(_WORDS, cell)) for column in columns]
    while sum(widths) + len(_GAP) * (len(widths) - 1) > WIDTH:
        narrower = [place for place, width in enumerate(widths) if width > least[place]]
        if not narrower:
            break
        widths[max(narrower, key=lambda place: widths[place])] -= 1
    cells = [[wrapped(cell, width) for cell, width in zip(line, widths, strict=True)] for line in lines]
    return "\n".join(
        _GAP.join(
            (cell[row] if row < len(cell) else "").ljust(width) for cell, width in zip(line, widths, strict=True)
        ).rstrip()
        for line in cells
        for row in range(max(map(len, line)))
    )


def wrapped(text: str, width: int) -> list[str]:
    """Break a text at commas, else before terms and bracketed factors, else at spaces, else before factors.

    A line is longer than the width only where one word is.
    """
    lines = [""]
    _fill(lines, text, "", width, _BREAKS)
    return lines if lines[0] or len(lines) == 1 else lines[1:]


def _fill(lines: list[str], text: str, joint: str, width: int, breaks: Sequence[tuple[str, str, bool]]) -> None:
    """Go on with a text in the last line, and in new ones."""
    if len(lines[-1]) + len(joint) + len(text) <= width:
        lines[-1] += joint + text
    elif len(text) <= width or not breaks:
        lines.append(text)
    else:
        place, between, outside = breaks[0]
        start = 0
        for found in [*re.finditer(place, text), None]:
            before = text[: found.start() if found else None]
            if found and outside and before.count("(") > before.count(")"):
                continue
            _fill(lines, before[start:], joint, width, breaks[1:])
            joint, start = between, found.end() if found else 0


def duration(seconds: float) -> str:
    """Return a time in the unit that suits it, with two or three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"

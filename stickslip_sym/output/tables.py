"""Plain text tables, and lines of text, no wider than a page."""

import re
import sys
from collections.abc import Sequence

__all__ = ["WIDTH", "duration", "table", "wrapped"]

WIDTH = 115  # characters of a line
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


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows of text under a header, in aligned columns with no trailing blanks.

    It is no wider than the terminal, without one than `WIDTH`; longer cells go on below, and nothing is cut.
    """
    from rich.console import Console
    from rich.table import Table

    shown = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="")
    for name in header:
        shown.add_column(name, overflow="fold")
    for row in rows:
        shown.add_row(*row)
    console = Console(width=None if sys.stdout.isatty() else WIDTH, markup=False, emoji=False, highlight=False)
    with console.capture() as captured:
        console.print(shown)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())


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

"""Plain text tables, no wider than a page, durations and the time."""

import re
import shutil
import sys
from collections.abc import Sequence
from datetime import UTC, datetime
from textwrap import wrap

TERMINAL_WIDTH = 80  # characters of a line, where there is no terminal that is wider
SHOWN_CHARACTERS = 60  # of a longer text, which only says what it is
MOST_FORMULA_CHARACTERS = 4000  # of a formula on a screen; a longer one is left to files
_BLANKS_BETWEEN_COLUMNS = 2  # blanks between columns
_LONG_NUMBER = re.compile(r"-?\d+\.\d{30,}(?:e[-+]?\d+)?")
"""What is not broken, as it is copied as a whole."""
_ROW = re.compile(r"\S {2,}\S")
_EQUALS = "\0=\0"  # stands for " = " while lines are broken


def aligned_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return rows of text under a header, in aligned columns with no trailing blanks.

    It is no wider than the terminal, without one than `TERMINAL_WIDTH`, or than numbers of many digits ask for;
    longer cells go on below, and nothing is cut.
    """
    from rich.console import Console
    from rich.table import Table

    shown = Table(box=None, pad_edge=False, padding=(0, _BLANKS_BETWEEN_COLUMNS, 0, 0), header_style="")
    columns = [[name, *(row[place] for row in rows)] for place, name in enumerate(header)]
    numbers = [
        max((len(cell) for cell in column if _LONG_NUMBER.fullmatch(cell)), default=0) for column in columns
    ]
    for name, column, number in zip(header, columns, numbers, strict=True):
        shown.add_column(name, overflow="fold", no_wrap=0 < number == max(map(len, column)))
    for row in rows:
        shown.add_row(*row)
    if sys.stdout.isatty():
        width = None
    else:
        width = max(TERMINAL_WIDTH, TERMINAL_WIDTH // 2 + sum(numbers))  # half a line for all other columns
    # In Jupyter Rich would show a box of its own, and an empty one, as what is printed is kept.
    console = Console(width=width, markup=False, emoji=False, highlight=False, force_jupyter=False)
    with console.capture() as captured:
        console.print(shown)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())


def fitted(text: str) -> str:
    """Return text whose lines fit the terminal, without one `TERMINAL_WIDTH`: a longer one goes on below,
    indented.

    An equation of a name and a number stays together, and so does a long word; rows of tables fit already.
    """
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else TERMINAL_WIDTH
    lines = list[str]()
    for line in text.split("\n"):
        if _ROW.search(line):
            lines.append(line)
            continue
        indent = " " * (len(line) - len(line.lstrip()) + 2)
        joined = line.replace(" = ", _EQUALS)
        broken = wrap(joined, width, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
        lines += [part.replace(_EQUALS, " = ") for part in broken or [""]]
    return "\n".join(lines)


def duration(seconds: float) -> str:
    """Return a time in the unit that suits it, with two or three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def now() -> str:
    """Return the time as pages and studies have it."""
    return f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC"

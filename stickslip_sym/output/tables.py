"""Plain text tables, no wider than a page, and durations."""

import sys
from collections.abc import Sequence

WIDTH = 115  # characters of a line


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
    width = None if sys.stdout.isatty() else WIDTH
    # In Jupyter Rich would show a box of its own, and an empty one, as what is printed is kept.
    console = Console(width=width, markup=False, emoji=False, highlight=False, force_jupyter=False)
    with console.capture() as captured:
        console.print(shown)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())


def duration(seconds: float) -> str:
    """Return a time in the unit that suits it, with two or three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"

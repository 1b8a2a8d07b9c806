"""What the commands print: progress, and with ``--json`` one object, valid JSON, of a shape that stays.

    {"format": 3, "version": "0.3.0", "command": "damping", "operating_point": {"law": ..., ...}, ...}

Results are objects with the names of their attributes in Python, as `content` makes them. "format" grows when a
name goes or changes its meaning; names may be added without.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import click

from stickslip_sym.core.version import __version__

if TYPE_CHECKING:
    from rich.console import Console

    from stickslip_sym.cli.options import Given
    from stickslip_sym.cli.reading import Point

Json = dict[str, Any]
"""What stands for an object of JSON."""

_FORMAT = 3


def terminal() -> Console:
    """Return where progress is shown: on stderr if that is a terminal, and nowhere else."""
    from rich.console import Console

    # Rich takes FORCE_COLOR for a terminal, and would draw into a file.
    return Console(stderr=True, force_terminal=sys.stderr.isatty())


@contextmanager
def counted(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show on a terminal how many of something are done."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    columns = what, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*columns, console=terminal(), transient=True, disable=not sys.stderr.isatty()) as shown:
        task = shown.add_task("", total=None)
        yield lambda done, total: shown.update(task, completed=done, total=total)


@contextmanager
def under_way(what: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is computed, and since when; what is yielded takes another text."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn()
    with Progress(*columns, console=terminal(), transient=True) as shown:
        task = shown.add_task(what, total=None)
        yield lambda text: shown.update(task, description=text)


def echo_json(command: str, **found: object) -> None:
    """Print the object of a command; results in it become what `content` makes of them."""
    from stickslip_sym.output.content import content

    head = {"format": _FORMAT, "version": __version__, "command": command}
    click.echo(json.dumps(head | content(found), indent=2, ensure_ascii=False, allow_nan=False))


def echo_all(given: Given, found: Sequence[Json], texts: Iterable[str], many: str = "points") -> None:
    """Print what was found at one point, or of one file, or of several: as texts, or as JSON."""
    if not given["json"]:
        click.echo("\n\n".join(texts))
    else:
        echo_json(given.command, **found[0] if len(found) == 1 else {many: found})


def echo_found(given: Given, at: Point, text: object, **found: object) -> None:
    """Print a law, an operating point and what was found there."""
    echo_all(given, [{"operating_point": at} | found], [f"{at}\n\n{text}"])

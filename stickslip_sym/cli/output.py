"""What the commands print: progress, and with ``--json`` one object, valid JSON, of a shape that stays.

    {"format": 3, "version": "...", "command": "damping", "operating_point": {"law": ..., ...}, ...}

Results are objects with the names of their attributes in Python, as `content` makes them. "format" grows when a
name goes or changes its meaning; names may be added without. A call that fails prints, beside its line on stderr,

    {..., "error": {"type": "InputError", "message": "...", "exit_code": 2}}

whose type is the name of one of the package's errors.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import click

from stickslip_sym.core.aliases import Json
from stickslip_sym.core.progress import StepOfWork, report_every_step_to
from stickslip_sym.core.version import __version__
from stickslip_sym.output.tables import SHOWN_CHARACTERS

if TYPE_CHECKING:
    from stickslip_sym.cli.arguments import Point
    from stickslip_sym.cli.options import Given

PRINTED = "stickslip_sym: an object of JSON"
"""Marks a call that has printed one: an error that follows prints no second."""
_FORMAT = 3


@contextmanager
def show_progress(what: str) -> Iterator[None]:
    """Show on a terminal, and nowhere else, what is computed, how far that is, and since when."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    # Rich takes FORCE_COLOR for a terminal, and would draw into a file.
    console = Console(stderr=True, force_terminal=True)
    columns = SpinnerColumn(), TextColumn("{task.description}", markup=False), BarColumn(20), TimeElapsedColumn()
    with Progress(*columns, console=console, transient=True) as shown:
        task = shown.add_task(what, total=None)

        def show(path: tuple[StepOfWork, ...]) -> None:
            outermost = next((step for step in path if step.total > 1), StepOfWork("", 0, 0))
            description = ": ".join([what, *map(_progress_text, path)])
            shown.update(task, description=description, completed=outermost.done, total=outermost.total or None)

        with report_every_step_to(show):
            yield


def _progress_text(step: StepOfWork) -> str:
    if len(step.what) <= SHOWN_CHARACTERS:
        words = step.what
    else:
        words = f"{step.what[:SHOWN_CHARACTERS]}..."
    if step.total > 1:
        return f"{words} ({step.done} of {step.total})"
    return words


def say(text: str) -> None:
    """Print text whose lines fit the terminal."""
    from stickslip_sym.output.tables import fitted

    click.echo(fitted(text))


def echo_json(command: str, **found: object) -> None:
    """Print the object of a command; results in it become what `content` makes of them."""
    from stickslip_sym.output.content import content

    context = click.get_current_context(silent=True)
    if context is not None:
        context.find_root().meta[PRINTED] = True
    head = {"format": _FORMAT, "version": __version__, "command": command}
    click.echo(json.dumps(head | content(found), indent=2, ensure_ascii=False, allow_nan=False))


def echo_all(given: Given, found: Sequence[Json], texts: Iterable[str], many: str = "points") -> None:
    """Print what was found at one point, or of one file, or of several: as texts, or as JSON."""
    if not given["json"]:
        say("\n\n".join(texts))
    else:
        echo_json(given.command, **found[0] if len(found) == 1 else {many: found})


def echo_found(given: Given, at: Point, text: object, **found: object) -> None:
    """Print a law, an operating point and what was found there."""
    echo_all(given, [{"operating_point": at} | found], [f"{at}\n\n{text}"])

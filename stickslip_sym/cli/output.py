"""What the commands print: progress, and with ``--json`` one object, valid JSON, of a shape that stays.

    {"format": 2, "version": "0.3.0", "command": "damping", "law": ..., "operating_point": ..., ...}

Results are objects with the names of their attributes in Python, without what only pictures need. Numbers are in
SI units, and null where there is none; formulas are text, and so is a number as it was given. "format" grows when
a name goes or changes its meaning; names may be added without.
"""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from typing import TYPE_CHECKING, Any

import click

import stickslip_sym as ss
from stickslip_sym.cli.options import Given
from stickslip_sym.cli.reading import Point
from stickslip_sym.core import symbols
from stickslip_sym.core.uncertain import UFloat, separated
from stickslip_sym.core.version import __version__

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

Json = dict[str, Any]
"""What stands for an object of JSON."""

_FORMAT = 2
_ATTRIBUTES = {
    "Threshold": "value method relative_error status uncertainty nonlinearity budget deserved",
    "Budget": "deviations alone shares correlated",
    "Critical": "value unit method relative_error sensitivity",
    "Margin": "name value below above change",
    "Margins": "stick_slip threshold rows probability sampled refused",
    "ClosedForm": "expr verdict",
    "Trajectory": "motion change outcome note events",
    "MotionMap": "motion reason attractors",
    "Axis": "name unit values",
    "Trade": "point box rows dominators",
    "Study": "warnings headline verdict regime answers choice probability margins forms fit refused defaults "
    "seconds",
    "Regime": "attractors",
}
"""The attributes that are printed, by the names of classes; of other dataclasses all."""


_QUANTITIES = ("V", "N", "m", "k", "c")
_OPTIONS = (
    "method", "criterion", "workers", "time_limit", "rtol", "t_end", "x0", "v0", "static",
    "name", "source", "radius", "speeds",
)  # fmt: skip
_RULES: list[tuple[str, str | Callable[[re.Match[str]], str]]] = [
    (r"bind them first: law\.bind\(([^()]*)\)", r"give \1"),
    (r"(?:bind it first: )?\blaw\.bind\((\w+=[\w.]+)\)", r"-p \1"),
    (r"bind them first", "give each by -p NAME=VALUE"),
    (r"declare it with Parameter\('(\w+)', positive=False\) if any sign is meant",
     r"write the formula with -\1, and give a positive value, if any sign is meant"),
    (r"use evaluate\(digits=\.\.\.\)", "stickslip derive computes it to 50 digits"),
    (r"columns=\{'(\w+)': '?([^'}]*)'?, '(\w+)': '?([^'}]*)'?\}", r'--column \1="\2" --column \3="\4"'),
    (r"columns=\{'(\w+)': '?([^'}]*)'?\}", r'--column \1="\2"'),
    (r"\b(leave|keep)_(out|outliers)=True", r"--\1-\2"),
    (r"pass extrapolate=True", "give --extrapolate"),
    (r"extrapolate=True", "--extrapolate"),
    (r"\bsimulate\(\)", "stickslip simulate"),
    (r"within=\(low, high\)", "--within LOW:HIGH"),
    (r"units=\{'(\w+)': \.\.\.\}", r"--unit \1=..."),
    (rf"\b({'|'.join(_OPTIONS)})=(\"?)([\w.+-]+)\2", lambda m: f"--{m[1].replace('_', '-')} {m[3]}"),
    (rf"(?<![\w-])({'|'.join(_QUANTITIES)})=\.\.\.", r"-\1 ..."),
    (r"(?<!-p )(?<!--unit )(?<!--symbol )(?<![\w-])(\w+)=\.\.\.", r"-p \1=..."),
    (r"(=?\.\.\.), (?=-)", r"\1 "),
]  # fmt: skip
"""Python's words in a message, and those of the command line, replaced in this order."""


def in_options(message: str) -> str:
    """Return a message of the package as a user of the command line can follow it."""
    for python, option in _RULES:
        message = re.sub(python, option, message)
    return message


@contextmanager
def progress_bar(*columns: ProgressColumn | str) -> Iterator[Callable[..., None]]:
    """Show columns of rich on a terminal, and yield what updates them; elsewhere show nothing."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Rich takes FORCE_COLOR for a terminal, and would draw into a file.
    drawn = console.is_terminal and sys.stderr.isatty()
    with Progress(*columns, console=console, transient=True, disable=not drawn) as shown:
        yield partial(shown.update, shown.add_task("reading the law", total=None))


@contextmanager
def counted(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show on a terminal how many of something are done; elsewhere show nothing."""
    from rich.progress import BarColumn, MofNCompleteColumn, TimeRemainingColumn

    with progress_bar(what, BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()) as update:
        yield lambda done, total: update(completed=done, total=total)


def echo_json(command: str, **content: object) -> None:
    """Print the object of a command; results in it become what `as_json` makes of them."""
    head = {"format": _FORMAT, "version": __version__, "command": command}
    click.echo(json.dumps(head | as_json(content), indent=2, ensure_ascii=False, allow_nan=False))


def echo_all(given: Given, contents: Sequence[Json], texts: Iterable[str], many: Json | None = None) -> None:
    """Print what was found at one point, or at several: texts, or with ``--json`` contents, `many` if several."""
    if not given["json"]:
        click.echo("\n\n".join(texts))
    else:
        echo_json(given.command, **contents[0] if len(contents) == 1 else many or {"points": contents})


def echo_found(given: Given, at: Point, text: object, **content: object) -> None:
    """Print a law, an operating point and what was found there."""
    echo_all(given, [point_of(at) | content], [f"{at}\n\n{in_options(str(text))}"])


def as_json(value: Any) -> Any:
    """Return a result as JSON can hold it."""
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, str | Exception):
        return in_options(str(value))
    if isinstance(value, Mapping):
        return {str(key.value if isinstance(key, Enum) else key): as_json(one) for key, one in value.items()}
    if hasattr(value, "tolist"):  # an array, or a number of NumPy
        return as_json(value.tolist())
    if isinstance(value, list | tuple):
        return [as_json(one) for one in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    names = _ATTRIBUTES.get(type(value).__name__, "").split()
    if not names and not is_dataclass(value):
        from stickslip_sym.output import printing

        return printing.text(value) if hasattr(value, "free_symbols") else str(value)
    return {name: as_json(getattr(value, name)) for name in names or [one.name for one in fields(value)]}


def _error(errors: Mapping[str, UFloat], name: str) -> Json:
    return {"standard_error": float(errors[name].std_dev) if name in errors else None}


def point_of(point: Point) -> Json:
    """Return the law and the operating point with which every answer begins."""
    _, errors = separated(point.texts)
    quantities = {
        name: {
            "value": value, "unit": symbols.QUANTITIES[name].unit, "text": point.texts[name],
            "default": name in point.defaults, **_error(errors, name),
        }
        for name, value in point.numbers.items()
    }  # fmt: skip
    return {"law": law_of(point.law, point.typical), "operating_point": quantities}


def law_of(law: ss.FrictionLaw, typical: Sequence[str] = ()) -> Json:
    """Return a law: its name, its formula, and its parameters with their values, some of them typical ones."""
    parameters = {
        name: {
            "value": float(law.values[name]) if name in law.values else None,
            "text": str(law.values[name]) if name in law.values else None, **_error(law.uncertain, name),
            "default": name in typical, "typical": parameter.typical, "unit": parameter.unit,
            "meaning": parameter.meaning,
        }
        for name, parameter in law.parameters.items()
    }  # fmt: skip
    content = {"name": law.name, "formula": law.text, "static": as_json(law.static), "parameters": parameters}
    return content | {"validity": law.validity, "source": law.source}

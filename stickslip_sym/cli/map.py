"""``stickslip map``: the motions over a plane of two quantities."""

import contextlib
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, Overwrite, SceneOptions, file_option
from stickslip_sym.cli.shared.reading import check_size, progress_bar, read_numbers, require_new, require_writable
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.core.aliases import FloatArray
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.motion.maps.motions import MotionMap

__all__ = ["motion_map", "read_axis", "report"]

_AXIS = "NAME=START:STOP:COUNT"
_MOST_VALUES = 1_000_000
_WIDTH, _HEIGHT = 60, 20  # of the picture in text


def motion_map(
    x: Annotated[str, typer.Option("--x", metavar=_AXIS, help="Horizontal axis: V, c, N, m, k or a parameter.")],
    y: Annotated[str, typer.Option("--y", metavar=_AXIS, help="Vertical axis.")],
    law: LawOptions,
    scene: SceneOptions,
    c: Annotated[str | None, typer.Option("-c", metavar="KG/S", help="Damping, unless it is an axis.")] = None,
    plot: Annotated[Path | None, file_option("--plot", "Draw the map (PNG, SVG or PDF).")] = None,
    csv: Annotated[Path | None, file_option("--csv", "Write a line for each cell.")] = None,
    npz: Annotated[Path | None, file_option("--npz", "Write NumPy arrays.")] = None,
    workers: Annotated[int, typer.Option("--workers", metavar="N", help="Processes; -1 for all processors.")] = 1,
    checkpoint: Annotated[Path | None, file_option("--checkpoint", "Keep what is done; go on from it.")] = None,
    overwrite: Overwrite = False,
    time_limit: Annotated[
        str | None,
        typer.Option("--time-limit", metavar="S", help="Seconds; the cells that are left then are undecided."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Map the motions that exist, and the three thresholds, over a plane.

    Example: stickslip map exponential --x V=0.01:1:100 --y c=0:6:100 --plot map.png
    """
    from stickslip_sym.motion.maps.motions import motion_map as compute

    axes = read_axis("--x", x), read_axis("--y", y)
    names = [quantity for quantity, _ in axes]
    for name in law.values:
        if name in names:
            raise InputError(f"{name} is an axis, and given by -p too; leave one of the two out")
    bound = law.bound()
    given = scene.texts({name: text for name, text in PAPER.items() if name not in names})
    given |= {} if c is None else {"c": c}
    numbers = read_numbers(given)
    _warn_at_corners(bound, axes, numbers)
    require_new(csv, "--csv", overwrite)
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    require_writable(csv, npz, plot=plot)
    with _progress() as progress:
        found = compute(
            bound,
            x=axes[0],
            y=axes[1],
            **numbers,
            workers=workers,
            checkpoint=checkpoint,
            progress=progress,
            time_limit=limit,
        )
    if as_json:
        known = {"law": json_output.law(bound), "scene": json_output.values(given)}
        json_output.echo("map", **known, **_as_json(found))
    else:
        typer.echo(report(found))
    for write, path in ((found.to_csv, csv), (found.to_npz, npz), (found.plot, plot)):
        if path is not None:
            write(path)


def read_axis(option: str, text: str) -> "tuple[str, FloatArray]":
    """Read NAME=START:STOP:COUNT."""
    import numpy as np

    from stickslip_sym.core.numbers import exact

    name, equals, range_text = text.partition("=")
    parts = range_text.split(":")
    if not equals or len(parts) != 3:
        raise InputError(f"{option} {text[:60]!r} is not {_AXIS}; write for example {option} V=0.01:1:100")
    start, stop = exact(parts[0], f"the start of {name}"), exact(parts[1], f"the stop of {name}")
    for value in (start, stop):
        check_size(name, value)
    count = int(parts[2]) if parts[2].isdecimal() and len(parts[2]) <= 7 else 0
    if not 1 <= count <= _MOST_VALUES:
        raise InputError(f"{option}: the count {parts[2][:30]!r} is no whole number from 1 to {_MOST_VALUES}")
    if (start > stop) or (start == stop) != (count == 1):
        raise InputError(
            f"{option} {text[:60]!r}: the start must lie below the stop, or equal it with a count of 1"
        )
    return name.strip(), np.linspace(float(start), float(stop), count)


def _warn_at_corners(
    law: "FrictionLaw", axes: "tuple[tuple[str, FloatArray], ...]", scene: dict[str, float]
) -> None:
    """Warn of a negative coefficient at a corner of the plane; one warning is enough."""
    from stickslip_sym.model.doubts import warn_where_negative

    for corner in product(*([(name, ends[0]), (name, ends[-1])] for name, ends in axes)):
        here = {**scene, **dict(corner)}
        bound = law.bind(**{name: float(here[name]) for name in law.parameters if name in here})
        if not bound.missing and here["V"] > 0 and warn_where_negative(bound, float(here["V"])):
            return


def _as_json(found: "MotionMap") -> json_output.Json:
    """Return the axes, and motion, attractors and reason of each cell, in rows along the horizontal axis."""
    axes = {
        name: {"quantity": axis.name, "unit": axis.unit, "values": axis.values.tolist()}
        for name, axis in (("x", found.x), ("y", found.y))
    }
    attractors = {name: getattr(found, name).tolist() for name in ("stick_slip", "rest", "pure_slip")}
    cells = {"motion": found.motion, "reason": found.reason}
    in_words = {name: [[cell.value for cell in row] for row in array] for name, array in cells.items()}
    return axes | in_words | attractors


def report(found: "MotionMap") -> str:
    """Return a picture of the map in letters, and the number of cells of each kind."""
    import numpy as np

    from stickslip_sym.motion.maps.drawing import regions_of
    from stickslip_sym.output.tables import table

    place, kinds = regions_of(found)
    rows, columns = (
        np.linspace(0, size - 1, min(size, most)).round().astype(int)
        for size, most in zip(place.shape, (_HEIGHT, _WIDTH), strict=True)
    )
    picture = ["".join(kinds[place[row, column]].letter for column in columns) for row in rows[::-1]]
    edge = f"{found.y.name} = {found.y.values[0]:g} to {found.y.values[-1]:g} upwards"
    below = f"{found.x.name} = {found.x.values[0]:g} to {found.x.values[-1]:g} to the right"
    cells = place.size
    counts = [
        [kind.letter, kind.name, str(n), f"{100 * n / cells:.1f} %"]
        for i, kind in enumerate(kinds)
        if (n := int((place == i).sum()))
    ]
    reasons = [
        [reason.value, str(n)]
        for reason in dict.fromkeys(found.reason.ravel().tolist())
        if (n := int((found.reason == reason).sum()))
    ]
    parts = [
        "\n".join([*picture, f"{edge}, {below}"]),
        table(["", "attractors", "cells", ""], counts),
        table(
            ["from x = 0 with the belt's speed", "cells"], [[m.value, str(n)] for m, n in found.count().items()]
        ),
        table(["decided", "cells"], reasons),
    ]
    if found.notes:
        (row, column), text = next(iter(found.notes.items()))
        where = f"{found.x.name} = {found.x.values[column]:g}, {found.y.name} = {found.y.values[row]:g}"
        many = (
            f"{len(found.notes)} cells have a note; the first" if len(found.notes) > 1 else "one cell has a note"
        )
        parts.append(f"{many}, at {where}: {in_options(text)}")
    return "\n\n".join(parts)


@contextlib.contextmanager
def _progress() -> Iterator[Callable[[int, int], None]]:
    """Show on a terminal how much is done; elsewhere show nothing."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    columns = TextColumn("lines of cells"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with progress_bar(*columns) as update:
        yield lambda done, total: update(completed=done, total=total)

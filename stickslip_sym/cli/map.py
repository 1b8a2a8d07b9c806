"""``stickslip map``: the motions over a plane of two quantities."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, Any

import click

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import point
from stickslip_sym.cli.options import Given, option, read_number
from stickslip_sym.cli.output import echo_found, show_progress
from stickslip_sym.core.errors import InputError
from stickslip_sym.output.tables import aligned_table

if TYPE_CHECKING:
    from stickslip_sym.core.aliases import FloatArray
    from stickslip_sym.motion.maps.motions import MotionMap

_AXIS = "NAME=START:STOP:COUNT"
_HEIGHT = 20  # of the picture in text, of letters that are three times as many in a line


def read_axis_option(text: str, option: str, law: ss.FrictionLaw) -> tuple[str, FloatArray]:
    """Read NAME=START:STOP:COUNT, the ends in SI units or others."""
    import numpy as np

    from stickslip_sym.core.units import share_unit, si_number
    from stickslip_sym.motion.maps.results_over_axes import MOST_CELLS

    name = _axis_name(text)
    parts = text.partition("=")[2].split(":")
    equals = "=" in text
    if not equals or len(parts) != 3:
        raise InputError(f"{option} {text[:60]!r} is not {_AXIS}; write for example {option} V=0.01:1:100")
    ends = share_unit(parts[1], parts[0]), parts[1]
    start, stop = (
        read_number(si_number(end, name, options.unit_of_option(law, name)), f"the {which} of {name}")
        for which, end in zip(("start", "stop"), ends, strict=True)
    )
    count = 0
    if parts[2].isdecimal() and len(parts[2]) <= 7:
        count = int(parts[2])
    if not 1 <= count <= MOST_CELLS or start > stop or (start == stop) != (count == 1):
        raise InputError(
            f"{option} {text[:60]!r}: the start must lie below the stop, or equal it with a count of 1; and "
            f"the count must be a whole number from 1 to {MOST_CELLS}"
        )
    return name, np.linspace(start, stop, count)


def _axis_name(text: str) -> str:
    """Return the quantity of an axis."""
    return text.partition("=")[0].strip()


def _axis(name: str, text: str) -> click.Option:
    return option(name, metavar=_AXIS, required=True, help=text)


@options.command(
    options.AT,
    _axis("--x", "Horizontal axis: V, c, N, m, k or a parameter."),
    _axis("--y", "Vertical axis."),
    options.DAMPING,
    options.plot_option("Draw the map"),
    options.file_option("--csv", help="Write a line for each cell."),
    options.file_option("--npz", help="Write NumPy arrays."),
    option("--workers", metavar="N", type=int, default=1, help="Threads; -1 for all processors."),
    options.time_limit_option("Seconds; the cells that are left then are undecided."),
)  # fmt: skip
def run(given: Given) -> None:
    """Map the motions that exist, and the three thresholds, over a plane.

    Example: stickslip map exponential --x V=0.01:1:100 --y c=0:6:100 --plot map.png
    """
    names = _axis_name(given["x"]), _axis_name(given["y"])
    if twice := given["parameter"].keys() & set(names):
        raise InputError(f"{min(twice)} is an axis, and given by -p too; leave one of the two out")
    at = point(given, without=names).exact("map")
    x, y = (read_axis_option(given[side], f"--{side}", at.law) for side in "xy")
    how: dict[str, Any] = {name: given[name] for name in ("time_limit", "workers")} | at.numbers
    csv = given["csv"]
    npz = given["npz"]
    plot = given["plot"]
    given.reject_unused()
    _warn_at_corners(at.law, (x, y), at.numbers)
    with show_progress("map"):
        motions = ss.motion_map(at.law, x=x, y=y, **how)
    echo_found(given, at, report(motions), x=motions.x, y=motions.y, map=motions)
    if csv is not None:
        motions.to_csv(csv)
    if npz is not None:
        motions.to_npz(npz)
    if plot is not None:
        motions.plot(plot)
    if motions.interrupted:
        raise click.Abort


def _warn_at_corners(
    law: ss.FrictionLaw, axes: tuple[tuple[str, FloatArray], ...], point: dict[str, float]
) -> None:
    """Warn of a negative coefficient at a corner of the plane; one warning is enough."""
    from stickslip_sym.model.negative import warn_where_negative

    for corner in product(*([(name, ends[0]), (name, ends[-1])] for name, ends in axes)):
        here = {**point, **dict(corner)}
        bound = law.bind(**{name: float(here[name]) for name in law.parameters if name in here})
        if not bound.missing and here["V"] > 0 and warn_where_negative(bound.kinetic, float(here["V"])):
            return


def report(motions: MotionMap) -> str:
    """Return a picture of the map in letters, and the number of cells of each kind."""
    import numpy as np

    region, kinds = motions.regions()
    rows, columns = (
        np.linspace(0, size - 1, min(size, most)).round().astype(int)
        for size, most in zip(region.shape, (_HEIGHT, 3 * _HEIGHT), strict=True)
    )
    letters = np.array([kind.letter for kind in kinds])[region[np.ix_(rows[::-1], columns)]]
    x, y = (f"{axis.name} = {axis.values[0]:g} to {axis.values[-1]:g}" for axis in (motions.x, motions.y))
    reasons = motions.reason.ravel().tolist()
    tables = {
        ("", "attractors", "cells", ""): [
            [kind.letter, kind.name, str(n), f"{100 * n / region.size:.1f} %"]
            for kind, n in zip(kinds, np.bincount(region.ravel(), minlength=len(kinds)), strict=True)
        ],
        ("from x = 0 with the belt's speed", "cells"): [
            [motion.value, str(n)] for motion, n in motions.count().items()
        ],
        ("decided", "cells"): [[reason.value, str(reasons.count(reason))] for reason in dict.fromkeys(reasons)],
    }
    parts = [
        "\n".join([*map("".join, letters), f"{y} upwards, {x} to the right"]),
        *map(aligned_table, tables, tables.values()),
    ]
    if motions.note:
        parts.append(motions.note)
    if motions.notes:
        (row, column), text = next(iter(motions.notes.items()))
        where = f"{motions.x.name} = {motions.x.values[column]:g}, {motions.y.name} = {motions.y.values[row]:g}"
        many = f"{len(motions.notes)} cells have a note; the first"
        parts.append(f"{'one cell has a note' if len(motions.notes) == 1 else many}, at {where}: {text}")
    return "\n\n".join(parts)

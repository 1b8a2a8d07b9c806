"""``stickslip read``: what a file of measurements is understood as, before anything is computed."""

from __future__ import annotations

from pathlib import Path

import click

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import reading_of
from stickslip_sym.cli.options import Given
from stickslip_sym.cli.output import echo_all
from stickslip_sym.output import files


@options.command(
    click.Argument(["file"], type=Path, required=True, metavar="FILE"),
    options.FILE_OF_MEASUREMENTS,
    options.file_option("--csv", help="Write v in m/s, mu and sigma, rows in the order of the file."),
    options.plot_option("Draw the measurements"),
)
def run(given: Given) -> None:
    """Show how a file of measurements is read: its columns and units, what is assumed, its first rows.

    Example: stickslip read disc.csv --speeds 0.01:1 --csv clean.csv --plot disc.svg
    """
    csv = given["csv"]
    plot = given["plot"]
    measured = ss.read_measurements(given["file"], **reading_of(given))
    if csv is not None:
        rows = slice(None) if measured.order is None else measured.order.argsort()  # as swept: branches stay
        (_, speeds), *others = measured.columns.items()
        files.write_csv(csv, {"v [m/s]": speeds[rows]} | {name: column[rows] for name, column in others})
    if plot is not None:
        measured.plot(plot)
    echo_all(given, [{"measured": measured, "columns": measured.columns}], [measured.preview()])

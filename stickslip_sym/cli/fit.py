"""``stickslip fit``: laws fitted to measured friction, and ranked."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import law_described, reading_of
from stickslip_sym.cli.options import LAW_NAMES, Given, option, pairs
from stickslip_sym.cli.output import echo_all, show_progress
from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from stickslip_sym.model.fitting.result import Fits


@options.command(
    click.Argument(["files"], type=Path, nargs=-1, required=True, metavar="FILE..."),
    option("--law", multiple=True, help="A law, or a formula in v (every law of the catalogue).", **LAW_NAMES),
    pairs("--parameter", "-p", text="Fix a parameter.", example="-p alpha=3"),
    pairs("--unit", text="Unit of a formula's parameter.", example="--unit alpha=s/m", metavar="NAME=UNIT"),
    options.FILE_OF_MEASUREMENTS,
    options.plot_option("Draw the best fit of the one file"),
)  # fmt: skip
def run(given: Given) -> None:
    """Fit friction laws to measurements, and rank them.

    A FILE has columns of v and mu, or of v, F_t and F_n.

    Example: stickslip fit disc.csv --law exponential --law stribeck --law "a + b/(d + v)" --plot fit.svg
    """
    files = given["files"]
    plot = given["plot"] if len(given["files"]) == 1 else None
    laws = laws_to_fit(given["law"], given)
    contents = []
    texts = []
    for file in files:
        fits = fit_file(file, laws, given)
        contents.append({"file": file, "fits": fits})
        above = f"{file}:\n" if len(files) > 1 else ""
        texts.append(f"{above}{fits}\n\n{fits.best}")
        if plot is not None:
            fits.plot(plot)
    echo_all(given, contents, texts, "files")


def fit_file(file: Path, laws: Sequence[ss.FrictionLaw], given: Given) -> Fits:
    """Return the fits of laws to a file of measurements; all other options were read before."""
    reading = reading_of(given)
    given.reject_unused()
    with show_progress(f"reading {file.name}"):
        measured = ss.read_measurements(file, **reading)
    if given.command != "fit":  # whose answer begins with it
        click.echo(f"{measured.preview()}\n", err=True)
    with show_progress("fits"):
        return ss.fit(measured, laws=laws)


def laws_to_fit(texts: Sequence[str], given: Given) -> list[ss.FrictionLaw]:
    """Return the laws to fit, with the parameters that are fixed; all of the catalogue if none is named."""
    fixed = given["parameter"]
    laws = [law_described(given, text) for text in texts] or list(ss.laws.catalogue.values())
    for name in fixed:
        if not any(name in law.parameters for law in laws):
            raise InputError(f"no law that is fitted has a parameter {name!r}; leave -p {name}=... out")
    return [law.bind(**{name: text for name, text in fixed.items() if name in law.parameters}) for law in laws]

"""``stickslip fit``: laws fitted to measured friction, and ranked."""

from pathlib import Path
from typing import Any

import click

from stickslip_sym.cli.options import (
    FILE_OF_MEASUREMENTS,
    LAW_NAMES,
    Given,
    command,
    file_option,
    option,
)  # fmt: skip
from stickslip_sym.cli.output import counted, echo_all
from stickslip_sym.cli.reading import assignments, measurements
from stickslip_sym.cli.words import in_options
from stickslip_sym.core.errors import InputError

__all__ = ["laws_to_fit"]


@command(
    "fit",
    click.Argument(["files"], type=Path, nargs=-1, required=True, metavar="FILE..."),
    option("--law", multiple=True, help="A law, or a formula in v (every law of the catalogue).", **LAW_NAMES),
    option("--parameter", "-p", metavar="NAME=VALUE", multiple=True, help="Fix a parameter."),
    option("--unit", metavar="NAME=UNIT", multiple=True, help="Unit of a formula's parameter."),
    FILE_OF_MEASUREMENTS,
    option("--profile", is_flag=True, help="Intervals of the best law from the sum of squares itself."),
    file_option("--plot", "Draw the best fit of the one file (SVG, PNG or PDF).", draws=True),
)  # fmt: skip
def run(given: Given) -> None:
    """Fit friction laws to measurements, and rank them.

    A FILE has columns of v and mu, or of v, F_t and F_n.

    Example: stickslip fit disc.csv --law exponential --law stribeck --law "a + b/(d + v)" --plot fit.svg
    """
    from stickslip_sym.model.fitting.fit import fit

    files, profile = given["files"], given["profile"]
    laws = laws_to_fit(given["law"], assignments(given["parameter"]), given)
    plot = given["plot"] if len(files) == 1 else None
    contents = []
    for position, file in enumerate(files):
        measured = measurements(given.__getitem__, file)
        given.all_used()
        with counted("laws") as progress:
            fits = fit(measured, laws=laws, progress=progress)
        intervals = fits.best.confidence(profile=True) if profile else {}
        if given["json"]:
            contents.append(fits.content() | ({"profile_95": intervals} if intervals else {}))
            continue
        lines = [*(["" if position else None, f"{file}:"] if len(files) > 1 else [])]
        lines += [in_options(str(fits)), "", in_options(str(fits.best))]
        if intervals:
            lines += ["", "95 % intervals from the sum of squares"]
            lines += [f"  {name}: {low:.4g} to {high:.4g}" for name, (low, high) in intervals.items()]
        click.echo("\n".join(line for line in lines if line is not None))
        if plot is not None:
            fits.plot(plot)
    if given["json"]:
        echo_all("fit", contents, files)


def laws_to_fit(texts: tuple[str, ...], fixed: dict[str, str], given: Given) -> list[Any]:
    """Return the laws to fit, with the parameters that are fixed; all of the catalogue if none is named."""
    from stickslip_sym.model.expression.parsing import NAME
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.laws import laws as catalogue

    units = {} if all(map(NAME.fullmatch, texts)) else assignments(given["unit"], "--unit alpha=s/m")
    laws = [catalogue.find(text) if NAME.fullmatch(text) else FrictionLaw(text, units=units) for text in texts]
    laws = laws or list(catalogue.values())
    for name in fixed:
        if not any(name in law.parameters for law in laws):
            raise InputError(f"no law that is fitted has a parameter {name!r}; leave -p {name}=... out")
    return [law.bind(**{name: text for name, text in fixed.items() if name in law.parameters}) for law in laws]

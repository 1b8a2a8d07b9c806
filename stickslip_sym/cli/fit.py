"""``stickslip fit``: laws fitted to measured friction, and ranked."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.completion import complete_law
from stickslip_sym.cli.shared.options import AsJson
from stickslip_sym.cli.shared.reading import assignments, progress_bar, require_writable
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import InputError

__all__ = ["fit", "laws_to_fit", "progress_of_laws"]


def fit(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Measured friction: v and mu, or v, F_t and F_n, in columns.")
    ],
    laws: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[LAW]...",
            help="Names of laws, or formulas in v; without, every law of the catalogue.",
            autocompletion=complete_law,
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Fix a parameter; may be repeated."),
    ] = None,
    unit: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="NAME=UNIT", help="Unit of a formula's parameter; may be repeated."),
    ] = None,
    profile: Annotated[
        bool, typer.Option("--profile", help="Intervals of the best law from the sum of squares itself.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the best fit (SVG, PNG or PDF).")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Fit friction laws to measurements, and rank them.

    Example: stickslip fit disc.csv exponential stribeck "a + b/(d + v)" --plot fit.svg
    """
    from stickslip_sym.model.fit import fit as compute
    from stickslip_sym.model.measured.measurements import read_measurements

    chosen = laws_to_fit(laws or [], assignments(parameter or []), assignments(unit or [], "--unit alpha=s/m"))
    require_writable(plot=plot)
    measured = read_measurements(file)
    with progress_of_laws() as progress:
        found = compute(measured, laws=chosen, progress=progress)
    best = found.best
    intervals = best.confidence(profile=True) if profile else None
    if as_json:
        content = _in_options(found.content())
        if intervals is not None:
            sides = {name: [json_output.number(side) for side in ends] for name, ends in intervals.items()}
            content["profile_95"] = sides
        json_output.echo("fit", **content)
    else:
        typer.echo(in_options(str(found)))
        typer.echo(f"\n{in_options(str(best))}")
        if intervals is not None:
            lines = [f"  {name}: {low:.4g} to {high:.4g}" for name, (low, high) in intervals.items()]
            typer.echo("\n".join(["\n95 % intervals from the sum of squares", *lines]))
    if plot is not None:
        found.plot(plot)


def laws_to_fit(texts: list[str], fixed: dict[str, str], units: dict[str, str]) -> list[Any]:
    """Return the laws to fit, with the parameters that are fixed; all of the catalogue if none is named."""
    from stickslip_sym.model.expression.parsing import NAME
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.laws import catalogue, find

    laws: list[Any] = [find(text) if NAME.fullmatch(text) else FrictionLaw(text, units=units) for text in texts]
    if units and all(map(NAME.fullmatch, texts)):
        raise InputError("--unit belongs to the parameters of a formula; there is none")
    laws = laws or list(catalogue.values())
    for name in fixed:
        if not any(name in law.parameters for law in laws):
            raise InputError(f"no law that is fitted has a parameter {name!r}; leave -p {name}=... out")
    return [law.bind(**{name: text for name, text in fixed.items() if name in law.parameters}) for law in laws]


def _in_options(content: Any) -> Any:
    """Return nested content with its sentences in the words of the command line."""
    if isinstance(content, dict):
        return {key: _in_options(value) for key, value in content.items()}
    if isinstance(content, list):
        return [_in_options(value) for value in content]
    return in_options(content) if isinstance(content, str) else content


@contextlib.contextmanager
def progress_of_laws() -> Iterator[Callable[[int, int], None]]:
    """Show on a terminal how many laws are done; elsewhere show nothing."""
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    with progress_bar(TextColumn("laws"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()) as update:
        yield lambda done, total: update(completed=done, total=total)

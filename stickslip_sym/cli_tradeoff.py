"""``stickslip tradeoff``: what each way to a number costs, and how far it is off."""

from pathlib import Path
from typing import Annotated

import typer

from stickslip_sym.cli_reading import assignments, read_law

__all__ = ["tradeoff"]


def tradeoff(
    law: Annotated[str, typer.Argument(metavar="LAW", help="Name of a law, or a formula in v.")] = "exponential",
    criterion: Annotated[str, typer.Option("--criterion", metavar="NAME")] = "least_squares",
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Value of a parameter; may be repeated."),
    ] = None,
    speed: Annotated[str, typer.Option("-V", metavar="M/S", help="Belt speed.")] = "0.05",
    force: Annotated[str, typer.Option("-N", metavar="N", help="Normal force.")] = "9.81",
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error against time (SVG, PNG or PDF).")
    ] = None,
) -> None:
    """Measure what each way to the number costs, and how far it is off.

    Example: stickslip tradeoff exponential -V 0.01 --plot trade.svg
    """
    from stickslip_sym import tradeoff as measured
    from stickslip_sym.closed_form import derive as derive_form

    form = derive_form(read_law(law, None, extrapolate=False).typical(**assignments(parameter or [])), criterion)
    ways = measured.tradeoff(form, {"V": speed, "N": force})
    typer.echo(f"{form!r}, V = {speed} m/s, N = {force} N\n\n{measured.report(ways)}")
    if plot is not None:
        measured.plot(ways, plot, f"{form.law.name or law}, {form.criterion.name}, V = {speed} m/s")

"""``stickslip tradeoff``: what each way to a number costs, and how far it is off."""

from pathlib import Path
from typing import Annotated

import typer

from stickslip_sym.cli_reading import LawName, Values, assignments, read_law

__all__ = ["tradeoff"]


def tradeoff(
    law: LawName = "exponential",
    criterion: Annotated[str, typer.Option("--criterion", metavar="NAME")] = "least_squares",
    parameter: Values = None,
    speed: Annotated[str, typer.Option("-V", metavar="M/S", help="Belt speed.")] = "0.05",
    force: Annotated[str, typer.Option("-N", metavar="N", help="Normal force.")] = "9.81",
    thresholds: Annotated[
        bool, typer.Option("--thresholds", help="The ways to the threshold instead: the ladder, and Newmark.")
    ] = False,
    mass: Annotated[str, typer.Option("-m", metavar="KG", help="Mass, for --thresholds.")] = "1",
    stiffness: Annotated[str, typer.Option("-k", metavar="N/M", help="Stiffness, for --thresholds.")] = "100",
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error against time (SVG, PNG or PDF).")
    ] = None,
) -> None:
    """Measure what each way to the number costs, and how far it is off.

    Example: stickslip tradeoff exponential -V 0.01 --plot trade.svg
    """
    from stickslip_sym import tradeoff as measured
    from stickslip_sym.closed_form import derive as derive_form

    bound = read_law(law, None, extrapolate=False).typical(**assignments(parameter or []))
    if thresholds:
        from stickslip_sym import tradeoff_thresholds
        from stickslip_sym.values import exact

        given = {"V": speed, "N": force, "m": mass, "k": stiffness}
        ways = tradeoff_thresholds.threshold_tradeoff(
            bound, {name: float(exact(value, name)) for name, value in given.items()}
        )
        scene = ", ".join(f"{name} = {value}" for name, value in given.items())
        typer.echo(f"thresholds of {bound.name or law}, {scene}\n\n{tradeoff_thresholds.threshold_report(ways)}")
        if plot is not None:
            measured.plot(ways, plot, f"thresholds of {bound.name or law}, {scene}")
        return
    form = derive_form(bound, criterion)
    ways = measured.tradeoff(form, {"V": speed, "N": force})
    typer.echo(f"{form!r}, V = {speed} m/s, N = {force} N\n\n{measured.report(ways)}")
    if plot is not None:
        measured.plot(ways, plot, f"{form.law.name or law}, {form.criterion.name}, V = {speed} m/s")

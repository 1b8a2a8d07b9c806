"""``stickslip tradeoff``: what each way to a number costs, and how far it is off."""

from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.cli import json_output
from stickslip_sym.cli.law import Extrapolate, FromCsv, LawName, Name, Source, Static, Units, read_law
from stickslip_sym.cli.reading import (
    CriterionName,
    Values,
    assignments,
    read_exact,
    read_numbers,
    require_writable,
)
from stickslip_sym.model.operating_point import PAPER

__all__ = ["tradeoff"]


def tradeoff(
    law: LawName = None,
    criterion: CriterionName = "least_squares",
    from_csv: FromCsv = None,
    extrapolate: Extrapolate = False,
    static: Static = None,
    name: Name = None,
    unit: Units = None,
    source: Source = None,
    parameter: Values = None,
    speed: Annotated[str, typer.Option("-V", metavar="M/S", help="Belt speed.")] = "0.05",
    force: Annotated[str, typer.Option("-N", metavar="N", help="Normal force.")] = PAPER["N"],
    thresholds: Annotated[
        bool, typer.Option("--thresholds", help="The ways to the threshold instead: the ladder, and Newmark.")
    ] = False,
    mass: Annotated[str, typer.Option("-m", metavar="KG", help="Mass, for --thresholds.")] = PAPER["m"],
    stiffness: Annotated[str, typer.Option("-k", metavar="N/M", help="Stiffness, for --thresholds.")] = PAPER["k"],
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error against time (SVG, PNG or PDF).")
    ] = None,
    time_limit: Annotated[
        str, typer.Option("--time-limit", metavar="S", help="Seconds; ways that are left then have no number.")
    ] = "600",
    as_json: json_output.AsJson = False,
) -> None:
    """Measure what each way to the number costs, and how far it is off.

    Example: stickslip tradeoff exponential -V 0.01 --plot trade.svg
    """
    from stickslip_sym.comparison import threshold_tradeoff
    from stickslip_sym.comparison import tradeoff as measured
    from stickslip_sym.formula.derivation.closed_form import derive as derive_form
    from stickslip_sym.model.doubts import warn_where_negative

    law = law if law or from_csv else "exponential"
    friction = read_law(law, from_csv, extrapolate=extrapolate, static=static, name=name, unit=unit, source=source)
    bound = friction.typical(**assignments(parameter or []))
    given = {"V": speed, "N": force} | ({"m": mass, "k": stiffness} if thresholds else {})
    numbers = read_exact(given)
    limit = read_numbers({"time_limit": time_limit})["time_limit"]
    require_writable(plot=plot)
    if not bound.missing:
        warn_where_negative(bound, float(numbers["V"]))
    if thresholds:
        scene = {name: float(value) for name, value in numbers.items()}
        ways = threshold_tradeoff.threshold_tradeoff(bound, scene, time_limit=limit)
        title = f"thresholds of {bound.name or law}, {', '.join(f'{n} = {text}' for n, text in given.items())}"
        text = f"{title}\n\n{threshold_tradeoff.threshold_report(ways)}"
    else:
        form = derive_form(bound, criterion)
        ways = measured.tradeoff(form, given, time_limit=limit)
        title = f"{form.law.name or law}, {form.criterion.name}, V = {speed} m/s"
        text = f"{form!r}, V = {speed} m/s, N = {force} N\n\n{measured.report(ways)}"
    if as_json:
        what = {"thresholds": True} if thresholds else {"criterion": criterion}
        json_output.echo(
            "tradeoff",
            law=json_output.law(bound),
            scene=json_output.values(given),
            **what,
            ways=[*map(_way, ways)],
        )
    else:
        typer.echo(text)
    if plot is not None:
        measured.plot(ways, plot, title)


def _way(way: Any) -> dict[str, Any]:
    return {
        "way": way.name,
        "seconds": json_output.number(way.seconds),
        "relative_error": json_output.number(way.error),
        "largest_relative_error": json_output.number(way.largest),
        **({"status": way.status} if way.status else {}),
    }

"""``stickslip tradeoff``: what each way to a number costs, and how far it is off."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import LOW_SPEED, AsJson, CriterionName, LowSpeedScene, file_option
from stickslip_sym.cli.shared.reading import read_exact, read_numbers, require_writable
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.comparison.tradeoff import Way

__all__ = ["as_json_of", "tradeoff"]


def tradeoff(
    law: LawOptions,
    scene: LowSpeedScene,
    criterion: CriterionName = "least_squares",
    thresholds: Annotated[
        bool, typer.Option("--thresholds", help="The ways to the threshold instead: the ladder, and Newmark.")
    ] = False,
    plot: Annotated[Path | None, file_option("--plot", "Draw error against time (SVG, PNG or PDF).")] = None,
    time_limit: Annotated[
        str, typer.Option("--time-limit", metavar="S", help="Seconds; ways that are left then have no number.")
    ] = "600",
    as_json: AsJson = False,
) -> None:
    """Measure what each way to the number costs, and how far it is off.

    Example: stickslip tradeoff exponential -V 0.01 --plot trade.svg
    """
    from stickslip_sym.comparison import threshold_tradeoff
    from stickslip_sym.comparison import tradeoff as measured
    from stickslip_sym.formula.derivation.closed_form import derive as derive_form
    from stickslip_sym.model.doubts import warn_where_negative

    bound = (law if law.law or law.from_csv else replace(law, law="exponential")).bound()
    given = scene.texts(PAPER | {"V": LOW_SPEED})
    given = {name: given[name] for name in ("VNmk" if thresholds else "VN")}
    numbers = read_exact(given)
    limit = read_numbers({"time_limit": time_limit})["time_limit"]
    require_writable(plot=plot)
    if not bound.missing:
        warn_where_negative(bound, float(numbers["V"]))
    if thresholds:
        floats = {name: float(value) for name, value in numbers.items()}
        ways = threshold_tradeoff.threshold_tradeoff(bound, floats, time_limit=limit)
        title = f"thresholds of {bound.name or law.law}, {', '.join(f'{n} = {text}' for n, text in given.items())}"
        text = f"{title}\n\n{threshold_tradeoff.threshold_report(ways)}"
    else:
        form = derive_form(bound, criterion)
        ways = measured.tradeoff(form, given, time_limit=limit)
        title = f"{form.law.name or law.law}, {form.criterion.name}, V = {given['V']} m/s"
        text = f"{form!r}, V = {given['V']} m/s, N = {given['N']} N\n\n{measured.report(ways)}"
    if as_json:
        what = {"thresholds": True} if thresholds else {"criterion": criterion}
        json_output.echo(
            "tradeoff",
            law=json_output.law(bound),
            scene=json_output.values(given),
            **what,
            ways=[*map(as_json_of, ways)],
        )
    else:
        typer.echo(text)
    if plot is not None:
        measured.plot(ways, plot, title)


def as_json_of(way: "Way") -> json_output.Json:
    """Return a way as JSON has it."""
    return {
        "way": way.name,
        "seconds": json_output.number(way.seconds),
        "relative_error": json_output.number(way.error),
        "largest_relative_error": json_output.number(way.largest),
        **({"status": way.status} if way.status else {}),
    }

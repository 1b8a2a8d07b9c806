"""``stickslip tradeoff``: what each way to a number costs, and how far it is off."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, CriterionName, LowSpeedScene, file_option
from stickslip_sym.cli.shared.reading import read_exact, read_numbers, require_writable
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER

if TYPE_CHECKING:
    from stickslip_sym.comparison.ways import Trade, Way

__all__ = ["as_json_of", "tradeoff"]

_ENDS = "FROM:TO"


def tradeoff(
    law: LawOptions,
    scene: LowSpeedScene,
    criterion: CriterionName = "least_squares",
    thresholds: Annotated[
        bool, typer.Option("--thresholds", help="The ways to the threshold instead: the ladder, Newmark, SciPy.")
    ] = False,
    basins: Annotated[
        bool, typer.Option("--basins", help="The ways to the share of starts that come to rest instead.")
    ] = False,
    everything: Annotated[bool, typer.Option("--all", help="All three, in one run.")] = False,
    c: Annotated[
        str | None, typer.Option("-c", metavar="KG/S", help="Damping, for basins (amid the two thresholds).")
    ] = None,
    x0: Annotated[str | None, typer.Option("--x0", metavar=_ENDS, help="Displacements of starts, in m.")] = None,
    v0: Annotated[str | None, typer.Option("--v0", metavar=_ENDS, help="Velocities of starts, in m/s.")] = None,
    plot: Annotated[Path | None, file_option("--plot", "Draw error against time (SVG, PNG or PDF).")] = None,
    time_limit: Annotated[
        str, typer.Option("--time-limit", metavar="S", help="Seconds; ways that are left then have no number.")
    ] = "600",
    as_json: AsJson = False,
) -> None:
    """Measure what each way to the number costs, how far it is off, and which other way dominates it.

    Example: stickslip tradeoff exponential --all --plot trade.svg
    """
    from stickslip_sym.comparison.tradeoff import KINDS
    from stickslip_sym.comparison.tradeoff import tradeoff as measured
    from stickslip_sym.model.doubts import warn_where_negative

    bound = (law if law.law or law.from_csv else replace(law, law="exponential")).bound()
    wanted = (not (thresholds or basins), thresholds, basins)
    kinds = [kind for kind, asked in zip(KINDS, wanted, strict=True) if asked or everything]
    given = {**scene.texts({}), **({} if c is None else {"c": c})}
    if given.keys() & {"c"} and "basin" not in kinds:
        raise InputError("-c is the damping of basins; add --basins or --all")
    numbers = read_exact(given)
    limit = read_numbers({"time_limit": time_limit})["time_limit"]
    require_writable(plot=plot)
    if not bound.missing:
        default = LOW_SPEED if kinds == ["criterion"] else PAPER["V"]
        warn_where_negative(bound, float(numbers.get("V", float(default))))
    ends = None if x0 is None else _ends("x0", x0), None if v0 is None else _ends("v0", v0)
    found = measured(bound, of=kinds, criterion=criterion, x0=ends[0], v0=ends[1], time_limit=limit, **given)
    if as_json:
        parts = {kind: _content(kind, trade, given, criterion) for kind, trade in found.trades.items()}
        none = {kind: {"reason": reason} for kind, reason in found.refused.items()}
        whole = parts[kinds[0]] if len(kinds) == 1 else {"trades": parts | none}
        json_output.echo("tradeoff", law=json_output.law(bound), **whole)
    else:
        typer.echo(str(found))
    if plot is not None:
        found.plot(plot)


def _ends(name: str, text: str) -> tuple[float, float]:
    low, colon, high = text.partition(":")
    if not colon:
        raise InputError(f"--{name} is {_ENDS}, such as --{name} -0.1:0.1, got {text[:60]!r}")
    ends = read_numbers({f"--{name}": low}), read_numbers({f"--{name}": high})
    return ends[0][f"--{name}"], ends[1][f"--{name}"]


def _content(kind: str, trade: "Trade[Any]", given: Mapping[str, str], criterion: str) -> json_output.Json:
    """Return what JSON has of one kind."""
    texts = {name: given.get(name, f"{value!r}") for name, value in trade.scene.items()}
    what: json_output.Json = {"criterion": criterion} if kind == "criterion" else {f"{kind}s": True}
    box = {name: list(map(json_output.number, ends)) for name, ends in trade.box.items()}
    by = trade.dominators
    ways = [as_json_of(way, by[way.name]) for way in trade.ways]
    return {"scene": json_output.values(texts), **box, **what, "ways": ways}


def as_json_of(way: "Way", dominated_by: tuple[str, ...] = ()) -> json_output.Json:
    """Return a way as JSON has it."""
    facts = asdict(way)
    found: json_output.Json = {
        "way": facts.pop("name"),
        "seconds": json_output.number(facts.pop("seconds")),
        "relative_error": json_output.number(facts.pop("error")),
        "largest_relative_error": json_output.number(facts.pop("largest", None)),
    }
    further = {name: json_output.number(fact) if isinstance(fact, float) else fact for name, fact in facts.items()}
    return found | {name: fact for name, fact in further.items() if fact != ""} | {"dominated_by": [*dominated_by]}

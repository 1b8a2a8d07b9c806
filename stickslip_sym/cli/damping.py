"""``stickslip damping``: the threshold to a tolerance, or every rung of the ladder."""

from typing import Annotated, Any

import typer

from stickslip_sym.cli import json_output
from stickslip_sym.cli.completion import complete_method
from stickslip_sym.cli.law import Extrapolate, FromCsv, LawName, Name, Source, Static, Units, read_law
from stickslip_sym.cli.reading import Values, assignments, read_numbers
from stickslip_sym.cli.words import in_options
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.operating_point import PAPER

__all__ = ["damping"]


def damping(
    law: LawName = None,
    from_csv: FromCsv = None,
    extrapolate: Extrapolate = False,
    static: Static = None,
    name: Name = None,
    unit: Units = None,
    source: Source = None,
    parameter: Values = None,
    speed: Annotated[str, typer.Option("-V", metavar="M/S", help="Belt speed.")] = PAPER["V"],
    force: Annotated[str, typer.Option("-N", metavar="N", help="Normal force.")] = PAPER["N"],
    mass: Annotated[str | None, typer.Option("-m", metavar="KG", help="Mass; goes with -k.")] = None,
    stiffness: Annotated[str | None, typer.Option("-k", metavar="N/M", help="Stiffness; goes with -m.")] = None,
    method: Annotated[
        str,
        typer.Option(
            "--method", metavar="NAME", help="A rung of the ladder, or auto.", autocompletion=complete_method
        ),
    ] = "auto",
    rtol: Annotated[float, typer.Option("--rtol", help="Relative error that is good enough.")] = 1e-3,
    everything: Annotated[bool, typer.Option("--all", help="Print every rung of the ladder.")] = False,
    time_limit: Annotated[
        str | None, typer.Option("--time-limit", metavar="S", help="Seconds of computation, for each method.")
    ] = None,
    as_json: json_output.AsJson = False,
) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    from stickslip_sym.core.uncertain import nominal_text
    from stickslip_sym.motion.thresholds.rungs import rungs
    from stickslip_sym.output.tables import duration, table

    friction = read_law(law, from_csv, extrapolate=extrapolate, static=static, name=name, unit=unit, source=source)
    bound = friction.typical(**assignments(parameter or []))
    options = {"V": speed, "N": force, "m": mass, "k": stiffness}
    given = {name: text for name, text in options.items() if text is not None}
    read_numbers({name: nominal_text(text, name) for name, text in given.items()})  # refuses what is no number
    scene = given
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    if everything:
        usable = [name for name, rung in rungs().items() if "m" in scene or not rung.oscillator]
        found = {name: _threshold(bound, scene, name, min(rtol, 1e-10), limit) for name in usable}
    else:
        found = {method: _threshold(bound, scene, method, rtol, limit)}
        if isinstance(error := found[method][0], StickSlipError):
            raise error
    if as_json:
        thresholds = [_as_json(method, *result) for method, result in found.items()]
        json_output.echo(
            "damping", law=json_output.law(bound), scene=json_output.values(given), thresholds=thresholds
        )
    elif everything:
        rows = [
            [method, f"none: {in_options(str(threshold))}", "", "", ""]
            if isinstance(threshold, StickSlipError)
            else [
                method,
                f"{threshold.value:.12g}",
                "unknown" if threshold.error is None else f"{threshold.error:.1e}",
                threshold.status,
                duration(seconds),
            ]
            for method, (threshold, seconds) in found.items()
        ]
        typer.echo(table(["method", "c in kg/s", "relative error", "status", "time"], rows))
    else:
        threshold = found[method][0]
        typer.echo(str(threshold if threshold.theorem is None else f"{threshold}\n\n{threshold.theorem}"))


def _threshold(
    law: Any, scene: dict[str, Any], method: str, rtol: float, limit: float | None
) -> tuple[Any, float]:
    """Return a threshold, or the error that says why there is none, and the seconds it took."""
    import time

    from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

    begin = time.perf_counter()
    try:
        found: Any = pure_slip_damping(law, **scene, method=method, rtol=rtol, time_limit=limit)
    except StickSlipError as error:
        found = error
    return found, time.perf_counter() - begin


def _as_json(method: str, threshold: Any, seconds: float) -> dict[str, Any]:
    if isinstance(threshold, StickSlipError):
        return {"method": method, "c": json_output.missing("kg/s", in_options(str(threshold)))}
    return {
        "method": threshold.method,
        "c": json_output.quantity(threshold.value, "kg/s"),
        "relative_error": json_output.number(threshold.error),
        "status": threshold.status,
        "seconds": seconds,
    }

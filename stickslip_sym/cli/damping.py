"""``stickslip damping``: the threshold to a tolerance, or every rung of the ladder."""

from typing import TYPE_CHECKING, Annotated, Union

import typer

from stickslip_sym.cli import json_output
from stickslip_sym.cli.completion import complete_method
from stickslip_sym.cli.law import LawOptions
from stickslip_sym.cli.options import AsJson, MaybeOscillator
from stickslip_sym.cli.reading import read_numbers
from stickslip_sym.cli.words import in_options
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.motion.thresholds.threshold import Threshold

__all__ = ["damping"]

Found = Union["Threshold", StickSlipError]  # a text has no |
"""A threshold, or why there is none."""


def damping(
    law: LawOptions,
    scene: MaybeOscillator,
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
    as_json: AsJson = False,
) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    from stickslip_sym.motion.thresholds.rungs import rungs
    from stickslip_sym.output.tables import duration, table

    bound = law.bound()
    given = scene.texts({name: PAPER[name] for name in ("V", "N")})
    read_numbers(given)  # refuses what is no number
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    if everything:
        usable = [name for name, rung in rungs().items() if "m" in given or not rung.oscillator]
        found = {name: _threshold(bound, given, name, min(rtol, 1e-10), limit) for name in usable}
    else:
        found = {method: _threshold(bound, given, method, rtol, limit)}
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
        theorem = getattr(found[method][0], "theorem", None)
        typer.echo(f"{found[method][0]}" + (f"\n\n{theorem}" if theorem else ""))


def _threshold(
    law: "FrictionLaw", scene: dict[str, str], method: str, rtol: float, limit: float | None
) -> tuple[Found, float]:
    """Return a threshold, or the error that says why there is none, and the seconds it took."""
    import time

    from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

    begin = time.perf_counter()
    try:
        found: Found = pure_slip_damping(law, **scene, method=method, rtol=rtol, time_limit=limit)
    except StickSlipError as error:
        found = error
    return found, time.perf_counter() - begin


def _as_json(method: str, threshold: Found, seconds: float) -> json_output.Json:
    if isinstance(threshold, StickSlipError):
        return {"method": method, "c": json_output.missing("kg/s", in_options(str(threshold)))}
    return {
        "method": threshold.method,
        "c": json_output.quantity(threshold.value, "kg/s"),
        "relative_error": json_output.number(threshold.error),
        "status": threshold.status,
        "seconds": seconds,
    }

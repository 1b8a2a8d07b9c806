"""``stickslip damping``: the threshold to a tolerance, or every rung of the ladder."""

from typing import TYPE_CHECKING, Annotated, cast

import typer

from stickslip_sym.cli.shared import json_answers, json_output
from stickslip_sym.cli.shared.completion import complete_method
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, MaybeOscillator
from stickslip_sym.cli.shared.reading import read_numbers
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.motion.thresholds.threshold import Threshold

__all__ = ["damping"]


def damping(
    law: LawOptions,
    scene: MaybeOscillator,
    method: Annotated[
        str,
        typer.Option(
            "--method", metavar="NAME", help="A rung of the ladder, or auto.", autocompletion=complete_method
        ),
    ] = "auto",
    rtol: Annotated[
        float | None,
        typer.Option("--rtol", help="Relative error that is good enough (0.001, or what the parameters deserve)."),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Print every rung of the ladder.")] = False,
    time_limit: Annotated[
        str | None, typer.Option("--time-limit", metavar="S", help="Seconds of computation, for each method.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -V "0.50(1)"; then the standard error of the
    damping and its budget are printed too.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    from stickslip_sym.core.uncertain import nominal_text
    from stickslip_sym.motion.thresholds.rungs import rungs
    from stickslip_sym.output.tables import duration, table

    bound = law.bound()
    given = scene.texts({name: PAPER[name] for name in ("V", "N")})
    read_numbers({name: nominal_text(text, name) for name, text in given.items()})  # refuses what is no number
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    if everything:
        usable = [name for name, rung in rungs().items() if "m" in given or not rung.oscillator]
        found = {name: _threshold(bound, given, name, min(rtol or 1e-10, 1e-10), limit) for name in usable}
    else:
        found = {method: _threshold(bound, given, method, rtol, limit)}
        if isinstance(error := found[method][0], StickSlipError):
            raise error
    if as_json:
        thresholds = [json_answers.threshold(method, *result) for method, result in found.items()]
        json_output.echo(
            "damping", law=json_output.law(bound), scene=json_output.values(given), thresholds=thresholds
        )
    elif everything:
        rows = [
            [method, f"none: {in_options(str(threshold))}", "", "", ""]
            if isinstance(threshold, StickSlipError | str)
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
        threshold = cast("Threshold", found[method][0])
        typer.echo(str(threshold) if threshold.budget is None else _with_budget(threshold))
        if threshold.theorem is not None:
            typer.echo(f"\n{threshold.theorem}")


def _threshold(
    law: "FrictionLaw", scene: dict[str, str], method: str, rtol: float | None, limit: float | None
) -> tuple[json_answers.Found, float]:
    """Return a threshold, or the error that says why there is none, and the seconds it took."""
    import time

    from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

    begin = time.perf_counter()
    try:
        found: json_answers.Found = pure_slip_damping(law, **scene, method=method, rtol=rtol, time_limit=limit)
    except StickSlipError as error:
        found = error
    return found, time.perf_counter() - begin


def _with_budget(threshold: "Threshold") -> str:
    """Return a threshold with its standard error, and what that consists of."""
    lines = [f"c = {threshold}"]
    _ = threshold.uncertainty  # warns where the first order does not serve
    if threshold.deserved is not None:
        lines.append(
            f"no more accurate a method than the parameters deserve: rtol = {threshold.deserved:.1e}, a tenth of "
            "their relative standard error; give --rtol for more"
        )
    return "\n".join([*lines, "", str(threshold.budget)])

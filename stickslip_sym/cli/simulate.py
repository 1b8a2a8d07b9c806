"""``stickslip simulate``: the motion from a start, its events, and how it ends."""

import math
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, Overwrite, SceneOptions, file_option
from stickslip_sym.cli.shared.reading import read_numbers, require_new, require_writable
from stickslip_sym.cli.shared.words import in_options

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.motion.simulation.trajectory import Trajectory

__all__ = ["simulate"]

_MOST_ROWS = 40  # of the table; the rest is in the file that --csv writes
_PERIODS = 10  # natural periods, the duration if none is given
_LONGEST = 5.0  # seconds, to find where the motion leads


def simulate(
    law: LawOptions,
    scene: SceneOptions,
    c: Annotated[str, typer.Option("-c", metavar="KG/S", help="Damping.")] = "0",
    x0: Annotated[str, typer.Option("--x0", metavar="M", help="Initial displacement.")] = "0",
    v0: Annotated[str | None, typer.Option("--v0", metavar="M/S", help="Initial velocity (belt speed).")] = None,
    t_end: Annotated[
        str | None, typer.Option("--t-end", metavar="S", help="Duration (ten natural periods).")
    ] = None,
    rtol: Annotated[str, typer.Option("--rtol", help="Relative tolerance of a step.")] = "1e-10",
    engine: Annotated[str, typer.Option("--engine", metavar="NAME", help="scipy or heyoka.")] = "scipy",
    time_limit: Annotated[
        str | None, typer.Option("--time-limit", metavar="S", help="Seconds of computation.")
    ] = None,
    plot: Annotated[Path | None, file_option("--plot", "Draw the motion (SVG, PNG or PDF).")] = None,
    csv: Annotated[Path | None, file_option("--csv", "Write the samples.")] = None,
    overwrite: Overwrite = False,
    as_json: AsJson = False,
) -> None:
    """Simulate the mass from a start, and print its events, what motion it is, and its periods.

    Example: stickslip simulate exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 -c 1 --t-end 5 --plot motion.png
    """
    from stickslip_sym.model.doubts import warn_where_negative
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.motion.simulation import automaton

    bound = law.bound()
    given = scene.texts() | {"c": c}
    osc = Oscillator(**read_numbers(given))
    warn_where_negative(bound, osc.V)
    values = read_numbers({"x0": x0, "v0": v0, "t_end": t_end, "rtol": rtol, "time_limit": time_limit})
    values.setdefault("t_end", _PERIODS * 2 * math.pi / osc.omega)
    require_new(csv, "--csv", overwrite)
    require_writable(csv, plot=plot)
    motion = automaton.simulate(bound, osc, engine=engine, **values)  # type: ignore[arg-type]  # no max_steps
    end = _end(bound, osc, motion, values)
    if as_json:
        known = {"law": json_output.law(bound), "scene": json_output.values(given)}
        json_output.echo("simulate", **known, **_as_json(motion, end))
    else:
        typer.echo(_report(motion, end))
    if csv is not None:
        motion.to_csv(csv)
    if plot is not None:
        motion.plot(plot)


def _end(law: "FrictionLaw", osc: "Oscillator", motion: "Trajectory", values: dict[str, float]) -> str | None:
    """Return which motion the start leads to, or that it was not found; None where the motion shows it."""
    from stickslip_sym.core.deadline import time_limit
    from stickslip_sym.core.errors import StickSlipError
    from stickslip_sym.motion.regimes.classification import classify
    from stickslip_sym.motion.simulation.trajectory import Tendency

    if motion.tendency in (Tendency.REST, Tendency.STICK_SLIP, Tendency.PURE_SLIP, Tendency.UNBOUNDED):
        return None
    start = {name: values[name] for name in ("x0", "v0") if name in values}
    try:
        with time_limit(min(_LONGEST, values.get("time_limit", _LONGEST))):
            return classify(law, osc, **start).value
    except StickSlipError as error:
        return f"not found: {error}"


def _as_json(motion: "Trajectory", end: str | None) -> json_output.Json:
    """Return what motion it is, the events and the outcome."""
    events = [
        {
            "t": json_output.quantity(event.t, "s"),
            "x": json_output.quantity(event.x, "m"),
            "v": json_output.quantity(event.v, "m/s"),
            "kind": event.kind.value,
            "begins": event.begins.value,
        }
        for event in motion.events
    ]
    periods = [json_output.quantity(period, "s") for period in _periods(motion)]
    word = {"motion": motion.tendency.value, "change_in_a_round": motion.change, "in_the_end": end}
    note = motion.note and in_options(motion.note)
    return word | {"outcome": motion.outcome.value, "note": note, "events": events, "periods": periods}


def _report(motion: "Trajectory", end: str | None) -> str:
    """Return the events as a table, and the motion in a few lines."""
    from stickslip_sym.output.tables import table

    rows = [
        [f"{event.t:.9g}", f"{event.x:.9g}", f"{event.v:.9g}", event.kind.value, event.begins.value]
        for event in motion.events[:_MOST_ROWS]
    ]
    lines = [table(["t in s", "x in m", "v in m/s", "event", "phase that begins"], rows)]
    if (more := len(motion.events) - _MOST_ROWS) > 0:
        lines.append(f"and {more} more events")
    lines += ["", f"motion: {motion.summary}" + ("" if end is None else f"; in the end: {end}")]
    lines.append(f"outcome: {motion.outcome.value}, at t = {motion.t[-1]:.9g} s, {len(motion.events)} events")
    lines += [in_options(motion.note)] if motion.note else []
    periods = _periods(motion)
    if periods:
        changes = f", the one before {periods[-2]:.12g} s" if len(periods) > 1 else ""
        lines.append(f"periods from slip to slip: {len(periods)}, the last {periods[-1]:.12g} s{changes}")
    else:
        lines.append("periods: fewer than two slips from stick")
    return "\n".join(lines)


def _periods(motion: "Trajectory") -> list[float]:
    """Return the times from one slip that follows stick to the next."""
    from stickslip_sym.motion.simulation.trajectory import EventKind

    onsets = [event.t for event in motion.events if event.kind is EventKind.SLIPS]
    return [after - before for before, after in pairwise(onsets)]

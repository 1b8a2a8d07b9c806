"""``stickslip simulate``: the motion from a start, its events, and how it ends."""

from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.cli_reading import LawName, Values, assignments, check_size, once, read_law

__all__ = ["simulate"]

_MOST_ROWS = 40  # of the table; the rest is in the file that --csv writes
_PERIODS = 10  # natural periods, the duration if none is given


def simulate(
    law: LawName,
    parameter: Values = None,
    speed: Annotated[list[str] | None, typer.Option("-V", metavar="M/S", help="Belt speed (0.5).")] = None,
    force: Annotated[list[str] | None, typer.Option("-N", metavar="N", help="Normal force (9.81).")] = None,
    mass: Annotated[list[str] | None, typer.Option("-m", metavar="KG", help="Mass (1).")] = None,
    stiffness: Annotated[list[str] | None, typer.Option("-k", metavar="N/M", help="Stiffness (100).")] = None,
    damping: Annotated[list[str] | None, typer.Option("-c", metavar="KG/S", help="Damping (0).")] = None,
    x0: Annotated[list[str] | None, typer.Option("--x0", metavar="M", help="Initial displacement (0).")] = None,
    v0: Annotated[
        list[str] | None, typer.Option("--v0", metavar="M/S", help="Initial velocity (the belt speed).")
    ] = None,
    t_end: Annotated[
        list[str] | None, typer.Option("--t-end", metavar="S", help="Duration (ten natural periods).")
    ] = None,
    rtol: Annotated[list[str] | None, typer.Option("--rtol", help="Relative tolerance of a step (1e-10).")] = None,
    engine: Annotated[list[str] | None, typer.Option("--engine", metavar="NAME", help="scipy or heyoka.")] = None,
    time_limit: Annotated[
        list[str] | None, typer.Option("--time-limit", metavar="S", help="Seconds of computation.")
    ] = None,
    plot: Annotated[
        list[Path] | None, typer.Option("--plot", metavar="FILE", help="Draw the motion (SVG, PNG or PDF).")
    ] = None,
    csv: Annotated[list[Path] | None, typer.Option("--csv", metavar="FILE", help="Write the samples.")] = None,
) -> None:
    """Simulate the mass from a start, and print its events and its periods.

    Example: stickslip simulate exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 -c 1 --t-end 5 --plot motion.png
    """
    import math

    from stickslip_sym import automaton
    from stickslip_sym.oscillator import Oscillator
    from stickslip_sym.values import exact

    bound = read_law(law, None, extrapolate=False).typical(**assignments(parameter or []))
    given = {
        "V": once("V", speed) or "0.5",
        "N": once("N", force) or "9.81",
        "m": once("m", mass) or "1",
        "k": once("k", stiffness) or "100",
        "c": once("c", damping) or "0",
    }
    options = {
        "x0": once("x0", x0),
        "v0": once("v0", v0),
        "t_end": once("t-end", t_end),
        "rtol": once("rtol", rtol),
        "time_limit": once("time-limit", time_limit),
    }
    plot_file, csv_file, integrator = once("plot", plot), once("csv", csv), once("engine", engine) or "scipy"
    numbers = {name: exact(value, name) for name, value in (given | options).items() if value is not None}
    for name, value in numbers.items():
        check_size(name, value)
    values: dict[str, Any] = {name: float(value) for name, value in numbers.items()}
    osc = Oscillator(**{name: values.pop(name) for name in given})
    values.setdefault("t_end", _PERIODS * 2 * math.pi / osc.omega)
    motion = automaton.simulate(bound, osc, **values, engine=integrator)
    typer.echo(_report(motion, osc))
    if csv_file is not None:
        motion.to_csv(csv_file)
    if plot_file is not None:
        motion.plot(plot_file)


def _report(motion: Any, osc: Any) -> str:
    """Return the events as a table, and the motion in a few lines."""
    from stickslip_sym.tables import table

    rows = [
        [f"{event.t:.9g}", f"{event.x:.9g}", f"{event.v:.9g}", event.kind.value, event.begins.value]
        for event in motion.events[:_MOST_ROWS]
    ]
    lines = [table(["t in s", "x in m", "v in m/s", "event", "phase that begins"], rows)]
    if (more := len(motion.events) - _MOST_ROWS) > 0:
        lines.append(f"and {more} more events")
    lines += ["", f"outcome: {motion.outcome.value}, at t = {motion.t[-1]:.9g} s, {len(motion.events)} events"]
    lines += [motion.note] if motion.note else []
    lines.append(_periods(motion))
    return "\n".join(lines)


def _periods(motion: Any) -> str:
    import numpy as np

    from stickslip_sym.trajectory import EventKind

    onsets = np.array([event.t for event in motion.events if event.kind is EventKind.SLIPS])
    periods = np.diff(onsets)
    if not periods.size:
        return "periods: fewer than two slips from stick"
    changes = f", the one before {periods[-2]:.12g} s" if periods.size > 1 else ""
    return f"periods from slip to slip: {periods.size}, the last {periods[-1]:.12g} s{changes}"

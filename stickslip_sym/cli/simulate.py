"""``stickslip simulate``: the motion from an initial condition, its events, and how it ends."""

from itertools import pairwise
from typing import TYPE_CHECKING

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import point
from stickslip_sym.cli.options import Given, option, read_number
from stickslip_sym.cli.output import echo_found, show_progress
from stickslip_sym.core.seconds import SECONDS_OF_PART
from stickslip_sym.output.tables import aligned_table

if TYPE_CHECKING:
    from stickslip_sym.motion.simulation.trajectory import Trajectory

_MOST_ROWS = 40  # of the table; the rest is in the file that --csv writes


@options.command(
    options.AT, options.DAMPING,
    option("--x0", metavar="M", read=read_number, default=0.0, help="Initial displacement (0)."),
    option("--v0", metavar="M/S", read=read_number, help="Initial velocity (belt speed)."),
    option("--t-end", metavar="S", read=read_number, help="Duration (ten natural periods)."),
    option("--rtol", metavar="X", read=read_number, default=1e-10, help="Relative tolerance of a step (1e-10)."),
    option("--method", metavar="NAME", default="events", help="events, or solve_ivp of SciPy (events)."),
    options.time_limit_option(),
    options.plot_option("Draw the motion"),
    options.file_option("--csv", help="Write the samples."),
)  # fmt: skip
def run(given: Given) -> None:
    """Simulate the mass, and print its events, what motion it is, and its periods.

    Example: stickslip simulate exponential -V 0.5 -N 9.81 -m 1 -k 100 -c 1 --t-end 5 --plot motion.png
    """
    from stickslip_sym.core.deadline import time_limit as limited
    from stickslip_sym.model.negative import warn_where_negative
    from stickslip_sym.motion.simulation.trajectory import EventKind

    at = point(given, c="0").exact("simulate")
    initial = {name: given[name] for name in ("x0", "v0")}
    how = {name: given[name] for name in ("rtol", "method", "time_limit")}
    t_end = given["t_end"]
    csv = given["csv"]
    plot = given["plot"]
    given.reject_unused()
    osc = ss.Oscillator(**at.numbers)
    warn_where_negative(at.law.kinetic, osc.V)
    with show_progress("motion" if t_end is None else f"motion up to {t_end:.4g} s"):
        motion = ss.simulate(at.law, osc, t_end=t_end, **initial, **how)
    end = None
    if motion.motion not in (ss.Motion.REST, ss.Motion.STICK_SLIP, ss.Motion.PURE_SLIP, ss.Motion.UNBOUNDED):
        try:
            with (
                show_progress("what it comes to"),
                limited(min(SECONDS_OF_PART, how["time_limit"] or SECONDS_OF_PART)),
            ):
                end = ss.classify(at.law, osc, **initial).value
        except ss.StickSlipError as error:
            end = f"not found: {error}"
    onsets = [event.t for event in motion.events if event.kind is EventKind.SLIPS]
    periods = [after - before for before, after in pairwise(onsets)]
    echo_found(given, at, _report(motion, end, periods), motion=motion, in_the_end=end, periods=periods)
    if csv is not None:
        motion.to_csv(csv)
    if plot is not None:
        motion.plot(plot)


def _report(motion: "Trajectory", end: str | None, periods: list[float]) -> str:
    """Return the events as a table, and the motion in a few lines."""
    rows = [
        [*(f"{number:.9g}" for number in (event.t, event.x, event.v)), event.kind.value, event.begins.value]
        for event in motion.events[:_MOST_ROWS]
    ]
    more = len(motion.events) - _MOST_ROWS
    lines = [
        aligned_table(["t in s", "x in m", "v in m/s", "event", "phase that begins"], rows),
        f"and {more} more events\n" if more > 0 else "",
        f"motion: {motion.summary}" + ("" if end is None else f"; in the end: {end}"),
        f"outcome: {motion.outcome.value}, at t = {motion.t[-1]:.9g} s, {len(motion.events)} events",
        *([motion.note] if motion.note else []),
    ]
    if periods:
        changes = ""
        if len(periods) > 1:
            changes = f", the one before {periods[-2]:.12g} s"
        lines.append(f"periods from slip to slip: {len(periods)}, the last {periods[-1]:.12g} s{changes}")
    else:
        lines.append("periods: fewer than two slips from stick")
    return "\n".join(lines)

"""``stickslip tradeoff``: what each method for a number costs, and how far it is off."""

from typing import Any

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import point
from stickslip_sym.cli.options import Given, option
from stickslip_sym.cli.output import echo_found, show_progress


@options.command(
    options.AT, options.criterion(),
    option("--thresholds", is_flag=True, help="Of the threshold: every method, the paper's Newmark scan, SciPy."),
    option("--basins", is_flag=True, help="Of the share of initial conditions that come to rest."),
    option("--all", is_flag=True, help="Of a criterion, a threshold and a share, in one run."),
    options.DAMPING,
    options.plot_option("Draw error against time"),
    options.time_limit_option("Seconds; methods that are left then have no number (600).", 600.0),
)  # fmt: skip
def run(given: Given) -> None:
    """Measure what each method for a number costs, how far it is off, and which other method dominates it.

    The number is a criterion, by default at V = 0.05 m/s, where its methods differ.

    Example: stickslip tradeoff exponential --all --plot trade.svg
    """
    from stickslip_sym.model.negative import warn_where_negative

    thresholds = given["thresholds"]
    basins = given["basins"]
    every = given["all"]
    asked = {"criterion": not (thresholds or basins), "threshold": thresholds, "basin": basins}
    kinds = [kind for kind, wanted in asked.items() if wanted or every]
    at = point(given, without=() if "basin" in kinds else ("c",)).exact("tradeoff")
    if "V" in at.defaults:  # each number has a default of its own
        del at.texts["V"]
    elif not at.law.missing:
        warn_where_negative(at.law.kinetic, at.numbers["V"])
    more = {"criterion": given["criterion"]} if "criterion" in kinds else {}
    limit = given["time_limit"]
    plot = given["plot"]
    given.reject_unused()
    quantities: dict[str, Any] = dict(at.texts)
    with show_progress("methods, each several times"):
        tradeoff = ss.tradeoff(at.law, of=kinds, time_limit=limit, **more, **quantities)
    echo_found(given, at, tradeoff, **more, trades=tradeoff.trades, refused=tradeoff.refused)
    if plot is not None:
        tradeoff.plot(plot)

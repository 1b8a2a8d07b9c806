"""``stickslip damping``: the threshold to a tolerance, or by every method."""

import time
from typing import TYPE_CHECKING

import click

from stickslip_sym.cli.options import JSON, LAW, METHOD, POINT, Given, command, option, time_limit
from stickslip_sym.cli.output import echo_json, point_of
from stickslip_sym.cli.reading import points
from stickslip_sym.cli.words import in_options
from stickslip_sym.output.tables import table

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.threshold import Threshold

_RTOL = 1e-10  # asked of every method that can be made more accurate, with --all


@command(
    "damping", LAW, POINT, METHOD, option("--all", is_flag=True, help="Compare every method."),
    time_limit("Seconds of computation, for each method."), JSON,
)  # fmt: skip
def run(given: Given) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -V "0.50(1)"; then the standard error of the
    damping and its budget are printed too. Several --point files give an answer each.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    from stickslip_sym.comparison.compare import HEADER, Answer, compare
    from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

    method = None if given["all"] else given["method"]
    rtol, limit = given["rtol"], given["time_limit"]
    reports = []
    for one in points(given, without=("c",)):
        given.all_used()
        if method is None:
            answers = compare(one.law, None, rtol=min(rtol or _RTOL, _RTOL), time_limit=limit, **one.texts).answers
        else:
            begin = time.perf_counter()
            threshold = pure_slip_damping(one.law, **one.texts, method=method, rtol=rtol, time_limit=limit)
            answers = (Answer(method, threshold, "", time.perf_counter() - begin),)
        reports.append((one, answers))
    if given["json"]:
        contents = [point_of(one) | {"answers": answers} for one, answers in reports]
        echo_json("damping", **(contents[0] if len(contents) == 1 else {"points": contents}))
        return
    for number, (one, answers) in enumerate(reports):
        click.echo(("\n" if number else "") + f"{one}\n")
        if method is None:
            click.echo(table(HEADER, [[in_options(cell) for cell in answer.cells] for answer in answers]))
        elif answers[0].threshold is not None:
            click.echo(_report(answers[0].threshold))


def _report(threshold: "Threshold") -> str:
    """Return a threshold, with its standard error and what that consists of, and the theorem if it is proved."""
    lines = [f"c = {threshold}"]
    if threshold.budget is not None:
        _ = threshold.uncertainty  # warns where the first order is not enough
        if threshold.deserved is not None:
            lines.append(
                "no more accurate a method than the parameters deserve: rtol = "
                f"{threshold.deserved:.1e}, a tenth of their relative standard error; give --rtol for more"
            )
        lines += ["", str(threshold.budget)]
    if threshold.theorem is not None:
        lines += ["", str(threshold.theorem)]
    return "\n".join(lines)

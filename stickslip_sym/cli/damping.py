"""``stickslip damping``: the threshold to a tolerance, or by every method."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import points
from stickslip_sym.cli.options import Given, file_option, option
from stickslip_sym.cli.output import echo_all, show_progress
from stickslip_sym.core.aliases import Json
from stickslip_sym.core.errors import InputError
from stickslip_sym.output.files import write_text

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.threshold import Threshold


@options.command(
    options.AT, options.METHOD,
    file_option("--certificate", help="A script that proves the threshold without this package (--method proof)."),
    option("--all", is_flag=True, help="Compare every method."),
    options.plot_option("Draw thresholds over the belt speed, and that of the one point"),
    options.time_limit_option("Seconds of computation, for each method."),
)  # fmt: skip
def run(given: Given) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    A value may carry a standard error, as in -p mu_s=0.50+/-0.02 or -V "0.50(1)"; then the standard error of the
    damping and its budget are printed too. Several --point files give an answer each. With V and N alone, an
    average of the slope is printed, which needs no mass and no stiffness, and whose error is not known.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    from stickslip_sym.comparison.compare import COMPARED_RTOL

    method = None if given["all"] else given["method"]
    rtol = given["rtol"]
    limit = given["time_limit"]
    script = given["certificate"]
    if script is not None and method != "proof":
        raise InputError(
            f"a certificate is the script of a theorem: add --method proof, or leave out --certificate {script}"
        )
    contents = list[Json]()
    texts = []
    certificates = []
    at_all = points(given, without=_left_out(given, method))
    plot = given["plot"] if len(at_all) == 1 else None
    for at in at_all:
        given.reject_unused()
        if method is None:
            with show_progress("thresholds by every method"):
                compared = ss.compare(at.law, None, rtol=min(rtol, COMPARED_RTOL), time_limit=limit, **at.texts)
            contents.append({"operating_point": at, "rows": compared.rows})
            texts.append(f"{at}\n\n{compared}")
            if plot is not None:
                with show_progress("thresholds over the belt speed"):
                    compared.plot(plot)
            continue
        with show_progress("threshold"):
            threshold = ss.pure_slip_damping(at.law, **at.texts, method=method, rtol=rtol, time_limit=limit)
            _ = threshold.uncertainty  # warns where the first order is not enough
        text = f"c = {threshold}"
        if "m" not in at.texts:
            text += (
                "\nThis is an average over the belt's speed: give -m and -k for the threshold, which has an error."
            )
        contents.append({"operating_point": at, "threshold": threshold})
        if script is not None:
            certificates += [theorem.certificate() for theorem in threshold.theorems]
        if plot is not None:
            _draw(plot, threshold)
        texts.append("\n\n".join(map(str, filter(None, (at, text, threshold.budget, threshold.theorem)))))
    if script is not None:
        write_text(script, "\n\n".join(certificates))
    echo_all(given, contents, texts)


def _left_out(given: Given, method: str | None) -> tuple[str, ...]:
    """Return the quantities that are not asked for: m and k too, where V and N are given and they are not.

    A mass and a stiffness that nobody named would give a threshold, and an error, of another machine.
    """
    stated = [name for name in "VNmk" if given[name] is not None]
    one_answer = method == "auto" and not given["point"] and given["plot"] is None
    return ("c", "m", "k") if one_answer and stated == ["V", "N"] else ("c",)


def _draw(path: Path, threshold: Threshold[float]) -> None:
    from stickslip_sym.views.drawing import save_drawing
    from stickslip_sym.views.threshold_plane import figure_of_plane

    with show_progress("thresholds over the belt speed"):
        figure = figure_of_plane(threshold)
    save_drawing(figure, path)

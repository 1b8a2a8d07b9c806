"""``stickslip critical``: values of one quantity at which the damping just suffices, or margins of all."""

from typing import Any

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import point
from stickslip_sym.cli.options import Given, option
from stickslip_sym.cli.output import echo_found, show_progress
from stickslip_sym.core.errors import InputError


@options.command(
    options.AT,
    option(
        "--of", metavar="NAME", default="all", help="V, N, m, k, c or a parameter, or all (all).",
        shell_complete=options.complete_quantities,
    ),
    options.DAMPING, options.METHOD,
    option("--within", metavar="LOW:HIGH", help="Where to look."),
    options.time_limit_option(),
)  # fmt: skip
def run(given: Given) -> None:
    """Print every value of a quantity at which the damping is just the pure-slip damping.

    Of all quantities the margins are printed. Values may carry standard errors then, and the probability that
    stick-slip is possible is printed too.

    Example: stickslip critical exponential --of mu_s -c 2 -V 0.5
    """
    of = given["of"]
    at = point(given, without=[given["of"]])
    how: dict[str, Any] = {name: given[name] for name in ("method", "time_limit", "rtol")}
    if "c" not in at.texts and of != "c":
        raise InputError("critical values are computed at a given damping: add -c VALUE")
    if of == "all":
        given.reject_unused()
        with show_progress("margins of all quantities"):
            margins = ss.margins(at.law, ss.Oscillator(**at.numbers), errors=at.texts, **how)
        echo_found(given, at, margins, of="all", margins=margins)
        return
    at.exact("critical --of " + of)
    text = given["within"]
    unit = options.unit_of_option(at.law, of)
    within = None
    if text is not None:
        within = options.read_range(text, "--within", of=of, unit=unit)
    given.reject_unused()
    with show_progress(f"critical values of {of}"):
        values = ss.critical(at.law, of, **how | at.numbers, within=within)
    echo_found(given, at, values, of=of, values=values, looked=values.looked, unresolved=values.unresolved)

"""``stickslip critical``: values of one quantity at which the damping just suffices, or margins of all."""

from typing import Any

import stickslip_sym as ss
from stickslip_sym.cli.options import DAMPING, LAW, METHOD, POINT, RANGE, Given, command, option, time_limit
from stickslip_sym.cli.output import echo_found
from stickslip_sym.cli.reading import point
from stickslip_sym.core.errors import InputError


@command(
    "critical", LAW,
    option("--of", metavar="NAME", default="all", help="V, N, m, k, c or a parameter, or all (all)."),
    DAMPING, POINT, METHOD, option("--within", metavar="LOW:HIGH", type=RANGE, help="Where to look, in SI units."),
    time_limit(),
)  # fmt: skip
def run(given: Given) -> None:
    """Print every value of a quantity at which the damping is just the pure-slip damping.

    Of all quantities the margins are printed. Values may carry standard errors then, and the probability that
    stick-slip is possible is printed too.

    Example: stickslip critical exponential --of mu_s -c 2 -V 0.5
    """
    of = given["of"]
    how: dict[str, Any] = {
        "method": given["method"],
        "rtol": given["rtol"] or 1e-3,
        "time_limit": given["time_limit"],
    }
    at = point(given, without=[of])
    if "c" not in at.texts and of != "c":
        raise InputError("critical values are computed at a given damping: add -c VALUE")
    if of == "all":
        given.all_used()
        margins = ss.margins(at.law, ss.Oscillator(**at.numbers), errors=at.texts, **how)
        echo_found(given, at, margins, of="all", margins=margins)
        return
    at.exact("critical --of " + of)
    within = given["within"]
    given.all_used()
    values = ss.critical(at.law, of, **how | at.numbers, within=within)
    text = "\n".join(map(str, values)) or f"there is no such value of {of}"
    echo_found(given, at, text, of=of, values=values)

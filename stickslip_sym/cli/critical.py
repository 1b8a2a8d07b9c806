"""``stickslip critical``: values of one quantity at which the damping just suffices, or margins of all."""

from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.shared import json_answers, json_output
from stickslip_sym.cli.shared.completion import complete_method
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import AsJson, MaybeOscillator
from stickslip_sym.cli.shared.reading import read_numbers
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw

__all__ = ["critical"]


def critical(
    of: Annotated[
        str,
        typer.Argument(metavar="NAME", help="V, N, m, k, c or a parameter; all: the margins of each."),
    ],
    law: LawOptions,
    scene: MaybeOscillator,
    damping: Annotated[str | None, typer.Option("-c", metavar="KG/S", help="Damping.")] = None,
    method: Annotated[
        str,
        typer.Option(
            "--method", metavar="NAME", help="A rung of the ladder, or auto.", autocompletion=complete_method
        ),
    ] = "auto",
    rtol: Annotated[float, typer.Option("--rtol", help="Relative error that is good enough.")] = 1e-3,
    within: Annotated[
        str | None, typer.Option("--within", metavar="LOW:HIGH", help="Where to look, in SI units.")
    ] = None,
    time_limit: Annotated[
        str | None, typer.Option("--time-limit", metavar="S", help="Seconds of computation.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print every value of a quantity at which the damping is just the pure-slip damping.

    With NAME all the damping may carry a standard error too, and the probability of stick-slip is printed.

    Example: stickslip critical mu_s exponential -c 2 -V 0.5
    """
    from stickslip_sym.core.errors import InputError
    from stickslip_sym.core.uncertain import nominal_text
    from stickslip_sym.motion.margins.critical import critical as critical_values

    bound = law.bound()
    names = ("V", "N", "m", "k") if of in ("m", "k", "all") else ("V", "N")
    texts = scene.texts({name: PAPER[name] for name in names if name != of})
    if damping is not None:
        texts["c"] = damping
    numbers = read_numbers({key: nominal_text(text, key) for key, text in texts.items()})
    if "c" not in numbers and of != "c":
        raise InputError("the damping is what all but c is sought for; give -c ...")
    limit = read_numbers({"time_limit": time_limit}).get("time_limit")
    if of == "all":
        _print_margins(bound, texts, numbers, method, rtol, limit, as_json)
        return
    ends: tuple[float, float] | None = None
    if within is not None:
        low, colon, high = within.partition(":")
        if not colon:
            raise InputError(f"--within {within} is not LOW:HIGH; write for example --within 0.1:10")
        read = read_numbers({"within": low, "within to": high})
        ends = read["within"], read["within to"]
    found = critical_values(of, bound, **numbers, method=method, rtol=rtol, within=ends, time_limit=limit)
    if as_json:
        json_output.echo(
            "critical",
            law=json_output.law(bound),
            scene=json_output.values(texts),
            of=of,
            values=[json_answers.critical(one) for one in found],
        )
    else:
        typer.echo("\n".join(map(str, found)) or f"there is no such value of {of}")


def _print_margins(
    law: "FrictionLaw",
    texts: dict[str, str],
    numbers: dict[str, float],
    method: str,
    rtol: float,
    limit: float | None,
    as_json: bool,
) -> None:
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.motion.margins.margins import margins

    osc = Oscillator(**numbers)
    found = margins(law, osc, errors=texts, method=method, rtol=rtol, time_limit=limit)
    if not as_json:
        typer.echo(str(found))
        return
    json_output.echo(
        "critical",
        law=json_output.law(law),
        scene=json_output.values(texts),
        of="all",
        **json_answers.margins(found),
    )

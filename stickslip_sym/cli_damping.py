"""``stickslip damping``: the threshold to a tolerance, or every rung of the ladder."""

from typing import Annotated

import typer

from stickslip_sym.cli_reading import LawName, Values, assignments, check_size, read_law
from stickslip_sym.errors import StickSlipError

__all__ = ["damping"]


def damping(
    law: LawName,
    parameter: Values = None,
    speed: Annotated[str, typer.Option("-V", metavar="M/S", help="Belt speed.")] = "0.5",
    force: Annotated[str, typer.Option("-N", metavar="N", help="Normal force.")] = "9.81",
    mass: Annotated[str | None, typer.Option("-m", metavar="KG", help="Mass; goes with -k.")] = None,
    stiffness: Annotated[str | None, typer.Option("-k", metavar="N/M", help="Stiffness; goes with -m.")] = None,
    method: Annotated[
        str, typer.Option("--method", metavar="NAME", help="A rung of the ladder, or auto.")
    ] = "auto",
    rtol: Annotated[float, typer.Option("--rtol", help="Relative error that is good enough.")] = 1e-3,
    everything: Annotated[bool, typer.Option("--all", help="Print every rung of the ladder.")] = False,
) -> None:
    """Print the pure-slip damping, the method that gave it, and its error.

    Example: stickslip damping exponential -p alpha=3 -V 0.5 -N 9.81 -m 1 -k 100 --all
    """
    import time

    from stickslip_sym.tables import duration, table
    from stickslip_sym.threshold import LADDER, pure_slip_damping
    from stickslip_sym.values import exact

    bound = read_law(law, None, extrapolate=False).typical(**assignments(parameter or []))
    given = {"V": speed, "N": force, "m": mass, "k": stiffness}
    numbers = {name: exact(value, name) for name, value in given.items() if value is not None}
    for name, value in numbers.items():
        check_size(name, value)
    scene = {name: float(value) for name, value in numbers.items()}
    if not everything:
        typer.echo(str(pure_slip_damping(bound, **scene, method=method, rtol=rtol)))
        return
    rows = []
    for rung in LADDER if "m" in scene else LADDER[:3]:
        begin = time.perf_counter()
        try:
            found = pure_slip_damping(bound, **scene, method=rung, rtol=min(rtol, 1e-10))
        except StickSlipError as error:
            rows.append([rung, f"none: {error}", "", ""])
            continue
        error_text = "unknown" if found.error is None else f"{found.error:.1e}"
        rows.append([rung, f"{found.value:.12g}", error_text, duration(time.perf_counter() - begin)])
    typer.echo(table(["method", "c in kg/s", "relative error", "time"], rows))

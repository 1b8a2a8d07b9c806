"""The law of a command: of the catalogue, a formula with its description, or measured points."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.cli.completion import complete_law
from stickslip_sym.cli.reading import assignments
from stickslip_sym.core.errors import InputError

__all__ = ["Extrapolate", "FromCsv", "LawName", "Name", "Source", "Static", "Units", "read_law"]

LawName = Annotated[
    str | None,
    typer.Argument(
        metavar="LAW",
        help="Name of a law (see: stickslip laws), or a formula in v.",
        autocompletion=complete_law,
    ),
]
FromCsv = Annotated[
    Path | None,
    typer.Option(
        "--from-csv", metavar="FILE", help="Measured friction instead: v and mu, or v, F_t and F_n, in columns."
    ),
]
Extrapolate = Annotated[
    bool, typer.Option("--extrapolate", help="Hold the first and the last measured coefficient.")
]
Static = Annotated[
    str | None,
    typer.Option("--static", metavar="MU", help="Static coefficient above mu(0+): a number or a formula."),
]
Name = Annotated[str | None, typer.Option("--name", metavar="NAME", help="Name of a formula or of points.")]
Units = Annotated[
    list[str] | None,
    typer.Option("--unit", metavar="NAME=UNIT", help="Unit of a formula's parameter; may be repeated."),
]
Source = Annotated[str | None, typer.Option("--source", metavar="TEXT", help="Where the law is from.")]


def read_law(
    text: str | None,
    from_csv: Path | None = None,
    *,
    extrapolate: bool = False,
    static: str | None = None,
    name: str | None = None,
    unit: Sequence[str] | None = None,
    source: str | None = None,
) -> Any:
    """Return a law: of the catalogue by its name, from a formula, or through the points of a CSV file.

    Raises
    ------
    InputError
        If it is given twice or not at all, or with options that do not belong to it.
    """
    from stickslip_sym.model.expression.parsing import NAME
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.laws import find
    from stickslip_sym.model.measured.measurements import read_measurements

    units = assignments(unit or [], "--unit alpha=s/m")
    if from_csv is not None and text is not None:
        raise InputError(f"the law is given twice, as {text!r} and by --from-csv; give it once")
    if from_csv is None and extrapolate:
        raise InputError("--extrapolate belongs to --from-csv: a formula holds at all speeds")
    if from_csv is not None:
        measured = read_measurements(from_csv)
        typer.echo(measured.averaged().understood, err=True)  # beside JSON, not in it
        law = FrictionLaw.from_csv(measured, extrapolate=extrapolate, source=source, name=name)
    elif text is None:
        raise InputError("no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE")
    elif NAME.fullmatch(text):
        law = find(text)
        for option, value in (("--name", name), ("--source", source)):
            if value is not None:
                raise InputError(f"{option} belongs to a formula or to --from-csv: {text} has its own")
    else:
        return FrictionLaw(text, static=static, units=units, name=name, source=source)
    if static is not None:
        return law.with_static(static, units=units)
    if units:
        raise InputError("--unit belongs to the parameters of a formula or of --static; there are none")
    return law

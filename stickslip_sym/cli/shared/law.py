"""The law of a command: of the catalogue, a formula with its description, or measured points."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.shared.completion import complete_law
from stickslip_sym.cli.shared.reading import assignments
from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw

__all__ = ["Description", "LawOptions"]


@dataclass(frozen=True)
class Description:
    """What is said of a law besides its formula, as options."""

    static: Annotated[
        str | None,
        typer.Option("--static", metavar="MU", help="Static coefficient above mu(0+): a number or a formula."),
    ] = None
    name: Annotated[str | None, typer.Option("--name", metavar="NAME", help="Name of a formula or of points.")] = (
        None
    )
    unit: Annotated[
        list[str] | None,
        typer.Option("--unit", metavar="NAME=UNIT", help="Unit of a formula's parameter; may be repeated."),
    ] = None
    source: Annotated[str | None, typer.Option("--source", metavar="TEXT", help="Where the law is from.")] = None

    def law_of(
        self, text: str | None, from_csv: Path | None = None, *, extrapolate: bool = False
    ) -> "FrictionLaw":
        """Return a law: of the catalogue by its name, from a formula, or through the points of a CSV file.

        Raises `InputError` if it is given twice or not at all, or with options that do not belong to it.
        """
        from stickslip_sym.model.expression.spelling import NAME
        from stickslip_sym.model.law import FrictionLaw
        from stickslip_sym.model.laws import find

        units = assignments(self.unit or [], "--unit alpha=s/m")
        if from_csv is not None and text is not None:
            raise InputError(f"the law is given twice, as {text!r} and by --from-csv; give it once")
        if from_csv is None and extrapolate:
            raise InputError("--extrapolate belongs to --from-csv: a formula holds at all speeds")
        if from_csv is not None:
            from stickslip_sym.model.measured.measurements import read_measurements

            measured = read_measurements(from_csv)
            typer.echo(measured.averaged().understood, err=True)  # beside JSON, not in it
            law = FrictionLaw.from_csv(measured, extrapolate=extrapolate, source=self.source, name=self.name)
        elif text is None:
            raise InputError("no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE")
        elif NAME.fullmatch(text):
            law = find(text)
            for option, value in (("--name", self.name), ("--source", self.source)):
                if value is not None:
                    raise InputError(f"{option} belongs to a formula or to --from-csv: {text} has its own")
        else:
            return FrictionLaw(text, static=self.static, units=units, name=self.name, source=self.source)
        if self.static is not None:
            return law.with_static(self.static, units=units)
        if units:
            raise InputError("--unit belongs to the parameters of a formula or of --static; there are none")
        return law


@dataclass(frozen=True)
class LawOptions(Description):
    """One law, and values of its parameters."""

    law: Annotated[
        str | None,
        typer.Argument(
            metavar="LAW",
            help="Name of a law (see: stickslip laws), or a formula in v.",
            autocompletion=complete_law,
        ),
    ] = None
    from_csv: Annotated[
        Path | None,
        typer.Option(
            "--from-csv",
            metavar="FILE",
            help="Measured friction instead: v and mu, or v, F_t and F_n, in columns.",
        ),
    ] = None
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Hold the first and the last measured coefficient.")
    ] = False
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Value of a parameter; may be repeated."),
    ] = None

    def __post_init__(self) -> None:
        """Refuse a name that is no law's, before a command imports what takes time."""
        from stickslip_sym.model.expression.spelling import NAME
        from stickslip_sym.model.laws import check_name

        if self.law is not None and self.from_csv is None and NAME.fullmatch(self.law):
            check_name(self.law)

    @property
    def values(self) -> dict[str, str]:
        """The values of parameters that were given."""
        return assignments(self.parameter or [])

    def bound(self) -> "FrictionLaw":
        """Return the law with the values that were given, and typical ones for the rest."""
        law = self.law_of(self.law, self.from_csv, extrapolate=self.extrapolate)
        return law.typical(**self.values)

"""The command line, ``stickslip``."""

import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.errors import InputError, StickSlipError

# Everything that needs SymPy is imported by the command that uses it: help must come at once.

app = typer.Typer(
    name="stickslip",
    help="How much damping does a mass on a moving belt need so that it does not stick and slip?",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

BAD_INPUT, NOT_FOUND = 2, 1


@app.command()
def laws() -> None:
    """List the friction laws of the catalogue.

    Example: stickslip laws
    """
    from stickslip_sym import printing
    from stickslip_sym.laws import catalogue
    from stickslip_sym.tables import table

    rows = [
        [name, printing.text(law.expr), ", ".join(_described(p) for p in law.parameters.values())]
        for name, law in catalogue.items()
    ]
    typer.echo(table(["law", "mu(v)", "parameters"], rows))


def _described(parameter: Any) -> str:
    unit = "" if parameter.unit in (None, "1") else f" {parameter.unit}"
    return f"{parameter.name} = {parameter.typical}{unit}" if parameter.typical else str(parameter.name)


@app.command()
def derive(
    law: Annotated[
        str, typer.Argument(metavar="LAW", help="Name of a law (see: stickslip laws), or a formula in v.")
    ],
    criterion: Annotated[str, typer.Option(help="least_squares or equilibrium.")] = "least_squares",
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Value for the table; may be repeated."),
    ] = None,
    speed: Annotated[list[str] | None, typer.Option("-V", metavar="M/S", help="Belt speed (0.5).")] = None,
    force: Annotated[list[str] | None, typer.Option("-N", metavar="N", help="Normal force (9.81).")] = None,
    mass: Annotated[list[str] | None, typer.Option("-m", metavar="KG", help="Mass (1).")] = None,
    stiffness: Annotated[list[str] | None, typer.Option("-k", metavar="N/M", help="Stiffness (100).")] = None,
    steps: Annotated[bool, typer.Option("--steps", help="Print every step of the derivation.")] = False,
    latex: Annotated[
        Path | None, typer.Option("--latex", metavar="FILE", help="Write the formula as LaTeX.")
    ] = None,
) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive exponential -p alpha=3 -V 0.5 --steps
    """
    from stickslip_sym import crosscheck, files, printing
    from stickslip_sym.closed_form import derive as derive_form
    from stickslip_sym.oscillator import Oscillator
    from stickslip_sym.values import exact

    bound = _law(law).typical(**_assignments(parameter or []))
    given = {"V": speed, "N": force, "m": mass, "k": stiffness}
    scene = crosscheck.SCENE | {name: _once(name, values) for name, values in given.items() if values}
    Oscillator(**{name: float(exact(value, name)) for name, value in scene.items()})  # refuse a bad scene early
    form = derive_form(bound, criterion)
    if latex is not None:
        content = f"% {form!r}\n\\begin{{equation}}\n  {form.latex()}\n\\end{{equation}}\n"
        files.write_text(latex, content + ("\n" + form.derivation.latex() if steps else ""))
    typer.echo(f"mu(v) = {printing.text(bound.expr)}")
    typer.echo(f"\n{form!r}\n\n  c = {printing.text(form.expr)}\n\n{form.gate.evidence}")
    if steps:
        typer.echo(f"\n{form.derivation.text()}")
    if bound.missing:
        names = ", ".join(bound.missing)
        typer.echo(f"\nno value for {names}: give -p {bound.missing[0]}=... for a table of values", err=True)
        return
    typer.echo(f"\n{crosscheck.report(crosscheck.crosscheck(form, scene))}")


def _law(text: str) -> Any:
    """Read a law: the name of one in the catalogue, or a formula."""
    from stickslip_sym.friction import FrictionLaw
    from stickslip_sym.laws import find
    from stickslip_sym.parsing import NAME

    return find(text) if NAME.fullmatch(text) else FrictionLaw(text)


def _assignments(texts: list[str]) -> dict[str, str]:
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise InputError(f"{text!r} is not NAME=VALUE; write for example -p alpha=3")
        if name in values:
            raise InputError(f"{name} is given twice, as {values[name]} and {value}; give it once")
        values[name] = value
    return values


def _once(name: str, values: list[str]) -> str:
    if len(values) > 1:
        raise InputError(f"{name} is given twice, as {' and '.join(values)}; give it once")
    return values[0]


def main() -> None:
    """Run the command line; errors go to stderr in a line or two, and decide the exit code."""
    try:
        sys.exit(typer.main.get_command(app).main(prog_name="stickslip", standalone_mode=False))
    except StickSlipError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(BAD_INPUT if isinstance(error, InputError) else NOT_FOUND)
    except Exception as error:
        # What typer raises for a wrong command line differs between its versions in class, not in this.
        if not hasattr(error, "format_message"):
            raise
        typer.echo(f"error: {error.format_message()} See: stickslip --help", err=True)
        sys.exit(BAD_INPUT)

"""The command line, ``stickslip``."""

import errno
import os
import sys
from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer

from stickslip_sym.errors import InputError, StickSlipError

# Everything that needs SymPy is imported by the command that uses it: help must come at once.

app = typer.Typer(
    name="stickslip",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

BAD_INPUT, NOT_FOUND, INTERRUPTED = 2, 1, 130
LARGEST = 10**20  # of a number in SI units, and its inverse the smallest: the table needs time and doubles
T = TypeVar("T")


@app.callback(invoke_without_command=True)
def start(context: typer.Context) -> None:
    """How much damping does a mass on a moving belt need so that it does not stick and slip?"""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


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
    criterion: Annotated[
        list[str] | None,
        typer.Option("--criterion", metavar="NAME", help="least_squares (default), harmonic or equilibrium."),
    ] = None,
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
        list[Path] | None, typer.Option("--latex", metavar="FILE", help="Write the formula as LaTeX.")
    ] = None,
) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive exponential -p alpha=3 -V 0.5 --steps
    """
    from stickslip_sym import crosscheck, files, printing
    from stickslip_sym.closed_form import derive as derive_form
    from stickslip_sym.oscillator import Oscillator
    from stickslip_sym.values import exact

    chosen = _once("criterion", criterion or ["least_squares"])
    file = _once("latex", latex) if latex else None
    bound = _law(law).typical(**_assignments(parameter or []))
    given = {"V": speed, "N": force, "m": mass, "k": stiffness}
    scene = crosscheck.SCENE | {name: _once(name, values) for name, values in given.items() if values}
    # Refuse what the table cannot be computed for before anything is derived or written.
    numbers = {name: exact(value, name) for name, value in scene.items()}
    for name, value in (numbers | bound.values).items():
        _check_size(name, value)
    Oscillator(**{name: float(value) for name, value in numbers.items()})
    form = derive_form(bound, chosen)
    if file is not None:
        content = f"% {form!r}\n\\begin{{equation}}\n  {form.latex()}\n\\end{{equation}}\n"
        files.write_text(file, content + ("\n" + form.derivation.latex() if steps else ""))
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


def _once(name: str, values: list[T]) -> T:
    if len(values) > 1:
        raise InputError(f"{name} is given twice, as {' and '.join(map(str, values))}; give it once")
    return values[0]


def _check_size(name: str, value: Any) -> None:
    size = abs(value)
    if size == 0 or 1 <= size * LARGEST <= LARGEST**2:
        return
    if size > 1:
        reason = "beyond what double precision can hold" if float(size) == float("inf") else "too large"
    else:
        reason = "below what double precision can hold" if float(size) == 0 else "too small"
    raise InputError(f"{name} is {reason}; give a size from {1 / LARGEST:g} to {LARGEST:g} in SI units")


def main() -> None:
    """Run the command line; errors go to stderr in a line or two, and decide the exit code."""
    try:
        sys.exit(typer.main.get_command(app).main(prog_name="stickslip", standalone_mode=False))
    except StickSlipError as error:
        typer.echo(f"error: {error}", err=True)
        sys.exit(BAD_INPUT if isinstance(error, InputError) else NOT_FOUND)
    except typer.Abort:
        sys.exit(INTERRUPTED)
    except OSError as error:
        _drop_output()
        if error.errno != errno.EPIPE:  # a reader that has read enough is no error
            typer.echo(f"error: cannot write the output: {error.strerror or error}", err=True)
        sys.exit(NOT_FOUND)
    except Exception as error:
        # What typer raises for a wrong command line differs between its versions in class, not in this.
        if not hasattr(error, "format_message"):
            raise
        typer.echo(f"error: {error.format_message()} See: stickslip --help", err=True)
        sys.exit(BAD_INPUT)


def _drop_output() -> None:
    """Send what is still buffered nowhere; Python would try again at exit, and complain."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)

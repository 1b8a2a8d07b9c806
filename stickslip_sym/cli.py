"""The command line, ``stickslip``."""

import errno
import os
import sys

import typer

# Everything that needs SymPy is imported by the command that uses it: help must come at once.
from stickslip_sym.cli_damping import damping
from stickslip_sym.cli_derive import derive
from stickslip_sym.cli_laws import laws
from stickslip_sym.cli_map import motion_map
from stickslip_sym.cli_simulate import simulate
from stickslip_sym.cli_tradeoff import tradeoff
from stickslip_sym.errors import InputError, StickSlipError

app = typer.Typer(
    name="stickslip",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

BAD_INPUT, NOT_FOUND, INTERRUPTED = 2, 1, 130


@app.callback(invoke_without_command=True)
def start(context: typer.Context) -> None:
    """How much damping does a mass on a moving belt need so that it does not stick and slip?"""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


app.command()(laws)
app.command()(derive)
app.command()(damping)
app.command()(simulate)
app.command("map")(motion_map)
app.command()(tradeoff)


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

"""The command line, ``stickslip``."""

import errno
import gc
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Annotated, Any

import typer

from stickslip_sym.cli.critical import critical
from stickslip_sym.cli.damping import damping
from stickslip_sym.cli.derive import derive
from stickslip_sym.cli.export import export
from stickslip_sym.cli.fit import fit
from stickslip_sym.cli.laws import laws
from stickslip_sym.cli.map import motion_map
from stickslip_sym.cli.shared.options import spread_out
from stickslip_sym.cli.shared.reading import Command, Commands
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.cli.simulate import simulate
from stickslip_sym.cli.study import study
from stickslip_sym.cli.tradeoff import tradeoff
from stickslip_sym.core.errors import InputError, InputWarning, StickSlipError

# Everything that needs SymPy is imported by the command that uses it: help must come at once.
from stickslip_sym.core.version import __version__

app = typer.Typer(name="stickslip", cls=Commands, rich_markup_mode=None, pretty_exceptions_enable=False)

_RARELY = 50_000, 20, 20  # thresholds of the garbage collector: of what an import makes, nothing is garbage
BAD_INPUT, NOT_FOUND, INTERRUPTED = 2, 1, 130


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"stickslip_sym {__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True)
def start(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """How much damping does a mass on a moving belt need so that it does not stick and slip?

    Example: stickslip damping exponential -V 0.5 -N 9.81
    """
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


COMMANDS: dict[str, Callable[..., None]] = {
    "laws": laws,
    "derive": derive,
    "fit": fit,
    "damping": damping,
    "critical": critical,
    "simulate": simulate,
    "map": motion_map,
    "study": study,
    "tradeoff": tradeoff,
    "export": export,
}
for name, command in COMMANDS.items():
    app.command(name, cls=Command)(spread_out(command))


def main() -> None:
    """Run the command line; errors go to stderr in a line or two, and decide the exit code."""
    gc.set_threshold(*_RARELY)
    with _warnings_in_a_line():
        _run()


@contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Print the package's own warnings to stderr, each once."""
    printed: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if not issubclass(category, InputWarning):
            others(message, category, *place, **more)
        elif (text := in_options(str(message))) not in printed:
            printed.add(text)
            typer.echo(f"warning: {text}", err=True)

    with warnings.catch_warnings():
        others, warnings.showwarning = warnings.showwarning, show
        warnings.simplefilter("always", InputWarning)
        yield


def _run() -> None:
    try:
        sys.exit(typer.main.get_command(app).main(prog_name="stickslip", standalone_mode=False))
    except StickSlipError as error:
        typer.echo(f"error: {in_options(str(error))}", err=True)
        sys.exit(BAD_INPUT if isinstance(error, InputError) else NOT_FOUND)
    except typer.Abort:
        sys.exit(INTERRUPTED)
    except OSError as error:
        _drop_output()
        if error.errno != errno.EPIPE:  # a reader that has read enough is no error
            typer.echo(f"error: cannot write the output: {error.strerror or error}", err=True)
        sys.exit(NOT_FOUND)
    # What typer raises for a wrong command line is of a class that its versions keep in different places; all of
    # them have this method, and what has not is raised again, as the fault in the program that it is.
    except Exception as error:
        if not hasattr(error, "format_message"):
            raise
        typer.echo(f"error: {_explained(error)}", err=True)
        sys.exit(BAD_INPUT)


def _explained(error: Any) -> str:
    """Return the message of a wrong command line as sentences, the last one where to look."""
    message = error.format_message()
    context = getattr(error, "ctx", None)
    options = [name for option in (context.command.params if context else []) for name in option.opts]
    other_case = getattr(error, "option_name", "").swapcase()
    if not message.endswith(("?", ".", ")")):
        message += "."
    if other_case in options:
        message += f" Did you mean {other_case}?"
    return f"{message} See: {context.command_path if context else 'stickslip'} --help"


def _drop_output() -> None:
    """Send what is still buffered nowhere; Python would try again at exit, and complain."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)

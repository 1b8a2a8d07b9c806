"""The command line, ``stickslip``."""

import ast
import errno
import importlib
import os
import signal
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click
from click.shell_completion import CompletionItem

from stickslip_sym.cli.exit_codes import BAD_INPUT, NO_RESULT, SIGNALLED
from stickslip_sym.cli.wording import option_wording
from stickslip_sym.core.errors import InputError, InputWarning, StickSlipError
from stickslip_sym.core.foreign import printable
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.remedies import worded
from stickslip_sym.core.version import __version__

COMMANDS = (
    "laws",
    "derive",
    "read",
    "fit",
    "damping",
    "critical",
    "simulate",
    "map",
    "study",
    "tradeoff",
    "export",
)


class Program(click.Group):
    """The commands, each imported when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order of use."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, name: str) -> click.Command:
        """Return a command by its name.

        Raises `click.UsageError` if there is none.
        """
        if name not in COMMANDS:
            raise click.UsageError(f"No such command {name!r}{suggestion(name, list(COMMANDS))}.", ctx)
        command: click.Command = importlib.import_module(f"stickslip_sym.cli.{name}").run
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands with their summaries, which are read without loading the commands."""
        width = formatter.width - 6 - max(map(len, COMMANDS))
        with formatter.section("Commands"):
            formatter.write_dl([(name, _summary(name, width)) for name in COMMANDS])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the commands and options that begin so, without loading a command."""
        begun = [name for name in COMMANDS if name.startswith(incomplete)]
        options = []
        if incomplete.startswith("-"):
            options = click.Command.shell_complete(self, ctx, incomplete)
        return [CompletionItem(name, help=_summary(name)) for name in begun] + options

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; an error goes to stderr in a line or two, and decides the exit code."""
        with worded(lambda remedy: option_wording(remedy, ctx)):
            try:
                return super().invoke(ctx)
            except StickSlipError as error:
                code = BAD_INPUT if isinstance(error, InputError) else NO_RESULT
                return _failed(ctx, ctx.invoked_subcommand, type(error).__name__, str(error), code)


def _summary(name: str, width: int = 80) -> str:
    """Return the first sentence of a command's docstring."""
    module = ast.parse(Path(__file__).with_name(f"{name}.py").read_text(encoding="utf-8"))
    functions = (node for node in module.body if isinstance(node, ast.FunctionDef) and node.name == "run")
    return click.Command(name, help=ast.get_docstring(next(functions))).get_short_help_str(width)


@click.group("stickslip", cls=Program, invoke_without_command=True)
@click.version_option(__version__, message="stickslip_sym %(version)s")
@click.pass_context
def program(context: click.Context) -> None:
    """How much damping does a mass on a moving belt need so that it does not stick and slip?

    Example: stickslip damping exponential -V 0.5 -N 9.81

    Completion in bash: eval "$(_STICKSLIP_COMPLETE=bash_source stickslip)"; zsh and fish likewise.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


def main() -> None:
    """Run the command line; errors go to stderr in a line or two, and decide the exit code."""
    with _warnings_in_a_line():
        sys.exit(_run_command())


def _run_command() -> int:
    try:
        code = program.main(prog_name="stickslip", standalone_mode=False)
        return code if isinstance(code, int) else 0
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return SIGNALLED + signal.SIGINT
    except click.ClickException as error:
        context = getattr(error, "ctx", None)
        return _failed(context, context and context.info_name, "InputError", _explained(error), BAD_INPUT)
    except OSError as error:
        # The rest of the buffer goes nowhere: Python would try again at its end, and complain.
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
        if error.errno != errno.EPIPE:  # a reader that has read enough is no error
            click.echo(f"error: cannot write the output: {error.strerror or error}", err=True)
        return NO_RESULT


def _failed(context: click.Context | None, command: str | None, kind: str, message: str, code: int) -> int:
    """Print an error on stderr, as JSON too where that was asked for and not printed; return the exit code."""
    from stickslip_sym.cli.output import PRINTED, echo_json

    click.echo(printable(f"error: {message}", lines=True), err=True)
    if "--json" in sys.argv[1:] and (context is None or PRINTED not in context.find_root().meta):
        echo_json(command or "stickslip", error={"type": kind, "message": message, "exit_code": code})
    return code


def _explained(error: click.ClickException) -> str:
    """Return the message of a wrong command line as sentences, the last one where to look."""
    message = error.format_message()
    context = getattr(error, "ctx", None)
    if isinstance(error, click.NoSuchOption) and context is not None:
        message = message.removesuffix(".") + _other_case(error.option_name, context.command)
    stop = "" if message.endswith(("?", ".")) else "."
    return f"{message}{stop} See: {context.command_path if context else 'stickslip'} --help"


def _other_case(name: str, command: click.Command) -> str:
    """Return '; did you mean -V, ...?' where an option differs from a wrong one by its case only."""
    for one in command.params:
        if isinstance(one, click.Option) and name.swapcase() in one.opts:
            what = (one.help or "").partition(",")[0].rstrip(".").lower()
            return f"; did you mean {name.swapcase()}, the {what.partition(' (')[0]}?"
    return ""


@contextmanager
def _warnings_in_a_line() -> Iterator[None]:
    """Print the package's own warnings to stderr, each once."""
    printed: set[str] = set()

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if not issubclass(category, InputWarning):
            others(message, category, *place, **more)
        elif (text := str(message)) not in printed:
            printed.add(text)
            click.echo(printable(f"warning: {text}", lines=True), err=True)

    with warnings.catch_warnings():
        others = warnings.showwarning
        warnings.showwarning = show
        warnings.simplefilter("always", InputWarning)
        yield

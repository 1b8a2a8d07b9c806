"""How the command line words what a message advises: with options, of the command that was given or of another."""

import shlex
from collections.abc import Mapping

import click

from stickslip_sym.core.remedies import AnySign, Argument, Call, Name, ParameterValues, Reading, Remedy


def option_wording(remedy: Remedy, context: click.Context) -> str:
    """Return what to give as a user of the command line gives it; `context` is that of the program."""
    match remedy:
        case Name(name):
            option = _option(name)
            if len(name) > 1 and option in _options(context, context.invoked_subcommand):
                return option
            return name
        case Argument(name, dict(entries)):  # one option for each
            return " ".join(_given(context, name.removesuffix("s"), _pair(*entry)) for entry in entries.items())
        case Argument(name, tuple(ends)):
            return _given(context, name, ":".join(map(str.upper, ends)))
        case Argument(name, value):
            return _given(context, name, "" if value is True else _quoted_for_shell(value))
        case ParameterValues(values):
            return " ".join(f"-p {_pair(*entry)}" for entry in values.items())
        case AnySign(parameter):
            return f"write the formula with -{parameter}, and give a positive value"
        case Reading(file, arguments):
            return shlex.join(["stickslip", "read", file, *_options_of_reading(arguments)])
        case Call():
            return f"stickslip {remedy.command}"
    raise TypeError(f"{remedy!r} is worded nowhere")


def _options_of_reading(arguments: Mapping[str, object]) -> list[str]:
    """Return the options that read a file of measurements so: one for each column, and for each block."""
    options = list[str]()
    for name, value in arguments.items():
        if isinstance(value, dict):
            for quantity, column in value.items():
                options += [_option(name.removesuffix("s")), f"{quantity}={column}"]
        elif value is True:
            options.append(_option(name))
        else:
            for each in value if isinstance(value, tuple) else (value,):
                options += [_option(name), str(each)]
    return options


def _given(context: click.Context, name: str, value: str) -> str:
    """Return an option with its value, behind another command where the present one has no such option."""
    option = _option(name)
    program = context.command
    present = context.invoked_subcommand
    commands = program.list_commands(context) if isinstance(program, click.Group) else []
    command = next((each for each in (present, *commands) if option in _options(context, each)), present)
    return " ".join(filter(None, ("" if command == present else f"stickslip {command}", option, value)))


def _options(context: click.Context, command: str | None) -> set[str]:
    if command is None or not isinstance(context.command, click.Group):
        return set()
    given = context.command.get_command(context, command)
    if given is None:
        return set()
    return {text for parameter in given.params for text in parameter.opts}


def _option(name: str) -> str:
    if len(name) == 1:
        return f"-{name}"
    return f"--{name.replace('_', '-')}"


def _pair(name: str, value: object) -> str:
    return f"{name}={_quoted_for_shell(value)}"


def _quoted_for_shell(value: object) -> str:
    text = "..." if value is ... else str(value)
    return f'"{text}"' if " " in text else text

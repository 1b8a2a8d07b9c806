"""What a message advises, as data: Python words it with arguments, the command line with options.

A message has a remedy among its parts, as ``InputError("too many points: ", Argument("bins", 60))`` has one;
`worded` says how remedies read within a block, as Python without it.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass


class Remedy:
    """What a user can give or do; its text is that of the interface in use."""

    def __str__(self) -> str:
        return _wording(self)


@dataclass(frozen=True)
class Argument(Remedy):
    """An argument of a function, with an example of its value; of a mapping, with examples of its entries."""

    name: str
    value: object = ...


@dataclass(frozen=True)
class Name(Remedy):
    """The argument that a message is about, by its name alone."""

    name: str


@dataclass(frozen=True)
class ParameterValues(Remedy):
    """Values of parameters of the law, with examples."""

    values: Mapping[str, object]

    @classmethod
    def of(cls, *names: str) -> "ParameterValues":
        """Return values of parameters that are left open."""
        return cls(dict.fromkeys(names, ...))


@dataclass(frozen=True)
class AnySign(Remedy):
    """A parameter of the law that may be negative."""

    parameter: str


@dataclass(frozen=True)
class Reading(Remedy):
    """The whole call that reads a file of measurements, with its arguments."""

    file: str
    arguments: Mapping[str, object]

    @classmethod
    def of(cls, file: str, **arguments: object) -> "Reading":
        """Return the call that reads a file, whose name may be quoted already."""
        return cls(file[1:-1] if file[:1] in ("'", '"') and file[-1:] == file[:1] else file, arguments)


@dataclass(frozen=True)
class Call(Remedy):
    """A function that does what was asked for, and the command that does."""

    function: str
    command: str


def python_wording(remedy: Remedy) -> str:
    """Return a remedy as a user of Python writes it."""
    match remedy:
        case Argument(name, Mapping() as entries):
            shown = (f"{key!r}: {'...' if value is ... else repr(value)}" for key, value in entries.items())
            return f"{name}={{{', '.join(shown)}}}"
        case Argument(name, tuple(ends)):
            return f"{name}=({', '.join(ends)})"
        case Argument(name, str(text)):
            return f'{name}="{text}"'
        case Argument(name, value):
            return f"{name}={'...' if value is ... else value}"
        case ParameterValues(values):
            shown = (f"{name}={'...' if value is ... else value}" for name, value in values.items())
            return f"law.bind({', '.join(shown)})"
        case AnySign(parameter):
            return f"declare it with Parameter({parameter!r}, positive=False)"
        case Reading(file, arguments):
            more = "".join(f", {name}={value!r}" for name, value in arguments.items())
            return f"read_measurements({file!r}{more})"
        case Call(function):
            return function
        case Name(name):
            return name
    raise TypeError(f"{remedy!r} is worded nowhere")


_wording: Callable[[Remedy], str] = python_wording


@contextmanager
def worded(words: Callable[[Remedy], str]) -> Iterator[None]:
    """Let every remedy read as a function words it, in all threads; the interface of a program does so once."""
    global _wording
    before = _wording
    _wording = words
    try:
        yield
    finally:
        _wording = before

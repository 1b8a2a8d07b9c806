"""What the commands read from their arguments: values, sizes, files. Each refusal says what to write."""

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from typer.core import TyperCommand, TyperGroup

from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from rich.progress import ProgressColumn

    from stickslip_sym.core.aliases import Rational
    from stickslip_sym.criteria.criterion import Criterion

__all__ = [
    "Command", "Commands", "assignments", "check_size", "chosen_criteria", "progress_bar", "read_exact",
    "read_numbers", "require_new", "require_writable",
]  # fmt: skip

LARGEST = 10**20  # of a number in SI units, and its inverse the smallest: the table needs time and doubles


class Commands(TyperGroup):
    """The program, with options of its own before the command."""

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options, that for help too, so that their texts and defaults are taken as they are."""
        return _as_they_are(super().get_params(ctx))


class Command(TyperCommand):
    """A command that takes an option once. Otherwise the last value would win without a word."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse options that are given twice, but for flags and those that may be repeated."""
        _, _, order = self.make_parser(ctx).parse_args(args=list(args))
        for option in order:
            single = not (getattr(option, "is_flag", True) or option.multiple)
            if single and order.count(option) > 1:
                raise InputError(f"{option.opts[0]} is given twice; give it once")
        return super().parse_args(ctx, args)

    def get_params(self, ctx: Any) -> list[Any]:
        """Return the options, as `Commands` does."""
        return _as_they_are(super().get_params(ctx))


def _as_they_are(params: list[Any]) -> list[Any]:
    """Let texts and defaults pass: to read even these typer imports pydantic, which takes a tenth of a second."""

    def passing(param: Any, declared: object) -> Callable[[Any, Any], Any]:
        read = param.process_value

        def process(context: Any, value: Any) -> Any:
            several = declared == list[str] and isinstance(value, list | tuple)
            is_text = all(isinstance(one, str) for one in value) if several else declared is str
            if value is not None and value is not param.default and not is_text:
                return read(context, value)
            return param.callback(context, param, value) if param.callback else value

        return process

    for param in params:
        known = getattr(param, "type_descriptor", None)  # typer 0.29 has it, and reads by pydantic
        if known is not None and not param.required and "process_value" not in vars(param):
            param.process_value = passing(param, known.annotation)
    return params


def assignments(texts: Sequence[str], example: str = "-p alpha=3") -> dict[str, str]:
    """Read NAME=VALUE texts; the example is for the refusal."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise InputError(f"{text!r} is not NAME=VALUE; write for example {example}")
        if name in values:
            raise InputError(f"{name} is given twice, as {values[name]} and {value}; give it once")
        values[name] = value
    return values


def chosen_criteria(name: str) -> "list[Criterion]":
    """Return the criterion of a name, or every one for "all"."""
    from stickslip_sym import criteria

    return list(criteria.catalogue.values()) if name == "all" else [criteria.find(name)]


def read_exact(given: Mapping[str, str | None]) -> "dict[str, Rational]":
    """Read numbers of a possible size, exactly; those that were not given are left out."""
    from stickslip_sym.core.numbers import exact

    return {name: exact(number, name) for name, number in _read(given).items()}


def read_numbers(given: Mapping[str, str | None]) -> dict[str, float]:
    """Read numbers as floats, as `read_exact` does."""
    return {name: float(value) for name, value in _read(given).items()}


def _read(given: Mapping[str, str | None]) -> dict[str, Fraction]:
    from stickslip_sym.core.numbers import fraction

    numbers = {name: fraction(text, name) for name, text in given.items() if text is not None}
    for name, value in numbers.items():
        check_size(name, value)
    return numbers


def check_size(name: str, value: "Rational | Fraction") -> None:
    """Refuse a number of a size that no scene has."""
    size = abs(value)
    if size == 0 or 1 <= size * LARGEST <= LARGEST**2:
        return
    if size > 1:
        reason = "beyond what double precision can hold" if float(size) == float("inf") else "too large"
    else:
        reason = "below what double precision can hold" if float(size) == 0 else "too small"
    raise InputError(f"{name} is {reason}; give a size from {1 / LARGEST:g} to {LARGEST:g} in SI units")


def require_new(path: Path | None, option: str, overwrite: bool) -> None:
    """Refuse to replace a file without a word: it may hold what was measured, and was meant to be read."""
    from stickslip_sym.output.files import is_kept

    if path is not None and not overwrite and is_kept(path):
        raise InputError(
            f"{str(path)!r} exists, and {option} writes: name another file, or add --overwrite to replace it; to "
            "read measured points from it, give --from-csv instead"
        )


def require_writable(*paths: Path | None, plot: Path | None = None) -> None:
    """Refuse a file that cannot be written, before a long computation rather than after it."""
    for path in (*paths, plot):
        if path is not None and not path.parent.is_dir():
            raise InputError(f"cannot write {str(path)!r}: there is no folder {str(path.parent)!r}; make it first")
    if plot is not None:
        from stickslip_sym.output.drawing import require_matplotlib

        require_matplotlib()


@contextmanager
def progress_bar(*columns: "ProgressColumn") -> Iterator[Callable[..., None]]:
    """Show columns of rich on a terminal, and yield what updates them; elsewhere show nothing."""
    from rich.console import Console
    from rich.progress import Progress

    console = Console(stderr=True)
    # Rich takes FORCE_COLOR for a terminal, and would draw into a file.
    drawn = console.is_terminal and sys.stderr.isatty()
    with Progress(*columns, console=console, transient=True, disable=not drawn) as shown:
        yield partial(shown.update, shown.add_task("reading the law", total=None))

"""What the commands read from their arguments: laws, values and sizes. Each refusal says what to write."""

from pathlib import Path
from typing import Annotated, Any, TypeVar

import typer
from typer.core import TyperCommand

from stickslip_sym.cli_names import complete_criterion, complete_law
from stickslip_sym.errors import InputError

__all__ = ["Command", "CriterionName", "LawName", "Values", "assignments", "check_size", "once", "read_law"]

T = TypeVar("T")
LawName = Annotated[
    str,
    typer.Argument(
        metavar="LAW",
        help="Name of a law (see: stickslip laws), or a formula in v.",
        autocompletion=complete_law,
    ),
]
CriterionName = Annotated[
    str,
    typer.Option(
        "--criterion",
        metavar="NAME",
        help="least_squares, harmonic or equilibrium.",
        autocompletion=complete_criterion,
    ),
]
Values = Annotated[
    list[str] | None,
    typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Value of a parameter; may be repeated."),
]
LARGEST = 10**20  # of a number in SI units, and its inverse the smallest: the table needs time and doubles


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


def read_law(text: str | None, csv: Path | None, *, extrapolate: bool) -> Any:
    """Return a law: of the catalogue by its name, from a formula, or through the points of a CSV file."""
    from stickslip_sym.friction import FrictionLaw
    from stickslip_sym.laws import find
    from stickslip_sym.parsing import NAME

    if csv is not None:
        if text is not None:
            raise InputError(f"the law is given twice, as {text!r} and by --from-csv; give it once")
        return FrictionLaw.from_csv(csv, extrapolate=extrapolate)
    if extrapolate:
        raise InputError("--extrapolate belongs to --from-csv: a formula holds at all speeds")
    if text is None:
        raise InputError("no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE")
    return find(text) if NAME.fullmatch(text) else FrictionLaw(text)


def assignments(texts: list[str]) -> dict[str, str]:
    """Read NAME=VALUE texts."""
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


def once(name: str, values: list[T] | None) -> T | None:
    """Return the one value of an option, or None if it was not given."""
    if not values:
        return None
    if len(values) > 1:
        raise InputError(f"{name} is given twice, as {' and '.join(map(str, values))}; give it once")
    return values[0]


def check_size(name: str, value: Any) -> None:
    """Refuse a number of a size that no scene has."""
    size = abs(value)
    if size == 0 or 1 <= size * LARGEST <= LARGEST**2:
        return
    if size > 1:
        reason = "beyond what double precision can hold" if float(size) == float("inf") else "too large"
    else:
        reason = "below what double precision can hold" if float(size) == 0 else "too small"
    raise InputError(f"{name} is {reason}; give a size from {1 / LARGEST:g} to {LARGEST:g} in SI units")

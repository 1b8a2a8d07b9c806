"""The law and the operating point that options make, and the numbers in them."""

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip_sym.cli.numbers import read_number
from stickslip_sym.cli.options import Given
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import PAPER

if TYPE_CHECKING:
    from stickslip_sym.criteria.criterion import Criterion
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.measured.measurements import Measurements

__all__ = [
    "UNITS", "Point", "assignments", "criteria_of", "law_described", "measurements", "point", "points",
    "reading_of",
]  # fmt: skip

UNITS = {"V": "m/s", "N": "N", "m": "kg", "k": "N/m", "c": "kg/s"}


@dataclass(frozen=True)
class Point:
    """A law and an operating point as they were given, and what was left to defaults.

    Attributes
    ----------
    law : FrictionLaw
        With typical values where none was given.
    typical : tuple of str
        Names of these.
    texts : dict of str to str
        V, N, m and k, and c where the command takes it, perhaps with standard errors.
    defaults : tuple of str
        Those that were not given.
    file : Path or None
        Where it was read.
    """

    law: "FrictionLaw"
    typical: tuple[str, ...]
    texts: dict[str, str]
    defaults: tuple[str, ...]
    file: Path | None = None

    @property
    def numbers(self) -> dict[str, float]:
        """The quantities without their errors."""
        from stickslip_sym.core.uncertain import split

        return {name: read_number(split(text, name)[0], name) for name, text in self.texts.items()}

    def exact(self, command: str) -> "Point":
        """Return the point, for a command that computes without standard errors.

        Raises `InputError` if anything has one.
        """
        for name, text in self.texts.items():
            if not _is_number(text, name):
                raise InputError(
                    f"{command} takes no standard errors: leave +/- out of -{name}; damping takes them"
                )
        if self.law.uncertain:
            name = next(iter(self.law.uncertain))
            raise InputError(f"{command} takes no standard errors: leave +/- out of -p {name}; damping takes them")
        return self

    def __str__(self) -> str:
        law, lines = self.law, []
        shown = law.text if law.curve is None else str(law.curve)
        lines.append(f"{law.name}: mu(v) = {shown}" if law.name else f"mu(v) = {shown}")
        parameters = []
        for name, value in law.values.items():
            unit = law.parameters[name].unit
            given = law.uncertain.get(name, f"{float(value):.12g}")
            mark = " (typical)" if name in self.typical else ""
            parameters.append(f"{name} = {given}{'' if unit in (None, '1') else f' {unit}'}{mark}")
        parameters += [f"{name} = ?" for name in law.missing]
        if parameters:
            lines.append(", ".join(parameters))
        marks = {name: " (default)" if name in self.defaults else "" for name in self.texts}
        lines.append(", ".join(f"{name} = {text} {UNITS[name]}{marks[name]}" for name, text in self.texts.items()))
        return "\n".join(lines)


def points(
    given: Given, *, c: str | None = None, without: Sequence[str] = (), law: "FrictionLaw | None" = None
) -> list[Point]:
    """Read the law and the operating point, one for each ``--point``, which options on the command line override.

    A file is for several commands: what it says beyond what this one needs is not read.

    - `c`: the default of the damping, for commands that have it.
    - `without`: quantities that are not given here, as they are sought for or an axis.
    - `law`: one that is fitted, so that none is read.
    """
    wanted: dict[str, str | None] = {**PAPER, "c": c}
    files = given["point"]
    for name in without:
        wanted.pop(name, None)
    found = []
    for file in files or (None,):
        content = {} if file is None else _toml(file)
        texts, defaults = {}, []
        for name, default in wanted.items():
            text = given[name]
            text = content.pop(name, None) if text is None else text
            if text is None and default is not None:
                defaults.append(name)
            if (text := default if text is None else text) is not None:
                texts[name] = str(text)
        friction = law
        typical: tuple[str, ...] = ()
        if friction is None:
            friction = law_described(given.__getitem__, given["law"] or content.pop("law", None))
            values = {name: str(value) for name, value in content.pop("parameters", {}).items()}
            values |= assignments(given["parameter"])
            friction = friction.typical(**values)
            typical = tuple(name for name in friction.values if name not in values)
        found.append(Point(friction, typical, texts, tuple(defaults), file))
        _ = found[-1].numbers  # refuses what is no number
    return found


def point(given: Given, **more: Any) -> Point:
    """Read the law and the one operating point of a command."""
    if len(given["point"]) > 1:
        raise InputError(f"{given.command} takes one --point; damping and study take several")
    (one,) = points(given, **more)
    return one


def _toml(file: Path) -> dict[str, Any]:
    """Read a file of values; numbers stay the text that they are."""
    try:
        content = tomllib.loads(file.read_text(encoding="utf-8"), parse_float=str)
    except OSError as error:
        raise InputError(f"cannot read {str(file)!r}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(
            f"{file}: {error}; write lines such as V = 0.5, and parameters below [parameters]"
        ) from None
    if unknown := content.keys() - {"law", "parameters", *UNITS}:
        raise InputError(
            f"{file}: there is no {min(unknown)}; a point has law, {', '.join(UNITS)} and [parameters]"
        )
    if not isinstance(content.get("parameters", {}), dict):
        raise InputError(
            f"{file}: parameters are a table: write [parameters] and lines such as alpha = 3 below it"
        )
    return content


def law_described(option: Callable[[str], Any], text: str | None) -> "FrictionLaw":
    """Return a law: of the catalogue by its name, from a formula, or through the points of a file.

    - `option`: returns the value of an option by its name.

    Raises `InputError` if it is given twice or not at all.
    """
    from stickslip_sym.model.expression.parsing import NAME
    from stickslip_sym.model.law import FrictionLaw
    from stickslip_sym.model.laws import laws

    file, static = option("from_csv"), option("static")
    if file is not None:
        if text is not None:
            raise InputError(f"the law is given twice, as {text!r} and by --from-csv; give it once")
        measured = measurements(option, file)
        click.echo(measured.averaged().understood, err=True)  # beside JSON, not in it
        law = FrictionLaw.from_csv(
            measured, extrapolate=option("extrapolate"), source=option("source"), name=option("name")
        )
    elif text is None:
        raise InputError("no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE")
    elif NAME.fullmatch(text):
        law = laws.find(text)
    else:
        units = assignments(option("unit") or (), "--unit alpha=s/m")
        return FrictionLaw(text, static=static, units=units, name=option("name"), source=option("source"))
    if static is not None:
        law = law.with_static(static, units=assignments(option("unit") or (), "--unit alpha=s/m"))
    return law


def measurements(option: Callable[[str], Any], file: Path) -> "Measurements":
    """Return the measurements in a file, read as options say.

    Raises `InputError` for what is not understood.
    """
    from stickslip_sym.model.measured.measurements import read_measurements

    return read_measurements(file, **reading_of(option))


def reading_of(option: Callable[[str], Any]) -> dict[str, Any]:
    """Return how options say that a file of measurements is read, as arguments of `read_measurements`."""
    columns = assignments(option("column"), '--column mu="Friction Factor"')
    return {"columns": columns} | {
        name: option(name) for name in ("radius", "speeds", "leave_out", "keep_outliers")
    }


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


def criteria_of(name: str) -> "list[Criterion]":
    """Return the criterion of a name, or every one for "all"."""
    from stickslip_sym import criteria

    return list(criteria.catalogue.values()) if name == "all" else [criteria.find(name)]


def _is_number(text: str, name: str) -> bool:
    from stickslip_sym.core.uncertain import split

    return bool(split(text, name)[0] == text)

"""The law and the operating point that options make."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import click

import stickslip_sym as ss
from stickslip_sym.cli.options import Given, read_number
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.operating_point import PAPER
from stickslip_sym.output.files import read_bytes

_FRACTION = re.compile(r"\d+/\d+")
_LONG_FRACTION = 9  # characters: 1/2 and 981/100 stay what was typed


@dataclass(frozen=True)
class Point:
    """A law and an operating point as they were given, and what was left to defaults."""

    reported = ("law", "typical", "texts", "numbers", "defaults")

    law: ss.FrictionLaw  # with typical values where none was given
    typical: tuple[str, ...]  # names of these
    texts: dict[str, str]  # V, N, m, k, and c where the command takes it, perhaps with standard errors
    defaults: tuple[str, ...]  # those that were not given
    file: Path | None = None  # where it was read

    @property
    def numbers(self) -> dict[str, float]:
        """The quantities without their errors."""
        from stickslip_sym.core.uncertain import split

        return {name: read_number(split(text, name)[0], name) for name, text in self.texts.items()}

    def exact(self, command: str) -> Point:
        """Return the point, for a command that computes without standard errors, or refuse the first of them."""
        from stickslip_sym.core.uncertain import split

        quantities = [f"-{name}" for name, text in self.texts.items() if split(text, name)[0] != text]
        if uncertain := [*quantities, *(f"-p {name}" for name in self.law.uncertain)]:
            raise InputError(
                f"{command} takes no standard errors: leave +/- out of {uncertain[0]}; damping takes them"
            )
        return self

    def __str__(self) -> str:
        from stickslip_sym.core import symbols

        law = self.law
        parameters = list[str]()
        for name, value in law.values.items():
            unit = law.parameters[name].unit
            shown = law.uncertain.get(name, f"{float(value):.12g}")
            mark = " (typical)" if name in self.typical else ""
            parameters.append(f"{name} = {shown}{'' if unit in (None, '1') else f' {unit}'}{mark}")
        formula = f"{f'{law.name}: ' if law.name else ''}mu(v) = {law.text if law.curve is None else law.curve}"
        shown_texts = {name: _shorten_fraction(text) for name, text in self.texts.items()}
        lines = formula, ", ".join(parameters + [f"{name} = ?" for name in law.missing])
        return "\n".join(filter(None, [*lines, symbols.quantities_text(shown_texts, self.defaults)]))


def _shorten_fraction(text: str) -> str:
    """Return a quantity as it is read: a long fraction, to which a unit was converted exactly, by its digits."""
    if len(text) <= _LONG_FRACTION or not _FRACTION.fullmatch(text):
        return text
    return f"{float(Fraction(text)):.12g}"


def points(
    given: Given, *, c: str | None = None, without: Sequence[str] = (), law: ss.FrictionLaw | None = None
) -> list[Point]:
    """Read the law and the operating point, one for each ``--point``, which options on the command line override.

    A file is for several commands: what it says beyond what this one needs is not read.

    - `c`: the default of the damping, for commands that have it.
    - `without`: quantities that are not given here, as they are sought for or an axis.
    - `law`: one that is fitted, so that none is read.
    """
    from stickslip_sym.core.units import si_number

    wanted = {name: default for name, default in {**PAPER, "c": c}.items() if name not in without}
    read = []
    for file in given["point"] or (None,):
        content = {} if file is None else _toml(file)
        stated = {name: content.get(name) if given[name] is None else given[name] for name in wanted}
        defaults = {name: text for name, text in wanted.items() if stated[name] is None and text is not None}
        texts = {
            name: si_number(str(text), name) for name, text in (stated | defaults).items() if text is not None
        }
        friction = law
        typical = tuple[str, ...]()
        if friction is None:
            values = {name: str(value) for name, value in content.get("parameters", {}).items()}
            values |= given["parameter"]
            friction = law_described(given, given["law"] or content.get("law")).typical(**values)
            typical = tuple(name for name in friction.values if name not in values)
        read.append(Point(friction, typical, texts, tuple(defaults), file))
        _ = read[-1].numbers  # refuses text that is no number
    return read


def point(given: Given, **more: Any) -> Point:
    """Read the law and the one operating point of a command."""
    if len(given["point"]) > 1:
        raise InputError(f"{given.command} takes one --point; damping and study take several")
    return points(given, **more)[0]


def _toml(file: Path) -> dict[str, Any]:
    """Read a file of values; numbers stay the text that they are."""
    expected = "a point has lines such as V = 0.5, for law, V, N, m, k and c, and a table [parameters]"
    try:
        content = tomllib.loads(read_bytes(file).decode(), parse_float=str)
    except InputError as error:
        raise InputError(error, f"; {expected}") from None
    except ValueError as error:  # what is no text in UTF-8, and no TOML
        raise InputError(f"cannot read {str(file)!r}: {error}; {expected}") from None
    if unknown := content.keys() - {"law", "parameters", *"VNmkc"}:
        raise InputError(f"{file}: there is no {min(unknown)}; {expected}")
    if not isinstance(content.get("law", ""), str) or not isinstance(content.get("parameters", {}), dict):
        raise InputError(f"{file}: law is text, and parameters a table; {expected}")
    return content


def law_described(given: Given | Mapping[str, Any], text: str | None) -> ss.FrictionLaw:
    """Return a law: of the catalogue by its name, from a formula, or through the points of a file.

    Options that describe no law of this kind are not read.
    """
    from stickslip_sym.model.expression.parsing import NAME

    file = given["from_csv"]
    static = given["static"]
    if file is not None:
        if text is not None:
            raise InputError(f"the law is given twice, as {text!r} and by --from-csv; give it once")
        measured = ss.read_measurements(file, **reading_of(given))
        click.echo(f"{measured.averaged().preview()}\n", err=True)  # beside JSON, not in it
        law = ss.FrictionLaw.from_csv(
            measured, extrapolate=given["extrapolate"], source=given["source"], name=given["name"]
        )
    elif text is None:
        raise InputError("no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE")
    elif NAME.fullmatch(text):
        law = ss.laws.find(text)
    else:
        described = {name: given[name] for name in ("name", "source")}
        return ss.FrictionLaw(text, static=static, units=given["unit"], **described)
    if static is None:
        return law
    return law.with_static(static, units=given["unit"])


def reading_of(given: Given | Mapping[str, Any]) -> dict[str, Any]:
    """Return how options say that a file of measurements is read, as arguments of `read_measurements`."""
    how = {name: given[name] for name in ("radius", "speeds", "leave_out", "keep_outliers", "bins")}
    return {"columns": given["column"], "block": given["block"] or None} | how


def criteria_of(name: str) -> list[ss.Criterion]:
    """Return the criterion of a name, or every one for "all"."""
    if name == "all":
        return list(ss.criteria.catalogue.values())
    return [ss.criteria.find(name)]

"""What the commands print with ``--json``: one object, valid JSON, of a shape that stays.

    {"format": 1, "version": "0.1.0", "command": "damping", ...what the command has to say...}

A number with a unit is an object {"value": 2.5, "unit": "kg/s"}. "text" beside it is the same number with more
digits than a double holds, or exactly. "value" is null where there is no number, and "reason" says why. Times
are in "seconds", relative errors plain numbers. "format" grows when a name goes or changes its meaning; names
may be added without.
"""

import json
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import typer

from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import NoClosedForm

if TYPE_CHECKING:
    from stickslip_sym.core.uncertain import UFloat
    from stickslip_sym.formula.derivation.closed_form import ClosedForm
    from stickslip_sym.model.law import FrictionLaw

Json = dict[str, object]
"""What stands for an object of JSON."""

__all__ = ["Json", "echo", "form", "law", "missing", "number", "quantity", "values"]

FORMAT = 1
UNITS = {"V": "m/s", "N": "N", "m": "kg", "k": "N/m", "c": "kg/s"}


def echo(command: str, **content: object) -> None:
    """Print the object of a command."""
    from stickslip_sym.core.version import __version__

    head = {"format": FORMAT, "version": __version__, "command": command}
    typer.echo(json.dumps(head | content, indent=2, ensure_ascii=False, allow_nan=False))


def number(value: float | None) -> float | None:
    """Return a number as JSON can hold it: none for NaN and infinity."""
    return None if value is None or not math.isfinite(value) else float(value)


def quantity(value: float, unit: str | None, *, text: str | None = None) -> Json:
    """Return a number with its unit, and as text where that says more."""
    known: Json = {"value": number(value), "unit": unit}
    return known if text is None else known | {"text": text}


def missing(unit: str, reason: str) -> Json:
    """Return what stands for a number that there is none of."""
    return {"value": None, "unit": unit, "reason": reason}


def values(given: Mapping[str, str]) -> Json:
    """Return V, N, m and k with their units and standard errors, and as they were given."""
    from stickslip_sym.core.numbers import exact
    from stickslip_sym.core.uncertain import separated

    numbers, errors = separated(given)
    return {
        name: quantity(float(exact(number, name)), UNITS[name], text=given[name]) | _standard_error(errors, name)
        for name, number in numbers.items()
    }


def _standard_error(errors: "Mapping[str, UFloat]", name: str) -> Json:
    return {"standard_error": float(errors[name].std_dev)} if name in errors else {}


def form(found: "ClosedForm | NoClosedForm | str") -> Json:
    """Return a closed form with its verdict, or why there is none."""
    from stickslip_sym.output import printing

    if isinstance(found, NoClosedForm | str):
        return {"formula": None, "reason": in_options(str(found))}
    return {"formula": printing.text(found.expr), "unit": "kg/s", "status": found.verdict.status.value}


def law(friction: "FrictionLaw") -> Json:
    """Return a law: its name, its formula, and its parameters with their bound values."""
    from stickslip_sym.output import printing

    parameters = {
        name: {
            "value": number(float(friction.values[name])) if name in friction.values else None,
            "text": str(friction.values[name]) if name in friction.values else None,
            "typical": parameter.typical,
            "unit": parameter.unit,
            "meaning": parameter.meaning,
        }
        | _standard_error(friction.uncertain, name)
        for name, parameter in friction.parameters.items()
    }
    static = None if friction.static is None else printing.text(friction.static)
    known: Json = {"name": friction.name, "formula": friction.text, "static": static, "parameters": parameters}
    return known | {"validity": friction.validity, "source": friction.source}

"""Options that several commands share, each declared once.

A group of options is a dataclass whose fields are options; a command takes a group as one argument, and
`spread_out` gives the command line its fields.
"""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, is_dataclass
from inspect import Parameter, Signature, signature
from typing import Annotated, Any, cast

import typer
from typer.models import OptionInfo

from stickslip_sym.cli.shared.completion import complete_criterion, complete_criterion_or_all
from stickslip_sym.model.operating_point import LOW_SPEED, PAPER

__all__ = [
    "SECONDS", "AsJson", "CriteriaName", "CriterionName", "LowSpeedScene", "MaybeOscillator", "Overwrite",
    "SceneOptions", "TimeLimit", "file_option", "spread_out",
]  # fmt: skip

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]
CriterionName = Annotated[
    str,
    typer.Option(
        "--criterion",
        metavar="NAME",
        help="least_squares, harmonic or equilibrium.",
        autocompletion=complete_criterion,
    ),
]
CriteriaName = Annotated[
    str,
    typer.Option(
        "--criterion",
        metavar="NAME",
        help="least_squares, harmonic, equilibrium, or all.",
        autocompletion=complete_criterion_or_all,
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Let --csv replace a file.")]
TimeLimit = Annotated[float, typer.Option("--time-limit", metavar="S", help="Seconds for each criterion.")]
SECONDS = 120.0  # of the search for one closed form


def file_option(name: str, text: str) -> OptionInfo:
    """Return an option that takes the name of a file."""
    return cast(OptionInfo, typer.Option(name, metavar="FILE", help=text))


def _quantity(name: str, unit: str, text: str) -> OptionInfo:
    return cast(OptionInfo, typer.Option(f"-{name}", metavar=unit, help=text))


@dataclass(frozen=True)
class SceneOptions:
    """Belt speed, normal force, mass and stiffness, of the paper's scene where they are not given."""

    V: Annotated[str | None, _quantity("V", "M/S", f"Belt speed ({PAPER['V']}).")] = None
    N: Annotated[str | None, _quantity("N", "N", f"Normal force ({PAPER['N']}).")] = None
    m: Annotated[str | None, _quantity("m", "KG", f"Mass ({PAPER['m']}).")] = None
    k: Annotated[str | None, _quantity("k", "N/M", f"Stiffness ({PAPER['k']}).")] = None

    def texts(self, otherwise: Mapping[str, str] = PAPER) -> dict[str, str]:
        """Return the quantities as they were given, and others where they were not."""
        return {**otherwise, **{name: text for name, text in asdict(self).items() if text is not None}}


@dataclass(frozen=True)
class MaybeOscillator(SceneOptions):
    """A scene that may do without mass and stiffness."""

    m: Annotated[str | None, _quantity("m", "KG", "Mass; goes with -k.")] = None
    k: Annotated[str | None, _quantity("k", "N/M", "Stiffness; goes with -m.")] = None


@dataclass(frozen=True)
class LowSpeedScene(SceneOptions):
    """A scene at a low belt speed for criteria, to which mass and stiffness do not matter."""

    V: Annotated[
        str | None, _quantity("V", "M/S", f"Belt speed ({LOW_SPEED} for a criterion, else {PAPER['V']}).")
    ] = None
    m: Annotated[str | None, _quantity("m", "KG", f"Mass, not for a criterion ({PAPER['m']}).")] = None
    k: Annotated[str | None, _quantity("k", "N/M", f"Stiffness, not for a criterion ({PAPER['k']}).")] = None


def spread_out(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that takes the fields of its groups of options one by one."""
    own = signature(command).parameters.values()
    groups: dict[str, Any] = {
        parameter.name: parameter.annotation for parameter in own if is_dataclass(parameter.annotation)
    }

    def run(**given: object) -> None:
        for name, group in groups.items():
            given[name] = group(**{field.name: given.pop(field.name) for field in fields(group)})
        command(**given)

    options = []
    for parameter in own:
        entries = [parameter] if parameter.name not in groups else [
            Parameter(field.name, Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
            for field in fields(groups[parameter.name])
        ]  # fmt: skip
        options += [entry.replace(kind=Parameter.KEYWORD_ONLY) for entry in entries]
    run.__name__, run.__doc__ = command.__name__, command.__doc__
    run.__signature__ = Signature(options)  # type: ignore[attr-defined]  # typer makes the options of it
    return run

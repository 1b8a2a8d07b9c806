"""``stickslip laws``: the catalogue, or one law of it."""

from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.derive import Found, derived
from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.completion import complete_law
from stickslip_sym.cli.shared.options import AsJson
from stickslip_sym.cli.shared.reading import chosen_criteria
from stickslip_sym.core.errors import NoClosedForm

if TYPE_CHECKING:
    from stickslip_sym.model.law import FrictionLaw, Parameter

__all__ = ["laws"]


def laws(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="A law of the catalogue, in full.", autocompletion=complete_law),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the friction laws of the catalogue, or tell all about one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.model.laws import catalogue, find
    from stickslip_sym.output.tables import table

    if name is not None:
        law = find(name)
        forms = {criterion.name: derived(law, criterion) for criterion in chosen_criteria("all")}
        if as_json:
            criteria = {criterion: json_output.form(form) for criterion, form in forms.items()}
            json_output.echo("laws", laws=[json_output.law(law) | {"criteria": criteria}])
        else:
            typer.echo(_about(law, forms))
    elif as_json:
        json_output.echo("laws", laws=[json_output.law(law) for law in catalogue.values()])
    else:
        rows = [
            [name, law.text, ", ".join(_described(parameter) for parameter in law.parameters.values())]
            for name, law in catalogue.items()
        ]
        typer.echo(table(["law", "mu(v)", "parameters"], rows))


def _described(parameter: "Parameter") -> str:
    unit = "" if parameter.unit in (None, "1") else f" {parameter.unit}"
    return f"{parameter.name} = {parameter.typical}{unit}" if parameter.typical else str(parameter.name)


def _about(law: "FrictionLaw", forms: dict[str, Found]) -> str:
    """Return a law's formula, parameters, source and criteria as text."""
    from stickslip_sym.output.lines import formula
    from stickslip_sym.output.tables import table

    rows = [[p.name, p.typical or "", p.unit or "", p.meaning] for p in law.parameters.values()]
    lines = [
        f"{law.name}: mu(v) = {law.text}",
        "",
        table(["parameter", "typical", "unit", "meaning"], rows),
        "",
        f"validity: {law.validity}",
        f"source: {law.source}",
    ]
    for criterion, form in forms.items():
        if isinstance(form, NoClosedForm):
            lines += ["", f"{criterion}: no closed form. {form}"]
        else:
            lines += ["", f"{criterion}, {form.verdict.status.value}", formula("c", form.expr)]
    return "\n".join(lines)

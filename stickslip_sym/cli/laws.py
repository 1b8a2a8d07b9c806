"""``stickslip laws``: the catalogue, or one law of it."""

from typing import Annotated, Any

import typer

from stickslip_sym.cli import json_output
from stickslip_sym.cli.completion import complete_law
from stickslip_sym.core.errors import NoClosedForm

__all__ = ["laws"]


def laws(
    name: Annotated[
        str | None,
        typer.Argument(metavar="[NAME]", help="A law of the catalogue, in full.", autocompletion=complete_law),
    ] = None,
    as_json: json_output.AsJson = False,
) -> None:
    """List the friction laws of the catalogue, or tell all about one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.model.laws import catalogue, find
    from stickslip_sym.output.tables import table

    if name is not None:
        law, forms = find(name), _forms(find(name))
        if as_json:
            criteria = {criterion: _described_form(form) for criterion, form in forms.items()}
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


def _described(parameter: Any) -> str:
    unit = "" if parameter.unit in (None, "1") else f" {parameter.unit}"
    return f"{parameter.name} = {parameter.typical}{unit}" if parameter.typical else str(parameter.name)


def _forms(law: Any) -> dict[str, Any]:
    """Return the closed form of every criterion, or the `NoClosedForm` that says why there is none."""
    from stickslip_sym import criteria
    from stickslip_sym.formula.derivation.closed_form import derive

    forms: dict[str, Any] = {}
    for criterion in criteria.catalogue:
        try:
            forms[criterion] = derive(law, criterion)
        except NoClosedForm as error:
            forms[criterion] = error
    return forms


def _described_form(form: Any) -> dict[str, Any]:
    from stickslip_sym.output import printing

    if isinstance(form, NoClosedForm):
        return {"formula": None, "reason": str(form)}
    return {"formula": printing.text(form.expr), "unit": "kg/s", "status": form.verdict.status.value}


def _about(law: Any, forms: dict[str, Any]) -> str:
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

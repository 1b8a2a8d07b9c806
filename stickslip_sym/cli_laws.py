"""``stickslip laws``: the catalogue, or one law of it."""

from typing import Annotated, Any

import typer

__all__ = ["laws"]


def laws(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="A law of the catalogue, in full.")] = None,
) -> None:
    """List the friction laws of the catalogue, or tell all about one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.laws import catalogue, find
    from stickslip_sym.tables import table

    if name is not None:
        typer.echo(_about(find(name)))
        return
    rows = [
        [name, law.text, ", ".join(_described(parameter) for parameter in law.parameters.values())]
        for name, law in catalogue.items()
    ]
    typer.echo(table(["law", "mu(v)", "parameters"], rows))


def _described(parameter: Any) -> str:
    unit = "" if parameter.unit in (None, "1") else f" {parameter.unit}"
    return f"{parameter.name} = {parameter.typical}{unit}" if parameter.typical else str(parameter.name)


def _about(law: Any) -> str:
    """Return a law's formula, parameters, source and criteria as text."""
    from stickslip_sym import criteria, printing
    from stickslip_sym.closed_form import derive
    from stickslip_sym.errors import NoClosedForm
    from stickslip_sym.tables import table

    rows = [[p.name, p.typical or "", p.unit or "", p.meaning] for p in law.parameters.values()]
    lines = [
        f"{law.name}: mu(v) = {law.text}",
        "",
        table(["parameter", "typical", "unit", "meaning"], rows),
        "",
        f"validity: {law.validity}",
        f"source: {law.source}",
    ]
    for criterion in criteria.catalogue:
        try:
            form = derive(law, criterion)
        except NoClosedForm as error:
            lines += ["", f"{criterion}: no closed form. {error}"]
        else:
            lines += ["", f"{criterion}, {form.verdict.status.value}", f"  c = {printing.text(form.expr)}"]
    return "\n".join(lines)

"""``stickslip laws``: the catalogue, or one law of it."""

import click

from stickslip_sym.cli.derive import derived
from stickslip_sym.cli.options import JSON, LAW_NAMES, Given, command
from stickslip_sym.cli.output import echo_json, law_of
from stickslip_sym.cli.reading import criteria_of
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.output.tables import table


@command("laws", click.Argument(["law"], required=False, **LAW_NAMES), JSON)
def run(given: Given) -> None:
    """List the friction laws of the catalogue, or all that is known of one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.model.laws import laws
    from stickslip_sym.output.lines import formula

    if given["law"] is None:
        if given["json"]:
            echo_json("laws", laws=[law_of(law) for law in laws.values()])
            return
        rows = []
        for name, law in laws.items():
            described = [
                f"{p.name} = {p.typical} {'' if p.unit in (None, '1') else p.unit}".rstrip()
                if p.typical
                else p.name
                for p in law.parameters.values()
            ]
            rows.append([name, law.text, ", ".join(described)])
        click.echo(table(["law", "mu(v)", "parameters"], rows))
        return
    law = laws.find(given["law"])
    forms = {criterion.name: derived(law, criterion) for criterion in criteria_of("all")}
    if given["json"]:
        echo_json("laws", laws=[law_of(law) | {"criteria": forms}])
        return
    rows = [[p.name, p.typical or "", p.unit or "", p.meaning] for p in law.parameters.values()]
    click.echo(f"{law.name}: mu(v) = {law.text}\n\n{table(['parameter', 'typical', 'unit', 'meaning'], rows)}\n")
    click.echo(f"validity: {law.validity}\nsource: {law.source}")
    for name, form in forms.items():
        if isinstance(form, NoClosedForm):
            click.echo(f"\n{name}: no closed form. {form}")
        else:
            click.echo(f"\n{name}, {form.verdict.status.value}\n{formula('c', form.expr)}")

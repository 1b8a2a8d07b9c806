"""``stickslip laws``: the catalogue, or one law of it."""

import click

import stickslip_sym as ss
from stickslip_sym.cli.derive import derived
from stickslip_sym.cli.options import LAW_NAMES, Given, command
from stickslip_sym.cli.output import echo_json, law_of
from stickslip_sym.cli.reading import criteria_of
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.output.tables import table


@command("laws", click.Argument(["law"], required=False, **LAW_NAMES))
def run(given: Given) -> None:
    """List the friction laws of the catalogue, or all that is known of one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.output.abbreviation import formula

    name = given["law"]
    laws = list(ss.laws.values()) if name is None else [ss.laws.find(name)]
    forms = {} if name is None else {one.name: derived(laws[0], one) for one in criteria_of("all")}
    if given["json"]:
        echo_json("laws", laws=[law_of(law) | ({"criteria": forms} if forms else {}) for law in laws])
        return
    if name is None:
        rows = []
        for law in laws:
            typical = [f"{p.name} = {p.typical}" if p.typical else p.name for p in law.parameters.values()]
            units = [
                "" if p.unit in (None, "1") or not p.typical else f" {p.unit}" for p in law.parameters.values()
            ]
            rows.append([str(law.name), law.text, ", ".join(map(str.__add__, typical, units))])
        click.echo(table(["law", "mu(v)", "parameters"], rows))
        return
    (law,) = laws
    rows = [[p.name, p.typical or "", p.unit or "", p.meaning] for p in law.parameters.values()]
    click.echo(f"{law.name}: mu(v) = {law.text}\n\n{table(['parameter', 'typical', 'unit', 'meaning'], rows)}\n")
    click.echo(f"validity: {law.validity}\nsource: {law.source}")
    for criterion, form in forms.items():
        if isinstance(form, NoClosedForm):
            click.echo(f"\n{criterion}: no closed form. {form}")
        else:
            click.echo(f"\n{criterion}, {form.verdict.status.value}\n{formula('c', form.expr)}")

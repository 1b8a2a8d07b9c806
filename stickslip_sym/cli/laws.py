"""``stickslip laws``: the catalogue, or one law of it."""

from __future__ import annotations

import click

import stickslip_sym as ss
from stickslip_sym.cli.arguments import criteria_of
from stickslip_sym.cli.derive import derived
from stickslip_sym.cli.options import LAW_NAMES, Given, command, plot_option
from stickslip_sym.cli.output import echo_json, say
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.model.operating_point import PAPER
from stickslip_sym.output.tables import aligned_table


@command(
    click.Argument(["law"], required=False, **LAW_NAMES),
    plot_option("Draw the law with its typical values, up to twice the default belt speed"),
)
def run(given: Given) -> None:
    """List the friction laws of the catalogue, or all that is known of one.

    Example: stickslip laws hyperbolic
    """
    from stickslip_sym.output.abbreviation import indented_equation

    name = given["law"]
    plot = None if given["law"] is None else given["plot"]
    given.reject_unused()
    if name is None:
        laws = list(ss.laws.values())
    else:
        laws = [ss.laws.find(name)]
    wanted = []
    if name is not None:
        wanted = [(laws[0], criterion) for criterion in criteria_of("all")]
    forms = {criterion.name: form for (_, criterion), form in zip(wanted, derived(wanted), strict=True)}
    if plot is not None:
        laws[0].typical().plot(plot, v_max=2 * float(PAPER["V"]))
    if given["json"]:
        echo_json("laws", laws=laws, **({"criteria": forms} if forms else {}))
    elif name is None:
        say(
            aligned_table(
                ["law", "mu(v)", "parameters"], [[str(law.name), law.text, _typical(law)] for law in laws]
            )
        )
    else:
        (law,) = laws
        rows = [[p.name, p.typical or "", p.unit or "", p.meaning] for p in law.parameters.values()]
        parameters = aligned_table(["parameter", "typical", "unit", "meaning"], rows)
        say(f"{law.name}: mu(v) = {law.text}\n\n{parameters}\n")
        say(f"validity: {law.validity}\nsource: {law.source}")
        for criterion, form in forms.items():
            if isinstance(form, NoClosedForm):
                say(f"\n{criterion}: no closed form. {form}")
            else:
                say(f"\n{criterion}, {form.verdict.status.value}\n{indented_equation('c', form.expr)}")


def _typical(law: ss.FrictionLaw) -> str:
    return ", ".join(
        f"{p.name} = {p.typical}{'' if p.unit in (None, '1') else f' {p.unit}'}" if p.typical else p.name
        for p in law.parameters.values()
    )

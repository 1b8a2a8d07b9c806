"""``stickslip derive``: a law's criteria in closed form, with a table that cross-checks each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import criteria_of, point
from stickslip_sym.cli.options import Given, option
from stickslip_sym.cli.output import echo_all, show_progress
from stickslip_sym.core.aliases import Json
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.core.progress import steps
from stickslip_sym.core.seconds import SECONDS_TO_DERIVE

if TYPE_CHECKING:
    from stickslip_sym.formula.closed_form import ClosedForm


@options.command(
    options.AT, options.criterion("all"),
    option("--steps", is_flag=True, help="Print every step of the derivation."),
    option("--verify", is_flag=True, help="Run the page in SymPy that proves the formula."),
    options.file_option("--latex", help="Write the formula as LaTeX."),
    options.time_limit_option(f"Seconds for each criterion ({SECONDS_TO_DERIVE:.0f}).", SECONDS_TO_DERIVE),
)  # fmt: skip
def run(given: Given) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive "mu_m + (mu_s - mu_m)*exp(-alpha*v)" -p mu_s=0.5 -p mu_m=0.2 -p alpha=3
    """
    from stickslip_sym.comparison.crosscheck import crosscheck
    from stickslip_sym.model.negative import warn_where_negative
    from stickslip_sym.output import files

    chosen = criteria_of(given["criterion"])
    latex = given["latex"]
    steps = given["steps"]
    verify = given["verify"]
    at = point(given, without=("c",)).exact("derive")
    law = at.law
    limit = given["time_limit"]
    given.reject_unused()
    # What the table cannot be computed for is refused before anything is derived or written.
    ss.Oscillator(**at.numbers)
    for criterion in chosen:
        law.require_speed(at.numbers["V"] * (1 if criterion.weight is None else 2))
    if not law.missing:
        warn_where_negative(law.kinetic, at.numbers["V"])
    derivations = dict(zip(chosen, derived([(law, criterion) for criterion in chosen], limit), strict=True))
    failures = [form for form in derivations.values() if isinstance(form, NoClosedForm)]
    forms = [form for form in derivations.values() if not isinstance(form, NoClosedForm)]
    for closed_form in forms if verify else []:
        closed_form.verify(time_limit=limit)
    if latex is not None and forms:
        files.write_text(latex, "\n".join(_latex(form, steps) for form in forms))
    rows = list[Json]()
    texts = [str(at)]
    for criterion, form in derivations.items():
        closed = None if isinstance(form, NoClosedForm) else form
        with show_progress("table of values"):
            if law.missing:
                checks = None
            else:
                checks = crosscheck(law, criterion, at.texts, closed)
        rows.append({"criterion": criterion.name, "form": form, "checks": checks})
        lines = [f"no closed form: {law.name or 'the law'}, {criterion.name}"]
        if closed is not None:
            lines = _form_lines(closed)
        if steps and closed is not None:
            rows[-1]["steps"] = closed.derivation.steps
            lines += ["", closed.derivation.text()]
        texts.append("\n".join([*lines, *(["", str(checks)] if checks else [])]))
    echo_all(given, [{"operating_point": at, "criteria": rows}], texts)
    if law.missing and forms:
        names = ", ".join(law.missing)
        click.echo(f"\nno value for {names}: give -p {law.missing[0]}=... for a table of values", err=True)
    for failure in failures:
        raise failure


def derived(
    wanted: Sequence[tuple[ss.FrictionLaw, ss.Criterion]], seconds: float = SECONDS_TO_DERIVE
) -> list[ClosedForm | NoClosedForm]:
    """Return the closed form of each law and criterion, or why there is none."""
    forms: list[ClosedForm | NoClosedForm] = []

    def what(pair: tuple[ss.FrictionLaw, ss.Criterion]) -> str:
        law, criterion = pair
        return f"{criterion.name} of {law.name or 'the law'}"

    with show_progress(f"closed forms, {seconds:.0f} s each at most"), steps(wanted, what) as pairs:
        for law, criterion in pairs:
            try:
                forms.append(ss.derive(law, criterion, time_limit=seconds))
            except NoClosedForm as error:
                forms.append(error)
    return forms


def _form_lines(form: ClosedForm) -> list[str]:
    """Return a form as lines of text, its formula no longer than a few screens."""
    from stickslip_sym.formula.proof.normal_form import arguments_of_arctangents, factor_of_sign
    from stickslip_sym.output import abbreviation, printing
    from stickslip_sym.output.tables import MOST_FORMULA_CHARACTERS

    if form.law.curve is not None:
        shown = f"  c = average of the {form.law.curve} (--json has its cubics)"
        return [repr(form), "", shown, "", form.verdict.evidence]
    general, letters = form.readable
    shown = abbreviation.indented_equation("c", general.expr)
    if len(shown) > MOST_FORMULA_CHARACTERS:
        size = len(printing.text(general.expr))
        shown = f"{shown[:MOST_FORMULA_CHARACTERS]}... ({size} characters; --latex and --json write it whole)"
    values = ", ".join(
        f"{letter} = {printing.value(value)}" for letter, value in letters.items() if general.expr.has(letter)
    )
    where = [f"  where {values}"] if values else []
    where += [
        f"  hyper((1/2, 1), (3/2,), z) is atanh(sqrt(z))/sqrt(z) for z > 0, atan(sqrt(-z))/sqrt(-z) for z < 0;"
        f" z has the sign of {printing.text(factor_of_sign(z))}"
        for z in arguments_of_arctangents(general.expr)
    ]
    return [repr(form), "", shown, *where, "", form.verdict.evidence]


def _latex(form: ClosedForm, steps: bool) -> str:
    from stickslip_sym.formula.export import criterion_latex
    from stickslip_sym.output.layout import key

    label = f"eq:{key(form.law.name)}-{form.criterion.name}"
    content = f"% {' '.join(repr(form).split())}\n{criterion_latex(form, label)}\n"
    return content + ("\n" + str(form.derivation.latex()) if steps else "")

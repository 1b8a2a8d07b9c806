"""``stickslip derive``: a law's criteria in closed form, with a table that cross-checks each."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Union

import click

from stickslip_sym.cli.options import CRITERIA, JSON, LAW, POINT, Given, command, file_option, option, time_limit
from stickslip_sym.cli.output import echo_json, point_of, progress_bar
from stickslip_sym.cli.reading import criteria_of, point
from stickslip_sym.cli.words import in_options
from stickslip_sym.core.errors import InputError, NoClosedForm

if TYPE_CHECKING:
    from stickslip_sym.comparison.crosscheck import Check
    from stickslip_sym.criteria.criterion import Criterion
    from stickslip_sym.formula.closed_form import ClosedForm
    from stickslip_sym.model.law import FrictionLaw

__all__ = ["SECONDS", "Form", "derived"]

Form = Union["ClosedForm", NoClosedForm]  # a text has no |
"""The closed form of a criterion, or why there is none."""
SECONDS = 120.0  # of the search for one closed form
_LONGEST = 4000  # characters of a formula on the screen
_CURVE = "  c = average of the {} (--json and --save have it exactly)"


@command(
    "derive", LAW, POINT, CRITERIA,
    option("--steps", is_flag=True, help="Print every step of the derivation."),
    file_option("--latex", "Write the formula as LaTeX."),
    file_option("--save", "Keep the form, for stickslip_sym.load."),
    time_limit("Seconds for each criterion (120).", SECONDS), JSON,
)  # fmt: skip
def run(given: Given) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive "mu_m + (mu_s - mu_m)*exp(-alpha*v)" -p mu_s=0.5 -p mu_m=0.2 -p alpha=3
    """
    from stickslip_sym.comparison.crosscheck import crosscheck
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.output import files

    chosen = criteria_of(given["criterion"])
    latex, save, steps = given["latex"], given["save"], given["steps"]
    if save is not None and len(chosen) > 1:
        raise InputError("--save keeps one closed form; name one criterion instead of all")
    at = point(given, without=("c",)).exact("derive")
    law, limit = at.law, given["time_limit"]
    given.all_used()
    # What the table cannot be computed for is refused before anything is derived or written.
    Oscillator(**at.numbers)
    for criterion in chosen:
        law.require_speed(at.numbers["V"] * (1 if criterion.weight is None else 2))
    if not law.missing:
        from stickslip_sym.model.negative import warn_where_negative

        warn_where_negative(law, at.numbers["V"])
    results = [(criterion, derived(law, criterion, limit)) for criterion in chosen]
    forms = [form for _, form in results if not isinstance(form, NoClosedForm)]
    if latex is not None and forms:
        files.write_text(latex, "\n".join(_latex(form, steps) for form in forms))
    if save is not None and forms:
        from stickslip_sym.formula.files import save as save_form

        save_form(forms[0], save)
    checks = [
        [] if law.missing else crosscheck(law, one, at.texts, None if isinstance(form, NoClosedForm) else form)
        for one, form in results
    ]
    if given["json"]:
        rows = [
            {"criterion": criterion.name, "form": form, "checks": rows}
            | ({"steps": form.derivation.steps} if steps and not isinstance(form, NoClosedForm) else {})
            for (criterion, form), rows in zip(results, checks, strict=True)
        ]
        echo_json("derive", **point_of(at), criteria=rows)
    else:
        click.echo(str(at))
        for (criterion, form), found in zip(results, checks, strict=True):
            click.echo(f"\n{_report(law, criterion, form, found, steps)}")
    if law.missing and forms:
        names = ", ".join(law.missing)
        click.echo(f"\nno value for {names}: give -p {law.missing[0]}=... for a table of values", err=True)
    for _, form in results:
        if isinstance(form, NoClosedForm):
            raise form


def derived(law: "FrictionLaw", criterion: "Criterion", seconds: float = SECONDS) -> Form:
    """Return the closed form, or the `NoClosedForm` that says why there is none."""
    from stickslip_sym.formula.closed_form import derive

    with _progress(seconds) as say:
        try:
            return derive(law, criterion, time_limit=seconds, progress=say)
        except NoClosedForm as error:
            return error


def _report(law: "FrictionLaw", criterion: "Criterion", form: Form, checks: "list[Check]", steps: bool) -> str:
    from stickslip_sym.comparison.crosscheck import report
    from stickslip_sym.output import printing
    from stickslip_sym.output.lines import formula

    if isinstance(form, NoClosedForm):
        lines = [f"no closed form: {law.name or 'the law'}, {criterion.name}"]
    else:
        shown = formula("c", form.expr) if form.law.curve is None else _CURVE.format(form.law.curve)
        if len(shown) > _LONGEST:
            size = len(printing.text(form.expr))
            shown = f"{shown[:_LONGEST]}... ({size} characters; --latex and --save write it whole)"
        lines = [repr(form), "", shown, "", form.verdict.evidence]
        if steps:
            lines += ["", form.derivation.text()]
    return "\n".join(lines + (["", in_options(report(checks))] if checks else []))


def _latex(form: "ClosedForm", steps: bool) -> str:
    from stickslip_sym.output import printing
    from stickslip_sym.output.layout import displayed, key

    label = f"eq:{key(form.law.name)}-{form.criterion.name}"
    content = f"% {' '.join(repr(form).split())}\n{displayed('c', printing.latex(form.expr), label=label)}\n"
    return content + ("\n" + str(form.derivation.latex()) if steps else "")


@contextlib.contextmanager
def _progress(seconds: float) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and how long it may still take; elsewhere show nothing."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.progress import ProgressColumn, SpinnerColumn, Task, TextColumn
    from rich.table import Column
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"at most {max(seconds - (task.elapsed or 0.0), 0.0):.0f} s left")

    words = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1))
    with progress_bar(SpinnerColumn(), words, TimeLeft()) as update:
        yield lambda text: update(description=text)

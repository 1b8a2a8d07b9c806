"""``stickslip derive``: a law's criteria in closed form, with a table that cross-checks each."""

import contextlib
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Union

import typer

from stickslip_sym.cli.shared import json_output
from stickslip_sym.cli.shared.law import LawOptions
from stickslip_sym.cli.shared.options import SECONDS, AsJson, CriteriaName, SceneOptions, TimeLimit, file_option
from stickslip_sym.cli.shared.reading import (
    check_size,
    chosen_criteria,
    progress_bar,
    read_exact,
    require_writable,
)
from stickslip_sym.cli.shared.words import in_options
from stickslip_sym.core.errors import InputError, NoClosedForm

if TYPE_CHECKING:
    from stickslip_sym.comparison.crosscheck import Check
    from stickslip_sym.criteria.criterion import Criterion
    from stickslip_sym.formula.derivation.closed_form import ClosedForm
    from stickslip_sym.model.law import FrictionLaw

__all__ = ["Found", "derive", "derived"]

Found = Union["ClosedForm", NoClosedForm]  # a text has no |
"""The closed form of a criterion, or why there is none."""


def derive(
    law: LawOptions,
    scene: SceneOptions,
    criterion: CriteriaName = "least_squares",
    steps: Annotated[bool, typer.Option("--steps", help="Print every step of the derivation.")] = False,
    latex: Annotated[Path | None, file_option("--latex", "Write the formula as LaTeX.")] = None,
    save: Annotated[Path | None, file_option("--save", "Keep the form, for stickslip_sym.load.")] = None,
    time_limit: TimeLimit = SECONDS,
    as_json: AsJson = False,
) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive "mu_m + (mu_s - mu_m)*exp(-alpha*v)" -p mu_s=0.5 -p mu_m=0.2 -p alpha=3
    """
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.output import files

    chosen = chosen_criteria(criterion)
    if save is not None and len(chosen) > 1:
        raise InputError("--save keeps one closed form; name one criterion instead of all")
    require_writable(latex, save)
    bound = law.bound()
    given = scene.texts()
    # Refuse what the table cannot be computed for before anything is derived or written.
    numbers = read_exact(given)
    for name, value in bound.values.items():
        check_size(name, value)
    Oscillator(**{name: float(value) for name, value in numbers.items()})
    for one in chosen:
        bound.require_speed(numbers["V"] * (1 if one.weight is None else 2))
    if not bound.missing:
        from stickslip_sym.model.doubts import warn_where_negative

        warn_where_negative(bound, float(numbers["V"]))
    found = [derived(bound, one, time_limit) for one in chosen]
    forms = [form for form in found if not isinstance(form, NoClosedForm)]
    if latex is not None and forms:
        files.write_text(latex, "\n".join(_latex(form, steps) for form in forms))
    if save is not None and forms:
        from stickslip_sym.formula.derivation import keeping

        keeping.save(forms[0], save)
    results = [(one.name, form, _checks(bound, one, given, form)) for one, form in zip(chosen, found, strict=True)]
    if as_json:
        shown = [_as_json(*result, steps) for result in results]
        json_output.echo("derive", law=json_output.law(bound), scene=json_output.values(given), criteria=shown)
    else:
        typer.echo(f"mu(v) = {bound.text}")
        for result in results:
            typer.echo(f"\n{_report(bound, *result, steps)}")
    if bound.missing and forms:
        names = ", ".join(bound.missing)
        typer.echo(f"\nno value for {names}: give -p {bound.missing[0]}=... for a table of values", err=True)
    for form in found:
        if isinstance(form, NoClosedForm):
            raise form


def _checks(law: "FrictionLaw", criterion: "Criterion", scene: dict[str, str], form: Found) -> "list[Check]":
    """Return the table of values, for a law that has all of its parameters."""
    if law.missing:
        return []
    from stickslip_sym.comparison.crosscheck import crosscheck

    return crosscheck(law, criterion, scene, None if isinstance(form, NoClosedForm) else form)


def derived(law: "FrictionLaw", criterion: "Criterion", time_limit: float = SECONDS) -> Found:
    """Return the closed form, or the `NoClosedForm` that says why there is none."""
    from stickslip_sym.formula.derivation.closed_form import derive as derive_form

    with _progress(time_limit) as say:
        try:
            return derive_form(law, criterion, time_limit=time_limit, progress=say)
        except NoClosedForm as error:
            return error


def _as_json(name: str, form: Found, checks: "list[Check]", steps: bool) -> json_output.Json:
    from stickslip_sym.output import printing

    known = {"criterion": name, **json_output.form(form)}
    if not isinstance(form, NoClosedForm):
        known["evidence"] = form.verdict.evidence
        if steps:
            known["steps"] = [
                {
                    "operation": step.operation,
                    "reason": step.reason,
                    "result": printing.text(step.statement),
                    "status": step.verdict.status.value,
                    "evidence": step.verdict.evidence,
                }
                for step in form.derivation.steps
            ]
    return known | {"checks": [_check(check) for check in checks]}


def _check(check: "Check") -> json_output.Json:
    if check.difference is None:
        return {"method": check.method, "c": json_output.missing("kg/s", in_options(check.value))}
    return {
        "method": check.method,
        "c": json_output.quantity(float(check.value), "kg/s", text=check.value),
        "relative_difference": json_output.number(check.difference),
        "seconds": check.seconds,
    }


def _report(law: "FrictionLaw", name: str, form: Found, checks: "list[Check]", steps: bool) -> str:
    from stickslip_sym.output import printing
    from stickslip_sym.output.lines import formula

    if isinstance(form, NoClosedForm):
        lines = [f"no closed form: {law.name or 'the law'}, {name}"]
    else:
        shown = formula("c", form.expr) if form.law.curve is None else _CURVE.format(form.law.curve)
        if len(shown) > _LONGEST:
            size = len(printing.text(form.expr))
            shown = f"{shown[:_LONGEST]}... ({size} characters; --latex and --save write it whole)"
        lines = [repr(form), "", shown, "", form.gate.evidence]
        if steps:
            lines += ["", form.derivation.text()]
    if checks:
        from stickslip_sym.comparison import crosscheck

        lines += ["", in_options(crosscheck.report(checks))]
    return "\n".join(lines)


_LONGEST = 4000  # characters of a formula on the screen
_CURVE = "  c = average of the {} (--json and --save have it exactly)"


def _latex(form: "ClosedForm", steps: bool) -> str:
    from stickslip_sym.output import printing
    from stickslip_sym.output.layout import displayed, key

    label = f"eq:{key(form.law.name)}-{form.criterion.name}"
    content = f"% {' '.join(repr(form).split())}\n{displayed('c', printing.latex(form.expr), label=label)}\n"
    return content + ("\n" + str(form.derivation.latex()) if steps else "")


@contextlib.contextmanager
def _progress(time_limit: float) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and how long it may still take; elsewhere show nothing."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.progress import ProgressColumn, SpinnerColumn, Task, TextColumn
    from rich.table import Column
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"at most {max(time_limit - (task.elapsed or 0.0), 0.0):.0f} s left")

    words = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1))
    with progress_bar(SpinnerColumn(), words, TimeLeft()) as update:
        yield lambda text: update(description=text)

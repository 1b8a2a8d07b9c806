"""``stickslip derive``: a law's criteria in closed form, with a table that cross-checks each."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from stickslip_sym.cli_reading import assignments, check_size, once, read_law
from stickslip_sym.errors import InputError, NoClosedForm

__all__ = ["derive"]


def derive(
    law: Annotated[
        str | None,
        typer.Argument(metavar="LAW", help="Name of a law (see: stickslip laws), or a formula in v."),
    ] = None,
    from_csv: Annotated[
        list[Path] | None,
        typer.Option("--from-csv", metavar="FILE", help="Measured points instead: a header, then v,mu a line."),
    ] = None,
    extrapolate: Annotated[
        bool, typer.Option("--extrapolate", help="Hold the first and the last measured coefficient.")
    ] = False,
    criterion: Annotated[
        list[str] | None,
        typer.Option(
            "--criterion", metavar="NAME", help="least_squares (default), harmonic, equilibrium, or all."
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option("--parameter", "-p", metavar="NAME=VALUE", help="Value for the table; may be repeated."),
    ] = None,
    speed: Annotated[list[str] | None, typer.Option("-V", metavar="M/S", help="Belt speed (0.5).")] = None,
    force: Annotated[list[str] | None, typer.Option("-N", metavar="N", help="Normal force (9.81).")] = None,
    mass: Annotated[list[str] | None, typer.Option("-m", metavar="KG", help="Mass (1).")] = None,
    stiffness: Annotated[list[str] | None, typer.Option("-k", metavar="N/M", help="Stiffness (100).")] = None,
    steps: Annotated[bool, typer.Option("--steps", help="Print every step of the derivation.")] = False,
    latex: Annotated[
        list[Path] | None, typer.Option("--latex", metavar="FILE", help="Write the formula as LaTeX.")
    ] = None,
    save: Annotated[
        list[Path] | None, typer.Option("--save", metavar="FILE", help="Keep the form, for stickslip_sym.load.")
    ] = None,
    time_limit: Annotated[
        float, typer.Option("--time-limit", metavar="S", help="Seconds for SymPy's integrator.")
    ] = 20.0,
) -> None:
    """Derive the closed form of a criterion, prove it, and cross-check its value.

    Example: stickslip derive "mu_m + (mu_s - mu_m)*exp(-alpha*v)" -p mu_s=0.5 -p mu_m=0.2 -p alpha=3
    """
    from stickslip_sym import criteria, crosscheck, files, keeping
    from stickslip_sym.oscillator import Oscillator
    from stickslip_sym.values import exact

    asked = once("criterion", criterion or ["least_squares"]) or ""
    chosen = list(criteria.catalogue.values()) if asked == "all" else [criteria.find(asked)]
    latex_file, kept = once("latex", latex), once("save", save)
    if kept is not None and len(chosen) > 1:
        raise InputError("--save keeps one closed form; name one criterion instead of all")
    friction = read_law(law, once("from-csv", from_csv), extrapolate=extrapolate)
    bound = friction.typical(**assignments(parameter or []))
    given = {"V": once("V", speed), "N": once("N", force), "m": once("m", mass), "k": once("k", stiffness)}
    scene = crosscheck.SCENE | {name: value for name, value in given.items() if value is not None}
    # Refuse what the table cannot be computed for before anything is derived or written.
    numbers = {name: exact(value, name) for name, value in scene.items()}
    for name, value in (numbers | bound.values).items():
        check_size(name, value)
    Oscillator(**{name: float(value) for name, value in numbers.items()})
    for one in chosen:
        bound.require_speed(numbers["V"] * (1 if one.weight is None else 2))
    found = [_derived(bound, one, time_limit) for one in chosen]
    forms = [form for form in found if not isinstance(form, NoClosedForm)]
    if latex_file is not None and forms:
        files.write_text(latex_file, "\n".join(_latex(form, steps) for form in forms))
    if kept is not None and forms:
        keeping.save(forms[0], kept)
    typer.echo(f"mu(v) = {bound.text}")
    for one, form in zip(chosen, found, strict=True):
        typer.echo(f"\n{_report(bound, one, form, scene, steps)}")
    if bound.missing and forms:
        names = ", ".join(bound.missing)
        typer.echo(f"\nno value for {names}: give -p {bound.missing[0]}=... for a table of values", err=True)
    for form in found:
        if isinstance(form, NoClosedForm):
            raise form


def _derived(law: Any, criterion: Any, time_limit: float) -> Any:
    """Return the closed form, or the `NoClosedForm` that says why there is none."""
    from stickslip_sym.closed_form import derive as derive_form

    with _progress(time_limit) as progress:
        try:
            return derive_form(law, criterion, time_limit=time_limit, progress=progress)
        except NoClosedForm as error:
            return error


def _report(law: Any, criterion: Any, form: Any, scene: dict[str, str], steps: bool) -> str:
    from stickslip_sym import crosscheck, printing

    if isinstance(form, NoClosedForm):
        lines = [f"no closed form: {law.name or 'the law'}, {criterion.name}"]
    else:
        formula = printing.text(form.expr)
        if len(formula) > _LONGEST:
            formula = f"{formula[:_LONGEST]}... ({len(formula)} characters; --latex and --save write it whole)"
        lines = [repr(form), "", f"  c = {formula}", "", form.gate.evidence]
        if steps:
            lines += ["", form.derivation.text()]
    if not law.missing:
        checks = crosscheck.crosscheck(law, criterion, scene, None if isinstance(form, NoClosedForm) else form)
        lines += ["", crosscheck.report(checks)]
    return "\n".join(lines)


_LONGEST = 4000  # characters of a formula on the screen


def _latex(form: Any, steps: bool) -> str:
    content = f"% {form!r}\n\\begin{{equation}}\n  {form.latex()}\n\\end{{equation}}\n"
    return content + ("\n" + str(form.derivation.latex()) if steps else "")


@contextlib.contextmanager
def _progress(time_limit: float) -> Iterator[Callable[[str], None]]:
    """Show on a terminal what is being done, and how long it may still take; elsewhere show nothing."""
    from rich.console import Console
    from rich.progress import Progress, ProgressColumn, SpinnerColumn, Task, TextColumn
    from rich.table import Column
    from rich.text import Text

    class TimeLeft(ProgressColumn):
        def render(self, task: Task) -> Text:
            return Text(f"at most {max(time_limit - (task.elapsed or 0.0), 0.0):.0f} s left")

    console = Console(stderr=True)
    words = TextColumn("{task.description}", markup=False, table_column=Column(no_wrap=True, ratio=1))
    with Progress(
        SpinnerColumn(), words, TimeLeft(), console=console, transient=True, disable=not console.is_terminal
    ) as shown:
        task = shown.add_task("reading the law", total=None)
        yield lambda text: shown.update(task, description=text)

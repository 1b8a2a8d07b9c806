"""``stickslip export``: criteria as LaTeX, Python, C or Octave, or exactly, several at once or none at all."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stickslip_sym.cli.derive import SECONDS, derived
from stickslip_sym.cli.options import (
    CRITERIA,
    DESCRIPTION,
    JSON,
    LAW_NAMES,
    Given,
    command,
    file_option,
    option,
    time_limit,
)  # fmt: skip
from stickslip_sym.cli.output import echo_json
from stickslip_sym.cli.reading import assignments, criteria_of, law_described
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.formula.code.languages import LANGUAGES

if TYPE_CHECKING:
    from stickslip_sym.formula.closed_form import ClosedForm
    from stickslip_sym.formula.slope_average import SlopeAverage
    from stickslip_sym.model.law import FrictionLaw

_KINDS = ("latex", *LANGUAGES, "save")


@command(
    "export", click.Argument(["laws"], nargs=-1, **{**LAW_NAMES, "metavar": "LAW..."}),
    option("--all", is_flag=True, help="Every law of the catalogue."), DESCRIPTION, CRITERIA,
    file_option("--latex", "A LaTeX document."),
    *(file_option(f"--{name}", language.description) for name, language in LANGUAGES.items()),
    file_option("--save", "Exact, for stickslip_sym.load."),
    option("--fragment", is_flag=True, help="LaTeX for \\input: without preamble."),
    option("--steps", is_flag=True, help="LaTeX with every step of the derivations."),
    option("--symbol", metavar="NAME=LATEX", multiple=True, help="Print a symbol otherwise."),
    time_limit("Seconds for each criterion (120).", SECONDS), JSON,
)  # fmt: skip
def run(given: Given) -> None:
    """Write criteria as LaTeX, Python, C or Octave. If anything fails, nothing is written.

    Example: stickslip export exponential polynomial --criterion all --latex criteria.tex --symbol V=v_b
    """
    from stickslip_sym.formula.slope_average import slope_average
    from stickslip_sym.output import files

    targets: dict[str, Path] = {kind: given[kind] for kind in _KINDS if given[kind] is not None}
    if not targets:
        *first, last = (f"--{kind} FILE" for kind in _KINDS)
        raise InputError(f"nothing to write: give {', '.join(first)} or {last}")
    if len({path.resolve() for path in targets.values()}) < len(targets):
        raise InputError("two outputs have the same file; give each one of its own")
    chosen, limit = criteria_of(given["criterion"]), given["time_limit"]
    laws = _laws(given)
    style = {}
    if "latex" in targets:
        notation = assignments(given["symbol"], "--symbol V=v_b")
        _check_notation(notation, laws)
        style = {"symbols": notation, "fragment": given["fragment"], "steps": given["steps"]}
    given.all_used()
    only_code = targets.keys() <= LANGUAGES.keys()
    unbound = _unbound(laws, given["all"]) if targets.keys() & LANGUAGES.keys() else []
    forms: list[ClosedForm] = []
    missing: list[tuple[FrictionLaw, str, str]] = []
    averages: list[SlopeAverage] = []
    for law in laws:
        for criterion in chosen:
            form = derived(law, criterion, limit)
            if not isinstance(form, NoClosedForm):
                forms.append(form)
                continue
            if len(chosen) == 1 and not given["all"] and not only_code:
                raise form
            missing.append((law, criterion.name, str(form)))
            averages.append(slope_average(law, criterion))
    if not forms and not only_code:
        raise NoClosedForm(f"none of the criteria has a closed form: {missing[0][2]}")
    coded: list[ClosedForm | SlopeAverage] = [*forms, *averages]
    coded = [one for one in coded if one.law not in unbound]
    files.write_texts({path: _text(kind, forms, coded, missing, style) for kind, path in targets.items()})
    for law, name, _ in missing:
        what = "its fast function is written" if only_code else "only its fast function is written, to code"
        if law in unbound or not targets.keys() & LANGUAGES.keys():
            what = "nothing is written of it but the reason"
        click.echo(f"no closed form: {law.name or law.text}, {name}; {what}", err=True)
    counts = {kind: len(coded if kind in LANGUAGES else forms) for kind in targets}
    if given["json"]:
        content = [{"law": one.law.name, "criterion": one.criterion.name, "form": one} for one in forms]
        echo_json("export", criteria=content, files=targets)
        return
    # /dev/stdout holds what was asked for, and nothing else.
    streamed = any(path.exists() and not path.is_file() for path in targets.values())
    for kind, path in targets.items():
        count = "1 criterion" if counts[kind] == 1 else f"{counts[kind]} criteria"
        click.echo(f"{kind}: {count} in {path}", err=streamed)


def _laws(given: Given) -> "list[FrictionLaw]":
    from stickslip_sym.model.laws import laws as catalogue

    texts = given["laws"]
    if given["all"]:
        if texts:
            raise InputError(f"--all is every law already; leave out {', '.join(map(repr, texts))}")
        return list(catalogue.values())
    if not texts:
        raise InputError("no law: give names (see: stickslip laws) or formulas in v, or --all")
    for position, text in enumerate(texts):
        if text in texts[:position]:
            raise InputError(f"the law {text!r} is given twice; give it once")
    if len(texts) > 1:
        return [law_described(lambda option: None, text) for text in texts]
    return [law_described(given.__getitem__, texts[0])]


def _check_notation(notation: dict[str, str], laws: "list[FrictionLaw]") -> None:
    """Refuse symbols before anything is derived, which may take long."""
    from stickslip_sym.core import symbols
    from stickslip_sym.output.notation import check_known, notation_of

    every = ["mu", *symbols.QUANTITIES]
    check_known(notation, [*every, *(name for law in laws for name in law.parameters)])
    for law in laws:
        notation_of([*every, *law.parameters], notation)


def _unbound(laws: "list[FrictionLaw]", every: bool) -> "list[FrictionLaw]":
    """Return the laws that need values before they can be code: said, and left out, of all; else refused."""
    from stickslip_sym.formula.code.writer import require_shapes

    unbound = []
    for law in laws:
        try:
            require_shapes(law)
        except InputError as failure:
            if not every:
                raise
            click.echo(f"no code: {failure}", err=True)
            unbound.append(law)
    return unbound


def _text(
    kind: str, forms: "list[ClosedForm]", coded: "list[ClosedForm | SlopeAverage]",
    missing: "list[tuple[FrictionLaw, str, str]]", style: dict[str, Any],
) -> str:  # fmt: skip
    from stickslip_sym.formula.export import export as write
    from stickslip_sym.formula.files import text_of

    if kind == "latex":
        return write.export_latex(forms, missing=missing, **style)
    if kind == "save":
        return text_of(forms)
    return write.export_code(coded, kind)

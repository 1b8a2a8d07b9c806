"""``stickslip export``: criteria as LaTeX, Python, C, Octave or JSON, several at once or none at all."""

from dataclasses import asdict, field, make_dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from stickslip_sym.cli.derive import derived
from stickslip_sym.cli.shared.law import Description
from stickslip_sym.cli.shared.options import SECONDS, CriteriaName, TimeLimit, file_option
from stickslip_sym.cli.shared.reading import assignments, chosen_criteria, require_writable
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.formula.code.languages import DESCRIPTIONS

if TYPE_CHECKING:
    from stickslip_sym.formula.derivation.closed_form import ClosedForm
    from stickslip_sym.formula.evaluation.averages import SlopeAverage
    from stickslip_sym.model.law import FrictionLaw

__all__ = ["export"]

Code = make_dataclass(
    "Code",
    [
        (name, Annotated[Path | None, file_option(f"--{name}", text)], field(default=None))
        for name, text in DESCRIPTIONS.items()
    ],
    frozen=True,
)
"""A file for each language of the table."""


def export(
    *,
    law: Annotated[
        list[str] | None,
        typer.Argument(metavar="LAW...", help="Names of laws (see: stickslip laws), or formulas in v."),
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Every law of the catalogue.")] = False,
    description: Description,
    criterion: CriteriaName = "least_squares",
    latex: Annotated[Path | None, file_option("--latex", "A LaTeX document.")] = None,
    code: Code,  # type: ignore[valid-type]  # a class that is made here
    json: Annotated[Path | None, file_option("--json", "Exact, for stickslip_sym.load_all.")] = None,
    fragment: Annotated[bool, typer.Option("--fragment", help="LaTeX for \\input: without preamble.")] = False,
    steps: Annotated[bool, typer.Option("--steps", help="LaTeX with every step of the derivations.")] = False,
    symbol: Annotated[
        list[str] | None,
        typer.Option("--symbol", metavar="NAME=LATEX", help="Print a symbol otherwise; may be repeated."),
    ] = None,
    time_limit: TimeLimit = SECONDS,
) -> None:
    """Write criteria as LaTeX, Python, C, Octave or JSON. If anything fails, nothing is written.

    Example: stickslip export exponential polynomial --criterion all --latex criteria.tex --symbol V=v_b
    """
    to_code = asdict(code)
    given = {"latex": latex, **to_code, "json": json}
    targets = {kind: path for kind, path in given.items() if path is not None}
    if not targets:
        *first, last = (f"--{kind} FILE" for kind in given)
        raise InputError(f"nothing to write: give {', '.join(first)} or {last}")
    if "latex" not in targets and (fragment or steps or symbol):
        raise InputError("--fragment, --steps and --symbol belong to --latex FILE")
    require_writable(*targets.values())
    notation = assignments(symbol or [])
    from stickslip_sym.formula.evaluation.averages import slope_average
    from stickslip_sym.output import files

    chosen = chosen_criteria(criterion)
    laws = _laws(law or [], everything, description)
    if notation:
        _check_notation(notation, laws)
    forms, missing, averages = [], [], []
    only_code = targets.keys() <= to_code.keys()
    for one in laws:
        for wanted in chosen:
            found = derived(one, wanted, time_limit)
            if not isinstance(found, NoClosedForm):
                forms.append(found)
                continue
            if len(chosen) == 1 and not everything and not only_code:
                raise found
            missing.append((one, wanted.name, str(found)))
            averages.append(slope_average(one, wanted))
    if not forms and not only_code:
        raise NoClosedForm(f"none of the criteria has a closed form: {missing[0][2]}")
    texts = {
        path: _text(kind, forms, averages, missing, notation, fragment, steps) for kind, path in targets.items()
    }
    if len({path.resolve() for path in texts}) < len(targets):
        raise InputError("two outputs have the same file; give each one of its own")
    files.write_texts(texts)
    for one, name, _ in missing:
        what = "its fast function is written" if only_code else "only its fast function is written, to code"
        typer.echo(f"no closed form: {one.name or one.text}, {name}; {what}", err=True)
    # /dev/stdout holds what was asked for, and nothing else.
    streamed = any(path.exists() and not path.is_file() for path in texts)
    for kind, path in targets.items():
        number = len(forms) + (len(averages) if kind in to_code else 0)
        count = "1 criterion" if number == 1 else f"{number} criteria"
        typer.echo(f"{kind}: {count} in {path}", err=streamed)


def _laws(texts: list[str], everything: bool, description: Description) -> list["FrictionLaw"]:
    from stickslip_sym.model.laws import catalogue

    given = [f"--{option}" for option, value in asdict(description).items() if value]
    if given and len(texts) != 1:
        raise InputError(f"{given[0]} belongs to one law; give one LAW")
    if everything:
        if texts:
            raise InputError(f"--all is every law already; leave out {', '.join(map(repr, texts))}")
        return list(catalogue.values())
    if not texts:
        raise InputError("no law: give names (see: stickslip laws) or formulas in v, or --all")
    for position, text in enumerate(texts):
        if text in texts[:position]:
            raise InputError(f"the law {text!r} is given twice; give it once")
    return [description.law_of(text) for text in texts]


def _check_notation(notation: dict[str, str], laws: "list[FrictionLaw]") -> None:
    """Refuse symbols before anything is derived, which may take long."""
    from stickslip_sym.core import symbols
    from stickslip_sym.output.notation import check_known, notation_of

    every = ["mu", *symbols.QUANTITIES]
    check_known(notation, [*every, *(name for law in laws for name in law.parameters)])
    for law in laws:
        notation_of([*every, *law.parameters], notation)


def _text(
    kind: str, forms: "list[ClosedForm]", averages: "list[SlopeAverage]",
    missing: "list[tuple[FrictionLaw, str, str]]", notation: dict[str, str],
    fragment: bool, steps: bool,
) -> str:  # fmt: skip
    from stickslip_sym.formula.derivation import keeping
    from stickslip_sym.formula.export import export as write

    if kind == "latex":
        return write.export_latex(forms, symbols=notation, fragment=fragment, steps=steps, missing=missing)
    if kind == "json":
        return keeping.collection(forms)
    return write.export_code([*forms, *averages], kind)

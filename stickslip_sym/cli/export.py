"""``stickslip export``: criteria as LaTeX, code or exact text; if one file cannot be written, none is."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import Any

import click

import stickslip_sym as ss
from stickslip_sym.cli import options
from stickslip_sym.cli.arguments import criteria_of, law_described
from stickslip_sym.cli.derive import derived
from stickslip_sym.cli.options import Given, file_option, option, pairs
from stickslip_sym.cli.output import echo_json
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.seconds import SECONDS_TO_DERIVE
from stickslip_sym.formula.code.languages import LANGUAGES

_KINDS = ("latex", *LANGUAGES, "certificate", "save")


@options.command(
    click.Argument(["laws"], nargs=-1, **{**options.LAW_NAMES, "metavar": "[LAW]..."}),
    option("--all", is_flag=True, help="Every law of the catalogue."),
    options.DESCRIPTION, options.PARAMETER, options.criterion("all"),
    file_option("--latex", help="A LaTeX document."),
    *(file_option(f"--{name}", help=language.description) for name, language in LANGUAGES.items()),
    file_option("--certificate", help="A proof in plain SymPy, or FILE.v in Coq."),
    file_option("--save", help="The laws, exact, for stickslip_sym.load."),
    option("--verify", is_flag=True, help="Run the proof of each criterion, and say in LaTeX that it has run."),
    option("--fragment", is_flag=True, help="LaTeX for \\input: without preamble."),
    option("--steps", is_flag=True, help="LaTeX with every step of the derivations."),
    pairs("--symbol", text="Print a symbol otherwise.", example="--symbol V=v_b", metavar="NAME=LATEX"),
    options.time_limit_option(f"Seconds for each criterion ({SECONDS_TO_DERIVE:.0f}).", SECONDS_TO_DERIVE),
)  # fmt: skip
def run(given: Given) -> None:
    """Write criteria as LaTeX, Python, C, Octave or a proof. If anything fails, nothing is written.

    Example: stickslip export exponential polynomial --criterion all --latex criteria.tex --symbol V=v_b
    """
    from stickslip_sym.certificates.closed_forms import certificate_of_forms
    from stickslip_sym.certificates.coq.coq_script import coq_script_of_one
    from stickslip_sym.model.law_files import law_text
    from stickslip_sym.output import files

    targets: dict[str, Path] = {kind: given[kind] for kind in _KINDS if given[kind] is not None}
    if not targets:
        *first, last = (f"--{kind} FILE" for kind in _KINDS)
        raise InputError(f"nothing to write: give {', '.join(first)} or {last}")
    if len({path.resolve() for path in targets.values()}) < len(targets):
        raise InputError("two outputs have the same file; give each one of its own")
    chosen = criteria_of(given["criterion"])
    limit = given["time_limit"]
    every = given["all"]
    laws = _laws_to_export(given)
    code = targets.keys() & LANGUAGES.keys()
    style: dict[str, Any] = {}
    if "latex" in targets:
        style = {"fragment": given["fragment"], "steps": given["steps"], "symbols": given["symbol"]}
    verify = given["verify"]
    in_coq = "certificate" in targets and targets["certificate"].suffix == ".v"
    given.reject_unused()
    unbound = _unbound(laws, every) if code else []
    wanted = [(law, criterion) for law in laws for criterion in chosen]
    forms_of = [(*pair, form) for pair, form in zip(wanted, derived(wanted, limit), strict=True)]
    forms = [form for *_, form in forms_of if not isinstance(form, NoClosedForm)]
    missing = [
        (law, criterion.name, str(form)) for law, criterion, form in forms_of if isinstance(form, NoClosedForm)
    ]
    if missing and len(code) < len(targets) and (not forms or (len(chosen) == 1 and not every)):
        raise NoClosedForm(missing[0][2])
    for form in forms if verify else []:
        verdict = form.verify("coq" if in_coq else "sympy", time_limit=limit)
        click.echo(f"{form.law.name or form.law.text}, {form.criterion.name}: {verdict}", err=True)
    coded = [
        ss.slope_average(law, criterion) if isinstance(form, NoClosedForm) else form
        for law, criterion, form in forms_of
        if code and law not in unbound
    ]
    if "certificate" in targets:
        style["certificate"] = targets["certificate"].name
    write = {
        "latex": lambda: ss.export_latex(forms, missing=missing, **style),
        "certificate": lambda: coq_script_of_one(forms) if in_coq else certificate_of_forms(forms),
        "save": lambda: law_text(laws),
    }
    files.write_texts(
        {
            path: write[kind]() if kind in write else ss.export_code(coded, kind, name=_function_name(kind, path))
            for kind, path in targets.items()
        }
    )
    for law, name, _ in missing:
        is_coded = code and law not in unbound
        what = "its fast function is written as code" if is_coded else "only the reason is written"
        click.echo(f"no closed form: {law.name or law.text}, {name}; {what}", err=True)
    if given["json"]:
        content = [{"law": form.law.name, "criterion": form.criterion.name, "form": form} for form in forms]
        echo_json("export", criteria=content, files=targets)
        return
    # /dev/stdout holds what was asked for, and nothing else.
    streamed = any(path.exists() and not path.is_file() for path in targets.values())
    for kind, path in targets.items():
        count = len(laws if kind == "save" else coded if kind in code else forms)
        word, more = ("law", "laws") if kind == "save" else ("criterion", "criteria")
        click.echo(f"{kind}: {count} {word if count == 1 else more} in {path}", err=streamed)


def _function_name(kind: str, path: Path) -> str:
    """Return the name of a function in a file: Octave finds it by that of the file."""
    if kind == "octave" and path.suffix == ".m":
        return path.stem
    return "damping"


def _laws_to_export(given: Given) -> list[ss.FrictionLaw]:
    texts = given["laws"]
    if given["all"]:
        if texts:
            raise InputError(f"--all is every law already; leave out {', '.join(map(repr, texts))}")
        return [_bound(law, given["parameter"]) for law in ss.laws.values()]
    if not texts:
        raise InputError("no law: give names (see: stickslip laws) or formulas in v, or --all")
    for position, text in enumerate(texts):
        if text in texts[:position]:
            raise InputError(f"the law {text!r} is given twice; give it once")
    described = given if len(texts) == 1 else defaultdict[str, Any](lambda: None)
    values = given["parameter"]
    described_laws = [law_described(described, text) for text in texts]
    known = list(dict.fromkeys(name for law in described_laws for name in law.parameters))
    for name in values:
        if name not in known:
            raise InputError(f"no law has a parameter {name!r}{suggestion(name, known)}")
    return [_bound(law, values) for law in described_laws]


def _bound(law: ss.FrictionLaw, values: dict[str, str]) -> ss.FrictionLaw:
    """Give a law the values of its parameters: code has them as defaults."""
    own = {name: value for name, value in values.items() if name in law.parameters}
    return law.bind(**own) if own else law


def _unbound(laws: list[ss.FrictionLaw], every: bool) -> list[ss.FrictionLaw]:
    """Return the laws that code cannot be written for without values; without --all they are refused."""
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

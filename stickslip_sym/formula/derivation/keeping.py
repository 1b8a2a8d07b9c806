"""Closed forms kept in files: written exactly, read back safely, verified again when asked.

A file is JSON. Every expression stands there as a tree (`trees`), and the criterion once more as text, for
people. A digest tells a file that was changed, by hand or by accident; it is no signature.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from stickslip_sym import criteria
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError, NoClosedForm
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.formula.derivation.gate import verify
from stickslip_sym.formula.derivation.proving import Status, Verdict
from stickslip_sym.formula.derivation.steps import Derivation, Step
from stickslip_sym.model.content import law_in, law_out
from stickslip_sym.model.trees import from_tree, to_tree
from stickslip_sym.output import files, printing

__all__ = ["collection", "load", "load_all", "save", "save_all"]

_FORMAT, _VERSION = "stickslip_sym closed form", 1
_SEVERAL = "stickslip_sym closed forms"
_LARGEST = 20_000_000  # bytes of a file


def save(form: ClosedForm, path: str | Path) -> None:
    """Write a closed form to a file: its law, formula, derivation and verdicts, all exact.

    Parameters
    ----------
    form : ClosedForm
    path : str or Path
        What was there before is replaced at once, or kept if writing fails.

    Raises
    ------
    InputError
        If the file cannot be written, or the form holds a function that has no written form.
    """
    files.write_text(Path(path), json.dumps(_form_out(form), indent=1, ensure_ascii=False) + "\n")


def save_all(forms: Sequence[ClosedForm], path: str | Path) -> None:
    """Write closed forms to one file, each as `save` does.

    Raises
    ------
    InputError
        If the file cannot be written, or a form holds a function that has no written form.
    """
    files.write_text(Path(path), collection(forms))


def collection(forms: Sequence[ClosedForm]) -> str:
    """Return the text of a file that holds closed forms."""
    content = {"format": _SEVERAL, "version": _VERSION, "forms": [_form_out(form) for form in forms]}
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def _form_out(form: ClosedForm) -> dict[str, object]:
    content: dict[str, object] = {
        "format": _FORMAT,
        "version": _VERSION,
        "text": f"{form.criterion.name}: c = {printing.text(form.expr)}",
        "criterion": _criterion_out(form.criterion),
        "formula": to_tree(form.expr),
        "gate": _verdict_out(form.gate),
        "law": law_out(form.law),
        "derivation": {
            "name": form.derivation.name,
            "title": form.derivation.title,
            "steps": [_step_out(step) for step in form.derivation.steps],
        },
    }
    content["digest"] = _digest(content)
    return content


def _criterion_out(criterion: Criterion) -> str | dict[str, object]:
    """Return the name of a criterion of the catalogue, and all there is to know of another one."""
    if criteria.catalogue.get(criterion.name) == criterion:
        return criterion.name
    weight = None if criterion.weight is None else to_tree(criterion.weight)
    return {"name": criterion.name, "weight": weight, "source": criterion.source}


def _criterion_in(content: Any) -> Criterion:
    if isinstance(content, str):
        return criteria.find(content)
    weight = None if content["weight"] is None else from_tree(content["weight"], {})
    return Criterion(content["name"], weight, str(content["source"]))


def _digest(content: Mapping[str, object]) -> str:
    """Return a digest of everything but itself."""
    others = {key: value for key, value in content.items() if key != "digest"}
    return hashlib.sha256(json.dumps(others, sort_keys=True).encode()).hexdigest()


def load(path: str | Path, *, verify: bool = False) -> ClosedForm:
    """Read a closed form from a file that `save` wrote. Nothing in the file is ever evaluated as code.

    Parameters
    ----------
    path : str or Path
    verify : bool
        Compare the formula with quadrature of its definition again, as `derive` does. Otherwise the verdicts
        are those of the file.

    Raises
    ------
    InputError
        If the file cannot be read, is of another format or version, or was changed.
    NoClosedForm
        If `verify` finds that the formula is wrong.
    """
    form = _understood(_checked(_read(Path(path)), path), path)
    return _verified(form) if verify else form


def load_all(path: str | Path, *, verify: bool = False) -> tuple[ClosedForm, ...]:
    """Read closed forms from a file that `save_all` or ``stickslip export --json`` wrote.

    Parameters
    ----------
    path : str or Path
    verify : bool
        As for `load`.

    Raises
    ------
    InputError
        If the file cannot be read, is of another format or version, or was changed.
    NoClosedForm
        If `verify` finds that a formula is wrong.
    """
    content = _read(Path(path))
    if (
        not isinstance(content, dict)
        or content.get("format") != _SEVERAL
        or not isinstance(content.get("forms"), list)
    ):
        raise InputError(
            f"{str(path)!r} holds no {_SEVERAL}; `save_all` writes them, and `load` reads a single one"
        )
    forms = [_understood(_checked(part, path), path) for part in content["forms"]]
    return tuple(_verified(form) if verify else form for form in forms)


def _understood(content: dict[str, Any], path: str | Path) -> ClosedForm:
    try:
        return _form_in(content)
    except InputError as error:
        raise InputError(f"{str(path)!r} holds no closed form that can be read: {error}") from None
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise InputError(f"{str(path)!r} lacks a part, or one has another shape: {error!r}") from None


def _read(path: Path) -> object:
    files.require_name(path)
    try:
        if path.stat().st_size > _LARGEST:
            raise InputError(f"{str(path)!r} has over {_LARGEST} bytes; no closed form is as long")
        return json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{str(path)!r} is no JSON text: {str(error)[:80]}") from None


def _checked(content: object, path: str | Path) -> dict[str, Any]:
    """Refuse what is no closed form of this version, or was changed."""
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise InputError(f"{str(path)!r} is no {_FORMAT}; `save` writes one")
    if type(content.get("version")) is not int or content["version"] != _VERSION:
        raise InputError(
            f"{str(path)!r} is of version {content.get('version')!r}, and this package reads version {_VERSION}; "
            "derive the form again, or use the package that wrote it"
        )
    if content.get("digest") != _digest(content):
        raise InputError(f"{str(path)!r} was changed since it was saved; derive the form again")
    return content


def _form_in(content: dict[str, Any]) -> ClosedForm:
    law = law_in(content["law"])
    names = {name: parameter.symbol for name, parameter in law.parameters.items()}
    expr = from_tree(content["formula"], names)
    criterion = _criterion_in(content["criterion"])
    steps = [_step_in(step, names) for step in content["derivation"]["steps"]]
    derivation = Derivation(str(content["derivation"]["name"]), str(content["derivation"]["title"]), steps)
    form = ClosedForm(law, criterion, expr, derivation, _verdict_in(content["gate"]))
    strange = expr.free_symbols - set(form.arguments.values())
    if strange:
        raise InputError(f"its formula holds {', '.join(map(str, strange))}, which the law does not have")
    if not steps:
        raise InputError("its derivation has no steps")
    if {Status.REFUTED, Status.UNDECIDED} & {derivation.status, form.gate.status}:
        raise InputError("it is marked as refuted or undecided, and such a form is never returned")
    return form


def _verified(form: ClosedForm) -> ClosedForm:
    gate = verify(form.law, form.criterion, form.expr)
    if gate.status is Status.REFUTED:
        raise NoClosedForm(f"the formula in the file is refuted, so it is not returned: {gate.evidence}")
    if gate.status is Status.UNDECIDED:
        raise NoClosedForm(f"the formula in the file could not be checked, so it is not returned: {gate.evidence}")
    return ClosedForm(form.law, form.criterion, form.expr, form.derivation, gate)


# -- derivations -----------------------------------------------------------------------------------


def _step_out(step: Step) -> dict[str, object]:
    return {
        "operation": step.operation,
        "reason": step.reason,
        "statement": to_tree(step.statement),
        "label": step.label,
        "verdict": _verdict_out(step.verdict),
    }


def _step_in(content: dict[str, Any], names: dict[str, Expr]) -> Step:
    operation, reason, label = (str(content[key]) for key in ("operation", "reason", "label"))
    statement = from_tree(content["statement"], names)
    return Step(operation, reason, statement, _verdict_in(content["verdict"]), label)


def _verdict_out(verdict: Verdict) -> dict[str, str]:
    return {"status": verdict.status.value, "evidence": verdict.evidence}


def _verdict_in(content: dict[str, str]) -> Verdict:
    return Verdict(Status(content["status"]), str(content["evidence"]))

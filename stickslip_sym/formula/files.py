"""Closed forms, laws and fits kept in files: written as text, read back safely.

A file is JSON. A closed form stands there as its law, its criterion and the text of its formula. It is derived
again when it is read, so its verdict is computed, and a file whose formula or verdict is another one is refused.
So is a fit: it stands there as its law and the measurements, and is fitted again.
Nothing in a file is ever evaluated as code. A digest tells a file that was changed, by hand or by accident; it is
no signature.
"""

import hashlib
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym import criteria
from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import exact, require_type
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.closed_form import ClosedForm, derive
from stickslip_sym.model.content import law_in, law_out
from stickslip_sym.model.fitting.fit import fit as fit_laws
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output import files, printing

_FORMAT, _VERSION = "stickslip_sym", 2
_LARGEST = 20_000_000  # bytes of a file
_BROKEN = (KeyError, TypeError, ValueError, AttributeError, IndexError)
_SAME = 1e-6  # relative difference of fitted values that are one minimum, on another machine too

Item = ClosedForm | FrictionLaw | Fit | Fits


def save(items: Item | Sequence[Item], path: str | Path) -> None:
    """Write a closed form, a law, a fit, or several of them to a file.

    Parameters
    ----------
    items : ClosedForm, FrictionLaw, Fit, Fits, or a sequence of them
    path : str or Path
        What was there before is replaced at once, or kept if writing fails.

    Raises
    ------
    InputError
        If the file cannot be written, or an item is none of these.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from stickslip_sym import laws
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "laws.json")
    ...     save([laws.linear, laws.cubic], path)
    ...     print([law.name for law in load(path)])
    ['linear', 'cubic']
    """
    require_type("path", path, str | PathLike, "the name of a file")
    files.write_text(Path(path), text_of(items))


def text_of(items: Item | Sequence[Item]) -> str:
    """Return the text of the file that `save` writes."""
    single = isinstance(items, Item)
    listed = list(items) if isinstance(items, Iterable) and not single else [items]
    content: dict[str, object] = {
        "format": _FORMAT, "version": _VERSION, "single": single, "items": [_item_out(item) for item in listed]
    }  # fmt: skip
    content["digest"] = _digest(content)
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def load(path: str | Path) -> Item | tuple[Item, ...]:
    """Read what `save` or ``stickslip export --save`` wrote.

    A closed form is derived, proved and compared with its definition again, which takes up to a second; its
    verdict is computed, and not read.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    ClosedForm, FrictionLaw, Fit or Fits, or a tuple of them if several were saved

    Raises
    ------
    InputError
        If the file cannot be read, is of another format or version, was changed, or holds a formula or a verdict
        that is not that of its law and criterion.
    NoClosedForm
        If there is none for a law and a criterion in the file.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from stickslip_sym import derive
    >>> with TemporaryDirectory() as folder:
    ...     save(derive("mu_s - a*v"), Path(folder, "linear.json"))
    ...     load(Path(folder, "linear.json")).expr
    N*a
    """
    require_type("path", path, str | PathLike, "the name of a file")
    name = repr(str(path))
    content = _read(Path(path), name)
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise InputError(f"{name} holds no closed form and no law; `save` writes them")
    version = content.get("version")
    if type(version) is not int or version != _VERSION:
        raise InputError(
            f"{name} is of version {version!r}, and this package reads version {_VERSION}; "
            "derive the form again, or use the package that wrote it"
        )
    if content.pop("digest", None) != _digest(content):
        raise InputError(f"{name} was changed since it was saved; derive the form again")
    try:
        items = tuple(_item_in(item) for item in content["items"])
        return items[0] if content["single"] else items
    except InputError as error:
        raise InputError(f"{name} holds something that cannot be read: {error}") from None
    except _BROKEN as error:
        raise InputError(f"{name} lacks a part, or one has another shape: {error!r}") from None


def _read(path: Path, name: str) -> object:
    try:
        if path.stat().st_size > _LARGEST:
            raise InputError(f"{name} has over {_LARGEST} bytes; nothing that is saved here is as long")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read {name}: {error.strerror or error}") from None
    except ValueError as error:
        raise InputError(f"{name} is no text in UTF-8: {str(error)[:80]}") from None
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name} is no JSON text: {str(error)[:80]}") from None


def _digest(content: dict[str, Any]) -> str:
    """Return a digest of everything but itself."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


# -- items -------------------------------------------------------------------------------------------


def _item_out(item: object) -> dict[str, object]:
    if isinstance(item, FrictionLaw):
        return {"kind": "law", "law": law_out(item)}
    if isinstance(item, Fits):
        return _fits_out(item)
    if isinstance(item, Fit):
        weight = {"weight": item.weight, "aicc": item.aicc if math.isfinite(item.aicc) else None}
        return _fits_out(Fits([item], item.measured, {})) | {"kind": "fit"} | weight
    if not isinstance(item, ClosedForm):
        raise InputError(
            f"closed forms, laws and fits are saved, got {type(item).__name__}; save its .law, for example"
        )
    if item.origin is not None:
        source, parameter = item.origin
        return {"kind": "sensitivity", "to": parameter, "of": _item_out(source), **_claims(item)}
    criterion = _criterion_out(item.criterion)
    return {"kind": "closed form", "law": law_out(item.law), "criterion": criterion, **_claims(item)}


def _claims(form: ClosedForm) -> dict[str, str]:
    """Return what a file says of a form, and what is computed again when it is read."""
    return {"formula": printing.text(form.expr), "status": form.verdict.status.value}


def _item_in(content: dict[str, Any]) -> Item:
    kind = content["kind"]
    if kind in ("fit", "fits"):
        fits, aicc = _fits_in(content), content.get("aicc")
        if kind == "fits":
            return fits
        return replace(fits.best, weight=content["weight"], aicc=math.inf if aicc is None else aicc)
    return law_in(content["law"]) if kind == "law" else _form_in(content)


def _form_in(content: dict[str, Any]) -> ClosedForm:
    """Return a closed form of a file, derived again, or refuse claims that are not its own."""
    if content["kind"] == "sensitivity":
        form = _form_in(content["of"]).sensitivity(content["to"])
    else:
        form = derive(law_in(content["law"]), _criterion_in(content["criterion"]))
    for name, right in _claims(form).items():
        if content[name] != right:
            wrong = str(content[name])[:80]
            raise InputError(f"its {name} is {wrong!r}, and that of its law and criterion is {right[:80]!r}")
    return form


def _fits_out(fits: Fits) -> dict[str, object]:
    measured = {field.name: getattr(fits.measured, field.name) for field in fields(fits.measured) if field.init}
    return {
        "kind": "fits",
        "fits": [{"law": law_out(fit.free_law), "values": dict(fit.values)} for fit in fits],
        "rejected": fits.rejected,
        "measurements": {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in measured.items()
            if not name.startswith("_")
        },
    }


def _fits_in(content: dict[str, Any]) -> Fits:
    """Return the fits of a file, fitted again, or refuse values that are not those of its measurements."""
    columns: dict[str, Any] = {
        name: np.array(x) if isinstance(x, list) else x for name, x in content["measurements"].items()
    }
    measured = Measurements(**columns)
    fitted = list(fit_laws(measured, laws=[law_in(saved["law"]) for saved in content["fits"]]))
    for fit, saved in zip(fitted, content["fits"], strict=True):
        for name, value in saved["values"].items():
            right = fit.values[name]
            if not math.isclose(right, value, rel_tol=_SAME, abs_tol=_SAME * fit.standard_errors[name]):
                what = f"{name} = {value!r} of the law {fit.name}"
                raise InputError(f"{what} is not that of its measurements, {right!r}")
    return Fits(fitted, measured, content["rejected"])


def _criterion_out(criterion: Criterion) -> str | dict[str, object]:
    """Return the name of a criterion of the catalogue, and all there is to know of another one."""
    if criteria.catalogue.get(criterion.name) == criterion:
        return criterion.name
    weight: object = None if criterion.weight is None else "harmonic"
    if criterion.is_polynomial:
        weight = [str(number) for number in sp.Poly(criterion.weight, symbols.s).all_coeffs()]
    return {"name": criterion.name, "weight": weight, "source": criterion.source}


def _criterion_in(content: Any) -> Criterion:
    if isinstance(content, str):
        return criteria.find(content)
    weight = content["weight"]
    if weight == "harmonic":
        weight = criteria.harmonic.weight
    elif weight is not None:
        weight = sp.Poly([exact(number, "a coefficient") for number in weight], symbols.s).as_expr()
    return Criterion(content["name"], weight, str(content["source"]))

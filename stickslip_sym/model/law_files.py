"""Laws kept in files: written as text, read back safely.

A file is JSON: a law stands there as the formula that was read, its parameters and its values, exact. Nothing in a
file is ever evaluated as code. A digest tells a file that was changed, by hand or by accident; it is no signature.
"""

import hashlib
import json
from collections.abc import Iterable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from stickslip_sym.core.aliases import Json
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import require_type
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.law_content import law_in, law_out
from stickslip_sym.output import files

_FORMAT, _VERSION = "stickslip_sym", 2
_BROKEN = (KeyError, TypeError, ValueError, AttributeError, IndexError)


def save(laws: FrictionLaw | Sequence[FrictionLaw], path: str | Path) -> None:
    """Write a law, or several, to a file.

    Parameters
    ----------
    laws : FrictionLaw, or a sequence of them
    path : str or Path
        What was there before is replaced at once, or kept if writing fails.

    Raises
    ------
    InputError
        If the file cannot be written, or one of them is no law.

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
    files.write_text(Path(path), law_text(laws))


def law_text(laws: FrictionLaw | Sequence[FrictionLaw]) -> str:
    """Return the text of the file that `save` writes."""
    single = not isinstance(laws, Iterable)
    listed: list[Any] = list(laws) if isinstance(laws, Iterable) else [laws]
    for law in listed:
        if not isinstance(law, FrictionLaw):
            raise InputError(
                f"laws are saved, got {type(law).__name__}; save its .law, from which it is made again"
            )
    items = [{"kind": "law", "law": law_out(law)} for law in listed]
    content: dict[str, object] = {"format": _FORMAT, "version": _VERSION, "single": single, "items": items}
    content["digest"] = _digest(content)
    return json.dumps(content, indent=1, ensure_ascii=False) + "\n"


def load(path: str | Path) -> FrictionLaw | tuple[FrictionLaw, ...]:
    """Read what `save` or ``stickslip export --save`` wrote.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    FrictionLaw, or a tuple of them if several were saved

    Raises
    ------
    InputError
        If the file cannot be read, is of another format or version, was changed, or holds what is no law.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     save(FrictionLaw("mu_s - a*v"), Path(folder, "linear.json"))
    ...     load(Path(folder, "linear.json")).text
    'mu_s - a*v'
    """
    require_type("path", path, str | PathLike, "the name of a file")
    name = repr(str(path))
    content = _read_json(Path(path), name)
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise InputError(f"{name} holds no law; `save` writes them")
    version = content.get("version")
    if type(version) is not int or version != _VERSION:
        raise InputError(
            f"{name} is of version {version!r}, and this package reads version {_VERSION}; "
            "make the law again, or use the package that wrote it"
        )
    if content.pop("digest", None) != _digest(content):
        raise InputError(f"{name} was changed since it was saved; make the law again")
    try:
        items = tuple(_law_in(item) for item in content["items"])
        return items[0] if content["single"] else items
    except InputError as error:
        raise InputError(f"{name} holds something that cannot be read: {error}") from None
    except _BROKEN as error:
        raise InputError(f"{name} lacks a part, or one has another shape: {error!r}") from None


def _read_json(path: Path, name: str) -> object:
    try:
        text = files.read_bytes(path).decode()
    except UnicodeDecodeError as error:
        raise InputError(f"{name} is no text in UTF-8: {str(error)[:80]}") from None
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{name} is no JSON text: {str(error)[:80]}") from None


def _digest(content: Json) -> str:
    """Return a digest of everything but itself."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _law_in(item: Json) -> FrictionLaw:
    if item["kind"] != "law":
        raise InputError(f"a {item['kind']}: laws alone are kept in files, and the rest is made from them again")
    return law_in(item["law"])

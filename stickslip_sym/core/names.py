"""Names that users give: looked up in a table, with the closest one where there is none."""

from collections.abc import Mapping
from difflib import get_close_matches
from typing import TypeVar

from stickslip_sym.core.errors import InputError

T = TypeVar("T")


def lookup(kind: str, name: str, table: Mapping[str, T]) -> T:
    """Return the entry of a table, or raise an `InputError` that suggests the closest name."""
    if isinstance(name, str) and name in table:
        return table[name]
    known = ", ".join(table)
    raise InputError(f"there is no {kind} {str(name)[:60]!r}{suggestion(str(name), table)}; known: {known}")


def suggestion(wrong: str, known: Mapping[str, object] | list[str]) -> str:
    """Return ' (did you mean ...?)' when a known name is close to the wrong one, else an empty text."""
    close = get_close_matches(wrong, list(known), n=1, cutoff=0.6)
    if close:
        return f" (did you mean {close[0]!r}?)"
    return ""

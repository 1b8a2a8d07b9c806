"""Scripts that leave the package: pages of text with sections, and names that are safe in them."""

import builtins
import keyword
import re
from collections.abc import Iterable
from pathlib import Path


def sections(page: Path) -> dict[str, str]:
    """Return the sections of a page of text, each of which begins with a line "@@ name", by their names."""
    parts = page.read_text(encoding="utf-8").split("@@ ")[1:]
    return dict(part.split("\n", 1) for part in parts)


def imported(script: str, names: Iterable[str]) -> str:
    """Return those of some names, parted by commas, that a script uses."""
    return ", ".join(name for name in names if re.search(rf"\b{name}\b", script))


def safe_names(names: Iterable[str], script: str) -> dict[str, str]:
    """Return names of variables in a script for names of parameters: none is a word of Python or of the script."""
    taken = {*keyword.kwlist, *dir(builtins), *re.findall(r"[^\W\d]\w*", script)}
    safe: dict[str, str] = {}
    for name in names:
        candidate = name if name.isidentifier() else re.sub(r"\W", "_", f"p_{name}")
        while candidate in taken:
            candidate += "_"
        taken.add(candidate)
        safe[name] = candidate
    return safe

"""What scripts that leave the package share: lines that are chosen, imports, and names that are safe in them."""

import builtins
import keyword
import re
from collections.abc import Iterable


def chosen_lines(text: str, names: set[str]) -> str:
    """Return text without the lines for what a script has none of, which say so: ``# if Min Max``."""
    lines = [line.partition("  # if ") for line in text.splitlines()]
    return "\n".join(line for line, _, needed in lines if not needed or names & set(needed.split()))


def imported(script: str, names: Iterable[str]) -> str:
    """Return those of some names, parted by commas, that a script uses."""
    return ", ".join(name for name in names if re.search(rf"\b{name}\b", script))


class SafeNames:
    """Names of variables in a script, for names of parameters: none is a word of Python or of the script.

    Two are never the same. `own` are those that the script makes itself, as it goes.
    """

    def __init__(self, script: str, own: str = r"(?!)") -> None:
        self._taken = {*keyword.kwlist, *dir(builtins), *re.findall(r"[^\W\d]\w*", script)}
        self._own = re.compile(own)

    def new(self, name: str) -> str:
        """Return a name like another that is not taken yet."""
        candidate = re.sub(r"\W", "_", name)
        if not candidate.isidentifier() or self._own.fullmatch(candidate):
            candidate = f"p_{candidate}"
        while candidate in self._taken:
            candidate += "_"
        self._taken.add(candidate)
        return candidate

"""Mutants that were shown to be equivalent: no test can notice them, for the reason that stands beside each."""

import tomllib
from pathlib import Path

from mutants import Mutant

KEPT = Path(__file__).with_name("equivalent.toml")
"""One table for each: the definition it is in, the text of what was changed before and after, and why."""


class Equivalents:
    """The mutants that were shown to be equivalent, found again wherever their code has moved."""

    def __init__(self) -> None:
        entries = tomllib.loads(KEPT.read_text()).get("equivalent", [])
        self._why = {
            (entry["definition"], entry["before"], after): entry["why"]
            for entry in entries
            for after in ([entry["after"]] if isinstance(entry["after"], str) else entry["after"])
        }
        self.used: set[tuple[str, str, str]] = set()

    def why(self, mutant: Mutant) -> str:
        """Return why a mutant is equivalent, nothing if that was not shown."""
        key = (mutant.definition, *mutant.change)
        if key in self._why:
            self.used.add(key)
        return self._why.get(key, "")

"""The names that a shell completes. It asks at every key, so nothing slow may be imported here."""

import ast
from pathlib import Path

__all__ = ["complete_criterion", "complete_criterion_or_all", "complete_law", "complete_method"]


def complete_law(incomplete: str) -> list[str]:
    """Return the laws of the catalogue whose names begin so."""
    return _beginning(incomplete, _names("model/laws.py", "_law"))


def complete_criterion(incomplete: str) -> list[str]:
    """Return the criteria whose names begin so."""
    return _beginning(incomplete, _criteria())


def complete_criterion_or_all(incomplete: str) -> list[str]:
    """Return the criteria whose names begin so, and "all"."""
    return _beginning(incomplete, [*_criteria(), "all"])


def complete_method(incomplete: str) -> list[str]:
    """Return the rungs of the ladder whose names begin so, and "auto"."""
    return _beginning(incomplete, [*_criteria(), *_names("motion/thresholds/rungs.py", "Rung"), "auto"])


def _criteria() -> list[str]:
    return _names("criteria/criterion.py", "Criterion")


def _names(file: str, made_by: str) -> list[str]:
    """Return the names of the entries that a file makes; it is read, not run."""
    source = Path(__file__).parents[2].joinpath(file).read_text(encoding="utf-8")
    calls = [
        (node.lineno, str(node.args[0].value))
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id == made_by
        and isinstance(node.args[0], ast.Constant)
    ]
    return [name for _, name in sorted(calls)]


def _beginning(incomplete: str, names: list[str]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]

"""The names that a shell completes. It asks at every key, so nothing slow may be imported here."""

import ast
from pathlib import Path

__all__ = ["complete_criterion", "complete_criterion_or_all", "complete_law", "complete_method"]

# Test-checked copies of what takes a second to import.
CRITERIA = ("equilibrium", "least_squares", "harmonic")
METHODS = (*CRITERIA, "second_order", "orbit", "simulation", "auto")


def complete_law(incomplete: str) -> list[str]:
    """Return the laws of the catalogue whose names begin so; the catalogue is read, not run."""
    source = Path(__file__).parents[1].joinpath("model", "laws.py").read_text(encoding="utf-8")
    names = [
        call.args[0].value
        for call in ast.walk(ast.parse(source))
        if isinstance(call, ast.Call)
        and isinstance(call.func, ast.Name)
        and call.func.id == "_law"
        and isinstance(call.args[0], ast.Constant)
    ]
    return _beginning(incomplete, [str(name) for name in names])


def complete_criterion(incomplete: str) -> list[str]:
    """Return the criteria whose names begin so."""
    return _beginning(incomplete, CRITERIA)


def complete_criterion_or_all(incomplete: str) -> list[str]:
    """Return the criteria whose names begin so, and "all"."""
    return _beginning(incomplete, (*CRITERIA, "all"))


def complete_method(incomplete: str) -> list[str]:
    """Return the rungs of the ladder whose names begin so, and "auto"."""
    return _beginning(incomplete, METHODS)


def _beginning(incomplete: str, names: list[str] | tuple[str, ...]) -> list[str]:
    return [name for name in names if name.startswith(incomplete)]

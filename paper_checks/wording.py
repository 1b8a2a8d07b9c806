"""Numbers as the evidence of a check words them."""

from collections.abc import Iterable

__all__ = ["listed", "percent"]


def listed(numbers: Iterable[float], digits: int = 4) -> str:
    """Write numbers to a number of decimals, with commas."""
    return ", ".join(f"{number:.{digits}f}" for number in numbers)


def percent(*fractions: float, digits: int = 2) -> str:
    """Write fractions as signed per cent, with commas."""
    return ", ".join(f"{100 * fraction:+.{digits}f} %" for fraction in fractions)

"""Numbers of the command line: exact, and of a size that an operating point may have."""

from typing import Any

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import fraction

__all__ = ["check_size", "read_number"]

_LARGEST = 10**20
"""Of a number in SI units, and its inverse the smallest: beyond, no table could be computed in doubles."""


def read_number(text: Any, name: str) -> float:
    """Read a number; the name is for the refusal.

    Raises `InputError` for what is no number, or has a size that no operating point has.
    """
    value = fraction(text, name)
    check_size(name, value)
    return float(value)


def check_size(name: str, value: Any) -> None:
    """Refuse a number of a size that no operating point has."""
    size = abs(value)
    if size == 0 or 1 <= size * _LARGEST <= _LARGEST**2:
        return
    if size > 1:
        reason = "beyond what double precision can hold" if float(size) == float("inf") else "too large"
    else:
        reason = "below what double precision can hold" if float(size) == 0 else "too small"
    raise InputError(f"{name} is {reason}; give a size from {1 / _LARGEST:g} to {_LARGEST:g} in SI units")

"""The header of a file of measured points: v in m/s, then mu, and nothing else is taken for it.

Units and columns are not converted or reordered; a header that says anything else is refused with what it says.
"""

import re
from collections.abc import Sequence

from stickslip_sym.core.errors import InputError

__all__ = ["check_header"]

EXPECTED = "v [m/s],mu"

_SPEED_UNITS = frozenset({"m/s", "m s^-1", "m*s^-1", "m.s^-1", "m s**-1", "m*s**-1", "m·s^-1", "m s⁻¹", "m·s⁻¹"})
_NO_UNITS = frozenset({"1", "-", "–", "—", "dimensionless", "none"})
_SPEEDS = frozenset(
    {f"{kind} {word}" for kind in ("slip", "sliding", "relative") for word in ("speed", "velocity")}
    | {"speed", "velocity", "v", "v_rel", "v_slip"}
)
_COEFFICIENTS = frozenset({"mu", "μ", "friction coefficient", "coefficient of friction", "cof"})
_CELL = re.compile(
    r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|/?\s*\((?P<round>[^()]*)\)|\bin\s+(?P<words>\S.*))?", re.DOTALL
)


def check_header(cells: Sequence[str], line: str) -> None:
    """Refuse a header that does not say v in m/s and mu, in this order.

    Parameters
    ----------
    cells : sequence of str
        The first line of a file, parted at its commas.
    line : str
        What the file is, for the message.

    Raises
    ------
    InputError
        With what was read, what is wrong with it, and what to write.
    """
    if wrong := _wrong(cells):
        read = ",".join(cells)
        shown = repr(read[:60]) + ("..." if len(read) > 60 else "")
        raise InputError(
            f"{line} must begin with a header of two columns, v in m/s and mu in that order, like {EXPECTED}, or "
            f"with its first point; got {shown}: {wrong}"
        )


def _wrong(cells: Sequence[str]) -> str | None:
    """Return what is wrong with a header; None if nothing is."""
    if len(cells) != 2:
        return _other_separator(cells) or f"it has {len(cells)} column{'s' * (len(cells) != 1)}"
    (speed, unit), (coefficient, no_unit) = map(_parts, cells)
    if speed in _COEFFICIENTS and coefficient in _SPEEDS:
        return "the columns are in the other order; write the speed first, in the lines below too"
    if speed not in _SPEEDS:
        return f"{_shown(cells[0])} is not the slip speed v"
    if coefficient not in _COEFFICIENTS:
        return f"{_shown(cells[1])} is not the friction coefficient mu"
    if unit is None and cells[0].strip() != "v":  # V is the belt speed, or volts
        return f"{_shown(cells[0])} has no unit; write v if it is the slip speed in m/s"
    if unit is not None and unit not in _SPEED_UNITS:
        return f"{_shown(unit)} is not m/s; convert the speeds to m/s, and write so"
    if no_unit is not None and no_unit not in _NO_UNITS:
        return f"{_shown(no_unit)} is no unit of mu, which is a ratio of forces; convert it to a plain number"
    return None


def _parts(cell: str) -> tuple[str, str | None]:
    """Return a column's name in small letters, and its unit as written, None if it has none."""
    match = _CELL.fullmatch(cell.replace("\N{MICRO SIGN}", "μ").strip())
    if match is None:
        return cell, None
    unit = next((text for text in match.group("square", "round", "words") if text is not None), None)
    name = " ".join(match["name"].lower().split())
    return name, None if unit is None else " ".join(unit.split())


def _other_separator(cells: Sequence[str]) -> str | None:
    for separator, name in ((";", "semicolons"), ("\t", "tabs"), ("|", "bars")):
        if any(separator in cell for cell in cells):
            return f"{name} part its columns; write commas there, and points in decimal numbers"
    return None


def _shown(text: str) -> str:
    return repr(text.strip()[:30])

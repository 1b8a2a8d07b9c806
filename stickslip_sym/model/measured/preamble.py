"""What lines above a table say of it: the radius of the track, which turns a rotational speed into one of slip."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from stickslip_sym.core.units import dimensions

_RADIUS = re.compile(
    r"(?P<name>[^\[\](){}:=]*\bradius\b[^\[\](){}:=]*)(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*(?:[:=]\s*(?P<value>.*))?",
    re.IGNORECASE,
)
_OF_TRACK = re.compile(r"track\W*radius|radius\s+of\s+(the\s+)?(wear\s+)?track", re.IGNORECASE)
# A comma before three digits may stand between thousands.
_VALUE = re.compile(r"(?P<number>\d+(?:\.\d*|,(?!\d{3}\b)\d+)?)\s*(?P<unit>[A-Za-zµμ]*)")


@dataclass(frozen=True)
class WrittenRadius:
    """A radius above a table: its line, its name and value as written, and its size in m where that is certain.

    That is where it has a unit of length and is said to be that of the track.
    """

    line: int
    name: str
    text: str
    size: Fraction | None


def written_radius(lines: Sequence[tuple[int, Sequence[str]]]) -> WrittenRadius | None:
    """Return the radius that lines of cells, each with its number, name; None where they name none, or several.

    Its value stands behind its name, in the next cell, or below it.
    """
    found = []
    for (number, cells), (_, below) in pairwise([*lines, (0, ())]):
        for i, cell in enumerate(cells):
            match = _RADIUS.fullmatch(cell)
            if match is None:
                continue
            places = [match["value"] or "", *cells[i + 1 : i + 2], *below[i : i + 1]]
            value = next(filter(None, map(_VALUE.fullmatch, places)), None)
            if value is not None:
                found.append(_read_radius(number, match, value, "".join(cells[i + 2 : i + 3])))
    different = {(radius.text, radius.size) for radius in found}
    return found[0] if len(different) == 1 else None


def _read_radius(line: int, match: re.Match[str], value: re.Match[str], behind: str) -> WrittenRadius:
    """Return a radius from its name and value; its unit is with either, or in the cell behind the value."""
    units = [unit for unit in (match["unit"], value["unit"], behind) if unit and _metres(unit)]
    length = _metres(units[0]) if units else None
    size = None
    if length is not None and _OF_TRACK.search(match["name"]):
        size = Fraction(value["number"].replace(",", ".")) * length
    if units:
        text = f"{value['number']} {units[0]}"
    else:
        text = value["number"]
    return WrittenRadius(line, match["name"].strip(), text, size)


def _metres(unit: str) -> Fraction | None:
    """Return the size in m of a unit of length; None for any other text."""
    known = dimensions(unit)
    metres = dimensions("m")
    if known is not None and metres is not None and known[1] == metres[1]:
        return known[0]
    return None

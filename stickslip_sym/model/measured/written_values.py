"""Cells that say more than a number: its standard error, 0.44(5) or 0.44 ± 0.05, or its unit, 10 mm/s."""

import re
from collections.abc import Sequence

from stickslip_sym.core.units import last_digits
from stickslip_sym.model.measured.columns import HeaderColumn, read_unit

_NUMBER = r"(?:\d+[.,]?\d*|[.,]\d+)(?:[eE][+-]?\d{1,4})?"
_PLAIN = re.compile(rf"[+-]?{_NUMBER}")
_VALUE = re.compile(
    rf"(?P<number>[+-]?{_NUMBER})\s*(?:(?:\+/-|±)\s*(?P<error>{_NUMBER})|\((?P<last>\d+)\))?\s*(?P<unit>[^\W\d].*|%)?"
)


def is_value(cell: str) -> bool:
    """Return whether a cell is a number, alone or with its standard error or a unit that is known."""
    match = _VALUE.fullmatch(cell)
    return match is not None and (match["unit"] is None or read_unit(match["unit"]) is not None)


def split_values(
    header: Sequence[str], rows: Sequence[tuple[int, list[str]]]
) -> tuple[list[str], Sequence[tuple[int, list[str]]]]:
    """Return a header and rows with units of cells in the header, and standard errors as columns at the end.

    Only columns are split in which every row has the same unit, and a standard error where one has it; cells of
    others stay as they are, and are no numbers.
    """
    names = list(header)
    count = len(header)
    wide = [i for i, (_, row) in enumerate(rows) if len(row) >= count and not any(row[count:])]
    if not wide or not any(header):
        return names, rows
    first = rows[wide[0]][1]
    split = [column for column in range(count) if is_value(first[column]) and not _PLAIN.fullmatch(first[column])]
    if not split:
        return names, rows
    cells = [(line, list(row)) for line, row in rows]
    for column in split:
        values = {i: _VALUE.fullmatch(cells[i][1][column]) for i in wide}
        matches = {i: match for i, match in values.items() if match is not None}
        units = {match["unit"] for match in matches.values()}
        have_errors = {_error(match) is not None for match in matches.values()}
        if len(units) > 1 or len(have_errors) > 1:
            continue
        read = HeaderColumn.read(header[column])
        if (unit := units.pop()) is not None:
            if read.unit_text and read_unit(read.unit_text) != read_unit(unit):
                continue
            names[column] = header[column] if read.unit_text else f"{header[column]} [{unit}]"
        if have_errors.pop():
            names.append(_name_of_errors(HeaderColumn.read(names[column])))
            for i in wide:
                error = _error(matches[i]) if i in matches else None
                cells[i] = cells[i][0], [*cells[i][1][: len(names) - 1], error or ""]
        for i, match in matches.items():
            cells[i][1][column] = match["number"]
    return names, cells


def _error(match: re.Match[str]) -> str | None:
    """Return a standard error with the decimal sign of its number; None where there is none."""
    if match["last"] is None:
        return match["error"]
    error = str(last_digits(match["number"].replace(",", "."), match["last"]))
    if "," in match["number"]:
        return error.replace(".", ",")
    return error


def _name_of_errors(column: HeaderColumn) -> str:
    """Return the name of a column of standard errors: of friction they are read, of anything else they are not."""
    if column.meanings == ("mu",):
        if column.unit_text in ("", "1", "-"):
            return "sigma_mu"
        return f"deviation of {column.name}"
    if column.meanings == ("F_t",):
        if column.unit_text:
            return f"sigma_F_t [{column.unit_text}]"
        return "sigma_F_t"
    return f"deviation of {column.name}"

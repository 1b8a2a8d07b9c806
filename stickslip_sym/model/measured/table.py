"""A table of numbers as text: how its columns are parted, which sign is decimal, and which line is its header."""

import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.headers import Columns, choose_columns, is_header, read_header
from stickslip_sym.model.measured.units import read_unit
from stickslip_sym.output.files import require_name

__all__ = ["Table", "read_table"]

SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars", ",": "commas", " ": "blanks"}
"""What separates columns, by preference: a comma may also be a decimal sign, and blanks may stand in a name."""
MOST_ROWS = 1_000_000  # of a file; a longer one is refused before its numbers are read
_LONGEST = 10_000  # characters of a line
_COMMENT = re.compile(r"^\s*([#%!]|//)\s*")
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")
_BETWEEN_BLANKS = re.compile(r'"[^"]*"|(?:\[[^\[\]]*\]|\([^()]*\)|\S)+')
_LOOKED_AT = 400  # lines, of which most look alike: enough to tell how a file is written
_NUMBER = r"[+-]?(\d+{sign}?\d*|{sign}\d+)([eE][+-]?\d{{1,4}})?"
_NUMBERS = {sign: re.compile(_NUMBER.format(sign=re.escape(sign)), re.ASCII) for sign in ".,"}
_HEADERLESS = read_header(["v", "mu"])


@dataclass(frozen=True)
class Table:
    """The cells of a file's columns that are needed, as text with a decimal point, and where they stand.

    Attributes
    ----------
    columns : Columns
    cells : dict of str to list of str
        By quantity.
    lines : list of int
        The line of the file, from 1, of each row.
    """

    columns: Columns
    cells: dict[str, list[str]]
    lines: list[int]


def read_table(path: Path) -> Table:
    """Read the columns of a text file that hold measurements.

    Raises
    ------
    InputError
        If the file cannot be read, its header is not understood, or a cell that is needed is no number; the
        message names line and column.
    """
    name = repr(str(path))
    lines = _text(path).splitlines()
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise InputError(f"{name}, line {number}: it has {len(line)} characters; a row is a line of its own")
    first = [_COMMENT.sub("", line, count=1) for line in lines[:_LOOKED_AT] if line.strip()]
    if not first:
        raise InputError(f"{name} has no points; write a line for each, like 0.1,0.35")
    separator = _separator(first)
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip()]
    head, columns, unit_line = _header(rows, separator, name)
    body = [(n, line) for n, line in rows if n > max(head, unit_line) and not _COMMENT.match(line)]
    if len(body) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    if not body:
        raise InputError(f"{name} has no points below line {head}; write a line for each, like 0.1,0.35")
    return _cells(body, columns, separator, name)


def _text(path: Path) -> str:
    require_name(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
    try:
        if content.startswith((b"\xff\xfe", b"\xfe\xff")):
            return content.decode("utf-16")
        if b"\0" in content:
            raise InputError(f"{str(path)!r} is not a text file of comma-separated values: it holds null bytes")
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if b"\0" not in content:
            return content.decode("cp1252", errors="replace")  # as older instruments write the micro sign
        raise InputError(f"{str(path)!r} is not a text file of comma-separated values: {error}") from None


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":  # but v [mm/s] is one name
        return [name.strip('"') for name in _BETWEEN_BLANKS.findall(_BEFORE_UNIT.sub("", line))]
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    return cells[:-1] if len(cells) > 1 and not cells[-1] else cells  # a separator at the end begins no column


def _is_number(cell: str) -> bool:
    return any(number.fullmatch(cell) for number in _NUMBERS.values())


def _separator(lines: Sequence[str]) -> str:
    """Return what separates the columns: that of a header, else of most lines of numbers, else of most lines."""
    scores: dict[str, tuple[bool, int, int]] = {}
    for separator in SEPARATORS:
        cells = [_split(line, separator) for line in lines]
        numbers = Counter(len(row) for row in cells if sum(map(_is_number, row)) > 1)
        named = any(is_header(read_header(row)) for row in cells)
        parted = 0 if separator == " " else sum(len(row) > 1 for row in cells)  # any sentence has blanks
        scores[separator] = named, max(numbers.values(), default=0), parted
    return max(scores, key=lambda separator: scores[separator])


def _header(rows: Sequence[tuple[int, str]], separator: str, name: str) -> tuple[int, Columns, int]:
    """Return the line of the header, 0 for none, what it says, and the line of units below it, 0 for none."""
    found = None
    for place, (_, line) in enumerate(rows[:_LOOKED_AT]):
        commented = _COMMENT.match(line) is not None
        cells = _split(_COMMENT.sub("", line, count=1), separator)
        has_numbers = any(map(_is_number, cells))
        if not has_numbers and is_header(read_header(cells)):
            found = place
        elif has_numbers and not commented and found is not None:
            break
        elif not commented and found is None and len(cells) == 2 and all(map(_is_number, cells)):
            if all(_COMMENT.match(above) for _, above in rows[:place]):
                return 0, choose_columns(_HEADERLESS, name), 0
            break
    if found is None:
        raise InputError(_no_header(rows, separator, name))
    number, line = rows[found]
    columns = read_header(_split(_COMMENT.sub("", line, count=1), separator))
    units = _units_below(rows, found, separator, len(columns))
    if units:
        columns = [column.in_unit(text) for column, text in zip(columns, units, strict=True)]
    below = rows[found + 1][0] if units else 0
    return number, choose_columns(columns, f"{name}, line {number}"), below


def _units_below(rows: Sequence[tuple[int, str]], place: int, separator: str, count: int) -> list[str] | None:
    """Return the cells of a line of units below the names; None if it is none."""
    if place + 1 >= len(rows):
        return None
    cells = _split(_COMMENT.sub("", rows[place + 1][1], count=1), separator)
    cells += [""] * (count - len(cells))
    if len(cells) != count or any(map(_is_number, cells)) or _COMMENT.match(rows[place + 1][1]):
        return None
    return cells if any(read_unit(cell.strip("[]()")) for cell in cells) else None


def _no_header(rows: Sequence[tuple[int, str]], separator: str, name: str) -> str:
    number, line = next(((n, text) for n, text in rows if not _COMMENT.match(text)), rows[0])
    shown = repr(line[:60]) + ("..." if len(line) > 60 else "")
    count = len(_split(line, separator))
    parted = _columns(count) + (f", parted by {SEPARATORS[separator]}" if count > 1 else "")
    return (
        f"{name}, line {number}: got {shown}, {parted}; a table begins with a header that names the slip speed "
        "and friction, like v [mm/s],mu or v [m/s];F_t [N];F_n [N];sigma_mu, or with its first point"
    )


def _cells(body: Sequence[tuple[int, str]], columns: Columns, separator: str, name: str) -> Table:
    """Return the needed cells of all rows, or refuse the first row that lacks one."""
    lines = [number for number, _ in body]
    if separator == " ":
        rows = [line.split() for _, line in body]
    else:
        rows = list(csv.reader([line for _, line in body], delimiter=separator, skipinitialspace=True))
    if len(rows) != len(body):
        line = next((number for number, text in body if text.count('"') % 2), body[-1][0])
        raise InputError(f"{name}, line {line}: a quotation mark is not closed; a row is a line of its own")
    sign = _decimal_sign(rows, lines, columns, name)
    number = _NUMBERS[sign]
    cells: dict[str, list[str]] = {}
    for quantity, place in columns.places.items():
        texts = cells[quantity] = []
        for line, row in zip(lines, rows, strict=True):
            cell = row[place].strip() if place < len(row) else ""
            if not number.fullmatch(cell) or (len(row) > columns.count and any(row[columns.count :])):
                raise InputError(_bad_cell(line, row, columns, quantity, separator, name))
            texts.append(cell.replace(",", ".") if sign == "," else cell)
    return Table(columns, cells, lines)


def _decimal_sign(rows: Sequence[Sequence[str]], lines: Sequence[int], columns: Columns, name: str) -> str:
    """Return the decimal sign of the needed columns, or refuse a table that has both."""
    first: dict[str, tuple[int, int, str]] = {}
    for line, row in zip(lines, rows, strict=True):
        for place in columns.places.values():
            cell = row[place].strip() if place < len(row) else ""
            for sign in ".,":
                if sign in cell and sign not in first and _NUMBERS[sign].fullmatch(cell):
                    first[sign] = line, place + 1, cell
        if len(first) > 1:
            (a, i, point), (b, j, comma) = first["."], first[","]
            raise InputError(
                f"{name}: {point!r} in line {a}, column {i}, has a decimal point, and {comma!r} in line {b}, "
                f"column {j}, a comma; write one sign everywhere, and none between thousands"
            )
    return next(iter(first), ".")


def _bad_cell(line: int, row: Sequence[str], columns: Columns, quantity: str, separator: str, name: str) -> str:
    place, widest = columns.places[quantity], max(columns.places.values())
    where = f"{name}, line {line}, column {place + 1}, {columns.names[quantity]!r}"
    got = separator.join(row)[:60]
    if place >= len(row) or len(row) <= widest:
        return f"{where}: the row has {_columns(len(row))}, and the header names more; got {got!r}"
    cell = row[place].strip()
    if _is_number(cell):
        return (
            f"{where}: the row has {_columns(len(row))}, and the header "
            f"{columns.count}; got {got!r}; where a comma is the decimal sign, part the columns by semicolons"
        )
    return f"{where}: a finite number is needed, like 0.35; got {cell[:40]!r}; mend the row, or begin it with # "


def _columns(count: int) -> str:
    return "1 column" if count == 1 else f"{count} columns"

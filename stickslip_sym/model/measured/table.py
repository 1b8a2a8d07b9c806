"""A table of numbers as text: how its columns are parted, which sign is decimal, and which line is its header."""

import csv
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.core.aliases import BoolArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.columns import (
    EXPECTED,
    Columns,
    Header,
    choose_columns,
    is_header,
    read_unit,
)  # fmt: skip
from stickslip_sym.output.files import require_name

__all__ = ["Faults", "Table", "read_table"]

FloatArray = NDArray[np.float64]

SEPARATORS = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", " ": "blanks"}
"""What separates columns, by preference: a comma may also be a decimal sign, and blanks may stand in a name."""
MOST_ROWS = 1_000_000  # of a file; a longer one is refused before its numbers are read
_LONGEST = 10_000  # characters of a line
_LOOKED_AT = 400  # lines, of which most look alike: enough to tell how a file is written
_COMMENT = re.compile(r"^\s*([#%!]|//)\s*")
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")
_BETWEEN_BLANKS = re.compile(r'"[^"]*"|(?:\[[^\[\]]*\]|\([^()]*\)|\S)+')
_NUMBER = r"[+-]?(\d+{sign}?\d*|{sign}\d+)([eE][+-]?\d{{1,4}})?"
_NUMBERS = {sign: re.compile(_NUMBER.format(sign=re.escape(sign))) for sign in ".,"}
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:([.,' \u00a0\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d*)?")
_THREE_DIGITS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_NINES = re.compile(r"[+-]?0*(99[.,]9+|9{3,}([.,](0*|9*))?)")
_NOTHING = re.compile(r"|nan|n/?a|inf|-+|null|none|#.*", re.IGNORECASE)
_OVERFLOW = 1e30  # what instruments write in place of a value out of range is larger, like 9.9E37
_WORKBOOKS = {b"PK\x03\x04": ".xlsx or .ods", b"\xd0\xcf\x11\xe0": ".xls"}


class Faults:
    """Rows that are no measurements: the first is refused, or all of them are left out and counted.

    Parameters
    ----------
    name : str
        Of the file, for messages.
    leave_out : bool
    """

    def __init__(self, name: str, *, leave_out: bool) -> None:
        self.name = name
        self.leave_out = leave_out
        self.lines: dict[int, str] = {}

    def add(self, line: int, where: str, got: str, rule: str, reason: str) -> None:
        """Refuse a row, or keep its line and the reason."""
        if not self.leave_out:
            raise InputError(
                f"{self.name}, line {line}{where}: {rule}; {got}; mend the row, begin it with #, or leave out "
                "rows like it: leave_out=True"
            )
        self.lines.setdefault(line, reason)

    def __str__(self) -> str:
        counts = Counter(self.lines.values())
        first = {reason: line for line, reason in reversed(self.lines.items())}
        return ", ".join(f"{count} {reason} (line {first[reason]})" for reason, count in counts.items())


@dataclass
class Table:
    """The numbers of a file's columns that are read, and where they stand.

    Attributes
    ----------
    columns : Columns
    cells : dict of str to list of str
        With a decimal point, by quantity.
    lines : list of int
        The line of the file, from 1, of each row.
    faults : Faults
    """

    columns: Columns
    cells: dict[str, list[str]]
    lines: list[int]
    faults: Faults

    def floats(self, quantity: str) -> FloatArray:
        """Return a column as it stands in the file, in double precision."""
        return np.array(self.cells[quantity], dtype=np.float64)

    def require(self, rows: BoolArray, quantity: str, rule: str, reason: str) -> BoolArray:
        """Refuse the first row that breaks a rule, or mark all of them; return which rows keep it."""
        good = np.asarray(rows, dtype=bool)
        for row in np.flatnonzero(~good):
            where = f", column {self.columns.positions[quantity] + 1}"
            self.faults.add(self.lines[row], where, f"got {quantity} = {self.cells[quantity][row]}", rule, reason)
        return good

    def keep(self, good: BoolArray) -> None:
        """Leave out rows."""
        if not good.all():
            rows = np.flatnonzero(good).tolist()
            self.cells = {name: [cells[i] for i in rows] for name, cells in self.cells.items()}
            self.lines = [self.lines[i] for i in rows]


def read_table(path: Path, chosen: Mapping[str, str | int], radius: Fraction | None, *, leave_out: bool) -> Table:
    """Read the columns of a text file that hold measurements.

    Raises
    ------
    InputError
        If the file cannot be read, its header is not understood, or a row is no measurement; the message names
        line and column.
    """
    name = repr(str(path))
    lines = _text(path).splitlines()
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise InputError(f"{name}, line {number}: it has {len(line)} characters; a row is a line of its own")
    rows = [(number, line) for number, line in enumerate(lines, 1) if line.strip("\t;|, ")]
    if not rows:
        raise InputError(f"{name} has no points; write a line for each, like 0.1,0.35")
    separator = _separator([_COMMENT.sub("", line, count=1) for _, line in rows[:_LOOKED_AT]])
    first, columns = _header(rows, separator, name, chosen, radius)
    body = [(number, line) for number, line in rows if number >= first and not _COMMENT.match(line)]
    if len(body) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    if not body:
        raise InputError(f"{name} has no points below line {first - 1}; write a line for each, like 0.1,0.35")
    table = _cells(body, columns, separator, Faults(name, leave_out=leave_out))
    for quantity in table.cells:
        table.keep(table.require(~_stand_ins(table.floats(quantity), table.cells[quantity]), quantity,
                                 "this stands for no value", "of a value that stands for none"))  # fmt: skip
    return table


def _stand_ins(values: FloatArray, cells: Sequence[str]) -> BoolArray:
    """Return where a number stands for none: an overflow, or digits 9 like 9999 beyond twice every other number.

    Below 0, like -999, they stand for none too where no other number of that sign is of like size.
    """
    nines = np.array([_NINES.fullmatch(cell) is not None for cell in cells])
    others = values[~nines]
    for i in np.flatnonzero(nines):
        ratio = others / values[i]
        nines[i] = not ((ratio > 0.5) & ((ratio < 2) | (values[i] > 0))).any()
    return np.asarray(nines | ~(np.abs(values) < _OVERFLOW))


def _text(path: Path) -> str:
    require_name(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {str(path)!r}: {error.strerror or error}") from None
    if kind := _WORKBOOKS.get(content[:4]):
        raise InputError(f"{str(path)!r} is a workbook ({kind}), not a text file; save the sheet as CSV")
    encoding = "utf-16" if content.startswith((b"\xff\xfe", b"\xfe\xff")) else "utf-8-sig"
    if b"\0" in content and encoding != "utf-16":
        halves = content[:400:2], content[1:400:2]  # in UTF-16 every other byte of plain text is null
        encoding = "utf-16-le" if not any(halves[1]) else "utf-16-be"
        if any(halves[0]) and any(halves[1]):
            raise InputError(f"{str(path)!r} is not a text file of columns: it holds null bytes")
    try:
        return content.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding == "utf-8-sig":
            return content.decode("cp1252", errors="replace")  # as older instruments write the micro sign
        raise InputError(f"{str(path)!r} is not a text file of columns: {error}") from None


def _split(line: str, separator: str, width: int = 0) -> list[str]:
    """Return the cells of a line; with blanks, names that two blanks part where that gives as many as `width`."""
    if separator == " ":  # but v [mm/s] is one name
        names = [name.strip('"') for name in _BETWEEN_BLANKS.findall(_BEFORE_UNIT.sub("", line))]
        wide = re.split(r"\s{2,}|\t", line.strip())
        return wide if len(wide) == width != len(names) else names
    cells = [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    while len(cells) > 1 and not cells[-1]:  # separators at the end begin no column
        cells.pop()
    return cells


def _is_number(cell: str) -> bool:
    return any(number.fullmatch(cell) for number in (*_NUMBERS.values(), _THOUSANDS))


def _separator(lines: Sequence[str]) -> str:
    """Return what separates the columns of most lines of numbers."""
    scores: dict[str, tuple[int, bool, int]] = {}
    for separator in SEPARATORS:
        cells = [_split(line, separator) for line in lines]
        numbers = [sum(map(_is_number, row)) for row in cells]
        rows = sum(
            count > 1 and (separator in "\t;|" or count > len(row) / 2)
            for count, row in zip(numbers, cells, strict=True)
        )
        named = any(is_header([Header.read(cell) for cell in row]) for row in cells)
        parted = 0 if separator == " " else sum(len(row) > 1 for row in cells)  # any sentence has blanks
        scores[separator] = rows, named, parted
    return max(scores, key=lambda separator: scores[separator])


def _header(
    rows: Sequence[tuple[int, str]],
    separator: str,
    name: str,
    chosen: Mapping[str, str | int],
    radius: Fraction | None,
) -> tuple[int, Columns]:
    """Return the line from which on there are numbers, and what the header above them says."""
    plain = [(number, _COMMENT.match(line), _COMMENT.sub("", line, count=1)) for number, line in rows[:_LOOKED_AT]]
    counts = Counter(
        len(cells) for _, comment, line in plain
        if comment is None and sum(map(_is_number, cells := _split(line, separator))) > 1
    )  # fmt: skip
    width = counts.most_common(1)[0][0] if counts else 0
    named: int | None = None  # the last row above the numbers that names a speed and friction
    above: int | None = None  # the last that has a name for each column
    first: int | None = None  # the first of numbers
    for i, (_, comment, line) in enumerate(plain):
        cells = _split(line, separator, width)
        has_numbers = any(map(_is_number, cells))
        if not has_numbers:
            named = i if is_header([Header.read(cell) for cell in cells]) else named
            above = (
                i if len(cells) == width > 1 or (separator != " " and len(cells) > 1 and above is None) else above
            )
        elif comment is None and (named is not None or (len(cells) == width > 1 and all(map(_is_number, cells)))):
            first = i
            break
    header = named if named is not None else above
    if header is not None and named is None and _is_units(_split(plain[header][2], separator, width)) and header:
        header -= 1
    if header is None:
        unnamed = [Header("", ())] * width if chosen else [Header("v", ("v",)), Header("mu", ("mu",))]
        if first is None or len(unnamed) != width or (not chosen and not all(row[1] for row in plain[:first])):
            raise InputError(_no_header(rows, separator, name))
        return plain[first][0], choose_columns(unnamed, name, chosen, radius)
    number, _, line = plain[header]
    headers = [Header.read(cell) for cell in _split(line, separator, width)]
    if separator == " " and width and len(headers) != width:
        raise InputError(
            f"{name}, line {number}: {line.strip()[:80]!r} has {_columns(len(headers))}, parted by blanks, and "
            f"the rows have {width}; part names of more words by two blanks, or all columns by tabs or semicolons"
        )
    below = number + 1
    if header + 1 < len(plain) and plain[header + 1][1] is None:
        units = _split(plain[header + 1][2], separator, width)
        if len(units) <= len(headers) and _is_units(units):
            units += [""] * (len(headers) - len(units))
            headers = [one.in_unit(text) for one, text in zip(headers, units, strict=True)]
            below = plain[header + 1][0] + 1
    return below, choose_columns(headers, f"{name}, line {number}", chosen, radius)


def _is_units(cells: Sequence[str]) -> bool:
    return not any(map(_is_number, cells)) and any(read_unit(cell.strip("[]()")) for cell in cells)


def _no_header(rows: Sequence[tuple[int, str]], separator: str, name: str) -> str:
    number, line = next(((n, text) for n, text in rows if not _COMMENT.match(text)), rows[0])
    shown = repr(line[:60]) + ("..." if len(line) > 60 else "")
    count = len(_split(line, separator))
    parted = _columns(count) + (f", parted by {SEPARATORS[separator]}" if count > 1 else "")
    return (
        f"{name}, line {number}: got {shown}, {parted}; a table begins with a header that names the slip speed "
        f"and friction, like {EXPECTED}, or with its first point; number the columns of one without names, like "
        "columns={'v': 1, 'mu': 3}"
    )


def _cells(body: Sequence[tuple[int, str]], columns: Columns, separator: str, faults: Faults) -> Table:
    """Return the cells that are read of all rows, or refuse the first row that is none."""
    if separator == " ":
        rows = [line.split() for _, line in body]
    else:
        rows = list(csv.reader([line for _, line in body], delimiter=separator, skipinitialspace=True))
    if len(rows) != len(body):
        line = next((number for number, text in body if text.count('"') % 2), body[-1][0])
        raise InputError(f"{faults.name}, line {line}: a quotation mark is not closed; a row is a line of its own")
    rows = [[cell.strip() for cell in row] for row in rows]
    lines = [number for number, _ in body]
    sign = _decimal_sign(rows, lines, columns, faults.name)
    pattern = _NUMBERS[sign]
    read = {i: quantity for quantity, i in columns.positions.items()}
    numeric = _numeric_columns(rows, columns)
    cells: dict[str, list[str]] = {quantity: [] for quantity in columns.positions}
    kept = []
    for line, row in zip(lines, rows, strict=True):
        if len(row) != columns.count and (len(row) < columns.count or any(row[columns.count :])):
            _refuse_length(line, row, columns, separator, faults)
            continue
        wrong = next((i for i in read if not pattern.fullmatch(row[i])), None)
        wrong = next((i for i in numeric if not (_is_number(row[i]) or _NOTHING.fullmatch(row[i]))), wrong)
        if wrong is not None:
            name = columns.headers[read[wrong]].text if wrong in read else ""
            faults.add(
                line, f", column {wrong + 1}" + (f", {name!r}" if name else ""), f"got {row[wrong][:40]!r}",
                "a finite number is needed, like 0.35", "without a number",
            )  # fmt: skip
            continue
        kept.append(line)
        for i, quantity in read.items():
            cells[quantity].append(row[i].replace(",", ".") if sign == "," else row[i])
    if not kept:
        raise InputError(f"{faults.name} has no row that is a measurement: {faults}")
    return Table(columns, cells, kept, faults)


def _numeric_columns(rows: Sequence[Sequence[str]], columns: Columns) -> list[int]:
    """Return the columns that are not read and hold numbers: a word in one, like Mean, is not of a measurement."""
    others = [i for i in range(columns.count) if i not in columns.positions.values()]
    looked_at = [row for row in rows[:_LOOKED_AT] if len(row) >= columns.count]
    return [i for i in others if 2 * sum(_is_number(row[i]) for row in looked_at) > len(looked_at)]


def _refuse_length(line: int, row: Sequence[str], columns: Columns, separator: str, faults: Faults) -> None:
    count, last = len(row), max(columns.positions.values())
    position = min(last, count - 1)
    hint = ""
    if separator == "," and count > columns.count:
        hint = (
            "; where a comma is the decimal sign, part the columns by semicolons, and write thousands without one"
        )
    faults.add(
        line, f", column {position + 1}", f"got {separator.join(row)[:60]!r}{hint}",
        f"the row has {_columns(count)}, and the header {columns.count}", "of another number of columns",
    )  # fmt: skip


def _decimal_sign(rows: Sequence[Sequence[str]], lines: Sequence[int], columns: Columns, name: str) -> str:
    """Return the decimal sign of the columns that are read, or refuse a table with both, or with thousands."""
    first: dict[str, str] = {}
    certain = False  # a comma that stands between no thousands
    unsure: str | None = None
    for line, row in zip(lines, rows, strict=True):
        for i in columns.positions.values():
            cell = row[i] if i < len(row) else ""
            where = f"{name}, line {line}, column {i + 1}"
            thousands = _THOUSANDS.fullmatch(cell)
            if thousands and not any(number.fullmatch(cell) for number in _NUMBERS.values()):
                plain = cell.replace(thousands[1], "").replace(",", ".")
                raise InputError(f"{where}: {cell!r} has a sign between thousands; write it without, like {plain}")
            sign = next((sign for sign in ".," if sign in cell and _NUMBERS[sign].fullmatch(cell)), None)
            if sign is None:
                continue
            first.setdefault(sign, f"{cell!r} in line {line}, column {i + 1}")
            if sign == ",":
                certain = certain or _THREE_DIGITS.fullmatch(cell) is None
                unsure = unsure or (None if certain else f"{where}: {cell!r}")
        if len(first) > 1:
            raise InputError(
                f"{name}: {first['.']}, has a decimal point, and {first[',']}, a comma; write one sign "
                "everywhere, and none between thousands"
            )
    if "," in first and not certain:
        raise InputError(
            f"{unsure} may be a thousand times as much, if the comma stands between thousands; write the number "
            "without a comma, or with a decimal point"
        )
    return next(iter(first), ".")


def _columns(count: int) -> str:
    return "1 column" if count == 1 else f"{count} columns"

"""A text file of columns: how they are parted, which line is the header, and the numbers that are read."""

import csv
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import repeat
from pathlib import Path
from typing import NamedTuple

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.columns import EXPECTED, Column, choose_columns, is_header, read_unit

SEPARATORS = "\t;|, "
"""What separates columns, by preference: a comma may also be a decimal sign, and blanks may stand in a name."""
MOST_ROWS = 1_000_000  # of a file; a longer one is refused before its numbers are read
_PRECISION = 40  # digits in which units are converted, beyond those of a double
_LONGEST = 10_000  # characters of a line
_LOOKED_AT = 400  # lines, of which most look alike: enough to tell how a file is written
_COMMENT = re.compile(r"^\s*([#%!]|//)\s*")
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])])\s+(?=[\[(])")
_BETWEEN_BLANKS = re.compile(r'"[^"]*"|(?:\[[^\[\]]*\]|\([^()]*\)|\S)+')
_NUMBER = r"[+-]?(\d+{sign}?\d*|{sign}\d+)([eE][+-]?\d{{1,4}})?"
_NUMBERS = {sign: re.compile(_NUMBER.format(sign=re.escape(sign))) for sign in ".,"}
_THREE_DIGITS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_NINES = re.compile(r"[+-]?0*(99[.,]9+|9{3,}([.,](0*|9*))?)")
_NOTHING = re.compile(r"|nan|n/?a|inf|-+|null|none|#.*", re.IGNORECASE)
_OVERFLOW = 1e30  # what instruments write in place of a value out of range is larger, like 9.9E37
_WORKBOOKS = {b"PK\x03\x04": ".xlsx or .ods", b"\xd0\xcf\x11\xe0": ".xls"}
_FAULTY = "mend the row, begin it with #, or leave out rows like it: leave_out=True"


@dataclass
class Table:
    """The cells of the columns that are read, with the lines they stand in; other rows are refused or counted."""

    name: str
    columns: dict[str, Column]
    unread: list[str]
    leave_out: bool
    lines: list[int] = field(default_factory=list)
    cells: dict[str, list[str]] = field(default_factory=dict)
    faults: dict[str, list[int]] = field(default_factory=dict)

    def floats(self, quantity: str) -> FloatArray:
        """Return a column as it stands in the file, in double precision."""
        return np.array(self.cells[quantity], dtype=np.float64)

    def numbers(self, quantity: str, per: str | None = None, radius: Fraction = Fraction(1)) -> FloatArray:
        """Return a column in SI units, or its ratio to another, rounded but once."""
        size = self.columns[quantity].size * radius / (self.columns[per].size if per else 1)
        below = self.cells[per] if per else repeat("1", len(self.lines))
        with localcontext(prec=_PRECISION):
            factor = Decimal(size.numerator) / size.denominator
            pairs = zip(map(Decimal, self.cells[quantity]), map(Decimal, below), strict=True)
            return np.array([float(above * factor / one) for above, one in pairs])

    def place(self, row: int, quantity: str) -> str:
        """Return the file, the line and the column of a number."""
        return f"{self.name}, line {self.lines[row]}, column {self.columns[quantity].number}"

    def fault(self, line: int, where: str, got: str, rule: str, reason: str) -> None:
        """Refuse a line, or note why it is left out."""
        if not self.leave_out:
            raise InputError(f"{where}: {rule}; got {got}; {_FAULTY}")
        self.faults.setdefault(reason, []).append(line)

    def require(self, keep: BoolArray, quantity: str, rule: str, reason: str) -> None:
        """Refuse the first row that breaks a rule, or leave out all of them."""
        for row in np.flatnonzero(~keep).tolist():
            got = f"{quantity} = {self.cells[quantity][row]}"
            self.fault(self.lines[row], self.place(row, quantity), got, rule, reason)
        rows = np.flatnonzero(keep).tolist()
        self.lines = [self.lines[i] for i in rows]
        self.cells = {name: [cells[i] for i in rows] for name, cells in self.cells.items()}
        if not rows:
            raise InputError(f"{self.name} has no row that is a measurement: {self.left_out}")

    @property
    def left_out(self) -> str:
        """How many lines were left out for which reason, and the first of each."""
        return ", ".join(f"{len(lines)} {reason} (line {min(lines)})" for reason, lines in self.faults.items())


class _Line(NamedTuple):
    """A line that is not empty: its number from 1, its text, and whether a sign before that made it a comment."""

    number: int
    text: str
    comment: bool


def read_table(path: Path, chosen: Mapping[str, str | int], radius: Fraction | None, *, leave_out: bool) -> Table:
    """Return the columns of a text file that hold measurements, or refuse it with line and column."""
    name = repr(str(path))
    texts = _text(path).splitlines()
    for number, text in enumerate(texts, 1):
        if len(text) > _LONGEST:
            raise InputError(f"{name}, line {number}: it has {len(text)} characters; a row is a line of its own")
    lines = [
        _Line(number, _COMMENT.sub("", text, count=1), _COMMENT.match(text) is not None)
        for number, text in enumerate(texts, 1) if text.strip(SEPARATORS)
    ]  # fmt: skip
    separator, header, where, rows = _layout(lines, name, chosen)
    columns = choose_columns(header, where, chosen, radius)
    if len(rows) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    read = {column.number for column in columns.values()}
    unread = [text for number, text in enumerate(header, 1) if number not in read and text]
    table = Table(name, columns, unread, leave_out)
    _fill(table, [(line.number, _cells(line.text, separator)) for line in rows], header, separator)
    for quantity in columns:
        good = ~_stand_ins(table.floats(quantity), table.cells[quantity])
        table.require(good, quantity, "this stands for no value", "of a value that stands for none")
    return table


def _text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except (OSError, ValueError) as error:  # a name may hold a null byte
        raise InputError(f"cannot read {str(path)!r}: {getattr(error, 'strerror', None) or error}") from None
    if kind := _WORKBOOKS.get(content[:4]):
        raise InputError(f"{str(path)!r} is a workbook ({kind}), not a text file; save the sheet as CSV")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        with suppress(UnicodeDecodeError):
            return content.decode("utf-16")
    elif b"\0" not in content:
        with suppress(UnicodeDecodeError):
            return content.decode("utf-8-sig")
        return content.decode("cp1252", "replace")  # as older instruments write the micro sign
    raise InputError(f"{str(path)!r} is not a text file of columns: it holds null bytes; save it as UTF-8")


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line; where a quotation mark is not closed it stands in a cell, and is no number."""
    if separator == " ":
        return line.split()
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error:
        row = line.split(separator)
    return [cell.strip() for cell in row]


def _names(line: str, separator: str) -> list[str]:
    """Return the cells of a header: with blanks v [mm/s] is one, and separators at the end begin none."""
    if separator == " ":
        return [name.strip('"') for name in _BETWEEN_BLANKS.findall(_BEFORE_UNIT.sub("", line))]
    cells = _cells(line, separator)
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _is_number(cell: str) -> bool:
    return any(number.fullmatch(cell) for number in _NUMBERS.values())


def _layout(
    lines: Sequence[_Line], name: str, chosen: Mapping[str, str | int]
) -> tuple[str, list[str], str, list[_Line]]:
    """Return what separates columns, the cells of the header, where it stands, and the rows.

    A header names a speed and friction, also in a comment, and has a row of numbers below it, where blanks part
    them as many as there are names; a row of units may stand between. Anything else that looks like a header is
    refused. Where the user chose the columns it may have any names, and is the last line as wide as the first row
    that has nothing but numbers.
    """
    rows = [line for line in lines if not line.comment]
    for i, line in enumerate(lines[:_LOOKED_AT]):
        start = sum(not one.comment for one in lines[: i + 1])
        below = rows[start : start + 1]
        cells = {mark: _names(line.text, mark) for mark in SEPARATORS}
        first = {mark: _names(below[0].text, mark) if below else [] for mark in SEPARATORS}
        where = f"{name}, line {line.number}"
        named = [mark for mark in SEPARATORS if is_header(cells[mark])]
        if named and not below:
            raise InputError(f"{name} has no points below line {line.number}; write a line for each")
        for mark in named:
            units = [cell.strip("[]() ") for cell in first[mark]]
            if len(units) == len(cells[mark]) and any(map(read_unit, units)) and not any(map(_is_number, units)):
                cells[mark] = [
                    f"{cell} [{unit}]" if unit else cell for cell, unit in zip(cells[mark], units, strict=True)
                ]
                start += 1
                first[mark] = _names(rows[start].text, mark) if start < len(rows) else []
            fits = len(first[mark]) == len(cells[mark]) if mark == " " else len(first[mark]) > 1
            if fits and any(map(_is_number, first[mark])):
                return mark, cells[mark], where, rows[start:]
        if named and (chosen or not line.comment):
            raise InputError(
                f"{where}: {line.text[:60]!r} names {len(cells[named[-1]])} columns, and {below[0].text[:50]!r} "
                "has not as many numbers; write units in brackets behind the names, part columns by tabs or "
                "semicolons, and begin a title with #"
            )
        numbers = [mark for mark in SEPARATORS if len(cells[mark]) > 1 and all(map(_is_number, cells[mark]))]
        if numbers and not line.comment:
            mark, count = numbers[0], len(cells[numbers[0]])
            wide = [one for one in lines[:i] if len(_names(one.text, mark)) == count]
            header = _names(wide[-1].text, mark) if wide else []
            above = [list(map(_is_number, _names(one.text, mark))) for one in rows[: start - 1]]
            rowlike = any(2 * sum(numeric) > len(numeric) for numeric in above)
            if rowlike or any(map(_is_number, header)) or (below and len(first[mark]) != count):
                break
            if chosen and wide:
                return mark, header, f"{name}, line {wide[-1].number}", rows[start - 1 :]
            if chosen or (count == 2 and line is rows[0]):
                return mark, [""] * count if chosen else ["v", "mu"], name, rows[start - 1 :]
            break
    if not rows:
        raise InputError(f"{name} has no points; write a line for each, like 0.1,0.35")
    raise InputError(
        f"{name}, line {rows[0].number}: got {rows[0].text[:60]!r}; a table begins with a header that names the "
        f"slip speed and friction, with units in brackets, like {EXPECTED}, or with its first point; number the "
        "columns of one without names, like columns={'v': 1, 'mu': 3}"
    )


def _fill(table: Table, rows: Sequence[tuple[int, list[str]]], header: list[str], separator: str) -> None:
    """Take the cells that are read of all rows, each of which has as many columns as the header."""
    count = len(header)
    read = {column.number - 1: quantity for quantity, column in table.columns.items()}
    sign = _decimal_sign([row[i] for _, row in rows for i in read if i < len(row)], table.name)
    looked_at = [row for _, row in rows[:_LOOKED_AT] if len(row) >= count]
    numeric = [  # a word in another column of numbers, like Mean, says that a row is none of measurements
        i for i in range(count)
        if i not in read and 2 * sum(_is_number(row[i]) for row in looked_at) > len(looked_at)
    ]  # fmt: skip
    table.cells = {quantity: [] for quantity in table.columns}
    for line, row in rows:
        text = separator.join(row)
        if len(row) < count or any(row[count:]):
            column, got, reason = str(min(len(row), count)), text[:60], "of another number of columns"
            rule = f"the row has {len(row)} column{'s' * (len(row) > 1)}, and the header {count}"
            rule += "; where a comma is the decimal sign, part the columns by semicolons" * (separator == ",")
        else:
            wrong = [i for i in numeric if not (re.search(r"\d", row[i]) or _NOTHING.fullmatch(row[i]))]
            wrong += [i for i in read if not _NUMBERS[sign].fullmatch(row[i])]
            if not wrong:
                table.lines.append(line)
                for i, quantity in read.items():
                    table.cells[quantity].append(row[i].replace(sign, "."))
                continue
            i, reason = wrong[0], "without a number"
            column, got = f"{i + 1}" + (f", {table.columns[read[i]].text!r}" if i in read else ""), row[i][:40]
            rule = "a finite number is needed, like 0.35, without a sign between thousands"
        other = not any(map(_is_number, row)) and _names(text, separator) != header
        if other and any(is_header(_names(text, mark)) for mark in SEPARATORS):
            raise InputError(
                f"{table.name}, line {line}: another header, {text[:60]!r}, begins a second table; save each as a "
                "file of its own"
            )
        table.fault(line, f"{table.name}, line {line}, column {column}", repr(got), rule, reason)


def _decimal_sign(cells: Sequence[str], name: str) -> str:
    """Return the decimal sign of cells, or refuse both signs, or a comma that may stand between thousands."""
    points, commas = ([cell for cell in cells if sign in cell and _is_number(cell)] for sign in ".,")
    if commas and (points or all(map(_THREE_DIGITS.fullmatch, commas))):
        raise InputError(
            f"{name}: the comma in {commas[0]!r} may be a decimal sign, or stand between thousands, as "
            f"{f'{points[0]!r} has a point' if points else 'all have three digits behind it'}; write one decimal "
            "sign everywhere, and none between thousands"
        )
    return "," if commas else "."


def _stand_ins(values: FloatArray, cells: Sequence[str]) -> BoolArray:
    """Return where a number stands for none: an overflow, or nines like 9999 or -999 beyond all others."""
    nines = np.array([_NINES.fullmatch(cell) is not None for cell in cells], dtype=bool)
    others = values[~nines]
    for i in np.flatnonzero(nines):
        ratio = others / values[i]
        nines[i] = not ((ratio > 0.5) & ((ratio < 2) | (values[i] > 0))).any()
    return np.asarray(nines | ~(np.abs(values) < _OVERFLOW))

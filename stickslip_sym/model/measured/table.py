"""A table of numbers as text: how its columns are parted, which sign is decimal, and which line is its header."""

import csv
import re
from collections import Counter
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

SEPARATORS = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", " ": "blanks"}
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
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:([.,' \u00a0\u202f])\d{3})(?:\1\d{3})*(?:[.,]\d*)?")
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

    def numbers(self, quantity: str, per: str | None = None) -> FloatArray:
        """Return a column in SI units, or its ratio to another, rounded but once."""
        size = self.columns[quantity].size / (self.columns[per].size if per else 1)
        below = self.cells[per] if per else repeat("1", len(self.lines))
        with localcontext(prec=_PRECISION):
            factor = Decimal(size.numerator) / size.denominator
            pairs = zip(map(Decimal, self.cells[quantity]), map(Decimal, below), strict=True)
            return np.array([float(above * factor / one) for above, one in pairs])

    def place(self, row: int, quantity: str) -> str:
        """Return the file, the line and the column of a number."""
        return f"{self.name}, line {self.lines[row]}, column {self.columns[quantity].position + 1}"

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
    lines = _text(path).splitlines()
    for number, line in enumerate(lines, 1):
        if len(line) > _LONGEST:
            raise InputError(f"{name}, line {number}: it has {len(line)} characters; a row is a line of its own")
    rows = [
        _Line(number, _COMMENT.sub("", line, count=1), _COMMENT.match(line) is not None)
        for number, line in enumerate(lines, 1) if line.strip("\t;|, ")
    ]  # fmt: skip
    if not rows:
        raise InputError(f"{name} has no points; write a line for each, like 0.1,0.35")
    separator = _separator(rows[:_LOOKED_AT])
    first, headers, where = _header(rows[:_LOOKED_AT], separator, name, unnamed=bool(chosen))
    columns = choose_columns(headers, where, chosen, radius)
    body = [line for line in rows if line.number >= first and not line.comment]
    if len(body) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    if not body:
        raise InputError(f"{name} has no points below line {first - 1}; write a line for each, like 0.1,0.35")
    read = {column.position for column in columns.values()}
    unread = [header.text for i, header in enumerate(headers) if i not in read and header.text]
    table = Table(name, columns, unread, leave_out)
    _fill(table, [(line.number, _cells(line.text, separator)) for line in body], len(headers), separator)
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
        encodings = ["utf-16"]
    elif b"\0" in content:  # in UTF-16 every other byte of plain text is null
        encodings = [f"utf-16-{end}" for end, i in (("le", 1), ("be", 0)) if not any(content[i:400:2])]
    else:  # the second as older instruments write the micro sign
        encodings = ["utf-8-sig", "cp1252"]
    for encoding in encodings:
        with suppress(UnicodeDecodeError):
            return content.decode(encoding, "replace" if encoding == "cp1252" else "strict")
    reason = ": it holds null bytes" if b"\0" in content else ""
    raise InputError(f"{str(path)!r} is not a text file of columns{reason}")


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line; where a quotation mark is not closed it stands in a cell, and is no number."""
    if separator == " ":
        return line.split()
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error:
        row = line.split(separator)
    return [cell.strip() for cell in row]


def _names(line: str, separator: str, width: int = 0) -> list[str]:
    """Return the cells of a header; with blanks, names that two blanks part if that gives as many as `width`."""
    if separator == " ":  # but v [mm/s] is one name
        names = [name.strip('"') for name in _BETWEEN_BLANKS.findall(_BEFORE_UNIT.sub("", line))]
        wide = re.split(r"\s{2,}|\t", line.strip())
        return wide if len(wide) == width != len(names) else names
    cells = _cells(line, separator)
    while len(cells) > 1 and not cells[-1]:  # separators at the end begin no column
        cells.pop()
    return cells


def _is_number(cell: str) -> bool:
    return any(number.fullmatch(cell) for number in (*_NUMBERS.values(), _THOUSANDS))


def _separator(lines: Sequence[_Line]) -> str:
    """Return what separates the columns of a header and of most lines of numbers."""

    def score(separator: str) -> tuple[bool, int, int]:
        table = [_names(line.text, separator) for line in lines]
        numbers = [(sum(map(_is_number, cells)), len(cells)) for cells in table]
        rows = sum(count > 1 and (separator in "\t;|" or count > width / 2) for count, width in numbers)
        parted = 0 if separator == " " else sum(width > 1 for _, width in numbers)  # any sentence has blanks
        return rows > 0 and any(map(is_header, table)), rows, parted

    return max(SEPARATORS, key=score)


def _header(lines: Sequence[_Line], separator: str, name: str, *, unnamed: bool) -> tuple[int, list[Column], str]:
    """Return the line of the first numbers, the columns by their header and units, and where it stands."""
    numbers = [_names(line.text, separator) for line in lines if not line.comment]
    widths = Counter(len(cells) for cells in numbers if sum(map(_is_number, cells)) > 1)
    width = widths.most_common(1)[0][0] if widths else 0
    table = [_names(line.text, separator, width) for line in lines]
    header = first = None
    named, units = False, list[str]()
    for i, cells in enumerate(table):
        if any(map(_is_number, cells)):
            if not lines[i].comment and (named or (len(cells) == width > 1 and all(map(_is_number, cells)))):
                first = i
                break
        elif is_header(cells):
            header, named, units = i, True, []
        elif header == i - 1 and not lines[i].comment and any(read_unit(cell.strip("[]()")) for cell in cells):
            units = cells
        elif not named and (len(cells) == width > 1 or (separator != " " and len(cells) > 1 and header is None)):
            header, units = i, []
    if header is None:
        if first is None or not (unnamed or (width == 2 and all(line.comment for line in lines[:first]))):
            raise InputError(_no_header(lines, separator, name))
        known = [Column("", "", ())] * width if unnamed else [Column(one, one, (one,)) for one in ("v", "mu")]
        return lines[first].number, known, name
    below = units + [""] * len(table[header])
    headers = [Column.read(cell, unit) for cell, unit in zip(table[header], below, strict=False)]
    where = f"{name}, line {lines[header].number}"
    if separator == " " and width and len(headers) != width:
        shown, count = repr(lines[header].text.strip()[:80]), f"{len(headers)} column{'s' * (len(headers) > 1)}"
        raise InputError(
            f"{where}: {shown} has {count}, parted by blanks, and the rows have {width}; part names of more words "
            "by two blanks, or all columns by tabs or semicolons"
        )
    return lines[header + bool(units)].number + 1, headers, where


def _no_header(lines: Sequence[_Line], separator: str, name: str) -> str:
    number, line, _ = next((line for line in lines if not line.comment), lines[0])
    shown, count = repr(line[:60]) + ("..." if len(line) > 60 else ""), len(_names(line, separator))
    parted = f"{count} column{'s' * (count > 1)}" + (f", parted by {SEPARATORS[separator]}" if count > 1 else "")
    return (
        f"{name}, line {number}: got {shown}, {parted}; a table begins with a header that names the slip speed "
        f"and friction, like {EXPECTED}, or with its first point; number the columns of one without names, like "
        "columns={'v': 1, 'mu': 3}"
    )


def _fill(table: Table, rows: Sequence[tuple[int, list[str]]], count: int, separator: str) -> None:
    """Take the cells that are read of all rows, each of which has so many columns."""
    read = {column.position: quantity for quantity, column in table.columns.items()}
    sign = _decimal_sign(rows, sorted(read), table.name)
    looked_at = [row for _, row in rows[:_LOOKED_AT] if len(row) >= count]
    numeric = [  # a word in another column of numbers, like Mean, says that a row is none of measurements
        i for i in range(count)
        if i not in read and 2 * sum(_is_number(row[i]) for row in looked_at) > len(looked_at)
    ]  # fmt: skip
    advice = "; where a comma is the decimal sign, part the columns by semicolons, and write thousands without one"
    table.cells = {quantity: [] for quantity in table.columns}
    for line, row in rows:
        if len(row) < count or any(row[count:]):
            column, got = str(min(max(read) + 1, len(row))), separator.join(row)[:60]
            reason = "of another number of columns"
            rule = f"the row has {len(row)} column{'s' * (len(row) > 1)}, and the header {count}"
            rule += advice if separator == "," and len(row) > count else ""
        else:
            wrong = [i for i in numeric if not (_is_number(row[i]) or _NOTHING.fullmatch(row[i]))]
            wrong += [i for i in read if not _NUMBERS[sign].fullmatch(row[i])]
            if not wrong:
                table.lines.append(line)
                for i, quantity in read.items():
                    table.cells[quantity].append(row[i].replace(sign, "."))
                continue
            if is_header(row) and not all(table.columns[read[i]].text.startswith(row[i]) for i in read):
                raise InputError(
                    f"{table.name}, line {line}: another header, {separator.join(row)[:60]!r}, begins a second "
                    "table; save each as a file of its own"
                )
            i, rule, reason = wrong[0], "a finite number is needed, like 0.35", "without a number"
            named = f", {table.columns[read[i]].text!r}" if i in read else ""
            column, got = f"{i + 1}{named}", row[i][:40]
        table.fault(line, f"{table.name}, line {line}, column {column}", repr(got), rule, reason)


def _decimal_sign(rows: Sequence[tuple[int, list[str]]], read: Sequence[int], name: str) -> str:
    """Return the decimal sign of the cells that are read, or refuse both signs, or one between thousands."""
    shown, grouped = dict[str, str](), True
    for line, row in rows:
        for i in read:
            cell = row[i] if i < len(row) else ""
            sign = "," if "," in cell else "."
            if _NUMBERS[sign].fullmatch(cell):
                if sign in cell and sign not in shown:
                    shown[sign] = f"{cell!r} in line {line}, column {i + 1}"
                grouped = grouped and (sign == "." or _THREE_DIGITS.fullmatch(cell) is not None)
            elif thousands := _THOUSANDS.fullmatch(cell):
                plain = cell.replace(thousands[1], "").replace(",", ".")
                raise InputError(
                    f"{name}, line {line}, column {i + 1}: {cell!r} has a sign between thousands; "
                    f"write it without, like {plain}"
                )
    if len(shown) > 1:
        raise InputError(
            f"{name}: {shown['.']}, has a decimal point, and {shown[',']}, a comma; write one sign everywhere, "
            "and none between thousands"
        )
    if "," in shown and grouped:
        raise InputError(
            f"{name}: {shown[',']}, may be a thousand times as much, if the comma stands between thousands; write "
            "the number without a comma, or with a decimal point"
        )
    return next(iter(shown), ".")


def _stand_ins(values: FloatArray, cells: Sequence[str]) -> BoolArray:
    """Return where a number stands for none: an overflow, or nines like 9999 or -999 beyond all others."""
    nines = np.array([_NINES.fullmatch(cell) is not None for cell in cells], dtype=bool)
    others = values[~nines]
    for i in np.flatnonzero(nines):
        ratio = others / values[i]
        nines[i] = not ((ratio > 0.5) & ((ratio < 2) | (values[i] > 0))).any()
    return np.asarray(nines | ~(np.abs(values) < _OVERFLOW))

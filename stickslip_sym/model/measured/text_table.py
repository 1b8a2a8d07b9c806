"""A text file of columns: how they are parted, which line is the header, and the numbers that are read."""

import csv
import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from decimal import Decimal, DefaultContext, localcontext
from fractions import Fraction
from io import BytesIO
from itertools import islice, pairwise, repeat
from pathlib import Path
from typing import NamedTuple, TypeAlias

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.foreign import printable
from stickslip_sym.core.remedies import Argument, Reading, Remedy
from stickslip_sym.model.measured.blocks import Block, label_of, varying
from stickslip_sym.model.measured.columns import EXPECTED, HeaderColumn, choose_columns, is_header, read_unit
from stickslip_sym.model.measured.plain import OVERFLOW, lines_before, plain_numbers
from stickslip_sym.model.measured.preamble import WrittenRadius, written_radius
from stickslip_sym.model.measured.proposals import proposed
from stickslip_sym.model.measured.sweep_branches import ROWS_TO_SAMPLE
from stickslip_sym.model.measured.written_values import is_value, split_values
from stickslip_sym.output.files import read_bytes

SEPARATORS = "\t;|, "
"""What separates columns, by preference: a comma may also be a decimal sign, and blanks may stand in a name."""
_PARTED = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", " ": "blanks"}
MOST_ROWS = 1_000_000  # of a file; a longer one is refused before its numbers are read
_MOST_FILE_BYTES = 200 * MOST_ROWS  # bytes of a file: those of a row with a dozen columns
_MOST_LINE_CHARACTERS = 10_000  # characters of a line
_LOOKED_AT = 400  # lines, of which most look alike: enough to tell how a file is written
_COMMENT = re.compile(r"^\s*([#%!]|//)\s*")
_AROUND_ERROR = re.compile(r" *(±|\+/-) *")
"""Blanks within 0.44 ± 0.05, which part no columns."""
_BEFORE_UNIT = re.compile(r"(?<=[^\s\])]) +(?=[\[(])")
_BETWEEN_BLANKS = re.compile(r'"[^"]*"|(?:\[[^\[\]]*\]|\([^()]*\)|[^ ])+')
_NUMBER = r"[+-]?(\d+{sign}?\d*|{sign}\d+)([eE][+-]?\d{{1,4}})?"
_NUMBERS = {sign: re.compile(_NUMBER.format(sign=re.escape(sign))) for sign in ".,"}
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?")
_THOUSANDS_IN_ROW = re.compile(r"(?<![\d.])[1-9]\d{0,2}(,\d{3})+(?!\d)")
_THREE_DIGITS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
_NINES = re.compile(r"[+-]?0*(99[.,]9+|9{3,}([.,](0*|9*))?)")
_NOTHING = re.compile(r"|nan|n/?a|inf|-+|null|none|#.*", re.IGNORECASE)
_FIRST_TWO = {"v": 1, "mu": 2}
"""The columns of a table of two without a header."""
_WORKBOOKS = {b"PK\x03\x04": ".xlsx or .ods", b"\xd0\xcf\x11\xe0": ".xls"}
_SUMMARIES = 4  # rows of one: mean, deviation, least, largest
_FEWEST_SYSTEMATIC = 3  # rows left out, of which it can be said that they are of one end of the speeds
_MOST_LEFT_OUT = 0.2  # share of the rows that break a rule, above which columns or units are not what they seem
_Row: TypeAlias = tuple[int, list[str]]  # its line, and its cells
_FAULTY = "; mend the row, begin it with #, or leave out rows like it: ", Argument("leave_out", True)


@dataclass
class Table:
    """The cells of the columns that are read, with the lines they stand in; other rows are refused or counted."""

    name: str
    columns: dict[str, HeaderColumn]
    unread: list[str]
    leave_out: bool
    written: str = ""  # how, in words
    lines: Sequence[int] = field(default_factory=list)
    cells: dict[str, list[str]] = field(default_factory=dict)
    values: dict[str, FloatArray] = field(default_factory=dict)  # in place of cells, of a long plain file
    faults: dict[str, list[int]] = field(default_factory=dict)
    radii: list[Fraction] = field(default_factory=list)  # of the track, in m, for each row
    origin: list[int] = field(default_factory=list)  # the number of each row's block
    blocks: tuple[Block, ...] = ()  # of the file, if there is more than one
    said_of_radius: str = ""  # where it was read in the file
    without: dict[int, float] = field(default_factory=dict)  # lines of numbers left out, and their v, if known

    def floats(self, quantity: str) -> FloatArray:
        """Return a column as it stands in the file, in double precision."""
        if self.values:
            return self.values[quantity]
        return np.array(self.cells[quantity], dtype=np.float64)

    def cell(self, quantity: str, row: int) -> str:
        """Return what stands in a cell."""
        if self.values:
            return f"{self.values[quantity][row]:.12g}"
        return self.cells[quantity][row]

    def numbers(self, quantity: str, per: str | None = None) -> FloatArray:
        """Return a column in SI units, or its ratio to another, rounded but once.

        What turns is multiplied by the radius of the track, and a torque is divided by it.
        """
        column = self.columns[quantity]
        size = column.size / (self.columns[per].size if per else 1)
        if column.turns:
            power = 1
        elif column.is_torque:
            power = -1
        else:
            power = 0
        tracks = self.radii
        if not power:
            tracks = [Fraction(1)] * len(self.lines)
        if size == 1 and per is None and not power:
            return self.floats(quantity)
        if self.values:  # rounded once more by each factor
            below_in_units = self.values[per] if per else 1.0
            numerator = self.values[quantity] * float(size.numerator)
            if power:
                numerator = numerator * np.array([float(track) for track in tracks]) ** power
            return np.asarray(numerator / (float(size.denominator) * below_in_units))
        below = self.cells[per] if per else repeat("1", len(self.lines))
        with localcontext(DefaultContext):
            sizes = {track: size * track**power for track in set(tracks)}
            factors = {track: Decimal(whole.numerator) / whole.denominator for track, whole in sizes.items()}
            of_rows = map(factors.__getitem__, tracks)
            rows = zip(map(Decimal, self.cells[quantity]), map(Decimal, below), of_rows, strict=True)
            return np.array([float(above * factor / divisor) for above, divisor, factor in rows])

    def place(self, row: int, quantity: str) -> str:
        """Return the file, the line and the column of a number."""
        return f"{self.name}, line {self.lines[row]}, column {self.columns[quantity].number}"

    def fault(self, line: int, where: str, got: str, rule: str, reason: str) -> None:
        """Refuse a line, or note why it is left out."""
        if not self.leave_out:
            raise InputError(f"{where}: {rule}; got {got}", *_FAULTY)
        self.faults.setdefault(reason, []).append(line)

    def refuse_systematic(self) -> None:
        """Refuse to leave out a block of rows, rows at even steps, or one end of the speeds.

        A law of what remains would be another one.
        """
        lost = sorted(self.without)
        if len(lost) < _FEWEST_SYSTEMATIC:
            return
        place = {line: i for i, line in enumerate(sorted([*self.lines, *lost]))}
        steps = [place[after] - place[before] for before, after in pairwise(lost)]
        run = longest = 1
        for step in steps:
            run = run + 1 if step == 1 else 1
            longest = max(longest, run)
        speeds = np.abs(np.array(list(self.without.values())))
        kept = np.abs(self.floats("v"))
        what = ""
        if longest > _SUMMARIES:
            what = f"{longest} of them follow each other"
        elif len(lost) > _SUMMARIES and len(set(steps)) == 1:
            what = f"they are every {steps[0]} rows"
        elif np.isfinite(speeds).all() and (speeds.min() > kept.max() or speeds.max() < kept.min()):
            what = f"they are those of the {'highest' if speeds.min() > kept.max() else 'lowest'} speeds"
        if what:
            shown = ", ".join(map(str, lost[:_SUMMARIES])) + ", ..." * (len(lost) > _SUMMARIES)
            raise InputError(
                f"{self.name}: {len(lost)} of {len(place)} rows would be left out (lines {shown}), and {what}, so "
                f"that the rest is no fair sample: {self.left_out}; mend them, or delete them if they are known "
                "to be wrong"
            )

    def require(
        self, keep: BoolArray, quantity: str, rule: str, reason: str, *, stands_for_none: bool = False
    ) -> None:
        """Refuse the first row that breaks a rule, or leave out all of them where they are few."""
        if (count := int(np.sum(~keep))) > max(_MOST_LEFT_OUT * len(keep), 1) and not stands_for_none:
            row = int(np.argmin(keep))
            raise InputError(
                f"{self.place(row, quantity)}: {rule}; got {quantity} = {self.cell(quantity, row)}, and {count} "
                f"of {len(keep)} rows are like it, too many to leave out: see which columns and units they are"
            )
        for row in np.flatnonzero(~keep).tolist():
            got = f"{quantity} = {self.cell(quantity, row)}"
            self.fault(self.lines[row], self.place(row, quantity), got, rule, reason)
            stands_in = stands_for_none and quantity == "v"
            self.without[self.lines[row]] = math.nan if stands_in else float(self.floats("v")[row])
        if keep.all():
            return
        rows = np.flatnonzero(keep).tolist()
        self.lines, self.origin = ([column[i] for i in rows] for column in (self.lines, self.origin))
        self.radii = [self.radii[i] for i in rows]
        self.values = {name: values[keep] for name, values in self.values.items()}
        self.cells = {name: [cells[i] for i in rows] for name, cells in self.cells.items()}
        self.refuse_empty()

    def refuse_empty(self) -> None:
        """Refuse a table of which all rows were left out."""
        if not self.lines:
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


class _Layout(NamedTuple):
    """How a table is written: what parts its columns, the cells of its header, the header's line, and the rows."""

    separator: str
    header: list[str]
    line: _Line | None
    rows: list[_Line]


class _Part(NamedTuple):
    """A block of a file: the lines above its header, the layout, and the lines of its rows."""

    above: list[_Line]
    layout: _Layout


def read_table(
    path: Path,
    chosen: Mapping[str, str | int],
    radius: Fraction | None,
    *,
    leave_out: bool,
    block: Collection[int] = (),
) -> Table:
    """Return the columns of a text file that hold measurements, or refuse it with line and column."""
    name = repr(str(path))
    content = read_bytes(path, _MOST_FILE_BYTES)
    how = _How(chosen, radius, None, leave_out)
    many = content.count(b"\n") > ROWS_TO_SAMPLE
    if many and not block and (plain := _plain_table(content, name, how)) is not None:
        return plain
    lines = _filled_lines(_decoded(content, name), name)
    parts = _blocks_of_file(lines, _layout_of_chosen(lines, name) if chosen else _layout(lines, name), name)
    if sum(len(part.layout.rows) for part in parts) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    numbers = _blocks_to_read(parts, block, name)
    blocks = list[Block]()
    tables = list[Table]()
    written = None
    for number, part in enumerate(parts, 1):
        header, cells = split_values(
            part.layout.header,
            [(line.number, _cells(line.text, part.layout.separator)) for line in part.layout.rows],
        )
        if len(parts) > 1:
            if part.layout.line is not None:
                line = part.layout.line.number
            else:
                line = part.layout.rows[0].number
            label = label_of([above.text for above in part.above])
            varies = varying(header, [row for _, row in cells])
            blocks.append(Block(number, line, label, len(cells), varies, number in numbers))
        above = [(line.number, _cells(line.text, part.layout.separator)) for line in part.above]
        written = written_radius(above[-_LOOKED_AT:]) or written
        if number in numbers:
            of_block = how._replace(written=written, block=number if block else None)
            tables.append(_table_of(part, header, cells, name, of_block, number))
    table = _together(tables)
    table.refuse_empty()
    table.blocks = tuple(blocks)
    return table


def _filled_lines(text: str, name: str) -> list[_Line]:
    """Return the lines of a text that are not empty."""
    texts = printable(text, lines=True).replace("\N{MINUS SIGN}", "-").splitlines()
    for number, line in enumerate(texts, 1):
        if len(line) > _MOST_LINE_CHARACTERS:
            raise InputError(f"{name}, line {number}: it has {len(line)} characters; a row is a line of its own")
    return [
        _Line(number, _COMMENT.sub("", line, count=1), _COMMENT.match(line) is not None)
        for number, line in enumerate(texts, 1) if line.strip(SEPARATORS)
    ]  # fmt: skip


def _plain_table(content: bytes, name: str, how: "_How") -> Table | None:
    """Return the columns of a long file of plain numbers; None where its cells are to be looked at one by one."""
    try:
        head = b"".join(islice(BytesIO(content), _LOOKED_AT)).decode()
        lines = _filled_lines(head, name)
        (part,) = _blocks_of_file(
            lines, _layout_of_chosen(lines, name) if how.chosen else _layout(lines, name), name
        )
    except (ValueError, InputError):
        return None
    header = part.layout.header
    separator = part.layout.separator
    rows = part.layout.rows
    cells = [(line.number, _cells(line.text, separator)) for line in rows]
    named = list(filter(None, header))
    before = lines_before(head, rows[0].number)
    if before is None or len(set(named)) < len(named) or split_values(header, cells)[0] != header:
        return None
    numbers = plain_numbers(content[before:], separator, len(header))
    if numbers is None:
        return None
    if len(numbers) > MOST_ROWS:
        raise InputError(f"{name} has over {MOST_ROWS} rows; average them to fewer")
    above = [(line.number, _cells(line.text, separator)) for line in part.above]
    return _table_of(
        part, header, cells, name, how._replace(written=written_radius(above[-_LOOKED_AT:])), 1, numbers
    )


class _How(NamedTuple):
    """How a block is read: the chosen columns, the radius that was given and that in the file, and faulty rows."""

    chosen: Mapping[str, str | int]
    radius: Fraction | None
    written: WrittenRadius | None
    leave_out: bool
    block: int | None = None  # the number of the block, where there are several


def _advice(
    name: str, header: Sequence[str], cells: Sequence[_Row], how: _How, block: int | None = None
) -> tuple[str, *tuple[Remedy, ...]]:
    """Return the call that would read a table if its columns are what they are likely to be."""
    rows = [row for _, row in cells[:_LOOKED_AT]]
    call = proposed(name, header, rows, how.chosen, how.radius, how.written, block)
    if call is None:
        return (f"; write a header like {EXPECTED}",)
    return "; if the columns and units are these, read it by: ", call


def _table_of(
    part: _Part,
    header: list[str],
    cells: Sequence[_Row],
    name: str,
    how: _How,
    number: int,
    plain: FloatArray | None = None,
) -> Table:
    """Return the columns of a block that hold measurements; of `plain` rows, if there are no others."""
    line = part.layout.line
    separator = part.layout.separator
    where = name
    if line is not None:
        where = f"{name}, line {line.number}"
    chosen = how.chosen if any(header) or how.chosen else _FIRST_TWO
    try:
        columns = choose_columns(header, where, chosen, how.radius, _copies(header, cells), how.written)
    except InputError as fault:
        raise InputError(fault, *_advice(name, header, cells, how, how.block)) from None
    read = {column.number for column in columns.values()}
    unread = [text for place, text in enumerate(header, 1) if place not in read and text]
    table = Table(name, columns, unread, how.leave_out)
    track = Fraction(1) if how.radius is None else how.radius
    if how.radius is None and how.written is not None and any(c.turns or c.is_torque for c in columns.values()):
        assert how.written.size is not None  # or the columns had been refused
        track = how.written.size
        table.said_of_radius = f"radius {how.written.text} from line {how.written.line}"
    if plain is None:
        _fill(table, cells, header, separator)
    else:
        _take(table, plain, cells[0][0], separator)
    table.radii = [track] * len(table.lines)
    table.origin = [number] * len(table.lines)
    for quantity in columns if plain is None else ():
        good = ~_stand_ins(table.floats(quantity), table.cells[quantity])
        reason = "of a value that stands for none"
        table.require(good, quantity, "this stands for no value", reason, stands_for_none=True)
    return table


def _together(tables: Sequence[Table]) -> Table:
    """Return the rows of blocks with one header as those of one table."""
    whole = tables[0]
    said = [whole.said_of_radius]
    for table in tables[1:]:
        whole.lines = [*whole.lines, *table.lines]
        whole.radii += table.radii
        whole.origin += table.origin
        whole.without |= table.without
        said.append(table.said_of_radius)
        for quantity, cells in table.cells.items():
            whole.cells[quantity] += cells
        for reason, lines in table.faults.items():
            whole.faults.setdefault(reason, []).extend(lines)
    whole.said_of_radius = ", ".join(dict.fromkeys(filter(None, said)))
    return whole


def _blocks_of_file(lines: Sequence[_Line], layout: _Layout, name: str) -> list[_Part]:
    """Return the blocks of a file whose first table is known: each later header begins another."""
    if layout.line is not None:
        first = lines.index(layout.line)
    else:
        first = lines.index(layout.rows[0])
    begins = [first]
    if layout.line is not None:
        begins += [
            i for i in range(first + 1, len(lines) - 1)
            if _is_later_header(lines[i], layout) and lines[i].number < layout.rows[-1].number
        ]  # fmt: skip
    parts = list[_Part]()
    above = list(lines[:first])
    for begin, end in pairwise([*begins, len(lines)]):
        own = layout
        if begin != first:
            try:
                if is_header(_names(lines[begin].text, layout.separator)):
                    own = _layout(lines[begin:], name)
                else:
                    own = _layout_of_chosen(lines[begin:], name)
            except InputError:
                return [_Part(list(lines[:first]), layout)]  # no table: what there is of it is refused by its line
        rows = [line for line in own.rows if line.number <= lines[end - 1].number]
        if end < len(lines):
            last = max((i for i, line in enumerate(rows) if _is_row(line, own)), default=-1)
            following = rows[last + 1 :]
            rows = rows[: last + 1]
        else:
            following = []
        if rows:
            parts.append(_Part(above, own._replace(rows=rows)))
        above = following
    return parts


def _is_later_header(line: _Line, layout: _Layout) -> bool:
    """Return whether a line is the header again, or that of another table."""
    assert layout.line is not None
    text = line.text.lstrip(SEPARATORS)
    if not text or text[0].isdigit() or text[0] in "+-.":
        return False
    if line.text.strip() == layout.line.text.strip():
        return True
    cells = _names(line.text, layout.separator)
    return not any(map(_is_number, cells)) and is_header(cells)


def _is_row(line: _Line, layout: _Layout) -> bool:
    """Return whether a line looks like a row of a table: as wide as its header, and mostly of numbers."""
    cells = _cells(line.text, layout.separator)
    filled = [is_value(cell) for cell in cells if cell]
    return len(cells) >= len(layout.header) and 2 * sum(filled) > len(filled)


def _blocks_to_read(parts: Sequence[_Part], block: Collection[int], name: str) -> set[int]:
    """Return the numbers of blocks that are read: those that were chosen, or all, if they have one header."""
    if block:
        if unknown := [number for number in block if not 1 <= number <= len(parts)]:
            said = f"blocks 1 to {len(parts)}" if len(parts) > 1 else "one block"
            raise InputError(f"{name} has {said}, and no block {unknown[0]}")
        return set(block)
    kinds = dict[tuple[str, ...], list[int]]()
    for number, part in enumerate(parts, 1):
        kinds.setdefault(tuple(part.layout.header), []).append(number)
    if len(kinds) > 1:
        listed = "; ".join(
            f"block{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))}: "
            f"{', '.join(filter(None, header))[:80]}"
            for header, numbers in kinds.items()
        )
        first = min(kinds.values())
        raise InputError(
            f"{name} holds tables with different headers ({listed}); read those of one: ",
            Reading.of(name, block=first[0] if len(first) == 1 else tuple(first)),
        )
    return {number for numbers in kinds.values() for number in numbers}


def _decoded(content: bytes, name: str) -> str:
    if kind := _WORKBOOKS.get(content[:4]):
        raise InputError(f"{name} is a workbook ({kind}), not a text file; save the sheet as CSV")
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        with suppress(UnicodeDecodeError):
            return content.decode("utf-16")
    elif b"\0" not in content:
        with suppress(UnicodeDecodeError):
            return content.decode("utf-8-sig")
        return content.decode("cp1252", "replace")  # as older instruments write the micro sign
    raise InputError(f"{name} is not a text file of columns: it holds null bytes; save it as UTF-8")


def _cells(line: str, separator: str) -> list[str]:
    """Return the cells of a line; where a quotation mark is not closed it stands in a cell, and is no number."""
    if separator == " ":  # a tab stands for a column, which may be empty
        return [cell for cell in _AROUND_ERROR.sub(r"\1", line).split(" ") if cell]
    try:
        row = next(csv.reader([line], delimiter=separator, skipinitialspace=True, strict=True))
    except csv.Error:
        row = line.split(separator)
    return [cell.strip() for cell in row]


def _names(line: str, separator: str) -> list[str]:
    """Return the cells of a header: with blanks v [mm/s] is one, and separators at the end begin none."""
    if separator == " ":
        whole = _AROUND_ERROR.sub(r"\1", line)
        return [name.strip('"') for name in _BETWEEN_BLANKS.findall(_BEFORE_UNIT.sub("", whole))]
    cells = _cells(line, separator)
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    return cells


def _is_as_wide(line: str, row: str, separator: str) -> bool:
    """Return whether a line has as many columns as a row, with or without the empty ones at their ends."""
    return any(len(cells(line, separator)) == len(cells(row, separator)) for cells in (_names, _cells))


def _is_number(cell: str) -> bool:
    return any(number.fullmatch(cell) for number in _NUMBERS.values())


def _is_of_units(cells: Sequence[str], count: int) -> bool:
    """Return whether a row below a header of so many names holds their units."""
    units = [read_unit(cell.strip("[]() ")) is not None and not _is_number(cell) for cell in cells]
    return len(cells) == count and any(units) and not any(_is_number(cell) and cell != "1" for cell in cells)


def _join_units(names: Sequence[str], units: Sequence[str]) -> list[str]:
    plain = [unit.strip("[]() ") for unit in units]
    return [f"{name} [{unit}]" if unit else name for name, unit in zip(names, plain, strict=True)]


def _layout_of_chosen(lines: Sequence[_Line], name: str) -> _Layout:
    """Return the same as `_layout` where the user chose columns: what parts the rows decides, not the title.

    The header is the last line above the first row that is as wide, with the units of a row below it.
    """
    rows = [line for line in lines if not line.comment]
    widths = Counter[tuple[bool, str, int]]()
    for line in rows[:_LOOKED_AT]:
        for mark in SEPARATORS:
            cells = _names(line.text, mark)
            filled = [is_value(cell) for cell in cells if cell]
            if sum(filled) > 1 and 2 * sum(filled) > len(filled):
                widths[all(filled), mark, len(cells)] += 1
    if not widths:
        raise InputError(f"{name} has no rows of numbers in columns; write a line for each, like 0.1,0.35")
    whole, mark, count = max(widths, key=lambda width: (width[0], widths[width]))
    enough = all if whole else any

    def holds_numbers(line: _Line) -> bool:
        cells = _names(line.text, mark)
        return len(cells) == count and enough(is_value(cell) for cell in cells if cell)

    first = next(i for i, line in enumerate(rows) if holds_numbers(line))
    above = lines[: lines.index(rows[first])]
    wide = [(line, _names(line.text, mark)) for line in above if _is_as_wide(line.text, rows[first].text, mark)]
    if not wide:
        return _Layout(mark, [""] * count, None, rows[first:])
    line, header = wide[-1]
    if len(wide) > 1 and _is_of_units(header, len(wide[-2][1])):
        line = wide[-2][0]
        header = _join_units(wide[-2][1], header)
    return _Layout(mark, header, line, rows[first:])


def _layout(lines: Sequence[_Line], name: str) -> _Layout:
    """Return what separates columns, the cells of the header, where it stands, and the rows.

    A header names a speed and friction, also in a comment, and has a row of numbers below it, where blanks part
    them as many as there are names; a row of units may stand between. Anything else that looks like a header is
    refused.
    """
    rows = [line for line in lines if not line.comment]
    for i, line in enumerate(lines[:_LOOKED_AT]):
        start = sum(not earlier.comment for earlier in lines[: i + 1])
        below = rows[start : start + 1]
        cells = {mark: _names(line.text, mark) for mark in SEPARATORS}
        first = {mark: _names(below[0].text, mark) if below else [] for mark in SEPARATORS}
        where = f"{name}, line {line.number}"
        named = [mark for mark in SEPARATORS if is_header(cells[mark])]
        named.sort(key=lambda mark: not (below and _is_as_wide(line.text, below[0].text, mark)))
        if named and not below:
            raise InputError(f"{name} has no points below line {line.number}; write a line for each")
        for mark in named:
            names = cells[mark]
            values = first[mark]
            units = values + [""] * (len(names) - len(values)) * (mark != " ")
            if _is_of_units(units, len(names)):
                names = _join_units(names, units)
                start += 1
                values = []
                if start < len(rows):
                    values = _names(rows[start].text, mark)
            fits = len(values) > 1
            if mark == " ":
                fits = len(values) == len(names)
            if fits and any(map(is_value, values)):
                return _Layout(mark, names, line, rows[start:])

        if named and not line.comment:
            raise InputError(
                f"{where}: {line.text[:60]!r} names {len(cells[named[-1]])} columns, and line "
                f"{below[0].number}, {below[0].text[:50]!r}, has not as many numbers; write units in brackets "
                "behind the names, part columns by tabs or semicolons, and begin a title with #"
            )
        numbers = [mark for mark in SEPARATORS if len(cells[mark]) > 1 and all(map(_is_number, cells[mark]))]
        if numbers and not line.comment:
            mark = numbers[0]
            count = len(cells[numbers[0]])
            wide = [earlier for earlier in lines[:i] if len(_names(earlier.text, mark)) == count]
            header = []
            if wide:
                header = _names(wide[-1].text, mark)
            above = [list(map(_is_number, _names(row.text, mark))) for row in rows[: start - 1]]
            rowlike = any(2 * sum(numeric) > len(numeric) for numeric in above)
            if rowlike or any(map(_is_number, header)) or (below and len(first[mark]) != count):
                break
            if count == 2 and line is rows[0]:
                return _Layout(mark, [""] * count, None, rows[start - 1 :])
            break
    if not rows:
        raise InputError(f"{name} has no points; write a line for each, like 0.1,0.35")
    likest = _likest_layout(lines, name)
    got = rows[0] if likest is None or likest.line is None else likest.line
    advice: tuple[str | Remedy, ...] = ("; number the columns, like ", Argument("columns", {"v": 1, "mu": 3}))
    if likest is not None:
        parted = [(line.number, _cells(line.text, likest.separator)) for line in likest.rows[:_LOOKED_AT]]
        advice = _advice(name, likest.header, parted, _How({}, None, None, leave_out=False))
    raise InputError(
        f"{name}, line {got.number}: got {got.text[:60]!r}; a table begins with a header that names the slip "
        f"speed and friction, with units in brackets, like {EXPECTED}, or with its first point",
        *advice,
    )


def _likest_layout(lines: Sequence[_Line], name: str) -> _Layout | None:
    """Return how a table without a header that is understood is likely written; None where there are no rows."""
    try:
        return _layout_of_chosen(lines, name)
    except InputError:
        return None


def _copies(header: Sequence[str], rows: Sequence[_Row]) -> set[int]:
    """Return the numbers of columns that repeat the name and all cells of an earlier one."""
    copies = set[int]()
    if len(set(filter(None, header))) == len(list(filter(None, header))):
        return copies
    wide = [row for _, row in rows if len(row) >= len(header)]
    for number, name in enumerate(header):
        first = header.index(name)
        if name and first < number and all(row[first] == row[number] for row in wide):
            copies.add(number + 1)
    return copies


def _fill(table: Table, rows: Sequence[_Row], header: list[str], separator: str) -> None:
    """Take the cells that are read of all rows, each of which has as many columns as the header."""
    count = len(header)
    table.written = f"columns parted by {_PARTED[separator]}"
    read = {column.number - 1: quantity for quantity, column in table.columns.items() if not column.value}
    if separator == ",":  # a comma in a cell is one in quotes
        rows = _drop_thousands(rows, read)
    sign = _decimal_sign(_cells_of_columns(rows, read), table.name)
    table.written += f", decimal {'comma' if sign == ',' else 'point'}"
    looked_at = [row for _, row in rows[:_LOOKED_AT] if len(row) >= count]
    numeric = [  # a word in another column of numbers, like Mean, says that a row is none of measurements
        i for i in range(count)
        if i not in read and 2 * sum(_is_number(row[i]) for row in looked_at) > len(looked_at)
    ]  # fmt: skip
    table.cells = {quantity: [] for quantity in table.columns}
    kept = list[int]()
    for line, row in rows:
        text = separator.join(row)
        if len(row) < count or any(row[count:]):
            column = str(min(len(row), count))
            got = text[:60]
            reason = "of another number of columns"
            rule = f"the row has {len(row)} column{'s' * (len(row) > 1)}, and the header {count}"
            rule += "; where a comma is the decimal sign, part the columns by semicolons" * (separator == ",")
            if separator == "," and len(row) > count and _THOUSANDS_IN_ROW.search(text):
                raise InputError(  # left out, the largest numbers would be missing
                    f"{table.name}, line {line}: {rule}, and where it stands between thousands, write such "
                    f"numbers in quotes; got {text[:60]!r}"
                )
        else:
            wrong = [i for i in numeric if not (re.search(r"\d", row[i]) or _NOTHING.fullmatch(row[i]))]
            wrong += [i for i in read if not _NUMBERS[sign].fullmatch(row[i])]
            if not wrong:
                kept.append(line)
                for i, quantity in read.items():
                    table.cells[quantity].append(row[i].replace(sign, "."))
                continue
            i = wrong[0]
            reason = "without a number"
            column = f"{i + 1}" + (f", {table.columns[read[i]].text!r}" if i in read else "")
            got = row[i][:40]
            rule = "a finite number is needed, like 0.35, without a sign between thousands"
        if table.leave_out:
            later = [(line, row)]
        else:
            later = [other for other in rows if other[0] >= line]
        _refuse_second_table(table, later, separator)
        table.fault(line, f"{table.name}, line {line}, column {column}", repr(got), rule, reason)
        if any(map(_is_number, row)):
            v = table.columns["v"].number - 1
            is_known = v < len(row) and _NUMBERS[sign].fullmatch(row[v])
            table.without[line] = float(row[v].replace(sign, ".")) if is_known else math.nan

    table.lines = kept
    for quantity, known in table.columns.items():
        if known.value:
            table.cells[quantity] = [known.value] * len(table.lines)


def _take(table: Table, rows: FloatArray, first: int, separator: str) -> None:
    """Take the columns that are read of plain rows, which stand in successive lines."""
    table.written = f"columns parted by {_PARTED[separator]}, decimal point"
    table.lines = range(first, first + len(rows))
    for quantity, column in table.columns.items():
        if column.value:
            numbers = np.full(len(rows), float(column.value))
        else:
            numbers = rows[:, column.number - 1]
        table.values[quantity] = np.ascontiguousarray(numbers)


def _refuse_second_table(table: Table, rows: Sequence[_Row], separator: str) -> None:
    """Refuse rows among which there is a header, though it be the same: another run, or another step."""
    for line, row in rows:
        text = separator.join(row)
        if not any(map(_is_number, row)) and any(is_header(_names(text, mark)) for mark in SEPARATORS):
            raise InputError(
                f"{table.name}, line {line}: another header, {text.strip(SEPARATORS)[:60]!r}, begins a second "
                "table; save each as a file of its own"
            )


def _cells_of_columns(rows: Sequence[_Row], numbers: Iterable[int]) -> list[str]:
    """Return the cells of some columns, row by row, of rows that are wide enough."""
    cells = list[str]()
    for _, row in rows:
        cells += [row[i] for i in numbers if i < len(row)]
    return cells


def _drop_thousands(rows: Sequence[_Row], read: Iterable[int]) -> Sequence[_Row]:
    """Return rows without commas between thousands, where points say that commas are no decimal signs."""
    cells = _cells_of_columns(rows, read)
    commas = [cell for cell in cells if "," in cell]
    pointed = any("." in cell for cell in cells) or any(cell.count(",") > 1 for cell in commas)
    if not (commas and pointed and all(map(_THOUSANDS.fullmatch, commas))):
        return rows
    return [
        (line, [_THOUSANDS.sub(lambda cell: cell[0].replace(",", ""), cell) for cell in row]) for line, row in rows
    ]


def _decimal_sign(cells: Sequence[str], name: str) -> str:
    """Return the decimal sign of cells, or refuse both signs, or a comma that may stand between thousands."""
    commas = [cell for cell in cells if "," in cell and _is_number(cell)]
    points = []
    if commas:
        points = [cell for cell in cells if "." in cell and _is_number(cell)]
    if commas and (points or all(map(_THREE_DIGITS.fullmatch, commas))):
        raise InputError(
            f"{name}: the comma in {commas[0]!r} may be a decimal sign, or stand between thousands, as "
            f"{f'{points[0]!r} has a point' if points else 'all have three digits behind it'}; write one decimal "
            "sign everywhere, and none between thousands"
        )
    return "," if commas else "."


def _stand_ins(values: FloatArray, cells: Sequence[str]) -> BoolArray:
    """Return where a number stands for none: an overflow, or nines like 9999 or -999.

    These are beyond all other numbers, or negative and written without decimals where all others have some.
    """
    nines = np.array([_NINES.fullmatch(cell) is not None for cell in cells], dtype=bool)
    others = values[~nines]
    have_decimals = all("." in cell or "," in cell for cell, nine in zip(cells, nines, strict=True) if not nine)
    for i in np.flatnonzero(nines):
        ratio = others / values[i]
        is_near = ((ratio > 0.5) & ((ratio < 2) | (values[i] > 0))).any()
        nines[i] = not is_near or (values[i] < 0 and have_decimals)
    return np.asarray(nines | ~(np.abs(values) < OVERFLOW))

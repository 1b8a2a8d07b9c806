"""What could read a table that is refused: for each quantity the likeliest column, with a unit where it has none.

A proposal is words for a user, who knows what the columns are; nothing is read by it.
"""

import math
import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Reading
from stickslip_sym.model.measured.columns import HeaderColumn, choose_columns
from stickslip_sym.model.measured.preamble import WrittenRadius

_SPEED = re.compile(
    r"speed|velo|vel\b|omega|ω|rpm|gesch|dreh|slid|slip|\bqd|dq\b|\bv\b|hz|freq|rate|rot", re.IGNORECASE
)
_COMMANDED = re.compile(r"ref|set|cmd|command|target|desired|demand|soll", re.IGNORECASE)
_SLIP = re.compile(r"slid|slip|rel", re.IGNORECASE)
_FRICTION = (
    re.compile(r"cof|\bmu\b|μ|coeff", re.IGNORECASE),
    re.compile(r"fric|traction|tangent|reib|shear|drag|\bf_?t\b", re.IGNORECASE),
    re.compile(r"torque|moment|tau|τ", re.IGNORECASE),
    re.compile(r"\bf_?[xyr]\b|lateral|force|kraft|load ?cell", re.IGNORECASE),
    re.compile(r"current|strom|amp|\bi_?q?\b|effort|pwm|signal", re.IGNORECASE),
)
_TORQUE = _FRICTION[2]
_NORMAL = re.compile(r"normal|\bf_?[nz]\b|fz\b|load(?! ?cell)|weight|down|last\b", re.IGNORECASE)
_IN_TIME = re.compile(
    r"time|zeit|date|stamp|index|\bno\.?\b|\bnr\.?\b|step|count|sample|temp|position|\bpos\b|angle", re.IGNORECASE
)
_TURNING = re.compile(r"rad|omega|ω|joint|\bqd|dq\b|angular", re.IGNORECASE)
_RPM = re.compile(r"rpm|dreh|rev|spindle|rotat", re.IGNORECASE)
_FAST = 5.0  # m/s: a larger number is one of mm/s, or of um/s
_TRACK, _ANY = "25 mm", Fraction(25, 1000)  # a radius, for an example
_FORCE = "10 N"  # the same
_LEAST_RATIO = 2.0  # of the normal force to the friction force, for an example


def proposed(
    name: str,
    header: Sequence[str],
    rows: Sequence[Sequence[str]],
    chosen: Mapping[str, str | int],
    radius: Fraction | None,
    written: WrittenRadius | None,
    block: int | None = None,
) -> Reading | None:
    """Return the call that may read a table, or None where its columns of numbers are too few.

    - `rows`: the cells of some rows.
    - `chosen`, `radius`, `block`: what the user gave, which stays.
    - `written`: a radius above the table.
    """
    values = {i: _numbers_of_column(rows, i) for i in range(len(header))}
    columns = [HeaderColumn.read(text, i + 1) for i, text in enumerate(header) if len(values[i])]
    left = [
        column for column in columns if not (_IN_TIME.search(column.name) or _counts(column, values))
    ] or columns
    picked = dict[str, str | int](chosen)
    speed = None if "v" in chosen else _speed(left, values)
    if "v" not in chosen:
        if speed is None:
            return None
        left.remove(speed)
        picked["v"] = _give_unit(speed, _unit_of_speed(speed, left, values), "speed", "rotation")
    if not picked.keys() & {"mu", "F_t"}:
        friction = _friction(left)
        if friction is None:
            return None
        left.remove(friction)
        quantity, unit = _quantity_of_friction(friction)
        picked[quantity] = _give_unit(friction, unit, *(("number",) if quantity == "mu" else ("force", "torque")))
    if "mu" not in picked and "F_n" not in picked:
        picked["F_n"] = _normal_force(left, values, picked["F_t"], columns)
    given = None
    if radius is not None:
        given = f"{float(1000 * radius):g} mm"
    track = given or _written(written) or _TRACK
    for these, size in ((dict(chosen), given), (dict(chosen), track), (picked, given), (picked, track)):
        if these:
            arguments = dict[str, object](columns=these)
        else:
            arguments = {}
        try:
            choose_columns(header, name, these, radius or (None if size is None else _ANY), (), written)
        except InputError:
            continue
        if size is not None:
            arguments |= {"radius": size}
        return Reading.of(name, **arguments, **({} if block is None else {"block": block}))
    return None


def _numbers_of_column(rows: Sequence[Sequence[str]], i: int) -> FloatArray:
    """Return the numbers of a column; none where most cells are none."""
    numbers = list[float]()
    filled = 0
    for row in rows:
        if i < len(row) and row[i]:
            filled += 1
            with suppress(ValueError):
                numbers.append(float(row[i].replace(",", ".")))
    finite = np.array([number for number in numbers if math.isfinite(number)])
    return finite if 2 * len(finite) > filled else np.zeros(0)


def _counts(column: HeaderColumn, values: Mapping[int, FloatArray]) -> bool:
    """Return whether the first of several columns without a name rises in even steps, as time or a count does."""
    steps = np.diff(values[column.number - 1])
    return (
        column.number == 1 < len(values) - 2
        and not column.name
        and len(steps) > 1
        and bool(np.allclose(steps, steps[0]))
    )


def _speed(columns: Sequence[HeaderColumn], values: Mapping[int, FloatArray]) -> HeaderColumn | None:
    """Return the likeliest column of the slip speed."""

    def likely(column: HeaderColumn) -> tuple[bool, ...]:
        varied = values[column.number - 1]
        return (
            "v" in column.possible and column.unit is not None,
            "v" in column.meanings or bool(_SPEED.search(column.name)),
            bool(_SLIP.search(column.name)),
            not _COMMANDED.search(column.name),
            bool(np.ptp(varied) > 0),
            not any(pattern.search(column.name) for pattern in (*_FRICTION, _NORMAL)),
        )

    if len(columns) > 1:
        return max(columns, key=likely, default=None)
    return None


def _friction(columns: Sequence[HeaderColumn]) -> HeaderColumn | None:
    """Return the likeliest column of friction."""

    def likely(column: HeaderColumn) -> tuple[int, bool]:
        rank = next((i for i, pattern in enumerate(_FRICTION) if pattern.search(column.name)), len(_FRICTION))
        if _NORMAL.search(column.name) or "v" in column.meanings:
            rank += len(_FRICTION)
        if set(column.meanings) & {"mu", "F_t"}:
            rank = min(rank, 1)
        return -rank, not _COMMANDED.search(column.name)

    return max(columns, key=likely, default=None)


def _quantity_of_friction(column: HeaderColumn) -> tuple[str, str]:
    """Return whether a column is mu or F_t, and a unit for it, empty for none."""
    kind = column.unit.kind if column.unit is not None else ""
    if kind in ("force", "torque"):
        return "F_t", ""
    if (_FRICTION[0].search(column.name) or "mu" in column.meanings) and kind in ("", "number"):
        return "mu", ""
    unit = "N m" if _TORQUE.search(column.name) else "N"
    is_signal = bool(column.unit_text) or _FRICTION[-1].search(column.name)
    return "F_t", f"1 {unit}" if is_signal else unit  # of one of what it is in, which the user knows


def _unit_of_speed(column: HeaderColumn, others: Sequence[HeaderColumn], values: Mapping[int, FloatArray]) -> str:
    """Return a likely unit of a speed that has none."""
    friction = _friction(others)
    if _TURNING.search(column.text) or (friction is not None and _TORQUE.search(friction.name)):
        return "rad/s"
    if _RPM.search(column.text):
        return "rpm"
    size = float(np.max(np.abs(values[column.number - 1])))
    if size <= _FAST:
        return "m/s"
    if size <= 1000 * _FAST:
        return "mm/s"
    return "um/s"


def _give_unit(column: HeaderColumn, unit: str, *kinds: str) -> str | int:
    """Return a column by its number, with a unit where it has none of these kinds."""
    known = column.unit is not None and column.unit.kind in kinds
    if known or not unit:
        return column.number
    return f"{column.number} [{unit}]"


def _normal_force(
    columns: Sequence[HeaderColumn],
    values: Mapping[int, FloatArray],
    friction: str | int,
    all_columns: Sequence[HeaderColumn],
) -> str | int:
    """Return the column of the normal force, or one force that is above the friction force."""
    named = [column for column in columns if "F_n" in column.possible or _NORMAL.search(column.name)]
    if named:
        return _give_unit(named[0], "N", "force")
    match = re.fullmatch(r"(?P<number>\d+)(?: \[(?P<unit>.*)\])?", str(friction))
    column = next((each for each in all_columns if match and str(each.number) == match["number"]), None)
    if match is None or column is None:
        return _FORCE
    column = replace(column, meanings=("F_t",), unit_text=match["unit"] or column.unit_text, chosen=True)
    largest = float(np.max(np.abs(values[column.number - 1]), initial=0.0)) * float(column.size)
    least = _LEAST_RATIO * (largest / float(_ANY) if column.is_torque else largest)
    if least > 0:
        return f"{10 ** math.ceil(math.log10(least)):g} N"
    return _FORCE


def _written(written: WrittenRadius | None) -> str:
    """Return a radius that stands above a table, in mm where it has no unit."""
    if written is None:
        return ""
    if written.text[-1].isdigit():
        return f"{written.text} mm"
    return written.text

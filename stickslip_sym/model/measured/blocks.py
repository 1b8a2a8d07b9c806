"""Blocks of a file of measurements: a preamble, a header, its rows, and again, for each step of a machine."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.probabilities import FAR_OFF
from stickslip_sym.core.remedies import Reading
from stickslip_sym.model.measured.columns import HeaderColumn
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.tables import SHOWN_CHARACTERS

_STEP = re.compile(r"\W*(step|segment|stage|run|test|block|cycle|part|schritt|lauf)\b", re.IGNORECASE)
VARIES = 0.1  # of the largest size of some values, beyond which they vary
_FIRST = "v", "mu", "F_t"  # quantities that are named before others
_COLUMNS_NAMED = 4  # columns that vary, which are named
_IN_TIME = re.compile(r"time|zeit|date|stamp|index|no\.?|nr\.?|step|count|sample", re.IGNORECASE)
_CONTRADICTS = 0.2  # of the mean coefficient, by which two blocks differ that measured other things


@dataclass(frozen=True)
class Block(DataResult):
    """A block of a file: a table with its own header, and what the lines above it say.

    Attributes
    ----------
    number : int
        From 1, as ``block`` chooses it.
    line : int
        Of its header.
    label : str
        The line above that names the step; empty if none does.
    rows : int
    varies : tuple of str
        The columns whose values vary, each with its range.
    read : bool
        Whether its rows are among those that were read.
    """

    reported = ("number", "line", "label", "rows", "varies", "read")

    number: int
    line: int
    label: str
    rows: int
    varies: tuple[str, ...]
    read: bool = True

    def __str__(self) -> str:
        label = f", {self.label!r}" if self.label else ""
        return f"block {self.number} (line {self.line}{label}, {self.rows} rows: {', '.join(self.varies)})"


def label_of(preamble: Sequence[str]) -> str:
    """Return what lines above a header call the step: the last one that names a step, with its description."""
    named = [" ".join(text.split()) for text in preamble if _STEP.match(text)]
    return "; ".join(named[-2:])[:SHOWN_CHARACTERS]


def varying(names: Sequence[str], cells: Sequence[Sequence[str]]) -> tuple[str, ...]:
    """Return which named columns of numbers vary, with their ranges; the speed first, and time is none."""
    found = list[tuple[int, str]]()
    for i, name in enumerate(names):
        if not name or name in names[:i] or _IN_TIME.search(name):
            continue
        values = _numbers([row[i] for row in cells if i < len(row)])
        if len(values) and np.ptp(values) > VARIES * np.max(np.abs(values)):
            meanings = HeaderColumn.read(name).meanings
            if meanings and meanings[0] in _FIRST:
                place = _FIRST.index(meanings[0])
            else:
                place = len(_FIRST)
            found.append((place, f"{name} {values.min():.4g} to {values.max():.4g}"))
    return tuple(text for _, text in sorted(found, key=lambda each: each[0])[:_COLUMNS_NAMED])


def _numbers(cells: Sequence[str]) -> FloatArray:
    """Return the cells that are numbers."""
    numbers = list[float]()
    for cell in cells:
        try:
            numbers.append(float(cell.replace(",", ".")))
        except ValueError:
            continue
    values = np.array(numbers)
    finite: FloatArray = values[np.isfinite(values)]
    return finite


def refuse_contradiction(
    name: str, v: FloatArray, mu: FloatArray, origin: IntArray, blocks: Sequence[Block]
) -> None:
    """Refuse blocks that measured other coefficients at the speeds that they share: they are no one sweep.

    `origin` is the number of each row's block.

    Raises
    ------
    InputError
        With both blocks, and what chooses one.
    """
    sweeps = []
    for number in np.unique(origin):
        rows = origin == number
        speeds, index = np.unique(v[rows], return_inverse=True)
        sweeps.append((int(number), speeds, np.bincount(index, mu[rows]) / np.bincount(index)))
    for i, (first, speeds, means) in enumerate(sweeps):
        for second, others, theirs in sweeps[i + 1 :]:
            low = max(speeds[0], others[0])
            high = min(speeds[-1], others[-1])
            shared = np.union1d(speeds, others)
            shared = shared[(shared >= low) & (shared <= high)]
            if not len(shared):
                continue
            ours = np.interp(shared, speeds, means)
            other = np.interp(shared, others, theirs)
            apart = ours - other
            error = float(np.std(apart)) / np.sqrt(len(apart))
            size = float(np.mean(np.abs(ours) + np.abs(other))) / 2
            if abs(apart.mean()) > max(_CONTRADICTS * size, FAR_OFF * error):
                both = [next(block for block in blocks if block.number == number) for number in (first, second)]
                raise InputError(
                    f"{name}: {both[0]} and {both[1]} contradict each other: from {low:.3g} to {high:.3g} m/s "
                    f"mu is {ours.mean():.3g} and {other.mean():.3g} on average; read one of them: ",
                    Reading.of(name, block=first),
                )

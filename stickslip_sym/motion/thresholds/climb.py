"""The way up the ladder: the cheapest rung that is known to be good enough, or the error of one that was named."""

from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NO_RESULT, NotConverged, OutOfTime
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import Rung, average, ladder, numerical_averages, rungs
from stickslip_sym.motion.thresholds.scenes import Scenes

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = ["accuracy", "by_name", "climb"]

_REFERENCE = 1e-10  # error of the best value, from which the error of others is told
_GOOD = 1e-8  # of that error, what need not be improved by a rung that takes scenes one by one


def accuracy(error: float | None) -> str:
    """Return an error as text."""
    return "unknown" if error is None or not np.isfinite(error) else f"{error:.0e}"


def by_name(scenes: Scenes, rung: Rung, rtol: float) -> "tuple[FloatArray, FloatArray, tuple[Theorem, ...]]":
    """Return the value of one rung, its error, and what was proved."""
    rung.require_smooth(scenes.law, scenes.V)
    found = rung.compute(scenes, rtol)
    _require(scenes, found.error <= max(rtol, rung.reachable), found.reason, found.error)
    if rung.knows_its_error:
        return found.value, found.error, found.theorems
    reference, doubt = _best(scenes, _REFERENCE)
    return found.value, _distance(found.value, reference) + doubt + found.error, ()


def _best(scenes: Scenes, rtol: float) -> tuple[FloatArray, FloatArray]:
    """Return the best value known of each scene, and its error, infinite where there is none."""
    smooth = obstacle(scenes.law, scenes.V) is None
    value, error = np.zeros(len(scenes)), np.full(len(scenes), np.inf)
    for rung in _exact(smooth):
        if not rung.singly:
            found = rung.compute(scenes, rtol)
            better = found.error < error
            value, error = np.where(better, found.value, value), np.where(better, found.error, error)
            continue
        for row in np.flatnonzero(~(error <= max(rtol, _GOOD))):
            try:
                found = rung.compute(scenes.rows([int(row)]), max(rtol, _GOOD))
            except NO_RESULT:
                continue
            if found.error[0] < error[row]:
                value[row], error[row] = found.value[0], found.error[0]
    return value, error


def _exact(smooth: bool) -> list[Rung]:
    """Return the rungs that know their error, for a law that is smooth, or any."""
    return [rung for rung in ladder(smooth) if rung.knows_its_error]


def climb(scenes: Scenes, rtol: float) -> tuple[FloatArray, ObjectArray, FloatArray]:
    """Return for each scene the cheapest rung that is known to be good enough: value, name and error.

    Raises `NotConverged` if the error of a scene is above `rtol` on the highest rung.
    Raises `OutOfTime` with the best value so far.
    """
    chosen = _Choice(len(scenes), rtol)
    smooth = obstacle(scenes.law, scenes.V) is None
    averages = {name: rung.criterion for name, rung in rungs().items() if rung.criterion is not None}
    columns = (
        numerical_averages(scenes)
        if smooth
        else {name: average(scenes, criterion) for name, criterion in averages.items()}
    )
    best = None
    for rung in ladder(smooth):
        if rung.knows_its_error or rung.criterion is not None:
            continue
        found = rung.compute(scenes, rtol)
        if found.doubt is not None:
            chosen.settle(np.arange(len(scenes)), columns, found.value, found.doubt)
            best = found.value, found.doubt
        columns[rung.name] = found.value
    exact = _exact(smooth)
    for rung in exact:
        for rows in chosen.open[:, None] if rung.singly else [chosen.open]:
            try:
                reason = _settle(scenes, rows, rung, columns, chosen)
            except OutOfTime as stop:
                if best is None:
                    raise
                raise OutOfTime(_so_far(stop, scenes, rows[0], *best)) from None
            left = np.intersect1d(rows, chosen.open)
            if rung is exact[-1] and left.size:
                raise NotConverged(
                    f"rtol = {rtol:g} is not reached for {scenes.label(left[0])}: {reason}; try another rtol"
                )
    return chosen.value, chosen.method, chosen.error


def _settle(scenes: Scenes, rows: IntArray, rung: Rung, columns: dict[str, FloatArray], chosen: "_Choice") -> str:
    """Choose rungs for scenes by a value that knows its error; say why one is left without."""
    reason = ""
    for tolerance in rung.attempts(chosen.rtol):  # tighter and tighter: a kink costs an integrator its order
        if not rows.size:
            break
        try:
            found = rung.compute(scenes.rows(rows), tolerance)
        except NotConverged as failure:
            reason = str(failure)
            continue
        chosen.settle(rows, columns | {rung.name: found.value}, found.value, found.error)
        still = np.isin(rows, chosen.open)
        if still.any():
            reason = f"the threshold is known to {found.error[still][0]:.1e} relative only"
        rows = rows[still]
    return reason


def _so_far(stop: OutOfTime, scenes: Scenes, row: int, value: FloatArray, error: FloatArray) -> str:
    """Say what is known of the first scene that is not settled."""
    best = f"{value[row]:.10g} kg/s, relative error {accuracy(error[row])}"
    return f"{stop}; the best value found for {scenes.label(row)} is {best}"


class _Choice:
    """The rungs chosen so far."""

    def __init__(self, count: int, rtol: float) -> None:
        self.rtol = rtol
        self.value, self.error = np.zeros(count), np.full(count, np.inf)
        self.method = np.full(count, "", dtype=object)  # texts of one width would cut longer ones

    @property
    def open(self) -> IntArray:
        """Scenes without a rung."""
        return np.flatnonzero(self.method == "")

    def settle(
        self, rows: IntArray, values: dict[str, FloatArray], reference: FloatArray, doubt: FloatArray
    ) -> None:
        """Choose the first rung close enough to a reference that is itself in doubt by `doubt`.

        The values of rungs belong to all scenes, or like the reference to `rows` only.
        """
        for name, column in values.items():
            value = column if len(column) == len(rows) else column[rows]
            error = _distance(value, reference) + doubt
            fits = (self.method[rows] == "") & (error <= self.rtol)
            self.value[rows[fits]], self.error[rows[fits]] = value[fits], error[fits]
            self.method[rows[fits]] = name


def _distance(value: FloatArray, reference: FloatArray) -> FloatArray:
    """Return the relative difference, infinite where one of the two is no number."""
    with np.errstate(all="ignore"):
        difference = np.where(value == reference, 0.0, np.abs(value - reference) / np.abs(reference))
    return np.where(np.isnan(difference), np.inf, difference)


def _require(scenes: Scenes, good: BoolArray, reason: str, error: FloatArray) -> None:
    """Refuse what has not the accuracy that was asked for."""
    bad = np.flatnonzero(~np.asarray(good))
    if bad.size:
        row = int(bad[0])
        reached = f"the error is {error[row]:.1e}" if np.isfinite(error[row]) else "there is no value"
        raise NotConverged(f'{reached} for {scenes.label(row)}: {reason}; try method="simulation"')

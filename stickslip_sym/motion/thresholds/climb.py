"""The way up the ladder: the cheapest rung that is known to be good enough, or the error of one that was named."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NO_RESULT, NotConverged, NoThreshold, OutOfTime
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import Found, Rung, ladder
from stickslip_sym.motion.thresholds.scenes import Scenes

if TYPE_CHECKING:
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = ["accuracy", "by_name", "climb"]

_REFERENCE = 1e-10  # error of the best value, from which the error of others is told
_GOOD = 1e-8  # of that error, what need not be improved by a rung that is not quick


def accuracy(error: float | None) -> str:
    """Return an error as text."""
    return "unknown" if error is None or not np.isfinite(error) else f"{error:.0e}"


def by_name(scenes: Scenes, rung: Rung, rtol: float) -> "tuple[FloatArray, FloatArray, tuple[Theorem, ...]]":
    """Return the value of one rung, its error, and what was proved."""
    rung.require_smooth(scenes.law, scenes.V)
    if rung.quickly is not None and not rung.knows_its_error:
        found = rung.quickly(scenes, rtol)
        if (found.error <= rtol).all():
            return found.value, found.error, ()
    found = rung.compute(scenes, rtol)
    _require(scenes, found.error <= max(rtol, rung.reachable), found.reason, found.error)
    if rung.knows_its_error:
        return found.value, found.error, found.theorems
    reference, doubt = _best(scenes, _REFERENCE)
    return found.value, _distance(found.value, reference) + doubt + found.error, ()


@dataclass(frozen=True)
class _Try:
    """One way in which "auto" asks a rung."""

    rung: Rung
    compute: Callable[[Scenes, float], Found]
    tolerances: tuple[float, ...]  # tighter and tighter: a kink costs an integrator its order


def _tries(smooth: bool, rtol: float) -> list[_Try]:
    """Return what knows its own error, the cheapest first.

    What it takes to know the error of another rung gives a closer value by itself. Where a rung is not quick, it
    takes longer than those that take one scene after another, as far as these reach.
    """
    rungs = ladder(smooth)
    quick = [_Try(rung, rung.quickly, (rtol,)) for rung in rungs if rung.quickly is not None]
    whole = [_Try(rung, rung.compute, rung.attempts(rtol)) for rung in rungs if rung.knows_its_error]
    if any(rung.singly and rung.best <= rtol for rung in rungs):
        whole.sort(key=lambda one: one.rung.quickly is not None)
    return quick + whole


def _best(scenes: Scenes, rtol: float) -> tuple[FloatArray, FloatArray]:
    """Return the best value known of each scene, and its error, infinite where there is none."""
    chosen = _Choice(len(scenes), max(rtol, _GOOD))
    for one in _tries(obstacle(scenes.law, scenes.V) is None, rtol):
        quick = one.compute is one.rung.quickly
        for rows in _groups(np.flatnonzero(~(chosen.error <= (rtol if quick else chosen.rtol))), one.rung):
            try:
                found = one.compute(scenes.rows(rows), max(rtol, _GOOD) if one.rung.singly else rtol)
            except NO_RESULT:
                continue
            chosen.improve(rows, one.rung, found)
    return chosen.value, chosen.error


def _groups(rows: IntArray, rung: Rung) -> list[IntArray]:
    """Return which scenes a rung takes together."""
    return list(rows[:, None]) if rung.singly else [rows] * bool(rows.size)


def climb(scenes: Scenes, rtol: float) -> tuple[FloatArray, ObjectArray, FloatArray]:
    """Return for each scene the first value that is known to be good enough: value, name of its rung and error.

    Raises `NotConverged` if the error of a scene is above `rtol` on the highest rung.
    Raises `OutOfTime` with the best value so far.
    """
    chosen = _Choice(len(scenes), rtol)
    tries = _tries(obstacle(scenes.law, scenes.V) is None, rtol)
    for one in tries:
        for rows in _groups(chosen.open, one.rung):
            try:
                reason = _settle(scenes, rows, one, chosen, last=one is tries[-1])
            except OutOfTime as stop:
                raise OutOfTime(f"{stop}{chosen.so_far(scenes, int(rows[0]))}") from None
            left = np.intersect1d(rows, chosen.open)
            if one is tries[-1] and left.size:
                raise chosen.refusals.get(int(left[0])) or NotConverged(
                    f"rtol = {rtol:g} is not reached for {scenes.label(left[0])}: {reason}; try another rtol"
                )
    return chosen.value, chosen.method, chosen.error


def _settle(scenes: Scenes, rows: IntArray, one: _Try, chosen: "_Choice", *, last: bool) -> str:
    """Improve what is known of scenes; say why one is left without a value that is good enough."""
    reason = ""
    for tolerance in one.tolerances:
        try:
            found = one.compute(scenes.rows(rows), tolerance)
        except NotConverged as failure:
            reason = str(failure)
            continue
        except NoThreshold as refusal:  # for no damping at all; the orbit may know one below 0
            if last:
                raise
            chosen.refusals |= dict.fromkeys(rows.tolist(), refusal)
            break
        chosen.improve(rows, one.rung, found)
        rows = np.intersect1d(rows, chosen.open)
        if not rows.size:
            break
        reason = found.reason or f"the threshold is known to {chosen.error[rows[0]]:.1e} relative only"
    return reason


class _Choice:
    """The closest values so far."""

    def __init__(self, count: int, rtol: float) -> None:
        self.rtol = rtol
        self.value, self.error = np.zeros(count), np.full(count, np.inf)
        self.method = np.full(count, "", dtype=object)  # texts of one width would cut longer ones
        self.refusals: dict[int, NoThreshold] = {}

    @property
    def open(self) -> IntArray:
        """Scenes without a value that is good enough."""
        return np.flatnonzero(~(self.error <= self.rtol))

    def improve(self, rows: IntArray, rung: Rung, found: Found) -> None:
        """Take the values that are closer."""
        better = found.error < self.error[rows]
        self.value[rows[better]], self.error[rows[better]] = found.value[better], found.error[better]
        self.method[rows[better]] = rung.name

    def so_far(self, scenes: Scenes, row: int) -> str:
        """Say what is known of a scene, if anything is."""
        if not np.isfinite(self.error[row]):
            return ""
        best = f"{self.value[row]:.10g} kg/s, relative error {accuracy(self.error[row])}"
        return f"; the best value found for {scenes.label(row)} is {best}"


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

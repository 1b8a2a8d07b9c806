"""The motions at many dampings of many operating points of one law, decided by comparisons.

As in `regime`, the slip from P returns exactly where c lies below the exact threshold. The damping d(A) that a
slip orbit of amplitude A V needs gives every slip cycle as a root of d(A) = c, stable where d falls; d(0) is the
equilibrium's threshold. The gap of the halves of an orbit is enough to decide: it has the sign of d(A) - c.

A law with mu(0+) = 0 holds no mass. Where the slip from P returns then, motions go out to one that overtakes the
belt each round, since damping and friction bring those far out back in.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from enum import Enum
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NO_RESULT, OutOfTime, StickSlipError
from stickslip_sym.criteria.criterion import least_squares
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.compiled import compilable
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.needed import SIGNS, Found, needed_all, sure_gap
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Signs
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.regimes.regime import regime
from stickslip_sym.motion.regimes.rounds import friction_far_out, rounds
from stickslip_sym.motion.roots import closest, orbit_signs
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.thresholds.averages import slope_mean

LATE = "not reached: time limit, or Ctrl-C"
CURVES = {
    "equilibrium": ("threshold of the equilibrium", ":", "black"),
    "least_squares": ("least-squares criterion", "--", "#0072B2"),
    "exact": ("exact threshold", "-", "black"),
}
"""The thresholds of an operating point: their names in legends, and how they are drawn."""
_KNOWN = 1e-8  # of the largest threshold, to which all of them are known
_UNSURE = 1e-9  # gap of which they may not tell the sign
_FOLD = 1e-7  # amplitude to which a fold is found; the damping there is known to its square
_FINER = 1e-2  # tolerance of the motions of single cells over that of thresholds


class Reason(Enum):
    """How a cell was decided."""

    ABOVE = "above every threshold and fold"
    BELOW = "below every threshold and fold"
    BETWEEN = "between thresholds or folds: by the damping that slip orbits need"
    SIMULATED = "simulated"
    TOLERANCE = "within tolerance of a threshold or a fold"
    FAILED = "failed"
    TIME = LATE


class Line(NamedTuple):
    """Operating points of a law at one belt speed, and dampings for each.

    - `place`: rows and columns of the cells in a map, each of the shape of the dampings.
    - `points`: values of V, N, m and k, and of parameters of the law, in place of those it has.
    - `c`: a row for each point.
    """

    place: tuple[IntArray, IntArray]
    points: Sequence[Mapping[str, float]]
    c: FloatArray


class Cells(NamedTuple):
    """What is known of the cells of a line; arrays are of the shape of its dampings.

    - `motion`, `reason`: arrays of `Motion` and of `Reason`.
    - `attractors`: whether there are those of each kind, by the names in `ATTRACTORS`.
    - `thresholds`: in kg/s, by the names in `CURVES`, a row for each point; NaN where one was not found.
    - `notes`: why a cell failed or stayed undecided.
    """

    motion: ObjectArray
    reason: ObjectArray
    attractors: dict[str, BoolArray]
    thresholds: dict[str, FloatArray]
    notes: dict[tuple[int, ...], str]


def reason_of(error: StickSlipError) -> Reason:
    """Return the reason of cells of which no more is known than an error."""
    return Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED


def decide(law: FrictionLaw, rtol: float, lines: Sequence[Line]) -> list[Cells | StickSlipError]:
    """Return the motion from x = 0, x' = V, and every attractor, for the cells of each of some lines.

    - `law`: with all parameters bound.
    - `rtol`: a damping that is closer to a threshold or a fold, relative to the largest of them, is not decided.

    Where a line fails its error stands for it; where a cell does, a note.
    """
    bound = cache(lambda values: law.bind(**dict(values)))
    found: list[Cells | StickSlipError] = []
    for line in lines:
        try:
            check_time()
            values = ((name, value) for name, value in line.points[0].items() if name in law.parameters)
            found.append(_Decider(bound(tuple(values)), line, rtol).cells())
        except StickSlipError as error:
            found.append(error)
    return found


@compilable
def _gaps_all(rise: Any, eta: Any, push: Any, A: Any, zeta: Any, rtol: float, wedge: Any, found: Any) -> None:
    """Find the gaps of orbits, of the sign of the needed damping ratio minus the one there is."""
    for i in range(len(A)):
        found[i, 0] = sure_gap(rise, eta[i], zeta[i], push[i], A[i], rtol, wedge[2])[0]


class _Decider:
    """Decides the cells of a line; dampings are damping ratios here, a row for each oscillator."""

    def __init__(self, law: FrictionLaw, line: Line, rtol: float) -> None:
        self.law, self.line, self.rtol = law, line, rtol
        self.oscillators = [Oscillator(**{name: point[name] for name in "VNmk"}) for point in line.points]
        self.system = Dimensionless.of(law, self.oscillators[0])
        self.table, V = self.system.table, self.system.V
        self.eta = np.array([osc.eta for osc in self.oscillators])
        self.ratio = np.array([[2 * osc.impedance] for osc in self.oscillators])  # damping over damping ratio
        self.zeta = line.c / self.ratio
        self.N = np.array([[osc.N] for osc in self.oscillators])
        at_kink = any(abs(kink / V - 1) <= _KNOWN for kink in self.table.kinks)
        self.equilibrium = -self.N * (math.nan if at_kink else float(law.slope(V))) / self.ratio
        found = self._needed(np.arange(len(self.eta)), np.ones(len(self.eta)))
        self.exact, self.error = found[:, :1], found[:, 1:]

    def _orbits(
        self, loop: Callable[..., None], width: int, row: IntArray, A: FloatArray, *columns: FloatArray
    ) -> FloatArray:
        """Return what a loop finds of orbits, by oscillators' numbers and amplitudes over V."""
        eta = self.eta[row]
        push = eta * (self.table.static - self.table.onset)
        found = self.system.spread(loop, (eta, push, A, *columns), (SIGNS,), width, few=0)
        check_time()
        return found

    def _needed(self, row: IntArray, A: FloatArray) -> FloatArray:
        """Return needed damping ratios and their errors, a row for each orbit; NaN where there is none."""
        found = self._orbits(needed_all, 6, row, A)
        return np.where(found[:, :1] == Found.ROOT, found[:, 1:3], math.nan)

    def cells(self) -> Cells:
        """Decide the cells."""
        zeta, exact, equilibrium = self.zeta, self.exact, self.equilibrium
        largest = np.nanmax(np.abs(np.hstack([exact, equilibrium])), axis=1, initial=0.0, keepdims=True)
        margin = max(self.rtol, _KNOWN) * largest + np.nan_to_num(self.error)
        near = (np.abs(zeta - exact) <= margin) | (np.abs(zeta - equilibrium) <= margin)
        returns, rest = zeta < exact, zeta > equilibrium
        held, escapes, known = self._after_return(returns)
        known &= np.isfinite(exact + equilibrium)
        cycle, stable = self._slip_cycles(near, known, margin)
        signs = Signs(rest=rest, falls=stable, returns=returns & ~escapes, held=held)
        motion, reason = np.full(zeta.shape, Motion.REST), np.full(zeta.shape, Reason.BETWEEN)
        motion[returns | cycle] = Motion.PURE_SLIP
        motion[returns & held] = Motion.STICK_SLIP
        motion[escapes] = Motion.UNBOUNDED
        reason[~returns & rest & ~cycle] = Reason.ABOVE
        reason[returns & ~rest & ~cycle] = Reason.BELOW
        motion[near], reason[near] = Motion.UNDECIDED, Reason.TOLERANCE
        average = np.full(self.N.shape, math.nan)
        with suppress(*NO_RESULT):
            average = self.N * slope_mean(self.law, least_squares, np.array([self.system.V]))
        curves = equilibrium * self.ratio, average, exact * self.ratio
        cells = Cells(
            motion, reason,
            attractors={kind.name: kind.exists(signs) & ~near for kind in ATTRACTORS},
            thresholds=dict(zip(CURVES, curves, strict=True)),
            notes={
                (i, j): f"c = {self.line.c[i, j]:.12g} is within {margin[i, 0] * self.ratio[i, 0]:.1e} kg/s of a "
                "threshold or a fold"
                for i, j in np.argwhere(near).tolist()
            },
        )  # fmt: skip
        for i, j in np.argwhere(~(near | known)).tolist():
            self._follow(cells, i, j)
        return cells

    def _after_return(self, returns: BoolArray) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Tell where the motion from x = 0, x' = V sticks for good, where it grows without bound, and where known.

        Where the slip from P returns beyond what static friction holds the mass overtakes the belt. It may stick
        after that; else it never sticks again. A motion that sticks at first leaves at P; any other is outside.
        """
        zeta, static = self.zeta, self.eta[:, None] * self.table.static
        begin = 2 * zeta - static  # q of the initial condition
        sticks = (begin <= 0) & (begin >= -2 * static)

        def ends(cells: tuple[IntArray, ...], q: FloatArray) -> FloatArray:
            return rounds(self.system, q, SIGNS, eta=self.eta[cells[0]], zeta=zeta[cells], few=0)

        end = np.zeros(zeta.shape)
        cells = np.nonzero(returns)
        end[cells] = ends(cells, np.zeros(cells[0].size))
        held, on_it = np.isnan(end), sticks | (static == 0)
        comes_in = self.line.c + self.N * friction_far_out(self.law, self.system.V) >= 0
        escapes = np.isinf(end) & ~comes_in & math.isinf(self.table.reach)
        known = (held | (np.isfinite(end) & (end > 0) & comes_in)) & on_it | escapes
        known |= ~returns & ((zeta >= 0) | sticks)
        if self.table.static == 0:
            # The initial condition is outside the orbit from P: it may be held back by one that overtakes.
            cells = np.nonzero(~returns & (zeta >= 0))
            known[cells] = ends(cells, begin[cells]) == 0
        return held, escapes, known

    def _slip_cycles(self, near: BoolArray, known: BoolArray, margin: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Tell where there is a cycle in pure slip, and a stable one.

        Where a fold is as near as the margin this is noted in `near`, and where it is not known in `known`.
        """
        zeta, grows_at_rest = self.zeta, self.zeta < self.equilibrium
        jumps = any(self.system.rise.jumps)
        found = orbit_signs(self._gaps, grows_at_rest.ravel())
        parts = found.cycle, found.stable, found.grows, found.lost
        cycle, stable, grows, lost = (part.reshape(zeta.shape) for part in parts)
        known &= ~lost
        if self.table.static == self.table.onset:
            # A cycle may touch the belt's speed but for less than what is looked at.
            last = grows != (zeta < self.exact)
            cycle, stable = cycle | last, stable | last & grows
        for cell, low, high in found.open:
            i, j = divmod(cell, zeta.shape[1])
            if jumps:
                known[i, j] = False
            elif known[i, j] and not near[i, j]:
                beyond, off = self._beside_fold(i, float(zeta[i, j]), low, high)
                # Where d passes c twice one of the two cycles is stable; else the next range has the other.
                cycle[i, j] |= beyond
                stable[i, j] |= beyond
                near[i, j] |= off <= margin[i, 0]
                known[i, j] = not math.isnan(off)
        return cycle, stable

    def _gaps(self, cell: IntArray, A: FloatArray) -> FloatArray:
        """Return gaps, cut at -1 and 1, by the numbers of cells; NaN where the sign is not known."""
        rows, zeta = cell // self.zeta.shape[1], self.zeta.ravel()[cell]
        found = self._orbits(_gaps_all, 1, rows, A, zeta)[:, 0]
        unsure = np.fmin(_UNSURE, 2 * math.pi * self.error[rows, 0])  # of weak friction all gaps are small
        return np.where(np.abs(found) < unsure, math.nan, np.clip(found, -1.0, 1.0))

    def _beside_fold(self, i: int, zeta: float, low: float, high: float) -> tuple[bool, float]:
        """Tell whether the needed damping passes a given one between two amplitudes, and how near it comes."""

        def excess(A: float) -> float:
            return float(self._needed(np.array([i]), np.array([A]))[0, 0]) - zeta

        sign = 1.0 if excess(low) > 0 else -1.0
        _, beyond = closest(excess, low, high, sign, _FOLD)
        return sign * beyond < 0, abs(beyond)

    def _follow(self, cells: Cells, i: int, j: int) -> None:
        """Decide one cell by following motions."""
        osc = replace(self.oscillators[i], c=float(self.line.c[i, j]))
        rtol = self.rtol * _FINER
        reason, motion, found, why = Reason.SIMULATED, Motion.UNDECIDED, None, ""
        try:
            check_time()
            found = regime(self.law, osc, rtol=rtol)
            check_time()  # what is named undecided for want of time is no boundary
            motion, why = classify(self.law, osc, rtol=rtol), "; ".join(found.undecided)
            if motion is Motion.UNDECIDED and not why:
                why = "the initial condition is within tolerance of a separatrix"
        except StickSlipError as error:
            reason, why = reason_of(error), str(error)
        cells.motion[i, j], cells.reason[i, j] = Motion.UNDECIDED if why else motion, reason
        for kind in ATTRACTORS:
            cells.attractors[kind.name][i, j] = not why and bool(kind.of(found))
        if why:
            cells.notes[i, j] = why

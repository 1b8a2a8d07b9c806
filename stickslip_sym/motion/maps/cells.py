"""The motions at many dampings of many operating points of one law, decided by comparisons.

Damping rotates the field of directions in the plane of x and x' one way, and moves P, where every forward stick
phase ends, inwards. So the slip that leaves P returns, and there is stick-slip, exactly where c lies below the
exact threshold. The damping d(A) that a slip orbit of amplitude A V needs gives every slip cycle as a root of
d(A) = c, stable where d falls; d(0) is the equilibrium's threshold, below which rest is unstable. So where many
dampings share an operating point, d decides them all. Where each has its own, it is enough whether orbits grow in
one round.

A law with mu(0+) = 0 holds no mass. Where the slip from P returns then, motions go out to one that overtakes the
belt each round, since damping and friction bring those far out back in.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NO_RESULT, OutOfTime, StickSlipError
from stickslip_sym.criteria.criterion import least_squares
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.compiled import compilable, compiled, is_compiling
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.orbits.needed import MOST_GAPS, begun, needed
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Signs
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.regimes.orbit_signs import orbit_signs
from stickslip_sym.motion.regimes.regime import Regime, friction_far_out, regime
from stickslip_sym.motion.slip import Dimensionless, End, Slips
from stickslip_sym.motion.thresholds.averages import slope_mean

__all__ = ["CURVES", "LATE", "REASONS", "Cells", "Column", "Reason", "decide"]

LATE = "not reached: time limit, or Ctrl-C"
CURVES = ("equilibrium", "least_squares", "exact")
"""The thresholds of an operating point."""
KNOWN = 1e-8
"""Of the largest threshold, to which all of them are known."""
_NEEDED = 1e-11  # tolerance of the steps with which needed dampings are found
_GROWTH = 1e-8  # tolerance of the steps by which the sign of a growth is found
_UNSURE = 1e-5  # growth in a round of which integrations do not tell the sign
_FOLD = 1e-7  # amplitude to which a fold is found; the damping there is known to its square
_FINER = 1e-2  # tolerance of the motions of single cells over that of thresholds
_TIGHTEST = 1e-13


class Reason(Enum):
    """How a cell was decided."""

    ABOVE = "above every threshold and fold"
    BELOW = "below every threshold and fold"
    BETWEEN = "between thresholds or folds: by the damping that slip orbits need"
    SIMULATED = "simulated"
    TOLERANCE = "within tolerance of a threshold or a fold"
    FAILED = "failed"
    TIME = LATE


REASONS = tuple(Reason)


@dataclass(frozen=True)
class Column:
    """Dampings at one operating point.

    Attributes
    ----------
    law : FrictionLaw
    parameters : dict of str to float
        Values of its parameters, in place of those it has.
    osc : Oscillator
        Its own c is not used.
    c : numpy.ndarray
    """

    law: FrictionLaw
    parameters: dict[str, float]
    osc: Oscillator
    c: FloatArray


@dataclass
class Cells:
    """What is known of the cells of a column, or of several one after the other.

    Attributes
    ----------
    motion, attractors, reason : numpy.ndarray of int
        Places in `MOTIONS`, a bit for each of `ATTRACTORS`, and places in `REASONS`.
    thresholds : dict of numpy.ndarray
        In kg/s, by the names in `CURVES`, an entry for each column; NaN where one was not found.
    notes : dict of int to str
        Why a cell failed or stayed undecided.
    """

    motion: IntArray
    attractors: IntArray
    reason: IntArray
    thresholds: dict[str, FloatArray]
    notes: dict[int, str]

    @classmethod
    def failed(cls, count: int, error: StickSlipError) -> "Cells":
        """Return cells of a column of which no more is known than why."""
        kind = Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED
        motion, reason = np.full(count, MOTIONS.index(Motion.UNDECIDED)), np.full(count, REASONS.index(kind))
        thresholds = {name: np.full(1, np.nan) for name in CURVES}
        return cls(motion, np.zeros(count, int), reason, thresholds, dict.fromkeys(range(count), str(error)))

    @classmethod
    def joined(cls, parts: Sequence["Cells"]) -> "Cells":
        """Return the cells of several columns as one."""
        begins = np.cumsum([0, *(part.motion.size for part in parts)]).tolist()
        return cls(
            np.concatenate([part.motion for part in parts]),
            np.concatenate([part.attractors for part in parts]),
            np.concatenate([part.reason for part in parts]),
            {name: np.concatenate([part.thresholds[name] for part in parts]) for name in CURVES},
            {
                begin + i: text
                for begin, part in zip(begins, parts, strict=False)
                for i, text in part.notes.items()
            },
        )


def decide(columns: Sequence[Column], rtol: float) -> list[Cells]:
    """Return the motion from x = 0, x' = V, and every attractor, for each cell of some columns.

    - `columns`: of one law, with all parameters bound.
    - `rtol`: a damping that is closer to a threshold or a fold, relative to the largest of them, is not decided.

    What fails is in the cells.
    """
    # Columns that share the law and the belt's speed share its table.
    groups: dict[tuple[tuple[tuple[str, float], ...], float], list[int]] = {}
    for i, column in enumerate(columns):
        groups.setdefault((tuple(column.parameters.items()), column.osc.V), []).append(i)
    found: dict[int, Cells] = {}
    bound = cache(lambda parameters: columns[0].law.bind(**dict(parameters)) if parameters else columns[0].law)
    for (parameters, _), places in groups.items():
        some = [columns[i] for i in places]
        try:
            check_time()
            cells = _Speed(bound(parameters), some, rtol).cells()
        except StickSlipError as error:
            cells = [Cells.failed(column.c.size, error) for column in some]
        found |= zip(places, cells, strict=True)
    return [found[i] for i in range(len(columns))]


@compilable
def _needed_all(rise: Any, eta: Any, push: Any, A: Any, rtol: float, by_zeta: Any, found: Any) -> None:
    """Find needed damping ratios and their errors, a row for each entry of the arrays; NaN where there is none."""
    for i in range(len(A)):
        state = begun(rise, eta[i], push[i], A[i])
        end, zeta, error = needed(rise, eta[i], push[i], A[i], rtol, by_zeta, state, MOST_GAPS)[:3]
        found[i, 0], found[i, 1] = (zeta, error) if end == 0 else (math.nan, math.nan)


class _Speed:
    """Columns of one law and one belt speed; dampings are damping ratios from here on."""

    def __init__(self, law: FrictionLaw, columns: Sequence[Column], rtol: float) -> None:
        self.law, self.columns, self.rtol = law, columns, rtol
        osc = columns[0].osc
        self.system = Dimensionless.of(self.law, osc)
        self.static, self.onset = self.system.table.static, self.system.table.onset
        self.eta = np.array([column.osc.eta for column in columns])
        self.ratio = np.array([2 * column.osc.impedance for column in columns])  # damping over damping ratio
        # A row for each column and an entry for each damping, as many as the longest column has.
        longest = max(column.c.size for column in columns)
        self.c = np.array([np.resize(column.c, longest) for column in columns])
        self.zeta = self.c / self.ratio[:, None]
        kinks = self.system.table.kinks
        self.N = np.array([column.osc.N for column in columns])
        at_kink = any(abs(kink / osc.V - 1) <= KNOWN for kink in kinks)
        slope = np.nan if at_kink else float(self.law.slope(osc.V))
        self.smooth = self.static == self.onset and all(kink >= 2 * osc.V for kink in kinks)
        self.equilibrium = -self.N * slope / self.ratio
        self.least_squares = self.N * self._mean_slope(osc.V) / self.ratio
        self.exact, self.error = self._needed(np.arange(len(columns)), np.ones(len(columns)))

    def _mean_slope(self, V: float) -> float:
        try:
            return float(slope_mean(self.law, least_squares, np.array([V]))[0])
        except NO_RESULT:
            return np.nan

    def _needed(self, row: IntArray, A: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the damping ratios that orbits need, and their errors; NaN where one is not found."""
        found = np.empty((row.size, 2))
        eta = self.eta[row]
        push = eta * (self.static - self.onset)
        rise = self.system.table.at(self.system.V, arrays=is_compiling())
        by_zeta = (0.0, -2.0, 0.0, rise.pieces, np.zeros(len(rise.jumps)))
        compiled(_needed_all)(rise, eta, push, A, _NEEDED, by_zeta, found)
        return found[:, 0], found[:, 1]

    # -- signs -------------------------------------------------------------------------------------

    def cells(self) -> list[Cells]:
        """Decide the cells of every column."""
        zeta, equilibrium = self.zeta, self.equilibrium[:, None]
        exact = np.where(self._without_threshold()[:, None], -np.inf, self.exact[:, None])
        edges = np.abs(np.hstack([np.where(np.isinf(exact), 0.0, exact), equilibrium]))
        margin = max(self.rtol, KNOWN) * np.nanmax(edges, axis=1, initial=0.0, keepdims=True)
        margin += np.nan_to_num(self.error)[:, None]
        near = (np.abs(zeta - exact) <= margin) | (np.abs(zeta - equilibrium) <= margin)
        returns, rest = zeta < exact, zeta > equilibrium
        held, comparable = self._held(returns)
        comparable &= ~(np.isnan(exact) | np.isnan(equilibrium))
        cycle, stable, folded, sure = self._slip_cycles(near, margin)
        near |= folded
        signs = Signs(rest=rest, falls=stable, returns=returns, held=held)
        motion = np.select(
            [near, returns & held, returns | cycle],
            [MOTIONS.index(one) for one in (Motion.UNDECIDED, Motion.STICK_SLIP, Motion.PURE_SLIP)],
            MOTIONS.index(Motion.REST),
        )
        bits = [kind.exists(signs).astype(np.intp) << place for place, kind in enumerate(ATTRACTORS)]
        attractors = np.where(near, 0, np.bitwise_or.reduce(bits))
        reason = np.select(
            [near, ~returns & rest & ~cycle, returns & ~rest & ~cycle],
            [REASONS.index(one) for one in (Reason.TOLERANCE, Reason.ABOVE, Reason.BELOW)],
            REASONS.index(Reason.BETWEEN),
        )
        decided = near | (comparable & sure)
        parts = zip(motion, attractors, reason, decided, margin.ravel(), strict=True)
        return [self._column(i, *part) for i, part in enumerate(parts)]

    def _without_threshold(self) -> BoolArray:
        """Tell where no threshold was found, and the slip from P does not return even without damping."""
        rows = np.flatnonzero(np.isnan(self.exact))
        without = np.zeros(self.exact.size, bool)
        if rows.size:
            nothing = np.zeros(rows.size)
            found = self._slips(rows, nothing, nothing)
            without[rows] = np.isin(found.end, (End.MINIMUM, End.REST, End.HORIZON)) & (found.w > _UNSURE)
        return without

    def _slips(self, row: IntArray, q: FloatArray, zeta: FloatArray, side: int = 1) -> Slips:
        """Follow slips from the belt's speed to their first minimum, or back."""
        nothing = np.zeros(row.size)
        until = End.MINIMUM if side > 0 else End.RETURN
        return self.system.slips(
            q, nothing, nothing + side, eta=self.eta[row], zeta=zeta, until=until, rtol=_GROWTH
        )

    def _held(self, returns: BoolArray) -> tuple[BoolArray, BoolArray]:
        """Tell where the motion from x = 0, x' = V sticks for good, and where comparisons decide at all.

        Where the slip from P returns beyond what static friction holds the mass overtakes the belt. It may stick
        after that; else it never sticks again.
        """
        zeta, static = self.zeta, self.eta[:, None] * self.static
        begin = 2 * zeta - static  # q of the initial condition
        sticks = (begin <= 0) & (begin >= -2 * static)
        held, comparable = np.zeros(zeta.shape, bool), ~returns & (zeta >= 0)
        row, entry = np.nonzero(returns & (sticks | (static == 0)))
        slow = self._slips(row, np.zeros(row.size), zeta[row, entry])
        back = slow.end == End.RETURN
        stuck = back & (slow.q <= 0) & (slow.q >= -2 * static[row, 0])
        over = np.flatnonzero(back & ~stuck)
        fast = self._slips(row[over], slow.q[over], zeta[row[over], entry[over]], -1)
        stuck[over] = (fast.end == End.RETURN) & (fast.q <= 0) & (fast.q >= -2 * static[row[over], 0])
        held[row, entry] = stuck
        comes_in = self.c.min(axis=1) + self.N * friction_far_out(self.law, self.system.V) >= 0
        comparable[row, entry] = stuck | (back & comes_in[row])
        if self.static == 0:
            # The initial condition is outside the orbit from P: it may be held back by one that overtakes.
            row, entry = np.nonzero(~returns & (zeta >= 0))
            found = self._slips(row, begin[row, entry], zeta[row, entry])
            comparable[row, entry] = np.isin(found.end, (End.MINIMUM, End.REST, End.HORIZON))
        return held, comparable

    # -- slip cycles -------------------------------------------------------------------------------

    def _slip_cycles(self, near: BoolArray, margin: FloatArray) -> tuple[BoolArray, ...]:
        """Tell where there is a cycle in pure slip, a stable one, where a fold is near, and where this is known.

        Cells of a column share the needed damping; a lone cell, or a jump of mu, asks for growth in one round.
        """
        shape, jumps = self.zeta.shape, any(self.system.rise.jumps)
        if shape[1] > 1 and not jumps:
            found = orbit_signs(
                lambda row, A: self._needed(row, A)[0], self.zeta, self.zeta < self.equilibrium[:, None]
            )
        else:
            row, zeta = np.repeat(np.arange(shape[0]), shape[1]), self.zeta.ravel()
            found = orbit_signs(
                lambda cell, A: self._growth(row[cell], zeta[cell], A),
                np.zeros((zeta.size, 1)),
                (zeta < self.equilibrium[row])[:, None],
            )
        cycle, stable, grows = (part.reshape(shape) for part in (found.cycle, found.stable, found.grows))
        if self.static == self.onset:  # a cycle may touch the belt's speed but for less than what is looked at
            last = grows != (self.zeta < self.exact[:, None])
            cycle, stable = cycle | last, stable | last & grows
        folded, known = np.zeros(shape, bool), np.ones(shape, bool)
        for entry, level, low, high in found.open:
            i, j = divmod(entry * found.cycle.shape[1] + level, shape[1])
            if jumps:
                known[i, j] = False
            elif not near[i, j]:
                crosses, touches = self._beside_fold(i, self.zeta[i, j], low, high, margin[i, 0])
                cycle[i, j] |= crosses
                stable[i, j] |= crosses
                folded[i, j] |= touches
        return cycle, stable, folded, known

    def _growth(self, row: IntArray, zeta: FloatArray, A: FloatArray) -> FloatArray:
        """Return a measure of the growth of slip orbits in one round, -1 to 1, with its sign."""
        w = 1 - A
        speeds, places = np.unique(w, return_inverse=True)
        lifted = np.array([self.system.lifted(one) for one in speeds.tolist()])[places]
        eta = self.eta[row]
        q = 2 * zeta * w - eta * (self.static - self.onset - lifted)
        found = self.system.slips(q, w, np.ones(w.size), eta=eta, zeta=zeta, until=End.MINIMUM, rtol=_GROWTH)
        # Where the mass meets the belt before, with an acceleration a, the next peak is 1 + a^2/2: that to which
        # the spring alone would pull it.
        ends = [found.end == end for end in (End.MINIMUM, End.RETURN, End.REST, End.HORIZON, End.OUTSIDE)]
        beyond = np.inf if math.isinf(self.system.w_max) else np.nan  # nothing is known beyond what was measured
        after = np.select(ends, [1 - found.w, 1 + found.rate**2 / 2, 0.0, 0.0, beyond], np.nan)
        with np.errstate(invalid="ignore"):
            change = np.where(np.isinf(after), 1.0, (after - A) / (after + A))
        return np.where(np.abs(change) < _UNSURE, np.nan, change)

    def _beside_fold(self, i: int, zeta: float, low: float, high: float, margin: float) -> tuple[bool, bool]:
        """Tell whether the needed damping passes one that there is between two amplitudes, and if it touches it.

        Where it passes twice, one of the two cycles is stable; where once, the neighbouring range has the other.
        """

        def excess(A: float) -> float:
            return float(self._needed(np.array([i]), np.array([A]))[0][0]) - zeta

        sign = 1.0 if excess(low) > 0 else -1.0
        options = {"xatol": _FOLD}
        fold = minimize_scalar(lambda A: sign * excess(A), bounds=(low, high), method="bounded", options=options)
        return bool(fold.fun < 0), not abs(fold.fun) > margin

    # -- columns -----------------------------------------------------------------------------------

    def _column(
        self, i: int, motion: IntArray, attractors: IntArray, reason: IntArray, decided: BoolArray, margin: float
    ) -> Cells:
        column, ratio = self.columns[i], self.ratio[i]
        some = slice(column.c.size)
        exact = self.exact[i] if self.smooth or self.exact[i] >= 0 else np.nan
        thresholds = {
            name: np.array([value * ratio])
            for name, value in zip(CURVES, (self.equilibrium[i], self.least_squares[i], exact), strict=True)
        }
        cells = Cells(motion[some], attractors[some], reason[some], thresholds, {})
        for j in np.flatnonzero(cells.reason == REASONS.index(Reason.TOLERANCE)).tolist():
            cells.notes[j] = f"c = {column.c[j]:.12g} is within {margin * ratio:.1e} kg/s of a threshold or a fold"
        for j in np.flatnonzero(~decided[some]).tolist():
            self._simulate(cells, j, replace(column.osc, c=float(column.c[j])))
        return cells

    def _simulate(self, cells: Cells, j: int, osc: Oscillator) -> None:
        """Decide one cell by following motions."""
        fine = max(self.rtol * _FINER, _TIGHTEST)
        cells.reason[j] = REASONS.index(Reason.SIMULATED)
        try:
            check_time()
            found = regime(self.law, osc, rtol=fine)
            check_time()  # what is named undecided for want of time is no boundary
            motion = _only(found) or classify(self.law, osc, rtol=fine)
        except StickSlipError as error:
            cells.motion[j], cells.attractors[j] = MOTIONS.index(Motion.UNDECIDED), 0
            kind = Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED
            cells.reason[j], cells.notes[j] = REASONS.index(kind), str(error)
            return
        cells.motion[j] = MOTIONS.index(motion)
        cells.attractors[j] = sum(bool(kind.of(found)) << place for place, kind in enumerate(ATTRACTORS))
        if found.undecided or motion is Motion.UNDECIDED:
            cells.motion[j], cells.attractors[j] = MOTIONS.index(Motion.UNDECIDED), 0
            cells.notes[j] = "; ".join(
                found.undecided or ["the initial condition is within tolerance of a separatrix"]
            )


def _only(found: Regime) -> Motion | None:
    """Return the one motion that all others come to, or None if the initial condition may decide."""
    if len(found.attractors) != 1 or found.unbounded or found.undecided:
        return None
    (motion,) = (kind.motion for kind in ATTRACTORS if kind.of(found))
    return motion

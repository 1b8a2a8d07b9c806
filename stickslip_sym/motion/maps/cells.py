"""The motions at many dampings of many operating points of one law, decided by comparisons.

As in `regime`, the slip from P returns exactly where c lies below the exact threshold. The damping d(A) that a
slip orbit of amplitude A V needs gives every slip cycle as a root of d(A) = c, stable where d falls; d(0) is the
equilibrium's threshold. It is resolved by polynomials, so no cycle is missed; where that fails, or takes longer
than its share of the time, the cells are followed one by one.

A law with mu(0+) = 0 holds no mass. Where the slip from P returns then, motions go out to one that overtakes the
belt each round, since damping and friction bring those far out back in.
"""

import math
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from enum import Enum
from functools import cache
from typing import NamedTuple

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.deadline import check_time, time_left, time_limit
from stickslip_sym.core.errors import NO_RESULT, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import SAME
from stickslip_sym.criteria.criterion import least_squares
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED, SlipEnd
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.damping import DAMPING_RTOL, NEAREST, needed_damping_at, resolve_together
from stickslip_sym.motion.orbits.needed import SIGNS, SearchEnd, search_damping_ratios
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Signs
from stickslip_sym.motion.regimes.classification import classify
from stickslip_sym.motion.regimes.overtaking import reaches, rounds_outside
from stickslip_sym.motion.regimes.regime import kept_regime
from stickslip_sym.motion.slip import NondimensionalOscillator, RoundEnds
from stickslip_sym.motion.thresholds.averages import resolved_gauss_average

LATE = "not reached: time limit, or Ctrl-C"
CURVES = ("equilibrium", "least_squares", "exact")
"""The thresholds of an operating point."""


_ROUNDS_RTOL = 1e-7  # tolerance of the steps along which rounds are resolved; what they leave open is followed
_INWARD = 3  # rounds that many cells are followed for, from where cycles that overtake may be, on the way in


class Reason(Enum):
    """How a cell was decided."""

    ABOVE = "above every threshold and fold"
    BELOW = "below every threshold and fold"
    BETWEEN = "between thresholds or folds: by the damping that slip orbits need"
    SIMULATED = "simulated"
    TOLERANCE = "within tolerance of a threshold"
    FAILED = "failed"
    TIME = LATE


class Cells(NamedTuple):
    """What is known of some cells; the last axis of arrays goes over them.

    - `motion`, `reason`: arrays of `Motion` and of `Reason`.
    - `attractors`: whether there are those of each kind, a row for each in `ATTRACTORS`.
    - `thresholds`: in kg/s, a row for each in `CURVES`; NaN where one was not found.
    - `notes`: why a cell failed or stayed undecided, by its number.
    """

    motion: ObjectArray
    reason: ObjectArray
    attractors: BoolArray
    thresholds: FloatArray
    notes: dict[int, str]

    @classmethod
    def unknown(cls, count: int) -> "Cells":
        """Return cells of which nothing is known."""
        return cls(
            np.full(count, Motion.UNDECIDED), np.full(count, Reason.TIME),
            np.zeros((len(ATTRACTORS), count), dtype=bool), np.full((len(CURVES), count), np.nan), {},
        )  # fmt: skip

    def put(self, rows: IntArray, part: "Cells | StickSlipError") -> None:
        """Write what is known of the cells of some numbers, or the error that stands for it."""
        if isinstance(part, StickSlipError):
            self.reason[rows] = _reason_of(part)
            self.notes.update(dict.fromkeys(rows.tolist(), str(part)))
            return
        for whole, some in zip(self[:4], part[:4], strict=True):
            whole[..., rows] = some
        self.notes.update({int(rows[i]): text for i, text in part.notes.items()})


def _reason_of(error: StickSlipError) -> Reason:
    return Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED


def decide(law: FrictionLaw, rtol: float, points: Mapping[str, FloatArray]) -> Cells:
    """Return the motion from x = 0, x' = V, and every attractor, for each of some cells; the last is confirmed.

    - `rtol`: a damping that is closer to a threshold, relative to the largest of them, is not decided.
    - `points`: V, N, m, k, c and parameters of the law in place of those it has, an entry for each cell.
    """
    cells = Cells.unknown(len(points["c"]))
    names = [name for name in points if name in law.parameters]
    bound = cache(lambda *values: law.bind(**dict(zip(names, values, strict=True))))
    kinds, kind = np.unique([points[name] for name in ("V", *names)], axis=1, return_inverse=True)
    for i, (V, *values) in enumerate(kinds.T.tolist()):
        rows = np.flatnonzero(kind.ravel() == i)
        try:
            check_time()
            seconds = time_left() / (len(kinds.T) - i)
            some = {name: points[name][rows] for name in "Nmkc"}
            decider = _Decider(bound(*values), V, some, rtol, seconds if seconds < math.inf else None)
            cells.put(rows, decider.cells(np.flatnonzero(rows == len(points["c"]) - 1)))
        except StickSlipError as error:
            cells.put(rows, error)
    return cells


class _Decider:
    """Decides cells of one law and belt speed; dampings are damping ratios here.

    - `seconds`: the share of the time of these cells.
    """

    def __init__(
        self, law: FrictionLaw, V: float, points: Mapping[str, FloatArray], rtol: float, seconds: float | None
    ) -> None:
        self.law = law
        self.points = points
        self.rtol = rtol
        self.seconds = seconds
        self.system = NondimensionalOscillator.of(law.bound, self._oscillator(V, 0))
        self.table = self.system.table
        self.N = points["N"]
        impedance = np.sqrt(points["k"]) * np.sqrt(points["m"])
        self.eta = self.N / (V * impedance)
        self.ratio = 2 * impedance  # damping over damping ratio
        self.zeta = points["c"] / self.ratio
        at_kink = any(abs(kink / V - 1) <= SAME for kink in self.table.kinks)
        self.equilibrium = -self.N * (math.nan if at_kink else float(law.bound.slope(V))) / self.ratio
        eta, oscillator = np.unique(self.eta, return_inverse=True)
        orbits = eta, eta * (self.table.static - self.table.onset), np.ones(eta.size)
        rows = np.empty((eta.size, 5))
        self.system.spread(search_damping_ratios, orbits, (DAMPING_RTOL,), rows, few=0)
        check_time()
        end, *ratios = rows[oscillator, :3].T
        self.exact, self.error = np.where(end == SearchEnd.CLOSED, ratios, math.nan)

    def _oscillator(self, V: float, i: int) -> Oscillator:
        return Oscillator(V=V, **{name: float(column[i]) for name, column in self.points.items()})

    def cells(self, confirmed: IntArray) -> Cells:
        """Decide the cells; where one of those that are confirmed is found to be wrong, follow them all."""
        cells, known = self._compared()
        left = ~known
        for i in confirmed[known[confirmed]].tolist():
            followed = Cells.unknown(known.size)
            self._follow(followed, i)
            if followed.motion[i] is Motion.UNDECIDED:
                continue
            agrees = followed.motion[i] is cells.motion[i] or cells.motion[i] is Motion.UNDECIDED
            if not agrees or (followed.attractors[:, i] != cells.attractors[:, i]).any():
                left |= cells.reason != Reason.TOLERANCE
        for i in np.flatnonzero(left).tolist():
            self._follow(cells, i)
        return cells

    def _compared(self) -> tuple[Cells, BoolArray]:
        """Decide the cells by comparisons, and return which of them are known."""
        zeta = self.zeta
        exact = self.exact
        equilibrium = self.equilibrium
        largest = np.nan_to_num(np.fmax(np.abs(exact), np.abs(equilibrium)))
        margin = self.rtol * largest + np.nan_to_num(self.error)
        near = (np.abs(zeta - exact) <= margin) | (np.abs(zeta - equilibrium) <= margin)
        returns = zeta < exact
        rest = zeta > equilibrium
        held, escapes, known = self._after_return(returns)
        known &= np.isfinite(exact + equilibrium)
        cycle, stable, unsure = self._cycles(zeta < equilibrium)
        known &= ~unsure
        self._overtaking(known & ~near & (held | ~returns), stable, known)
        signs = Signs(rest=rest, falls=stable, returns=returns & ~escapes, held=held)
        cells = Cells.unknown(zeta.size)
        motion = cells.motion
        reason = cells.reason
        motion[:], reason[:] = Motion.REST, Reason.BETWEEN
        motion[returns | cycle] = Motion.PURE_SLIP
        motion[returns & held] = Motion.STICK_SLIP
        motion[escapes] = Motion.UNBOUNDED
        reason[~returns & rest & ~cycle] = Reason.ABOVE
        reason[returns & ~rest & ~cycle] = Reason.BELOW
        motion[near], reason[near] = Motion.UNDECIDED, Reason.TOLERANCE
        cells.attractors[:] = [kind.exists(signs) & ~near for kind in ATTRACTORS]
        curves = dict.fromkeys(CURVES, np.full(zeta.size, math.nan))
        curves |= {"equilibrium": equilibrium * self.ratio, "exact": exact * self.ratio}
        with suppress(*NO_RESULT):
            curves["least_squares"] = self.N * resolved_gauss_average(
                self.law.kinetic, least_squares, np.array([self.system.V])
            )
        cells.thresholds[:] = list(curves.values())
        for i in np.flatnonzero(near).tolist():
            off = f"within {margin[i] * self.ratio[i]:.1e} kg/s of a threshold"
            cells.notes[i] = f"c = {self.points['c'][i]:.12g} is {off}"
        return cells, near | known

    def _after_return(self, returns: BoolArray) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Tell where the motion from x = 0, x' = V sticks for good, where it grows without bound, and where known.

        Where the slip from P returns beyond what static friction holds the mass overtakes the belt. It may stick
        after that; else it never sticks again. A motion that sticks at first leaves at P; any other is outside.
        """
        zeta = self.zeta
        static = self.eta * self.table.static
        begin = 2 * zeta - static  # q of the initial condition
        sticks = (begin <= 0) & (begin >= -2 * static)

        held, escapes, overtakes = np.zeros((3, zeta.size), dtype=bool)
        comes_in = 2 * zeta + self.eta * self.system.friction_far_out >= 0
        rounds = self._rounds(np.zeros(zeta.size), returns)
        held[returns], escapes[returns] = rounds.sticks, rounds.leaves
        # A law with mu(0) = 0 holds nothing: where the slip from P returns, the mass overtakes.
        is_clear = rounds.ends.surely(above=0) | (static[returns] == 0)
        overtakes[returns] = rounds.ends.known & is_clear & ~rounds.leaves & ~rounds.slower
        escapes &= ~comes_in & math.isinf(self.table.reach)
        on_it = sticks | (static == 0)
        known = (held | (overtakes & comes_in)) & on_it | escapes
        known |= ~returns & ((zeta >= 0) | sticks)
        if self.table.static == 0:
            # The initial condition is outside the orbit from P: it may be held back by one that overtakes.
            outside = ~returns & (zeta >= 0)
            known[outside] = self._rounds(begin, outside).slower
        return held, escapes, known

    def _rounds(self, q: FloatArray, cells: BoolArray | IntArray) -> RoundEnds:
        """Return what rounds come to that begin at displacements, an entry for each cell, in some of the cells."""
        rounds = self.system.rounds(q[cells], SIGNS, ratios=(self.eta[cells], self.zeta[cells]), few=0)
        check_time()
        return rounds

    def _overtaking(self, sought: BoolArray, stable: BoolArray, known: BoolArray) -> None:
        """Mark which cells have a stable cycle that overtakes the belt, and which are not known, of those sought.

        Where a motion overtakes and is not held, there is one, or motions grow without bound.
        """
        q = reaches(self.system, self.eta, self.zeta)
        for _ in range(_INWARD):
            inward = np.flatnonzero(sought & (q > 0) & np.isfinite(q))
            ends = self._rounds(q, inward).ends
            q[inward] = np.where(ends.high < q[inward], ends.high, math.inf)
        for i in np.flatnonzero(sought & (q > 0)).tolist():
            check_time()
            outer = rounds_outside(replace(self.system, eta=self.eta[i], zeta=self.zeta[i]), _ROUNDS_RTOL)
            stable[i] |= -2 in np.diff(outer.growth)
            known[i] = "open" not in [mark.kind for mark in outer.marks]

    def _cycles(self, grows_at_rest: BoolArray) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Return which cells have limit cycles in pure slip, which a stable one, and of which it is not known."""
        growth = self._growth_of_all()
        cycle, stable, unsure = np.zeros((3, self.zeta.size), dtype=bool)
        # Where all orbits grow, or shrink, while those about rest do not, there is a cycle that is smaller.
        cycle[:] = (growth != 0) & ((growth > 0) != grows_at_rest)
        stable[:] = cycle & grows_at_rest
        groups = self._alike(np.flatnonzero(growth == 0))
        needs = [needed_damping_at(self.table, float(self.eta[rows[0]]), self.system.V) for rows in groups]
        try:
            with time_limit(self.seconds):
                resolve_together(needs)
        except OutOfTime:
            check_time()  # raises if it was the limit on all
            unsure[growth == 0] = True
            return cycle, stable, unsure
        for rows, need in zip(groups, needs, strict=True):
            cycle[rows], stable[rows], unsure[rows] = need.signs(2 * self.zeta[rows], grows_at_rest[rows])
        return cycle, stable, unsure

    def _alike(self, rows: IntArray) -> list[IntArray]:
        """Return some cells, those that differ in c alone together."""
        _, oscillator = np.unique(self.eta[rows], return_inverse=True)
        return [rows[oscillator == i] for i in range(oscillator.max(initial=-1) + 1)]

    def _growth_of_all(self) -> IntArray:
        """Return 1 where one swing shows that all slip orbits grow, -1 where they shrink, and 0 elsewhere."""
        w = np.array([0.0, 1 - NEAREST])
        zeta = self.zeta[:, None]
        eta = self.eta[:, None]
        rise = np.array([self.table.rise(self.system.V * speed) for speed in w.tolist()])
        begin = 2 * zeta * w + eta * (self.table.onset + rise - self.table.static)
        slips = self.system.slips(
            begin.ravel(), np.tile(w, self.zeta.size), ratios=(np.repeat(self.eta, 2), np.repeat(self.zeta, 2)),
            until=SlipEnd.MINIMUM, rtol=SIGNS, few=0,
        )  # fmt: skip
        check_time()
        end = slips.end.reshape(-1, 2)
        least = slips.w.reshape(-1, 2)
        growth = np.zeros(self.zeta.size, dtype=np.intp)
        growth[(end[:, 0] == SlipEnd.MINIMUM) & (1 - least[:, 0] <= NEAREST)] = -1
        growth[np.isin(end[:, 1], (SlipEnd.RETURN, SlipEnd.OUTSIDE)) & (self.zeta < self.equilibrium)] = 1
        return growth

    def _follow(self, cells: Cells, i: int) -> None:
        """Decide one cell by following motions."""
        osc, rtol = self._oscillator(self.system.V, i), self.rtol / ADDED  # so near a separatrix it is not decided
        outcome = None
        why = ""
        try:
            check_time()
            outcome = kept_regime(self.law, osc, rtol)
            cells.motion[i], cells.reason[i] = classify(self.law, osc, rtol=rtol), Reason.SIMULATED
            why = "; ".join(outcome.undecided)
            if cells.motion[i] is Motion.UNDECIDED and not why:
                why = "the initial condition is within tolerance of a separatrix"
        except StickSlipError as error:
            cells.reason[i], why = _reason_of(error), str(error)
        cells.attractors[:, i] = [not why and bool(kind.of(outcome)) for kind in ATTRACTORS]
        if why:
            cells.motion[i], cells.notes[i] = Motion.UNDECIDED, why

"""Motions for many dampings in one scene, decided by comparisons where that is possible.

Damping rotates the field of directions in the plane of x and x' one way, and moves P, where every forward stick
phase ends, inwards. So the slip that leaves P returns, and there is stick-slip, exactly where c lies below the
exact threshold. The damping d(A) that a slip orbit of amplitude A V needs (`cycles`) gives every slip cycle as a
root of d(A) = c, stable where d falls; d(0) is the equilibrium's threshold, below which rest is unstable. Which of
these c lies above and which below tells all attractors, for all c at once.

Where d is not found, it still has one value for each A. So where the motion from P comes to rest there is no slip
cycle, nor is there with more damping; and where the motion from beside rest comes to stick-slip, there is none
with less. That leaves few cells, and these are simulated one by one.
"""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NO_RESULT, InputError, NotConverged, NoThreshold, OutOfTime, StickSlipError
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import least_squares
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.maps.cells import MOTIONS, REASONS, Attractor, Cells, Reason
from stickslip_sym.motion.orbits.cycles import needed_damping
from stickslip_sym.motion.orbits.orbit import obstacle, orbits
from stickslip_sym.motion.regimes.attractors import Regime, regime
from stickslip_sym.motion.regimes.classification import Motion, classify
from stickslip_sym.motion.simulation.transit import stick_slip_cycle
from stickslip_sym.motion.thresholds.grazing import grazing_damping
from stickslip_sym.motion.thresholds.rungs import average, numerical_averages
from stickslip_sym.motion.thresholds.scenes import Scenes

__all__ = ["KNOWN", "by_collocation", "decide", "least_squares_dampings"]

_MOST_WORK = 5e7  # cubes of grids; beyond, following the motions of a cell costs less
KNOWN = 1e-8  # of the largest threshold, to which all of them are known
_FIRST, _BESIDE = 1e-6, 100  # tolerance of a simulated threshold, and how many errors away no finer one is needed
_FINER = 1e-2  # tolerance of simulations over that of thresholds
_TIGHTEST = 1e-13
_GAUSS = np.polynomial.legendre.leggauss(4)  # exact to degree 7; a slope times the weight has degree 6
_BESIDE_REST = 1e-3  # velocity over the belt's of a motion that begins beside rest


def decide(law: FrictionLaw, osc: Oscillator, c: ArrayLike, *, rtol: float) -> Cells:
    """Return the motion from x = 0, x' = V, and every attractor, for each damping.

    - `law`: with all parameters bound.
    - `osc`: its own c is not used.
    - `c`: in kg/s.
    - `rtol`: a damping that is closer to a threshold or a fold, relative to the largest of them, is not decided.

    Raises `InputError` for a law that no oscillator can have.
    """
    return _Column(law, osc, np.asarray(c, dtype=np.float64), rtol).cells()


class _Column:
    """All dampings in one scene; `turns` is None where collocation does not tell of its slip cycles."""

    def __init__(self, law: FrictionLaw, osc: Oscillator, c: FloatArray, rtol: float) -> None:
        self.law, self.osc, self.c, self.rtol = law, osc, c, rtol
        self.fine = max(rtol * _FINER, _TIGHTEST)
        self.scene = Scene.of(law, osc)
        self.static = self.scene.static
        self.equilibrium = self._equilibrium()
        self.graze = _graze(law, osc)
        self.exact, self.doubt = self._exact()
        inner = None if self.graze is None else _folds(law, osc)
        self.turns = None if inner is None else np.array([self.equilibrium, *inner, self.graze])

    # -- thresholds --------------------------------------------------------------------------------

    def _equilibrium(self) -> float | None:
        if any(abs(float(place) / self.osc.V - 1) <= KNOWN for place in self.law.kinks()):
            return None
        return float(-self.osc.N * self.law.slope(self.osc.V))

    def _exact(self) -> tuple[float, float]:
        """Return the exact threshold and its error: -inf if no c >= 0 is one, NaN if it is not found."""
        if self.graze is not None and obstacle(self.law, self.osc.V) is None:
            return self.graze, 0.0
        try:
            value, error = grazing_damping(self.law, self.osc, rtol=_FIRST)
            if (np.abs(self.c - value) <= _BESIDE * error * value).any():
                value, error = grazing_damping(self.law, self.osc, rtol=max(self.fine, 1e-10))
        except NoThreshold:
            return -np.inf, 0.0
        except NotConverged:
            return np.nan, 0.0
        return value, value * error

    # -- cells -------------------------------------------------------------------------------------

    def cells(self) -> Cells:
        c = self.c
        folded = [] if self.turns is None else self.turns.tolist()
        edges = [self.exact, *folded, *([] if self.equilibrium is None else [self.equilibrium])]
        edges = [edge for edge in edges if np.isfinite(edge)]
        margin = max(self.rtol, KNOWN) * max(map(abs, edges), default=0.0) + self.doubt
        near = (np.abs(c[:, None] - np.array(edges)) <= margin).any(axis=1)
        sticks = c < self.exact
        reason = np.full(c.shape, REASONS.index(Reason.BETWEEN))
        if self.turns is None:
            reason[:] = REASONS.index(Reason.ALONG)
        else:
            reason[c > max(edges)] = REASONS.index(Reason.ABOVE)
            reason[c < min(edges)] = REASONS.index(Reason.BELOW)
        reason[near] = REASONS.index(Reason.TOLERANCE)
        slips, stable = self._cycles(folded)
        motion = np.select(
            [near, sticks, slips],
            [MOTIONS.index(one) for one in (Motion.UNDECIDED, Motion.STICK_SLIP, Motion.PURE_SLIP)],
            MOTIONS.index(Motion.DAMPED_SLIP),
        )
        rest = c > (np.nan if self.equilibrium is None else self.equilibrium)
        attractors = Attractor.STICK_SLIP * sticks + Attractor.REST * rest + Attractor.PURE_SLIP * stable
        attractors[near] = 0
        exact = self.exact if np.isfinite(self.exact) else None
        average = least_squares_dampings(self.law, np.array([self.osc.V]), np.array([self.osc.N])).item()
        cells = Cells(
            motion.tolist(), attractors.tolist(), reason.tolist(), self.equilibrium,
            None if np.isnan(average) else average, exact,
        )  # fmt: skip
        for i in np.flatnonzero(near):
            cells.notes[int(i)] = f"c = {c[i]:.12g} is within {margin:.1e} kg/s of a threshold or a fold"
        for i in np.flatnonzero(~near & ~self._comparable(~near)):
            self._simulate(cells, int(i))
        return cells

    def _cycles(self, folded: list[float]) -> tuple[BoolArray, BoolArray]:
        """Tell where there are slip cycles, and where stable ones."""
        c = self.c
        slips, stable = np.zeros(c.shape, dtype=bool), np.zeros(c.shape, dtype=bool)
        for before, after in pairwise(folded):
            falls = (after < c) & (c < before)
            slips |= falls | ((before < c) & (c < after))
            stable |= falls
        return slips, stable

    def _comparable(self, clear: BoolArray) -> BoolArray:
        """Tell which cells, of those clear of thresholds, comparisons decide."""
        c = self.c
        if self.static == 0 or self.equilibrium is None or np.isnan(self.exact):
            return np.zeros(c.shape, dtype=bool)
        held = np.abs(c) * self.osc.V <= self.static * self.osc.N
        below = np.unique(c[clear & held & (c < self.exact)])
        # With less damping the slip from P returns further back: it is one side of one place.
        below = below[_first(below, self._sticks_at_once) :]
        # With enough damping, a start beyond what static friction holds comes to where the slip from P comes.
        above = np.unique(c[clear & (c > self.exact) & (c >= 0)])
        if self.turns is None:
            below = below[below < self.equilibrium]
            below = below[: _first(below, lambda one: not self._leaves_rest(one))]
            above = above[above > self.equilibrium]
            above = above[_first(above, self._comes_to_rest) :]
        return clear & (np.isin(c, below) | np.isin(c, above))

    def _sticks_at_once(self, c: float) -> bool:
        """Tell whether the slip from P ends in stick, and not beyond what static friction holds."""
        try:
            cycle = stick_slip_cycle(self.law, replace(self.osc, c=c), rtol=self.fine)
        except NO_RESULT:
            return False
        return cycle is not None and cycle.v_max <= self.osc.V

    def _leaves_rest(self, c: float) -> bool:
        x0 = self.osc.N * float(self.law.mu(self.osc.V)) / self.osc.k
        return self._motion(c, x0, _BESIDE_REST * self.osc.V) is Motion.STICK_SLIP

    def _comes_to_rest(self, c: float) -> bool:
        return self._motion(c, replace(self.osc, c=c).onset(self.law), self.osc.V) is Motion.DAMPED_SLIP

    def _motion(self, c: float, x0: float, v0: float) -> Motion:
        try:
            found: Motion = classify(self.law, replace(self.osc, c=c), x0=x0, v0=v0, rtol=self.fine)
        except NO_RESULT:
            return Motion.UNDECIDED
        return found

    def _simulate(self, cells: Cells, i: int) -> None:
        """Decide one cell by following motions."""
        osc = replace(self.osc, c=float(self.c[i]))
        cells.reason[i] = REASONS.index(Reason.SIMULATED)
        try:
            check_time()
            found = regime(self.law, osc, rtol=self.fine)
            check_time()  # what is named undecided for want of time is no boundary
            motion = _only(found) or classify(self.law, osc, rtol=self.fine)
        except StickSlipError as error:
            cells.motion[i], cells.attractors[i] = MOTIONS.index(Motion.UNDECIDED), 0
            kind = Reason.TIME if isinstance(error, OutOfTime) else Reason.FAILED
            cells.reason[i], cells.notes[i] = REASONS.index(kind), str(error)
            return
        cells.motion[i] = MOTIONS.index(motion)
        cells.attractors[i] = int(
            Attractor.STICK_SLIP * (found.stick_slip is not None)
            + Attractor.REST * found.rest.stable
            + Attractor.PURE_SLIP * any(cycle.stable for cycle in found.cycles)
        )
        if found.undecided or motion is Motion.UNDECIDED:
            cells.motion[i], cells.attractors[i] = MOTIONS.index(Motion.UNDECIDED), 0
            cells.notes[i] = "; ".join(found.undecided or ["the start is within tolerance of a separatrix"])


def least_squares_dampings(law: FrictionLaw, V: FloatArray, N: FloatArray) -> FloatArray:
    """Return the damping of the criterion in kg/s, for belt speeds and normal forces; NaN where there is none."""
    try:
        return _together(law, V, N)
    except NO_RESULT:
        if len(V) == 1:
            return np.full(1, np.nan)
    return np.concatenate([least_squares_dampings(law, V[[i]], N[[i]]) for i in range(len(V))])


def _together(law: FrictionLaw, V: FloatArray, N: FloatArray) -> FloatArray:
    scenes = Scenes.of(law, V=V, N=N)
    if obstacle(law, V, jump=False) is None:
        return np.asarray(numerical_averages(scenes)[least_squares.name])
    if law.curve is None:
        return np.asarray(average(scenes, least_squares))
    kinks = [float(place) for place in law.kinks()]
    speeds, places = np.unique(V, return_inverse=True)
    return np.asarray(N * np.array([_through_points(law, kinks, speed) for speed in speeds.tolist()])[places])


@cache
def _weight() -> Callable[[FloatArray], FloatArray]:
    return function_of([symbols.s], least_squares.weight, "numpy")


def _through_points(law: FrictionLaw, kinks: list[float], V: float) -> float:
    """Return the damping over N of measured points: by Gauss, exact for the cubics between them."""
    end = 2 * V
    law.require_speed(end)
    edges = np.array([0.0, *(place for place in kinks if place < end), end])
    half = np.diff(edges)[:, None] / 2
    v = edges[:-1, None] + half * (1 + _GAUSS[0])
    weight = _weight()(v / V - 1)
    return float(-(half * _GAUSS[1] * weight * law.slope(v)).sum() / V)


@lru_cache(maxsize=64)
def _graze(law: FrictionLaw, osc: Oscillator) -> float | None:
    """Return the damping of the orbit that grazes the belt's speed; None if it is not known by collocation."""
    if obstacle(law, osc.V, jump=False) is not None:
        return None
    found = orbits(law, osc.V, osc.N / osc.impedance, most_work=_MOST_WORK / 5)
    if not found.relative_error[0] < KNOWN and not found.error[0] * found.scale[0] < KNOWN:
        return None
    return float(found.d[0] * osc.impedance)


def _folds(law: FrictionLaw, osc: Oscillator) -> FloatArray | None:
    """Return the damping that slip orbits need at each fold; None if it is not known by collocation."""
    try:
        need = needed_damping(law, osc, most_work=_MOST_WORK)
    except (InputError, NotConverged):
        return None
    return np.asarray(need.at(need.folds) * osc.impedance)


def by_collocation(law: FrictionLaw, osc: Oscillator) -> bool:
    """Tell whether collocation tells of all slip cycles in a scene."""
    try:
        return _graze(law, osc) is not None and _folds(law, osc) is not None
    except StickSlipError:
        return False


def _only(found: Regime) -> Motion | None:
    """Return the one motion that all others come to, or None if the start may decide."""
    if len(found.attractors) != 1 or found.unbounded or found.undecided:
        return None
    if found.stick_slip is not None:
        return Motion.STICK_SLIP
    return Motion.DAMPED_SLIP if found.rest.stable else Motion.PURE_SLIP


def _first(values: FloatArray, holds: Callable[[float], bool]) -> int:
    """Return the place of the first of ascending values for which something holds, as it does for all after it."""
    if values.size and holds(float(values[0])):
        return 0
    return bisect_left(range(values.size), True, lo=min(1, values.size), key=lambda i: holds(float(values[i])))

"""The damping d(A) that slip orbits need, as a function of their amplitude A V: polynomials between its breaks.

An orbit of amplitude A V meets the slip speeds from V (1 - A) to a highest one that grows with A, since orbits of
different amplitudes do not cross: damping rotates the field of directions one way. Where either end of that range
comes to a speed at which mu changes quickly, d may turn, jump, or begin anew as a power of the square root of the
amplitude beyond. The range of amplitudes is parted there, and d resolved between these amplitudes in the square
root of the distance: so every limit cycle at any damping, and every fold, is a root or an extremum of polynomials.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import LEAST_RTOL, ROUNDING
from stickslip_sym.core.remedies import Call
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.model.table import FrictionTable, Rise
from stickslip_sym.motion.kernel.slip_data import PRECISE, TIGHT
from stickslip_sym.motion.orbits.needed import (
    SearchEnd,
    damping_ratios,
    orbit_damping_ratio,
    search_damping_ratios,
    velocity_mismatch_at,
)
from stickslip_sym.motion.simulation.cycle import first_minimum
from stickslip_sym.motion.slip import SAME_AMPLITUDE, NondimensionalOscillator
from stickslip_sym.numerics.known import Column, Unknown, attempted
from stickslip_sym.numerics.resolved import ERRORS_OF_CLEAR_SIGN, Resolved, Turn, resolve

NEAREST = 1e-3
"""Lowest amplitude over the belt's speed that is looked at; a smaller cycle shows by the growth at rest."""
DAMPING_RTOL = 1e-9
"""Of d, that its polynomials may leave out, and of thresholds to which others are held."""
MOST_ORBITS = 2000
"""Orbits, to resolve it, and rounds that overtake the belt."""
OF_ORBITS = 1e-8
"""Relative error of the values through which they go, and what polynomials over another quantity leave out."""
STEP_ERRORS = 3.0
"""Errors of steps, within which an orbit is periodic, and beyond which the fate of a slip is certain."""
_WEAK_FRICTION = 1.0  # eta, below which mismatches are so small that their steps are to be precise
_RELATIVE_CYCLE_WIDTH = DAMPING_RTOL / NEAREST  # of the amplitude of a cycle by polynomials, within which it lies
_NARROW_RATIO = 64  # times narrower than V is a piece of the table in which mu changes quickly,
_NARROWER = 0.6  # and than the pieces beside it
_THIN = 1e-3  # over V, width of a layer at rest that polynomials might not see
_DAMPING_OF_JUMP = 0.5  # damping ratio that a jump of mu at V may ask for
_LARGEST_LEAST_AMPLITUDE = 0.9  # amplitude above all such
_ROUNDS_LOOKED_AT = 200  # of a motion, to see whether it goes through a range of amplitudes


@dataclass(frozen=True)
class NeededDamping:
    """The damping d(A) that a slip orbit needs, over sqrt(k m), as a function of its amplitude A V.

    - `system`: without damping and without a static excess, which no orbit in slip meets.
    """

    system: NondimensionalOscillator

    def at(self, amplitude: ArrayLike) -> FloatArray:
        """Return d at amplitudes over the belt speed; d(0) is the Hopf bifurcation, d(1) the graze."""
        A = np.asarray(amplitude, dtype=np.float64)
        hopf = -self.system.decay(1.0)
        d = [hopf if one < NEAREST else 2 * orbit_damping_ratio(self.system, one)[0] for one in A.ravel().tolist()]
        return np.array(d).reshape(A.shape)

    def mismatch(self, A: float, damping: float) -> float:
        """Return the mismatch of an orbit at a damping over sqrt(k m), of the sign of d(A) - damping."""
        system = self.system
        steps = TIGHT
        if abs(system.eta) < _WEAK_FRICTION:
            steps = PRECISE
        value = velocity_mismatch_at(replace(system, zeta=damping / 2), A, rtol=steps).value
        if math.isnan(value):
            raise NotConverged(
                f"the slip orbit of amplitude {A * system.V:g} m/s takes too many steps: friction is too strong; "
                "try ",
                Call("simulate()", "simulate LAW"),
            )
        return 0.0 if abs(value) <= STEP_ERRORS * steps else float(value)

    # -- d as polynomials --------------------------------------------------------------------------

    @property
    def least(self) -> float:
        """The least amplitude at which d is resolved: beside a jump of mu at V it grows without bound."""
        rise = _rise_at(self.system.table, self.system.V)
        levels = rise.levels
        jumps = rise.jumps
        jump = max(
            (abs(size) for w, size in zip(levels, jumps, strict=False) if abs(w - 1) <= NEAREST), default=0.0
        )
        return min(max(NEAREST, self.system.eta * jump / (math.pi * _DAMPING_OF_JUMP)), _LARGEST_LEAST_AMPLITUDE)

    @cached_property
    def edges(self) -> list[float]:
        """The amplitudes from the least that is looked at to 1, between which d is smooth."""
        levels = [v / self.system.V for v in quick_speeds(self.system.table, self.system.V)]
        met = [1 - w for w in levels if w < 1]
        above = [w for w in levels if w > 1]
        least, most = (self._highest(A) for A in (self.least, 1.0)) if above else (math.inf, math.inf)
        for w in above:
            if least < w < most:
                met.append(self._reaching(w * (1 - ROUNDING), self.least))
                if self._highest(beyond := met[-1] + SAME_AMPLITUDE) < w * (1 + ROUNDING) < self.system.w_max:
                    met.append(self._reaching(w * (1 + ROUNDING), beyond))  # orbits slide there for a while
        # Amplitudes within a layer at rest may be as good as one: d is not resolved there.
        last = min((A for A in met if 1 - SAME_AMPLITUDE <= A < 1), default=1.0)
        inside = sorted(A for A in met if self.least < A < last)
        edges = [self.least, *(A for A, after in pairwise([*inside, last]) if after - A > SAME_AMPLITUDE), last]
        # Both ends of the last range may be singular: the law at rest, too.
        return edges if len(edges) == 2 else [*edges[:-1], (edges[-2] + last) / 2, last]

    @cached_property
    def measured(self) -> float:
        """The amplitude up to which orbits stay at speeds at which the law is measured."""
        w_max = self.system.w_max
        return (
            next((A for A in self.edges if self._highest(A) >= w_max * (1 - SAME_AMPLITUDE)), 1.0)
            if math.isfinite(w_max)
            else 1.0
        )

    @cached_property
    def resolved(self) -> Resolved:
        """The polynomials, over a place that `amplitudes` takes: from one edge to the next it grows by 1."""
        return resolve(
            lambda places: self._values(self.amplitudes(places)),
            range(len(self.edges)),
            rtol=DAMPING_RTOL,
            most=MOST_ORBITS,
        )

    @property
    def covers_all_amplitudes(self) -> bool:
        """Whether the polynomials, and what is open between them, go from the nearest amplitude to 1."""
        return self.least <= NEAREST and self.measured >= 1 and bool(self.resolved.pieces)

    def amplitudes(self, places: ArrayLike) -> FloatArray:
        """Return amplitudes, over the belt's speed, from places among the edges.

        They go with the square of the distance from the lower edge, or from the upper one in the first and the
        last range.
        """
        places = np.asarray(places, dtype=np.float64)
        edges = np.array(self.edges)
        last = edges.size - 2
        row = np.clip(places.astype(np.intp), 0, last)
        low = edges[row]
        high = edges[row + 1]
        part = places - row
        below = (row == 0) | (row == last)
        found: FloatArray = np.where(below, high - (high - low) * (1 - part) ** 2, low + (high - low) * part**2)
        return found

    def _values(self, A: FloatArray) -> Column:
        """Return d."""
        return _orbit_dampings(self.system, np.full(A.size, self.system.eta), A)

    def _reaching(self, w: float, low: float) -> float:
        """Return the amplitude, above one, at which orbits come to a highest slip speed over V."""

        def off(A: float) -> float:
            return min(self._highest(A), 2 * w) - w

        return float(brentq(off, low, 1.0, xtol=LEAST_RTOL)) if off(low) < 0 < off(1.0) else low

    def _highest(self, A: float) -> float:
        """Return what the highest slip speed of an orbit is at most, over V: infinite where it is not known."""
        system = self.system
        damping = self._values(np.array([A])).at(0)
        if isinstance(damping, Unknown) or math.isinf(damping):
            return math.inf
        return velocity_mismatch_at(replace(system, zeta=damping / 2), A, rtol=TIGHT).highest

    # -- what is read from them --------------------------------------------------------------------

    @cached_property
    def turns(self) -> tuple[Turn, ...]:
        """The extrema of d over the amplitude, the ends of its range with them."""
        turns = tuple(turn._replace(x=float(self.amplitudes(turn.x))) for turn in self.resolved.turns)
        return (*turns, self._graze) if self._graze else turns

    @cached_property
    def _graze(self) -> Turn | None:
        """d(1), where polynomials do not end there: d changes to it within a layer at rest too thin for them."""
        table = self.system.table
        if len(table.pieces) == 1 or table.pieces[1, 0] >= _THIN * self.system.V:
            return None
        pieces = self.resolved.pieces
        if not pieces or pieces[-1].high < len(self.edges) - 1:  # it is among those that are open
            return None
        graze = attempted(orbit_damping_ratio, self.system)
        if isinstance(graze, Unknown):
            return None
        d = 2 * graze[0]
        error = 2 * graze[1]
        last = self.resolved.turns[-1]
        return Turn(1.0, d, error) if abs(d - last.value) > ERRORS_OF_CLEAR_SIGN * (error + last.error) else None

    def signs(self, dampings: FloatArray, grows_at_rest: BoolArray) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Return at which dampings over sqrt(k m) there is a cycle, at which a stable one, and where that is open.

        - `grows_at_rest`: whether small motions about rest grow at each: a cycle may be smaller than all others.
        """
        none = np.zeros_like(grows_at_rest)
        if not self.covers_all_amplitudes:
            return none, none, ~none
        sides = np.array([self._side(damping) for damping in dampings.tolist()])
        # Where all orbits grow, or shrink, while those about rest do not, there is a cycle that is smaller.
        cycle = (sides != 0) & ((sides > 0) != grows_at_rest)
        stable = cycle & grows_at_rest
        unsure = none.copy()
        if (left := sides == 0).any():
            cycle[left], stable[left], unsure[left] = self._between(dampings[left], grows_at_rest[left])
        return cycle, stable, unsure

    def _side(self, damping: float) -> int:
        """Return 1 where d is shown to lie above a damping, -1 below, else 0."""
        side = self.resolved.side(damping)
        if self._graze and side * (self._graze.value - damping) <= ERRORS_OF_CLEAR_SIGN * self._graze.error:
            return 0
        return side

    def _between(self, dampings: FloatArray, grows_at_rest: BoolArray) -> tuple[BoolArray, BoolArray, BoolArray]:
        """Return the same at dampings between the least and the largest d, by its extrema."""
        _, values, errors = np.array(self.turns)[:, :, None].transpose(1, 0, 2)
        above = np.vstack([grows_at_rest, values > dampings])
        falls = above[:-1] & ~above[1:]
        unknown = [bool(self.resolved.open_at(damping)) for damping in dampings.tolist()]
        near = np.abs(values - dampings) <= ERRORS_OF_CLEAR_SIGN * (errors + ROUNDING * np.abs(dampings))
        return (above[:-1] != above[1:]).any(axis=0), falls.any(axis=0), near.any(axis=0) | unknown

    def cycles(self, damping: float) -> Iterator[tuple[float, bool]]:
        """Yield every amplitude at which d is a damping, ascending, and whether d falls there: a stable cycle.

        Raises `InputError` if orbits leave the speeds that were measured of the law, and `NotConverged` where a
          range of amplitudes is not resolved.
        """
        turns = self.turns
        V = self.system.V
        if any(turn.x > self.measured and turn.value > damping for turn in turns):
            raise self.system.unmeasured(self.system.w_max)
        ranges = [self.amplitudes(ends).tolist() for ends in self.resolved.open_at(damping)]
        for low, high in [*([[NEAREST, self.least]] if self.least > NEAREST else []), *ranges]:
            if not self._passes(low, high, damping):
                raise NotConverged(
                    f"the slip orbits with amplitudes from {low * V:.9g} to {high * V:.9g} m/s are not resolved "
                    f"by {MOST_ORBITS} orbits: limit cycles there may be missed; try ",
                    Call("simulate()", "simulate LAW"),
                )
        roots = {root.low: float(self.amplitudes(root.x)) for root in self.resolved.roots(damping)}
        signs = [self._sign(turn, damping) for turn in turns]
        for i, turn in enumerate(turns):
            if signs[i] == 0 and len(turns) > 1:
                yield turn.x, False
            elif i + 1 < len(turns) and signs[i] * signs[i + 1] < 0:
                ends = turn.x, turns[i + 1].x
                estimate = roots.get(self.resolved.turns[i].x)
                in_layer = turns[i + 1] is self._graze
                A = 1.0 if in_layer else self._polished(estimate, *ends, signs[i], damping)
                yield A, signs[i] > 0

    def _sign(self, turn: Turn, damping: float) -> float:
        """Return the sign of d - damping at an extremum."""
        off = turn.value - damping
        if not abs(off) <= ERRORS_OF_CLEAR_SIGN * (turn.error + ROUNDING * abs(damping)):
            return math.copysign(1.0, off)
        return float(np.sign(self.mismatch(turn.x, damping)))

    def _polished(self, estimate: float | None, low: float, high: float, sign: float, damping: float) -> float:
        """Return the amplitude of a cycle between two, by the mismatch at the damping; of weak friction all are
        small.

        - `sign`: of d - damping at the lower one, where d may jump.
        """
        ends = {high: -sign, low: sign}

        def mismatch(A: float) -> float:
            return ends[A] if A in ends else min(max(self.mismatch(A, damping), -1.0), 1.0)

        if estimate is not None:
            beside = (
                max(estimate * (1 - _RELATIVE_CYCLE_WIDTH), low),
                min(estimate * (1 + _RELATIVE_CYCLE_WIDTH), high),
            )
            signs = np.sign([mismatch(A) for A in beside])
            if not signs.any():
                return estimate
            if signs.prod() < 0:
                low, high = beside
        return float(brentq(mismatch, low, high, xtol=ROUNDING * high)) if low < high else low

    def _passes(self, low: float, high: float, damping: float) -> bool:
        """Whether a motion goes through all amplitudes between two: orbits do not cross, so no cycle is there."""
        system = replace(self.system, zeta=damping / 2)
        way = math.copysign(1.0, self.mismatch(low, damping))
        peak, end = (low, high) if way > 0 else (high, low)
        for _ in range(_ROUNDS_LOOKED_AT):
            before = peak
            peak = 1 - first_minimum(system, system.turn(1 - peak), 1 - peak, TIGHT)
            if way * (peak - end) >= 0:
                return True
            if way * (peak - before) <= 0:
                return False
        return False


def _orbit_dampings(system: NondimensionalOscillator, eta: FloatArray, A: FloatArray) -> Column:
    """Return d of orbits, each at an eta of its own.

    It is infinite where no damping is enough, or none too little. Where less lets an orbit leave the speeds that
    were measured it is the damping at which that begins.
    """
    rows = np.full((A.size, 5), float(SearchEnd.LATE))
    system.spread(search_damping_ratios, (eta, np.zeros(A.size), A), (OF_ORBITS,), rows)
    check_time()
    rows[:, 1:] *= 2
    return damping_ratios(rows)


def resolve_together(needs: Sequence[NeededDamping]) -> None:
    """Resolve d of oscillators that differ in eta alone at once: many orbits take little longer than one.

    The places of each follow those of the one before.
    """
    needs = [need for need in needs if "resolved" not in vars(need)]
    if not needs:
        return
    begins = np.cumsum([0, *(len(need.edges) - 1 for need in needs)])
    system = needs[0].system
    etas = np.array([need.system.eta for need in needs])

    def values(places: FloatArray) -> Column:
        which = np.searchsorted(begins, places, side="right") - 1
        A = np.empty(places.size)
        for i in np.unique(which).tolist():
            A[which == i] = needs[i].amplitudes(places[which == i] - begins[i])
        return _orbit_dampings(system, etas[which], A)

    whole = resolve(values, range(int(begins[-1]) + 1), rtol=DAMPING_RTOL, most=MOST_ORBITS * len(needs))
    for need, (begin, end) in zip(needs, pairwise(begins.tolist()), strict=True):
        vars(need)["resolved"] = whole.between(begin, end)


@lru_cache(maxsize=64)  # of one law and belt speed all normal forces ask for it
def quick_speeds(table: FrictionTable, V: float) -> list[float]:
    """Return the slip speeds in m/s, ascending, at which a law has a kink or a jump, or changes quickly beside V.

    It does so in pieces of its table that are narrower than those beside them, at both ends of these, and at the
    end of a layer at rest.
    """
    begins = np.append(table.pieces[:, 0], table.end)
    widths = np.diff(begins)
    bounds = np.flatnonzero(np.abs(np.diff(np.log(widths))) > -math.log(_NARROWER)) + 1
    runs = [0, *bounds.tolist(), widths.size]
    narrow = [
        begins[end]
        for before, first, after in zip(runs, runs[1:], runs[2:], strict=False)
        if widths[first] < min(_NARROWER * widths[[before, after % widths.size]].min(), V / _NARROW_RATIO)
        for end in (first, after)
    ]
    measured = [table.end] if math.isfinite(table.reach) else []
    layer = [float(begins[runs[1]])] if widths[0] < _THIN * V < math.inf else []
    return sorted({*table.kinks, *map(float, narrow), *measured, *layer})


def needed_damping(law: FrictionLaw, osc: Oscillator) -> NeededDamping:
    """Return the damping that slip orbits need as a function of their amplitude; the c of `osc` is not used."""
    system = NondimensionalOscillator.of(law.bound, osc)
    return needed_damping_at(system.table, system.eta, system.V)


@lru_cache(maxsize=64)  # cycles at many dampings read one
def needed_damping_at(table: FrictionTable, eta: float, V: float) -> NeededDamping:
    """Return the same from the table of a law, and numbers free of units."""
    return NeededDamping(NondimensionalOscillator(eta, 0.0, _drop_static_excess(table), V))


@lru_cache(maxsize=64)  # so that what is computed of a table at a belt speed is shared by all normal forces
def _drop_static_excess(table: FrictionTable) -> FrictionTable:
    return replace(table, static=table.onset)


@lru_cache(maxsize=64)
def _rise_at(table: FrictionTable, V: float) -> Rise:
    return table.at(V)

"""Motions in many scenes of one map, decided together.

Where the damping is no axis every cell is a scene of its own. What `columns` computes for each scene (the damping of
the orbit that touches the belt's speed, and at which amplitudes slip orbits grow) is computed here for all of
them at once (`touch`, `patterns`), and a comparison decides each cell. What is beside a threshold or a fold, and
what these ways are not made for, is left to `columns`, scene by scene.

A law with mu(0+) = 0 holds no mass. Where the slip from P returns then, motions go out to one that overtakes the
belt each round, since damping and friction bring those far out back in.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.errors import OutOfTime, StickSlipError
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.maps.averages import least_squares_dampings
from stickslip_sym.motion.maps.cells import MOTIONS, REASONS, Attractor, Cells, Reason
from stickslip_sym.motion.maps.columns import KNOWN, decide
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.regimes.attractors import grows_far_out
from stickslip_sym.motion.regimes.classification import Motion
from stickslip_sym.motion.regimes.patterns import Patterns, patterns
from stickslip_sym.motion.regimes.rounds import CREEPS, RETURN, TURN, Family, arrive
from stickslip_sym.motion.regimes.touch import touching_dampings
from stickslip_sym.motion.simulation.resolution import jumps

__all__ = ["Asked", "alone", "decide_together"]

_STRONGEST = 50.0  # friction N/(V sqrt(k m)), from which on motions decay too fast for explicit steps
_BESIDE = 100  # errors of a threshold, within which a cell is left to `columns`
_RTOL = 1e-8  # of steps
_DEEP = 1e-5  # slip speed over the belt's, at which a slip is known to turn
_PHASES = np.arange(1, 256, 2) * np.pi / 256  # of half an orbit, for the first guess of a threshold
_SAME = 1e-9  # relative, of the belt's speed and a kink; and of coefficients


@dataclass(frozen=True)
class Asked:
    """Dampings in one scene."""

    law: FrictionLaw
    osc: Oscillator
    c: FloatArray


def decide_together(asked: Sequence[Asked], *, rtol: float) -> list[Cells]:
    """Return the motion from x = 0, x' = V, and every attractor, for dampings in scenes.

    - `asked`: laws have all parameters bound, and are of one formula.
    - `rtol`: as for `decide`.

    What fails is in the cells.
    """
    found: dict[int, Cells] = {}
    for places in _alike(asked):
        try:
            found |= dict(zip(places, _Batch([asked[i] for i in places], rtol).cells(), strict=True))
        except OutOfTime as error:
            found |= {i: Cells.failed(asked[i].c.size, error) for i in places}
        except (ArithmeticError, StickSlipError):  # of one scene: each may say it for itself
            continue
    return [found[i] if i in found else alone(one, rtol=rtol) for i, one in enumerate(asked)]


def alone(one: Asked, *, rtol: float) -> Cells:
    """Return the same of one scene by itself, as `columns` decides it."""
    try:
        return decide(one.law, one.osc, one.c, rtol=rtol)
    except StickSlipError as error:
        return Cells.failed(one.c.size, error)


def _alike(asked: Sequence[Asked]) -> list[list[int]]:
    """Sort out scenes that can be followed together: those that have a law whose kinks are the same."""
    groups: dict[FrictionLaw | None, list[int]] = {}
    for i, one in enumerate(asked):
        if _suits(one.law, one.osc):
            groups.setdefault(one.law if one.law.kinks() else None, []).append(i)
    return list(groups.values())


def _suits(law: FrictionLaw, osc: Oscillator) -> bool:
    if not 0 < osc.eta <= _STRONGEST or (law.v_max is not None and law.v_max < 2 * osc.V):
        return False
    if any(abs(float(place) / osc.V - 1) <= _SAME for place in law.kinks()):
        return False
    try:
        scene = Scene.of(law, osc)
    except StickSlipError:
        return False
    return not any(jumps(scene, *pair) for pair in pairwise(scene.branches))


class _Batch:
    """Scenes of one formula, and their dampings."""

    def __init__(self, asked: Sequence[Asked], rtol: float) -> None:
        self.asked, self.rtol = asked, rtol
        self.V, self.N = (np.array([getattr(one.osc, name) for one in asked]) for name in "VN")
        self.ratio = 2 * np.array([one.osc.impedance for one in asked])  # damping over damping ratio
        self.equilibrium, self.least_squares, guess = np.empty((3, len(asked)))
        for law, rows in self._laws():
            V, N = self.V[rows], self.N[rows]
            self.equilibrium[rows] = -N * law.slope(V)
            self.least_squares[rows] = least_squares_dampings(law, V, N)
            mu = law.at_speeds(V[:, None] * (1 - np.cos(_PHASES)))
            guess[rows] = 2 * N / V * np.mean(mu * np.cos(_PHASES), axis=1)
        self.family = self._family()
        zeta, error = touching_dampings(self.family, guess / self.ratio)
        self.exact, self.doubt = zeta * self.ratio, error * self.ratio
        none = self._without_threshold()
        self.exact[none], self.doubt[none] = -np.inf, 0.0
        self.scene = np.repeat(np.arange(len(asked)), [one.c.size for one in asked])
        self.c = np.concatenate([one.c for one in asked])

    def _without_threshold(self) -> IntArray:
        """Return the scenes without a known one where the slip from P does not return even without damping."""
        rows = np.flatnonzero(np.isnan(self.exact))
        nothing = np.zeros(rows.size)
        found = arrive(self.family.rows(rows), nothing, nothing, nothing, nothing + _RTOL)
        below = (found.end == TURN) & (found.w > _DEEP) | (found.end == CREEPS)
        return rows[below]

    def _laws(self) -> list[tuple[FrictionLaw, IntArray]]:
        rows: dict[FrictionLaw, list[int]] = {}
        for i, one in enumerate(self.asked):
            rows.setdefault(one.law, []).append(i)
        return [(law, np.array(places)) for law, places in rows.items()]

    def _family(self) -> Family:
        first = self.asked[0].law
        laws = self._laws()
        names = [name for name in first.values if any(law.values[name] != first.values[name] for law, _ in laws)]
        eta = np.array([one.osc.eta for one in self.asked])
        static, onset, *given = np.empty((2 + len(names), len(self.asked)))
        for law, rows in laws:
            scene = Scene.of(law, self.asked[rows[0]].osc)
            static[rows], onset[rows] = scene.static, scene.onset
            for column, name in zip(given, names, strict=True):
                column[rows] = float(law.values[name])
        end = np.inf if first.v_max is None else float(first.v_max)
        places = np.array([-np.inf, *map(float, first.kinks()), end])
        return Family(first.by_piece(names), self.V, eta, static, onset, places / self.V[:, None], tuple(given))

    # -- cells -------------------------------------------------------------------------------------

    def cells(self) -> list[Cells]:
        """Decide the cells of every scene."""
        c, exact, equilibrium = self.c, self.exact[self.scene], self.equilibrium[self.scene]
        known = self._clear()
        inside = known & (c > exact)
        zeta = c / self.ratio[self.scene]
        sticks = known & (c < exact)
        rows = np.flatnonzero(known)
        family = self.family.rows(self.scene[rows])
        pattern = patterns(family, zeta[rows], (equilibrium / self.ratio[self.scene])[rows])
        known[rows] &= pattern.known & self._as_expected(family, zeta[rows], sticks[rows], pattern)
        cycle, stable = np.zeros((2, c.size), bool)
        cycle[rows], stable[rows] = pattern.cycle, pattern.stable
        held = (self.family.static > 0)[self.scene]
        rest = c > equilibrium
        motion = np.select(
            [sticks & held, sticks | cycle],
            [MOTIONS.index(Motion.STICK_SLIP), MOTIONS.index(Motion.PURE_SLIP)],
            MOTIONS.index(Motion.DAMPED_SLIP),
        )
        attractors = Attractor.STICK_SLIP * (sticks & held) + Attractor.REST * rest
        attractors += Attractor.PURE_SLIP * (stable | sticks & ~held)
        reason = np.select(
            [inside & rest & ~cycle, sticks & ~rest & ~cycle],
            [REASONS.index(Reason.ABOVE), REASONS.index(Reason.BELOW)],
            REASONS.index(Reason.BETWEEN),
        )
        ends = np.cumsum([one.c.size for one in self.asked])[:-1]
        parts = zip(*(np.split(column, ends) for column in (motion, attractors, reason, known)), strict=True)
        return [self._of_scene(i, *part) for i, part in enumerate(parts)]

    def _clear(self) -> BoolArray:
        """Tell which cells lie clear of the thresholds, where the comparison with them holds."""
        c, exact, equilibrium = self.c, self.exact[self.scene], self.equilibrium[self.scene]
        largest = np.maximum(np.abs(np.where(np.isinf(exact), 0.0, exact)), np.abs(equilibrium))
        margin = max(self.rtol, KNOWN) * largest
        margin += _BESIDE * self.doubt[self.scene]
        clear: BoolArray = (c >= 0) & (np.abs(c - exact) > margin) & (np.abs(c - equilibrium) > margin)
        far_out = np.array([grows_far_out(one.law, one.osc) for one in self.asked])
        static = self.family.static[self.scene]
        held = c * self.V[self.scene] <= static * self.N[self.scene]
        return clear & np.where(static > 0, (c > exact) | held, (static == 0) & ~far_out[self.scene])

    def _as_expected(self, family: Family, zeta: FloatArray, sticks: BoolArray, pattern: Patterns) -> BoolArray:
        """Tell where the slips that decide end as the thresholds say: to stick, or below the belt's speed."""
        free = family.static == 0
        jump = family.static - family.onset > _SAME * np.abs(family.onset)
        agrees: BoolArray = np.where(jump, sticks | ~pattern.grows, sticks == pattern.grows)
        rows = np.flatnonzero(sticks != free)
        # The start of a mass that nothing holds is not P.
        q, size = np.where(free, 2 * zeta, 0.0)[rows], np.full(rows.size, _RTOL)
        found = arrive(family.rows(rows), zeta[rows], q, np.zeros(rows.size), size)
        stuck = (found.end == RETURN) & (found.q <= 0) & (found.q >= -(2 * family.eta * family.static)[rows])
        below = (found.end == TURN) | (found.end == CREEPS)
        agrees[rows] &= np.where(free[rows], below, stuck)
        return agrees

    def _of_scene(
        self, i: int, motion: IntArray, attractors: IntArray, reason: IntArray, known: BoolArray
    ) -> Cells:
        one, exact, average = self.asked[i], self.exact[i], self.least_squares[i]
        smooth = obstacle(one.law, one.osc.V) is None
        cells = Cells(
            motion.tolist(), attractors.tolist(), reason.tolist(), float(self.equilibrium[i]),
            float(average) if np.isfinite(average) else None,
            float(exact) if np.isfinite(exact) and (smooth or exact >= 0) else None,
        )  # fmt: skip
        left = np.flatnonzero(~known).tolist()
        if left:
            found = alone(replace(one, c=one.c[left]), rtol=self.rtol)
            for j, place in enumerate(left):
                cells.motion[place], cells.attractors[place] = found.motion[j], found.attractors[j]
                cells.reason[place] = found.reason[j]
            cells.notes = {left[j]: text for j, text in found.notes.items()}
            cells.exact = found.exact if cells.exact is None else cells.exact
        return cells

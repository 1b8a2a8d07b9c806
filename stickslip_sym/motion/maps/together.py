"""Motions in many scenes of one map, decided together.

Where the damping is no axis every cell is a scene of its own. The damping of the orbit that touches the belt's
speed, and where slip orbits grow, are computed for all of them at once (`touch`, `patterns`), and comparisons
decide the cells. What is beside a threshold or a fold, and what these ways are not made for, is left to `columns`,
scene by scene.

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
from stickslip_sym.motion.maps.cells import MOTIONS, REASONS, Attractor, Cells, Reason
from stickslip_sym.motion.maps.columns import KNOWN, decide, least_squares_dampings
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


@dataclass(frozen=True)
class _Facts:
    """What scenes of one law have in common."""

    law: FrictionLaw
    kinks: tuple[float, ...]
    static: float
    onset: float
    jumps: bool

    @classmethod
    def of(cls, law: FrictionLaw) -> "_Facts":
        scene = Scene.of(law, Oscillator(m=1, k=1, V=1, N=1))
        places = tuple(float(place) for place in law.kinks())
        return cls(
            law, places, scene.static, scene.onset, any(jumps(scene, *pair) for pair in pairwise(scene.branches))
        )

    @property
    def held(self) -> bool:
        """Whether static friction holds more than what slips."""
        return self.static - self.onset > _SAME * abs(self.onset)

    def suit(self, osc: Oscillator) -> bool:
        """Tell whether steps of time from an onset to the next are made for a scene."""
        end = self.law.v_max
        beside = any(abs(place / osc.V - 1) <= _SAME for place in self.kinks)
        return not (self.jumps or beside or (end is not None and end < 2 * osc.V)) and 0 < osc.eta <= _STRONGEST

    def smooth(self, V: float) -> bool:
        """Whether slip orbits are smooth up to the one that touches the belt's speed."""
        return not self.held and all(place >= 2 * V for place in self.kinks)


def decide_together(asked: Sequence[Asked], *, rtol: float) -> list[Cells]:
    """Return the motion from x = 0, x' = V, and every attractor, for dampings in scenes.

    - `asked`: laws have all parameters bound, and are of one formula.
    - `rtol`: as for `decide`.

    What fails is in the cells.
    """
    found: dict[int, Cells] = {}
    for places, facts in _alike(asked):
        try:
            cells = _Batch([asked[i] for i in places], facts, rtol).cells()
            found |= dict(zip(places, cells, strict=True))
        except OutOfTime as error:
            found |= {i: Cells.failed(asked[i].c.size, error) for i in places}
        except (ArithmeticError, StickSlipError):  # of one scene: each may say it for itself
            continue
    return [found[i] if i in found else alone(one, rtol=rtol) for i, one in enumerate(asked)]


def _alike(asked: Sequence[Asked]) -> list[tuple[list[int], list[_Facts]]]:
    """Sort out scenes that can be followed together: those of laws without kinks, or of one law."""
    groups: dict[int | None, tuple[list[int], list[_Facts]]] = {}
    known: dict[int, _Facts | None] = {}
    for i, one in enumerate(asked):
        if id(one.law) not in known:
            try:
                known[id(one.law)] = _Facts.of(one.law)
            except StickSlipError:
                known[id(one.law)] = None
        facts = known[id(one.law)]
        if facts is not None and facts.suit(one.osc):
            places, described = groups.setdefault(id(one.law) if facts.kinks else None, ([], []))
            places.append(i)
            described.append(facts)
    return list(groups.values())


def alone(one: Asked, *, rtol: float) -> Cells:
    """Return the same of one scene by itself, as `columns` decides it."""
    try:
        return decide(one.law, one.osc, one.c, rtol=rtol)
    except StickSlipError as error:
        return Cells.failed(one.c.size, error)


class _Batch:
    """Scenes of one formula, and their dampings."""

    def __init__(self, asked: Sequence[Asked], facts: Sequence[_Facts], rtol: float) -> None:
        self.asked, self.facts, self.rtol = asked, facts, rtol
        self.V, self.N = (np.array([getattr(one.osc, name) for one in asked]) for name in "VN")
        self.ratio = 2 * np.array([one.osc.impedance for one in asked])  # damping over damping ratio
        self.equilibrium, self.least_squares, guess = np.empty((3, len(asked)))
        for one, rows in self._laws():
            law, V, N = one.law, self.V[rows], self.N[rows]
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
        return np.asarray(rows[below])

    def _laws(self) -> list[tuple[_Facts, IntArray]]:
        rows: dict[int, list[int]] = {}
        for i, one in enumerate(self.facts):
            rows.setdefault(id(one), []).append(i)
        return [(self.facts[places[0]], np.array(places)) for places in rows.values()]

    def _family(self) -> Family:
        first, laws = self.facts[0], self._laws()
        values = [(one.law.values, rows) for one, rows in laws]
        names = [
            name
            for name, value in first.law.values.items()
            if first.law.parameters[name].symbol in first.law.expr.free_symbols
            and any(other[name] != value for other, _ in values)
        ]
        given = np.empty((len(names), len(self.asked)))
        for other, rows in values:
            given[:, rows] = np.array([float(other[name]) for name in names])[:, None]
        end = np.inf if first.law.v_max is None else float(first.law.v_max)
        return Family(
            first.law.by_piece(names), self.V, np.array([one.osc.eta for one in self.asked]),
            np.array([one.static for one in self.facts]), np.array([one.onset for one in self.facts]),
            np.array([-np.inf, *first.kinks, end]) / self.V[:, None], tuple(given),
        )  # fmt: skip

    # -- cells -------------------------------------------------------------------------------------

    def cells(self) -> list[Cells]:
        """Decide the cells of every scene."""
        c, exact, equilibrium = self.c, self.exact[self.scene], self.equilibrium[self.scene]
        known = self._clear()
        inside = known & (c > exact)
        zeta = c / self.ratio[self.scene]
        sticks = known & (c < exact)
        rows = np.flatnonzero(known)
        scene = self.scene[rows]
        pattern = patterns(self.family.rows(scene), zeta[rows], equilibrium[rows] / self.ratio[scene])
        known[rows] &= pattern.known & self._as_expected(scene, zeta[rows], sticks[rows], pattern)
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
        static = self.family.static[self.scene]
        held = c * self.V[self.scene] <= static * self.N[self.scene]
        pairs = zip(self.facts, self.asked, strict=True)
        come_in = [facts.static == 0 and not grows_far_out(facts.law, one.osc) for facts, one in pairs]
        return np.where(static > 0, (c > exact) | held, np.array(come_in)[self.scene]) & clear

    def _as_expected(self, scene: IntArray, zeta: FloatArray, sticks: BoolArray, pattern: Patterns) -> BoolArray:
        """Tell where the slips that decide end as the thresholds say: to stick, or below the belt's speed."""
        family, held = self.family.rows(scene), np.array([one.held for one in self.facts])[scene]
        free = family.static == 0
        agrees: BoolArray = np.where(held, sticks | ~pattern.grows, sticks == pattern.grows)
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
        smooth = self.facts[i].smooth(one.osc.V)
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

"""Slip orbits from level to level of the slip speed: where they go, without when.

Where only the curve in the plane is asked for, as by a threshold, w can take the place of the time (Henon, Physica
D 5 (1982) 412):

    dq/dw = (1 - w)/w',    w' = eta (mu_static - mu(V w)) + q - 2 zeta w.

So a step ends at a kink of mu because it was told to, and no crossing is looked for. All orbits of a scene,
whatever their damping, pass the same levels, so mu is computed at the stages of each step once for all of them.
Where w turns, and w' vanishes, steps of time lead from the last level to the next one.

What these steps are not made for (a jump of mu, a layer too thin for the levels, a fast decay, creeping) is left
to `follow`: the answer is None.
"""

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from operator import mul

from scipy.integrate import DOP853

from stickslip_sym.core.deadline import check_time
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.simulation.resolution import levels_between
from stickslip_sym.motion.simulation.slip_phase import End
from stickslip_sym.motion.simulation.steppers import Explicit, Point, Rates

__all__ = ["Arrival", "Levels"]

_BENT = 0.35  # relative change of w' in a step between levels, above which w turns too soon
_DEEPEST = 5  # halvings of such a step
_ORDER, _SAFETY = 8, 0.15  # of its error in its length; halvings more than that asks for
_LONGEST_STEP = 0.35  # of time
_FIRST_STEP = 0.25  # of time, beside a level; from a steep onset it is shortened
_MOST_STEPS = 80  # of time in one orbit, which takes about ten
_TOUCH = 1e-10  # by which w may pass a kink and turn unnoticed: it is on the way for 1e-5
_GRAZE = 1e-6  # depth below w = 0, within which a turn counts as the end rather than the return before it
_NEWTON = 6  # steps of Newton's method to a turn
_CLOSE = 1e-5  # time from a turn, over which w is a parabola
_BESIDE = 1e-5  # distance of w, over which a slope of mu is taken
_NODES = DOP853.C[1:12].tolist()
_STAGES = [row[:i].tolist() for i, row in enumerate(DOP853.A)][1:]
_END, _ERROR_3, _ERROR_5 = DOP853.B.tolist(), DOP853.E3[:12].tolist(), DOP853.E5[:12].tolist()
_SMALL = 0.01  # states below count as that large, as in steps of time


@dataclass(frozen=True)
class Arrival:
    """Where a slip orbit comes to: a minimum of w, or a return to w = 0, at (q, w)."""

    end: End
    q: float
    w: float


@dataclass(frozen=True)
class _Crossing:
    """What a step from one slip speed to another needs, once for all orbits."""

    w: list[float]  # at the stages, the first at the start, and at the end
    friction: list[float]  # what friction adds to w' there
    rise: list[float]  # q' there
    stages: list[list[float]]  # coefficients of the method times the length of the step
    end: list[float]
    errors: tuple[list[float], list[float]]


class Levels:
    """The levels of one scene, and its orbits at any damping; what the scene says of damping is not used."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.levels = levels_between(scene)
        self.lows = [branch.low for branch in scene.branches]
        self.crossings: dict[tuple[float, float], _Crossing] = {}

    def arrive(self, zeta: float, q: float, w: float, rtol: float) -> Arrival | None:
        """Follow the orbit that leaves (q, w), where w' >= 0, to its next minimum of w or return to w = 0.

        - `zeta`: damping ratio.
        - `rtol`: relative tolerance of a step, of either kind.
        """
        check_time()
        if not self.levels:
            return None
        return _Orbit(self, 2 * zeta, rtol).arrive(q, w)

    def lowest(self, zeta: float, rtol: float) -> float | None:
        """Return the first minimum of w after P, or -w'^2/2 at a return."""
        found = self.arrive(zeta, 0.0, 0.0, rtol)
        return None if found is None else self._depth(found)

    def next_peak(self, zeta: float, amplitude: float, rtol: float) -> float | None:
        """Return the next peak of the velocity after one at `amplitude`, over V; 1 + w'^2/2 at a return."""
        w = 1 - amplitude
        found = self.arrive(zeta, 2 * zeta * w - self.scene.friction(w, 1), w, rtol)
        return None if found is None else 1 - self._depth(found)

    def _depth(self, found: Arrival) -> float:
        # At w = 0 damping has no part in w'.
        return found.w if found.end is End.MINIMUM else -(self.scene.acceleration(found.q, 0.0, 1) ** 2) / 2

    def crossing(self, start: float, end: float, index: int) -> _Crossing:
        """Return what a step between two slip speeds needs on a smooth segment of mu, or beside it."""
        scene, length, rise = self.scene, end - start, self.scene.branches[index].rise
        held = scene.static - scene.onset
        w = [start, *(start + node * length for node in _NODES), end]
        return _Crossing(
            w,
            [scene.eta * (held - rise(place)) for place in w],
            [1 - place for place in w],
            [[length * a for a in row] for row in _STAGES],
            [length * b for b in _END],
            ([length * e for e in _ERROR_5], [length * e for e in _ERROR_3]),
        )

    def kept(self, start: float, end: float, index: int) -> _Crossing:
        """Return the same of a step that other orbits will take too."""
        if (start, end) not in self.crossings:
            self.crossings[start, end] = self.crossing(start, end, index)
        return self.crossings[start, end]

    def index(self, w: float) -> int:
        """Return the place of the segment of mu that holds at w and above."""
        return bisect_right(self.lows, w) - 1


class _Orbit:
    """One orbit on its way."""

    def __init__(self, levels: Levels, damping: float, rtol: float) -> None:
        self.levels, self.scene, self.damping, self.rtol = levels, levels.scene, damping, rtol
        self.rising = True
        self.solver: Explicit | None = None  # of steps of time
        self.rates: dict[int, Rates] = {}  # on the segments of mu

    def arrive(self, q: float, w: float) -> Arrival | None:
        steps, at_level = 0, False
        while True:
            level = self._next(w)
            if level is None:
                return None
            found = self._cross(w, level, q, self.levels.index((w + level) / 2), keep=at_level)
            if found is not None:
                q, w, self.solver, at_level = found, level, None, True
            else:
                steps, at_level = steps + 1, False
                after = self._step(q, w) if steps <= _MOST_STEPS else None
                if after is None or isinstance(after, Arrival):
                    return after
                q, w = after
            if w == 0:
                return Arrival(End.RETURN, q, 0.0)

    def _next(self, w: float) -> float | None:
        """Return the next level on the way."""
        levels = self.levels.levels
        place = bisect_right(levels, w) if self.rising else bisect_left(levels, w) - 1
        return levels[place] if 0 <= place < len(levels) else None

    def _cross(
        self, start: float, end: float, q: float, index: int, *, keep: bool = False, depth: int = 0
    ) -> float | None:
        """Return q after a step from one slip speed to another; None where w turns, or nearly does.

        - `index`: of the segment of mu.
        - `keep`: what the step needs, since it is one between levels.
        """
        levels, damping, positive = self.levels, self.damping, self.rising
        kept = levels.kept(start, end, index) if keep else None
        slope = kept.friction[0] - damping * start + q if kept else self._rates(index)(q, start)[1]
        if (slope > 0) != positive or abs((1 - start) * (end - start)) > _BENT * slope * slope:
            return None
        crossing = kept or levels.crossing(start, end, index)
        w, friction, rise = crossing.w, crossing.friction, crossing.rise
        rates = [rise[0] / slope]
        try:
            for i, row in enumerate(crossing.stages, 1):
                rates.append(rise[i] / (friction[i] - damping * w[i] + q + sum(map(mul, row, rates))))
        except ZeroDivisionError:
            return None
        last = q + sum(map(mul, crossing.end, rates))
        scale = self.rtol * (_SMALL + max(abs(q), abs(last)))
        fifth, third = (sum(map(mul, row, rates)) / scale for row in crossing.errors)
        error = fifth * fifth / math.sqrt(fifth * fifth + 0.01 * third * third) if fifth else 0.0
        if error < 1:
            return last if (friction[-1] - damping * end + last > 0) == positive else None
        # What is not finite compares as false, and counts as the largest error.
        halvings = max(math.ceil(math.log2(error) / _ORDER + _SAFETY), 1) if error < math.inf else _DEEPEST
        if depth + halvings > _DEEPEST:
            return None
        found: float | None = q
        for i in range(2**halvings):
            if found is not None:
                low, high = (start + (end - start) * part / 2**halvings for part in (i, i + 1))
                found = self._cross(low, high, found, index, keep=keep, depth=depth + halvings)
        return found

    # -- steps of time, where w turns ----------------------------------------------------------------------

    def _rates(self, index: int) -> Rates:
        if index not in self.rates:
            scene, damping, rise = self.scene, self.damping, self.scene.branches[index].rise
            held, eta = scene.eta * (scene.static - scene.onset), scene.eta
            self.rates[index] = lambda q, w: (1 - w, held - eta * rise(w) + q - damping * w)
        return self.rates[index]

    def _step(self, q: float, w: float) -> tuple[float, float] | Arrival | None:
        """Take a step of time, to (q, w), or to the end of the orbit; None if there is none."""
        lows, index = self.levels.lows, self.levels.index(w)
        if not self.rising and w == lows[index]:
            index -= 1
        low, high = lows[index], [*lows, math.inf][index + 1]
        rates = self._rates(index)
        if self.solver is None:
            self.solver = self._begin(index, Point(0.0, q, w), _FIRST_STEP)
        while True:
            solver, before, slope = self.solver, self.solver.now, self.solver.slope
            if solver.step() is None:
                return None
            now = solver.now
            turns = (solver.slope > 0) != self.rising
            level = high if self.rising else low
            if turns:
                length = now.tau - before.tau
                # The tangents at the ends meet no nearer than this to the extremum between them.
                reach = max(abs(slope), abs(solver.slope)) * length
                if self.rising and now.w > max(low, 1.0) and max(before.w, now.w) + reach < high:
                    self.rising = False
                    return now.q, now.w
                turn = self._turn(index, before, now)
                if turn is None:
                    return None
                beyond = (turn.w - level) * (1 if self.rising else -1)
                if beyond <= (_GRAZE if level == 0 else _TOUCH):
                    if (turn.w > 1) != self.rising:
                        return None
                    if not self.rising:
                        return Arrival(End.MINIMUM, turn.q, turn.w)
                    self.rising, self.solver = False, None
                    return turn.q, min(turn.w, high)
            elif (now.w < level) if self.rising else (now.w > level):
                return now.q, now.w
            else:
                # From the end that is further from a turn; beyond the level the segment goes on smoothly.
                ends = sorted((before, now), key=lambda point: -abs(rates(point.q, point.w)[1]))
                for point in ends:
                    q_level = self._cross(point.w, level, point.q, index)
                    if q_level is not None:
                        self.solver = None
                        return q_level, level
            half = (now.tau - before.tau) / 2
            if half < _TOUCH:
                return None
            self.solver = self._begin(index, before, half)

    def _begin(self, index: int, start: Point, step: float) -> Explicit:
        return Explicit(self._rates(index), start, math.inf, self.rtol, step=step, longest=_LONGEST_STEP)

    def _turn(self, index: int, before: Point, after: Point) -> Point | None:
        """Locate the extremum of w in a step of time by Newton's method from the end nearer to it."""
        rates, rise, eta = self._rates(index), self.scene.branches[index].rise, self.scene.eta
        near = min(before, after, key=lambda point: abs(rates(point.q, point.w)[1]))
        for _ in range(_NEWTON):
            dq, slope = rates(near.q, near.w)
            decay = eta * (rise(near.w + _BESIDE) - rise(near.w - _BESIDE)) / (2 * _BESIDE) + self.damping
            bend = dq - decay * slope
            shift = -slope / bend if bend else math.inf
            if abs(shift) < _CLOSE:
                return Point(near.tau + shift, near.q + shift * dq, near.w + shift * slope / 2)
            length = near.tau + shift - before.tau
            if not 0 < length < 2 * _LONGEST_STEP:
                return None
            again = Explicit(rates, before, near.tau + shift, math.inf, step=length)
            again.step()
            near = again.now
        return None

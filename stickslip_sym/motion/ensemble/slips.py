"""Many slips at once: all that are under way take a step, each of its own length; who ends makes room for others.

Extrema of w are seen at the ends of a step, as for a single motion. Most are far from where anything happens, and
are located later, many at once. A step in which w may leave its segment of mu, or come to 0, is set aside with its
mass, and looked at when there are many of them: then the extremum is located before the crossing, so that a graze
is neither missed nor invented.
"""

import time

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.deadline import time_left
from stickslip_sym.motion.ensemble.beginning import begun
from stickslip_sym.motion.ensemble.extrema import Extrema
from stickslip_sym.motion.ensemble.field import EXPONENT, Field, Rise, error_of
from stickslip_sym.motion.ensemble.locating import level_passed, turn_estimated, turn_located
from stickslip_sym.motion.ensemble.log import BACK, FORWARD, STICK, Log
from stickslip_sym.motion.ensemble.rows import Rows, Step
from stickslip_sym.motion.simulation.slip_phase import REST_WITHIN, RUNAWAY, End, Until
from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome

__all__ = ["Slips"]

_ROOM = 3600  # masses under way: their stages are 0.7 MB, and a product with them is too small for threads
_MANY = 400  # steps set aside, that are looked at together
_LONGEST_STEP = 0.25  # of dimensionless time, as in a single motion
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
_TINY = 1e-30  # error of a step, below which it is none
_FEW, _RATE = 500, 60  # tries of a step in a phase, and more for each unit of time
_STIFF, _STABLE = 10.0, 2.5  # decay of w, and decay times a step, from which stability holds steps short
_MOST_HELD = 600  # steps held short one after another
_SELDOM = 20  # steps, of which one is looked at for that
_MARGIN = 0.05  # of w, and relative, from a level: more than the cubic of a step is off


class Slips:
    """The motions of a log, followed up to where they come to P, end, or are given up.

    - `until`: `End.MINIMUM`: end also at a minimum of w above 0 of a mass slower than the belt, and where a mass
      begins to be slower than the belt for the second time, without having come to P.
    - `lowest`: for each start the slip speed at such a minimum, else NaN.
    - `rounds`: rows of q where a mass began to be slower for the first and second time, else NaN.
    - `alone`: numbers of the starts that are given up: a decay holds steps short, or mu has no value on the
      way, or is not known so far.
    """

    def __init__(
        self, field: Field, log: Log, *, horizon: float, rtol: float, deadline: float, until: Until = End.RETURN
    ) -> None:
        self.field, self.log, self.scene = field, log, field.scene
        self.horizon, self.rtol, self.deadline = horizon, rtol, deadline
        self.ends_at_minima = until is End.MINIMUM
        self.lowest, self.rounds = np.full(log.tau.size, np.nan), np.full((2, log.tau.size), np.nan)
        self.extrema = Extrema(field, log)
        self.attracts = self.scene.decay(1.0) > 0
        self.under_way = Rows.none()
        self.waiting: list[IntArray] = []  # motions whose next phase is a slip
        self.aside: list[Step] = []
        self.taken = 0  # steps of all
        self.alone: list[int] = []

    def follow(self) -> None:
        """Follow all motions."""
        log, starts = self.log, np.arange(self.log.tau.size)
        for chosen, phase in ((log.u < 1, BACK), (log.u > 1, FORWARD)):
            log.event(starts[chosen], phase, EventKind.START)
            self.waiting.append(starts[chosen])
        self._from_belt(starts[log.u == 1], EventKind.START)
        while self.under_way.size or self.aside or any(rows.size for rows in self.waiting):
            if time.monotonic() > self.deadline or time_left() < 0:
                self._stop()
                break
            self._fill_up()
            if self.under_way.size:
                self._advance()
            if sum(step.h.size for step in self.aside) >= (_MANY if self.under_way.size else 1):
                self._look_aside()
        self.extrema.locate()

    # -- from phase to phase -------------------------------------------------------------------------------

    def _from_belt(self, rows: IntArray, before: EventKind) -> None:
        """Go on with motions that have the belt's speed: in stick, at P, or in slip.

        - `before`: the kind of the event unless the mass sticks after slip.
        """
        log, scene = self.log, self.scene
        q, held = log.q[rows], -2 * scene.eta * scene.static <= log.q[rows]
        leaves, sticks = rows[held & (q == 0)], rows[held & (q < 0)]
        slips = rows[~held | (q > 0)]
        log.onset[leaves] = log.tau[leaves]
        log.event(leaves, BACK, before)
        log.side[slips] = np.where(log.q[slips] >= 0, 1.0, -1.0)
        log.event(slips, np.where(log.q[slips] >= 0, BACK, FORWARD), before)
        self.waiting.append(self._not_around(slips) if self.ends_at_minima else slips)

        log.event(sticks, STICK, EventKind.STICKS if before is EventKind.CROSSES else before)
        end = log.tau[sticks] - log.q[sticks]
        comes = end < self.horizon
        stay, come = sticks[~comes], sticks[comes]
        log.moved(stay, np.full(stay.size, self.horizon), log.q[stay] + (self.horizon - log.tau[stay]), 1.0)
        log.ended(stay, Outcome.FINISHED)
        log.moved(come, end[comes], np.zeros(come.size), 1.0)
        log.onset[come] = end[comes]
        log.event(come, BACK, EventKind.SLIPS)

    def _not_around(self, rows: IntArray) -> IntArray:
        """Note where masses leave the belt's speed, and return those that have not done so before."""
        slower = rows[self.log.q[rows] >= 0]
        again = slower[np.isfinite(self.rounds[0, slower])]
        self.rounds[1, again] = self.log.q[again]
        self.rounds[0, np.setdiff1d(slower, again)] = self.log.q[np.setdiff1d(slower, again)]
        self.log.ended(again, Outcome.FINISHED)
        return np.setdiff1d(rows, again)

    def _fill_up(self) -> None:
        """Begin slips where there is room for many, or for all that wait."""
        room = _ROOM - self.under_way.size
        waiting = np.concatenate([np.empty(0, dtype=np.intp), *self.waiting])
        self.waiting = [waiting]
        if waiting.size and room >= min(_ROOM // 8, waiting.size):
            self.waiting = [waiting[room:]]
            row, log = waiting[:room], self.log
            w = log.side[row] * (1 - log.u[row])
            some, odd = begun(self.field, row, log.tau[row], log.q[row], w, log.side[row], rtol=self.rtol)
            self.alone += row[odd].tolist()
            self.under_way = self.under_way.joined(some.taken(~odd))

    def _stop(self) -> None:
        """Leave all motions where they are, as the time is up."""
        for some in (self.under_way, *(step.before for step in self.aside)):
            self.log.moved(some.row, some.tau, some.q, 1 - some.side * some.w)
        goes_on = (self.log.outcome < 0) & np.isnan(self.log.onset)
        self.log.ended(np.flatnonzero(goes_on), Outcome.TIME_LIMIT)

    def _end(self, some: Rows, outcome: Outcome) -> None:
        self.log.moved(some.row, some.tau, some.q, 1 - some.side * some.w)
        self.log.ended(some.row, outcome)

    def _going_on(self, some: Rows) -> Rows:
        """Return the masses that are neither at rest nor at the end of the time, and part with the others."""
        close = REST_WITHIN * self.rtol
        q, w = self.scene.rest if self.attracts else (np.nan, np.nan)
        rests = (some.side > 0) & (np.abs(some.w - w) <= close) & (np.abs(some.q - q) <= close * max(1.0, abs(q)))
        over = ~rests & (some.tau >= self.horizon)
        ended = rests | over
        if not ended.any():
            return some
        self._end(some.taken(rests), Outcome.AT_REST)
        self._end(some.taken(over), Outcome.FINISHED)
        return some.taken(~ended)

    # -- a step of all ---------------------------------------------------------------------------------------

    def _advance(self) -> None:
        """Take a step with every mass, or find that it must be shorter."""
        now, field = self.under_way, self.field
        left = self.horizon - now.tau
        h = np.minimum(np.minimum(now.length, _LONGEST_STEP), left)
        rise = field.rise(now.segment)
        q, w, errors = field.step(rise, now.q, now.w, now.side, now.slope, h)
        error = error_of((now.w, now.q), (w, q), errors, h, self.rtol)
        sound = error < 1
        factor = np.where(error < np.inf, _SAFETY * np.maximum(error, _TINY) ** EXPONENT, 0.0)
        longer = np.minimum(np.where(now.shortened > 0, 1.0, _MOST), factor)
        now.length[:] = h * np.where(sound, longer, np.maximum(_LEAST, factor))
        now.shortened[:] = ~sound
        now.steps += 1
        lost = (now.steps > _FEW + _RATE * (now.tau - now.since)) | self._held(now, rise, h)
        lost |= ~sound & (now.length <= 10 * np.spacing(now.tau))
        lost |= sound & (w > self.scene.w_max)
        beyond = sound & ~lost & ~(np.maximum(np.abs(q), np.abs(w)) < RUNAWAY)
        sound &= ~lost & ~beyond
        step = Step(now, h, q, w, field.slope(rise, q, w, now.side))
        aside, turns = self._sorted(step, sound)
        moves = sound & ~aside
        self.extrema.add(step, turns, moves & (now.side > 0) & ((now.w - 1) * (w - 1) < 0))
        if aside.any():
            self.aside.append(step.taken(aside))
        if beyond.any():
            self._end(now.taken(beyond), Outcome.UNBOUNDED)
        self.alone += now.row[lost].tolist()
        now.rises[turns] = 1 - now.rises[turns]
        tau = np.where(h >= left, self.horizon, now.tau + h)
        for line, values in ((now.tau, tau), (now.q, q), (now.w, w), (now.slope, step.slope)):
            line[moves] = values[moves]
        gone = aside | lost | beyond
        self.under_way = self._going_on(now.taken(~gone) if gone.any() else now)

    def _held(self, now: Rows, rise: Rise, h: FloatArray) -> BoolArray:
        """Whether stability has held steps short for long: an implicit method takes fewer."""
        self.taken += 1
        if self.taken % _SELDOM:
            return np.zeros(now.size, dtype=bool)
        decay = self.field.decay(rise, now.w)
        now.held[:] = np.where((decay > _STIFF) & (decay * h > _STABLE), now.held + _SELDOM, 0.0)
        return np.asarray(now.held > _MOST_HELD)

    def _sorted(self, step: Step, sound: BoolArray) -> tuple[BoolArray, BoolArray]:
        """Return which steps are to be looked at by themselves, and in which of the others w turns."""
        now, field = step.before, self.field
        turns = np.flatnonzero(sound & step.turns)
        low, high = field.lows[now.segment], field.highs[now.segment]
        aside = sound & np.where(now.rises > 0, step.w >= high, step.w <= low)
        flips = np.zeros(now.size, dtype=bool)
        some, low, high = step.taken(turns), low[turns], high[turns]
        up, turn = some.before.rises > 0, turn_estimated(some)[1]
        margin = _MARGIN * np.maximum(1.0, turn)
        near = np.where(up, (turn >= high - margin) | (some.w <= low), (turn <= low + margin) | (some.w >= high))
        if self.ends_at_minima:
            near |= ~up & (some.before.side > 0)
        aside[turns] = near
        # Where w' = 0, w'' = side - w whatever mu is: any other turn is an error of the integration.
        flips[turns] = ~near & ((turn < some.before.side) != up)
        return aside, flips

    # -- steps set aside -------------------------------------------------------------------------------------

    def _look_aside(self) -> None:
        """Locate, in steps set aside, the extremum of w, and then where w leaves its segment of mu."""
        step = Step.joined(self.aside)
        self.aside = []
        now, field = step.before, self.field
        low, high, rising = field.lows[now.segment], field.highs[now.segment], now.rises > 0
        t_turn, w_turn, turns = step.h.copy(), step.w.copy(), step.turns
        place = turn_located(field, step.taken(turns))
        t_turn[turns], w_turn[turns] = place.t, place.w
        turns &= (w_turn < now.side) != rising
        t_turn, w_turn = np.where(turns, t_turn, step.h), np.where(turns, w_turn, step.w)
        early = np.where(rising, w_turn >= high, w_turn <= low)  # before the turn, or where there is none
        turns &= ~early
        late = turns & np.where(rising, step.w <= low, step.w >= high)
        rising ^= turns
        lowest = turns & rising & (now.side > 0) & self.ends_at_minima
        self._end_at_minimum(now.taken(lowest), w_turn[lowest])
        left = (early | late) & ~lowest
        level = np.where(rising, high, low)
        first, last = np.where(late, t_turn, 0.0)[left], np.where(late, step.h, t_turn)[left]
        t, q, w = step.h.copy(), step.q.copy(), np.where(left, level, step.w)
        place = level_passed(field, step.taken(left), level[left], first, last, rising[left])
        t[left], q[left] = place.t, place.q

        self.extrema.turns(step.taken(turns), w_turn[turns])
        middle, between = np.where(turns, w_turn, w), np.where(turns, t_turn, t)
        self._note_passages(step, now.w, middle, np.zeros(t.size), between)
        self._note_passages(step, middle, w, between, t)
        now.rises[:] = rising
        over = ~left & (step.h >= self.horizon - now.tau)
        now.tau[:] = np.where(over, self.horizon, now.tau + t)
        now.q[:], now.w[:], now.slope[:] = q, w, step.slope
        self._go_on(now.taken(~left & ~lowest))
        back = now.taken(left & (w == 0))
        self.log.moved(back.row, back.tau, back.q, 1.0)
        self._from_belt(back.row, EventKind.CROSSES)
        self._enter(now.taken(left & (w != 0)))

    def _end_at_minimum(self, some: Rows, w: FloatArray) -> None:
        self.lowest[some.row] = w
        self.log.ended(some.row, Outcome.FINISHED)

    def _note_passages(
        self, step: Step, one: FloatArray, other: FloatArray, low: FloatArray, high: FloatArray
    ) -> None:
        """Note where x turns in stretches of steps from a slip speed to another."""
        chosen = (step.before.side > 0) & ((one - 1) * (other - 1) < 0)
        if chosen.any():
            self.extrema.passages(step.taken(chosen), low[chosen], high[chosen], (one < other)[chosen])

    def _go_on(self, some: Rows) -> None:
        self.under_way = self.under_way.joined(self._going_on(some))

    def _enter(self, some: Rows) -> None:
        """Go on from levels at which mu has a kink, or jumps: then the mass may slide at the level (Filippov)."""
        if not some.size:
            return
        field, log, rising, index = self.field, self.log, some.rises > 0, some.segment
        beyond = index + np.where(rising, 1, -1)
        onward = (field.slope(field.rise(beyond), some.q, some.w, some.side) >= 0) == rising
        slides = field.jumps[np.maximum(index, beyond)] & ~onward
        log.place(some.row, u=1 - some.side * some.w)
        turns = some.taken((some.w == 1) & (some.side > 0))  # the level is the belt's speed
        log.turn(turns.row, turns.tau, turns.q)
        some.segment = np.where(slides, np.minimum(index, beyond), beyond)
        some.slope[:] = field.slope(field.rise(some.segment), some.q, some.w, some.side)
        self._go_on(some.taken(~slides))
        self._slide(some.taken(slides))

    def _slide(self, some: Rows) -> None:
        """Slide at the slip speed of a jump, above the segment: q is a straight line, until a slope of w turns."""
        rate = 1 - some.side * some.w
        held = rate == 0  # a jump at the belt's speed holds the mass, wherever it is
        self._end(some.taken(held), Outcome.AT_REST)
        some, rate = some.taken(~held), rate[~held]
        upward = some.side * rate > 0
        if self.ends_at_minima:
            lowest = upward & (some.rises == 0) & (some.side > 0)
            self._end_at_minimum(some.taken(lowest), some.w[lowest])
            some, rate, upward = some.taken(~lowest), rate[~lowest], upward[~lowest]
        some.segment = some.segment + upward
        rise = self.field.rise(some.segment)
        # Where the slope of w on the side of the exit is 0.
        distance = -some.side * self.field.slope(rise, some.q, some.w, some.side) / rate
        left = self.horizon - some.tau
        t = np.minimum(left, np.maximum(distance, 0.0))
        some.tau[:] = np.where(t >= left, self.horizon, some.tau + t)
        some.q += rate * t
        some.rises[:] = upward
        some.slope[:] = self.field.slope(rise, some.q, some.w, some.side)
        self._go_on(some)

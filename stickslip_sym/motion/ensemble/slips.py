"""Many slips at once: all that are under way take a step, each of its own length; who ends makes room for the next.

Extrema of w are seen at the ends of a step, as for a single motion. Most are far from where anything happens, and
are located later, many at once. A step in which w may leave its segment of mu, come to 0 first of all, is set aside
with its mass, and looked at when there are many of them: then the extremum is located before the crossing, so that
a graze is neither missed nor invented.
"""

import time

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.deadline import time_left
from stickslip_sym.motion.ensemble.field import EXPONENT, Field, error_of
from stickslip_sym.motion.ensemble.locating import level_passed, turn_estimated, turn_located
from stickslip_sym.motion.ensemble.log import BACK, FORWARD, STICK, Log
from stickslip_sym.motion.ensemble.rows import Rows, Step
from stickslip_sym.motion.simulation.slip_phase import REST_WITHIN, RUNAWAY
from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome

__all__ = ["Slips"]

_ROOM = 3600  # masses under way: their stages are 0.7 MB, and a product with them is no work for threads
_MANY = 400  # steps set aside, that are looked at together
_MOST_LATER = 20_000  # extrema that wait to be located
_LONGEST_STEP = 0.25  # of dimensionless time, as in a single motion
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0
_FEW, _RATE = 500, 60  # tries of a step in a phase, and more for every unit of time: beyond, a decay holds them short
_MARGIN = 0.05  # of w, and relative, from a level: what the cubic of a step may be off
_LEVEL = 1e-13  # of the terms of w', below which it may be nothing but rounding


class Slips:
    """The motions of a log, followed up to where they come to P, end, or are given up.

    - `alone`: numbers of the starts that are given up: a decay holds explicit steps short, mu has no value on the
      way, or the law is not known so far.
    """

    def __init__(self, field: Field, log: Log, *, horizon: float, rtol: float, deadline: float) -> None:
        self.field, self.log, self.scene = field, log, field.scene
        self.horizon, self.rtol, self.deadline = horizon, rtol, deadline
        self.under_way = Rows.none()
        self.waiting: list[IntArray] = []
        self.aside: list[Step] = []
        self.later: list[tuple[Step, BoolArray]] = []  # whether w = 1 is looked for, not the turn of w
        self.alone: list[int] = []

    def follow(self) -> None:
        """Follow all motions."""
        starts = np.arange(self.log.tau.size)
        at_belt = self.log.u == 1
        self._from_belt(starts[at_belt], EventKind.START)
        slower = self.log.u < 1
        for chosen, phase in ((slower, BACK), (~slower & ~at_belt, FORWARD)):
            self.log.event(starts[chosen], phase, EventKind.START)
        self.waiting.append(starts[~at_belt])
        while True:
            if time.monotonic() > self.deadline or time_left() < 0:
                self._stop()
                return
            self._refill()
            if self.under_way.size:
                self._advance()
            if self.aside and (
                not self.under_way.size or sum(step.h.size for step in self.aside) >= _MANY
            ):
                self._look_aside()
            elif not self.under_way.size and not any(rows.size for rows in self.waiting):
                break
        self._locate_later()

    # -- from phase to phase -------------------------------------------------------------------------------

    def _from_belt(self, rows: IntArray, kind: EventKind) -> None:
        """Go on with motions that have the belt's speed: in stick, at P, or slipping on."""
        log, scene = self.log, self.scene
        q = log.q[rows]
        held = -2 * scene.eta * scene.static <= q
        sticks = held & (q < 0)
        at_onset = held & (q == 0)
        some = rows[sticks]
        log.event(some, STICK, EventKind.STICKS if kind is not EventKind.START else kind)
        end = log.tau[some] - log.q[some]
        comes = end < self.horizon
        stuck = some[~comes]
        log.moved(stuck, np.full(stuck.size, self.horizon), log.q[stuck] + (self.horizon - log.tau[stuck]), 1.0)
        log.ended(stuck, Outcome.FINISHED)
        come = some[comes]
        log.moved(come, end[comes], np.zeros(come.size), 1.0)
        log.onset[come] = end[comes]
        log.event(come, BACK, EventKind.SLIPS)
        leave = rows[at_onset]
        log.onset[leave] = log.tau[leave]
        log.event(leave, BACK, EventKind.CROSSES if kind is not EventKind.START else kind)
        on = rows[~sticks & ~at_onset]
        log.side[on] = np.where(log.q[on] >= 0, 1.0, -1.0)
        log.event(on, np.where(log.q[on] >= 0, BACK, FORWARD), EventKind.CROSSES if kind is not EventKind.START else kind)
        self.waiting.append(on)

    def _refill(self) -> None:
        """Begin as many slips as there is room for."""
        room = _ROOM - self.under_way.size
        if not self.waiting or room < min(_ROOM // 8, sum(rows.size for rows in self.waiting)):
            return
        waiting = np.concatenate(self.waiting)
        self.waiting = [waiting[room:]]
        if waiting[:room].size:
            self.under_way = self.under_way.joined(self._begun(waiting[:room]))

    def _begun(self, row: IntArray) -> Rows:
        log, scene, field = self.log, self.scene, self.field
        tau, q, side = log.tau[row], log.q[row], log.side[row]
        w = side * (1 - log.u[row])
        segment = np.searchsorted(field.lows, w, side="right") - 1
        rise = field.rise(segment)
        slope = field.slope(rise, q, w, side)
        held, risen = scene.eta * (side * scene.static - scene.onset), scene.eta * rise(w)
        terms = np.max(np.abs((held, risen, q, 2 * scene.zeta * w)), axis=0)
        level = (np.abs(slope) <= _LEVEL * terms) & (w < side)  # at a minimum of w
        rises = (w == 0) | level | (slope > 0)
        fast = np.maximum(1.0, np.maximum(np.abs(1 - side * w), np.abs(slope)))
        length = np.maximum(self.rtol**-EXPONENT / fast, 100 * np.spacing(tau))
        begun = Rows.of(row, segment, tau, q, w, slope, side, length, rises, np.zeros(row.size), tau)
        # Those that begin where mu has a kink, falling, are on the other side of it.
        odd = ~np.isfinite(slope) | (w > scene.w_max) | (~rises & (segment > 0) & (w == field.lows[segment]))
        self._give_up(row[odd])
        return begun.taken(~odd)

    def _give_up(self, rows: IntArray) -> None:
        self.alone += rows.tolist()

    def _stop(self) -> None:
        """Leave all motions where they are, as the time is up."""
        parts = [self.under_way, *(step.before for step in self.aside)]
        for some in parts:
            self.log.moved(some.row, some.tau, some.q, 1 - some.side * some.w)
        self.log.ended(np.flatnonzero((self.log.outcome < 0) & np.isnan(self.log.onset)), Outcome.TIME_LIMIT)
        self._locate_later()

    # -- a step of all ---------------------------------------------------------------------------------------

    def _advance(self) -> None:
        now, field = self.under_way, self.field
        left = self.horizon - now.tau
        h = np.minimum(np.minimum(now.length, _LONGEST_STEP), left)
        rise = field.rise(now.segment)
        q, w, errors = field.step(rise, now.q, now.w, now.side, now.slope, h)
        error = error_of((now.w, now.q), (w, q), errors, h, self.rtol)
        slope = field.slope(rise, q, w, now.side)
        sound = error < 1
        factor = np.where(error < np.inf, _SAFETY * np.maximum(error, 1e-30) ** EXPONENT, 0.0)
        on = np.where(now.shortened > 0, np.minimum(1.0, factor), np.minimum(_MOST, factor))
        now.length[:] = h * np.where(sound, on, np.maximum(_LEAST, factor))
        now.shortened[:] = ~sound
        now.steps += 1
        lost = (now.steps > _FEW + _RATE * (now.tau - now.since)) | (~sound & (now.length <= 10 * np.spacing(now.tau)))
        lost |= sound & (w > self.scene.w_max)
        beyond = sound & ~(np.maximum(np.abs(q), np.abs(w)) < RUNAWAY)
        sound &= ~lost & ~beyond
        step = Step(now, h, q, w, slope)
        turns = sound & step.turns
        aside, flips = self._sorted(step, turns, sound)
        moves = sound & ~aside
        passes = moves & (now.side > 0) & ((now.w - 1) * (w - 1) < 0)
        self._look_later(step, flips, passes)
        if aside.any():
            self.aside.append(step.taken(aside))
        now.rises[flips] = 1 - now.rises[flips]
        tau = np.where(h >= left, self.horizon, now.tau + h)
        for line, values in ((now.tau, tau), (now.q, q), (now.w, w), (now.slope, slope)):
            line[:] = np.where(moves, values, line)
        self._keep(now, ~(aside | lost | beyond), moves, lost, beyond)

    def _keep(self, now: Rows, kept: BoolArray, moves: BoolArray, lost: BoolArray, beyond: BoolArray) -> None:
        """Part with the masses that have ended."""
        rests = moves & self._rests(now)
        over = moves & ~rests & (now.tau >= self.horizon)
        for chosen, outcome in ((over, Outcome.FINISHED), (beyond, Outcome.UNBOUNDED), (rests, Outcome.AT_REST)):
            if chosen.any():
                self._end(now.taken(chosen), outcome)
        if lost.any():
            self._give_up(now.row[lost])
        kept &= ~rests & ~over
        if not kept.all():
            self.under_way = now.taken(kept)

    def _end(self, some: Rows, outcome: Outcome) -> None:
        self.log.moved(some.row, some.tau, some.q, 1 - some.side * some.w)
        self.log.ended(some.row, outcome)

    def _rests(self, now: Rows) -> BoolArray:
        """Whether masses are at the rest that attracts them, within the tolerance."""
        if not self.scene.decay(1.0) > 0:
            return np.zeros(now.size, dtype=bool)
        q, w = self.scene.rest
        close = REST_WITHIN * self.rtol
        return (now.side > 0) & (np.abs(now.w - w) <= close) & (np.abs(now.q - q) <= close * max(1.0, abs(q)))

    def _sorted(self, step: Step, turns: BoolArray, sound: BoolArray) -> tuple[BoolArray, BoolArray]:
        """Return which steps are to be looked at by themselves, and in which of the others w turns."""
        now, field = step.before, self.field
        low, high = field.lows[now.segment], field.highs[now.segment]
        aside = sound & np.where(turns, False, np.where(now.rises > 0, step.w >= high, step.w <= low))
        flips = np.zeros(now.size, dtype=bool)
        rows = np.flatnonzero(turns)
        if rows.size:
            some = step.taken(rows)
            _, turn = turn_estimated(some)
            up = some.before.rises > 0
            margin = _MARGIN * np.maximum(1.0, turn)
            near = np.where(up, (turn >= high[rows] - margin) | (some.w <= low[rows]),
                            (turn <= low[rows] + margin) | (some.w >= high[rows]))
            # Between its ends w may have passed 1, and come back.
            near |= ((some.before.w - 1) * (turn - 1) < 0) & ((some.before.w - 1) * (some.w - 1) >= 0)
            aside[rows] = near
            # Where w' = 0, w'' = side - w whatever mu is: any other turn is an error of the integration.
            flips[rows] = ~near & ((turn < some.before.side) != up)
        return aside, flips

    # -- extrema, later --------------------------------------------------------------------------------------

    def _look_later(self, step: Step, flips: BoolArray, passes: BoolArray) -> None:
        for chosen, at_one in ((flips, False), (passes, True)):
            if chosen.any():
                some = step.taken(chosen)
                self.later.append((some, np.full(some.h.size, at_one)))
        if sum(step.h.size for step, _ in self.later) > _MOST_LATER:
            self._locate_later()

    def _locate_later(self) -> None:
        if not self.later:
            return
        step, at_one = Step.joined([step for step, _ in self.later]), np.concatenate([at for _, at in self.later])
        self.later = []
        turning, passing = step.taken(~at_one), step.taken(at_one)
        self._note_turn(turning, turn_located(self.field, turning).w)
        self._note_passage(passing, np.zeros(passing.h.size), passing.h)

    def _note_turn(self, step: Step, w: FloatArray) -> None:
        self.log.place(step.before.row, u=1 - step.before.side * w)

    def _note_passage(self, step: Step, low: FloatArray, high: FloatArray) -> None:
        """Note where x turns, as w passes 1 between two times of each step."""
        if not step.h.size:
            return
        falling = step.before.w > 1
        place = level_passed(self.field, step, np.ones(step.h.size), low, high, ~falling)
        self.log.turn(step.before.row, step.before.tau + place.t, place.q)

    # -- steps set aside -------------------------------------------------------------------------------------

    def _look_aside(self) -> None:
        """Locate, in steps set aside, the extremum of w, and where it leaves its segment of mu."""
        step = Step.joined(self.aside)
        self.aside = []
        now, field = step.before, self.field
        count = now.size
        rising = now.rises > 0
        turns = step.turns
        t_turn, w_turn = step.h.copy(), step.w.copy()
        place = turn_located(field, step.taken(turns))
        t_turn[turns], w_turn[turns] = place.t, place.w
        real = turns & ((w_turn < now.side) != rising)
        t_turn, w_turn = np.where(real, t_turn, step.h), np.where(real, w_turn, step.w)
        low, high = field.lows[now.segment], field.highs[now.segment]

        def leaves(rising: BoolArray, w: FloatArray) -> BoolArray:
            return np.where(rising, w >= high, w <= low)

        before = leaves(rising, w_turn)
        after = ~before & real & leaves(~rising, step.w)
        self._note_turn(step.taken(real & ~before), w_turn[real & ~before])
        upward = np.where(after, ~rising, rising)
        level = np.where(upward, high, low)
        first, last = np.where(after, t_turn, 0.0), np.where(after, step.h, t_turn)
        left = before | after
        t, q = step.h.copy(), step.q.copy()
        some = step.taken(left)
        place = level_passed(field, some, level[left], first[left], last[left], upward[left])
        t[left], q[left] = place.t, place.q
        w = np.where(left, level, step.w)
        middle = np.where(real & ~before, w_turn, w)
        self._note_passages(step, now.w, middle, np.zeros(count), np.where(real & ~before, t_turn, t))
        self._note_passages(step, middle, w, t_turn, t)
        now.rises[:] = np.where(real & ~before, ~rising, rising)
        ends_at_horizon = ~left & (step.h >= self.horizon - now.tau)
        now.tau[:] = np.where(ends_at_horizon, self.horizon, now.tau + t)
        now.q[:], now.w[:] = q, w
        now.slope[:] = step.slope
        inner = ~left
        self._go_on(now.taken(inner))
        back = left & (w == 0)
        self._return(now.taken(back))
        kinked = left & ~back
        if kinked.any():
            self._enter(now.taken(kinked), upward[kinked])

    def _note_passages(self, step: Step, one: FloatArray, other: FloatArray, low: FloatArray, high: FloatArray) -> None:
        chosen = (step.before.side > 0) & ((one - 1) * (other - 1) < 0)
        if chosen.any():
            self._note_passage(step.taken(chosen), low[chosen], high[chosen])

    def _return(self, some: Rows) -> None:
        self.log.moved(some.row, some.tau, some.q, 1.0)
        self._from_belt(some.row, EventKind.CROSSES)

    def _go_on(self, some: Rows) -> None:
        """Let masses go on with their slips."""
        rests = self._rests(some)
        over = ~rests & (some.tau >= self.horizon)
        self._end(some.taken(rests), Outcome.AT_REST)
        self._end(some.taken(over), Outcome.FINISHED)
        self.under_way = self.under_way.joined(some.taken(~rests & ~over))

    def _enter(self, some: Rows, rising: BoolArray) -> None:
        """Go on from levels at which mu has a kink, or jumps: then the mass may slide at the level (Filippov)."""
        field, log = self.field, self.log
        index = some.segment
        beyond = index + np.where(rising, 1, -1)
        onward = (field.slope(field.rise(beyond), some.q, some.w, some.side) >= 0) == rising
        jumps = field.jumps[np.maximum(index, beyond)]
        at_rest = some.w == 1  # the level is the belt's speed, where x turns
        log.turn(some.row[at_rest & (some.side > 0)], some.tau[at_rest & (some.side > 0)], some.q[at_rest & (some.side > 0)])
        slides = jumps & ~onward
        some.segment = np.where(slides, index, beyond)
        some.slope[:] = field.slope(field.rise(some.segment), some.q, some.w, some.side)
        self._go_on(some.taken(~slides))
        if slides.any():
            self._slide(some.taken(slides), np.minimum(index, beyond)[slides])

    def _slide(self, some: Rows, lower: IntArray) -> None:
        """Slide at the slip speed of a jump: w is constant, and q a straight line, until a slope of w turns."""
        field, side = self.field, some.side
        rate = 1 - side * some.w
        held = rate == 0  # a jump at the belt's speed holds the mass, wherever it is
        self._end(some.taken(held), Outcome.AT_REST)
        some, lower, rate, side = some.taken(~held), lower[~held], rate[~held], side[~held]
        upward = side * rate > 0
        some.segment = np.where(upward, lower + 1, lower)
        rise = field.rise(some.segment)
        distance = -side * field.slope(rise, some.q, some.w, side) / rate
        t = np.minimum(self.horizon - some.tau, np.maximum(distance, 0.0))
        over = t >= self.horizon - some.tau
        some.tau[:] = np.where(over, self.horizon, some.tau + t)
        some.q += rate * t
        some.rises[:] = upward
        some.slope[:] = field.slope(rise, some.q, some.w, side)
        self._go_on(some)

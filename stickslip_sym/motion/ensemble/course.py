"""One motion as a table, in which any number of its times are looked up at once.

All that come to P go on alike, so one such table serves them all: that of the motion from P, once around where it
comes back there. The motion of a start that the steps of many do not serve is a table too.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.motion.ensemble.log import BACK, FORWARD, KINDS, OUTCOMES, PHASES, STICK, TURNS
from stickslip_sym.motion.simulation.automaton import ENDS, Slipping, Sticking
from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome

__all__ = ["Course", "Cut"]


@dataclass(frozen=True)
class Cut:
    """A motion up to some times, an entry for each.

    Attributes
    ----------
    tau, q, u, phase, outcome, lowest, highest, latest : numpy.ndarray
        As in `Log`.
    events : numpy.ndarray
        How many there were after the first.
    sticks : numpy.ndarray
        How many of these began a stick.
    rounds : numpy.ndarray
        How often it came back to P.
    turned, turns : numpy.ndarray
        How many extremes of x there were, and tau and q of the last ones, the latest first.
    """

    tau: FloatArray
    q: FloatArray
    u: FloatArray
    phase: IntArray
    outcome: IntArray
    lowest: FloatArray
    highest: FloatArray
    latest: FloatArray
    events: IntArray
    sticks: IntArray
    rounds: IntArray
    turned: IntArray
    turns: FloatArray


class Course:
    """The phases of one motion, from time 0 on.

    Parameters
    ----------
    parts : iterable of Sticking or Slipping
    from_onset : bool
        Whether it begins at P: then it is taken once around, if it comes back there.

    Attributes
    ----------
    note : str
        What kept the motion from going on; empty as a rule.
    """

    def __init__(self, parts: Iterable[Sticking | Slipping], *, from_onset: bool) -> None:
        self._parts: list[Sticking | Slipping] = []
        self._lap = 0.0  # how long it takes to come back; 0 where it does not
        for part in parts:
            if from_onset and self._parts and isinstance(self._parts[-1], Sticking):
                self._lap = part.tau  # a stick that comes to an end ends at P
                break
            self._parts.append(part)
        last = self._parts[-1]
        self._end, self._outcome, self.note = last.end, Outcome.FINISHED, ""
        if isinstance(last, Slipping) and last.phase.end in ENDS and not self._lap:
            self._outcome, self.note = ENDS[last.phase.end], str(last.phase.error or "")
        self._list_events()
        self._list_places()

    def _list_events(self) -> None:
        events, kind = list[tuple[float, float, int, int]](), EventKind.START
        for part in self._parts:
            if isinstance(part, Sticking):
                kind = EventKind.STICKS if events else kind
                events.append((part.tau, part.q, STICK, KINDS.index(kind)))
                kind = EventKind.SLIPS
            else:
                phase = BACK if part.phase.side > 0 else FORWARD
                events.append((part.tau, part.phase.start.q, phase, KINDS.index(kind)))
                kind = EventKind.CROSSES
        self._events = np.array(events).T
        if self._lap:
            self._events[3, 0] = KINDS.index(EventKind.SLIPS)
        self._sticks = np.cumsum(self._events[3] == KINDS.index(EventKind.STICKS))

    def _list_places(self) -> None:
        """List the extremes of x, and the lowest and highest q and u so far at every place where one may be."""
        turns, marks = list[tuple[float, float]](), list[tuple[float, float, float]]()
        for part in self._parts:
            if isinstance(part, Sticking):
                marks += [(part.tau, part.q, 1.0), (part.end, part.q + part.end - part.tau, 1.0)]
                continue
            phase, later = part.phase, part.later
            at_rest = phase.crossings(1.0) if phase.side > 0 else []
            turns += [(point.tau + later, point.q) for point in at_rest]
            points = [*phase.points, *phase.extrema, *at_rest]
            marks += sorted((point.tau + later, point.q, 1 - phase.side * point.w) for point in points)
        self._turns = np.array(turns).reshape(-1, 2).T
        self._times, *values = np.array(marks).T
        self._lowest = np.array([np.minimum.accumulate(line) for line in values])
        self._highest = np.array([np.maximum.accumulate(line) for line in values])

    def events(self, numbers: IntArray) -> FloatArray:
        """Return rows tau, q, phase and kind of some events, the first of which is number 0."""
        around, place = np.divmod(numbers, self._events.shape[1])
        found = self._events[:, place]
        found[0] += around * self._lap
        return found

    @property
    def first_stick(self) -> float:
        """When the mass first sticks after the start, if it does."""
        return float(self._events[0, np.argmax(self._sticks > 0)])

    def at(self, tau: FloatArray) -> Cut:
        """Return the motion up to some times."""
        # The end of a round belongs to it.
        around = np.maximum(np.ceil(tau / self._lap) - 1, 0.0) if self._lap else np.zeros(tau.size)
        part = np.clip(tau - around * self._lap, 0.0, self._end)
        ended = (
            tau - around * self._lap >= self._end if self._outcome is not Outcome.FINISHED else np.zeros(tau.size)
        )
        index = np.maximum(np.searchsorted(self._events[0], part) - 1, 0)
        q, u = self._states(part, index)
        mark = np.searchsorted(self._times, part, side="right") - 1
        mark[around > 0] = -1
        each, rounds = self._turns.shape[1], around.astype(np.intp)
        turned = rounds * each + np.searchsorted(self._turns[0], part, side="right")
        turns = np.full((2, TURNS, tau.size), np.nan)
        for back in range(TURNS if each else 0):
            number = turned - 1 - back
            laps, place = np.divmod(number, each)
            times, places = self._turns[:, place]
            turns[:, back] = np.where(number >= 0, (times + laps * self._lap, places), np.nan)
        return Cut(
            tau=around * self._lap + part,
            q=q,
            u=u,
            phase=self._events[2, index].astype(np.intp),
            outcome=np.where(ended, OUTCOMES.index(self._outcome), OUTCOMES.index(Outcome.FINISHED)),
            lowest=np.minimum(self._lowest[:, mark], (q, u)),
            highest=np.maximum(self._highest[:, mark], (q, u)),
            latest=self._latest(around, part, index),
            events=rounds * self._events.shape[1] + index,
            sticks=rounds * self._sticks[-1] + self._sticks[index],
            rounds=rounds,
            turned=turned,
            turns=turns,
        )

    def _states(self, tau: FloatArray, index: IntArray) -> tuple[FloatArray, FloatArray]:
        q, u = np.empty(tau.size), np.empty(tau.size)
        for i in np.unique(index):
            part, chosen = self._parts[i], index == i
            if isinstance(part, Sticking):
                q[chosen], u[chosen] = part.q + (tau[chosen] - part.tau), 1.0
            else:
                phase, times = part.phase, tau[chosen] - part.later
                ended = times >= phase.last.tau
                q[chosen], w = np.where(ended, [[phase.last.q], [phase.last.w]], phase.at(times))
                u[chosen] = 1 - phase.side * w
        return q, u

    def _latest(self, around: FloatArray, tau: FloatArray, index: IntArray) -> FloatArray:
        """Return when each phase was last, a row for each."""
        found = np.full((len(PHASES), tau.size), -np.inf)
        begins, ends = self._events[2], np.append(self._events[0, 1:], self._end)
        for phase in range(len(PHASES)):
            until = np.maximum.accumulate(np.where(begins == phase, ends, -np.inf))
            before = np.where(around > 0, until[-1] - self._lap, -np.inf)
            before = np.where(index > 0, np.maximum(until[index - 1], before), before)
            found[phase] = around * self._lap + np.where(begins[index] == phase, tau, before)
        return found

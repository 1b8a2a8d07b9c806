"""`ensemble`: the motions from many starts of one law in one scene."""

import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.numbers import read_array, read_rtol, real
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.ensemble.course import Course, Cut
from stickslip_sym.motion.ensemble.field import Field
from stickslip_sym.motion.ensemble.log import KINDS, OUTCOMES, PHASES, STICK, TURNS, Log
from stickslip_sym.motion.ensemble.result import Changes, Ensemble, Rounds
from stickslip_sym.motion.ensemble.slips import Slips
from stickslip_sym.motion.simulation import engines
from stickslip_sym.motion.simulation.automaton import Slipping, Sticking, parts, rest_of
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome

__all__ = ["ensemble"]


def ensemble(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    t_end: float,
    x0: ArrayLike,
    v0: ArrayLike | None = None,
    rtol: float = 1e-10,
    time_limit: float | None = None,
) -> Ensemble:
    """Integrate m x'' + c x' + k x = friction from many starts, events included, all at once.

    Every motion is the one that `simulate` finds, to the tolerance: the same steps, taken for some thousand masses
    together, with extrema of the slip speed located before crossings. All that stick go on from the same place P,
    so the motion from there is integrated once for all; its state between events, where `t_end` falls there, is as
    accurate as `Trajectory.at`. Laws with kinks, with jumps, and through measured points are served as well.

    One by one, as by `simulate`, are followed the starts whose slip decays so fast that stability holds hundreds
    of explicit steps short, those that come to where mu has no value or was not measured, and those that begin,
    slowing down, at the very slip speed of a kink: `alone` says how many. The others take less time together than
    one by one where there are twenty or more.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    t_end : float
        Duration in s, positive.
    x0, v0 : array_like
        Initial displacements in m and velocities in m/s, of one shape or such that broadcast; the belt's speed
        where no velocities are given.
    rtol : float
        Relative tolerance of a step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which motions end as they are.

    Returns
    -------
    Ensemble
        Its memory is some 500 bytes a start and 40 for every change of phase before P is reached; what a
        computation needs beside that does not depend on how many they are.

    Raises
    ------
    InputError
        For unusable numbers, or an unbound law.

    Examples
    --------
    >>> import numpy as np, stickslip_sym as ss
    >>> law, osc = ss.laws.exponential.typical(), ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    >>> found = ss.ensemble(law, osc, x0=np.linspace(-0.1, 0.1, 5), v0=0.0, t_end=20.0)
    >>> found.sticks
    array([32, 32,  0,  0, 31])
    """
    t_end = real("t_end", t_end)
    if t_end <= 0:
        raise InputError(f"t_end = {t_end:g} must be positive")
    rtol = read_rtol(rtol)
    seconds = math.inf if time_limit is None else real("time_limit", time_limit)
    if seconds <= 0:
        raise InputError(f"time_limit = {seconds:g} s must be positive")
    places, speeds = _starts(x0, osc.V if v0 is None else v0)
    scene = Scene.of(law, osc)
    run = _Run(law, osc, scene, t_end * osc.omega, rtol, time.monotonic() + seconds)
    with np.errstate(all="ignore"):  # what is not finite is a step to be taken again, or a start to be given up
        return run.of(places, speeds, t_end)


def _starts(x0: ArrayLike, v0: ArrayLike) -> tuple[FloatArray, FloatArray]:
    places, speeds = read_array("x0", x0), read_array("v0", v0)
    try:
        places, speeds = np.broadcast_arrays(places, speeds)
    except ValueError:
        raise InputError(
            f"x0 of shape {places.shape} and v0 of shape {speeds.shape} do not go together; give one v0 for each "
            "x0, or x0[:, None] and v0 for all combinations"
        ) from None
    if not places.size:
        raise InputError("x0 and v0 hold no starts; give at least one")
    return places.astype(np.float64), speeds.astype(np.float64)


@dataclass(frozen=True)
class _Run:
    """One scene, and how it is integrated."""

    law: FrictionLaw
    osc: Oscillator
    scene: Scene
    horizon: float
    rtol: float
    deadline: float

    def of(self, x0: FloatArray, v0: FloatArray, t_end: float) -> Ensemble:
        """Return what becomes of starts."""
        law, osc = self.law, self.osc
        x_onset, notes = osc.onset(law), dict[int, str]()
        log = Log((x0.ravel() - x_onset) / osc.length, v0.ravel() / osc.V)
        slips = Slips(Field(self.scene), log, horizon=self.horizon, rtol=self.rtol, deadline=self.deadline)
        slips.follow()
        own_turns = log.turns
        for row in slips.alone:
            self._follow_alone(row, log, own_turns, notes)
        events = log.events
        released, back = _released(events, x0.size)
        came = np.flatnonzero(np.isfinite(log.onset))
        course, more, sticks = None, np.zeros(x0.size, dtype=np.intp), _count(events, STICK, x0.size)
        first_stick = _first(events, STICK, x0.size)
        if came.size:
            course = self._from_onset(float(self.horizon - log.onset[came].min()))
            cut = course.at(self.horizon - log.onset[came])
            _join(log, own_turns, came, cut)
            more[came] = cut.events
            back[came] = cut.sticks > np.where(released[came], 0, 1)
            released[came] |= cut.rounds > 0
            sticks[came] += cut.sticks
            late = came[np.isnan(first_stick[came]) & (cut.sticks > 0)]
            first_stick[late] = log.onset[late] + course.first_stick
            if course.note:
                notes |= dict.fromkeys(
                    came[log.outcome[came] == OUTCOMES.index(Outcome.UNDEFINED)].tolist(), course.note
                )
        self._rest(log)
        outcome = _members(OUTCOMES, log.outcome)
        words, change = Rounds(log.latest, *own_turns, released, back).words(
            outcome, length=osc.length, rtol=self.rtol
        )
        x_min, x_max = (x_onset + osc.length * line[0] for line in (log.lowest, log.highest))
        t = np.where(log.tau >= self.horizon, t_end, log.tau / osc.omega)
        arrays = {
            "t": t,
            "x": x_onset + osc.length * log.q,
            "v": osc.V * log.u,
            "phase": _members(PHASES, log.phase),
            "outcome": outcome,
            "x_min": x_min,
            "x_max": x_max,
            "v_min": osc.V * log.lowest[1],
            "v_max": osc.V * log.highest[1],
            "changes": np.bincount(events[0].astype(np.intp), minlength=x0.size) - 1 + more,
            "sticks": sticks,
            "first_stick": first_stick / osc.omega,
            "tendency": words,
            "change": change,
        }
        return Ensemble(
            law=law,
            oscillator=osc,
            x0=x0,
            v0=v0,
            **{name: array.reshape(x0.shape) for name, array in arrays.items()},
            alone=len(slips.alone),
            notes=notes,
            _changes=Changes(events, log.onset, course, more),
        )

    def _parts(self, start: Point, horizon: float) -> Iterator[Sticking | Slipping]:
        return parts(
            self.scene, start, horizon=horizon, rtol=self.rtol, engine=engines.find("scipy"),
            max_steps=sys.maxsize, deadline=self.deadline,
        )  # fmt: skip

    def _from_onset(self, horizon: float) -> Course:
        return Course(self._parts(Point(0.0, 0.0, 0.0), horizon), from_onset=True)

    def _follow_alone(self, row: int, log: Log, turns: tuple[IntArray, FloatArray], notes: dict[int, str]) -> None:
        """Follow one start as `simulate` does."""
        log.begin_anew(row)
        try:
            start = Point(0.0, float(log.q[row]), float(1 - log.u[row]))
            course = Course(self._parts(start, self.horizon), from_onset=False)
        except StickSlipError as error:  # where mu has no value at the start
            log.ended(np.array([row]), Outcome.UNDEFINED)
            notes[row] = str(error)
            return
        cut = course.at(np.array([self.horizon]))
        log.events_are(row, course.events(np.arange(int(cut.events[0]) + 1)))
        turns[0][row], turns[1][..., row] = 0, np.nan
        log.onset[row] = 0.0
        _join(log, turns, np.array([row]), cut)
        log.onset[row] = np.nan
        if course.note:
            notes[row] = course.note

    def _rest(self, log: Log) -> None:
        """Prolong the motions that have come to rest: where rest is isolated it is known, not integrated."""
        rows = np.flatnonzero(log.outcome == OUTCOMES.index(Outcome.AT_REST))
        known = rest_of(self.scene, self.law, self.osc, Point(0.0, 0.0, 0.0))
        if known is not None:
            rest = (known - self.osc.onset(self.law)) / self.osc.length
            held = (log.u[rows] == 0) & any(branch.low == 1 for branch in self.scene.branches)
            log.moved(rows, np.full(rows.size, self.horizon), np.where(held, log.q[rows], rest), 0.0)


def _join(log: Log, own: tuple[IntArray, FloatArray], rows: IntArray, cut: Cut) -> None:
    """Add to motions what follows from P on."""
    onset = log.onset[rows]
    log.tau[rows], log.q[rows], log.u[rows], log.phase[rows] = onset + cut.tau, cut.q, cut.u, cut.phase
    log.outcome[rows] = cut.outcome
    log.lowest[:, rows] = np.minimum(log.lowest[:, rows], cut.lowest)
    log.highest[:, rows] = np.maximum(log.highest[:, rows], cut.highest)
    log.latest[:, rows] = np.maximum(log.latest[:, rows], onset + cut.latest)
    turned, turns = own
    new, before = cut.turns + np.array((1.0, 0.0))[:, None, None] * onset, turns[:, :, rows]
    for place in range(TURNS):
        earlier = np.take_along_axis(before, np.maximum(place - cut.turned, 0)[None, None], axis=1)[:, 0]
        turns[:, place, rows] = np.where(place < cut.turned, new[:, place], earlier)
    turned[rows] += cut.turned


def _released(events: FloatArray, count: int) -> tuple[BoolArray, BoolArray]:
    """Return whether static friction has given way in each motion, and whether it took hold again after that."""
    row, tau, kind = events[0].astype(np.intp), events[1], events[4]
    first = np.full(count, np.inf)
    slips, sticks = (kind == KINDS.index(one) for one in (EventKind.SLIPS, EventKind.STICKS))
    np.minimum.at(first, row[slips], tau[slips])
    back = np.zeros(count, dtype=bool)
    back[row[sticks & (tau > first[row])]] = True
    return np.isfinite(first), back


def _count(events: FloatArray, phase: int, count: int) -> IntArray:
    return np.bincount(events[0, events[3] == phase].astype(np.intp), minlength=count)


def _first(events: FloatArray, phase: int, count: int) -> FloatArray:
    """Return when a phase first began in each motion; NaN where it never did."""
    found, chosen = np.full(count, np.nan), events[3] == phase
    np.fmin.at(found, events[0, chosen].astype(np.intp), events[1, chosen])
    return found


def _members(members: Sequence[Enum], places: IntArray) -> ObjectArray:
    return np.array([*members, None], dtype=object)[places]

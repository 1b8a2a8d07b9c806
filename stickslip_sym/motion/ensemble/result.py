"""`Ensemble`: what became of many starts."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.ensemble.course import Course
from stickslip_sym.motion.ensemble.log import KINDS, PHASES
from stickslip_sym.motion.simulation.tendency import word
from stickslip_sym.motion.simulation.trajectory import Event, Phase, Tendency
from stickslip_sym.output import files, markup

__all__ = ["Changes", "Ensemble", "Rounds"]


@dataclass(frozen=True)
class Changes:
    """The changes of phase of all motions, free of units: those of each, and for those that came to P the rest.

    - `own`: rows number of the start, tau, q, phase and kind, in order of start and time.
    - `onset`: when each motion came to P; NaN if it did not.
    - `course`: the motion from P, None if none came there, and `more`: how many of its events each motion has.
    """

    own: FloatArray
    onset: FloatArray
    course: Course | None
    more: IntArray

    def all(self) -> FloatArray:
        """Return rows as `own` has them, of all changes."""
        rows = np.repeat(np.arange(self.more.size), self.more)
        if self.course is None or not rows.size:
            return self.own
        number = np.arange(rows.size) - np.repeat(np.cumsum(self.more) - self.more, self.more) + 1
        found = np.concatenate((rows[None].astype(np.float64), self.course.events(number)))
        found[1] += self.onset[rows]
        both = np.concatenate((self.own, found), axis=1)
        return both[:, np.argsort(both[0], kind="stable")]

    def of(self, start: int) -> FloatArray:
        """Return rows tau, q, phase and kind of the changes of one motion."""
        low, high = np.searchsorted(self.own[0], (start, start + 1))
        own = self.own[1:, low:high]
        if self.course is None or not self.more[start]:
            return own
        found = self.course.events(np.arange(1, int(self.more[start]) + 1))
        found[0] += self.onset[start]
        return np.concatenate((own, found), axis=1)


@dataclass(frozen=True)
class Rounds:
    """What is to be said of the last rounds of all motions: arguments of `tendency.word`, an entry for each."""

    latest: FloatArray
    turned: IntArray
    turns: FloatArray
    released: BoolArray
    back: BoolArray

    def words(self, outcomes: ObjectArray, *, length: float, rtol: float) -> tuple[ObjectArray, FloatArray]:
        """Return what each motion has come to, and the relative change of its swing, NaN where it has none."""
        since = np.where(self.turned > 2, self.turns[0, 2], -np.inf)
        lately = (self.latest > since).T.tolist()
        swings = np.abs(np.diff(length * self.turns[1, ::-1], axis=0)).T.tolist()
        words, changes = np.empty(len(lately), dtype=object), np.full(len(lately), np.nan)
        for i, phases in enumerate(lately):
            words[i], change = word(
                outcomes[i],
                {phase for phase, late in zip(PHASES, phases, strict=True) if late},
                released=bool(self.released[i]),
                back=bool(self.back[i]),
                swings=swings[i] if self.turned[i] >= 4 else None,
                length=length,
                rtol=rtol,
            )
            changes[i] = np.nan if change is None else change
        return words, changes


@dataclass(frozen=True, repr=False)
class Ensemble:
    """What became of many starts; every array has the shape of the starts.

    Attributes
    ----------
    law : FrictionLaw
    oscillator : Oscillator
    x0, v0 : numpy.ndarray
        Initial displacements in m and velocities in m/s.
    t, x, v : numpy.ndarray
        Where each motion ended: time in s, displacement in m, velocity in m/s.
    phase : numpy.ndarray of Phase
        The phase in which it ended.
    outcome : numpy.ndarray of Outcome
        Whether `t_end` was reached; else the motion is what was computed so far.
    x_min, x_max, v_min, v_max : numpy.ndarray
        The extremes of the whole motion, as exact as its events.
    changes : numpy.ndarray of int
        How many changes of phase it had.
    sticks : numpy.ndarray of int
        How often the mass came to stick.
    first_stick : numpy.ndarray
        When it first stuck, in s; NaN if it never did.
    tendency : numpy.ndarray of Tendency
        What the motion has come to in its last rounds, as for a `Trajectory`; `basin_map` says where starts lead.
    change : numpy.ndarray
        Where it only slips: the relative change of the swing of x in its last round; else NaN.
    alone : int
        How many starts were simulated one by one.
    notes : dict of int to str
        By number of the start, counted as in a flat array: why a motion does not go on.
    """

    law: FrictionLaw
    oscillator: Oscillator
    x0: FloatArray
    v0: FloatArray
    t: FloatArray
    x: FloatArray
    v: FloatArray
    phase: ObjectArray
    outcome: ObjectArray
    x_min: FloatArray
    x_max: FloatArray
    v_min: FloatArray
    v_max: FloatArray
    changes: IntArray
    sticks: IntArray
    first_stick: FloatArray
    tendency: ObjectArray
    change: FloatArray
    alone: int
    notes: dict[int, str]
    _changes: Changes

    def events_of(self, start: int) -> tuple[Event, ...]:
        """Return the events of one motion, as `Trajectory.events` has them.

        Parameters
        ----------
        start : int
            Number of the start, counted as in a flat array.

        Raises
        ------
        InputError
            If there is no such start.
        """
        if not isinstance(start, int | np.integer) or not 0 <= start < self.x0.size:
            raise InputError(f"start = {start} is none of the {self.x0.size} starts, which are counted from 0")
        tau, q, phase, kind = self._changes.of(start)
        osc, first = self.oscillator, float(self.v0.flat[start])
        x = osc.onset(self.law) + osc.length * q
        lines = zip((tau / osc.omega).tolist(), x.tolist(), phase.tolist(), kind.tolist(), strict=True)
        events = [
            Event(t, place, first if i == 0 else osc.V, PHASES[int(begins)], KINDS[int(what)])
            for i, (t, place, begins, what) in enumerate(lines)
        ]
        return tuple(events)

    def starts_of(self, phase: Phase) -> tuple[IntArray, FloatArray]:
        """Return when a phase began, in all motions: numbers of the starts, and times in s, in this order."""
        found = self._changes.all()
        found = found[:, found[3] == PHASES.index(phase)]
        return found[0].astype(np.intp), found[1] / self.oscillator.omega

    def count(self) -> dict[Tendency, int]:
        """Return how many motions have come to what."""
        return {word: n for word in Tendency if (n := int((self.tendency == word).sum()))}

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {word.value}" for word, n in self.count().items())
        alone = f"; {self.alone} simulated one by one" if self.alone else ""
        return f"Ensemble: {self.x0.size} starts to t = {self.t.max():.6g} s; {counts}{alone}"

    def _repr_html_(self) -> str:
        rows = [[word.value, str(n)] for word, n in self.count().items()]
        return markup.block(repr(self), markup.table(["come to", "starts"], rows))

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each start, with units in the header.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        units = {"x0": "m", "v0": "m/s", "t": "s", "x": "m", "v": "m/s", "x_min": "m", "x_max": "m"}
        units |= {"v_min": "m/s", "v_max": "m/s", "first_stick": "s"}
        columns: dict[str, ArrayLike] = {f"{name} ({unit})": getattr(self, name) for name, unit in units.items()}
        columns |= {"changes": self.changes, "sticks": self.sticks}
        columns |= {"outcome": files.texts(self.outcome), "tendency": files.texts(self.tendency)}
        files.write_csv(Path(path), columns)

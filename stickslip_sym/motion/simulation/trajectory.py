"""What simulations give: `Trajectory`, a motion with its events and its course, and the ends of many motions."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import SAME, read_array
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.slip import SAME_AMPLITUDE
from stickslip_sym.output import files
from stickslip_sym.output.data import DataResult, TableResult
from stickslip_sym.output.shown import Shown, views_of

if TYPE_CHECKING:
    from stickslip_sym.output.shown import Axes, Figure

_DENSE = 8  # points of a smooth curve for each step of an integration


class Phase(Enum):
    """What the contact does."""

    STICK = "stick"
    SLIP_BACK = "slip, slower than the belt"
    SLIP_FORWARD = "slip, faster than the belt"


class EventKind(Enum):
    """What happens at an event."""

    START = "start"
    STICKS = "slip ends in stick"
    SLIPS = "static friction gives way"
    CROSSES = "passes the belt's speed without sticking"


class Outcome(Enum):
    """How a simulation ended."""

    FINISHED = "finished"
    AT_REST = "at rest"
    STEP_LIMIT = "step limit"
    TIME_LIMIT = "time limit"
    UNBOUNDED = "grows without bound"
    UNDEFINED = "mu has no value there"


_DECIDED = {Outcome.AT_REST: Motion.REST, Outcome.UNBOUNDED: Motion.UNBOUNDED}


@dataclass(frozen=True)
class Event(DataResult):
    """A change of phase: the time in s, the state in m and m/s, the phase that begins, and how it comes about."""

    t: float
    x: float
    v: float
    begins: Phase
    kind: EventKind


class State(NamedTuple):
    """Displacement in m, velocity in m/s and phase, each an array of the shape of the times."""

    x: FloatArray
    v: FloatArray
    phase: ObjectArray


@dataclass(frozen=True)
class Stretch(DataResult):
    """One phase of a motion.

    - `samples`: rows of t in s, x in m and v in m/s, at the integrator's steps.
    - `curve`: the rows x and v at a row of times; without it x is a straight line, as in stick and at rest.
    """

    reported = ("phase", "samples")

    phase: Phase
    samples: FloatArray
    curve: Callable[[FloatArray], FloatArray] | None = None

    @property
    def start(self) -> float:
        """When it begins, in s."""
        return float(self.samples[0, 0])

    @property
    def end(self) -> float:
        """When it ends, in s."""
        return float(self.samples[0, -1])

    def course(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x and v at times within."""
        if self.curve is not None:
            x, v = self.curve(np.ravel(t))
            return x.reshape(np.shape(t)), v.reshape(np.shape(t))
        times, *state = self.samples
        x, v = (np.interp(t, times, row) for row in state)
        return x, v


@dataclass(frozen=True, repr=False, eq=False)
class Trajectory(Shown, TableResult, by_identity=True):
    """A motion of the mass.

    Attributes
    ----------
    oscillator : Oscillator
    rtol : float
        Relative tolerance of a step.
    stretches : tuple of Stretch
        The phases in order, as functions of time.
    outcome : Outcome
        Whether the end was reached; else the trajectory is what was computed so far.
    note : str
        What kept the motion from going on, and what to try; empty as a rule.
    """

    reported = ("motion", "change", "outcome", "note", "events")

    oscillator: Oscillator
    rtol: float
    stretches: tuple[Stretch, ...]
    outcome: Outcome
    note: str = ""

    @property
    def t(self) -> FloatArray:
        """Times in s, ascending, at the integrator's steps and at every event."""
        return np.asarray(self._samples[0])

    @property
    def x(self) -> FloatArray:
        """Displacement in m at these times."""
        return np.asarray(self._samples[1])

    @property
    def v(self) -> FloatArray:
        """Velocity in m/s at these times."""
        return np.asarray(self._samples[2])

    @cached_property
    def _samples(self) -> FloatArray:
        return np.concatenate([stretch.samples for stretch in self.stretches], axis=1)

    @cached_property
    def phase(self) -> ObjectArray:
        """The phase in which each sample lies; one at an event belongs to the phase that ends there."""
        phases = np.array([stretch.phase for stretch in self.stretches], dtype=object)
        return np.repeat(phases, [stretch.samples.shape[1] for stretch in self.stretches])

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """The changes of phase, of which the first is the start; the rest to which a motion comes is none."""
        events = list[Event]()
        for stretch in self.stretches[:-1] if self.outcome is Outcome.AT_REST else self.stretches:
            kind = EventKind.CROSSES
            if events and events[-1].begins is Phase.STICK:
                kind = EventKind.SLIPS
            if stretch.phase is Phase.STICK:
                kind = EventKind.STICKS
            t, x, v = stretch.samples[:, 0].tolist()
            events.append(Event(t, x, v, stretch.phase, kind if events else EventKind.START))
        return tuple(events)

    @cached_property
    def motion(self) -> Motion:
        """What the motion has come to in its last rounds; not where it leads later, which `classify` says."""
        # A round goes from one extreme of x to the next but one.
        if self.outcome in _DECIDED:
            return _DECIDED[self.outcome]
        turns, _ = self._turns
        since = turns[-3] if len(turns) > 2 else -np.inf
        lately = {stretch.phase for stretch in self.stretches if stretch.end > since}
        kinds = [event.kind for event in self.events]
        if lately == {Phase.STICK} and EventKind.SLIPS not in kinds:
            return Motion.STICK
        if Phase.STICK in lately:
            # Every stick ends at P, so a mass that comes back to stick does so for ever.
            back = EventKind.SLIPS in kinds and EventKind.STICKS in kinds[kinds.index(EventKind.SLIPS) :]
            return Motion.STICK_SLIP if back else Motion.UNDECIDED
        if self.change is None:
            return Motion.REST if self._is_still else Motion.UNDECIDED
        if Phase.SLIP_FORWARD in lately:
            return Motion.OVERTAKING
        if abs(self.change) <= ADDED * self.rtol:  # it repeats itself within the errors of the steps
            return Motion.PURE_SLIP
        return Motion.SHRINKING if self.change < 0 else Motion.GROWING

    @cached_property
    def change(self) -> float | None:
        """The relative change of the swing of x in the last round, where the mass only slips; else None."""
        turns, _ = self._turns
        if self.outcome in _DECIDED or len(turns) < 4 or self._is_still:
            return None
        if any(stretch.phase is Phase.STICK and stretch.end > turns[-3] for stretch in self.stretches):
            return None
        before, _, now = self._swings
        return float(now / before - 1)

    @cached_property
    def _turns(self) -> FloatArray:
        """The last four times at most at which v changes its sign, and x there.

        A step of the integrator ends where v = 0; between samples of any other motion the root is sought.
        """
        moving = np.flatnonzero(self.v)
        signs = np.sign(self.v[moving])
        last = np.flatnonzero(signs[:-1] != signs[1:])[-4:]
        turns = list[tuple[float, float]]()
        for before, after in zip(moving[last].tolist(), moving[last + 1].tolist(), strict=True):
            t = float(self.t[before + 1])
            x = float(self.x[before + 1])
            if after == before + 1:
                t = brentq(lambda t: float(self.at(t).v), self.t[before], self.t[after])
                x = float(self.at(t).x)
            turns.append((t, x))
        return np.reshape(turns, (-1, 2)).T

    @property
    def _swings(self) -> FloatArray:
        return np.asarray(np.abs(np.diff(self._turns[1])))

    @property
    def _is_still(self) -> bool:
        """Whether the last swings of x are too small to be a motion."""
        if self._turns.shape[1] == 4:
            ends = self._swings[[0, -1]]
        else:
            ends = np.array([math.inf])
        return bool(ends.min() == 0 or ends.max() <= SAME_AMPLITUDE * self.oscillator.length)

    @property
    def summary(self) -> str:
        """What the motion is, in a few words."""
        if self.change is None:
            return self.motion.value
        if self.motion is Motion.PURE_SLIP:
            return f"{self.motion.value}, the same within {100 * ADDED * self.rtol:.2g} % a round"
        if self.motion is Motion.OVERTAKING:
            return f"{self.motion.value}, {100 * self.change:+.2g} % a round"
        return f"{self.motion.value} by {100 * abs(self.change):.2g} % a round"

    def __repr__(self) -> str:
        return views_of(self).one_line(self)

    def starts_of(self, phase: Phase) -> FloatArray:
        """Return the times at which a phase began."""
        return np.array([event.t for event in self.events if event.begins is phase])

    def at(self, t: ArrayLike) -> State:
        """Return the state at any times of the motion.

        Stick is exact, and slip as accurate as the samples: a state between two of them is one shorter step.

        Parameters
        ----------
        t : float or array
            Times in s. At an event the state is that of the phase that ends there.

        Raises
        ------
        InputError
            For a time that is no number, or before the start, or after the end of what was computed.
        """
        times = read_array("t", t, finite=False)
        first = float(self.t[0])
        last = float(self.t[-1])
        slack = SAME * (last - first)
        wrong = ~((times >= first - slack) & (times <= last + slack))
        if wrong.any():
            advice = self.note or "simulate with a larger t_end or limit"
            raise InputError(
                f"t = {times[wrong].flat[0]:g} s is outside the motion, which was computed from {first:g} s to "
                f"{last:g} s ({self.outcome.value}); {advice}"
            )
        times = np.clip(times, first, last)
        index = np.searchsorted([stretch.end for stretch in self.stretches], times)
        x = np.empty(times.shape)
        v = np.empty(times.shape)
        phase = np.empty(times.shape, dtype=object)
        for i in np.unique(index):
            chosen = index == i
            x[chosen], v[chosen] = self.stretches[i].course(times[chosen])
            phase[chosen] = self.stretches[i].phase
        return State(x, v, phase)

    def _table_columns(self) -> dict[str, Any]:
        return {"t": self.t, "x": self.x, "v": self.v, "phase": [phase.value for phase in self.phase]}

    def to_csv(self, path: str | Path, t: ArrayLike | None = None) -> None:
        """Write times, displacements, velocities and phases to a file, with units in its header.

        Parameters
        ----------
        path : str or Path
        t : array, optional
            Times in s; those of the samples if not given.

        Raises
        ------
        InputError
            For times outside the motion, or a file that cannot be written.
        """
        times = self.t if t is None else np.atleast_1d(t)
        if t is None:
            state = State(self.x, self.v, self.phase)
        else:
            state = self.at(times)
        numbers = {"t (s)": np.asarray(times, dtype=np.float64), "x (m)": state.x, "v (m/s)": state.v}
        phases = np.array([phase.name.lower() for phase in state.phase])
        files.write_csv(Path(path), numbers | {"phase": phases})

    def draw(self, ax: "Axes", x: str = "t", y: str = "v", *, since: float = -math.inf) -> None:
        """Draw two of t, x and v over each other, with stick and slip in different styles."""
        views_of(self).draw(self, ax, x, y, since=since)

    def plot(
        self, path: str | Path | None = None, *, since: float | None = None, ax: "Axes | None" = None
    ) -> "Figure":
        """Draw the time history and the phase plane, with stick and slip in different styles.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to, as for `Drawn.plot`; so is what is returned and raised.
        since : float, optional
            Time in s; what came before is left out.
        ax : matplotlib.axes.Axes, optional
            Axes of a figure of your own, for the velocity over time alone.
        """
        return views_of(self).plot(self, path, ax, since=since)


@dataclass(frozen=True, repr=False)
class Trajectories(Shown, TableResult):
    """What became of many initial conditions; every array has their shape.

    Attributes
    ----------
    law : FrictionLaw
    oscillator : Oscillator
    t_end : float
        Duration in s.
    rtol : float
        Relative tolerance of a step.
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
    """

    law: FrictionLaw
    oscillator: Oscillator
    t_end: float
    rtol: float
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

    def __len__(self) -> int:
        return self.x0.size

    def count(self) -> dict[str, int]:
        """Return how many motions stick, slip, came to rest, or ended otherwise."""
        done = self.outcome == Outcome.FINISHED
        numbers = {
            "stick": int((done & (self.sticks > 0)).sum()),
            "only slip": int((done & (self.sticks == 0)).sum()),
        }
        numbers |= {
            outcome.value: int((self.outcome == outcome).sum())
            for outcome in Outcome
            if outcome is not Outcome.FINISHED
        }
        return {word: number for word, number in numbers.items() if number}

    def __repr__(self) -> str:
        counts = ", ".join(f"{number} {word}" for word, number in self.count().items())
        return f"Trajectories: {len(self)} initial conditions to t = {self.t.max():.6g} s; {counts}"

    def _table_columns(self) -> dict[str, Any]:
        numbers = "x0", "v0", "t", "x", "v", "x_min", "x_max", "v_min", "v_max", "first_stick", "changes", "sticks"
        columns = {name: np.ravel(getattr(self, name)) for name in numbers}
        return {**columns, "outcome": np.ravel(files.texts(self.outcome))}

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each initial condition, with units in the header.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        units = {"x0": "m", "v0": "m/s", "t": "s", "x": "m", "v": "m/s", "x_min": "m", "x_max": "m"}
        units |= {"v_min": "m/s", "v_max": "m/s", "first_stick": "s"}
        columns: dict[str, ArrayLike] = {f"{name} ({unit})": getattr(self, name) for name, unit in units.items()}
        columns |= {"changes": self.changes, "sticks": self.sticks, "outcome": files.texts(self.outcome)}
        files.write_csv(Path(path), columns)


def dense(ends: FloatArray) -> FloatArray:
    """Return places between the ends of steps, dense enough for a smooth curve."""
    return np.interp(np.arange(_DENSE * (ends.size - 1) + 1) / _DENSE, np.arange(ends.size), ends)

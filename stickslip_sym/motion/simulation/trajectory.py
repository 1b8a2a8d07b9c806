"""`Trajectory`: a motion of the mass, its events, and its course between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.motion import Motion
from stickslip_sym.output import drawing, files, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Course", "Event", "EventKind", "Outcome", "Phase", "State", "Straight", "Stretch", "Trajectory"]

_ROUNDING = 1e-12  # of the duration, by which a time may lie outside it
_SAME = 1e-6  # relative change of a swing in a round, up to which a motion repeats itself
_STEPS = 100  # errors of a step that may add up in a round
_STILL = 1e-9  # m for each m that the belt moves in 1/omega: a smaller swing is rest
_SHOWN = 3000  # steps in the picture of a notebook, some hundred rounds; more take seconds to draw


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
class Event:
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


Course = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""x and v as functions of time."""


@dataclass(frozen=True)
class Stretch:
    """One phase of a motion, from `start` to `end` in s; `course` gives x and v at times within."""

    phase: Phase
    start: float
    end: float
    course: Course


@dataclass(frozen=True)
class Straight:
    """The course of a mass that moves with one velocity from a time and place on: in stick, or at rest."""

    t: float
    x: float
    v: float

    def __call__(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return x and v at times."""
        return self.x + self.v * (t - self.t), np.full(t.shape, self.v)


@dataclass(frozen=True)
class Trajectory:
    """A motion of the mass.

    Attributes
    ----------
    oscillator : Oscillator
    rtol : float
        Relative tolerance of a step.
    t : numpy.ndarray
        Times in s, ascending, at the integrator's steps and at every event.
    x, v : numpy.ndarray
        Displacement in m and velocity in m/s at these times.
    phase : numpy.ndarray of Phase
        The phase in which each sample lies; a sample at an event belongs to the phase that ends there.
    events : tuple of Event
    outcome : Outcome
        Whether the end was reached; else the trajectory is what was computed so far.
    stretches : tuple of Stretch
        The phases in order, as functions of time.
    note : str
        What kept the motion from going on, and what to try; empty as a rule.
    """

    oscillator: Oscillator
    rtol: float
    t: FloatArray
    x: FloatArray
    v: FloatArray
    phase: ObjectArray
    events: tuple[Event, ...]
    outcome: Outcome
    stretches: tuple[Stretch, ...]
    note: str = ""

    @classmethod
    def of(
        cls,
        osc: Oscillator,
        rtol: float,
        parts: Sequence[tuple[Stretch, FloatArray]],
        outcome: Outcome,
        note: str = "",
    ) -> "Trajectory":
        """Return the motion that stretches make up, each with its samples as rows t, x and v.

        Each begins with an event, but for the rest to which a motion comes at last.
        """
        events = list[Event]()
        for stretch, samples in parts[:-1] if outcome is Outcome.AT_REST else parts:
            kind = EventKind.SLIPS if events and events[-1].begins is Phase.STICK else EventKind.CROSSES
            kind = EventKind.STICKS if stretch.phase is Phase.STICK else kind
            t, x, v = samples[:, 0].tolist()
            events.append(Event(t, x, v, stretch.phase, kind if events else EventKind.START))
        stretches = tuple(stretch for stretch, _ in parts)
        t, x, v = np.concatenate([samples for _, samples in parts], axis=1)
        kinds = np.empty(len(parts), dtype=object)
        kinds[:] = [stretch.phase for stretch in stretches]
        phase = np.repeat(kinds, [samples.shape[1] for _, samples in parts])
        return cls(osc, rtol, t, x, v, phase, tuple(events), outcome, stretches, note)

    @cached_property
    def motion(self) -> Motion:
        """What the motion has come to in its last rounds; not where it leads later, which `classify` says."""
        # A round goes from one extreme of x to the next but one.
        if self.outcome in _DECIDED:
            return _DECIDED[self.outcome]
        since = self._turns[-3] if len(self._turns) > 2 else -np.inf
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
        if abs(self.change) <= max(_SAME, _STEPS * self.rtol):
            return Motion.PURE_SLIP
        return Motion.SHRINKING if self.change < 0 else Motion.GROWING

    @cached_property
    def change(self) -> float | None:
        """The relative change of the swing of x in the last round, where the mass only slips; else None."""
        if self.outcome in _DECIDED or len(self._turns) < 4 or self._is_still:
            return None
        if any(stretch.phase is Phase.STICK and stretch.end > self._turns[-3] for stretch in self.stretches):
            return None
        return self._swings[2] / self._swings[0] - 1

    @cached_property
    def _turns(self) -> list[float]:
        """The last four times at most at which v changes its sign."""
        moving = np.flatnonzero(self.v)
        signs = np.sign(self.v[moving])
        places = np.flatnonzero(signs[:-1] != signs[1:])[-4:]
        brackets = [(float(self.t[moving[i]]), float(self.t[moving[i + 1]])) for i in places]
        return [float(brentq(lambda t: float(self.at(t).v), low, high)) for low, high in brackets]

    @property
    def _swings(self) -> list[float]:
        swings: list[float] = np.abs(np.diff(self.at(self._turns).x)).tolist()
        return swings

    @property
    def _is_still(self) -> bool:
        """Whether the last swings of x are too small to be a motion."""
        if len(self._turns) < 4:
            return False
        before, _, now = self._swings
        return min(before, now) == 0 or max(before, now) <= _STILL * self.oscillator.length

    @property
    def summary(self) -> str:
        """What the motion is, in a few words."""
        if self.change is None or self.motion is Motion.PURE_SLIP:
            return self.motion.value
        if self.motion is Motion.OVERTAKING:
            return f"{self.motion.value}, {100 * self.change:+.2g} % a round"
        return f"{self.motion.value} by {100 * abs(self.change):.2g} % a round"

    def __repr__(self) -> str:
        return (
            f"Trajectory: {self.summary}; {len(self.t)} samples from t = {self.t[0]:.6g} to {self.t[-1]:.6g} s, "
            f"x from {self.x.min():.6g} to {self.x.max():.6g} m, v from {self.v.min():.6g} to "
            f"{self.v.max():.6g} m/s, {len(self.events)} changes of phase, {self.outcome.value}"
        )

    def _repr_html_(self) -> str:
        rows = [
            ["..."] * 4
            if event is None
            else [f"{event.t:.9g}", f"{event.x:.9g}", f"{event.v:.9g}", event.begins.value]
            for event in markup.shortened(self.events)
        ]
        since = float(self.t[max(self.t.size - _SHOWN, 0)])
        picture = drawing.picture(lambda: self.plot(since=since), self.summary)
        cut = [] if since == self.t[0] or not picture else [f"The picture begins at t = {since:.6g} s."]
        table = markup.table(["t in s", "x in m", "v in m/s", "begins"], rows)
        return markup.block(repr(self), picture, *cut, table)

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
        try:
            times = np.asarray(t, dtype=np.float64)
        except (TypeError, ValueError):
            raise InputError(f"t = {str(t)[:60]!r} is not a time in s; give a float or an array") from None
        first, last = float(self.t[0]), float(self.t[-1])
        slack = _ROUNDING * (last - first)
        wrong = ~((times >= first - slack) & (times <= last + slack))
        if wrong.any():
            advice = self.note or "simulate with a larger t_end or limit"
            raise InputError(
                f"t = {times[wrong].flat[0]:g} s is outside the motion, which was computed from {first:g} s to "
                f"{last:g} s ({self.outcome.value}); {advice}"
            )
        times = np.clip(times, first, last)
        index = np.searchsorted([stretch.end for stretch in self.stretches], times)
        x, v, phase = np.empty(times.shape), np.empty(times.shape), np.empty(times.shape, dtype=object)
        for i in np.unique(index):
            chosen = index == i
            x[chosen], v[chosen] = self.stretches[i].course(times[chosen])
            phase[chosen] = self.stretches[i].phase
        return State(x, v, phase)

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
        state = State(self.x, self.v, self.phase) if t is None else self.at(times)
        numbers = {"t (s)": np.asarray(times, dtype=np.float64), "x (m)": state.x, "v (m/s)": state.v}
        phases = np.array([phase.name.lower() for phase in state.phase])
        files.write_csv(Path(path), numbers | {"phase": phases})

    def plot(self, path: str | Path | None = None, *, since: float | None = None) -> "Figure":
        """Draw the time history and the phase plane, stick and slip told apart.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to, as for `Drawn.plot`; so is what is returned and raised.
        since : float, optional
            Time in s; what came before is left out.
        """
        drawing.require_matplotlib()
        from matplotlib.figure import Figure

        figure = Figure(figsize=(8.4, 4.2), layout="constrained")
        panels = figure.subplot_mosaic("xp;vp", width_ratios=(3, 2))
        panels["x"].sharex(panels["v"])
        for phase, style in _STYLES.items():
            t, x, v = self._drawn(phase, self.t[0] if since is None else since)
            if t.size:
                panels["x"].plot(t, x, **style)
                panels["v"].plot(t, v, **style)
                panels["p"].plot(x, v, label=phase.value, **style)
        panels["x"].set(ylabel="displacement $x$ (m)")
        panels["x"].tick_params(labelbottom=False)
        panels["v"].set(xlabel="time $t$ (s)", ylabel="velocity $\\dot x$ (m/s)")
        panels["p"].locator_params(axis="x", nbins=5)
        panels["p"].set(xlabel="displacement $x$ (m)", ylabel="velocity $\\dot x$ (m/s)")
        for panel in panels.values():
            panel.grid(alpha=0.25)
        figure.align_ylabels([panels["x"], panels["v"]])
        figure.legend(loc="outside upper center", ncols=len(_STYLES), frameon=False)
        if path is not None:
            drawing.save(figure, Path(path))
        return figure

    def _drawn(self, phase: Phase, since: float) -> FloatArray:
        """Return t, x and v of all stretches of a phase that end after a time, with NaN between two of them."""
        parts = [np.empty((3, 0))]
        for stretch in self.stretches:
            if stretch.phase is phase and stretch.end > since:
                first = np.searchsorted(self.t, max(stretch.start, since), side="right")
                inner = self.t[first : np.searchsorted(self.t, stretch.end)]
                ends = np.array([max(stretch.start, since), *inner, stretch.end])
                t = drawing.dense(ends)
                parts += [np.array((t, *stretch.course(t))), np.full((3, 1), np.nan)]
        return np.concatenate(parts, axis=1)


_STYLES: dict[Phase, dict[str, Any]] = {
    Phase.STICK: {"color": "black", "linewidth": 2.6},
    Phase.SLIP_BACK: {"color": "tab:blue", "linewidth": 1.1},
    Phase.SLIP_FORWARD: {"color": "tab:orange", "linewidth": 1.4, "linestyle": (0, (3, 1))},
}
"""In grey they are told apart by weight and by dashes."""

"""What is noted of many motions while they go on: where each one is, how it ended, its extremes and its events."""

import numpy as np

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.motion.simulation.trajectory import EventKind, Outcome, Phase

__all__ = ["BACK", "FORWARD", "KINDS", "OUTCOMES", "PHASES", "STICK", "TURNS", "Log"]

PHASES, KINDS, OUTCOMES = tuple(Phase), tuple(EventKind), tuple(Outcome)
"""Their places are what is noted."""
STICK, BACK, FORWARD = (PHASES.index(phase) for phase in (Phase.STICK, Phase.SLIP_BACK, Phase.SLIP_FORWARD))
TURNS = 4
"""How many of the last extremes of x are kept."""

_MOST = 200_000  # extremes of x on the list, before it is shortened to what is kept


class Log:
    """Notes on the motions from many starts, free of units; every array has an entry for each start.

    Attributes
    ----------
    tau, q, u : numpy.ndarray
        Time, displacement, and velocity over the belt's: where the motion is, in the end where it ended.
    side : numpy.ndarray
        Of the slip that goes on or begins, 1 or -1.
    phase, outcome : numpy.ndarray
        Places in `PHASES` and `OUTCOMES`; the outcome is -1 until there is one.
    onset : numpy.ndarray
        When the motion came to P, from where on all are one; NaN if it has not.
    lowest, highest : numpy.ndarray
        Extremes of q and u, two rows.
    latest : numpy.ndarray
        When each phase was last, a row for each of `PHASES`; -infinity where it never was.
    """

    def __init__(self, q: FloatArray, u: FloatArray) -> None:
        count = q.size
        self._start = q, u
        self.tau, self.q, self.u, self.side = np.zeros(count), q.copy(), u.copy(), np.where(u < 1, 1.0, -1.0)
        self.phase, self.outcome = np.full(count, BACK), np.full(count, -1)
        self.onset = np.full(count, np.nan)
        self.lowest, self.highest = np.array((q, u)), np.array((q, u))
        self.latest = np.full((len(PHASES), count), -np.inf)
        self._events: list[FloatArray] = []
        self._anew: dict[int, FloatArray] = {}  # all events of the motions that began anew
        self._turns: list[FloatArray] = []
        self._listed = 0

    def place(self, rows: IntArray, q: FloatArray | None = None, u: FloatArray | None = None) -> None:
        """Note displacements or velocities that motions came to."""
        for line, values in ((0, q), (1, u)):
            if values is not None:
                np.minimum.at(self.lowest[line], rows, values)
                np.maximum.at(self.highest[line], rows, values)

    def event(self, rows: IntArray, phase: IntArray | int, kind: EventKind) -> None:
        """Note that a phase begins where the motions are."""
        self.phase[rows] = phase
        lines = np.empty((5, rows.size))
        lines[0], lines[1], lines[2], lines[3] = rows, self.tau[rows], self.q[rows], phase
        lines[4] = KINDS.index(kind)
        self._events.append(lines)

    def moved(self, rows: IntArray, tau: FloatArray, q: FloatArray, u: FloatArray | float) -> None:
        """Note where motions are, in the phase in which they have been."""
        self.tau[rows], self.q[rows], self.u[rows] = tau, q, u
        self.latest[self.phase[rows], rows] = tau
        self.place(rows, self.q[rows], self.u[rows])

    def ended(self, rows: IntArray, outcome: Outcome) -> None:
        """Note that motions have ended."""
        self.outcome[rows] = OUTCOMES.index(outcome)

    def begin_anew(self, row: int) -> None:
        """Forget a motion but for its extremes of x, and take it back to its start."""
        self.tau[row], self.onset[row], self.outcome[row], self.latest[:, row] = 0.0, np.nan, -1, -np.inf
        self.q[row], self.u[row] = (line[row] for line in self._start)
        self.lowest[:, row] = self.highest[:, row] = self.q[row], self.u[row]
        self._anew[row] = np.empty((5, 0))

    def events_are(self, row: int, lines: FloatArray) -> None:
        """Note all events of a motion that began anew, rows tau, q, phase and kind."""
        self._anew[row] = np.concatenate((np.full((1, lines.shape[1]), row), lines))

    @property
    def events(self) -> FloatArray:
        """The events in order of start and time, rows: number of the start, tau, q, phase and kind."""
        found = np.concatenate([np.empty((5, 0)), *self._events], axis=1)
        if self._anew:
            kept = found[:, ~np.isin(found[0], list(self._anew))]
            found = np.concatenate([kept, *self._anew.values()], axis=1)
        return found[:, np.argsort(found[0], kind="stable")]  # those of one start are noted in their order

    def turn(self, rows: IntArray, tau: FloatArray, q: FloatArray) -> None:
        """Note extremes of x, at which v = 0."""
        self.place(rows, q=q)
        self._turns.append(np.array((rows, tau, q)))
        self._listed += rows.size
        if self._listed > _MOST:
            self._shorten()

    @property
    def turns(self) -> tuple[IntArray, FloatArray]:
        """How many of the last extremes of x are kept, and tau and q of these, the latest first, else NaN."""
        found, rows, place = self._shorten()
        last = np.full((2, TURNS, self.tau.size), np.nan)
        last[:, place, rows] = found[1:]
        return np.bincount(rows, minlength=self.tau.size), last

    def _shorten(self) -> tuple[FloatArray, IntArray, IntArray]:
        """Drop all extremes of x but the last ones; return their list, whose they are, and which from the end."""
        found = np.concatenate([np.empty((3, 0)), *self._turns], axis=1)
        found = found[:, np.lexsort((-found[1], found[0]))]
        rows = found[0].astype(np.intp)
        count = np.bincount(rows, minlength=self.tau.size)
        place = np.arange(rows.size) - (np.cumsum(count) - count)[rows]
        kept = place < TURNS
        self._turns, self._listed = [found[:, kept]], 0
        return found[:, kept], rows[kept], place[kept]

"""`Rows`: masses on their way through a slip phase, and `Step`: one step of each."""

from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.core.aliases import Rows as Chosen

__all__ = ["Rows", "Step"]


class Rows:
    """Masses in slip. One array holds all, a column for each mass, so that some are taken out in one piece.

    Attributes
    ----------
    tau, q, w, slope : numpy.ndarray
        Time, state and w'.
    side : numpy.ndarray
        1 where the mass is slower than the belt, -1 where it is faster.
    length : numpy.ndarray
        Of the next step, as far as it is foreseen.
    rises : numpy.ndarray
        1 where w rises, else 0.
    shortened : numpy.ndarray
        1 where the step has been tried before, longer, else 0.
    since, steps : numpy.ndarray
        When the phase began, and the steps that were tried in it.
    held : numpy.ndarray
        Steps of late that stability held short.
    """

    def __init__(self, data: FloatArray) -> None:
        self.data = data
        self._row, self._segment, self.tau, self.q, self.w, self.slope = data[:6]
        self.side, self.length, self.rises, self.since, self.shortened, self.steps, self.held = data[6:]

    @classmethod
    def of(cls, *lines: FloatArray | IntArray | BoolArray) -> "Rows":
        """Return the rows of the lines row, segment, tau, q, w, slope, side, length, rises and since."""
        return cls(np.array((*lines, *np.zeros((3, lines[0].size)))))

    @classmethod
    def none(cls) -> "Rows":
        """Return no masses."""
        return cls(np.empty((13, 0)))

    @property
    def row(self) -> IntArray:
        """The numbers of the starts."""
        return np.asarray(self._row, dtype=np.intp)

    @property
    def segment(self) -> IntArray:
        """The segments of mu."""
        return np.asarray(self._segment, dtype=np.intp)

    @segment.setter
    def segment(self, values: IntArray) -> None:
        self._segment[:] = values

    @property
    def size(self) -> int:
        """How many masses they are."""
        return int(self.data.shape[1])

    def taken(self, chosen: Chosen) -> "Rows":
        """Return some of them, as rows of their own."""
        return Rows(self.data[:, chosen])

    def joined(self, *others: "Rows") -> "Rows":
        """Return these and others."""
        return Rows(np.concatenate((self.data, *(other.data for other in others)), axis=1))


@dataclass(frozen=True)
class Step:
    """A step of each of some masses: the rows before it, its length, and q, w and w' after it."""

    before: Rows
    h: FloatArray
    q: FloatArray
    w: FloatArray
    slope: FloatArray

    def taken(self, chosen: Chosen) -> "Step":
        """Return the steps of some of them."""
        return Step(self.before.taken(chosen), *(line[chosen] for line in (self.h, self.q, self.w, self.slope)))

    @classmethod
    def joined(cls, steps: list["Step"]) -> "Step":
        """Return the steps of several lists, at least one, as one."""
        lines = (np.concatenate([getattr(step, name) for step in steps]) for name in ("h", "q", "w", "slope"))
        return cls(steps[0].before.joined(*(step.before for step in steps[1:])), *lines)

    @property
    def turns(self) -> BoolArray:
        """Whether w turns: the ends are enough to see it, as for a single motion."""
        return np.where(self.before.rises > 0, self.slope < 0, self.slope > 0)

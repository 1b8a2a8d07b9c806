"""What a computation established: one word for formulas, numbers and motions alike."""

from collections.abc import Iterable
from enum import Enum


class Status(Enum):
    """What a statement rests on; the members stand in order, the strongest first.

    PROVED: an exact zero by symbolic computation, or an enclosure by a theorem whose hypotheses were checked.
    CHECKED: agrees with an independent computation at stated points and digits.
    ESTIMATED: neither proved nor checked; a number has an error estimate that is no bound.
    REFUTED: false, with the point where it fails.
    """

    PROVED = "PROVED"
    CHECKED = "CHECKED"
    ESTIMATED = "ESTIMATED"
    REFUTED = "REFUTED"

    def __str__(self) -> str:
        return self.value

    @classmethod
    def weakest(cls, statuses: "Iterable[Status]") -> "Status":
        """Return what several statements together rest on; PROVED if there is none."""
        order = list(cls)
        return max(statuses, key=order.index, default=cls.PROVED)

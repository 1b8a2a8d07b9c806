"""The ways to one number, each with its time and its error, and which of them are dominated."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from time import process_time
from typing import Generic, TypeVar

from stickslip_sym.output.tables import duration, table

__all__ = ["Trade", "Way", "dominators", "shortest"]

_Value = TypeVar("_Value")
NO_NUMBER = float("nan")


@dataclass(frozen=True)
class Way:
    """One way to a number.

    Attributes
    ----------
    name : str
        A family, and after a comma what tells it from others of that family.
    seconds : float
        Time of the processor, to the number; NaN where the way gives none.
    error : float
        Relative; NaN where the way gives no number.
    """

    name: str
    seconds: float = NO_NUMBER
    error: float = NO_NUMBER

    @property
    def found(self) -> bool:
        """Whether the way gives a number."""
        return not math.isnan(self.seconds)

    def dominates(self, other: "Way") -> bool:
        """Whether it is at least as fast and at least as accurate as another, and better in one of the two."""
        at_least = self.seconds <= other.seconds and self.error <= other.error
        return at_least and (self.seconds < other.seconds or self.error < other.error)

    @staticmethod
    def further_columns() -> tuple[str, ...]:
        """Return the titles of what else is known of every way of this kind."""
        return ()

    def further(self) -> tuple[str, ...]:
        """Return what else is known of it, as text."""
        return ()


def dominators(ways: Iterable[Way]) -> dict[str, tuple[str, ...]]:
    """Return for each way which ones dominate it, of those that none dominates.

    They suffice: what is dominated at all is dominated by one of them.
    """
    ways = list(ways)
    front = [way for way in ways if not any(other.dominates(way) for other in ways)]
    return {way.name: tuple(other.name for other in front if other.dominates(way)) for way in ways}


def shortest(compute: Callable[[], _Value], *, least: int = 3, enough: float = 0.0) -> tuple[_Value, float]:
    """Return a value, and the shortest of several times of the processor to it, in seconds.

    - `least`: how often it is computed at least.
    - `enough`: seconds that all of them take together at least.
    """
    times: list[float] = []
    while len(times) < least or sum(times) < enough:
        start = process_time()
        value = compute()
        times.append(process_time() - start)
    return value, min(times)


AnyWay = TypeVar("AnyWay", bound=Way)


@dataclass(frozen=True)
class Trade(Generic[AnyWay]):
    """The ways to one number, measured in one scene.

    Attributes
    ----------
    number : str
        What kind of number: "value" of a criterion, "threshold" or "share" of a basin.
    title : str
        Which number it is, and in which scene.
    ways : tuple of Way
        Of one kind.
    scene : mapping
        Name to number, in SI units.
    box : mapping
        From and to, of the displacements x0 and velocities v0 of starts.
    """

    number: str
    title: str
    ways: tuple[AnyWay, ...]
    scene: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def dominators(self) -> dict[str, tuple[str, ...]]:
        """For each way which ones dominate it: at least as fast and as accurate, and better in one of the two.

        Named are those that are not dominated themselves.
        """
        return dominators(self.ways)

    def __str__(self) -> str:
        return f"{self.title}\n\n{table(self.header(), self.rows())}"

    def header(self) -> Sequence[str]:
        """Return the titles of the table's columns."""
        kind = type(self.ways[0])
        return ["way", f"time a {self.number}", "relative error", *kind.further_columns(), "dominated by"]

    def rows(self) -> list[list[str]]:
        """Return the table's cells, a row for each way."""
        by = self.dominators
        return [
            [
                way.name,
                duration(way.seconds) if way.found else "no number",
                f"{way.error:.1e}" if way.found else "",
                *way.further(),
                "; ".join(by[way.name]),
            ]
            for way in self.ways
        ]

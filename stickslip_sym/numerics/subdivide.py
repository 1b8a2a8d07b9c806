"""Intervals that are divided until each is decided: the one loop behind such searches.

A `look` is shown intervals, many at once if it is vectorised, and decides each: `Accept` with what was found on
it, `Halve` with a note for both halves, or `Unknown`. Ends are numbers of any kind: floats, balls, fractions. What
is neither accepted nor halved is listed as open, with its last note and the reason: nothing is lost on the way.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, NamedTuple, Protocol, TypeAlias, TypeVar

import numpy as np

from stickslip_sym.core.aliases import FloatArray, Span
from stickslip_sym.core.deadline import check_time
from stickslip_sym.numerics.known import Unknown


class Endpoint(Protocol):
    """A number at which an interval ends."""

    def __lt__(self, other: Any, /) -> Any: ...
    def __sub__(self, other: Any, /) -> Any: ...


X = TypeVar("X", bound=Endpoint)
P = TypeVar("P")  # of what is accepted
N = TypeVar("N")  # of a note

WORK = Unknown("the bound on the work was reached")
NARROW = Unknown("it is too narrow to be halved")
CROWDED = Unknown("there is too much in it")


class Interval(NamedTuple, Generic[X, N]):
    """An interval that waits for its decision.

    - `halvings`: how often it was halved.
    - `first`: the number of the interval that it was cut from, among those to begin with.
    - `note`: what was noted when it was halved; None at first.
    """

    low: X
    high: X
    halvings: int
    first: int
    note: N | None


class Open(NamedTuple, Generic[X, N]):
    """An interval of which nothing was decided, its last note, and why."""

    low: X
    high: X
    note: N | None
    why: Unknown


class Accepted(NamedTuple, Generic[X, P]):
    """An interval that was settled, and what was found on it."""

    low: X
    high: X
    payload: P


class Accept(NamedTuple, Generic[P]):
    """The decision that an interval is settled."""

    payload: P


class Halve(NamedTuple, Generic[N]):
    """The decision that an interval is to be halved, and a note for both halves."""

    note: N


HALVE = Halve(None)
MOST_INTERVALS = 400
"""That are looked at where each takes milliseconds, before a function counts as too irregular."""
Decision: TypeAlias = Accept[P] | Halve[N] | Unknown
Look: TypeAlias = Callable[[Sequence[Interval[X, N]]], Iterable[Decision[P, N]]]


@dataclass
class WorkBudget:
    """How much work is left, in the unit of whoever counts it; several searches may share one."""

    left: float = math.inf

    def take(self, work: int) -> bool:
        """Take from it if there is enough."""
        enough = work <= self.left
        if enough:
            self.left -= work
        return enough


@dataclass(frozen=True)
class DivisionLimits:
    """How far intervals are divided.

    - `budget`, `cost`: the work that is left, and that of looking at one interval.
    - `halvings`: of each interval to begin with.
    - `parts`: how many may be accepted of each of these.
    - `narrowest`: a width down to which intervals are halved.
    """

    budget: WorkBudget = field(default_factory=WorkBudget)
    cost: int = 1
    halvings: float = math.inf
    parts: float = math.inf
    narrowest: float = 0.0


@dataclass(frozen=True)
class Subdivision(Generic[X, P, N]):
    """What was accepted, and what is open, both ascending."""

    accepted: list[Accepted[X, P]]
    open: list[Open[X, N]]

    @property
    def payloads(self) -> list[P]:
        """What was accepted, without its ends."""
        return [one.payload for one in self.accepted]

    def complete(self) -> list[P] | Unknown:
        """Return the same if nothing is open."""
        if self.open:
            return self.open[0].why
        return self.payloads


def middle(low: Any, high: Any) -> Any:
    """Return the middle of two floats or fractions."""
    return (low + high) / 2


def exact_middle(low: Any, high: Any) -> Any:
    """Return a number without a radius about in the middle of two balls."""
    return ((low + high) / 2).mid()


def ends(intervals: Sequence[Interval[float, N]]) -> tuple[FloatArray, FloatArray]:
    """Return the lower ends of intervals and the higher ones, as arrays."""
    low, high = np.array([(one.low, one.high) for one in intervals], dtype=np.float64).reshape(-1, 2).T
    return low, high


def subdivide(
    edges: Sequence[tuple[X, X]],
    look: Look[X, N, P],
    *,
    limits: DivisionLimits,
    at_once: int = 1,
    cut: Callable[[X, X], X] = middle,
    to_first_open: bool = False,
) -> Subdivision[X, P, N]:
    """Divide intervals until each is decided.

    - `edges`: the intervals to begin with, ascending.
    - `at_once`: how many `look` is shown at a time, the lowest first.
    - `cut`: where an interval is divided.
    - `to_first_open`: whether nothing counts above the lowest open interval.

    Raises `OutOfTime` when the time of a `time_limit` is up.
    """
    waiting = [Interval[X, N](low, high, 0, i, None) for i, (low, high) in enumerate(edges)]
    waiting.reverse()  # the lowest last
    accepted = list[Accepted[X, P]]()
    undecided = list[Open[X, N]]()
    parts = [0] * len(waiting)
    while waiting:
        check_time()
        batch = waiting[-at_once:][::-1]
        del waiting[-at_once:]
        paid = [one for one in batch if limits.budget.take(limits.cost)]
        undecided += [Open(one.low, one.high, one.note, WORK) for one in batch[len(paid) :]]
        halves = list[Interval[X, N]]()
        for one, decision in zip(paid, look(paid) if paid else (), strict=True):
            if isinstance(decision, Unknown):
                undecided.append(Open(one.low, one.high, one.note, decision))
            elif isinstance(decision, Halve):
                both = _halved(one, decision.note, limits, cut)
                halves += both
                if not both:
                    undecided.append(Open(one.low, one.high, decision.note, NARROW))
            elif parts[one.first] >= limits.parts:
                undecided.append(Open(one.low, one.high, one.note, CROWDED))
            else:
                parts[one.first] += 1
                accepted.append(Accepted(one.low, one.high, decision.payload))
        waiting += halves[::-1]
        if to_first_open and undecided:
            lowest = min(undecided, key=lambda one: one.low)
            undecided = [lowest]
            waiting = [one for one in waiting if one.low < lowest.low]
            accepted = [one for one in accepted if one.low < lowest.low]
    accepted.sort(key=lambda one: one.low)
    undecided.sort(key=lambda one: one.low)
    return Subdivision(accepted, undecided)


def _halved(
    one: Interval[X, N], note: N, limits: DivisionLimits, cut: Callable[[X, X], X]
) -> list[Interval[X, N]]:
    """Return both halves of an interval; none if that is not to be halved any more."""
    if one.halvings >= limits.halvings or not limits.narrowest < one.high - one.low:
        return []
    between = cut(one.low, one.high)
    if not (one.low < between and between < one.high):
        return []
    return [
        Interval(one.low, between, one.halvings + 1, one.first, note),
        Interval(between, one.high, one.halvings + 1, one.first, note),
    ]


def shown(
    holds: Callable[[X, X, int], bool],
    edges: Sequence[tuple[X, X]],
    *,
    halvings: float,
    most: float = math.inf,
    cut: Callable[[X, X], X] = middle,
) -> bool:
    """Whether something is shown on all of some intervals, each halved as often as it takes.

    False says that it was not shown, and not that it does not hold.

    - `holds`: of an interval that was halved so often.
    - `halvings`: of each interval, at most.
    - `most`: intervals that are looked at.
    """
    waiting = [(low, high, 0) for low, high in reversed(edges)]
    while waiting:
        if most <= 0:
            return False
        most -= 1
        low, high, depth = waiting.pop()
        if holds(low, high, depth):
            continue
        if depth >= halvings:
            return False
        between = cut(low, high)
        waiting += [(between, high, depth + 1), (low, between, depth + 1)]
    return True


def locate_boundary(
    holds: Callable[[float], bool], inside: float, outside: float, narrowest: float
) -> tuple[float, float]:
    """Return two numbers close together between which something ceases to hold."""
    while abs(outside - inside) > narrowest:
        between = (inside + outside) / 2
        if between in (inside, outside):
            break
        if holds(between):
            inside = between
        else:
            outside = between
    return inside, outside


def joined(intervals: Iterable[Span]) -> list[Span]:
    """Return intervals, ascending, those that touch as one."""
    together = list[Span]()
    for low, high in sorted(intervals):
        if together and low <= together[-1][1]:
            together[-1] = together[-1][0], max(high, together[-1][1])
        else:
            together.append((low, high))
    return together

"""A limit on the time of a call, which every loop beneath it asks for.

A call that may take long opens a `time_limit`; the loops under it ask `check_time` once a round. Limits nest: the
earliest end counts.
"""

import math
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import ClassVar

from stickslip_sym.core.errors import InputError, OutOfTime
from stickslip_sym.core.numbers import real
from stickslip_sym.core.remedies import Name

LONGEST = 86_400.0  # seconds, a day
_end: ContextVar[float] = ContextVar("end of the time limit, of _Clock", default=math.inf)


class _Clock:
    """What time it is for limits."""

    exempted: ClassVar[float] = 0.0
    """Seconds so far that count in no limit."""

    @classmethod
    def now(cls) -> float:
        return time.monotonic() - cls.exempted


@contextmanager
def exempt_from_time_limit() -> Iterator[None]:
    """Let the time of a block count in no limit, as where something is compiled once for an installation."""
    begin = time.monotonic()
    try:
        yield
    finally:
        _Clock.exempted += time.monotonic() - begin


def require_seconds(seconds: float | str | None) -> float | None:
    """Return a time limit as a number or None; refuse what is no number of seconds from 0 to a day."""
    if not isinstance(seconds, float | int | None):
        seconds = real("time_limit", seconds)
    if seconds is not None and not 0 <= seconds <= LONGEST:
        raise InputError(Name("time_limit"), f" = {seconds} is not a number of seconds from 0 to {LONGEST:.0f}")
    return seconds


@contextmanager
def time_limit(seconds: float | str | None) -> Iterator[None]:
    """Let `check_time` raise `OutOfTime` within this block once so many seconds have passed; None is no limit."""
    limit = require_seconds(seconds)
    end = math.inf if limit is None else _Clock.now() + limit
    token = _end.set(min(end, _end.get()))
    try:
        yield
    finally:
        _end.reset(token)


def time_left() -> float:
    """Return how many seconds are left, infinite without a limit, negative after it."""
    return _end.get() - _Clock.now()


def is_late() -> bool:
    """Whether the time of the innermost or any outer limit is up."""
    return time_left() < 0


def check_time() -> None:
    """Raise `OutOfTime` if the time of the innermost or any outer limit is up."""
    if is_late():
        raise OutOfTime("the time limit was reached")

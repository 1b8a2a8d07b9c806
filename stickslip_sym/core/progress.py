"""What is under way, and how far: a function that works in steps says each, and whoever shows it listens.

Steps nest: what a step calls may work in steps of its own. Threads say nothing; who waits for them does.
"""

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import NamedTuple, TypeVar

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Name

T = TypeVar("T")


class StepOfWork(NamedTuple):
    """What is under way, and how many steps like it are done, of how many; 0 where that is not known."""

    what: str
    done: int
    total: int


Listener = Callable[[tuple[StepOfWork, ...]], object]
"""What is called with the step that begins, after those that it is part of."""
_listener: ContextVar[Listener | None] = ContextVar("who listens", default=None)
_path: ContextVar[tuple[StepOfWork, ...]] = ContextVar("steps under way, from the outermost on", default=())


@contextmanager
def stages() -> Iterator[Callable[[str, int, int], None]]:
    """Yield a function that says what is under way now, instead of what it said before."""
    outer = _path.get()

    def say(what: str, done: int, total: int) -> None:
        path = (*outer, StepOfWork(what, done, total))
        _path.set(path)
        if (listener := _listener.get()) is not None:
            listener(path)

    try:
        yield say
    finally:
        _path.set(outer)


@contextmanager
def steps(items: Collection[T], what: Callable[[T], str]) -> Iterator[Iterator[T]]:
    """Yield an iterator over items, each of which is under way, by the words that it has, until the next is taken.

    What is under way ends with the block: a loop that an error leaves does not end its iterator, which stays
    suspended as long as somebody keeps the error.
    """
    with stages() as say:

        def said() -> Iterator[T]:
            words = ""
            for done, item in enumerate(items):
                words = what(item)
                say(words, done, len(items))
                yield item
            say(words, len(items), len(items))

        yield said()


@contextmanager
def report_every_step_to(listener: Listener) -> Iterator[None]:
    """Let a function hear of every step in a block, besides whoever does already."""
    before = _listener.get()

    def both(path: tuple[StepOfWork, ...]) -> None:
        if before is not None:
            before(path)
        listener(path)

    token = _listener.set(both)
    try:
        yield
    finally:
        _listener.reset(token)


@contextmanager
def report_steps_to(hear: Callable[[StepOfWork], object] | None) -> Iterator[None]:
    """Let a function, if there is one, hear of the steps of a block, without those within them."""
    if hear is None:
        yield
        return
    depth = len(_path.get())
    with report_every_step_to(lambda path: hear(path[-1]) if len(path) == depth + 1 else None):
        yield


@contextmanager
def report_counts_to(progress: Callable[[int, int], object] | None) -> Iterator[None]:
    """Let a function, if there is one, hear how many steps of a block are done, and of how many."""
    if not (progress is None or callable(progress)):
        raise InputError(Name("progress"), f" is a function of two numbers, got {progress!r:.60}")
    with report_steps_to(progress and (lambda step: progress(step.done, step.total))):
        yield

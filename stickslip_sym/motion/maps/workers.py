"""A function over many tasks, by one process, several, or any executor's map.

What `workers` means is SciPy's convention: a number of processes, -1 for all processors, or a callable that takes
a function and an iterable as the builtin `map` does.
"""

import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from stickslip_sym.core.errors import InputError, NotConverged

__all__ = ["Workers", "check_workers", "run"]

Task = TypeVar("Task")
Result = TypeVar("Result")
Mapper = Callable[[Callable[[Any], Any], Iterable[Any]], Iterable[Any]]
Workers = int | Mapper
_MOST_STARTS = 3  # times that a pool is started; after so many the cause is no accident


def check_workers(workers: Workers) -> None:
    """Refuse what is neither a number of processes nor a map."""
    if callable(workers):
        return
    if isinstance(workers, bool) or not isinstance(workers, int) or (workers < 1 and workers != -1):
        raise InputError(
            f"workers = {workers!r} must be a number of processes, at least 1, or -1 for all processors, or a "
            "function like the builtin map"
        )


def run(
    function: Callable[[Task], Result], tasks: Sequence[Task], workers: Workers
) -> Iterator[tuple[int, Result]]:
    """Yield the index of each task and its result, as they come.

    - `function`: at the top level of a module, so that other processes find it.
    - `tasks`: plain arguments, for the same reason.
    - `workers`: a callable's results are taken in the order of the tasks, each as soon as it is given.

    Raises `InputError` for unusable workers, or a map that returns too few or too many results.
    Raises `NotConverged` when processes of ours end again and again.
    """
    check_workers(workers)
    if callable(workers):
        yield from _mapped(function, tasks, workers)
    elif workers == 1 or len(tasks) < 2:
        yield from enumerate(map(function, tasks))
    else:
        yield from _pooled(function, tasks, _processors() if workers == -1 else workers)


def _processors() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _mapped(
    function: Callable[[Task], Result], tasks: Sequence[Task], mapper: Mapper
) -> Iterator[tuple[int, Result]]:
    count = 0
    for result in mapper(function, tasks):
        if count == len(tasks):
            raise InputError(f"the map given as workers returned more results than the {count} tasks it was given")
        yield count, result
        count += 1
    if count < len(tasks):
        raise InputError(f"the map given as workers returned {count} results for {len(tasks)} tasks")


def _pooled(function: Callable[[Task], Result], tasks: Sequence[Task], count: int) -> Iterator[tuple[int, Result]]:
    """Use processes of our own; where one of them is killed, start anew with what is not done yet."""
    todo, others = dict(enumerate(tasks)), set(active_children())
    for _ in range(_MOST_STARTS):
        # Spawned, not forked: a fork of a process with threads may hang.
        pool = ProcessPoolExecutor(min(count, len(todo)), mp_context=get_context("spawn"))
        started: set[BaseProcess] = set()
        try:
            with _no_interrupt():
                futures = {pool.submit(function, task): index for index, task in todo.items()}
                started = set(active_children()) - others
            for future in as_completed(futures):
                index, result = futures[future], future.result()
                del todo[index]
                yield index, result
            return
        except BrokenProcessPool:
            continue
        finally:
            for process in started if todo else ():  # the tasks that they still carry out are not needed
                process.terminate()
            pool.shutdown(cancel_futures=True)
    raise NotConverged(
        f"worker processes ended {_MOST_STARTS} times before their work was done: memory may be short, or a "
        'script that starts workers lacks its `if __name__ == "__main__":`; try workers=1'
    )


@contextmanager
def _no_interrupt() -> Iterator[None]:
    """Start processes that Ctrl-C does not reach: the one that started them ends them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

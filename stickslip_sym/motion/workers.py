"""A function over many tasks: here, in several threads, or by any executor of `concurrent.futures`.

Compiled code releases the interpreter, so threads share the processors. A time limit around the call goes with
each task. Ctrl-C ends the work and keeps what is done.
"""

import math
import os
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import AbstractContextManager, nullcontext
from functools import partial
from typing import TypeVar

from stickslip_sym.core.deadline import LONGEST, time_left, time_limit
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.progress import stages
from stickslip_sym.core.remedies import Argument, Name

Task = TypeVar("Task")
Result = TypeVar("Result")
Workers = int | Executor
"""A number of threads, -1 for all processors, or what carries out the tasks."""


def collect(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    *,
    workers: Workers = 1,
    what: str,
) -> list[Result | None]:
    """Return the result of each task; None for a task that Ctrl-C kept from its end.

    - `function`, `tasks`: at the top level of a module, and plain content, so that other processes find them.
    - `workers`: a number of threads, -1 for all processors, or an executor,
      such as a dask client's ``get_executor()``.
    - `what`: the tasks, in words, for who listens to how many are done.

    Raises `InputError` for unusable workers.
    Raises `NotConverged` if the executor ends before its work is done.
    Raises `KeyboardInterrupt` if Ctrl-C comes before the first result.
    """
    results: list[Result | None] = [None] * len(tasks)
    left = time_left()
    limited = function
    if not math.isinf(left):
        limited = partial(_carry_out_until, time.time() + left, function)
    done = 0
    with stages() as say:
        say(what, done, len(tasks))
        try:
            for index, result in _results(limited, tasks, workers):
                results[index] = result
                done += 1
                say(what, done, len(tasks))
        except KeyboardInterrupt:
            if done == 0:
                raise
    return results


def _carry_out_until(end: float, function: Callable[[Task], Result], task: Task) -> Result:
    """Carry out a task with the time until a given one, in seconds of the clock that all processes have."""
    with time_limit(min(max(end - time.time(), 0.0), LONGEST)):
        return function(task)


def _results(
    function: Callable[[Task], Result], tasks: Sequence[Task], workers: Workers
) -> Iterator[tuple[int, Result]]:
    """Yield the index of each task and its result, as they come."""
    with _executor(workers, len(tasks)) as executor:
        if executor is None:
            yield from enumerate(map(function, tasks))
            return
        futures: dict[Future[Result], int] = {}
        try:
            for index, task in enumerate(tasks):  # Ctrl-C may come here too
                futures[executor.submit(function, task)] = index
            for future in as_completed(futures):
                yield futures[future], future.result()
        except BrokenExecutor as error:
            raise NotConverged(
                f"the executor ended before its work was done ({error}); try ", Argument("workers", 1)
            ) from None
        finally:
            for future in futures:
                future.cancel()


def _executor(workers: Workers, tasks: int) -> AbstractContextManager[Executor | None]:
    """Give an executor of ours, which ends with the block, one of the caller's, which does not, or None."""
    if isinstance(workers, Executor):
        return nullcontext(workers)
    if isinstance(workers, bool) or not isinstance(workers, int) or (workers < 1 and workers != -1):
        raise InputError(
            Name("workers"),
            f" = {workers!r} must be a number of threads, at least 1, or -1 for all processors, or an "
            "executor of concurrent.futures",
        )
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    count = min(workers if workers > 0 else usable, tasks)
    return nullcontext() if count < 2 else ThreadPoolExecutor(count)

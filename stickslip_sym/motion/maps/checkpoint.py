"""Results kept in a file as they come, so that a run that was killed goes on where it stopped.

The first line tells the request by its digest, every other line is one finished chunk. Lines are appended whole;
a last one that was torn by a kill is dropped.
"""

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from stickslip_sym.core.deadline import LONGEST, time_left, time_limit
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.version import __version__
from stickslip_sym.motion.maps.workers import Workers, check_workers, run
from stickslip_sym.output.files import require_name

__all__ = ["UNFINISHED", "Progress", "collect"]

UNFINISHED = "unfinished"
"""The key of a result that says whether the time was up before it was whole; such a one is not kept."""

_FORMAT = "stickslip_sym checkpoint"
Progress = Callable[[int, int], None]


def collect(
    function: Callable[[Any], Any],
    tasks: Sequence[Any],
    *,
    workers: Workers = 1,
    checkpoint: str | Path | None = None,
    progress: Progress | None = None,
) -> list[Any]:
    """Return the results of all tasks, in order.

    Parameters
    ----------
    function : callable
        At the top level of a module; takes a task, and returns what JSON holds.
    tasks : sequence
        What JSON holds; together they are the request.
    workers : int or map-like callable
    checkpoint : str or Path, optional
        A file of an earlier run of the same request, or a new one.
    progress : callable, optional
        Called with the number of finished tasks and of all.

    Raises
    ------
    InputError
        For unusable workers, or a file that cannot be used.
    """
    check_workers(workers)
    found: dict[int, Any] = {}
    if checkpoint is None:
        return _run(function, tasks, found, workers, progress, lambda index, result: None)
    head = json.dumps({"format": _FORMAT, "request": _digest(function, tasks), "chunks": len(tasks)}) + "\n"
    path = Path(checkpoint)
    with _opened(path) as stream:
        with _explained(path):
            found = _resume(path, stream, head.encode(), len(tasks))

        def keep(index: int, result: Any) -> None:
            # One unbuffered write a line: a kill can tear the last line only.
            with _explained(path):
                stream.write((json.dumps([index, result]) + "\n").encode())

        return _run(function, tasks, found, workers, progress, keep)


def _run(
    function: Callable[[Any], Any],
    tasks: Sequence[Any],
    found: dict[int, Any],
    workers: Workers,
    progress: Progress | None,
    keep: Callable[[int, Any], None],
) -> list[Any]:
    told = progress or (lambda done, total: None)
    told(len(found), len(tasks))
    left = [index for index in range(len(tasks)) if index not in found]
    for place, result in run(_limited(function), [tasks[index] for index in left], workers):
        if not (isinstance(result, dict) and result.get(UNFINISHED)):
            keep(left[place], result)
        found[left[place]] = result
        told(len(found), len(tasks))
    return [found[index] for index in range(len(tasks))]


def _limited(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Let a function heed in other processes, too, what is left of the time here."""
    left = time_left()
    return function if math.isinf(left) else partial(_until, time.time() + left, function)


def _until(end: float, function: Callable[[Any], Any], task: Any) -> Any:
    """Carry out a task with the time until a given one, in seconds of the clock that all processes have."""
    with time_limit(min(max(end - time.time(), 0.0), LONGEST)):
        return function(task)


def _digest(function: Callable[[Any], Any], tasks: Iterable[Any]) -> str:
    """Return what tells one request from another; another version of the package may compute otherwise."""
    digest = hashlib.sha256(f"{__version__} {function.__module__}.{function.__name__}".encode())
    for task in tasks:
        digest.update(b"\n" + json.dumps(task, sort_keys=True).encode())
    return digest.hexdigest()


def _opened(path: Path) -> BinaryIO:
    require_name(path)
    with _explained(path):
        return path.open("a+b", buffering=0)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Say which file it was that failed."""
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot use the checkpoint {str(path)!r}: {error.strerror or error}") from None


def _resume(path: Path, stream: BinaryIO, head: bytes, count: int) -> dict[int, Any]:
    """Read what is done, and leave the file ready for the next line."""
    stream.seek(0)
    content = stream.read()
    whole = content[: content.rfind(b"\n") + 1]
    lines = whole.splitlines()
    if not lines and not head.startswith(content):
        raise InputError(f"{str(path)!r} is no checkpoint, and is left as it is; choose another file")
    if lines and lines[0] + b"\n" != head:
        _refuse(path, lines[0])
    stream.truncate(len(whole))
    if not lines:
        stream.write(head)
    found = {}
    for number, line in enumerate(lines[1:], 2):
        try:
            index, result = json.loads(line)
        except ValueError:
            index, result = -1, None
        if type(index) is not int or not 0 <= index < count:
            raise InputError(f"line {number} of the checkpoint {str(path)!r} was changed; choose another file")
        found[index] = result
    return found


def _refuse(path: Path, first: bytes) -> None:
    """Say what a file is that is no checkpoint of this request."""
    try:
        ours = json.loads(first).get("format") == _FORMAT
    except (ValueError, AttributeError):
        ours = False
    if ours:
        raise InputError(
            f"the checkpoint {str(path)!r} belongs to another request: another law, axis, value or version; "
            "repeat that request, or choose another file"
        )
    raise InputError(f"{str(path)!r} is no checkpoint, and is left as it is; choose another file")

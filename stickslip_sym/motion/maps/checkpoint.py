"""Results kept in a file as they come, so that a run that was killed goes on where it stopped.

The first line tells the request by its digest, every other line is one finished task. Lines are appended whole;
a last one that was torn by a kill is dropped.
"""

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

from stickslip_sym.core.deadline import LONGEST, time_left, time_limit
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.version import __version__
from stickslip_sym.motion.maps.workers import Workers, check_workers, run
from stickslip_sym.output.files import require_name

__all__ = ["UNFINISHED", "Plain", "Progress", "collect", "limited"]

UNFINISHED = "unfinished"
"""The key of a result that says whether the time was up before it was whole; such a one is not kept."""

_FORMAT = "stickslip_sym checkpoint"
Progress = Callable[[int, int], None]
Plain = Any
"""What JSON holds."""
Function = Callable[[Plain], Plain]


def collect(
    function: Function,
    tasks: Sequence[Plain],
    *,
    together: int | None = None,
    workers: Workers = 1,
    checkpoint: str | Path | None = None,
    progress: Progress | None = None,
) -> list[Plain]:
    """Return the results of all tasks, in order.

    - `function`: at the top level of a module; takes a task, and returns what JSON holds.
    - `tasks`: what JSON holds; all of them are the request.
    - `together`: how many tasks the function takes as a list, to return a list; if not given, one as it is.
    - `checkpoint`: a file of an earlier run of the same request, or a new one.
    - `progress`: called with the number of finished tasks and of all.

    Raises `InputError` for unusable workers, or a file that cannot be used.
    """
    check_workers(workers)
    found: dict[int, Plain] = {}
    told = progress or (lambda done, total: None)
    with nullcontext() if checkpoint is None else _opened(Path(checkpoint)) as file:
        if file is not None:
            request = {"format": _FORMAT, "request": _digest(function, tasks), "chunks": len(tasks)}
            found = file.resume(request, len(tasks))
        told(len(found), len(tasks))
        # The same tasks go together in every run: where they differ in the last digit, it is not by chance.
        parts = [range(len(tasks))[i : i + (together or 1)] for i in range(0, len(tasks), together or 1)]
        left = [part for part in parts if not found.keys() >= set(part)]
        given = [tasks[part[0]] if together is None else [tasks[i] for i in part] for part in left]
        for place, results in run(limited(function), given, workers):
            for index, result in zip(left[place], [results] if together is None else results, strict=True):
                if index in found:
                    continue
                if file is not None and not (isinstance(result, dict) and result.get(UNFINISHED)):
                    file.keep(index, result)
                found[index] = result
            told(len(found), len(tasks))
    return [found[index] for index in range(len(tasks))]


def limited(function: Function) -> Function:
    """Return a function that keeps, in other processes too, to the time that is left here."""
    left = time_left()
    return function if math.isinf(left) else partial(_until, time.time() + left, function)


def _until(end: float, function: Function, task: Plain) -> Plain:
    """Carry out a task with the time until a given one, in seconds of the clock that all processes have."""
    with time_limit(min(max(end - time.time(), 0.0), LONGEST)):
        return function(task)


def _digest(function: Function, tasks: Iterable[Plain]) -> str:
    """Return what tells one request from another; another version of the package may compute otherwise."""
    digest = hashlib.sha256(f"{__version__} {function.__module__}.{function.__name__}".encode())
    for task in tasks:
        digest.update(b"\n" + json.dumps(task, sort_keys=True).encode())
    return digest.hexdigest()


@contextmanager
def _opened(path: Path) -> Iterator["_File"]:
    require_name(path)
    with _explained(path):
        stream = path.open("a+b", buffering=0)
    with stream:
        yield _File(path, stream)


@contextmanager
def _explained(path: Path) -> Iterator[None]:
    """Name the file that failed."""
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot use the checkpoint {str(path)!r}: {error.strerror or error}") from None


@dataclass(frozen=True)
class _File:
    """A checkpoint; each line is one unbuffered write, so that a kill can tear the last one only."""

    path: Path
    stream: BinaryIO

    def keep(self, index: int, result: Plain) -> None:
        with _explained(self.path):
            self.stream.write(_line([index, result]))

    def resume(self, request: dict[str, Plain], count: int) -> dict[int, Plain]:
        """Read what is done, and leave the file ready for the next line."""
        name, head = str(self.path), _line(request)
        with _explained(self.path):
            self.stream.seek(0)
            content = self.stream.read()
        first, *lines = content[: content.rfind(b"\n") + 1].splitlines() or [b""]
        if first + b"\n" != head and (first or not head.startswith(content)):
            if first.startswith(_line({"format": _FORMAT})[:-2]):
                raise InputError(
                    f"the checkpoint {name!r} belongs to another request: another law, axis, value or version; "
                    "repeat that request, or choose another file"
                )
            raise InputError(f"{name!r} is no checkpoint, and is left as it is; choose another file")
        with _explained(self.path):
            self.stream.truncate(content.rfind(b"\n") + 1)
            if not first:
                self.stream.write(head)
        found = {}
        for number, line in enumerate(lines, 2):
            try:
                index, result = json.loads(line)
            except ValueError:
                index, result = -1, None
            if type(index) is not int or not 0 <= index < count:
                raise InputError(f"line {number} of the checkpoint {name!r} was changed; choose another file")
            found[index] = result
        return found


def _line(content: Plain) -> bytes:
    return (json.dumps(content) + "\n").encode()

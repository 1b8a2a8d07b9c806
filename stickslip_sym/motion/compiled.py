"""Functions that run as plain Python, or compiled by numba where many runs are asked for.

A function marked `compilable` is written in the subset of Python that numba compiles: floats, tuples and lists, no
objects. A single run calls it as it is; for many, `compiled` returns it as machine code, which is kept on disk;
making it counts in no time limit. Without numba, the extra `fast`, `compiled` returns the function itself.
"""

import inspect
import logging
import math
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from stickslip_sym.core.deadline import exempt_from_time_limit, is_late
from stickslip_sym.core.interrupts import held_back

_Function = TypeVar("_Function", bound=Callable[..., Any])
_OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "fastmath": False}
"""Machine code carries out each operation as Python does, in the same order: results are the same to the bit.

Products and sums in one instruction, rounded once, would save no time that can be measured.
"""
_log = logging.getLogger("stickslip_sym")
_marked = dict[Callable[..., Any], bool]()
"""Functions that compiled ones may call, and whether numba knows that."""
_inlined = set[Callable[..., Any]]()
"""Those that become part of each compiled function that calls them."""
_ready = set[Callable[..., Any]]()


def compilable(function: _Function) -> _Function:
    """Mark a function that compiled functions may call."""
    _marked[function] = False
    return function


def inlined(function: _Function) -> _Function:
    """Mark a compilable function that is called so often that its calls would count in machine code."""
    _inlined.add(function)
    return compilable(function)


@cache
def is_compiling() -> bool:
    """Whether numba is there; where it is not, a line on the log says once what it would do."""
    if find_spec("numba") is not None:
        return True
    _say("many motions are computed in plain Python; pip install numba makes that 30 times faster")
    return False


def is_ready(function: Callable[..., Any]) -> bool:
    """Whether the machine code of a function was loaded, or made, in this process."""
    return function in _ready


@cache
def compiled(function: _Function) -> _Function:
    """Return a compilable function as machine code that runs without holding the interpreter.

    Where none is kept, a line on the log or on stderr says that it is made.
    """
    if not is_compiling():
        return function
    with held_back():  # an interrupt within the import would break numba until Python is started again
        import numba
        from numba.extending import overload, register_jitable

    if not any(_marked.values()):
        overload(is_late)(lambda: lambda: False)  # whoever runs machine code looks at the time between two batches
    for part in [part for part, is_known in _marked.items() if not is_known]:
        register_jitable(no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=part in _inlined, **_OPTIONS)(
            part
        )
        _marked[part] = True
    machine_code: Any = numba.njit(nogil=True, **_OPTIONS)(function)
    _forget(_newest_part(), function)

    def call(*arguments: Any) -> Any:
        if not machine_code.overloads:
            if not _kept(function):
                _say_once("compiling the integrator, once for this installation ...")
            with exempt_from_time_limit():
                _load_or_make(machine_code, function, tuple(map(numba.typeof, arguments)))
            _ready.add(function)
        return machine_code(*arguments)

    return call  # type: ignore[return-value]


def _load_or_make(machine_code: Any, function: Callable[..., Any], types: tuple[Any, ...]) -> None:
    """Load kept machine code, or make it; what is kept and cannot be read is dropped, and made once more."""
    try:
        machine_code.compile(types)
    except Exception:  # of pickle, of LLVM, of text that is none: whatever damaged bytes lead to
        _forget(math.inf, function)
        machine_code.compile(types)


def _newest_part() -> float:
    """Return when the newest file of what compiled functions may call was changed: numba looks at its own only."""
    return max(os.path.getmtime(inspect.getfile(part)) for part in _marked)


def _forget(before: float, function: Callable[..., Any]) -> None:
    """Remove machine code, of a function and of what it may call, that was kept before a time."""
    for part in {function, *_marked}:
        for index in _kept(part):
            with suppress(FileNotFoundError):  # another process may have done so
                if index.stat().st_mtime < before:
                    index.unlink()


def _kept(function: Callable[..., Any]) -> list[Path]:
    """Return the files that list the machine code of a function on disk."""
    from numba.core.caching import FunctionCache

    cache: Any = FunctionCache
    return [*Path(cache(function).cache_path).glob(f"*.{function.__name__}-*.nbi")]


@cache
def _say_once(line: str) -> None:
    _say(line)


def _say(line: str) -> None:
    if _log.hasHandlers():
        _log.info(line)
    else:
        print(line, file=sys.stderr)

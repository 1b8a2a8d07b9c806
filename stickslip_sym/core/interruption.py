"""A limit on the time of work that never asks for the time itself, such as SymPy's algebra.

A watching thread raises an exception in the thread that works, at whatever bytecode it has come to, and again
after a while should something on the way have swallowed it. When the work ends, in whatever way, what is still
pending is taken, so nothing is raised later. What SymPy had begun to deduce is forgotten: an interrupted
deduction would stay "unknown" for good.
"""

import ctypes
import gc
import threading
from collections.abc import Callable
from typing import TypeVar

import mpmath
import sympy as sp
from sympy.core.cache import clear_cache

from stickslip_sym.core.deadline import check_time, time_left, time_limit
from stickslip_sym.core.errors import OutOfTime

__all__ = ["within"]

T = TypeVar("T")

_AGAIN = 1.0  # seconds until the exception is raised again; what tidies up behind it has that long


def within(seconds: float | None, work: Callable[[], T]) -> T:
    """Return what `work` returns, unless a time limit ends it: this one, or one that was set around it.

    Raises
    ------
    OutOfTime
        After so many seconds, or the few more that one step without a bytecode takes.
    InputError
        If it is no number of seconds from 0 to a day.
    """
    with time_limit(seconds):
        check_time()
        left = time_left()
        if left == float("inf"):
            return work()
        precision = mpmath.mp.prec
        watch = _Watch(left)
        try:
            try:
                watch.start()
                return work()
            finally:
                watch.stop()
        except watch.signal:
            pass
        except KeyboardInterrupt:
            watch.stop()
            _forget()
            raise
        watch.stop()
        mpmath.mp.prec = precision
        _forget()
        raise OutOfTime("the time limit was reached")


class _Watch:
    """The thread that raises an exception in the one that made it.

    Attributes
    ----------
    signal : type
        The exception, a class of this watch alone: limits nest. No `except Exception` on the way takes it.
    """

    def __init__(self, seconds: float) -> None:
        self.signal: type[BaseException] = type("TimeIsUp", (BaseException,), {})
        self._seconds = seconds
        self._thread = threading.get_ident()
        self._raising = threading.Lock()
        self._on = True
        self._raised = False
        # A lock and no Event: releasing it is one step, which nothing can interrupt half way.
        self._running = threading.Lock()
        self._running.acquire()

    def start(self) -> None:
        """Begin to watch."""
        threading.Thread(target=self._watch, name="time limit", daemon=True).start()

    def _watch(self) -> None:
        wait = self._seconds
        while not self._running.acquire(timeout=wait):
            with self._raising:
                if self._on:
                    self._raised = True
                    self._raise()
            wait = _AGAIN

    def _raise(self) -> None:
        ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(self._thread), ctypes.py_object(self.signal))

    def stop(self) -> None:
        """End the watch, and take an exception that is still to be raised; Ctrl-C waits until that is done.

        It is taken, not withdrawn: CPython 3.11 would look for what was withdrawn at every bytecode, and under a
        profiler or a debugger for good.
        """
        pressed: KeyboardInterrupt | None = None
        while True:
            try:
                with self._raising:
                    self._on = False
                if self._running.locked():
                    self._running.release()
                if self._raised:
                    self._raise()
                    while True:
                        pass
                break
            except self.signal:
                self._raised = False
            except KeyboardInterrupt as interrupt:
                pressed = interrupt
        if pressed is not None:
            raise pressed


def _forget() -> None:
    """Make SymPy deduce anew what it knows about every expression; symbols keep what they were given."""
    clear_cache()
    for node in gc.get_objects():
        if issubclass(type(node), sp.Basic) and not issubclass(type(node), sp.Symbol):
            node._assumptions = node.default_assumptions.copy()

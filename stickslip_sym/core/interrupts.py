"""Ctrl-C where an exception would do harm: it waits for the end of a block.

Python raises KeyboardInterrupt between any two steps of the program, even before the first line of a function that
a library in C has called. A library that does not expect an exception there goes on with it pending.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any


class Interrupt:
    """Whether Ctrl-C came within a block."""

    came = False


@contextmanager
def held_back() -> Iterator[Interrupt]:
    """Let Ctrl-C take effect at the end of a block, not within it; the block may ask whether it came.

    Only the main thread is interrupted, so there is nothing to hold back in others, nor where a user's program
    handles the signal in C, or ignores it.
    """
    interrupt = Interrupt()
    before: Any = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(before):
        yield interrupt
        return

    def wait(number: int, frame: FrameType | None) -> None:
        interrupt.came = True

    try:
        signal.signal(signal.SIGINT, wait)
        yield interrupt
    finally:
        signal.signal(signal.SIGINT, before)
    if interrupt.came:
        before(signal.SIGINT, None)

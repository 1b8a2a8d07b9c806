"""What other processes are asked to do in tests."""

import os
import signal
import time
from pathlib import Path

KILL = getattr(signal, "SIGKILL", signal.SIGTERM)
"""What ends a process at once, with no handler asked: on Windows, which has no SIGKILL, SIGTERM does."""


def square(number):
    return number * number


def slow_square(number):
    time.sleep(number)
    return number * number


def slow_lines(tasks):
    """Decide lines of a map, slowly enough to be killed at it."""
    from stickslip_sym.motion.maps.lines import decide_lines

    time.sleep(0.1)
    return decide_lines(tasks)


def die_once(task):
    """Kill the process that this runs in, the first time it comes to task 3."""
    path, number = task
    if number == 3 and not Path(path).exists():
        Path(path).write_text(str(os.getpid()))
        os.kill(os.getpid(), KILL)
    return number

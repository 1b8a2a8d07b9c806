"""Run tests with a mutant in place: a process that has imported what is large forks one for each mutant.

The child imports the mutated sources afresh, and tells through a pipe what it does.
"""

import contextlib
import json
import os
import py_compile
import select
import signal
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

LARGE = (
    *("sympy", "mpmath", "numpy", "scipy.integrate", "scipy.optimize", "scipy.interpolate", "scipy.special"),
    *("scipy.sparse.linalg", "hypothesis", "typer", "pytest", "_pytest.assertion.rewrite", "xdist.plugin"),
    *("matplotlib.figure", "matplotlib.backends.backend_agg", "multiprocessing.pool", "concurrent.futures"),
)
"""What the tests import besides the sources."""

SLOWER = 4.0
"""A test that needs this much more CPU time with a mutant hangs."""

ALWAYS = 10.0
"""CPU seconds that every test has, and that importing has."""

STILL = 120.0
"""Seconds of the clock without any use of the CPU after which a test waits in vain."""


@dataclass(frozen=True)
class Trial:
    """What became of a mutant.

    Attributes
    ----------
    outcome
        ``"killed"``, ``"hangs"``, ``"at import"`` (no test could be collected), or ``"survived"``.
    by
        The test that noticed.
    tests
        The tests that passed.
    seconds
        CPU seconds.
    """

    outcome: str
    by: str
    tests: list[str]
    seconds: float


def warm_up() -> None:
    """Import what all children need, and nothing of what is mutated."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    sys.dont_write_bytecode = True
    for name in LARGE:
        with contextlib.suppress(ImportError):
            __import__(name)


class _Messages:
    """A plugin of pytest that tells what is run."""

    def __init__(self, pipe: int) -> None:
        self._pipe = pipe

    def send(self, **facts: object) -> None:
        os.write(self._pipe, json.dumps(facts).encode() + b"\n")

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.send(start=nodeid)

    def pytest_runtest_logreport(self, report: object) -> None:
        if report.failed:
            self.send(failed=report.nodeid)
        elif report.when == "call" and report.passed:
            self.send(passed=report.nodeid)


def _child(pipe: int, root: Path, tests: list[str]) -> None:
    """Run tests until one fails, a few and then ever more of them at a time."""
    os.setsid()
    os.chdir(root)
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(silent, stream)
    os.environ |= {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}
    sys.path.insert(0, str(root))
    import pytest

    messages = _Messages(pipe)
    # What the parent has imported can't be rewritten, and needs not be.
    options = ["-x", "-q", "-n", "0", "-p", "no:cacheprovider", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
    done, size = 0, 6
    while done < len(tests):
        part = tests[done : done + size]
        code = pytest.main([*options, *part], plugins=[messages])
        if code == pytest.ExitCode.USAGE_ERROR:
            # A test of this name is not there any more: what its file holds is run instead.
            files = sorted({test.partition("::")[0] for test in part})
            code = pytest.main([*options, *files], plugins=[messages])
        if code not in (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED):
            messages.send(ended=int(code))
            break
        done, size = done + size, 4 * size
    else:
        messages.send(ended=0)


def _used(session: int) -> float:
    """Return the CPU seconds that a session's processes have used, as far as the system tells."""
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            if int(fields[3]) == session:
                ticks += sum(map(int, fields[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def run(root: Path, tests: list[str], usual: dict[str, float]) -> Trial:
    """Run tests in a child, on the sources as they lie under the root."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        with contextlib.suppress(BaseException):
            os.close(reading)
            _child(writing, root, tests)
        os._exit(0)
    os.close(writing)
    passed: list[str] = []
    failed, now, ended, hangs = "", "", None, False
    start = used = 0.0
    moved = time.monotonic()
    buffer = b""
    while True:
        ready, _, _ = select.select([reading], [], [], 1.0)
        if ready:
            read = os.read(reading, 65536)
            if not read:
                break
            buffer += read
            *whole, buffer = buffer.split(b"\n")
            for line in whole:
                message = json.loads(line)
                if "start" in message:
                    now, start = message["start"], _used(child)
                elif "passed" in message:
                    passed.append(message["passed"])
                elif "failed" in message:
                    failed = message["failed"]
                else:
                    ended = message["ended"]
            if failed or ended is not None:
                break
            continue
        previous, used = used, _used(child)
        if used > previous:
            moved = time.monotonic()
        allowed = ALWAYS + SLOWER * max(usual.get(now, 0.0), 0.0)
        if (used - start > allowed and now) or time.monotonic() - moved > STILL:
            hangs = True
            break
    used = max(used, _used(child))
    os.close(reading)
    with contextlib.suppress(OSError):
        os.killpg(child, signal.SIGKILL)
    with contextlib.suppress(OSError):
        os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    if hangs:
        return Trial("hangs", now, passed, used)
    if failed:
        return Trial("killed", failed, passed, used)
    if ended != 0:
        # Not even the sources could be imported, or the process died.
        return Trial("killed" if now else "at import", now, passed, used)
    return Trial("survived", "", passed, used)


@contextlib.contextmanager
def in_place(path: Path, mutated: str) -> Iterator[None]:
    """Put another text into a file of a copy for a while; what is compiled follows."""
    text = path.read_text()
    try:
        _write(path, mutated)
        yield
    finally:
        _write(path, text)


def _write(path: Path, text: str) -> None:
    path.write_text(text)
    py_compile.compile(str(path), invalidation_mode=py_compile.PycInvalidationMode.UNCHECKED_HASH)

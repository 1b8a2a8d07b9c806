"""Which tests run which line: the test files are run once, each in a process of its own, with a context per test.

Programs that a test starts are traced too, and count for that test. What is found is kept by the text of what was
run, so that only test files that are new or changed are run again.
"""

import hashlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_stack
from types import FrameType

import coverage
import pytest

MUTATED = ("stickslip_sym", "derivations")
"""The folders that are mutated."""

SETTINGS = """\
[run]
data_file = {place}/data
parallel = true
source = {sources}
context = ${{MUTANTS_TEST-}}
concurrency = thread, multiprocessing
disable_warnings = no-data-collected, module-not-measured, module-not-imported, couldnt-parse
"""


WAITING = 30.0
"""Seconds of the clock that a test may use for one of the CPU: programs it waits for count only when they end."""


def used_seconds() -> float:
    """Return the CPU seconds of this process and of those it waited for."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def is_tracer(path: str) -> bool:
    """Tell whether a file is one of the tracer's, or of the locks it uses."""
    return f"{os.sep}coverage{os.sep}" in path or path.endswith((f"{os.sep}threading.py", f"{os.sep}sqlite3.py"))


class TooLong(BaseException):
    """A test has used the time that one may use."""


class Contexts:
    """A plugin of pytest: name the context of each test, and note its outcome and its CPU time.

    A test that uses more than so many seconds is ended, and left out of all that follows.
    """

    def __init__(self, measured: coverage.Coverage, longest: float) -> None:
        self._measured, self._longest = measured, longest
        self._start = self._began = 0.0
        self.tests: dict[str, dict[str, float | bool]] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> object:
        """Run a test, with all that it sets up, in its own context."""
        self.tests[item.nodeid] = {"seconds": 0.0, "passed": False}
        os.environ["MUTANTS_TEST"] = item.nodeid
        self._measured.switch_context(item.nodeid)
        self._start, self._began = used_seconds(), time.monotonic()
        try:
            return (yield)
        finally:
            self.tests[item.nodeid]["seconds"] = used_seconds() - self._start
            self._measured.switch_context("")
            os.environ["MUTANTS_TEST"] = ""

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self) -> object:
        """Limit the time that what a test needs may take."""
        with self._limited():
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self) -> object:
        """Limit the time that a test may take."""
        with self._limited():
            return (yield)

    @contextmanager
    def _limited(self) -> Iterator[None]:
        def look(_: int, frame: FrameType | None) -> None:
            waited = time.monotonic() - self._began
            long = used_seconds() - self._start > self._longest or waited > WAITING * self._longest
            # Whoever holds a lock of the tracer's would hold it for ever.
            if long and not any(is_tracer(outer.f_code.co_filename) for outer, _ in walk_stack(frame)):
                raise TooLong

        signal.signal(signal.SIGALRM, look)
        signal.setitimer(signal.ITIMER_REAL, 1.0, 1.0)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note whether a test passed: one that does not pass without a mutation notices none."""
        if report.when == "call":
            self.tests[report.nodeid]["passed"] = report.passed
        elif report.failed:
            self.tests[report.nodeid]["passed"] = False


def cover(test_file: str, place: Path, longest: float) -> None:
    """Run one test file here and write what its tests run to the place."""
    os.environ["MUTANTS_TEST"] = ""
    settings = place / "settings"
    settings.write_text(SETTINGS.format(place=place, sources=", ".join(str(Path.cwd() / p) for p in MUTATED)))
    (place / "sitecustomize.py").write_text("import coverage\n\ncoverage.process_startup()\n")
    measured = coverage.Coverage(config_file=str(settings), data_suffix="main")
    contexts = Contexts(measured, longest)
    measured.start()
    os.environ["COVERAGE_PROCESS_START"] = str(settings)
    os.environ["PYTHONPATH"] = os.pathsep.join([str(place), os.environ.get("PYTHONPATH", "")])
    code = pytest.main([test_file, "-q", "-n", "0", "-p", "no:cacheprovider"], plugins=[contexts])
    measured.stop()
    measured.save()
    if code not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise RuntimeError(f"{test_file} ended with {code!r}")
    lines: dict[str, dict[int, set[str]]] = {}
    for path in place.glob("data*"):
        data = coverage.CoverageData(str(path))
        data.read()
        for measured_file in data.measured_files():
            name = str(Path(measured_file).relative_to(Path.cwd()))
            for line, tests in data.contexts_by_lineno(measured_file).items():
                lines.setdefault(name, {}).setdefault(line, set()).update(tests)
    (place / "found.json").write_text(
        json.dumps(
            {
                "tests": contexts.tests,
                "lines": {
                    name: {str(line): sorted(tests) for line, tests in of_file.items()}
                    for name, of_file in lines.items()
                },
            }
        )
    )


def text_of(paths: list[Path]) -> str:
    """Return a fingerprint of the files' texts."""
    summed = hashlib.sha256()
    for path in sorted(paths):
        summed.update(str(path).encode() + path.read_bytes())
    return summed.hexdigest()[:16]


def cover_all(kept: Path, jobs: int, longest: float) -> list[dict[str, dict[str, object]]]:
    """Return what every test file of the folder we are in runs, from the kept results where they still hold."""
    kept.mkdir(parents=True, exist_ok=True)
    sources = [path for folder in (*MUTATED, "tests", "paper_checks") for path in Path(folder).rglob("*.py")]
    # Benchmarks are no part of the default run.
    sources = [path for path in sources if "benchmarks" not in path.parts]
    test_files = [path for path in sources if path.name.startswith("test_")]
    ground = text_of([path for path in sources if path not in test_files])

    def found(path: Path) -> dict[str, dict[str, object]]:
        result = kept / f"{path.stem}-{ground}-{text_of([path])}-{longest:g}.json"
        if not result.exists():
            start = time.time()
            with tempfile.TemporaryDirectory() as place:
                command = [sys.executable, __file__, str(path), place, str(longest)]
                run = subprocess.run(command, capture_output=True, text=True, check=False)
                made = Path(place, "found.json")
                if not made.exists():
                    raise RuntimeError(f"{path} could not be run:\n{run.stdout}\n{run.stderr}")
                result.write_text(made.read_text())
            print(f"covered {path} in {time.time() - start:.0f} s: {run.stdout.splitlines()[-1]}", flush=True)
        return json.loads(result.read_text())

    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(found, test_files))


if __name__ == "__main__":
    cover(sys.argv[1], Path(sys.argv[2]), float(sys.argv[3]))

"""The table of verdicts and the report at the end of the run."""

import importlib.util
from pathlib import Path

import pytest

from paper_checks.findings import collect
from paper_checks.terminal import print_verdicts


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare where the report goes."""
    parser.addoption(
        "--report",
        metavar="DIR",
        type=Path,
        help="write report.html and claims.json, all claims and figures, to DIR",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Say where thresholds are proved; refuse a report that could not be written before anything is computed."""
    folder = config.getoption("--report", None)
    if folder is not None or config.getoption("--thorough", default=False):
        from paper_checks.proved import (
            prove_everywhere,
        )  # imports the package, which the run's first process need not

        prove_everywhere()
    if folder is None:
        return
    if importlib.util.find_spec("matplotlib") is None:
        raise pytest.UsageError("the report's figures need matplotlib: pip install 'stickslip_sym[plot]'")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise pytest.UsageError(f"--report {folder}: {error.strerror}; give a folder that can be made") from None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the table of verdicts, and write the report if one was asked for."""
    findings = collect(report for some in terminalreporter.stats.values() for report in some)
    if findings:
        print_verdicts(terminalreporter, findings)
    folder = terminalreporter.config.getoption("--report", None)
    if folder is not None:
        from paper_checks.report import write

        terminalreporter.write("report: ", flush=True)
        terminalreporter.write_line(str(write(folder, findings)))

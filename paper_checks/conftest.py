"""The fixture that turns evidence into a verdict; the table of verdicts and the report at the end of the run."""

import importlib.util
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from paper_checks.claims import CLAIMS, Claim, Outcome
from paper_checks.findings import FINDING, Finding, collect
from paper_checks.printed import PRINTED
from paper_checks.terminal import print_verdicts

Find = Callable[..., None]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare where the report goes."""
    parser.addoption(
        "--report",
        metavar="DIR",
        type=Path,
        help="write report.html and claims.json, all claims and figures, to DIR",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Refuse a report that could not be written before anything is computed."""
    folder = config.getoption("--report", None)
    if folder is None:
        return
    if importlib.util.find_spec("matplotlib") is None:
        raise pytest.UsageError("the report's figures need matplotlib: pip install 'stickslip_sym[plot]'")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise pytest.UsageError(f"--report {folder}: {error.strerror}; give a folder that can be made") from None


@pytest.fixture
def find(request: pytest.FixtureRequest) -> Find:
    """Take the evidence of a check and hold it against the verdict on record.

    Called as ``find(ours=..., holds=..., proved=..., checked=..., estimated=..., reproduced=bool,
    qualified=bool, difference=...)``: what holds in one plain sentence; the evidence by its kind, at least one;
    two conditions that the check computed; the difference from the paper's value is a text, and optional.
    """
    claim = claim_of(request.node)

    def record(*, ours: str, holds: str, reproduced: bool, qualified: bool = False, **more: str) -> None:
        outcome = Outcome.of(reproduced, qualified)
        finding = Finding(claim.id, ours, outcome, holds, **more)
        assert finding.by_kind, f"{claim.id} has no evidence: tell what was proved, checked or estimated"
        # With the report of a test, it also reaches the process that prints the table when tests run in several.
        request.node.user_properties.append((FINDING, finding.pack()))
        expected = claim.outcome.value
        assert finding.as_recorded, f"{claim.id} is {outcome.value}, on record: {expected}\n{finding.evidence}"

    return record


@pytest.fixture
def printed(request: pytest.FixtureRequest) -> dict[str, Any]:
    """Return what the paper prints of the claim that a test checks."""
    return dict(PRINTED[claim_of(request.node).id])


def claim_of(node: Any) -> Claim:
    """Return the claim that a test is marked with."""
    return CLAIMS[node.get_closest_marker("claim").args[0]]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Fail a check that ends without a finding."""
    yield
    if item.get_closest_marker("claim") and not any(name == FINDING for name, _ in item.user_properties):
        pytest.fail(f"the check of {claim_of(item).id} ended without a finding")


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

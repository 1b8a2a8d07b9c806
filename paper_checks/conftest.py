"""The fixture that turns evidence into a verdict, and the table of verdicts at the end of the run."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from paper_checks.claims import CLAIMS, Claim, Outcome
from stickslip_sym import FrictionLaw, Oscillator, laws
from stickslip_sym.tables import table


@dataclass(frozen=True)
class Finding:
    """What a check found: our value, the verdict that its evidence gives, and the evidence in words."""

    claim: Claim
    ours: str
    outcome: Outcome
    evidence: str


FINDING = "finding"

Find = Callable[..., None]


def pytest_configure(config: pytest.Config) -> None:
    """Declare the marker that ties a test to its claim."""
    config.addinivalue_line("markers", "claim(id): the claim of the paper that this test checks")


@pytest.fixture
def find(request: pytest.FixtureRequest) -> Find:
    """Take the evidence of a check and hold it against the verdict on record.

    Called as ``find(ours=..., evidence=..., reproduced=bool, qualified=bool)``: both are conditions that
    the check computed.
    """
    claim = claim_of(request.node)

    def record(*, ours: str, evidence: str, reproduced: bool, qualified: bool = False) -> None:
        outcome = Outcome.NOT_REPRODUCED
        if reproduced:
            outcome = Outcome.REPRODUCED
        elif qualified:
            outcome = Outcome.QUALIFIED
        # With the report, it also reaches the process that prints the table when tests run in several.
        request.node.user_properties.append((FINDING, (claim.id, ours, outcome.value, evidence)))
        expected = claim.outcome.value
        assert outcome is claim.outcome, f"{claim.id} is {outcome.value}, on record: {expected}\n{evidence}"

    return record


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
    """Print the table of verdicts."""
    reports = [report for some in terminalreporter.stats.values() for report in some if hasattr(report, "when")]
    found = {
        value[0]: Finding(CLAIMS[value[0]], value[1], Outcome(value[2]), value[3])
        for report in reports
        for name, value in report.user_properties
        if name == FINDING
    }
    findings = [found[claim] for claim in CLAIMS if claim in found]
    if not findings:
        return
    terminalreporter.section("claims of the paper")
    rows = [[f.claim.id, f.claim.says, f.claim.paper, f.ours, f.outcome.value] for f in findings]
    terminalreporter.write_line(table(["id", "claim", "paper", "ours", "verdict"], rows))
    terminalreporter.write_line("")
    for finding in findings:
        if finding.outcome is not Outcome.REPRODUCED:
            terminalreporter.write_line(f"{finding.claim.id}: {finding.evidence}")
    counts = {outcome: sum(f.outcome is outcome for f in findings) for outcome in Outcome}
    terminalreporter.write_line(", ".join(f"{count} {outcome.value}" for outcome, count in counts.items()))


@pytest.fixture
def exponential() -> FrictionLaw:
    """Return the law (3) with the parameters of the paper's section 3."""
    return laws.exponential.bind(mu_s="0.5", mu_m="0.2", alpha="3")


@pytest.fixture
def polynomial() -> FrictionLaw:
    """Return the law (4) with the parameters of the paper's section 3."""
    return laws.polynomial.bind(mu_s="0.5", mu_m="0.2", v_m="1")


def oscillator(c: float = 0.0, V: float = 0.5) -> Oscillator:
    """Return the oscillator of the paper's section 3."""
    return Oscillator(m=1.0, k=100.0, c=c, V=V, N=9.81)

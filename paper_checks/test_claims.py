"""Each claim of the paper: its check must come to the verdict that is on record."""

from collections.abc import Callable

import pytest

# Importing the checks puts them into CHECKS, so that nothing of them is used here.
from paper_checks import check_criteria, check_equations, check_figures, check_motion, check_numbers  # noqa: F401  # which register their checks
from paper_checks.claims import CLAIMS
from paper_checks.findings import CHECKS, FINDING
from paper_checks.printed import PRINTED


@pytest.mark.parametrize("id", CLAIMS)
def test_claim(id: str, record_property: Callable[[str, object], None]) -> None:
    """The evidence gives the verdict on record; the finding travels to the table and the report."""
    finding = CHECKS[id](dict(PRINTED[id]))
    assert finding.by_kind, f"{id} has no evidence: say what was proved, checked or estimated"
    record_property(FINDING, finding.pack())
    expected = CLAIMS[id].outcome.value
    assert finding.as_recorded, f"{id} is {finding.outcome.value}, on record: {expected}\n{finding.evidence}"

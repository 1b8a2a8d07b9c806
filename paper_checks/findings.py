"""What a check found, on its way from the test to the terminal and the report."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from typing import Any

from paper_checks.claims import CLAIMS, Claim, Outcome

__all__ = ["FINDING", "KINDS", "SHORT", "Finding", "collect", "summary"]

FINDING = "finding"
"""Name of the property of a test under which its finding travels to the process that collects them."""

SHORT = {
    Outcome.REPRODUCED: "reproduced",
    Outcome.QUALIFIED: "qualified",
    Outcome.NOT_REPRODUCED: "not reproduced",
}
"""What a table calls the outcomes."""
KINDS = {"PROVED": "proof", "CHECKED": "check", "ESTIMATED": "estimate"}
"""What evidence may be: an exact zero or an enclosure by a theorem; agreement with an independent computation; a
number whose error is estimated."""


@dataclass(frozen=True)
class Finding:
    """What a check found.

    Attributes
    ----------
    id : str
        Of the claim.
    ours : str
        Our value.
    outcome : Outcome
        The verdict that the evidence gives.
    holds : str
        In one plain sentence, without its stop: what holds and what does not.
    proved, checked, estimated : str
        What was found, by kind of evidence; empty where nothing was.
    difference : str
        Between the paper's value and ours; empty where the claim is no number.
    """

    id: str
    ours: str
    outcome: Outcome
    holds: str
    proved: str = ""
    checked: str = ""
    estimated: str = ""
    difference: str = ""

    @property
    def claim(self) -> Claim:
        """The claim it is about."""
        return CLAIMS[self.id]

    @property
    def by_kind(self) -> dict[str, str]:
        """The evidence, by its kind as results have it: PROVED, CHECKED, ESTIMATED."""
        texts = zip(KINDS, (self.proved, self.checked, self.estimated), strict=True)
        return {kind: text for kind, text in texts if text}

    @property
    def kinds(self) -> str:
        """The kinds of evidence, as nouns."""
        return ", ".join(KINDS[kind] for kind in self.by_kind)

    @property
    def evidence(self) -> str:
        """The plain sentence, and the evidence after it, each with its kind."""
        return ". ".join([self.holds, *(f"{kind}: {text}" for kind, text in self.by_kind.items())])

    @property
    def as_recorded(self) -> bool:
        """Whether the verdict is the one on record."""
        return self.outcome is self.claim.outcome

    def pack(self) -> tuple[str, ...]:
        """Return it as texts, which can be sent to another process."""
        return tuple(field.value if isinstance(field, Outcome) else field for field in astuple(self))

    @classmethod
    def unpack(cls, texts: Sequence[str]) -> "Finding":
        """Return the finding that was packed."""
        id, ours, outcome, *rest = texts
        return cls(id, ours, Outcome(outcome), *rest)


def collect(reports: Iterable[Any]) -> list[Finding]:
    """Return the findings of all reports of tests, in the order of the claims."""
    found = {
        value[0]: Finding.unpack(value)
        for report in reports
        for name, value in getattr(report, "user_properties", ())
        if name == FINDING
    }
    return [found[id] for id in CLAIMS if id in found]


def summary(findings: Sequence[Finding]) -> dict[Outcome, int]:
    """Return how many findings there are of each outcome."""
    counts = Counter(finding.outcome for finding in findings)
    return {outcome: counts[outcome] for outcome in Outcome}

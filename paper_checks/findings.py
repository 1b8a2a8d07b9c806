"""What a check found, on its way from the check to the terminal and the report."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from typing import Any

from paper_checks.claims import CLAIMS, Claim, Outcome

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
    """What a check found, its evidence by kind."""

    id: str  # of the claim
    ours: str  # our value
    outcome: Outcome  # the verdict that the evidence gives
    holds: str  # what holds and what does not, in one plain sentence without its stop
    proved: str = ""
    checked: str = ""
    estimated: str = ""
    difference: str = ""  # between the paper's value and ours; empty where the claim is no number

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


Find = Callable[..., Finding]
"""What makes a finding of the evidence of a check.

Called as ``find(ours=..., holds=..., proved=..., checked=..., estimated=..., reproduced=bool, qualified=bool,
difference=...)``: what holds in one plain sentence; the evidence by its kind, at least one; two conditions that
the check computed; the difference from the paper's value is a text, and optional.
"""
Printed = dict[str, Any]
"""What the paper prints of a claim, by the name of each datum."""
CHECKS: dict[str, Callable[[Printed], Finding]] = {}
"""The check of each claim, which finds from what is printed."""


def check(id: str, **more: Any) -> Callable[[Callable[..., Finding]], Callable[..., Finding]]:
    """Return a decorator: the function checks a claim, with further arguments where it checks several."""

    def find(*, ours: str, holds: str, reproduced: bool, qualified: bool = False, **evidence: str) -> Finding:
        return Finding(id, ours, Outcome.of(reproduced, qualified), holds, **evidence)

    def registered(function: Callable[..., Finding]) -> Callable[..., Finding]:
        assert id not in CHECKS, f"{id} has two checks"
        CHECKS[id] = partial(function, find, **more)
        return function

    return registered


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

"""The checks of the paper, run in this process on other data than are printed."""

import importlib
from pathlib import Path

import paper_checks
from paper_checks.claims import Outcome
from paper_checks.findings import Finding

FILES = sorted(Path(paper_checks.__file__).parent.glob("test_*.py"))


def checks():
    """Return the check of each claim."""
    found = {}
    for path in FILES:
        for function in vars(importlib.import_module(f"paper_checks.{path.stem}")).values():
            for mark in getattr(function, "pytestmark", ()):
                if mark.name == "claim":
                    assert mark.args[0] not in found
                    found[mark.args[0]] = function
    return found


CHECKS = checks()


def verdict(claim, printed):
    """Run a check in this process and return the verdict that it comes to."""
    return found(claim, printed).outcome


def found(claim, printed):
    """Run a check in this process and return what it finds."""
    findings = []

    def find(*, ours, holds, reproduced, qualified=False, **more):
        finding = Finding(claim, ours, Outcome.of(reproduced, qualified), holds, **more)
        assert finding.ours
        assert finding.holds
        assert finding.by_kind
        findings.append(finding)

    CHECKS[claim](find, printed)
    (finding,) = findings
    return finding

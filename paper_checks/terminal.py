"""The table of verdicts on a terminal: as wide as the terminal is, in colour where it has any."""

from collections.abc import Sequence
from typing import Any

import pytest
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from paper_checks.claims import Outcome
from paper_checks.findings import SHORT, Finding, summary

_COLOURS = {Outcome.REPRODUCED: "green", Outcome.QUALIFIED: "yellow", Outcome.NOT_REPRODUCED: "bold red"}


def print_verdicts(reporter: pytest.TerminalReporter, findings: Sequence[Finding]) -> None:
    """Print the table, the evidence of all that is not simply reproduced, and the summary."""
    writer = reporter.config.get_terminal_writer()
    reporter.section("claims of the paper")
    coloured: dict[str, Any] = {"force_terminal": True, "color_system": "standard"} if writer.hasmarkup else {}
    console = Console(width=writer.fullwidth - 1, **coloured)
    with console.capture() as captured:
        console.print(verdicts(findings))
    reporter.write("\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n")


def verdicts(findings: Sequence[Finding]) -> Group:
    """Return what is printed of findings."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for name in ("id", "verdict", "evidence", "claim", "paper", "ours"):
        table.add_column(name, overflow="fold")
    for one in findings:
        verdict = Text(SHORT[one.outcome], style=_COLOURS[one.outcome])
        table.add_row(one.id, verdict, one.kinds, *map(Text, (one.claim.says, one.claim.paper, one.ours)))
    others = [finding for finding in findings if finding.outcome is not Outcome.REPRODUCED]
    notes = [Text(f"{finding.id}: {finding.evidence}") for finding in others]
    counts = [
        Text(f"{count} {SHORT[outcome]}", style=_COLOURS[outcome] if count else "")
        for outcome, count in summary(findings).items()
    ]
    return Group(table, "", *notes, Text(", ").join(counts))

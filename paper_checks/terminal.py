"""The table of verdicts on a terminal: as wide as the terminal is, in colour where it has any."""

from collections.abc import Sequence
from typing import Any

import pytest
from rich.console import Console, Group
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from paper_checks.claims import Outcome
from paper_checks.findings import SHORT, Finding, summary

__all__ = ["print_verdicts", "verdicts"]

_COLOURS = {Outcome.REPRODUCED: "green", Outcome.QUALIFIED: "yellow", Outcome.NOT_REPRODUCED: "bold red"}
_NARROW = 70  # columns of a terminal below which the cells of a claim go under each other


def print_verdicts(reporter: pytest.TerminalReporter, findings: Sequence[Finding]) -> None:
    """Print the table, the evidence of all that is not simply reproduced, and the summary."""
    writer = reporter.config.get_terminal_writer()
    reporter.section("claims of the paper")
    coloured: dict[str, Any] = {"force_terminal": True, "color_system": "standard"} if writer.hasmarkup else {}
    console = Console(width=writer.fullwidth - 1, **coloured)
    with console.capture() as captured:
        console.print(verdicts(findings, console.width))
    reporter.write("\n".join(line.rstrip() for line in captured.get().splitlines()) + "\n")


def verdicts(findings: Sequence[Finding], width: int) -> Group:
    """Return what is printed of findings in a width."""
    counts = [
        Text(f"{count} {SHORT[outcome]}", style=_COLOURS[outcome] if count else "")
        for outcome, count in summary(findings).items()
    ]
    others = [finding for finding in findings if finding.outcome is not Outcome.REPRODUCED]
    notes = [Text(f"{finding.id}: {finding.evidence}") for finding in others]
    return Group(_table(findings) if width >= _NARROW else _list(findings), "", *notes, Text(", ").join(counts))


def _table(findings: Sequence[Finding]) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for name in ("id", "verdict", "evidence", "claim", "paper", "ours"):
        table.add_column(name, no_wrap=name in ("id", "verdict"), overflow="fold")
    for one in findings:
        verdict = Text(SHORT[one.outcome], style=_COLOURS[one.outcome])
        table.add_row(one.id, verdict, one.kinds, *map(Text, (one.claim.says, one.claim.paper, one.ours)))
    return table


def _list(findings: Sequence[Finding]) -> Group:
    lines: list[Text | Padding] = []
    for one in findings:
        lines.append(Text.assemble(one.id, "  ", (SHORT[one.outcome], _COLOURS[one.outcome])))
        cells = (one.claim.says, f"paper: {one.claim.paper}", f"ours: {one.ours}", f"by {one.kinds}")
        lines += [Padding(Text(cell, overflow="fold"), (0, 0, 0, 4)) for cell in cells]
    return Group(*lines)

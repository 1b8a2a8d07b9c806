"""The table of verdicts on a terminal: as wide as the terminal is, in colour where it has any."""

import textwrap
from collections.abc import Iterator, Sequence
from itertools import zip_longest

import pytest

from paper_checks.claims import Outcome
from paper_checks.findings import Finding, summary

__all__ = ["MARKUP", "SHORT", "print_verdicts", "table_lines"]

SHORT = {
    Outcome.REPRODUCED: "reproduced",
    Outcome.QUALIFIED: "qualified",
    Outcome.NOT_REPRODUCED: "not reproduced",
}
MARKUP = {
    Outcome.REPRODUCED: {"green": True},
    Outcome.QUALIFIED: {"yellow": True},
    Outcome.NOT_REPRODUCED: {"red": True, "bold": True},
}
_GAP = 2
_NARROWEST = 12  # columns of text; below that a table cannot be read, and cells go under each other
_HEADER = ("id", "verdict", "evidence", "claim", "paper", "ours")


def print_verdicts(reporter: pytest.TerminalReporter, findings: Sequence[Finding]) -> None:
    """Print the table, the evidence of all that is not simply reproduced, and the summary."""
    width = reporter.config.get_terminal_writer().fullwidth
    reporter.section("claims of the paper")
    for outcome, line in table_lines(findings, width):
        if outcome is None:
            reporter.write_line(line, bold=True)
            continue
        before, verdict, after = line.partition(SHORT[outcome])
        reporter.write(before)
        reporter.write(verdict, **MARKUP[outcome])
        reporter.write_line(after)
    reporter.write_line("")
    for finding in findings:
        if finding.outcome is not Outcome.REPRODUCED:
            reporter.write_line(_paragraph(f"{finding.id}: {finding.evidence}", width))
    parts = {outcome: f"{count} {SHORT[outcome]}" for outcome, count in summary(findings).items()}
    between = ", " if len(", ".join(parts.values())) < width else ",\n"
    for position, (outcome, part) in enumerate(parts.items()):
        reporter.write(between if position else "")
        reporter.write(part, **({} if part.startswith("0 ") else MARKUP[outcome]))
    reporter.write_line("")


def _paragraph(text: str, width: int) -> str:
    return "\n".join(textwrap.wrap(text, width - 1, subsequent_indent="    "))


def table_lines(findings: Sequence[Finding], width: int) -> Iterator[tuple[Outcome | None, str]]:
    """Yield the lines of the table, none as long as the width; with its outcome where a line begins a claim.

    The other lines of a claim come with its first, after line feeds.
    """
    rows = [(f.id, SHORT[f.outcome], f.kinds, f.claim.says, f.claim.paper, f.ours) for f in findings]
    fixed = [max(len(row[column]) for row in [_HEADER, *rows]) for column in (0, 1)]
    fixed.append(max(len(word) for row in [_HEADER, *rows] for word in row[2].split()))  # a kind a line
    room = width - 1 - sum(fixed) - _GAP * (len(_HEADER) - 1)
    if room < 3 * _NARROWEST:
        for finding, (id, verdict, kinds, says, paper, ours) in zip(findings, rows, strict=True):
            cells = (says, f"paper: {paper}", f"ours: {ours}", f"by {kinds}")
            wrapped = [textwrap.wrap(cell, max(width - 5, 8)) for cell in cells]
            below = [f"    {line}" for lines in wrapped for line in lines]
            yield finding.outcome, "\n".join([f"{id}  {verdict}", *below])
        return
    natural = [max(len(row[column]) for row in [_HEADER, *rows]) for column in (3, 4, 5)]
    widths = [*fixed, *_shares(natural, room)]
    yield None, _cells(_HEADER, widths)
    for finding, row in zip(findings, rows, strict=True):
        yield finding.outcome, _cells(row, widths)


def _shares(natural: Sequence[int], room: int) -> list[int]:
    """Return widths of columns: what a column does not need goes to those that need more."""
    shares = [0] * len(natural)
    for done, column in enumerate(sorted(range(len(natural)), key=natural.__getitem__)):
        shares[column] = min(natural[column], room // (len(natural) - done))
        room -= shares[column]
    return shares


def _cells(row: Sequence[str], widths: Sequence[int]) -> str:
    columns = [textwrap.wrap(cell, width) or [""] for cell, width in zip(row, widths, strict=True)]
    gap = " " * _GAP
    return "\n".join(
        gap.join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in zip_longest(*columns, fillvalue="")
    )

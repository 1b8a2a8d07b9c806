"""The page of a report, from the template ``report.html``."""

import re
from pathlib import Path
from typing import TYPE_CHECKING

from paper_checks.claims import CLAIMS, Outcome
from paper_checks.figures import FIGURES
from paper_checks.findings import SHORT, summary
from paper_checks.formulas import EQUATIONS
from stickslip_sym.output.page.render import render
from stickslip_sym.output.tables import duration

if TYPE_CHECKING:
    from paper_checks.report import Report

__all__ = ["page"]

_TITLE = "Stick–slip vibration of an oscillator with damping, checked by machine"
_SIGNS = {Outcome.REPRODUCED: "✓", Outcome.QUALIFIED: "◐", Outcome.NOT_REPRODUCED: "✗"}


def page(report: "Report") -> str:
    """Return the whole page."""
    findings = list(report.findings.values())
    return render(
        Path(__file__).with_name("report.html"),
        title=_TITLE,
        time=report.time,
        report=report,
        claims=CLAIMS,
        counts=summary(findings),
        exceptions=[finding for finding in findings if finding.outcome is not Outcome.REPRODUCED],
        equations=EQUATIONS,
        figures=FIGURES,
        columns=("", "claim", "paper", "ours", "difference", "verdict"),
        groups={"E": "Equations", "N": "Numbers", "F": "Figures", "S": "Statements"},
        signs=_SIGNS,
        short=SHORT,
        css=lambda outcome: SHORT[outcome].replace(" ", "-"),
        sentence=_sentence,
        duration=duration,
    )


def _sentence(text: str) -> str:
    """Return text with a capital, unless it begins with a symbol, and a stop."""
    return re.sub(r"^[a-z]{2,} ", lambda word: word[0].capitalize(), text) + "."

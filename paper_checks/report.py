"""The report of a run: ``report.html`` to be read, ``claims.json`` to be computed with."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from paper_checks.claims import CLAIMS, Claim, Outcome
from paper_checks.computed import LAWS, law, oscillator
from paper_checks.figures import FIGURES
from paper_checks.findings import SHORT, Finding, summary
from paper_checks.formulas import EQUATIONS
from stickslip_sym.comparison.trade import Row
from stickslip_sym.comparison.tradeoff import SPEEDS, tradeoff
from stickslip_sym.output.drawing import svg_uri
from stickslip_sym.output.page.render import now, versions

__all__ = ["POINT", "Report", "write"]

POINT = {name: getattr(oscillator(), name) for name in "VNmk"}
_FORMAT = 3


@dataclass(frozen=True)
class Report:
    """All that a report tells.

    Attributes
    ----------
    findings : dict
        By the identifiers of claims; a claim that was not checked in this run has none.
    pictures : dict
        Numbers of figures to data URIs.
    methods : dict
        Names of laws to the methods for a threshold, measured.
    versions : dict
    time : str
    """

    findings: dict[str, Finding]
    pictures: dict[int, str]
    methods: dict[str, tuple[Row, ...]]
    versions: dict[str, str]
    time: str

    def verdict(self, claim: Claim) -> Outcome | None:
        """Return the outcome of a claim in this run."""
        return self.findings[claim.id].outcome if claim.id in self.findings else None


def write(folder: Path, findings: Sequence[Finding]) -> Path:
    """Write the report to a folder; returns the file to be opened."""
    from paper_checks.report_page import page

    report = Report(
        {finding.id: finding for finding in findings},
        {figure.number: svg_uri(figure.draw()) for figure in FIGURES},
        {name: tradeoff(law(name), of="threshold", **POINT).trades["threshold"].rows for name in LAWS},
        versions(),
        now(),
    )
    (folder / "claims.json").write_text(
        json.dumps(as_json(report), indent=1, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8"
    )
    target = folder / "report.html"
    target.write_text(page(report), encoding="utf-8")
    return target


def as_json(report: Report) -> dict[str, Any]:
    """Return the report for machines; pictures are in the page only."""
    counts = summary(list(report.findings.values()))
    return {
        "format": _FORMAT,
        "time": report.time,
        "versions": report.versions,
        "summary": {SHORT[outcome]: count for outcome, count in counts.items()}
        | {"not checked": len(CLAIMS) - len(report.findings)},
        "claims": [_claim(claim, report.findings.get(claim.id)) for claim in CLAIMS.values()],
        "equations": [
            {"number": e.number, "about": e.about, "claims": list(e.claims), "mathml": e.mathml()}
            for e in EQUATIONS
        ],
        "figures": [
            {
                "number": f.number,
                "title": f.title,
                "shown": f.shown,
                "left_out": f.left_out,
                "claims": list(f.claims),
            }
            for f in FIGURES
        ],
        "methods": {
            "operating_point": POINT,
            "speeds": SPEEDS.tolist(),
            "laws": {
                name: [
                    {
                        "method": row.name,
                        "seconds": row.seconds if row.found else None,
                        "relative_error": row.error if row.found else None,
                        "largest_relative_error": _finite(row.further.get("largest")),
                        "status": row.further.get("status"),
                    }
                    for row in rows
                ]
                for name, rows in report.methods.items()
            },
        },
    }


def _finite(value: float | str | None) -> float | None:
    return value if isinstance(value, float) and math.isfinite(value) else None


def _claim(claim: Claim, finding: Finding | None) -> dict[str, Any]:
    return {
        "id": claim.id,
        "where": claim.where,
        "says": claim.says,
        "paper": claim.paper,
        "ours": finding.ours if finding else None,
        "difference": (finding.difference or None) if finding else None,
        "verdict": finding.outcome.value if finding else None,
        "on_record": claim.outcome.value,
        "holds": finding.holds if finding else None,
        "evidence": finding.by_kind if finding else None,
    }

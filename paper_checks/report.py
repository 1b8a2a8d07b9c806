"""The report of a run: ``report.html`` to be read, ``claims.json`` to be computed with."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import derivations
from paper_checks.claims import CLAIMS, Claim, Outcome
from paper_checks.computed import LAWS, law, oscillator
from paper_checks.figures import FIGURES
from paper_checks.findings import SHORT, Finding, summary
from paper_checks.formulas import EQUATIONS
from paper_checks.proved import THEOREMS, theorem
from stickslip_sym.comparison.compare import Row
from stickslip_sym.comparison.tradeoff import SPEEDS, tradeoff
from stickslip_sym.motion.thresholds.theorem import Theorem
from stickslip_sym.output.tables import duration, now
from stickslip_sym.views.drawing import svg_uri
from stickslip_sym.views.pages.render import render, versions

_POINT = {name: getattr(oscillator(), name) for name in "VNmk"}
_FORMAT = 3
_TITLE = "Stick–slip vibration of an oscillator with damping, checked by machine"
_PROOFS = Path(derivations.__file__).with_name("certificates")
_CERTIFIED = {"(15)": "least_squares", "(16)": "least_squares", "(17)": "exponential_least_squares",
              "(18)": "polynomial_least_squares"}  # fmt: skip
_IN_COQ = {"(15)": "least_squares", "(16)": "least_squares", "(17)": "exponential_law", "(18)": "polynomial_law"}
_SIGNS = {Outcome.REPRODUCED: "✓", Outcome.QUALIFIED: "◐", Outcome.NOT_REPRODUCED: "✗"}


@dataclass(frozen=True)
class Report:
    """All that a report says."""

    findings: dict[str, Finding]  # of the claims that were checked in this run
    pictures: dict[int, str]  # data URIs of the figures
    methods: dict[str, tuple[Row, ...]]  # for a threshold, measured, by law
    versions: dict[str, str]
    time: str

    def verdict(self, claim: Claim) -> Outcome | None:
        """Return the outcome of a claim in this run."""
        return self.findings[claim.id].outcome if claim.id in self.findings else None


def write(folder: Path, findings: Sequence[Finding]) -> Path:
    """Write the report to a folder; returns the file to be opened."""
    report = Report(
        {finding.id: finding for finding in findings},
        {figure.number: svg_uri(figure.draw()) for figure in FIGURES},
        {name: tradeoff(law(name), of="threshold", **_POINT).trades["threshold"].rows for name in LAWS},
        versions(),
        now(),
    )
    (folder / "certificates").mkdir(exist_ok=True)
    for name, text in certificates().items():
        (folder / name).write_text(text, encoding="utf-8")
    content = json.dumps(as_json(report), indent=1, ensure_ascii=False, allow_nan=False)
    (folder / "claims.json").write_text(content + "\n", encoding="utf-8")
    target = folder / "report.html"
    target.write_text(page(report), encoding="utf-8")
    return target


def certificates() -> dict[str, str]:
    """Return scripts that prove equations and thresholds without this package, by the files that hold them."""
    proofs = [*_PROOFS.glob("*.py"), *_PROOFS.glob("*.v")]
    scripts = {f"certificates/{path.name}": path.read_text(encoding="utf-8") for path in proofs}
    return scripts | {file: proof.certificate() for file, proof in _theorems().items()}


def _theorems() -> dict[str, Theorem]:
    """Return those of the table of methods, and of the claims of this run, by the files that prove them."""
    for name in LAWS:
        theorem(name)
    points = {f"{name}_V{V}_k{k}": proof for (name, V, k), proof in sorted(THEOREMS.items())}
    return {f"certificates/{point}.py": proof for point, proof in points.items()}


def page(report: Report) -> str:
    """Return the whole page."""
    findings = list(report.findings.values())
    return render(
        Path(__file__).with_name("report.html"),
        title=_TITLE, time=report.time, report=report, claims=CLAIMS, counts=summary(findings),
        exceptions=[finding for finding in findings if finding.outcome is not Outcome.REPRODUCED],
        equations=EQUATIONS, figures=FIGURES,
        columns=("", "claim", "paper", "ours", "difference", "verdict"),
        groups={"E": "Equations", "N": "Numbers", "F": "Figures", "S": "Statements"},
        signs=_SIGNS, short=SHORT, css=lambda outcome: SHORT[outcome].replace(" ", "-"),
        certified=_CERTIFIED, in_coq=_IN_COQ, theorems=_theorems(), sentence=_sentence, duration=duration,
    )  # fmt: skip


def _sentence(text: str) -> str:
    """Return text with a capital, unless it begins with a symbol, and a stop."""
    return re.sub(r"^[a-z]{2,} ", lambda word: word[0].capitalize(), text) + "."


def as_json(report: Report) -> dict[str, Any]:
    """Return the report for machines; pictures are in the page only."""
    counts = {SHORT[outcome]: count for outcome, count in summary(list(report.findings.values())).items()}
    figures = ("number", "title", "shown", "left_out", "claims")
    laws = {name: [_method(row) for row in rows] for name, rows in report.methods.items()}
    return {
        "format": _FORMAT,
        "time": report.time,
        "versions": report.versions,
        "summary": {**counts, "not checked": len(CLAIMS) - len(report.findings)},
        "claims": [_claim(claim, report.findings.get(claim.id)) for claim in CLAIMS.values()],
        "equations": [
            {"number": one.number, "about": one.about, "claims": list(one.claims), "mathml": one.mathml()}
            for one in EQUATIONS
        ],
        "figures": [{key: getattr(figure, key) for key in figures} for figure in FIGURES],
        "methods": {"operating_point": _POINT, "speeds": SPEEDS.tolist(), "laws": laws},
    }


def _method(row: Row) -> dict[str, Any]:
    return {
        "method": row.name,
        "seconds": row.seconds,
        "relative_error": row.relative_error,
        "largest_relative_error": next(iter(row.further.values()), None),
        "status": row.status and row.status.value,
    }


def _claim(claim: Claim, finding: Finding | None) -> dict[str, Any]:
    return {
        "id": claim.id, "where": claim.where, "says": claim.says, "paper": claim.paper,
        "ours": finding.ours if finding else None,
        "difference": (finding.difference or None) if finding else None,
        "verdict": finding.outcome.value if finding else None,
        "on_record": claim.outcome.value,
        "holds": finding.holds if finding else None,
        "evidence": finding.by_kind if finding else None,
    }  # fmt: skip

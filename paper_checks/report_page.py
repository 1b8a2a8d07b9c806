"""The page of a report: well-formed HTML that needs no script and nothing from elsewhere."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from paper_checks.claims import CLAIMS, Claim, Outcome
from paper_checks.figures import FIGURES, PaperFigure
from paper_checks.findings import Finding, summary
from paper_checks.formulas import EQUATIONS, PrintedEquation
from paper_checks.terminal import SHORT
from stickslip_sym.output.page import document
from stickslip_sym.output.page.elements import Html, element, prose, raw
from stickslip_sym.output.tables import duration

if TYPE_CHECKING:
    from paper_checks.report import Report

__all__ = ["claim_rows", "page"]

_STYLE = Path(__file__).with_name("report.css")
_TITLE = "Stick–slip vibration of an oscillator with damping, checked by machine"
_SIGNS = {Outcome.REPRODUCED: "✓", Outcome.QUALIFIED: "◐", Outcome.NOT_REPRODUCED: "✗"}
_GROUPS = {"E": "Equations", "N": "Numbers", "F": "Figures", "S": "Statements"}
_COLUMNS = ("", "claim", "paper", "ours", "difference", "verdict")


def page(report: "Report") -> str:
    """Return the whole page."""
    style = _STYLE.read_text(encoding="utf-8")
    parts = [exceptions(report), claims(report), equations(report), figures(report), ladder(report)]
    return document.page(_TITLE, [header(report), contents()], parts, footer(report), style)


def header(report: "Report") -> Html:
    """Say what was checked, and how it came out."""
    counts = summary(list(report.findings.values()))
    items = [
        element(
            "span", element("b", str(count)), " ", _sign(outcome), class_=_class(outcome) if count else "not-run"
        )
        for outcome, count in counts.items()
    ]
    missing = len(CLAIMS) - len(report.findings)
    if missing:
        items.append(element("span", element("b", str(missing)), " not checked in this run", class_="not-run"))
    return element(
        "header",
        element("h1", _TITLE),
        element(
            "p",
            "H.-I. Won and J. Chung, ",
            element("i", "Nonlinear Dynamics"),
            f", 2016. The {len(CLAIMS)} claims taken from the paper, each with the verdict of a computation. "
            "Numbers of equations and figures are the paper’s. Evidence is a proof (PROVED), agreement with an "
            "independent computation (CHECKED), or a number whose error is estimated (ESTIMATED).",
            class_="source",
        ),
        element("div", *items, class_="counts"),
    )


def contents() -> Html:
    """List what there is, by the paper's numbers."""
    rows = [
        ("Claims", "claims", [(claim, f"claim-{claim}") for claim in CLAIMS]),
        ("Equations", "equations", [(e.number, _anchor(e)) for e in EQUATIONS]),
        ("Figures", "figures", [(str(f.number), f"figure-{f.number}") for f in FIGURES]),
        ("Ladder", "ladder", []),
        ("Versions", "versions", []),
    ]
    items = [
        element(
            "li",
            element("a", name, href=f"#{anchor}"),
            element("span", *(element("a", text, href=f"#{target}") for text, target in links)),
        )
        for name, anchor, links in rows
    ]
    return element("nav", element("ul", *items), aria_label="Contents")


def exceptions(report: "Report") -> Html:
    """Tell first what does not hold as printed."""
    found = [finding for finding in report.findings.values() if finding.outcome is not Outcome.REPRODUCED]
    if not found:
        words = "Every claim checked in this run was reproduced."
        return element("section", element("h2", "What does not hold as printed"), element("p", words))
    items = [
        element(
            "li",
            element(
                "p",
                _link(finding.claim),
                " ",
                element("b", prose(finding.claim.says)),
                ": ",
                _badge(finding.outcome),
            ),
            *_evidence(finding),
        )
        for finding in found
    ]
    return element(
        "section", element("h2", "What does not hold as printed"), element("ul", *items, class_="exceptions")
    )


def claims(report: "Report") -> Html:
    """Return the table of claims."""
    head = element("thead", element("tr", *(element("th", name, scope="col") for name in _COLUMNS)))
    bodies = []
    for letter, group in _GROUPS.items():
        rows = [claim for claim in CLAIMS.values() if claim.id.startswith(letter)]
        if rows:
            title = element("th", group, colspan=str(len(_COLUMNS)), scope="colgroup")
            bodies.append(element("tbody", element("tr", title), class_="group"))
        bodies += [claim_rows(claim, report.findings.get(claim.id)) for claim in rows]
    table = element("table", head, *bodies, class_="claims")
    return element("section", element("h2", "Claims"), table, id="claims")


def claim_rows(claim: Claim, finding: Finding | None) -> Html:
    """Return the rows of one claim; its finding is None if it was not checked."""
    cells = [claim.says, claim.paper, finding.ours if finding else "", finding.difference if finding else ""]
    first = element("th", claim.id, scope="row")
    columns = [
        element("td", prose(cell), data_label=name) if cell else element("td")
        for name, cell in zip(_COLUMNS[1:], cells, strict=False)
    ]
    verdict = _badge(finding.outcome if finding else None)
    if finding and not finding.as_recorded:
        verdict = raw(verdict + element("span", f" (on record: {SHORT[claim.outcome]})", class_="note"))
    if finding:
        verdict = raw(verdict + element("span", f" by {finding.kinds}", class_="note"))
    evidence = _evidence(finding) if finding else ["No finding in this run."]
    where = element("td", prose(claim.where))
    return element(
        "tbody",
        element("tr", first, *columns, element("td", verdict, data_label="verdict")),
        element("tr", where, element("td", *evidence, colspan="5"), class_="evidence"),
        class_="claim",
        id=f"claim-{claim.id}",
    )


def equations(report: "Report") -> Html:
    """Return the printed equations with the verdicts on them."""
    note = (
        "As they stand in the paper but for the order of terms and factors, from the expressions that the checks "
        "use; in (12) and (13), (8) is put in."
    )
    items = [
        element(
            "div",
            element("div", raw(equation.mathml()), class_="formulas"),
            element("span", equation.number),
            element("span", equation.about, ". ", *_verdicts(report, equation.claims), class_="about"),
            class_="equation",
            id=_anchor(equation),
        )
        for equation in EQUATIONS
    ]
    return element(
        "section", element("h2", "Equations"), element("p", note, class_="note"), *items, id="equations"
    )


def figures(report: "Report") -> Html:
    """Return the figures."""
    note = (
        "Redrawn from this computation over the paper’s ranges. Black is what the paper shows; colour is what it "
        "leaves out."
    )
    drawn = [_figure(report, figure) for figure in FIGURES]
    title = element("h2", "Figures")
    return element("section", title, element("p", note, class_="note"), *drawn, id="figures", class_="figures")


def _figure(report: "Report", figure: PaperFigure) -> Html:
    alt = f"Figure {figure.number}: {figure.title}. {figure.shown} Left out by the paper: {figure.left_out}"
    caption = element(
        "figcaption",
        element("b", f"Figure {figure.number}. {figure.title}."),
        f" {figure.shown} ",
        element("i", "Left out by the paper:"),
        f" {figure.left_out} ",
        *_verdicts(report, figure.claims),
    )
    picture = element("img", src=report.pictures[figure.number], alt=alt)
    return element("figure", picture, caption, id=f"figure-{figure.number}")


def ladder(report: "Report") -> Html:
    """Return what each way to a threshold costs, and how far it is off."""
    note = (
        "Every way to the pure-slip damping at the paper’s parameters, measured in this run: the time for one "
        "threshold, and the relative error against the orbit that grazes the belt’s speed, at V = 0.5 m/s and the "
        "largest for V from 0.05 to 1 m/s. That of the orbit is its own estimate, and that of a proof a bound."
    )
    columns = ("way", "time", "error at 0.5 m/s", "largest error", "status")
    tables = []
    for law, ways in report.ladder.items():
        rows = []
        for way in ways:
            largest = "not measured" if way.largest != way.largest else f"{way.largest:.1e}"
            cells = (duration(way.seconds).replace("us", "μs"), f"{way.error:.1e}", largest)
            numbers = [element("td", cell, class_="number") for cell in cells]
            rows.append([way.name.replace("_", " "), *numbers, way.status or "none"])
        tables += [element("h3", f"{law} law".capitalize()), document.table(columns, rows)]
    title = element("h2", "Ladder of criteria")
    return element("section", title, element("p", note, class_="note"), *tables, id="ladder")


def footer(report: "Report") -> Html:
    """Say what computed all this."""
    return document.colophon(report.time, report.versions)


def _evidence(finding: Finding) -> list[Html]:
    """Return a finding's plain sentence, and its evidence by kind, a paragraph each."""
    told = [
        element("p", element("b", kind), ": ", prose(_sentence(text)), class_="note")
        for kind, text in finding.by_kind.items()
    ]
    return [element("p", prose(_sentence(finding.holds)), class_="holds"), *told]


def _sentence(text: str) -> str:
    """Return text with a capital, unless it begins with a symbol, and a stop."""
    return re.sub(r"^[a-z]{2,} ", lambda word: word[0].capitalize(), text) + "."


def _verdicts(report: "Report", ids: tuple[str, ...]) -> Iterator[Html]:
    for id in ids:
        verdict = _badge(report.verdict(CLAIMS[id]))
        yield element("span", _link(CLAIMS[id]), " ", verdict, class_="note")
        yield raw(" ")  # outside, so that the line may break here


def _link(claim: Claim) -> Html:
    return element("a", claim.id, href=f"#claim-{claim.id}")


def _anchor(equation: PrintedEquation) -> str:
    return f"equation-{equation.number.strip('()')}"


def _badge(outcome: Outcome | None) -> Html:
    if outcome is None:
        return element("span", "not checked", class_="verdict not-run")
    return element("span", _sign(outcome), class_=f"verdict {_class(outcome)}")


def _sign(outcome: Outcome) -> str:
    return f"{_SIGNS[outcome]} {SHORT[outcome]}"


def _class(outcome: Outcome) -> str:
    return SHORT[outcome].replace(" ", "-")

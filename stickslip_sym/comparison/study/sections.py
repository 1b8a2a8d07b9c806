"""The sections of a study's page. Every text of a user's is escaped, as `element` does it."""

import math
from pathlib import Path

import sympy as sp

from stickslip_sym.comparison.study.cells import name, number, percent, with_error
from stickslip_sym.comparison.study.findings import Answer, Findings, quantities
from stickslip_sym.comparison.study.pictures import pictures
from stickslip_sym.comparison.study.tables import law_section, margins_section, sensitivity_section
from stickslip_sym.core import symbols
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.output import printing
from stickslip_sym.output.page import document
from stickslip_sym.output.page.elements import Html, element, prose
from stickslip_sym.output.page.mathml import relation
from stickslip_sym.output.tables import duration

__all__ = ["page"]

_STYLE = Path(__file__).with_name("study.css")
_WIDEST = 260  # characters of a formula as text, up to which it fits a sheet when it is set
_LONGEST = 1500  # characters that are shown at all
_LONGEST_NAME = 80  # characters of a heading
_ALT = {
    "law": "Coefficient of friction over slip speed, with measured points and the 95 % band where there are any.",
    "plane": "Thresholds of damping over belt speed, with regions of coexistence, and the operating point.",
    "time": "Velocity of the mass over time, from x = 0 with the belt's speed.",
    "phase": "Phase plane: velocity over displacement, with attractors and separatrices.",
}
_CAPTIONS = {
    "law": "Friction law. The threshold depends on slip speeds from 0 to 2V only, or little more.",
    "plane": "Damping over belt speed. Below the threshold the mass sticks, if it starts so. Hatched: between the "
    "threshold and the stability of the equilibrium (dashed) the start decides, or a limit cycle in pure slip "
    "attracts.",
    "time": "Motion from x = 0 with the belt’s speed. Thick lines are stick.",
    "phase": "Phase plane. A separatrix parts the starts that lead to different attractors.",
}


def page(study: Findings) -> str:
    """Return the whole page."""
    title = f"Stick–slip study: {_shortened(study.name)}"
    sections = [
        _figures(pictures(study)),
        element("div", _thresholds(study), law_section(study), class_="columns"),
        element("div", sensitivity_section(study), margins_section(study), class_="columns second"),
        _formulas(study),
        _assumed(study),
    ]
    when = f"{study.time} in {study.seconds:.1f} s"
    footer = document.colophon(when, document.versions("lmfit", "uncertainties"))
    return document.page(title, [_header(study, title)], sections, footer, _STYLE.read_text(encoding="utf-8"))


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST_NAME else f"{text[: _LONGEST_NAME - 1]}…"


def _header(study: Findings, title: str) -> Html:
    own = study.errors["c"].std_dev if "c" in study.errors else None
    counts = [_count("damping c", with_error(study.oscillator.c, own), " kg/s")]
    threshold, margins = study.threshold, study.margins
    if threshold is not None:
        spread = None if threshold.budget is None else threshold.budget.uncertainty
        counts.append(_count("pure-slip damping", with_error(threshold.value, spread), " kg/s", id="threshold"))
    if margins is not None and margins.rows and math.isfinite(margins.rows[0].change):
        first = margins.rows[0]
        change = name(first.name), " ", percent(first.change)
        counts.append(_count("nearest change to the threshold", *change, id="nearest"))
    if margins is not None and margins.probability is not None:
        chance = number(margins.probability, ".3g")
        counts.append(_count("probability of stick–slip", chance, id="probability"))
    return element(
        "header",
        element("h1", title),
        element("p", f"At {quantities(study.oscillator)}.", class_="source"),
        element("p", element("b", study.verdict), class_=f"state {_state(study)}", id="verdict"),
        element("div", *counts, class_="counts"),
    )


def _state(study: Findings) -> str:
    if study.regime is None or study.regime.coexist:
        return "either"
    return "rests" if study.regime.stick_slip is None else "sticks"


def _count(what: str, *value: str, **attributes: str) -> Html:
    return element("span", element("b", *value, **attributes), what)


def _figures(drawn: dict[str, str]) -> Html:
    figures = [
        element(
            "figure",
            element("img", src=uri, alt=_ALT[key]),
            element("figcaption", _CAPTIONS[key]),
            id=f"figure-{key}",
        )
        for key, uri in drawn.items()
    ]
    return element("section", *figures, class_="pictures")


def _thresholds(study: Findings) -> Html:
    columns = ("method", "c in kg/s", "relative error", "status", "first call")
    note = (
        "The error is the method’s, against the exact threshold: an estimate, and for a proof a bound. What the "
        "uncertainty of the values does is apart from it."
    )
    return element(
        "section",
        element("h2", "Thresholds by every rung"),
        document.table(columns, [_answer(answer) for answer in study.answers]),
        element("p", note, class_="note"),
        id="thresholds",
    )


def _answer(answer: Answer) -> list[str]:
    head = element("th", answer.method.replace("_", " "), scope="row", id=f"threshold-{answer.method}")
    time = element("td", duration(answer.seconds).replace("us", "μs"), class_="number")
    found = answer.threshold
    if found is None:
        return [head, element("td", answer.refused, colspan="3", class_="reason"), time]
    error = element("span", "unknown") if found.error is None else number(found.error, ".1e")
    cells = [element("td", cell, class_="number") for cell in (number(found.value, ".10g"), error)]
    return [head, *cells, found.status, time]


def _formulas(study: Findings) -> Html:
    law, parts = study.law, list[Html]()
    if law.curve is None:
        parts.append(_formula(sp.Function("mu")(symbols.v), law.expr, "friction law", id="formula-law"))
    for criterion, form in study.forms.items():
        title = criterion.replace("_", " ")
        if isinstance(form, ClosedForm):
            verdict = f"{title}, {form.verdict.status.value}: {form.verdict.evidence}"
            parts.append(_formula(symbols.c, form.expr, verdict, id=f"formula-{criterion}"))
        else:
            words = element("span", f"{title}: {form}", class_="about")
            parts.append(element("div", words, class_="equation", id=f"formula-{criterion}"))
    return element("section", element("h2", "Formulas"), *parts, id="formulas")


def _formula(left: sp.Expr, expr: sp.Expr, about: str, **attributes: str) -> Html:
    text = printing.text(expr)
    if len(text) <= _WIDEST:
        shown = relation(left, "=", expr)
    elif len(text) <= _LONGEST:
        shown = element("code", f"{printing.text(left)} = {text}")
    else:
        shown = element("p", f"A formula of {len(text)} characters; derive gives it.", class_="note")
    words = element("span", about, class_="about")
    return element("div", element("div", shown, class_="formulas"), words, class_="equation", **attributes)


def _assumed(study: Findings) -> Html:
    sentences = [
        "m x'' + c x' + k x = N mu(V - x'): one mass, one contact; N and V are constant.",
        "The threshold is sought with the mass slower than the belt, from the end of a stick phase.",
    ]
    if study.law.static is not None:
        sentences.append("A static coefficient above mu(0+), which motions heed, and no average of slopes.")
    if study.threshold is not None and study.threshold.budget is not None:
        sentences.append("Standard errors are those of normal distributions; they are carried on to first order.")
    items = [element("li", prose(sentence)) for sentence in sentences]
    items += [element("li", text) for text in study.assumed]
    items += [element("li", f"Warning: {doubt}", class_="doubt") for doubt in study.doubts]
    items += [element("li", f"Not found: {part}: {why}", class_="doubt") for part, why in study.refused.items()]
    return element("section", element("h2", "What was assumed"), element("ul", *items), id="assumed")

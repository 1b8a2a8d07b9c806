"""What stands on a study's page, for its template."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sympy as sp

from stickslip_sym.comparison.compare import Answer
from stickslip_sym.comparison.study.findings import Findings
from stickslip_sym.comparison.study.pictures import ALT, CAPTIONS, pictures
from stickslip_sym.core import symbols
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.motion.margins.margins import Margin
from stickslip_sym.output import printing
from stickslip_sym.output.page.elements import Html, element, raw
from stickslip_sym.output.page.render import equation, number, percent, render, symbol, with_error
from stickslip_sym.output.tables import duration

__all__ = ["REACH", "page"]

REACH = 3.0
"""Times a value, and its inverse: where margins are sought; no decision turns on those beyond."""
_TEMPLATE = Path(__file__).with_name("study.html")
_WIDEST = 260  # characters of a formula as text, up to which it fits a sheet when it is set
_LONGEST = 1500  # characters that are shown at all
_LONGEST_NAME = 80  # characters of a heading
_DIGITS = 10  # of a value, at most
_RARE = 0.001  # a probability below it is not told from 0
_MUCH = 0.1  # by which the second order may differ from the first before it is said aloud


@dataclass(frozen=True)
class _Row:
    """A row of a table: its id, its head, and its cells, or a reason in their place."""

    id: str
    head: str
    cells: Sequence[str] = ()
    reason: str = ""


def page(study: Findings) -> str:
    """Return the whole page."""
    title = study.title if len(study.title) <= _LONGEST_NAME else f"{study.title[: _LONGEST_NAME - 1]}…"
    drawn = pictures(study)
    return render(
        _TEMPLATE,
        title=f"Stick–slip study: {title}",
        point=[
            (symbol(key), _value_with_error(study, key), QUANTITIES[key].unit, key in study.defaults)
            for key in ("c", "V", "N", "m", "k")
        ],
        state=_state(study),
        headline=study.headline,
        verdict=study.verdict,
        warnings=study.warnings,
        counts=_counts(study),
        figures=[(key, uri, ALT[key], CAPTIONS[key]) for key, uri in drawn.items()],
        thresholds=[_threshold(one) for one in study.answers],
        choice=_choice(study),
        about_law=_about_law(study),
        parameters=_parameters(study),
        sensitivities=_sensitivities(study),
        margins=_margins(study),
        formulas=_formulas(study),
        assumed=_assumed(study),
        refused=study.refused,
        time=f"{study.time} in {study.seconds:.1f} s",
    )


def _state(study: Findings) -> str:
    if study.regime is None or study.regime.coexist:
        return "either"
    return "rests" if study.regime.stick_slip is None else "sticks"


def _value(study: Findings, key: str) -> float:
    return float(study.law.values[key]) if key in study.law.values else float(getattr(study.oscillator, key))


def _standard_error(study: Findings, key: str) -> float | None:
    carried = study.law.uncertain.get(key) or study.errors.get(key)
    return None if carried is None else carried.std_dev


def _value_with_error(study: Findings, key: str) -> Html:
    return with_error(_value(study, key), _standard_error(study, key))


def _counts(study: Findings) -> list[tuple[str, str, str, str]]:
    """Return the numbers at the top: what, value, unit and id."""
    counts: list[tuple[str, str, str, str]] = [
        ("damping c", with_error(study.oscillator.c, study.damping_error), " kg/s", "")
    ]
    if study.needed is not None:
        what = "pure-slip damping, averaged over laws" if study.by_law else "pure-slip damping"
        counts.append((what, with_error(*study.needed), " kg/s", "threshold"))
    if study.margins is not None and study.margins.rows and math.isfinite(study.margins.rows[0].change):
        first = study.margins.rows[0]
        value = raw(f"{symbol(first.name)} {percent(first.change)}")
        counts.append(("nearest change to the threshold", value, "", "nearest"))
    if study.probability is not None:
        rare = study.probability < _RARE
        shown = (
            element("data", f"< {_RARE:g}", value=repr(study.probability))
            if rare
            else number(study.probability, ".2g")
        )
        counts.append(("probability that stick–slip is possible", shown, "", "probability"))
    return counts


def _threshold(answer: Answer) -> _Row:
    name, threshold = answer.method.replace("_", " "), answer.threshold
    if threshold is None:
        return _Row(answer.method, name, reason=answer.reason)
    error = threshold.relative_error
    digits = _DIGITS if not error else min(max(1 - math.floor(math.log10(error)), 2), _DIGITS)
    stated = element("span", "unknown") if error is None else number(error, ".1e")
    elapsed = duration(answer.seconds).replace("us", "μs")
    return _Row(
        answer.method, name, [number(threshold.value, f".{digits}g"), stated, str(threshold.status), elapsed]
    )


def _choice(study: Findings) -> dict[str, Any] | None:
    if study.choice is None or not study.by_law:
        return None
    rows = [
        _Row(str(i), one.law, [number(one.weight, ".2g"), with_error(one.value, one.standard_error)])
        for i, one in enumerate(study.by_law)
    ]
    average = with_error(study.choice.value, study.choice.standard_error)
    return {"rows": rows, "average": average, "refused": study.choice.refused}


def _about_law(study: Findings) -> list[str]:
    law, fit = study.law, study.fit
    notes = [f"{law.name}: mu(v) = {law.text}" if law.name else f"mu(v) = {law.text}"]
    if study.measured is not None:
        file = f" ({study.measured.source})" if study.measured.source else ""
        notes.append(f"Measured{file}: {study.measured.understood}.")
    if fit is not None:
        low, high = float(fit.measured.v[0]), float(fit.measured.v[-1])
        notes.append(
            f"Fitted to {len(fit.measured)} rows from {low:.3g} to {high:.3g} m/s: residual standard deviation "
            f"{fit.sigma:.3g}, AICc {fit.aicc:.6g}, weight {fit.weight:.2g} among the laws fitted."
        )
    if law.static is not None:
        notes.append(f"Static coefficient: {law.static}.")
    return notes + [
        f"{label}: {text}." for label, text in (("Source", law.source), ("Holds", law.validity)) if text
    ]


def _parameters(study: Findings) -> list[_Row]:
    described = [(key, parameter.unit, parameter.meaning) for key, parameter in study.law.parameters.items()]
    described += [(key, QUANTITIES[key].unit, QUANTITIES[key].meaning) for key in ("c", "V", "N", "m", "k")]
    return [
        _Row(key, symbol(key), [_value_with_error(study, key), unit or "", f"{meaning}{_default(study, key)}"])
        for key, unit, meaning in described
    ]


def _default(study: Findings, key: str) -> str:
    return " (default)" if key in study.defaults else ""


def _sensitivities(study: Findings) -> dict[str, Any]:
    """Return how the threshold changes with each quantity and parameter, and what their errors do to it."""
    threshold = study.threshold
    if threshold is None:
        return {"rows": [], "notes": [("There is no threshold here.", "")]}
    try:
        slopes = threshold.sensitivity
    except StickSlipError as error:
        return {"rows": [], "notes": [(f"Not found: {error}", "")]}
    budget = threshold.budget
    columns = ["", "value", "dc/d", "% of c for 1 %"]
    if budget is not None:
        columns += ["alone, kg/s", "share"]
    first = () if budget is None else budget.names
    rows = []
    for key in (*first, *(key for key in slopes if key not in first)):
        relative = slopes[key] * _value(study, key) / threshold.value if threshold.value else None
        cells: list[str] = [_value_with_error(study, key), number(slopes[key], ".4g"), number(relative, "+.3g")]
        if budget is not None:
            known = key in budget.names
            cells += [number(budget.alone[key], ".2g"), percent(budget.shares[key], ".1f")] if known else ["", ""]
        rows.append(_Row(key, symbol(key), cells))
    notes: list[tuple[str, str]] = [("Derivatives are exact; all else is held.", "")]
    if budget is not None:
        words = f"Standard error of the threshold {number(budget.uncertainty, '.2g')} kg/s"
        ratio = threshold.nonlinearity
        words += (
            f"; to second order {number(ratio, '.3g')} times that."
            if ratio == ratio
            else (". To second order it could not be computed.")
        )
        if ratio == ratio and abs(ratio - 1) > _MUCH:
            words += " The first order is not enough here."
        if budget.correlated:
            pairs = ", ".join(f"{one} and {other} ({r:+.2f})" for one, other, r in budget.correlated)
            words += (
                f" Correlated: {pairs}. Shares count covariances too: together they are 100 %, and one may be "
                "below 0 or above 100 %."
            )
        notes.append((raw(words), "uncertainty"))
    return {"columns": columns, "rows": rows, "notes": notes}


def _margins(study: Findings) -> dict[str, Any]:
    """Return how much each quantity may change, alone, before stick-slip becomes possible or impossible."""
    margins = study.margins
    if margins is None:
        return {"rows": [], "notes": [(f"Not found: {study.refused['margins']}", "")]}
    uncertain = any(_standard_error(study, row.name) for row in margins.rows)
    columns = ["", "value", "critical below", "critical above", "smallest change"]
    columns += ["in standard errors"] if uncertain else []
    rows = []
    for row in margins.rows:
        ends = ["" if one is None else number(one.value, ".5g") for one in (row.below, row.above)]
        cells = [number(row.value, ".5g"), *ends, percent(row.change)]
        rows.append(_Row(row.name, symbol(row.name), cells + ([_in_errors(study, row)] if uncertain else [])))
    state = "below it, so stick–slip is possible" if margins.stick_slip else "above it, so nothing sticks for good"
    notes: list[tuple[str, str]] = [
        (f"Where c is just the pure-slip damping, within a factor of {REACH:g}; as things are c is {state}.", "")
    ]
    notes += [(f"{key}: {why}", "") for key, why in margins.refused.items()]
    if margins.probability is not None:
        first = number(margins.probability, ".3g")
        words = (
            f"Probability that stick–slip is possible, c below the threshold of this law: {first} to first order"
        )
        if margins.sampled is not None:
            sampled = margins.sampled
            words += (
                f", {number(sampled.probability, '.3g')} ± {number(sampled.standard_error, '.1g')} from samples"
            )
            words += f", {percent(sampled.undecided, '.2g')} undecided" if sampled.undecided else ""
        if study.regime is not None and study.regime.coexist:
            words += "; where rest is stable too the initial condition decides"
        notes.append((raw(f"{words}."), "probabilities"))
    return {"columns": columns, "rows": rows, "notes": notes}


def _in_errors(study: Findings, row: Margin) -> str:
    error = _standard_error(study, row.name)
    if not error or not math.isfinite(row.change):
        return ""
    return number(row.change * row.value / error, "+.2g")


def _formulas(study: Findings) -> list[tuple[str, str, str]]:
    law = study.law
    parts: list[tuple[str, str, str]] = (
        []
        if law.curve is not None
        else [("law", _formula(sp.Function("mu")(symbols.v), law.expr), "friction law")]
    )
    for criterion, form in study.forms.items():
        name = criterion.replace("_", " ")
        if isinstance(form, ClosedForm):
            about = f"{name}, {form.verdict.status.value}: {form.verdict.evidence}"
            parts.append((criterion, _formula(symbols.c, form.expr), about))
        else:
            parts.append((criterion, "", f"{name}: {form}"))
    return parts


def _formula(left: sp.Expr, expr: sp.Expr) -> Html:
    text = printing.text(expr)
    if len(text) <= _WIDEST:
        return equation(left, expr)
    if len(text) <= _LONGEST:
        return element("code", f"{printing.text(left)} = {text}")
    return element("p", f"A formula of {len(text)} characters; derive gives it.", class_="note")


def _assumed(study: Findings) -> list[str]:
    sentences = [
        "m x'' + c x' + k x = N mu(V - x'): one mass, one contact; N and V are constant.",
        "The threshold is sought with the mass slower than the belt, from the end of a stick phase.",
    ]
    if study.law.static is not None:
        sentences.append(
            "A static coefficient above mu(0+) holds the mass in stick; no slope average depends on it."
        )
    if study.threshold is not None and study.threshold.budget is not None:
        sentences.append("Standard errors are those of normal distributions; they are carried on to first order.")
    if study.defaults:
        sentences.append("Values marked as default were not given.")
    return sentences

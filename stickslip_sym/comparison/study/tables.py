"""The tables of a study's page: what the threshold depends on, margins, and the law with its values."""

from stickslip_sym.comparison.study.cells import name, number, percent, with_error
from stickslip_sym.comparison.study.findings import REACH, Findings
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.motion.margins.value import Critical
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.output.page import document
from stickslip_sym.output.page.elements import Html, element

__all__ = ["law_section", "margins_section", "sensitivity_section"]

_MUCH = 0.1  # by which the second order may differ from the first before it is said aloud
_NOTHING = element("span", "")


def _section(title: str, id: str, *parts: Html) -> Html:
    return element("section", element("h2", title), *parts, id=id)


def _note(text: str) -> Html:
    return element("p", text, class_="note")


def _cell(content: Html) -> Html:
    return element("td", content, class_="number")


def _head(table: str, quantity: str) -> Html:
    return element("th", name(quantity), scope="row", id=f"{table}-{quantity}")


def _value(study: Findings, key: str) -> float:
    return float(study.law.values[key]) if key in study.law.values else float(getattr(study.oscillator, key))


def _with_error(study: Findings, key: str) -> Html:
    carried = study.law.uncertain.get(key) or study.errors.get(key)
    return with_error(_value(study, key), None if carried is None else carried.std_dev)


def sensitivity_section(study: Findings) -> Html:
    """Return how the threshold changes with each quantity and parameter, and what their errors do to it."""
    title = "What the threshold depends on"
    threshold = study.threshold
    if threshold is None:
        return _section(title, "sensitivities", _note("There is no threshold here."))
    try:
        slopes = threshold.sensitivity
    except StickSlipError as error:
        return _section(title, "sensitivities", _note(f"Not found: {error}"))
    budget = threshold.budget
    columns = ["", "value", "dc/d", "% of c for 1 %"]
    if budget is not None:
        columns += ["alone, kg/s", "share"]
    first = () if budget is None else budget.names
    rows = []
    for key in (*first, *(key for key in slopes if key not in first)):
        relative = slopes[key] * _value(study, key) / threshold.value if threshold.value else None
        row = [
            _head("sensitivity", key),
            _cell(_with_error(study, key)),
            _cell(number(slopes[key], ".5g")),
            _cell(number(relative, "+.3g")),
        ]
        if budget is not None:
            known = key in budget.names
            row += [
                _cell(number(budget.alone[key], ".3g") if known else _NOTHING),
                _cell(percent(budget.shares[key], ".1f") if known else _NOTHING),
            ]
        rows.append(row)
    notes = [_note("Derivatives are exact; all else is held.")]
    if budget is not None:
        notes.append(element("p", *_uncertainty(threshold), class_="note", id="uncertainty"))
    return _section(title, "sensitivities", document.table(columns, rows), *notes)


def _uncertainty(threshold: Threshold) -> list[str]:
    """Return what the standard errors do together, and whether the first order serves."""
    budget = threshold.budget
    assert budget is not None
    words = ["Standard error of the threshold ", number(budget.uncertainty, ".3g"), " kg/s"]
    if budget.correlated:
        pairs = ", ".join(f"{one} and {other} ({r:+.2f})" for one, other, r in budget.correlated)
        words.append(f", with the correlations of {pairs}; shares hold only together")
    ratio = threshold.nonlinearity
    if ratio != ratio:
        return [*words, ". To second order it could not be computed."]
    words += ["; to second order ", number(ratio, ".3g"), " times that."]
    if abs(ratio - 1) > _MUCH:
        words.append(" First order does not serve here.")
    return words


def margins_section(study: Findings) -> Html:
    """Return how much each quantity and parameter may change, alone, before stick-slip sets in or ends."""
    found = study.margins
    if found is None:
        return _section("Margins", "margins", _note(f"Not found: {study.refused['margins']}"))
    rows = [
        [
            _head("margin", row.name),
            _cell(number(row.value)),
            _cell(_critical(row.below)),
            _cell(_critical(row.above)),
            _cell(percent(row.change)),
        ]
        for row in found.rows
    ]
    state = "below it, so there is stick–slip" if found.stick_slip else "above it, so nothing sticks for good"
    notes = [
        _note(f"Where c is just the pure-slip damping, within a factor of {REACH:g}; as things are c is {state}.")
    ]
    notes += [_note(f"{key}: {why}") for key, why in found.refused.items()]
    if found.probability is not None:
        words = ["Probability of stick–slip ", number(found.probability, ".3g"), " to first order"]
        if found.sampled is not None:
            share, error = found.sampled
            words += [", ", number(share, ".3g"), " ± ", number(error, ".1g"), " from samples"]
        notes.append(element("p", *words, ".", class_="note", id="probabilities"))
    columns = ("", "value", "critical below", "critical above", "smallest change")
    return _section("Margins", "margins", document.table(columns, rows), *notes)


def _critical(one: Critical | None) -> Html:
    return _NOTHING if one is None else number(one.value)


def law_section(study: Findings) -> Html:
    """Return the law: its formula as text, its values, where it is from, and how it was fitted."""
    law, fit = study.law, study.fit
    notes = [f"{law.name}: mu(v) = {law.text}" if law.name else f"mu(v) = {law.text}"]
    if study.measured is not None:
        notes.append(f"Measured: {study.measured.understood}.")
    if fit is not None:
        notes.append(
            f"Fitted to {len(fit.measured)} rows: residual standard deviation {fit.sigma:.3g}, "
            f"AICc {fit.aicc:.6g}, weight {fit.weight:.2g} among the laws fitted."
        )
    if law.static is not None:
        notes.append(f"Static coefficient: {law.static}.")
    notes += [f"{label}: {text}." for label, text in (("Source", law.source), ("Holds", law.validity)) if text]
    described = [(key, parameter.unit, parameter.meaning) for key, parameter in law.parameters.items()]
    described += [(key, QUANTITIES[key].unit, QUANTITIES[key].meaning) for key in ("c", "V", "N", "m", "k")]
    rows = [
        [_head("parameter", key), _cell(_with_error(study, key)), unit or "", meaning]
        for key, unit, meaning in described
    ]
    table = document.table(("", "value", "unit", "meaning"), rows)
    return _section("Law and values", "law", *map(_note, notes), table)

"""What is shown of thresholds and the budgets of their standard errors."""

from typing import Any

import numpy as np

from stickslip_sym.core.uncertain import text_with_error
from stickslip_sym.model.negative import note_at_rest
from stickslip_sym.motion.thresholds.methods import accuracy
from stickslip_sym.motion.thresholds.threshold import Threshold
from stickslip_sym.motion.thresholds.uncertainty import Budget, ranged
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import dispatch, markup

_COLUMNS = ["operating point", "c in kg/s", "standard error", "method", "error of the method", "status"]


@dispatch.plain_text.register(Threshold)
def threshold_as_text(threshold: Threshold[Any]) -> str:
    """Return the value, or the range of several, with its errors, and what a negative one means."""
    if not np.size(threshold.value):
        return "0 thresholds"
    text = _values_in_words(threshold)
    error = 0.0 if threshold.error is None else threshold.error
    if np.any(threshold.value < -np.asarray(error)):
        text += "; no damping is needed: a negative value says how much energy must be fed in for stick-slip"
    if threshold.points.has_oscillator and (at_rest := note_at_rest(threshold.points.bound)):
        text += f"; {at_rest}"
    return text


def _values_in_words(threshold: Threshold[Any]) -> str:
    low = np.min(threshold.value)
    high = np.max(threshold.value)
    spread = threshold.known_standard_error
    row = 0
    if threshold.relative_error is not None:
        row = int(np.argmax(threshold.relative_error))
    worst = threshold.accuracy(tuple(map(int, np.unravel_index(row, threshold.points.shape))))
    basis = f"{', '.join(np.unique(threshold.method))}, {worst}, {threshold.status}"
    if np.ndim(threshold.value):
        text = f"{np.size(threshold.value)} thresholds from {low:.6g} to {high:.6g} kg/s ({basis})"
    elif spread is None or threshold.theorems or np.isnan(spread):
        text = f"{threshold.enclosure or format(low, '.10g')} kg/s ({basis})"
    else:
        value = text_with_error(float(low), float(spread))
        return f"{value} kg/s (parameters) +/- {_error_of_method(threshold.error)} (method: {threshold.method})"
    if spread is not None:
        size = f"{ranged(spread, '.2g')} kg/s" if np.isfinite(spread).all() else "unknown"
        text += f"; standard error {size} (parameters)"
    return text


def _error_of_method(error: float | None) -> str:
    if error is None:
        return "unknown"
    return f"{error:.0e}" if error else "0"


@dispatch.notebook_html.register(Threshold)
def threshold_as_html(threshold: Threshold[Any]) -> str:
    """Return a table with a row for each operating point, the first and the last of many."""
    value = np.atleast_1d(threshold.value)
    method = np.atleast_1d(threshold.method)
    known = threshold.known_standard_error
    spread = None if known is None else np.atleast_1d(known)
    rows = list[list[str]]()
    for index in markup.shortened(list(np.ndindex(value.shape))):
        row = ["..."] * len(_COLUMNS)
        if index is not None:
            text = str(threshold.enclosure or format(value[index], ".10g"))
            deviation = ""
            if spread is not None:
                deviation = accuracy(float(spread[index]), ".2g")
            accurate = threshold.accuracy(index if threshold.points.shape else ())
            place = ", ".join(map(str, index))
            row = [place, text, deviation, str(method[index]), accurate, str(threshold.status)]
        rows.append(row)
    unused = {"standard error"} if spread is None else set[str]()
    if not np.ndim(threshold.value):
        unused.add("operating point")
    shown = [i for i, name in enumerate(_COLUMNS) if name not in unused]
    head, *body = ([row[i] for i in shown] for row in (_COLUMNS, *rows))
    return markup.html_table(head, body, caption=f"pure-slip damping: {threshold}")


@dispatch.parts.register(Budget)
def parts_of_budget(budget: Budget) -> list[str | HeadedRows]:
    """Return a row for each standard error, and which are correlated."""
    rows = []
    for name in budget.names:
        share = ranged(100 * np.asarray(budget.shares[name]), ".1f")
        rows.append([name, f"{budget.deviations[name]:.3g}", ranged(budget.alone[name], ".3g"), f"{share} %"])
    header = ["quantity", "standard error", "alone, kg/s", "share of the variance"]
    pairs = ", ".join(f"{first} and {second} ({r:+.2f})" for first, second, r in budget.correlated)
    remarks = [f"correlated: {pairs}; their shares hold only together"] if pairs else []
    return [(header, rows), *remarks]

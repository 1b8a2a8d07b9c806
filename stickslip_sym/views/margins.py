"""What is shown of margins and critical values."""

import math

from stickslip_sym.motion.margins.critical import Critical
from stickslip_sym.motion.margins.margins import Margin, Margins
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import dispatch, markup


@dispatch.notebook_html.register(Critical)
def critical_as_html(critical: Critical) -> str:
    """Return the value in a line."""
    return markup.block(f"critical value: {critical}")


@dispatch.one_line.register(Margins)
def margins_in_a_line(margins: Margins) -> str:
    """Return what is the case at the operating point, and the threshold."""
    return f"Margins: {_decision(margins)}"


def _decision(margins: Margins) -> str:
    if abs(margins.c - margins.threshold.value) <= (margins.threshold.error or 0.0):
        state = "the damping is the pure-slip damping, within its error"
    elif margins.stick_slip:
        state = "stick-slip is possible"
    else:
        state = "no stick-slip" if margins.sticks is None else "the mass overtakes the belt, and does not stick"
    return f"{state}: c = {margins.c:.6g} kg/s, pure-slip damping {margins.threshold}"


@dispatch.parts.register(Margins)
def parts_of_margins(margins: Margins) -> list[str | HeadedRows]:
    """Return the decision, a row for each quantity, what is open, and the probability."""
    header = ["quantity", "value", "critical below", "critical above", "smallest change"]
    lines = [f"{name}: {why}" for name, why in margins.refused.items()]
    for name, intervals in margins.open.items():
        gaps = ", ".join(f"{low:.6g} to {high:.6g}" for low, high in intervals)
        lines.append(f"{name}: not decided, or without a threshold, from {gaps}")
    if margins.probability is not None:
        what = "the mass comes to the belt's speed" if margins.sticks is False else "stick-slip is possible"
        lines.append(f"probability that {what}: {margins.probability:.3g} (first order)")
    if margins.sampled is not None:
        lines[-1] += f", {margins.sampled}"
    return [_decision(margins), (header, list(map(_row_of_margin, margins.rows))), *lines]


def _row_of_margin(margin: Margin) -> list[str]:
    ends = ["" if end is None else f"{end.value:.6g}" for end in (margin.below, margin.above)]
    change = "none"
    if math.isfinite(margin.change):
        change = f"{100 * margin.change:+.3g} %"
    return [margin.name, f"{margin.value:.6g}", *ends, change]

"""Where a step ends: at an extremum of the slip speed, or at a level of it."""

import math

from stickslip_sym.core.numbers import DOUBLE_BITS, EPSILON, ROOT_OF_ROUNDING
from stickslip_sym.motion.compiled import compilable, inlined
from stickslip_sym.motion.kernel.forces import bend_at, rate_at, wedge_terms
from stickslip_sym.motion.kernel.slip_data import Branch, Field, SlipEnd, SlipState, Trial, Wedge
from stickslip_sym.motion.kernel.steps import stepped

_SHARE_OF_SERIES_STEP = 0.1
"""Of a step, times rtol^(1/3), over which a power series of three terms is off by a part of rtol."""


@inlined
def land(
    branch: Branch, field: Field, state: SlipState, trial: Trial, rising: bool, border: float, level: float,
    implicit: bool, rtol: float, wedge: Wedge,
) -> tuple[SlipEnd, Trial]:  # fmt: skip
    """Let a step end where w turns, or comes to a level before, and return which of them it is, and the step.

    - `border`: of the segment of the law, a level as `level` is.
    """
    event = SlipEnd.OPEN
    w = state.w
    ahead = 1.0 if rising else -1.0
    # Where w' changes its sign there is an extremum if w'' = side - w has the sign for it; else it is rounding,
    # or the error of an implicit step.
    slowest = rtol ** (2.0 / 3.0) * max(1.0, abs(state.rate)) if implicit else 0.0
    turns = trial.rate < -slowest if rising else trial.rate > slowest
    if turns and (trial.w > field.side) == rising:
        event = SlipEnd.MAXIMUM if rising else SlipEnd.MINIMUM
        trial = _located(implicit, branch, field, state, trial, rtol, wedge, math.nan, ahead)
    inner = (w < level < border) if rising else (border < level < w)
    target = level if inner else border
    if (trial.w >= target) if rising else (trial.w <= target):
        event = SlipEnd.LEVEL
        if trial.w != target:
            trial = _located(implicit, branch, field, state, trial, rtol, wedge, target, -ahead)
        rate = rate_at(branch, field, trial.q, target)
        trial = Trial(trial.length, trial.q, target, rate, trial.wedge, trial.error)
    return event, trial


@compilable
def _located(
    implicit: bool, branch: Branch, field: Field, state: SlipState, beyond: Trial, rtol: float, wedge: Wedge,
    level: float, sign: float,
) -> Trial:  # fmt: skip
    """Return the step that ends at a level of w, or, if that is NaN, at an extremum.

    - `beyond`: a step that ends after it.
    - `sign`: of w - level, or of w', before.
    """
    turns = math.isnan(level)
    h = beyond.length
    # Newton's method in a bracket, from where the inverse of the value is 0, as a cubic through both ends.
    begin = state.w - level
    end = beyond.w - level
    by = state.rate
    by_end = beyond.rate
    if turns:
        begin = by
        by = bend_at(branch, field, state.w, state.rate)
        end = by_end
        by_end = bend_at(branch, field, beyond.w, beyond.rate)
    part = begin / (begin - end) if begin * end < 0.0 else 0.5
    length = h * part
    if by * by_end > 0.0:
        length *= part * (3.0 - 2.0 * part)
        length += (end - begin) * part * (1.0 - part) * ((1.0 - part) / by - part / by_end)
    low = 0.0
    high = h
    close = _SHARE_OF_SERIES_STEP * h * rtol ** (1.0 / 3.0)
    guesses = 0
    while True:
        guesses += 1
        # Where mu is steep Newton's method may creep: it gets as many guesses as halvings would need.
        if guesses > DOUBLE_BITS or not low < length < high:
            length = 0.5 * (low + high)
        trial = stepped(implicit, branch, field, state, length, rtol, wedge)
        value = trial.rate if turns else trial.w - level
        bend = bend_at(branch, field, trial.w, trial.rate)
        if value * sign > 0.0:
            low = length
        else:
            high = length
        change = bend if turns else trial.rate
        shift = -value / change if change != 0.0 else 0.0
        if not turns and trial.rate != 0.0:
            shift -= 0.5 * shift * shift * bend / trial.rate
        if abs(shift) <= (ROOT_OF_ROUNDING if turns else close) and (value == 0.0 or change != 0.0):
            return _moved(branch, field, trial, shift, bend, wedge)
        if high - low <= 4.0 * EPSILON * h:
            return trial
        length += shift


@compilable
def _moved(branch: Branch, field: Field, trial: Trial, shift: float, bend: float, wedge: Wedge) -> Trial:
    """Return a step that ends a little later, by a few terms of a power series; its rate is left as it is.

    - `bend`: w'' at its end.
    """
    length, q, w, rate, D, error = trial
    if wedge.wanted:
        a, b = wedge_terms(branch, field, wedge, w)
        D += shift * (a * D + b)
    q += shift * (1.0 - field.side * w - shift * field.side * (0.5 * rate + shift * bend / 6.0))
    w += shift * (rate + 0.5 * shift * bend)
    return Trial(length + shift, q, w, rate, D, error)

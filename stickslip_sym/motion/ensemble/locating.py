"""Where, within a step, w turns or passes a level: Newton's method on steps of the integration itself.

The cubic through the states and rates at both ends of a step gives a first guess, good to 1e-5. From there on
every try is a fresh step of that length from the same state, so that a root is as exact as the integration, as for
a single motion; what is left is a parabola. Where Newton's method leaves the bracket, it is halved.
"""

from typing import NamedTuple

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.motion.ensemble.field import Field
from stickslip_sym.motion.ensemble.rows import Step

__all__ = ["Place", "level_passed", "turn_estimated", "turn_located"]

_CLOSE = 1e-4  # time, over which w' is a straight line at a turn
_SHORT = 1e-5  # time, and time over that in which w' changes by itself, over which w is a parabola
_GUESSES = 3  # Newton steps on the cubic
_MOST_TRIES = 80  # a bracket halved so often is a number


class Place(NamedTuple):
    """Times after the beginnings of the steps, and the states q and w there."""

    t: FloatArray
    q: FloatArray
    w: FloatArray


def turn_estimated(step: Step) -> tuple[FloatArray, FloatArray]:
    """Return the time of a turn within a step and w there, on the cubic through its ends."""
    h, w = step.h, step.before.w
    start, square, cube = _cubic(step)
    a, half = 3 * cube, square
    root = -(half + np.copysign(np.sqrt(np.maximum(half * half - a * start, 0.0)), half))
    with np.errstate(all="ignore"):
        one, other = start / root, root / a
    part = np.where((one >= 0) & (one <= 1), one, other)
    # At an onset or an extremum the slope at the beginning may have either sign.
    early = (start > 0) != (step.before.rises > 0)
    part = np.where(early | ~np.isfinite(part), 0.0, np.clip(part, 0.0, 1.0))
    return part * h, w + part * (start + part * (square + part * cube))


def turn_located(field: Field, step: Step) -> Place:
    """Return where w turns within steps in which it does."""
    guess, _ = turn_estimated(step)
    return _located(field, step, None, np.zeros_like(guess), step.h.copy(), guess, step.before.rises > 0)


def level_passed(
    field: Field, step: Step, level: FloatArray, low: FloatArray, high: FloatArray, rising: BoolArray
) -> Place:
    """Return where w passes a level between two times of each step, in a stretch in which it rises or falls."""
    start, square, cube = _cubic(step)
    w, h = step.before.w, step.h
    first, last = low / h, high / h
    part = (first + last) / 2
    for _ in range(_GUESSES):
        value = w - level + part * (start + part * (square + part * cube))
        rate = start + part * (2 * square + 3 * part * cube)
        with np.errstate(all="ignore"):
            part = np.clip(part - value / rate, first, last)
        part = np.where(np.isfinite(part), part, (first + last) / 2)
    return _located(field, step, level, low.copy(), high.copy(), part * h, ~rising)


def _cubic(step: Step) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the coefficients of w, over the time as a part of the step, from the first power on."""
    rise, start, end = step.w - step.before.w, step.h * step.before.slope, step.h * step.slope
    return start, 3 * rise - 2 * start - end, start + end - 2 * rise


def _located(
    field: Field, step: Step, level: FloatArray | None, low: FloatArray, high: FloatArray, t: FloatArray,
    positive: BoolArray,
) -> Place:  # fmt: skip
    """Return the root of w - level, or of w' without a level, in brackets at whose lower ends it is `positive`."""
    found = Place(t.copy(), *np.empty((2, t.size)))
    todo = np.arange(t.size)
    for left in reversed(range(_MOST_TRIES if t.size else 0)):
        some, side = step.before.taken(todo), step.before.side[todo]
        rise = field.rise(some.segment)
        q, w, _ = field.step(rise, some.q, some.w, side, some.slope, t)
        slope = field.slope(rise, q, w, side)
        bend = field.bend(rise, w, side, slope)
        value, rate = (slope, bend) if level is None else (w - level[todo], slope)
        before = (value > 0) == positive
        low, high = np.where(before, t, low), np.where(before, high, t)
        with np.errstate(all="ignore"):
            shift = -value / rate
            if level is None:
                close = np.abs(shift) <= _CLOSE
            else:
                close = np.abs(shift) <= _SHORT * np.minimum(1.0, np.abs(rate / bend))
                shift = np.where(close & (rate != 0), shift * (1 - shift * bend / (2 * rate)), shift)
        # A bracket that is rounded away holds the root too.
        done = close | (high - low <= 4 * np.spacing(step.h[todo])) | (left == 0)
        shift = np.where(close & np.isfinite(shift), shift, 0.0)
        ahead = t - value / np.where(rate == 0, np.nan, rate)
        chosen = todo[done]
        for line, values in zip(
            found,
            (
                t + shift,
                q + shift * (1 - side * w) - side * slope * shift**2 / 2,
                w + shift * (slope + shift * bend / 2),
            ),
            strict=True,
        ):
            line[chosen] = values[done]
        if done.all():
            break
        t = np.where((ahead > low) & (ahead < high), ahead, (low + high) / 2)[~done]
        low, high, positive, todo = low[~done], high[~done], positive[~done], todo[~done]
    return found

"""Whether a mass on its way to rest is shown never to come to w = 1: by bounds of the slope of its law.

With q the displacement from rest and x = w - 1 there is q' = -x and x' = q - K x, where the chord of friction and
damping is K = 2 zeta + eta (rise(w) - rise(1))/(w - 1). On the line q = s x, x > 0,

    (q - s x)' = -x - s (s - K) x >= 0    where    K >= s + 1/s.

A state with q x > 0, |q| >= s |x| and x x' <= 0 never leaves q x > 0 if K >= s + 1/s >= 2 from rest up to its own
w: as |q| falls it comes no farther out again, and it tends to rest. Here s is the smaller root, near 1/K. Beside
rest that line is the fast direction of the node: the test is sharp. A chord lies between the least and the largest
slope of the law from rest to w. Backward in time the same holds with -eta and -zeta.
"""

import math

from stickslip_sym.model.table import Rise
from stickslip_sym.motion.compiled import compilable
from stickslip_sym.motion.kernel.forces import rate_at, slope_at, slope_standing, standing
from stickslip_sym.motion.kernel.slip_data import Branch, Field

_PARTS_OF_INTERVAL = 8  # of an interval of the table, on each of which a slope is bounded


@compilable
def creeps(rise: Rise, field: Field, q: float, w: float) -> bool:
    """Whether a state is shown to tend to rest; False says nothing."""
    low = min(w, 1.0)
    high = max(w, 1.0)
    x = w - 1.0
    at_rest = field.eta * standing(rise.pieces, w > 1.0)
    displacement = q + field.push - field.damping - at_rest
    if displacement * x <= 0.0 or high > rise.levels[-1] or _is_jump_between(rise, low, high):
        return False
    whole = Branch(rise.pieces, 0, len(rise.pieces) - 1, 0)
    if rate_at(whole, field, q, w) * x > 0.0:  # it may go where the law is another
        return False
    # The slopes at both ends show most often that it may come, without a look at all between them.
    here = slope_at(whole, w)
    largest = field.eta * min(here, slope_standing(rise.pieces, w > 1.0))
    if field.eta < 0.0:
        largest = field.eta * max(here, slope_standing(rise.pieces, w > 1.0))
    if not _is_held(field.damping + largest, displacement, x):
        return False
    least, most = slope_bounds(rise, low, high)
    return _is_held(field.damping + min(field.eta * least, field.eta * most), displacement, x)


@compilable
def _is_held(K: float, displacement: float, x: float) -> bool:
    """Whether chords that are nowhere less than K keep a state from w = 1."""
    return K > 2.0 and abs(displacement) * (K + math.sqrt(K * K - 4.0)) > 2.0 * abs(x)


@compilable
def _is_jump_between(rise: Rise, low: float, high: float) -> bool:
    """Whether the law jumps between two slip speeds."""
    jumps = False
    for i in range(len(rise.jumps)):
        jumps = jumps or (low < rise.levels[i] < high and rise.jumps[i] != 0.0)
    return jumps


@compilable
def slope_bounds(rise: Rise, low: float, high: float) -> tuple[float, float]:
    """Return numbers between which the derivative of a rise lies on a range of slip speeds.

    On a part of an interval it is off by what its own derivative, bounded by the sizes of its terms, makes of half
    the width.
    """
    pieces = rise.pieces
    last = len(pieces) - 1
    least = math.inf
    most = -math.inf
    for i in range(last + 1):
        begin = max(pieces[i][0], low)
        end = high
        if i < last:
            end = min(pieces[i + 1][0], high)
        if begin >= end:
            continue
        _ = pieces[i][0]
        origin = pieces[i][1]
        scale = pieces[i][2]
        reach = max(abs(begin - origin), abs(end - origin)) * scale
        bend = 0.0
        power = 1.0
        for k in range(2, 15):
            bend += k * (k - 1) * abs(pieces[i][3 + k]) * power
            power *= reach
        half = 0.5 * (end - begin) / _PARTS_OF_INTERVAL
        off = bend * scale * scale * half
        for j in range(_PARTS_OF_INTERVAL):
            slope = slope_at(Branch(pieces, i, i, i), begin + (2 * j + 1) * half)
            least = min(least, slope - off)
            most = max(most, slope + off)
    return least, most

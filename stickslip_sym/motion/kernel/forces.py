"""The rates of a slip at a state: w', its derivative by w, w'', and the rate of the wedge D."""

import math
from typing import Any

from stickslip_sym.core.numbers import EPSILON
from stickslip_sym.model.table import Pieces, Rise
from stickslip_sym.motion.compiled import compilable, inlined
from stickslip_sym.motion.kernel.slip_data import Branch, Field, Wedge

_CONTINUED_HALF_WIDTHS = 4.0  # half-widths of an interval from its middle, up to which a polynomial is continued
_BEYOND_SQUARED = _CONTINUED_HALF_WIDTHS * _CONTINUED_HALF_WIDTHS


@compilable
def interval_number(pieces: Any, first: int, last: int, near: int, w: float) -> int:
    """Return the number of the interval of w among those from first to last; it is likely to be near."""
    if pieces[near][0] <= w and (near == last or w < pieces[near + 1][0]):
        return near
    beyond = last + 1
    while beyond - first > 1:
        middle = (first + beyond) // 2
        if w >= pieces[middle][0]:
            first = middle
        else:
            beyond = middle
    return first


@compilable
def entered(rise: Rise, segment: int, rising: bool, w: float) -> Branch:
    """Return the law on a segment that is entered at w, from below if w rises."""
    first = rise.firsts[segment]
    last = rise.firsts[segment + 1] - 1
    return Branch(
        rise.pieces, first, last, interval_number(rise.pieces, first, last, first if rising else last, w)
    )


@inlined
def rate_at(branch: Branch, field: Field, q: float, w: float) -> float:
    """Return w'. Beyond the ends of a segment its law goes on as a polynomial, and then as a constant."""
    pieces, first, last, near = branch
    eta, push, side, damping = field
    if w < pieces[near][0] or (near < last and w >= pieces[near + 1][0]):  # seldom: most calls are saved
        near = interval_number(pieces, first, last, near, w)
    c = pieces[near]
    t = (w - c[1]) * c[2]
    t2 = t * t
    if t2 > _BEYOND_SQUARED:
        t = math.copysign(_CONTINUED_HALF_WIDTHS, t)
        t2 = t * t
    t4 = t2 * t2
    # Estrin's scheme: its products do not wait for one another, as those of Horner's do.
    lower = (c[3] + c[4] * t) + (c[5] + c[6] * t) * t2 + ((c[7] + c[8] * t) + (c[9] + c[10] * t) * t2) * t4
    upper = (c[11] + c[12] * t) + (c[13] + c[14] * t) * t2 + ((c[15] + c[16] * t) + c[17] * t2) * t4
    rate: float = (push + side * q - damping * w) - eta * (lower + upper * (t4 * t4))
    return rate


@compilable
def rise_at(branch: Branch, w: float) -> float:
    """Return mu(V w) - mu(0+), which is -w' where nothing but friction acts, with eta = 1."""
    return -rate_at(branch, Field(1.0, 0.0, 0.0, 0.0), 0.0, w)


@compilable
def standing(pieces: Pieces, above: bool) -> float:
    """Return a rise where the mass stands still, w = 1: its limit from slip speeds above, or from below."""
    return rise_at(_interval_at_rest(pieces, above), 1.0)


@compilable
def slope_standing(pieces: Pieces, above: bool) -> float:
    """Return the derivative of the rise there, on one side."""
    return slope_at(_interval_at_rest(pieces, above), 1.0)


@compilable
def _interval_at_rest(pieces: Pieces, above: bool) -> Branch:
    """Return the interval of slip speeds that begins, or ends, with w = 1, or holds it."""
    at = interval_number(pieces, 0, len(pieces) - 1, 0, 1.0)
    if not above and at > 0 and pieces[at][0] == 1.0:
        at -= 1
    return Branch(pieces, at, at, at)


@compilable
def slope_at(branch: Branch, w: float) -> float:
    """Return the derivative of the rise by w."""
    pieces, first, last, near = branch
    c = pieces[interval_number(pieces, first, last, near, w)]
    t = (w - c[1]) * c[2]
    if abs(t) > _CONTINUED_HALF_WIDTHS:
        return 0.0
    slope = (((14.0 * c[17] * t + 13.0 * c[16]) * t + 12.0 * c[15]) * t + 11.0 * c[14]) * t + 10.0 * c[13]
    slope = (((slope * t + 9.0 * c[12]) * t + 8.0 * c[11]) * t + 7.0 * c[10]) * t + 6.0 * c[9]
    slope = (((slope * t + 5.0 * c[8]) * t + 4.0 * c[7]) * t + 3.0 * c[6]) * t + 2.0 * c[5]
    return (slope * t + c[4]) * c[2]  # type: ignore[no-any-return]


@compilable
def bend_at(branch: Branch, field: Field, w: float, r: float) -> float:
    """Return w''."""
    eta, _, side, damping = field
    bend: float = side * (1.0 - side * w) - (eta * slope_at(branch, w) + damping) * r
    return bend


@compilable
def wedge_terms(branch: Branch, field: Field, wedge: Wedge, w: float) -> tuple[float, float]:
    """Return a and b of the wedge's equation D' = a D + b."""
    pieces, first, last, _ = branch
    eta, _, side, damping = field
    constant, linear, factor, own, _, _ = wedge
    push = constant + linear * w
    if factor != 0.0:
        # On this segment also where w is at its end, and another one begins.
        inside = max(w, pieces[first][0])
        if last + 1 < len(pieces):
            inside = min(inside, pieces[last + 1][0] * (1.0 - EPSILON))
        push += factor * rise_at(Branch(own, 0, len(own) - 1, 0), inside)
    return -eta * slope_at(branch, w) - damping, (1.0 - side * w) * push

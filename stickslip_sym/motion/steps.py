"""Slip, from where it begins to where it ends, whatever the law.

In units of the belt's speed V, of 1/omega and of V/omega: w = |V - x'|/V >= 0 is the slip speed, q the
displacement from the point P where every forward stick phase ends, and side = 1 where the mass is slower than
the belt, -1 where it is faster. With eta = N/(V sqrt(k m)) and zeta = c/(2 sqrt(k m)),

    q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.

So w = 0 is the belt's speed exactly, and P is the origin: no digits cancel where returns are decided. Backward in
time the equations are the same, with q, eta and zeta negated.

The law is a `Rise`: polynomials, in smooth segments between the kinks of mu. A step ends wherever
something happens: at an extremum of w, at a kink, at the belt's speed. So w is monotone in a step, and an extremum
is located before a crossing of w = 0: an orbit that grazes the belt's speed touches 0 and turns within a step, and
no change of sign is left to see. A state between two steps is one shorter step from the first.

At w = 0 static friction holds the mass where |c V + k x| <= mu_static N, from q = -hold = -2 eta mu_static to P.
Anywhere else the mass passes the belt's speed: side changes its sign, and w grows from 0 again.

Where mu jumps up, the rates on both sides may lead to the jump: the mass then slides at the slip speed of the
jump, w is constant and q a straight line, until one of the rates turns (Filippov's sliding mode).

With p any quantity on which the motion depends, the wedge D = f_q dw/dp - f_w dq/dp of the rates f = (q', w')
with the derivative of the state obeys one scalar equation, since div f does not depend on q:

    D' = (div f) D + (1 - side w) dw'/dp,    div f = -eta V mu'(V w) - 2 zeta.

At an extremum dw/dp = D/(1 - side w); at a level of w that p does not move, dq/dp = -D/w'. Where mu jumps at a
level b(p), D - (1 - side w) db/dp changes as w' does; and so does D where the mass passes the belt's speed.

Explicit steps are those of DOP853, a Runge-Kutta method of order 8; in a fast decay of w they are those of the
linearly implicit Euler method, extrapolated to order 8. A step that is to end at an extremum of w, or at a level,
is taken again with other lengths: it is as accurate as the integration, and there are no interpolants.

Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5 (DOP853); II, IV.9 (extrapolation).
"""

import math
from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import is_late
from stickslip_sym.model.table import Pieces, Rise
from stickslip_sym.motion.compiled import compilable, inlined


class End(IntEnum):
    """Why a slip ended, or the search for the damping that an orbit needs."""

    OPEN = -1  # it did not
    RETURN = 0  # w came down to 0, where the mass sticks, or may not pass the belt's speed once more
    MINIMUM = 1  # w turned before; an orbit that left P then never returns, since orbits in a plane do not cross
    MAXIMUM = 2  # w turned down
    LEVEL = 3  # w came to the level asked for
    REST = 4  # the mass came to rest, within the tolerance
    HORIZON = 5  # the time was over
    STEPS = 6  # the bound on the steps was reached
    OUTSIDE = 7  # w came to where the table of the law ends
    FAILED = 8  # no step is short enough for the tolerance, or no number of them
    LATE = 9  # the time of a `time_limit` was up
    CLOSED = 10  # the orbit closes at the damping that was sought
    NEVER = 11  # no damping closes the orbit


class Field(NamedTuple):
    """The forces on one side of the belt's speed: w' = push + side q - damping w - eta rise(w).

    - `push`: eta (side mu_static - mu(0+)).
    - `damping`: 2 zeta.
    """

    eta: float
    push: float
    side: float
    damping: float


class Branch(NamedTuple):
    """The law on one of its smooth segments.

    - `pieces`: those of the rise.
    - `first`, `last`: numbers of the first and the last one of the segment.
    - `near`: the number of one that is likely to hold the next w.
    """

    pieces: Any
    first: int
    last: int
    near: int


class Wedge(NamedTuple):
    """The quantity p of a wedge D: dw'/dp = constant + linear w + factor rise(w) at a fixed state.

    - `pieces`: the polynomials of that rise.
    - `shifts`: db/dp of the level b at which each segment of the law begins.
    - `wanted`: whether D is computed at all.
    """

    constant: float
    linear: float
    factor: float
    pieces: Pieces
    shifts: Sequence[float] | FloatArray
    wanted: bool = True


@compilable
def no_wedge(rise: Rise) -> Wedge:
    """Return a wedge that is not computed."""
    return Wedge(0.0, 0.0, 0.0, rise.pieces, np.zeros(len(rise.jumps)), False)


class State(NamedTuple):
    """A motion at one time tau: the displacement, the slip speed, its side and its rate w', and the wedge D."""

    tau: float
    q: float
    w: float
    side: float
    rate: float
    wedge: float


class Stop(NamedTuple):
    """Where a slip ends, besides where the mass sticks.

    - `until`: the number of one more `End` at which it stops: a minimum, a maximum or a level of w.
    - `level`: of w, at which a step ends in any case.
    - `horizon`: tau at which to stop.
    - `most`: how many steps it may take.
    - `passes`: how often the mass may pass the belt's speed.
    """

    until: int
    level: float
    horizon: float
    most: int
    passes: int


class Extent(NamedTuple):
    """How far a slip went.

    - `taken`, `passed`: how many steps it took, and how often the mass passed the belt's speed.
    - `q_least` to `u_most`: extremes of q, and of u = side w, at the ends of its steps.
    """

    taken: int
    passed: int
    q_least: float
    q_most: float
    u_least: float
    u_most: float


class Step(NamedTuple):
    """One step of a slip: its begin, its length in tau, and how it was taken.

    - `rate`: w' at the begin.
    - `segment`: number of the smooth segment of the law; -1 where the mass slides at a jump of mu.
    - `implicit`: by the method for fast decays.
    """

    tau: float
    q: float
    w: float
    rate: float
    length: float
    segment: int
    implicit: bool


class Run(NamedTuple):
    """A slip that was followed: why it ended, the state there, how far it went, its steps where recorded."""

    end: End
    state: State
    extent: Extent
    steps: list[Step]


class Trial(NamedTuple):
    """A step that was tried: its length, q, w, w' and D at its end, and its error over the tolerance."""

    length: float
    q: float
    w: float
    rate: float
    wedge: float
    error: float


class Pace(NamedTuple):
    """What the steps so far say of the next one.

    - `implicit`: whether it is taken by the method for fast decays.
    - `held`: how many explicit steps in a row stability held short.
    - `length`: to be tried next.
    - `tried`: the length of the last one.
    - `bearable`: the longest step that the tolerance bears, by the last one that it accepted.
    - `again`: whether the last one is taken again, shorter.
    """

    implicit: bool
    held: int
    length: float
    tried: float
    bearable: float
    again: bool


TIGHT = 1e-12
"""The relative tolerance of the steps along which numbers are found that others follow from."""
PRECISE = 1e-13
"""The relative error of a rise in its table, and the tolerance of steps where digits are wanted."""
ADDED = 100
"""Errors of a step that may add up along an orbit: within so many tolerances two states are one."""
MOST_STEPS = 60_000
"""Of a slip; the longest that end take some hundred."""
_LONGEST_STEP = 0.25  # explicit; at twice that what a step is off shows in thresholds
_STIFF = 10.0  # a decay of w, per unit of time, below which explicit steps are cheap enough
_STABLE = 2.5  # decay times a step, from which stability holds it short: the explicit method bears about 6
_LOOK = 100  # steps between two looks at the time limit
_PATIENCE = 15  # steps held short by stability before the method changes
_NO_ERROR = 1e-7  # of the tolerance, that may be nothing but rounding
_SHORTEST = 1e-14  # length of a step, over max(tau, 1), that is not made shorter
_REST_WITHIN = 10  # times the tolerance: nearer to rest the errors of steps do not let the mass come
_BESIDE = 1e-6  # of w = 1, over which the slope of mu at rest is taken
_CREEP = 2.0  # decay of w from which a deviation from rest has real exponents
_BEYOND = 4.0  # half-widths of an interval from its middle, up to which a polynomial is continued
_BEYOND_SQUARED = _BEYOND * _BEYOND
_SMALL = 0.01  # states below count as that large in an error: less than order 1, since events are where w is 0
_ROWS = 8  # of the extrapolation
_AMPLIFIED = 4e3  # their rounding errors by it, the sum of its weights
_ULP = 2.0**-52
_GUESSES = 20  # steps of Newton's method, after which a bracket is halved
_OFF = 1e-9  # of tau, over which a straight line is off by less than rounding
_CLOSE = 0.1  # of a step, times rtol^(1/3), over which a power series of three terms is off by a part of rtol

_A: tuple[tuple[float, ...], ...] = tuple(map(tuple, DOP853.A.tolist()))
_B, _E, _F = (tuple(row[:12].tolist()) for row in (DOP853.B, DOP853.E5, DOP853.E3))
_A21 = _A[1][0]
_A31, _A32 = _A[2][:2]
_A41, _, _A43 = _A[3][:3]
_A51, _, _A53, _A54 = _A[4][:4]
_A61, _, _, _A64, _A65 = _A[5][:5]
_A71, _, _, _A74, _A75, _A76 = _A[6][:6]
_A81, _, _, _A84, _A85, _A86, _A87 = _A[7][:7]
_A91, _, _, _A94, _A95, _A96, _A97, _A98 = _A[8][:8]
_A101, _, _, _A104, _A105, _A106, _A107, _A108, _A109 = _A[9][:9]
_A111, _, _, _A114, _A115, _A116, _A117, _A118, _A119, _A1110 = _A[10][:10]
_A121, _, _, _A124, _A125, _A126, _A127, _A128, _A129, _A1210, _A1211 = _A[11][:11]
_B1, _, _, _, _, _B6, _B7, _B8, _B9, _B10, _B11, _B12 = _B
_E1, _, _, _, _, _E6, _E7, _E8, _E9, _E10, _E11, _E12 = _E
_F1, _, _, _, _, _F6, _F7, _F8, _F9, _F10, _F11, _F12 = _F


@compilable
def interval(pieces: Any, first: int, last: int, near: int, w: float) -> int:
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


@inlined
def rate_at(branch: Branch, field: Field, q: float, w: float) -> float:
    """Return w'. Beyond the ends of a segment its law goes on as a polynomial, and then as a constant."""
    pieces, first, last, near = branch
    eta, push, side, damping = field
    if w < pieces[near][0] or (near < last and w >= pieces[near + 1][0]):  # seldom: most calls are saved
        near = interval(pieces, first, last, near, w)
    c = pieces[near]
    t = (w - c[1]) * c[2]
    t2 = t * t
    if t2 > _BEYOND_SQUARED:
        t = math.copysign(_BEYOND, t)
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
def slope_at(branch: Branch, w: float) -> float:
    """Return the derivative of the rise by w."""
    pieces, first, last, near = branch
    c = pieces[interval(pieces, first, last, near, w)]
    t = (w - c[1]) * c[2]
    if abs(t) > _BEYOND:
        return 0.0
    slope = (((14.0 * c[17] * t + 13.0 * c[16]) * t + 12.0 * c[15]) * t + 11.0 * c[14]) * t + 10.0 * c[13]
    slope = (((slope * t + 9.0 * c[12]) * t + 8.0 * c[11]) * t + 7.0 * c[10]) * t + 6.0 * c[9]
    slope = (((slope * t + 5.0 * c[8]) * t + 4.0 * c[7]) * t + 3.0 * c[6]) * t + 2.0 * c[5]
    return (slope * t + c[4]) * c[2]  # type: ignore[no-any-return]


@inlined
def stepped(
    implicit: bool, branch: Branch, field: Field, state: State, h: float, rtol: float, wedge: Wedge
) -> Trial:
    """Try a step of length h."""
    if implicit:
        return _implicit(branch, field, state, h, rtol, wedge)
    return _explicit(branch, field, state, h, rtol, wedge)


@compilable
def _explicit(branch: Branch, field: Field, state: State, h: float, rtol: float, wedge: Wedge) -> Trial:
    """Try a step of DOP853."""
    side, q, w, r1 = field.side, state.q, state.w, state.rate
    p1 = 1.0 - side * w
    q2, w2 = q + h * (_A21 * p1), w + h * (_A21 * r1)
    p2, r2 = 1.0 - side * w2, rate_at(branch, field, q2, w2)
    q3, w3 = q + h * (_A31 * p1 + _A32 * p2), w + h * (_A31 * r1 + _A32 * r2)
    p3, r3 = 1.0 - side * w3, rate_at(branch, field, q3, w3)
    q4, w4 = q + h * (_A41 * p1 + _A43 * p3), w + h * (_A41 * r1 + _A43 * r3)
    p4, r4 = 1.0 - side * w4, rate_at(branch, field, q4, w4)
    q5 = q + h * (_A51 * p1 + _A53 * p3 + _A54 * p4)
    w5 = w + h * (_A51 * r1 + _A53 * r3 + _A54 * r4)
    p5, r5 = 1.0 - side * w5, rate_at(branch, field, q5, w5)
    q6 = q + h * (_A61 * p1 + _A64 * p4 + _A65 * p5)
    w6 = w + h * (_A61 * r1 + _A64 * r4 + _A65 * r5)
    p6, r6 = 1.0 - side * w6, rate_at(branch, field, q6, w6)
    q7 = q + h * (_A71 * p1 + _A74 * p4 + _A75 * p5 + _A76 * p6)
    w7 = w + h * (_A71 * r1 + _A74 * r4 + _A75 * r5 + _A76 * r6)
    p7, r7 = 1.0 - side * w7, rate_at(branch, field, q7, w7)
    q8 = q + h * (_A81 * p1 + _A84 * p4 + _A85 * p5 + _A86 * p6 + _A87 * p7)
    w8 = w + h * (_A81 * r1 + _A84 * r4 + _A85 * r5 + _A86 * r6 + _A87 * r7)
    p8, r8 = 1.0 - side * w8, rate_at(branch, field, q8, w8)
    q9 = q + h * (_A91 * p1 + _A94 * p4 + _A95 * p5 + _A96 * p6 + _A97 * p7 + _A98 * p8)
    w9 = w + h * (_A91 * r1 + _A94 * r4 + _A95 * r5 + _A96 * r6 + _A97 * r7 + _A98 * r8)
    p9, r9 = 1.0 - side * w9, rate_at(branch, field, q9, w9)
    q10 = q + h * (_A101 * p1 + _A104 * p4 + _A105 * p5 + _A106 * p6 + _A107 * p7 + _A108 * p8 + _A109 * p9)
    w10 = w + h * (_A101 * r1 + _A104 * r4 + _A105 * r5 + _A106 * r6 + _A107 * r7 + _A108 * r8 + _A109 * r9)
    p10, r10 = 1.0 - side * w10, rate_at(branch, field, q10, w10)
    p = _A111 * p1 + _A114 * p4 + _A115 * p5 + _A116 * p6 + _A117 * p7 + _A118 * p8 + _A119 * p9 + _A1110 * p10
    r = _A111 * r1 + _A114 * r4 + _A115 * r5 + _A116 * r6 + _A117 * r7 + _A118 * r8 + _A119 * r9 + _A1110 * r10
    q11, w11 = q + h * p, w + h * r
    p11, r11 = 1.0 - side * w11, rate_at(branch, field, q11, w11)
    p = _A121 * p1 + _A124 * p4 + _A125 * p5 + _A126 * p6 + _A127 * p7 + _A128 * p8 + _A129 * p9
    r = _A121 * r1 + _A124 * r4 + _A125 * r5 + _A126 * r6 + _A127 * r7 + _A128 * r8 + _A129 * r9
    q12, w12 = q + h * (p + _A1210 * p10 + _A1211 * p11), w + h * (r + _A1210 * r10 + _A1211 * r11)
    p12, r12 = 1.0 - side * w12, rate_at(branch, field, q12, w12)
    p = _B1 * p1 + _B6 * p6 + _B7 * p7 + _B8 * p8 + _B9 * p9 + _B10 * p10 + _B11 * p11 + _B12 * p12
    r = _B1 * r1 + _B6 * r6 + _B7 * r7 + _B8 * r8 + _B9 * r9 + _B10 * r10 + _B11 * r11 + _B12 * r12
    q_end, w_end = q + h * p, w + h * r

    scale_q, scale_w = rtol * (_SMALL + max(abs(q), abs(q_end))), rtol * (_SMALL + max(abs(w), abs(w_end)))
    p = _E1 * p1 + _E6 * p6 + _E7 * p7 + _E8 * p8 + _E9 * p9 + _E10 * p10 + _E11 * p11 + _E12 * p12
    r = _E1 * r1 + _E6 * r6 + _E7 * r7 + _E8 * r8 + _E9 * r9 + _E10 * r10 + _E11 * r11 + _E12 * r12
    fifth = (p / scale_q) * (p / scale_q) + (r / scale_w) * (r / scale_w)
    p = _F1 * p1 + _F6 * p6 + _F7 * p7 + _F8 * p8 + _F9 * p9 + _F10 * p10 + _F11 * p11 + _F12 * p12
    r = _F1 * r1 + _F6 * r6 + _F7 * r7 + _F8 * r8 + _F9 * r9 + _F10 * r10 + _F11 * r11 + _F12 * r12
    third = (p / scale_q) * (p / scale_q) + (r / scale_w) * (r / scale_w)
    both = fifth + 0.01 * third
    error = h * fifth / math.sqrt(2.0 * both) if both > 0.0 else both

    D = state.wedge
    if wedge.wanted:
        speeds = (w, w2, w3, w4, w5, w6, w7, w8, w9, w10, w11, w12)
        rates = [0.0] * 12
        for i in range(12):
            a, b = _of_wedge(branch, field, wedge, speeds[i])
            change = 0.0
            for j in range(i):
                change += _A[i][j] * rates[j]
            rates[i] = a * (D + h * change) + b
        for i in range(12):
            D += h * _B[i] * rates[i]
    return Trial(h, q_end, w_end, rate_at(branch, field, q_end, w_end), D, error)


@compilable
def _of_wedge(branch: Branch, field: Field, wedge: Wedge, w: float) -> tuple[float, float]:
    """Return a and b of the wedge's equation D' = a D + b."""
    pieces, first, last, _ = branch
    eta, _, side, damping = field
    constant, linear, factor, own, _, _ = wedge
    push = constant + linear * w
    if factor != 0.0:
        # On this segment also where w is at its end, and another one begins.
        inside = max(w, pieces[first][0])
        if last + 1 < len(pieces):
            inside = min(inside, pieces[last + 1][0] * (1.0 - _ULP))
        push += factor * rise_at(Branch(own, 0, len(own) - 1, 0), inside)
    return -eta * slope_at(branch, w) - damping, (1.0 - side * w) * push


@compilable
def _implicit(branch: Branch, field: Field, state: State, h: float, rtol: float, wedge: Wedge) -> Trial:
    """Try a step of the extrapolated linearly implicit Euler method."""
    eta, push, side, damping = field
    q, w = state.q, state.w
    decay = eta * slope_at(branch, w) + damping
    of_q, of_w, of_D = [0.0] * _ROWS, [0.0] * _ROWS, [0.0] * _ROWS
    error = 0.0
    # No step is more accurate than the rounding of w', which the decay divides and the extrapolation multiplies.
    rounding = _AMPLIFIED * _ULP
    terms = max(max(abs(push), abs(eta * rise_at(branch, w))), max(abs(q), abs(damping * w)))
    least_q, least_w = rounding * abs(q), rounding * (terms / max(abs(decay), 1.0) + abs(w))
    for row in range(_ROWS):
        s = h / (row + 1)
        # (1 - s J) (dq, dw) = s (q', w') with J = ((0, -side), (side, -decay))
        determinant = 1.0 + s * decay + s * s
        x, y, z = q, w, state.wedge
        for _ in range(row + 1):
            dq, dw = s * (1.0 - side * y), s * rate_at(branch, field, x, y)
            x += ((1.0 + s * decay) * dq - s * side * dw) / determinant
            y += (dw + s * side * dq) / determinant
            if wedge.wanted:
                a, b = _of_wedge(branch, field, wedge, y)
                z = (z + s * b) / (1.0 - s * a)
        for k in range(row):
            # Neville's scheme, from the row before to this one; x, y and z hold the column that is known.
            ratio = (row + 1.0) / (row - k) - 1.0
            next_q, next_w, next_D = (
                x + (x - of_q[k]) / ratio,
                y + (y - of_w[k]) / ratio,
                z + (z - of_D[k]) / ratio,
            )
            of_q[k], of_w[k], of_D[k] = x, y, z
            if k == row - 1:
                off_q = (next_q - x) / (least_q + rtol * (_SMALL + max(abs(q), abs(next_q))))
                off_w = (next_w - y) / (least_w + rtol * (_SMALL + max(abs(w), abs(next_w))))
                error = math.sqrt(0.5 * (off_q * off_q + off_w * off_w))
            x, y, z = next_q, next_w, next_D
        of_q[row], of_w[row], of_D[row] = x, y, z
    return Trial(h, x, y, rate_at(branch, field, x, y), z, error)


@compilable
def _located(
    implicit: bool, branch: Branch, field: Field, state: State, beyond: Trial, rtol: float, wedge: Wedge,
    level: float, sign: float,
) -> Trial:  # fmt: skip
    """Return the step that ends at a level of w, or, if that is NaN, at an extremum.

    - `beyond`: a step that ends after it.
    - `sign`: of w - level, or of w', before.
    """
    turns, h = math.isnan(level), beyond.length
    # Newton's method in a bracket, from where the inverse of the value is 0, as a cubic through both ends.
    begin, end, by, by_end = state.w - level, beyond.w - level, state.rate, beyond.rate
    if turns:
        begin, by = by, _bend(branch, field, state.w, state.rate)
        end, by_end = by_end, _bend(branch, field, beyond.w, beyond.rate)
    part = begin / (begin - end) if begin * end < 0.0 else 0.5
    length = h * part
    if by * by_end > 0.0:
        length *= part * (3.0 - 2.0 * part)
        length += (end - begin) * part * (1.0 - part) * ((1.0 - part) / by - part / by_end)
    low, high, close = 0.0, h, _CLOSE * h * rtol ** (1.0 / 3.0)
    guesses = 0
    while True:
        guesses += 1
        if guesses > _GUESSES or not low < length < high:  # where mu is steep Newton's method may creep
            length = 0.5 * (low + high)
        trial = stepped(implicit, branch, field, state, length, rtol, wedge)
        value, bend = trial.rate if turns else trial.w - level, _bend(branch, field, trial.w, trial.rate)
        if value * sign > 0.0:
            low = length
        else:
            high = length
        change = bend if turns else trial.rate
        shift = -value / change if change != 0.0 else 0.0
        if not turns and trial.rate != 0.0:
            shift -= 0.5 * shift * shift * bend / trial.rate
        if abs(shift) <= (_OFF if turns else close) and (value == 0.0 or change != 0.0):
            return _moved(branch, field, trial, shift, bend, wedge)
        if high - low <= 4.0 * _ULP * h:
            return trial
        length += shift


@compilable
def _moved(branch: Branch, field: Field, trial: Trial, shift: float, bend: float, wedge: Wedge) -> Trial:
    """Return a step that ends a little later, by a few terms of a power series; its rate is left as it is.

    - `bend`: w'' at its end.
    """
    length, q, w, rate, D, error = trial
    if wedge.wanted:
        a, b = _of_wedge(branch, field, wedge, w)
        D += shift * (a * D + b)
    q += shift * (1.0 - field.side * w - shift * field.side * (0.5 * rate + shift * bend / 6.0))
    w += shift * (rate + 0.5 * shift * bend)
    return Trial(length + shift, q, w, rate, D, error)


@compilable
def _bend(branch: Branch, field: Field, w: float, r: float) -> float:
    """Return w''."""
    eta, _, side, damping = field
    bend: float = side * (1.0 - side * w) - (eta * slope_at(branch, w) + damping) * r
    return bend


@compilable
def follow(
    rise: Rise, field: Field, hold: float, begin: State, stop: Stop, wedge: Wedge, rtol: float, recorded: bool
) -> Run:
    """Follow slip from a state at tau = 0, whose side is that of the field; its rate is not read.

    - `hold`: 2 eta mu_static, the width in q of the range where static friction holds the mass.
    - `recorded`: keep the steps.
    """
    steps = [Step(0.0, 0.0, 0.0, 0.0, 0.0, 0, False)]
    steps.pop()
    q, u, farthest = begin.q, begin.side * begin.w, rise.levels[-1]
    taken, passed, q_least, q_most, u_least, u_most = 0, 0, q, q, u, u
    if not (begin.w <= farthest and abs(q) < math.inf):
        return Run(End.OUTSIDE, begin, Extent(taken, passed, q, q, u, u), steps)
    segment, rising, state = _begun(rise, field, begin)
    branch = entered(rise, segment, True, state.w)
    pace = _first_pace(field, state, rtol)
    at_kink = not rising and segment > 0 and state.w == rise.levels[segment]  # it leaves downward
    close = _BESIDE + _REST_WITHIN * rtol
    end = End.OPEN
    while end == End.OPEN:
        if at_kink:
            at_kink = False
            before = state
            end, segment, rising, state, slide = _enter(rise, field, state, segment, rising, stop, wedge)
            if slide > -1.0:
                if recorded:
                    steps.append(Step(before.tau, before.q, before.w, 0.0, slide, -1, False))
                taken, q_least, q_most = taken + 1, min(q_least, state.q), max(q_most, state.q)
            if end != End.OPEN:
                break
            branch = entered(rise, segment, rising, state.w)
            state = _at_rate(state, rate_at(branch, field, state.q, state.w))
        end = _interruption(state.tau, taken, stop)
        if end != End.OPEN:
            break
        trial, pace = _advance(branch, field, state, pace, stop.horizon - state.tau, rtol, wedge)
        shortest = _SHORTEST * max(state.tau, 1.0)
        if pace.again:
            end = End.FAILED if trial.length <= shortest else End.OPEN
            continue
        border = rise.levels[segment + 1] if rising else rise.levels[segment]
        event, trial = _land(branch, field, state, trial, rising, border, stop.level, pace.implicit, rtol, wedge)
        if event != End.OPEN and not trial.error < 1.0 and trial.length > shortest:
            pace = _shortened(pace, trial)
            continue
        if recorded:
            steps.append(Step(state.tau, state.q, state.w, state.rate, trial.length, segment, pace.implicit))
        is_over = event == End.OPEN and pace.tried == stop.horizon - state.tau
        tau = stop.horizon if is_over else state.tau + trial.length
        state = State(tau, trial.q, trial.w, field.side, trial.rate, trial.wedge)
        taken, u = taken + 1, field.side * trial.w
        q_least, q_most = min(q_least, trial.q), max(q_most, trial.q)
        u_least, u_most = min(u_least, u), max(u_most, u)
        near = interval(branch.pieces, branch.first, branch.last, branch.near, trial.w)
        if near != branch.near:
            branch = Branch(branch.pieces, branch.first, branch.last, near)
        may_rest = abs(trial.w - 1.0) <= close and event in (End.OPEN, End.LEVEL)
        if may_rest and _is_rest(rise, field, state, rising, rtol):
            end = End.REST
        elif event == End.LEVEL:
            at_kink = state.w == border and border > 0.0
            if state.w == 0.0 and (passed == stop.passes or -hold <= state.q <= 0.0):
                end = End.RETURN
            elif state.w == 0.0:
                field, state = _cross(branch, field, hold, state)
                passed, rising = passed + 1, True
            elif state.w == farthest:
                end = End.OUTSIDE
            elif stop.until == End.LEVEL and state.w == stop.level:
                end = End.LEVEL
        elif event != End.OPEN:
            rising, state = not rising, _at_rate(state, 0.0)
            end = event if stop.until == event else End.OPEN
    return Run(end, state, Extent(taken, passed, q_least, q_most, u_least, u_most), steps)


@compilable
def _begun(rise: Rise, field: Field, begin: State) -> tuple[int, bool, State]:
    """Return the segment of the law in which a slip begins, whether w rises there, and the state with its rate."""
    w, segment = begin.w, 0
    while segment + 2 < len(rise.levels) and w >= rise.levels[segment + 1]:
        segment += 1
    branch = entered(rise, segment, True, w)
    rate = rate_at(branch, field, begin.q, w)
    forces = abs(field.push) + abs(field.eta * rise_at(branch, w)) + abs(begin.q) + abs(field.damping * w)
    noise = PRECISE * forces
    rising = w == 0.0 or rate > noise or (abs(rate) <= noise and w < field.side)
    return segment, rising, _at_rate(begin, rate)


@compilable
def _first_pace(field: Field, state: State, rtol: float) -> Pace:
    """Return the pace of a slip that begins."""
    fastest = max(1.0, max(abs(1.0 - field.side * state.w), abs(state.rate)))
    length = min(3.0 * rtol**0.125 / fastest, _LONGEST_STEP)
    return Pace(False, 0, length, 0.0, length, False)


@compilable
def _interruption(tau: float, taken: int, stop: Stop) -> End:
    """Return why a slip is not followed further, or that it is."""
    end = End.OPEN
    if tau >= stop.horizon:
        end = End.HORIZON
    elif taken >= stop.most:
        end = End.STEPS
    elif taken % _LOOK == 0 and is_late():
        end = End.LATE
    return end


@inlined
def _advance(
    branch: Branch, field: Field, state: State, pace: Pace, longest: float, rtol: float, wedge: Wedge
) -> tuple[Trial, Pace]:
    """Try a step of the kind and the length that the steps before it say, and return it with the pace after it.

    The step is implicit where stability holds explicit ones short. One that is taken again is held short by
    accuracy, as where mu is singular.
    """
    implicit, held, length, tried, bearable, again = pace
    if not again:
        decay = field.eta * slope_at(branch, state.w) + field.damping
        # A third, so that the method does not change to and fro.
        if implicit and decay <= _STIFF / 3.0:
            implicit, held, length = False, 0, rtol**0.125 / max(1.0, abs(state.rate))
        elif not implicit:
            held = held + 1 if decay > _STIFF and decay * tried > _STABLE else 0
            implicit = held >= _PATIENCE
    h = min(length, longest)
    if not implicit:
        h = min(h, _LONGEST_STEP)
    trial = stepped(implicit, branch, field, state, h, rtol, wedge)
    error = trial.error
    again = not error < 1.0
    if again:
        length = h * max(0.2, 0.9 * error**-0.125 if error < math.inf else 0.0)
    else:
        # The longest step that the tolerance bears, which may go on falling as it fell in this one.
        before, bearable = bearable, h * max(error, _NO_ERROR) ** -0.125
        length = 0.85 * bearable * min(1.0, bearable / before)
    return trial, Pace(implicit, held, length, h, bearable, again)


@inlined
def _land(
    branch: Branch, field: Field, state: State, trial: Trial, rising: bool, border: float, level: float,
    implicit: bool, rtol: float, wedge: Wedge,
) -> tuple[End, Trial]:  # fmt: skip
    """Let a step end where w turns, or comes to a level before, and return which of them it is, and the step.

    - `border`: of the segment of the law, a level as `level` is.
    """
    event, w, ahead = End.OPEN, state.w, 1.0 if rising else -1.0
    # Where w' changes its sign there is an extremum if w'' = side - w has the sign for it; else it is rounding,
    # or the error of an implicit step.
    slowest = rtol ** (2.0 / 3.0) * max(1.0, abs(state.rate)) if implicit else 0.0
    turns = trial.rate < -slowest if rising else trial.rate > slowest
    if turns and (trial.w > field.side) == rising:
        event = End.MAXIMUM if rising else End.MINIMUM
        trial = _located(implicit, branch, field, state, trial, rtol, wedge, math.nan, ahead)
    inner = (w < level < border) if rising else (border < level < w)
    target = level if inner else border
    if (trial.w >= target) if rising else (trial.w <= target):
        event = End.LEVEL
        if trial.w != target:
            trial = _located(implicit, branch, field, state, trial, rtol, wedge, target, -ahead)
        rate = rate_at(branch, field, trial.q, target)
        trial = Trial(trial.length, trial.q, target, rate, trial.wedge, trial.error)
    return event, trial


@compilable
def _shortened(pace: Pace, trial: Trial) -> Pace:
    """Return the pace for shorter steps to where the last one came, as where mu is singular at the level."""
    return Pace(pace.implicit, pace.held, 0.5 * trial.length, pace.tried, pace.bearable, True)


@compilable
def _cross(branch: Branch, field: Field, hold: float, state: State) -> tuple[Field, State]:
    """Return the forces and the state beyond the belt's speed: friction turns, and D changes as w' does."""
    side = 1.0 if state.q > 0.0 else -1.0
    field = Field(field.eta, field.push + 0.5 * (side - field.side) * hold, side, field.damping)
    rate = rate_at(branch, field, state.q, state.w)
    return field, State(state.tau, state.q, state.w, side, rate, state.wedge * rate / state.rate)


@compilable
def _enter(
    rise: Rise, field: Field, state: State, segment: int, rising: bool, stop: Stop, wedge: Wedge
) -> tuple[End, int, bool, State, float]:
    """Let a mass pass the kink between two segments of the law, or slide where mu jumps there.

    Returns the end if it is one, the segment beyond, whether w rises there, the state, and how long the mass
      slides, -1 if it does not.
    """
    beyond = segment + 1 if rising else segment - 1
    upper = max(segment, beyond)
    across = rate_at(entered(rise, beyond, rising, state.w), field, state.q, state.w)
    end, slide = End.OPEN, -1.0
    if (across >= 0.0) == rising or rise.jumps[upper] == 0.0:
        segment = beyond
        if wedge.wanted and rise.jumps[upper] != 0.0:
            state = _through(field, state, across, wedge.shifts[upper])
    elif field.side * state.w == 1.0:
        end, state = End.REST, _at_rate(state, 0.0)
    else:
        turn, segment, rising, slide = _slide(rise, field, state, upper, rising, stop.horizon)
        state = _slid(field, state, slide, wedge.shifts[upper])
        if turn == stop.until:
            end, state = turn, _at_rate(state, 0.0)
    return end, segment, rising, state, slide


@compilable
def _through(field: Field, state: State, across: float, shift: float) -> State:
    """Return the state beyond a jump of mu, where w' is `across`; `shift` is that of the jump with p."""
    moved, D = shift * (1.0 - field.side * state.w), state.wedge
    if state.rate != 0.0:
        D = moved + (D - moved) * across / state.rate
    return State(state.tau, state.q, state.w, state.side, state.rate, D)


@compilable
def _slide(
    rise: Rise, field: Field, state: State, upper: int, came_rising: bool, horizon: float
) -> tuple[End, int, bool, float]:
    """Find where a mass leaves a jump of mu at which it slides, since the rates on both sides lead to the jump.

    It does so when the rate on the side that it leaves to turns.

    - `upper`: the number of the segment that begins with the jump.

    Returns the extremum of w that the slide is, if it is one, the segment that it leaves to, whether w rises then,
      and how long it slides.
    """
    speed = field.side * (1.0 - field.side * state.w)
    rising = speed > 0.0
    segment = upper if rising else upper - 1
    turning = rate_at(entered(rise, segment, rising, state.w), field, state.q, state.w)
    length = min(horizon - state.tau, max(0.0, -turning / speed))
    turn = End.OPEN
    if rising != came_rising:
        turn = End.MINIMUM if rising else End.MAXIMUM
    return turn, segment, rising, length


@compilable
def _slid(field: Field, state: State, length: float, shift: float) -> State:
    """Return the state after a slide at a jump of mu, the motions beside it lying on it."""
    speed = 1.0 - field.side * state.w
    return State(state.tau + length, state.q + length * speed, state.w, state.side, 0.0, shift * speed)


@compilable
def _at_rate(state: State, rate: float) -> State:
    """Return a state with its rate."""
    return State(state.tau, state.q, state.w, state.side, rate, state.wedge)


@compilable
def entered(rise: Rise, segment: int, rising: bool, w: float) -> Branch:
    """Return the law on a segment that is entered at w, from below if w rises."""
    first, last = rise.firsts[segment], rise.firsts[segment + 1] - 1
    return Branch(rise.pieces, first, last, interval(rise.pieces, first, last, first if rising else last, w))


@compilable
def _is_rest(rise: Rise, field: Field, state: State, rising: bool, rtol: float) -> bool:
    """Whether a mass with w near 1 is at rest within the tolerance, and stays there.

    Where two segments of the law meet at rest, a motion may come to it in swings over both, where deviations decay
    on the mean, or creep to it on one side, where that side has real exponents below 0.
    """
    eta, push, side, damping = field
    q, w = state.q, state.w
    if side < 0.0 or rise.levels[-1] <= 1.0 + _BESIDE:
        return False
    whole = Branch(rise.pieces, 0, rise.firsts[-1] - 1, 0)
    lifted = eta * rise_at(whole, 1.0)
    faster = (eta * rise_at(whole, 1.0 + _BESIDE) - lifted) / _BESIDE + damping
    slower = (lifted - eta * rise_at(whole, 1.0 - _BESIDE)) / _BESIDE + damping
    rest = damping - push + lifted
    fastest = max(abs(faster), abs(slower))
    noise = _ULP * max(max(abs(push), abs(lifted)), max(abs(rest), abs(damping)))
    if fastest > _STIFF:  # of implicit steps
        noise *= _AMPLIFIED / fastest
    close = _REST_WITHIN * (rtol + noise)
    if abs(w - 1.0) > close or abs(q - rest) > close * max(1.0, abs(rest)):
        return False
    decay = slower if w < 1.0 or (w == 1.0 and rising) else faster
    return bool(faster + slower > 0.0 or decay >= _CREEP)

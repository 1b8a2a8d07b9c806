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

Functions here take

- `law`: the pieces of the rise, the first and the last of the smooth segment that w is in, and one near w;
- `system`: eta, push = eta (side mu_static - mu(0+)), side, and 2 zeta;
- `wedge`: whether D is wanted, its value, and the fields of a `Wedge`.

Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5 (DOP853); II, IV.9 (extrapolation).
"""

import math
from enum import IntEnum
from typing import Any

from scipy.integrate import DOP853

from stickslip_sym.core.deadline import is_late
from stickslip_sym.motion.compiled import compilable


class End(IntEnum):
    """Why a slip ended."""

    OPEN = -1  # it did not
    RETURN = 0  # w came down to 0, where the mass sticks, or may not pass the belt's speed once more
    MINIMUM = 1  # w turned before; an orbit that left P then never returns, since orbits in a plane do not cross
    MAXIMUM = 2  # w turned down
    LEVEL = 3  # w came to the level asked for
    REST = 4  # the mass came to rest, within the tolerance
    HORIZON = 5  # the time was over
    STEPS = 6  # the bound on the steps was reached
    OUTSIDE = 7  # w came to where the table of the law ends
    FAILED = 8  # no step is short enough for the tolerance
    LATE = 9  # the time of a `time_limit` was up


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


@compilable
def rate_at(law: Any, system: Any, q: float, w: float) -> float:
    """Return w'. Beyond the ends of a segment its law goes on as a polynomial, and then as a constant."""
    pieces, first, last, near = law
    eta, push, side, damping = system
    c = pieces[interval(pieces, first, last, near, w)]
    t = (w - c[1]) * c[2]
    if t < -_BEYOND:
        t = -_BEYOND
    elif t > _BEYOND:
        t = _BEYOND
    t2 = t * t
    t4 = t2 * t2
    # Estrin's scheme: its products do not wait for one another, as those of Horner's do.
    lower = (c[3] + c[4] * t) + (c[5] + c[6] * t) * t2 + ((c[7] + c[8] * t) + (c[9] + c[10] * t) * t2) * t4
    upper = (c[11] + c[12] * t) + (c[13] + c[14] * t) * t2 + ((c[15] + c[16] * t) + c[17] * t2) * t4
    rate: float = (push + side * q - damping * w) - eta * (lower + upper * (t4 * t4))
    return rate


@compilable
def rise_at(law: Any, w: float) -> float:
    """Return mu(V w) - mu(0+), which is -w' where nothing but friction acts, with eta = 1."""
    return -rate_at(law, (1.0, 0.0, 0.0, 0.0), 0.0, w)


@compilable
def slope_at(law: Any, w: float) -> float:
    """Return the derivative of the rise by w."""
    pieces, first, last, near = law
    c = pieces[interval(pieces, first, last, near, w)]
    t = (w - c[1]) * c[2]
    slope: float = 0.0
    if abs(t) > _BEYOND:
        return slope
    for k in range(14, 0, -1):
        slope = slope * t + k * c[k + 3]
    return slope * c[2]  # type: ignore[no-any-return]


@compilable
def stepped(
    implicit: bool, law: Any, system: Any, q: float, w: float, r: float, h: float, rtol: float, wedge: Any
) -> Any:
    """Take a step, and return q, w, w' and D at its end, and the error over the tolerance."""
    if implicit:
        return _implicit(law, system, q, w, h, rtol, wedge)
    return _explicit(law, system, q, w, r, h, rtol, wedge)


@compilable
def _explicit(law: Any, system: Any, q: float, w: float, r1: float, h: float, rtol: float, wedge: Any) -> Any:
    """Take a step of DOP853."""
    side = system[2]
    p1 = 1.0 - side * w
    q2, w2 = q + h * (_A21 * p1), w + h * (_A21 * r1)
    p2, r2 = 1.0 - side * w2, rate_at(law, system, q2, w2)
    q3, w3 = q + h * (_A31 * p1 + _A32 * p2), w + h * (_A31 * r1 + _A32 * r2)
    p3, r3 = 1.0 - side * w3, rate_at(law, system, q3, w3)
    q4, w4 = q + h * (_A41 * p1 + _A43 * p3), w + h * (_A41 * r1 + _A43 * r3)
    p4, r4 = 1.0 - side * w4, rate_at(law, system, q4, w4)
    q5 = q + h * (_A51 * p1 + _A53 * p3 + _A54 * p4)
    w5 = w + h * (_A51 * r1 + _A53 * r3 + _A54 * r4)
    p5, r5 = 1.0 - side * w5, rate_at(law, system, q5, w5)
    q6 = q + h * (_A61 * p1 + _A64 * p4 + _A65 * p5)
    w6 = w + h * (_A61 * r1 + _A64 * r4 + _A65 * r5)
    p6, r6 = 1.0 - side * w6, rate_at(law, system, q6, w6)
    q7 = q + h * (_A71 * p1 + _A74 * p4 + _A75 * p5 + _A76 * p6)
    w7 = w + h * (_A71 * r1 + _A74 * r4 + _A75 * r5 + _A76 * r6)
    p7, r7 = 1.0 - side * w7, rate_at(law, system, q7, w7)
    q8 = q + h * (_A81 * p1 + _A84 * p4 + _A85 * p5 + _A86 * p6 + _A87 * p7)
    w8 = w + h * (_A81 * r1 + _A84 * r4 + _A85 * r5 + _A86 * r6 + _A87 * r7)
    p8, r8 = 1.0 - side * w8, rate_at(law, system, q8, w8)
    q9 = q + h * (_A91 * p1 + _A94 * p4 + _A95 * p5 + _A96 * p6 + _A97 * p7 + _A98 * p8)
    w9 = w + h * (_A91 * r1 + _A94 * r4 + _A95 * r5 + _A96 * r6 + _A97 * r7 + _A98 * r8)
    p9, r9 = 1.0 - side * w9, rate_at(law, system, q9, w9)
    q10 = q + h * (_A101 * p1 + _A104 * p4 + _A105 * p5 + _A106 * p6 + _A107 * p7 + _A108 * p8 + _A109 * p9)
    w10 = w + h * (_A101 * r1 + _A104 * r4 + _A105 * r5 + _A106 * r6 + _A107 * r7 + _A108 * r8 + _A109 * r9)
    p10, r10 = 1.0 - side * w10, rate_at(law, system, q10, w10)
    p = _A111 * p1 + _A114 * p4 + _A115 * p5 + _A116 * p6 + _A117 * p7 + _A118 * p8 + _A119 * p9 + _A1110 * p10
    r = _A111 * r1 + _A114 * r4 + _A115 * r5 + _A116 * r6 + _A117 * r7 + _A118 * r8 + _A119 * r9 + _A1110 * r10
    q11, w11 = q + h * p, w + h * r
    p11, r11 = 1.0 - side * w11, rate_at(law, system, q11, w11)
    p = _A121 * p1 + _A124 * p4 + _A125 * p5 + _A126 * p6 + _A127 * p7 + _A128 * p8 + _A129 * p9
    r = _A121 * r1 + _A124 * r4 + _A125 * r5 + _A126 * r6 + _A127 * r7 + _A128 * r8 + _A129 * r9
    q12, w12 = q + h * (p + _A1210 * p10 + _A1211 * p11), w + h * (r + _A1210 * r10 + _A1211 * r11)
    p12, r12 = 1.0 - side * w12, rate_at(law, system, q12, w12)
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

    wanted, D, source = wedge
    if wanted:
        speeds = (w, w2, w3, w4, w5, w6, w7, w8, w9, w10, w11, w12)
        rates = [0.0] * 12
        for i in range(12):
            a, b = _of_wedge(law, system, source, speeds[i])
            change = 0.0
            for j in range(i):
                change += _A[i][j] * rates[j]
            rates[i] = a * (D + h * change) + b
        for i in range(12):
            D += h * _B[i] * rates[i]
    return q_end, w_end, rate_at(law, system, q_end, w_end), D, error


@compilable
def _of_wedge(law: Any, system: Any, source: Any, w: float) -> tuple[float, float]:
    """Return a and b of the wedge's equation D' = a D + b."""
    pieces, first, last, _ = law
    eta, _, side, damping = system
    constant, linear, factor, own, _ = source
    push = constant + linear * w
    if factor != 0.0:
        # On this segment also where w is at its end, and another one begins.
        inside = max(w, pieces[first][0])
        if last + 1 < len(pieces):
            inside = min(inside, pieces[last + 1][0] * (1.0 - _ULP))
        push += factor * rise_at((own, 0, len(own) - 1, 0), inside)
    return -eta * slope_at(law, w) - damping, (1.0 - side * w) * push


@compilable
def _implicit(law: Any, system: Any, q: float, w: float, h: float, rtol: float, wedge: Any) -> Any:
    """Take a step of the extrapolated linearly implicit Euler method."""
    eta, push, side, damping = system
    wanted, D, source = wedge
    decay = eta * slope_at(law, w) + damping
    of_q, of_w, of_D = [0.0] * _ROWS, [0.0] * _ROWS, [0.0] * _ROWS
    error = 0.0
    # No step is more accurate than the rounding of w', which the decay divides and the extrapolation multiplies.
    rounding = _AMPLIFIED * _ULP
    terms = max(max(abs(push), abs(eta * rise_at(law, w))), max(abs(q), abs(damping * w)))
    least_q, least_w = rounding * abs(q), rounding * (terms / max(abs(decay), 1.0) + abs(w))
    for row in range(_ROWS):
        s = h / (row + 1)
        # (1 - s J) (dq, dw) = s (q', w') with J = ((0, -side), (side, -decay))
        determinant = 1.0 + s * decay + s * s
        x, y, z = q, w, D
        for _ in range(row + 1):
            dq, dw = s * (1.0 - side * y), s * rate_at(law, system, x, y)
            x += ((1.0 + s * decay) * dq - s * side * dw) / determinant
            y += (dw + s * side * dq) / determinant
            if wanted:
                a, b = _of_wedge(law, system, source, y)
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
    return x, y, rate_at(law, system, x, y), z, error


@compilable
def _located(
    implicit: bool, law: Any, system: Any, q: float, w: float, r: float, h: float, rtol: float, wedge: Any,
    w_h: float, r_h: float, level: float, sign: float,
) -> Any:  # fmt: skip
    """Return the length of the step that ends at a level of w, or, if that is NaN, at an extremum; and that step.

    - `h`: of a step that ends beyond, with `w_h` and `r_h`.
    - `sign`: of w - level, or of w', before.
    """
    side, turns = system[2], math.isnan(level)
    # Newton's method in a bracket, from where the inverse of the value is 0, as a cubic through both ends.
    begin, end = (r, r_h) if turns else (w - level, w_h - level)
    by, by_end = (_bend(law, system, w, r), _bend(law, system, w_h, r_h)) if turns else (r, r_h)
    part = begin / (begin - end) if begin * end < 0.0 else 0.5
    length = h * part
    if by * by_end > 0.0:
        length *= part * (3.0 - 2.0 * part)
        length += (end - begin) * part * (1.0 - part) * ((1.0 - part) / by - part / by_end)
    low, high, close = 0.0, h, _CLOSE * h * rtol ** (1.0 / 3.0)
    q_now, w_now, r_now, D_now, error = q, w, r, 0.0, 0.0
    guesses = 0
    while True:
        guesses += 1
        if guesses > _GUESSES or not low < length < high:  # where mu is steep Newton's method may creep
            length = 0.5 * (low + high)
        q_now, w_now, r_now, D_now, error = stepped(implicit, law, system, q, w, r, length, rtol, wedge)
        value, bend = r_now if turns else w_now - level, _bend(law, system, w_now, r_now)
        if value * sign > 0.0:
            low = length
        else:
            high = length
        change = bend if turns else r_now
        shift = -value / change if change != 0.0 else 0.0
        if not turns and r_now != 0.0:
            shift -= 0.5 * shift * shift * bend / r_now
        if abs(shift) <= (_OFF if turns else close) and (value == 0.0 or change != 0.0):
            # What is left is a few terms of a power series; at an extremum w is stationary.
            if wedge[0]:
                a, b = _of_wedge(law, system, wedge[2], w_now)
                D_now += shift * (a * D_now + b)
            q_now += shift * (1.0 - side * w_now - shift * side * (0.5 * r_now + shift * bend / 6.0))
            w_now += shift * (r_now + 0.5 * shift * bend)
            length += shift
            break
        if high - low <= 4.0 * _ULP * h:
            break
        length += shift
    return length, q_now, w_now, r_now, D_now, error


@compilable
def _bend(law: Any, system: Any, w: float, r: float) -> float:
    """Return w''."""
    eta, _, side, damping = system
    bend: float = side * (1.0 - side * w) - (eta * slope_at(law, w) + damping) * r
    return bend


@compilable
def follow(
    rise: Any, eta: float, zeta: float, push: float, hold: float, side: float, q: float, w: float, horizon: float,
    most: int, passes: int, rtol: float, until: int, level: float, wedge: Any, recorded: bool,
) -> Any:  # fmt: skip
    """Follow slip, and return its end, the state there, how far it went, and all steps.

    The state is tau, q, w, side, w' and the wedge; how far: the numbers of steps and of passes, and the least and
    the largest q, and side w, at the ends of the steps.

    - `push`: eta (side mu_static - mu(0+)).
    - `hold`: 2 eta mu_static.
    - `most`: how many steps it may take.
    - `passes`: how often the mass may pass the belt's speed.
    - `until`: the number of one more `End` at which it stops: a minimum, a maximum or a level of w.
    - `level`: of w, at which a step ends in any case.
    - `wedge`: whether it is wanted, its value at the begin, and the fields of a `Wedge`.
    """
    pieces, levels, firsts, jumps = rise
    wanted, D, source = wedge
    damping = 2.0 * zeta
    system = (eta, push, side, damping)
    steps = [(0.0, 0.0, 0.0, 0.0, 0.0, 0, False)]
    steps.pop()
    tau, count, passed, held, implicit, h, again = 0.0, 0, 0, 0, False, 0.0, False
    q_least, q_most, u_least, u_most = q, q, side * w, side * w
    segments = len(firsts) - 1
    farthest = levels[segments]
    if not (w <= farthest and abs(q) < math.inf):
        return End.OUTSIDE, (tau, q, w, side, 0.0, D), (count, passed, q, q, u_least, u_most), steps
    segment = 0
    while segment + 1 < segments and w >= levels[segment + 1]:
        segment += 1
    law = entered(rise, segment, True, w)
    r = rate_at(law, system, q, w)
    noise = PRECISE * (abs(push) + abs(eta * rise_at(law, w)) + abs(q) + abs(damping * w))
    rising = w == 0.0 or r > noise or (abs(r) <= noise and w < side)
    arrived = not rising and segment > 0 and w == levels[segment]  # at a kink, which it leaves downward
    length = min(3.0 * rtol**0.125 / max(1.0, max(abs(1.0 - side * w), abs(r))), _LONGEST_STEP)
    bearable = length

    end = End.OPEN
    while end == End.OPEN:
        if arrived:
            arrived = False
            beyond = segment + 1 if rising else segment - 1
            upper = max(segment, beyond)
            across = rate_at(entered(rise, beyond, rising, w), system, q, w)
            if (across >= 0.0) == rising or jumps[upper] == 0.0:
                if wanted and jumps[upper] != 0.0 and r != 0.0:
                    shift = source[4][upper] * (1.0 - side * w)
                    D = shift + (D - shift) * across / r
                segment = beyond
            elif side * w == 1.0:
                end, r = End.REST, 0.0
                break
            else:
                # Both rates lead to the jump: the mass slides, until the one on the side that it leaves to turns.
                fell, rising = not rising, side * (1.0 - side * w) > 0.0
                segment = upper if rising else upper - 1
                turning = rate_at(entered(rise, segment, rising, w), system, q, w)
                duration = min(horizon - tau, max(0.0, -turning / (side * (1.0 - side * w))))
                if recorded:
                    steps.append((tau, q, w, 0.0, duration, -1, False))
                tau, q, count = tau + duration, q + duration * (1.0 - side * w), count + 1
                q_least, q_most = min(q_least, q), max(q_most, q)
                D = source[4][upper] * (1.0 - side * w)
                turn = End.MINIMUM if rising else End.MAXIMUM
                if fell == rising and until == turn:
                    end, r = turn, 0.0
                    break
            law = entered(rise, segment, rising, w)
            r = rate_at(law, system, q, w)
        if tau >= horizon:
            end = End.HORIZON
        elif count >= most:
            end = End.STEPS
        elif count % _LOOK == 0 and is_late():
            end = End.LATE
        if end != End.OPEN:
            break

        # The kind of the step: implicit where stability holds explicit ones short. A step that is taken again is
        # held short by accuracy, as where mu is singular.
        if not again:
            decay = eta * slope_at(law, w) + damping
            # A third, so that the method does not change to and fro.
            if implicit and decay <= _STIFF / 3.0:
                implicit, held, length = False, 0, rtol**0.125 / max(1.0, abs(r))
            elif not implicit:
                held = held + 1 if decay > _STIFF and decay * h > _STABLE else 0
                if held >= _PATIENCE:
                    implicit = True
        h = min(length, horizon - tau)
        if not implicit:
            h = min(h, _LONGEST_STEP)
        wedge = (wanted, D, source)
        q_now, w_now, r_now, D_now, error = stepped(implicit, law, system, q, w, r, h, rtol, wedge)
        shortest = _SHORTEST * max(tau, 1.0)
        again = not error < 1.0
        if again:
            if h <= shortest:
                end = End.FAILED
            length = h * max(0.2, 0.9 * error**-0.125 if error < math.inf else 0.0)
            continue
        # The longest step that the tolerance bears, which may go on falling as it fell in this one.
        before, bearable = bearable, h * max(error, _NO_ERROR) ** -0.125
        length = 0.85 * bearable * min(1.0, bearable / before)

        # Where w' changes its sign there is an extremum if w'' = side - w has the sign for it; else it is
        # rounding, or the error of an implicit step.
        event, taken, ahead = End.OPEN, h, 1.0 if rising else -1.0
        slowest = rtol ** (2.0 / 3.0) * max(1.0, abs(r)) if implicit else 0.0
        if (r_now < -slowest if rising else r_now > slowest) and (w_now > side) == rising:
            event = End.MAXIMUM if rising else End.MINIMUM
            taken, q_now, w_now, r_now, D_now, error = _located(
                implicit, law, system, q, w, r, h, rtol, wedge, w_now, r_now, math.nan, ahead
            )
        border = levels[segment + 1] if rising else levels[segment]
        inner = (w < level < border) if rising else (border < level < w)
        target = level if inner else border
        if (w_now >= target) if rising else (w_now <= target):
            if w_now != target:
                taken, q_now, w_now, r_now, D_now, error = _located(
                    implicit, law, system, q, w, r, taken, rtol, wedge, w_now, r_now, target, -ahead
                )
            event, w_now, r_now = End.LEVEL, target, rate_at(law, system, q_now, target)
        if event != End.OPEN and not error < 1.0 and taken > shortest:
            length = 0.5 * taken  # as where mu is singular at the level: its step is taken in shorter ones
            again = True
            continue

        if recorded:
            steps.append((tau, q, w, r, taken, segment, implicit))
        tau = horizon if event == End.OPEN and h == horizon - tau else tau + taken
        q, w, r, D = q_now, w_now, r_now, D_now
        q_least, q_most = min(q_least, q), max(q_most, q)
        u_least, u_most = min(u_least, side * w), max(u_most, side * w)
        count += 1
        law = (pieces, law[1], law[2], interval(pieces, law[1], law[2], law[3], w))
        if (
            event in (End.OPEN, End.LEVEL)
            and abs(w - 1.0) <= _BESIDE + _REST_WITHIN * rtol
            and _is_rest(rise, system, q, w, rising, rtol)
        ):
            end = End.REST
        elif event == End.LEVEL:
            if target == 0.0 and (passed == passes or -hold <= q <= 0.0):
                end = End.RETURN
            elif target == 0.0:
                before, passed, rising = side, passed + 1, True
                side = 1.0 if q > 0.0 else -1.0
                push += 0.5 * (side - before) * hold
                system = (eta, push, side, damping)
                across = rate_at(law, system, q, w)
                D, r = D * across / r, across
            elif target == farthest and not inner:
                end = End.OUTSIDE
            elif until == End.LEVEL and level == target:
                end = End.LEVEL
            arrived = not inner and target != 0.0
        elif event != End.OPEN:
            r, rising = 0.0, not rising
            if until == event:
                end = event
    return end, (tau, q, w, side, r, D), (count, passed, q_least, q_most, u_least, u_most), steps


@compilable
def entered(rise: Any, segment: int, rising: bool, w: float) -> Any:
    """Return the law on a segment that is entered at w, from below if w rises."""
    pieces, _, firsts, _ = rise
    first, last = firsts[segment], firsts[segment + 1] - 1
    return pieces, first, last, interval(pieces, first, last, first if rising else last, w)


@compilable
def _is_rest(rise: Any, system: Any, q: float, w: float, rising: bool, rtol: float) -> bool:
    """Whether a mass with w near 1 is at rest within the tolerance, and stays there.

    Where two segments of the law meet at rest, a motion may come to it in swings over both, where deviations decay
    on the mean, or creep to it on one side, where that side has real exponents below 0.
    """
    eta, push, side, damping = system
    pieces, levels, firsts, _ = rise
    if side < 0.0 or levels[len(levels) - 1] <= 1.0 + _BESIDE:
        return False
    whole = (pieces, 0, firsts[len(firsts) - 1] - 1, 0)
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

"""One slip phase: from where it begins to where it ends, whatever the law.

In units of the belt's speed V, of 1/omega and of V/omega: w = |V - x'|/V >= 0 is the slip speed, q the
displacement from the point P where every forward stick phase ends, and side = 1 where the mass is slower than
the belt, -1 where it is faster. With eta = N/(V sqrt(k m)) and zeta = c/(2 sqrt(k m)),

    q' = 1 - side w,    w' = eta (side mu_static - mu(V w)) + side q - 2 zeta w.

So w = 0 is the belt's speed exactly, and P is the origin: no digits cancel where returns are decided.

The law is a `Rise`: polynomials, in smooth segments between the kinks of mu. Steps are those of DOP853, an
explicit Runge-Kutta method of order 8, and in a fast decay of w those of the linearly implicit Euler method,
extrapolated to order 8. A step ends wherever something happens: at an extremum of w, at a kink, at the belt's
speed. So w is monotone in a step, and an extremum is located before a crossing of w = 0: an orbit that grazes
the belt's speed touches 0 and turns within a step, and no change of sign is left to see. What ends a step is a
root in the length of the step, located by steps: it is as accurate as the integration, and there are no
interpolants. A state between two steps is one shorter step from the first.

Where mu jumps up, the rates on both sides may lead to the jump: the mass then slides at the slip speed of the
jump, w is constant and q a straight line, until one of the rates turns (Filippov's sliding mode).

With p any quantity on which the motion depends, the wedge D = f_q dw/dp - f_w dq/dp of the rates f = (q', w')
with the derivative of the state obeys one scalar equation, since div f does not depend on q:

    D' = (div f) D + (1 - side w) dw'/dp,    div f = -eta V mu'(V w) - 2 zeta.

At an extremum dw/dp = D/(1 - side w); at a level of w that p does not move, dq/dp = -D/w'. Where mu jumps at a
level b(p), D - (1 - side w) db/dp changes as w' does.

Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.5 (DOP853); II, IV.9 (extrapolation).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import DOP853

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.deadline import check_time, time_left
from stickslip_sym.core.errors import InputError, NotConverged, StickSlipError
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.compiled import compilable, compiled, is_compiling
from stickslip_sym.motion.table import FARTHEST, FrictionTable, Pieces, Rise
from stickslip_sym.motion.workers import spread

__all__ = ["EVERY_TURN", "Dimensionless", "End", "Slip", "Slips", "Step", "Wedge", "follow"]


class End(IntEnum):
    """Why a slip ended."""

    RETURN = 0
    """w came down to 0."""
    MINIMUM = 1
    """w turned before. An orbit that left P then never returns, since orbits in a plane do not cross."""
    MAXIMUM = 2
    """w turned down."""
    LEVEL = 3
    """w came to the level asked for."""
    REST = 4
    """The mass came to rest, within the tolerance."""
    HORIZON = 5
    """The time was over."""
    STEPS = 6
    """The bound on the steps was reached."""
    OUTSIDE = 7
    """w came to where the table of the law ends."""
    FAILED = 8
    """No step is short enough for the tolerance."""


class Step(NamedTuple):
    """One step of a slip: its begin, its length in tau, and how it was taken.

    - `rate`: w' at the begin.
    - `segment`: number of the smooth segment of the law.
    - `kind`: `EXPLICIT`, `IMPLICIT` or `SLIDING`.
    """

    tau: float
    q: float
    w: float
    rate: float
    length: float
    segment: int
    kind: int


class Wedge(NamedTuple):
    """The quantity p of a wedge D: dw'/dp = constant + linear w + factor rise(w) at a fixed state.

    - `pieces`: the polynomials of that rise.
    - `shifts`: db/dp of the level b at which each segment of the law begins.
    """

    constant: float
    linear: float
    factor: float
    pieces: Pieces
    shifts: Sequence[float] | FloatArray


class Slip(NamedTuple):
    """The end of a slip: why, when, where, and with which rate and wedge.

    - `rate`: w' there.
    - `wedge`: D there.
    - `taken`: how many steps it took.
    - `steps`: all of them where they were recorded.
    """

    end: End
    tau: float
    q: float
    w: float
    rate: float
    wedge: float
    taken: int
    steps: list[Step]


EXPLICIT, IMPLICIT, SLIDING = 0, 1, 2
EVERY_TURN = -1
"""Instead of the number of an `End`: stop at every extremum of w, and where w comes to `level`."""
_RETURN, _MINIMUM, _MAXIMUM, _LEVEL, _REST, _HORIZON, _STEPS, _OUTSIDE, _FAILED = (int(end) for end in End)

_LONGEST_STEP = 0.25  # explicit; at twice that what a step is off shows in thresholds
_SMALL = (
    0.01  # states below count as that large in an error: events are where w is 0, so it is less than their order
)
_SAFETY, _LEAST, _MOST = 0.9, 0.2, 10.0  # of the factor from one step length to the next
_STIFF = 10.0  # a decay of w, per unit of time, below which explicit steps are cheap enough
_SOFT = _STIFF / 3  # below which they are taken again; less, so that the method does not change to and fro
_STABLE = 2.5  # decay times a step, from which stability holds it short: the explicit method bears about 6
_PATIENCE = 15  # steps held short by stability before the method changes
_ROWS = 8  # of the extrapolation
_NOISE = 1e-13  # of the terms of w', below which it may be nothing but rounding
_OFF = 1e-9  # of tau, over which a straight line is off by less than rounding
_SHORTEST = 1e-14  # length of a step, over max(tau, 1), that is not made shorter
_ULP = 2.0**-52
_BEYOND = 4.0  # half-widths of an interval from its middle, up to which a polynomial is continued
_GUESSES = 4  # Newton steps on the cubic
_BISECTIONS = 100  # at most, for the root that ends a step
_REST_WITHIN = 10  # times the tolerance: nearer to rest the errors of steps do not let the mass come
_BESIDE = 1e-6  # of w = 1, over which the slope of mu at rest is taken
_CREEP = 2.0  # decay of w from which a deviation from rest has real exponents
_AMPLIFIED = 4e3  # rounding errors of the rows by the extrapolation, the sum of its weights

_A: list[list[float]] = DOP853.A.tolist()
_WEIGHTS: list[list[float]] = [row.tolist() for row in (DOP853.B, DOP853.E5, DOP853.E3)]
_A21 = _A[1][0]
_A31, _A32 = _A[2][:2]
_A41, _A43 = _A[3][0], _A[3][2]
_A51, _A53, _A54 = _A[4][0], *_A[4][2:4]
_A61, _A64, _A65 = _A[5][0], *_A[5][3:5]
_A71, _A74, _A75, _A76 = _A[6][0], *_A[6][3:6]
_A81, _A84, _A85, _A86, _A87 = _A[7][0], *_A[7][3:7]
_A91, _A94, _A95, _A96, _A97, _A98 = _A[8][0], *_A[8][3:8]
_A101, _A104, _A105, _A106, _A107, _A108, _A109 = _A[9][0], *_A[9][3:9]
_A111, _A114, _A115, _A116, _A117, _A118, _A119, _A1110 = _A[10][0], *_A[10][3:10]
_A121, _A124, _A125, _A126, _A127, _A128, _A129, _A1210, _A1211 = _A[11][0], *_A[11][3:11]
_B1, _B6, _B7, _B8, _B9, _B10, _B11, _B12 = (_WEIGHTS[0][i] for i in (0, *range(5, 12)))
_E1, _E6, _E7, _E8, _E9, _E10, _E11, _E12 = (_WEIGHTS[1][i] for i in (0, *range(5, 12)))
_F1, _F6, _F7, _F8, _F9, _F10, _F11, _F12 = (_WEIGHTS[2][i] for i in (0, *range(5, 12)))


@compilable
def _interval(low: Any, first: int, last: int, near: int, w: float) -> int:
    """Return the number of the interval of w among those from first to last, looked for from one that is near."""
    while near < last and w >= low[near + 1]:
        near += 1
    while near > first and w < low[near]:
        near -= 1
    return near


@compilable
def _rise(pieces: Any, first: int, last: int, near: int, w: float) -> float:
    """Return mu(V w) - mu(0+) on a segment; beyond its ends it goes on as a polynomial, and then as a constant."""
    low, origin, scale, rows = pieces
    i = _interval(low, first, last, near, w)
    t = (w - origin[i]) * scale[i]
    if t < -_BEYOND:
        t = -_BEYOND
    elif t > _BEYOND:
        t = _BEYOND
    c = rows[i]
    t2 = t * t
    t4 = t2 * t2
    # Estrin's scheme: its products do not wait for one another, as those of Horner's do.
    low_half = (c[0] + c[1] * t) + (c[2] + c[3] * t) * t2 + ((c[4] + c[5] * t) + (c[6] + c[7] * t) * t2) * t4
    high_half = (c[8] + c[9] * t) + (c[10] + c[11] * t) * t2 + ((c[12] + c[13] * t) + c[14] * t2) * t4
    value: float = low_half + high_half * (t4 * t4)
    return value


@compilable
def _slope(pieces: Any, first: int, last: int, near: int, w: float) -> float:
    """Return the derivative of the rise by w."""
    low, origin, scale, rows = pieces
    i = _interval(low, first, last, near, w)
    t = min(max((w - origin[i]) * scale[i], -_BEYOND), _BEYOND)
    c = rows[i]
    slope: float = 0.0
    for k in range(14, 0, -1):
        slope = slope * t + k * c[k]
    slope *= scale[i]
    return slope


@compilable
def _explicit(law: Any, system: Any, q: float, w: float, r1: float, h: float, rtol: float, wedge: Any) -> Any:
    """Take a step of DOP853, and return q, w, w' and the wedge at its end, and the error over the tolerance."""
    pieces, first, last, near = law
    eta, push, side, damping = system
    p1 = 1.0 - side * w
    q2, w2 = q + h * (_A21 * p1), w + h * (_A21 * r1)
    p2, r2 = 1.0 - side * w2, push - eta * _rise(pieces, first, last, near, w2) + side * q2 - damping * w2
    q3, w3 = q + h * (_A31 * p1 + _A32 * p2), w + h * (_A31 * r1 + _A32 * r2)
    p3, r3 = 1.0 - side * w3, push - eta * _rise(pieces, first, last, near, w3) + side * q3 - damping * w3
    q4, w4 = q + h * (_A41 * p1 + _A43 * p3), w + h * (_A41 * r1 + _A43 * r3)
    p4, r4 = 1.0 - side * w4, push - eta * _rise(pieces, first, last, near, w4) + side * q4 - damping * w4
    q5 = q + h * (_A51 * p1 + _A53 * p3 + _A54 * p4)
    w5 = w + h * (_A51 * r1 + _A53 * r3 + _A54 * r4)
    p5, r5 = 1.0 - side * w5, push - eta * _rise(pieces, first, last, near, w5) + side * q5 - damping * w5
    q6 = q + h * (_A61 * p1 + _A64 * p4 + _A65 * p5)
    w6 = w + h * (_A61 * r1 + _A64 * r4 + _A65 * r5)
    p6, r6 = 1.0 - side * w6, push - eta * _rise(pieces, first, last, near, w6) + side * q6 - damping * w6
    q7 = q + h * (_A71 * p1 + _A74 * p4 + _A75 * p5 + _A76 * p6)
    w7 = w + h * (_A71 * r1 + _A74 * r4 + _A75 * r5 + _A76 * r6)
    p7, r7 = 1.0 - side * w7, push - eta * _rise(pieces, first, last, near, w7) + side * q7 - damping * w7
    q8 = q + h * (_A81 * p1 + _A84 * p4 + _A85 * p5 + _A86 * p6 + _A87 * p7)
    w8 = w + h * (_A81 * r1 + _A84 * r4 + _A85 * r5 + _A86 * r6 + _A87 * r7)
    p8, r8 = 1.0 - side * w8, push - eta * _rise(pieces, first, last, near, w8) + side * q8 - damping * w8
    q9 = q + h * (_A91 * p1 + _A94 * p4 + _A95 * p5 + _A96 * p6 + _A97 * p7 + _A98 * p8)
    w9 = w + h * (_A91 * r1 + _A94 * r4 + _A95 * r5 + _A96 * r6 + _A97 * r7 + _A98 * r8)
    p9, r9 = 1.0 - side * w9, push - eta * _rise(pieces, first, last, near, w9) + side * q9 - damping * w9
    q10 = q + h * (_A101 * p1 + _A104 * p4 + _A105 * p5 + _A106 * p6 + _A107 * p7 + _A108 * p8 + _A109 * p9)
    w10 = w + h * (_A101 * r1 + _A104 * r4 + _A105 * r5 + _A106 * r6 + _A107 * r7 + _A108 * r8 + _A109 * r9)
    p10, r10 = 1.0 - side * w10, push - eta * _rise(pieces, first, last, near, w10) + side * q10 - damping * w10
    p = _A111 * p1 + _A114 * p4 + _A115 * p5 + _A116 * p6 + _A117 * p7 + _A118 * p8 + _A119 * p9 + _A1110 * p10
    r = _A111 * r1 + _A114 * r4 + _A115 * r5 + _A116 * r6 + _A117 * r7 + _A118 * r8 + _A119 * r9 + _A1110 * r10
    q11, w11 = q + h * p, w + h * r
    p11, r11 = 1.0 - side * w11, push - eta * _rise(pieces, first, last, near, w11) + side * q11 - damping * w11
    p = _A121 * p1 + _A124 * p4 + _A125 * p5 + _A126 * p6 + _A127 * p7 + _A128 * p8 + _A129 * p9
    r = _A121 * r1 + _A124 * r4 + _A125 * r5 + _A126 * r6 + _A127 * r7 + _A128 * r8 + _A129 * r9
    q12, w12 = q + h * (p + _A1210 * p10 + _A1211 * p11), w + h * (r + _A1210 * r10 + _A1211 * r11)
    p12, r12 = 1.0 - side * w12, push - eta * _rise(pieces, first, last, near, w12) + side * q12 - damping * w12
    p = _B1 * p1 + _B6 * p6 + _B7 * p7 + _B8 * p8 + _B9 * p9 + _B10 * p10 + _B11 * p11 + _B12 * p12
    r = _B1 * r1 + _B6 * r6 + _B7 * r7 + _B8 * r8 + _B9 * r9 + _B10 * r10 + _B11 * r11 + _B12 * r12
    q_end, w_end = q + h * p, w + h * r
    rate = push - eta * _rise(pieces, first, last, near, w_end) + side * q_end - damping * w_end

    scale_q, scale_w = rtol * (_SMALL + max(abs(q), abs(q_end))), rtol * (_SMALL + max(abs(w), abs(w_end)))
    p = _E1 * p1 + _E6 * p6 + _E7 * p7 + _E8 * p8 + _E9 * p9 + _E10 * p10 + _E11 * p11 + _E12 * p12
    r = _E1 * r1 + _E6 * r6 + _E7 * r7 + _E8 * r8 + _E9 * r9 + _E10 * r10 + _E11 * r11 + _E12 * r12
    fifth = (p / scale_q) * (p / scale_q) + (r / scale_w) * (r / scale_w)
    p = _F1 * p1 + _F6 * p6 + _F7 * p7 + _F8 * p8 + _F9 * p9 + _F10 * p10 + _F11 * p11 + _F12 * p12
    r = _F1 * r1 + _F6 * r6 + _F7 * r7 + _F8 * r8 + _F9 * r9 + _F10 * r10 + _F11 * r11 + _F12 * r12
    third = (p / scale_q) * (p / scale_q) + (r / scale_w) * (r / scale_w)
    both = fifth + 0.01 * third
    error = abs(h) * fifth / math.sqrt(2.0 * both) if both > 0.0 else both

    wanted, D, source = wedge
    if wanted:
        a1, b1 = _linear(law, system, source, w)
        k1 = a1 * D + b1
        a2, b2 = _linear(law, system, source, w2)
        k2 = a2 * (D + h * (_A21 * k1)) + b2
        a3, b3 = _linear(law, system, source, w3)
        k3 = a3 * (D + h * (_A31 * k1 + _A32 * k2)) + b3
        a4, b4 = _linear(law, system, source, w4)
        k4 = a4 * (D + h * (_A41 * k1 + _A43 * k3)) + b4
        a5, b5 = _linear(law, system, source, w5)
        k5 = a5 * (D + h * (_A51 * k1 + _A53 * k3 + _A54 * k4)) + b5
        a6, b6 = _linear(law, system, source, w6)
        k6 = a6 * (D + h * (_A61 * k1 + _A64 * k4 + _A65 * k5)) + b6
        a7, b7 = _linear(law, system, source, w7)
        k7 = a7 * (D + h * (_A71 * k1 + _A74 * k4 + _A75 * k5 + _A76 * k6)) + b7
        a8, b8 = _linear(law, system, source, w8)
        k8 = a8 * (D + h * (_A81 * k1 + _A84 * k4 + _A85 * k5 + _A86 * k6 + _A87 * k7)) + b8
        a9, b9 = _linear(law, system, source, w9)
        k9 = a9 * (D + h * (_A91 * k1 + _A94 * k4 + _A95 * k5 + _A96 * k6 + _A97 * k7 + _A98 * k8)) + b9
        a10, b10 = _linear(law, system, source, w10)
        k = _A101 * k1 + _A104 * k4 + _A105 * k5 + _A106 * k6 + _A107 * k7 + _A108 * k8 + _A109 * k9
        k10 = a10 * (D + h * k) + b10
        a11, b11 = _linear(law, system, source, w11)
        k = _A111 * k1 + _A114 * k4 + _A115 * k5 + _A116 * k6 + _A117 * k7 + _A118 * k8 + _A119 * k9
        k11 = a11 * (D + h * (k + _A1110 * k10)) + b11
        a12, b12 = _linear(law, system, source, w12)
        k = _A121 * k1 + _A124 * k4 + _A125 * k5 + _A126 * k6 + _A127 * k7 + _A128 * k8 + _A129 * k9
        k12 = a12 * (D + h * (k + _A1210 * k10 + _A1211 * k11)) + b12
        k = _B1 * k1 + _B6 * k6 + _B7 * k7 + _B8 * k8 + _B9 * k9 + _B10 * k10 + _B11 * k11 + _B12 * k12
        D = D + h * k
    return q_end, w_end, rate, D, error


@compilable
def _linear(law: Any, system: Any, source: Any, w: float) -> tuple[float, float]:
    """Return a and b of the wedge's equation D' = a D + b."""
    pieces, first, last, near = law
    eta, _, side, damping = system
    constant, linear, factor, own, _ = source
    push = constant + linear * w
    if factor != 0.0:
        # On this segment also where w is at its end, and another one begins.
        inside = max(w, pieces[0][first])
        if last + 1 < len(pieces[0]):
            inside = min(inside, pieces[0][last + 1] * (1.0 - _ULP))
        push += factor * _rise(own, 0, len(own[0]) - 1, 0, inside)
    return -eta * _slope(pieces, first, last, near, w) - damping, (1.0 - side * w) * push


@compilable
def _implicit(law: Any, system: Any, q: float, w: float, rate: float, h: float, rtol: float, wedge: Any) -> Any:
    """Take a step of the extrapolated linearly implicit Euler method, and return what `_explicit` does."""
    pieces, first, last, near = law
    eta, push, side, damping = system
    wanted, D, source = wedge
    decay = eta * _slope(pieces, first, last, near, w) + damping
    of_q, of_w, of_D = [0.0] * _ROWS, [0.0] * _ROWS, [0.0] * _ROWS
    error = 0.0
    # No step is more accurate than the rounding of w', which the decay divides and the extrapolation multiplies.
    rounding = _AMPLIFIED * _ULP
    least_q = rounding * abs(q)
    least_w = max(abs(push), abs(eta * _rise(pieces, first, last, near, w)))
    least_w = rounding * (max(least_w, max(abs(q), abs(damping * w))) / max(abs(decay), 1.0) + abs(w))
    for row in range(_ROWS):
        s = h / (row + 1)
        # (1 - s J) (dq, dw) = s (q', w') with J = ((0, -side), (side, -decay))
        determinant = 1.0 + s * decay + s * s
        x, y, z = q, w, D
        for _ in range(row + 1):
            dq = s * (1.0 - side * y)
            dw = s * (push - eta * _rise(pieces, first, last, near, y) + side * x - damping * y)
            x, y = (
                x + ((1.0 + s * decay) * dq - s * side * dw) / determinant,
                y + (dw + s * side * dq) / determinant,
            )
            if wanted:
                a, b = _linear(law, system, source, y)
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
    rate = push - eta * _rise(pieces, first, last, near, y) + side * x - damping * y
    return x, y, rate, z, error


@compilable
def _step(
    kind: int, law: Any, system: Any, q: float, w: float, r: float, h: float, rtol: float, wedge: Any
) -> Any:
    """Take a step of a kind."""
    if kind == EXPLICIT:
        return _explicit(law, system, q, w, r, h, rtol, wedge)
    return _implicit(law, system, q, w, r, h, rtol, wedge)


@compilable
def _located(
    kind: int, law: Any, system: Any, q: float, w: float, r: float, h: float, rtol: float, wedge: Any,
    w_h: float, r_h: float, turn: bool, level: float, sign: float,
) -> Any:  # fmt: skip
    """Return the length of the step that ends at an extremum of w, or at a level, and what the step returns.

    - `h`: of a step that ends beyond, with `w_h` and `r_h`.
    - `sign`: of w', or of w - level, before.
    """
    pieces, first, last, near = law
    eta, _, side, damping = system
    low, high = 0.0, h
    # The first guess is the root of the cubic through both ends.
    m, m_h = h * r, h * r_h
    third, second = 2.0 * (w - w_h) + m + m_h, 3.0 * (w_h - w) - 2.0 * m - m_h
    begin, end = (m, m_h) if turn else (w - level, w_h - level)
    part = begin / (begin - end) if begin * end < 0.0 else 0.5
    for _ in range(_GUESSES):
        value = w - level + part * (m + part * (second + part * third))
        change = m + part * (2.0 * second + 3.0 * part * third)
        if turn:
            value, change = change, 2.0 * second + 6.0 * part * third
        if change != 0.0:
            part = min(max(part - value / change, 0.001), 1.0)
    length = h * part
    q_now, w_now, r_now, D_now, error = q, w, r, 0.0, 0.0
    for _ in range(_BISECTIONS):
        q_now, w_now, r_now, D_now, error = _step(kind, law, system, q, w, r, length, rtol, wedge)
        value = r_now if turn else w_now - level
        if value * sign > 0.0:
            low = length
        else:
            high = length
        change = r_now
        if turn:
            change = side * (1.0 - side * w_now)
            change -= (eta * _slope(pieces, first, last, near, w_now) + damping) * r_now
        shift = -value / change if change != 0.0 else 0.0
        if abs(shift) <= _OFF and (value == 0.0 or change != 0.0):
            # What is left is a straight line, but for the extremum, at which w is stationary.
            rate = side * (1.0 - side * w_now) - (eta * _slope(pieces, first, last, near, w_now) + damping) * r_now
            q_now += shift * (1.0 - side * w_now)
            w_now += shift * (r_now + 0.5 * shift * rate)
            r_now += shift * rate
            length += shift
            break
        if abs(high - low) <= _OFF * _OFF * abs(h):
            break
        length = length + shift
        if not (min(low, high) < length < max(low, high)):
            length = 0.5 * (low + high)
    return length, q_now, w_now, r_now, D_now, error


@compilable
def follow(
    rise: Any, eta: float, zeta: float, push: float, side: float, q: float, w: float, horizon: float, rtol: float,
    direction: float, until: int, level: float, most: int, wedge: Any, recorded: bool,
) -> Any:  # fmt: skip
    """Follow a slip, and return its end, tau, q, w, w', the wedge, how many steps it took, and their list.

    - `push`: eta (side mu_static - mu(0+)).
    - `direction`: 1, or -1 backward in time; tau counts up in either.
    - `until`: the number of one more `End` at which it stops: a minimum, a maximum or, with `level`, a level of w;
      or `EVERY_TURN`.
    - `most`: how many steps it may take.
    - `wedge`: whether it is wanted, its value at the begin, and the fields of a `Wedge`.
    """
    pieces, levels, firsts, jumps, steepest = rise
    wanted, D, source = wedge
    damping = 2.0 * zeta
    system = (eta, push, side, damping)
    leveled = until in (_LEVEL, EVERY_TURN)
    steps = [(0.0, 0.0, 0.0, 0.0, 0.0, 0, 0)]
    steps.pop()
    segments = len(firsts) - 1
    tau, count, held, kind = 0.0, 0, 0, EXPLICIT
    farthest = levels[segments]
    if not (w <= farthest and abs(q) < math.inf):
        return _OUTSIDE, tau, q, w, 0.0, D, count, steps

    # Where two segments of the law meet at rest a motion may come to it in swings over both, where deviations
    # decay on the mean, or creep to it on one side, where that side has real exponents below 0.
    q_rest, faster, slower, close = math.nan, 0.0, 0.0, 0.0  # no rest; and the decay for w above 1, and below
    if side > 0.0 and farthest > 1.0 + _BESIDE:
        whole = firsts[segments] - 1
        lifted = eta * _rise(pieces, 0, whole, 0, 1.0)
        faster = (eta * _rise(pieces, 0, whole, 0, 1.0 + _BESIDE) - lifted) / _BESIDE + damping
        slower = (lifted - eta * _rise(pieces, 0, whole, 0, 1.0 - _BESIDE)) / _BESIDE + damping
        q_rest = damping - push + lifted
        fastest = max(abs(faster), abs(slower))
        noise = _ULP * max(max(abs(push), abs(lifted)), max(abs(q_rest), abs(damping)))
        if fastest > _STIFF:  # of implicit steps
            noise *= _AMPLIFIED / fastest
        close = _REST_WITHIN * (rtol + noise)

    segment = 0
    while segment + 1 < segments and w >= levels[segment + 1]:
        segment += 1
    first, last = firsts[segment], firsts[segment + 1] - 1
    near = _interval(pieces[0], first, last, (first + last) // 2, w)
    law = (pieces, first, last, near)
    lifted = eta * _rise(pieces, first, last, near, w)
    r = push - lifted + side * q - damping * w
    noise = _NOISE * max(max(abs(push), abs(lifted)), max(abs(q), abs(damping * w)))
    rising = w == 0.0 or direction * r > noise or (abs(r) <= noise and w < side)
    arrived = not rising and segment > 0 and w == levels[segment]  # at a kink, which it leaves downward
    length = min(rtol**0.125 / max(1.0, max(abs(1.0 - side * w), abs(r))), _LONGEST_STEP)

    while True:
        if arrived:
            arrived = False
            beyond = segment + 1 if rising else segment - 1
            upper = max(segment, beyond)
            start, stop = firsts[beyond], firsts[beyond + 1] - 1
            across = push - eta * _rise(pieces, start, stop, start if rising else stop, w) + side * q - damping * w
            onward = (direction * across >= 0.0) == rising
            if onward or jumps[upper] == 0.0:
                if wanted and jumps[upper] != 0.0 and r != 0.0:
                    shift = source[4][upper] * (1.0 - side * w)
                    D = shift + (D - shift) * across / r
                segment = beyond
            else:
                # Both rates lead to the jump: the mass slides, until the one on the side that it leaves to turns.
                if side * w == 1.0:
                    return _REST, tau, q, w, 0.0, D, count, steps
                upward = side * (1.0 - side * w) > 0.0
                fell = not rising
                segment, leaving = (upper, upper) if upward else (upper - 1, upper - 1)
                start, stop = firsts[leaving], firsts[leaving + 1] - 1
                lifted = eta * _rise(pieces, start, stop, start if upward else stop, w)
                turning = direction * (push - lifted + side * q - damping * w)
                duration = min(horizon - tau, max(0.0, -turning / (side * (1.0 - side * w))))
                if recorded:
                    steps.append((tau, q, w, 0.0, duration, upper, SLIDING))
                tau, q = tau + duration, q + direction * duration * (1.0 - side * w)
                count += 1
                D = source[4][upper] * (1.0 - side * w)
                rising = upward
                event = _MINIMUM if rising else _MAXIMUM
                if fell == rising and until in (event, EVERY_TURN):
                    return event, tau, q, w, 0.0, D, count, steps
            first, last = firsts[segment], firsts[segment + 1] - 1
            near = _interval(pieces[0], first, last, first if rising else last, w)
            law = (pieces, first, last, near)
            r = push - eta * _rise(pieces, first, last, near, w) + side * q - damping * w
            if kind == IMPLICIT and direction * (eta * _slope(pieces, first, last, near, w) + damping) <= _SOFT:
                kind, length = EXPLICIT, rtol**0.125 / max(1.0, abs(r))  # a long step would take growth for decay
        if tau >= horizon:
            return _HORIZON, tau, q, w, r, D, count, steps
        if count >= most:
            return _STEPS, tau, q, w, r, D, count, steps

        h = min(length, horizon - tau)
        if kind == EXPLICIT:
            h = min(h, _LONGEST_STEP)
        signed = direction * h
        wedge = (wanted, D, source)
        q_now, w_now, r_now, D_now, error = _step(kind, law, system, q, w, r, signed, rtol, wedge)
        shortest = _SHORTEST * max(tau, 1.0)
        if not error < 1.0:
            if h <= shortest:
                return _FAILED, tau, q, w, r, D, count, steps
            length = h * max(_LEAST, _SAFETY * error**-0.125 if error < math.inf else 0.0)
            continue
        growth = min(_MOST, _SAFETY * error**-0.125) if error > 0.0 else _MOST

        # Where w' changes its sign there is an extremum if w'' = side - w has the sign for it; else it is
        # rounding, or the error of an implicit step.
        event = _HORIZON
        slowest = rtol ** (2.0 / 3.0) * max(1.0, abs(r)) if kind == IMPLICIT else 0.0
        turned = direction * r_now < -slowest if rising else direction * r_now > slowest
        if turned and (w_now > side) == rising:
            sign = direction if rising else -direction
            h_turn, q_turn, w_turn, r_turn, D_turn, e_turn = _located(
                kind, law, system, q, w, r, signed, rtol, wedge, w_now, r_now, True, 0.0, sign
            )
            event = _MAXIMUM if rising else _MINIMUM
            signed, q_now, w_now, r_now, D_now, error = h_turn, q_turn, w_turn, r_turn, D_turn, e_turn
        border = levels[segment + 1] if rising else levels[segment]
        inner = leveled and ((w < level < border) if rising else (border < level < w))
        target = level if inner else border
        if (w_now >= target) if rising else (w_now <= target):
            sign = -1.0 if rising else 1.0
            if w_now != target:
                signed, q_now, w_now, r_now, D_now, error = _located(
                    kind, law, system, q, w, r, signed, rtol, wedge, w_now, r_now, False, target, sign
                )
            event, w_now = _LEVEL, target
        if event != _HORIZON and not error < 1.0 and abs(signed) > shortest:
            length = 0.5 * abs(signed)  # as where mu is singular at the level: its step is taken in shorter ones
            continue

        if recorded:
            steps.append((tau, q, w, r, abs(signed), segment, kind))
        if event == _HORIZON:
            tau = horizon if h == horizon - tau else tau + h
        else:
            tau += abs(signed)
        length = h * growth
        q, w, r, D = q_now, w_now, r_now, D_now
        count += 1
        near = _interval(pieces[0], first, last, near, w)
        law = (pieces, first, last, near)

        if (
            event in (_HORIZON, _LEVEL)
            and abs(w - 1.0) <= close
            and abs(q - q_rest) <= close * max(1.0, abs(q_rest))
        ):
            decay = slower if w < 1.0 or (w == 1.0 and rising) else faster
            if direction * (faster + slower) > 0.0 or direction * decay >= _CREEP:
                return _REST, tau, q, w, r, D, count, steps
        if event == _LEVEL:
            if target == 0.0:
                return _RETURN, tau, q, w, r, D, count, steps
            if target == farthest and not inner:
                return _OUTSIDE, tau, q, w, r, D, count, steps
            if inner or (leveled and level == target):
                return _LEVEL, tau, q, w, r, D, count, steps
            arrived = True
        elif event != _HORIZON:
            r = 0.0
            rising = not rising
            if until in (event, EVERY_TURN):
                return event, tau, q, w, r, D, count, steps

        # The kind of the next step: implicit where stability holds explicit ones short.
        if eta * steepest + abs(damping) > _STIFF:
            decay = direction * (eta * _slope(pieces, first, last, near, w) + damping)
            if kind == IMPLICIT:
                if decay <= _SOFT:
                    kind, held = EXPLICIT, 0
                    length = rtol**0.125 / max(1.0, abs(r))
            else:
                held = held + 1 if decay > _STIFF and decay * h > _STABLE else 0
                if held >= _PATIENCE:
                    kind = IMPLICIT


@compilable
def _states(
    rise: Any, eta: float, push: float, side: float, damping: float, rtol: float, source: Any,
    begin: Any, q: Any, w: Any, rate: Any, segment: Any, kind: Any, tau: Any, found: Any,
) -> None:  # fmt: skip
    """Write q and w at times within steps, an entry of each array for each, into the rows of `found`."""
    pieces, _, firsts, _, _ = rise
    system = (eta, push, side, damping)
    for i in range(len(tau)):
        h = tau[i] - begin[i]
        if kind[i] == SLIDING:
            found[0, i], found[1, i] = q[i] + h * (1.0 - side * w[i]), w[i]
            continue
        first, last = firsts[segment[i]], firsts[segment[i] + 1] - 1
        law = (pieces, first, last, _interval(pieces[0], first, last, first, w[i]))
        q_now, w_now, _, _, _ = _step(kind[i], law, system, q[i], w[i], rate[i], h, rtol, (False, 0.0, source))
        found[0, i], found[1, i] = q_now, w_now


@compilable
def _follow_all(
    rise: Any, eta: Any, zeta: Any, push: Any, side: Any, q: Any, w: Any, horizon: float, rtol: float,
    direction: float, until: int, level: float, most: int, wedge: Any, ends: Any, found: Any,
) -> None:  # fmt: skip
    """Follow many slips, an entry of each array for each, into `ends` and the columns tau, q, w, w' and D."""
    for i in range(len(q)):
        end, tau, q_end, w_end, rate, D, _, _ = follow(
            rise, eta[i], zeta[i], push[i], side[i], q[i], w[i], horizon, rtol,
            direction, until, level, most, wedge, False,
        )  # fmt: skip
        ends[i] = end
        found[i, 0], found[i, 1], found[i, 2], found[i, 3], found[i, 4] = tau, q_end, w_end, rate, D


class Slips(NamedTuple):
    """The ends of many slips, an array of each field of a `Slip` but its steps."""

    end: IntArray
    tau: FloatArray
    q: FloatArray
    w: FloatArray
    rate: FloatArray
    wedge: FloatArray


_PATIENT = 1e4  # decay times, after which a motion without a turn creeps to rest
_CHUNK = 1000  # steps, after which a slip looks at the time limit
_MOST_STEPS = 10_000  # of a slip without a given horizon; the longest that end take some hundred
_MORE_STEPS = 20  # for every unit of tau and segment of the law, on the way to a given horizon


@dataclass(frozen=True)
class Dimensionless:
    """An oscillator with its law, free of units: the equations of this module with their numbers.

    Attributes
    ----------
    eta : float
        N/(V sqrt(k m)).
    zeta : float
        c/(2 sqrt(k m)).
    table : FrictionTable
    V : float
        The belt's speed in m/s, the unit of w.

    Examples
    --------
    The slip from P, up to the belt's speed or the first minimum of the slip speed above:

    >>> from stickslip_sym import Oscillator, laws
    >>> osc = Oscillator(m=1.0, k=100.0, c=2.0, V=0.5, N=9.81)
    >>> slip = Dimensionless.of(laws.exponential.typical(), osc).slip(0.0, 0.0, until=End.MINIMUM)
    >>> slip.end.name, round(slip.tau, 6)
    ('RETURN', 5.677805)
    """

    eta: float
    zeta: float
    table: FrictionTable
    V: float

    @classmethod
    def of(cls, law: FrictionLaw, osc: Oscillator) -> "Dimensionless":
        """Make an oscillator with a bound law dimensionless.

        Raises
        ------
        InputError
            As for `FrictionTable.of`.
        """
        return cls(osc.eta, osc.zeta, FrictionTable.of(law), osc.V)

    @cached_property
    def rise(self) -> Rise:
        """The rise of mu as a function of w, for plain Python."""
        return self.table.at(self.V)

    @property
    def w_max(self) -> float:
        """The slip speed up to which the law is measured; infinite for a formula."""
        return self.table.reach / self.V

    def push(self, side: float) -> float:
        """Return eta (side mu_static - mu(0+))."""
        return self.eta * (side * self.table.static - self.table.onset)

    def lifted(self, w: float) -> float:
        """Return mu(V w) - mu(0+) for a slip speed within the table."""
        pieces = self.rise.pieces
        return _rise(pieces, 0, len(pieces.low) - 1, 0, w)

    def friction(self, w: float, side: int = 1) -> float:
        """Return what static and sliding friction together add to w', eta (side mu_static - mu(V w))."""
        return self.push(side) - self.eta * self.lifted(w)

    def acceleration(self, q: float, w: float, side: int = 1) -> float:
        """Return w', the rate at which the slip speed grows."""
        return self.friction(w, side) + side * q - 2 * self.zeta * w

    def decay(self, w: float) -> float:
        """Return -dw'/dw, the rate at which a deviation of the slip speed w >= 0 decays, between both sides."""
        half = _BESIDE * max(w, 1.0)
        low, high = max(w - half, 0.0), w + half
        return self.eta * (self.lifted(high) - self.lifted(low)) / (high - low) + 2 * self.zeta

    def turn(self, w: float) -> float:
        """Return the displacement q at which w' = 0 for a mass slower than the belt."""
        return 2 * self.zeta * w - self.friction(w)

    @property
    def rest(self) -> tuple[float, float]:
        """The equilibrium (q, w): the mass stands still, and the belt slips under it."""
        return self.turn(1.0), 1.0

    def sticks(self, q: float) -> bool:
        """Whether static friction holds the mass at displacement q: |c V + k x| <= mu_static N."""
        return -2 * self.eta * self.table.static <= q <= 0

    @property
    def horizon(self) -> float:
        """How long to wait for the end of a slip, in 1/omega."""
        return _PATIENT * max(1.0, 2 * abs(self.zeta))

    @property
    def no_wedge(self) -> Wedge:
        """The wedge of no quantity: its D is that of a difference of two initial conditions."""
        return Wedge(0.0, 0.0, 0.0, self.rise.pieces, [0.0] * len(self.rise.jumps))

    def slip(
        self,
        q: float,
        w: float,
        side: int = 1,
        *,
        until: int = End.RETURN,
        level: float = math.inf,
        horizon: float | None = None,
        rtol: float = 1e-12,
        backward: bool = False,
        wedge: Wedge | None = None,
        D: float = 0.0,
        most: int | None = None,
        recorded: bool = False,
    ) -> Slip:
        """Follow one slip from (q, w), in plain Python.

        - `side`: 1 where the mass is slower than the belt, -1 where it is faster.
        - `until`: one more end beside `RETURN`: `MINIMUM`, `MAXIMUM`, or `LEVEL`, where w comes to `level`; or
          `EVERY_TURN`.
        - `horizon`: tau at which to stop; if not given, when nothing but a creep to rest can be left.
        - `rtol`: relative tolerance of a step.
        - `backward`: in time.
        - `wedge`, `D`: the quantity of a wedge, and its value at the begin.
        - `most`: how many steps it may take; then, or when the time of a `time_limit` is up, it ends with `STEPS`.
          Without it that is an error, as is all that is no answer.
        - `recorded`: keep the steps.

        At w = 0 the slip is leaving, whatever rounding says of w'.

        Raises `InputError` if the motion comes beyond what was measured of the law.
        Raises `NotConverged` without `most`, where steps are too many, none is short enough, or mu has no value.
        Raises `OutOfTime` when the time of a `time_limit` is up.
        """
        end_tau = self.horizon if horizon is None else horizon
        limit = _MOST_STEPS if horizon is None else _MOST_STEPS + _MORE_STEPS * len(self.rise.jumps) * end_tau
        bound = limit if most is None else most
        chosen = self.no_wedge if wedge is None else wedge
        tau, count, steps = 0.0, 0, list[Step]()
        while True:
            if most is None:
                check_time()
            end, more, q, w, rate, D, taken, new = follow(
                self.rise, self.eta, self.zeta, self.push(side), float(side), float(q), float(w), end_tau - tau,
                rtol, -1.0 if backward else 1.0, int(until), level, min(_CHUNK, math.ceil(bound - count)),
                (wedge is not None, D, tuple(chosen)), recorded,
            )  # fmt: skip
            steps += [Step(tau + step[0], *step[1:]) for step in new]
            tau, count = tau + more, count + taken
            if end != End.STEPS or count >= bound or (most is not None and time_left() < 0):
                break
        found = Slip(End(end), tau, q, w, rate, D, count, steps)
        if most is None and (refusal := self.refusal(found, rtol)) is not None:
            raise refusal
        return found

    @staticmethod
    def slip_of(slips: Slips, number: int) -> Slip:
        """Return one of many slips."""
        end, tau, q, w, rate, wedge = (column[number].item() for column in slips)
        return Slip(End(end), tau, q, w, rate, wedge, 0, [])

    def unmeasured(self, w: float) -> InputError:
        """Return the refusal of a slip speed beyond the last measured one."""
        return InputError(
            f"the motion reaches a slip speed of {w:.6g} V, the law is measured up to {self.w_max:.6g} V; "
            "measure further, or hold the last coefficient: extrapolate=True"
        )

    def refusal(self, found: Slip, rtol: float) -> StickSlipError | None:
        """Return why a slip has no answer; None where it has one, or grows without bound."""
        if found.end is End.OUTSIDE and found.w >= self.w_max:
            return self.unmeasured(found.w)
        if found.end is End.STEPS:
            return NotConverged(
                f"one slip phase took over {found.taken} steps up to {found.tau:.3g}/omega: mu may be too rough; "
                "try a larger rtol"
            )
        if found.end is End.OUTSIDE and not found.taken and not self.unbounded(found):
            return InputError(f"mu cannot be computed at a slip speed of {found.w:g} V, where the motion begins")
        if found.end is End.FAILED or (found.end is End.OUTSIDE and not self.unbounded(found)):
            return NotConverged(
                f"the slip phase cannot be integrated at rtol = {rtol:g} beyond a slip speed of {found.w:.6g} V: "
                "mu may have no finite value there; try a larger rtol or another law"
            )
        return None

    def unbounded(self, found: Slip) -> bool:
        """Whether a slip that came out of the table grew beyond all bounds."""
        return found.end is End.OUTSIDE and found.w * self.V >= FARTHEST * (1 - _NOISE)

    def states(
        self, steps: Sequence[Step], which: IntArray, tau: FloatArray, side: int, rtol: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return q and w at times within recorded steps, each by one shorter step from the begin of its step.

        - `which`: the number of the step for each time.
        """
        fast = len(tau) >= (_SOME if compiled.cache_info().currsize else _MANY) and is_compiling()
        rise = self.table.at(self.V, arrays=fast)
        begins = [np.array(column, dtype=np.float64) for column in list(zip(*steps, strict=True))[:4]]
        columns = [column[which] for column in (*begins, *np.array([step[5:] for step in steps]).T)] + [tau]
        found = np.empty((2, len(tau)))
        run: Callable[..., None] = compiled(_states) if fast else _states
        source = (*self.no_wedge[:3], rise.pieces, np.zeros(len(rise.jumps)))
        arrays = columns if fast else [column.tolist() for column in columns]
        run(rise, self.eta, self.push(side), float(side), 2.0 * self.zeta, rtol, source, *arrays, found)
        return found[0], found[1]

    def slips(
        self,
        q: FloatArray,
        w: FloatArray,
        side: FloatArray,
        *,
        eta: FloatArray | None = None,
        zeta: FloatArray | None = None,
        until: End = End.RETURN,
        level: float = math.inf,
        horizon: float | None = None,
        rtol: float = 1e-12,
        backward: bool = False,
        wedge: Wedge | None = None,
        D: float = 0.0,
        most: int = _MOST_STEPS,
        workers: int = 1,
    ) -> Slips:
        """Follow many slips, compiled where numba is there and they are no few; as for `slip`, nothing is refused.

        - `q`, `w`, `side`: an entry for each slip.
        - `eta`, `zeta`: likewise, where they are not this system's.
        - `workers`: a number of threads, -1 for all processors.

        Raises `OutOfTime` when the time of a `time_limit` is up, which is looked at between batches.
        """
        size = len(q)
        eta = np.full(size, self.eta) if eta is None else eta
        zeta = np.full(size, self.zeta) if zeta is None else zeta
        push = eta * (side * self.table.static - self.table.onset)
        fast = (size > _FEW or compiled.cache_info().currsize > 0) and is_compiling()
        rise = self.table.at(self.V, arrays=fast)
        chosen = self.no_wedge if wedge is None else wedge
        source = (*chosen[:3], rise.pieces if wedge is None else chosen.pieces, np.asarray(chosen.shifts))
        ends, found = np.empty(size, dtype=np.int64), np.empty((size, 5))
        run: Callable[..., None] = compiled(_follow_all) if fast else _follow_all
        end_tau = self.horizon if horizon is None else horizon
        columns = [np.ascontiguousarray(column, dtype=np.float64) for column in (eta, zeta, push, side, q, w)]

        def batch(some: slice) -> None:
            check_time()
            arrays = [column[some] if fast else column[some].tolist() for column in columns]
            run(
                rise, *arrays, end_tau, rtol, -1.0 if backward else 1.0, int(until), level, most,
                (wedge is not None, D, source), ends[some], found[some],
            )  # fmt: skip

        spread(batch, size, _BATCH, workers)
        return Slips(ends, *found.T)


_MANY, _SOME = 3000, 100  # states, for which loading compiled code is no loss; and where there is some already
_FEW = 8  # slips, up to which plain Python is as fast as loading compiled code, where there is none already
_BATCH = 4000  # slips between two looks at the time limit, some hundredths of a second compiled

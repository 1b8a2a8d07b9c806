"""One step of a slip: explicit by DOP853, or implicit in a fast decay of w, with its error."""

import math

from scipy.integrate import DOP853

from stickslip_sym.core.numbers import DOUBLE_BITS, EPSILON, ROUNDING
from stickslip_sym.motion.compiled import compilable, inlined
from stickslip_sym.motion.kernel.forces import rate_at, rise_at, slope_at, wedge_terms
from stickslip_sym.motion.kernel.slip_data import ADDED, Branch, Field, SlipState, Trial, Wedge

_SMALL = 1 / ADDED  # states below count as that large in an error: what adds up is a tolerance of the belt's speed
SHORTEST = ROUNDING  # length of a step, over max(tau, 1), that is not made shorter
_EXTRAPOLATION_ROWS = 8  # of the extrapolation
AMPLIFIED = sum(
    row ** (_EXTRAPOLATION_ROWS - 1) / (math.factorial(row - 1) * math.factorial(_EXTRAPOLATION_ROWS - row))
    for row in range(1, _EXTRAPOLATION_ROWS + 1)
)
"""Their rounding errors by it: the sum of the sizes of its weights."""
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


@inlined
def stepped(
    implicit: bool, branch: Branch, field: Field, state: SlipState, h: float, rtol: float, wedge: Wedge
) -> Trial:
    """Try a step of length h."""
    if implicit:
        return _implicit(branch, field, state, h, rtol, wedge)
    return _explicit(branch, field, state, h, rtol, wedge)


@compilable
def _explicit(branch: Branch, field: Field, state: SlipState, h: float, rtol: float, wedge: Wedge) -> Trial:
    """Try a step of DOP853."""
    side = field.side
    q = state.q
    w = state.w
    r1 = state.rate
    p1 = 1.0 - side * w
    q2 = q + h * (_A21 * p1)
    w2 = w + h * (_A21 * r1)
    p2 = 1.0 - side * w2
    r2 = rate_at(branch, field, q2, w2)
    q3 = q + h * (_A31 * p1 + _A32 * p2)
    w3 = w + h * (_A31 * r1 + _A32 * r2)
    p3 = 1.0 - side * w3
    r3 = rate_at(branch, field, q3, w3)
    q4 = q + h * (_A41 * p1 + _A43 * p3)
    w4 = w + h * (_A41 * r1 + _A43 * r3)
    p4 = 1.0 - side * w4
    r4 = rate_at(branch, field, q4, w4)
    q5 = q + h * (_A51 * p1 + _A53 * p3 + _A54 * p4)
    w5 = w + h * (_A51 * r1 + _A53 * r3 + _A54 * r4)
    p5 = 1.0 - side * w5
    r5 = rate_at(branch, field, q5, w5)
    q6 = q + h * (_A61 * p1 + _A64 * p4 + _A65 * p5)
    w6 = w + h * (_A61 * r1 + _A64 * r4 + _A65 * r5)
    p6 = 1.0 - side * w6
    r6 = rate_at(branch, field, q6, w6)
    q7 = q + h * (_A71 * p1 + _A74 * p4 + _A75 * p5 + _A76 * p6)
    w7 = w + h * (_A71 * r1 + _A74 * r4 + _A75 * r5 + _A76 * r6)
    p7 = 1.0 - side * w7
    r7 = rate_at(branch, field, q7, w7)
    q8 = q + h * (_A81 * p1 + _A84 * p4 + _A85 * p5 + _A86 * p6 + _A87 * p7)
    w8 = w + h * (_A81 * r1 + _A84 * r4 + _A85 * r5 + _A86 * r6 + _A87 * r7)
    p8 = 1.0 - side * w8
    r8 = rate_at(branch, field, q8, w8)
    q9 = q + h * (_A91 * p1 + _A94 * p4 + _A95 * p5 + _A96 * p6 + _A97 * p7 + _A98 * p8)
    w9 = w + h * (_A91 * r1 + _A94 * r4 + _A95 * r5 + _A96 * r6 + _A97 * r7 + _A98 * r8)
    p9 = 1.0 - side * w9
    r9 = rate_at(branch, field, q9, w9)
    q10 = q + h * (_A101 * p1 + _A104 * p4 + _A105 * p5 + _A106 * p6 + _A107 * p7 + _A108 * p8 + _A109 * p9)
    w10 = w + h * (_A101 * r1 + _A104 * r4 + _A105 * r5 + _A106 * r6 + _A107 * r7 + _A108 * r8 + _A109 * r9)
    p10 = 1.0 - side * w10
    r10 = rate_at(branch, field, q10, w10)
    p = _A111 * p1 + _A114 * p4 + _A115 * p5 + _A116 * p6 + _A117 * p7 + _A118 * p8 + _A119 * p9 + _A1110 * p10
    r = _A111 * r1 + _A114 * r4 + _A115 * r5 + _A116 * r6 + _A117 * r7 + _A118 * r8 + _A119 * r9 + _A1110 * r10
    q11 = q + h * p
    w11 = w + h * r
    p11 = 1.0 - side * w11
    r11 = rate_at(branch, field, q11, w11)
    p = _A121 * p1 + _A124 * p4 + _A125 * p5 + _A126 * p6 + _A127 * p7 + _A128 * p8 + _A129 * p9
    r = _A121 * r1 + _A124 * r4 + _A125 * r5 + _A126 * r6 + _A127 * r7 + _A128 * r8 + _A129 * r9
    q12 = q + h * (p + _A1210 * p10 + _A1211 * p11)
    w12 = w + h * (r + _A1210 * r10 + _A1211 * r11)
    p12 = 1.0 - side * w12
    r12 = rate_at(branch, field, q12, w12)
    p = _B1 * p1 + _B6 * p6 + _B7 * p7 + _B8 * p8 + _B9 * p9 + _B10 * p10 + _B11 * p11 + _B12 * p12
    r = _B1 * r1 + _B6 * r6 + _B7 * r7 + _B8 * r8 + _B9 * r9 + _B10 * r10 + _B11 * r11 + _B12 * r12
    q_end = q + h * p
    w_end = w + h * r

    scale_q = rtol * (_SMALL + max(abs(q), abs(q_end)))
    scale_w = rtol * (_SMALL + max(abs(w), abs(w_end)))
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
            a, b = wedge_terms(branch, field, wedge, speeds[i])
            change = 0.0
            for j in range(i):
                change += _A[i][j] * rates[j]
            rates[i] = a * (D + h * change) + b
        for i in range(12):
            D += h * _B[i] * rates[i]
    return Trial(h, q_end, w_end, rate_at(branch, field, q_end, w_end), D, error)


@compilable
def _implicit(branch: Branch, field: Field, state: SlipState, h: float, rtol: float, wedge: Wedge) -> Trial:
    """Try a step of the extrapolated implicit Euler method, linearly implicit but where mu is all but vertical.

    There its slope says nothing of how friction changes over a step: linearised, it would hold w where it was.
    """
    eta, push, side, damping = field
    q = state.q
    w = state.w
    decay = eta * slope_at(branch, w) + damping
    is_vertical = decay * SHORTEST > 1.0
    of_q = [0.0] * _EXTRAPOLATION_ROWS
    of_w = [0.0] * _EXTRAPOLATION_ROWS
    of_D = [0.0] * _EXTRAPOLATION_ROWS
    error = 0.0
    # No step is more accurate than the rounding of w', which the decay divides and the extrapolation multiplies.
    rounding = AMPLIFIED * EPSILON
    terms = max(max(abs(push), abs(eta * rise_at(branch, w))), max(abs(q), abs(damping * w)))
    least_q = rounding * abs(q)
    least_w = rounding * (terms / max(abs(decay), 1.0) + abs(w))
    for row in range(_EXTRAPOLATION_ROWS):
        s = h / (row + 1)
        # (1 - s J) (dq, dw) = s (q', w') with J = ((0, -side), (side, -decay))
        determinant = 1.0 + s * decay + s * s
        x = q
        y = w
        z = state.wedge
        for _ in range(row + 1):
            dq = s * (1.0 - side * y)
            dw = s * rate_at(branch, field, x, y)
            if is_vertical:
                y = _euler(branch, field, x, y, s)
                x += s * (1.0 - side * y)
            else:
                x += ((1.0 + s * decay) * dq - s * side * dw) / determinant
                y += (dw + s * side * dq) / determinant
            if wedge.wanted:
                a, b = wedge_terms(branch, field, wedge, y)
                z = (z + s * b) / (1.0 - s * a)
        for k in range(row):
            # Neville's scheme, from the row before to this one; x, y and z hold the column that is known.
            ratio = (row + 1.0) / (row - k) - 1.0
            next_q = x + (x - of_q[k]) / ratio
            next_w = y + (y - of_w[k]) / ratio
            next_D = z + (z - of_D[k]) / ratio
            of_q[k], of_w[k], of_D[k] = x, y, z
            if k == row - 1:
                off_q = (next_q - x) / (least_q + rtol * (_SMALL + max(abs(q), abs(next_q))))
                off_w = (next_w - y) / (least_w + rtol * (_SMALL + max(abs(w), abs(next_w))))
                error = math.sqrt(0.5 * (off_q * off_q + off_w * off_w))
            x = next_q
            y = next_w
            z = next_D
        of_q[row], of_w[row], of_D[row] = x, y, z
    return Trial(h, x, y, rate_at(branch, field, x, y), z, error)


@compilable
def _euler(branch: Branch, field: Field, q: float, w: float, s: float) -> float:
    """Return w after a step of the implicit Euler method, by Newton's method in a bracket."""
    eta, _, side, damping = field
    low = w
    high = w + s * (rate_at(branch, field, q, w) + s * side * (1.0 - side * w))
    rises = high > w
    y = w
    for _ in range(2 * DOUBLE_BITS):
        off = w + s * rate_at(branch, field, q + s * (1.0 - side * y), y) - y
        if (off > 0.0) == rises:
            low = y
        else:
            high = y
        before = y
        y += off / (1.0 + s * (eta * slope_at(branch, y) + damping) + s * s)
        if not min(low, high) <= y <= max(low, high):
            y = 0.5 * (low + high)
        if abs(y - before) <= EPSILON * abs(y):
            break
    return y

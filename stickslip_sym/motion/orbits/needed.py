"""The damping that a slip orbit needs: d(A), for every law.

With time in 1/omega and w = |x' - V|/V, an orbit in slip whose mass reaches A V at its fastest comes to
w = 1 - A, where w' = 0. Forward from there it goes over its highest slip speed down to w = 1, where the mass
stands still; backward it comes to w = 1 as well. The orbit is closed where both halves meet, with one rate r = w'.
Along an orbit's last stretch neighbouring motions part, by many powers of ten if friction is strong; backward they
close up. So both halves are steady where one way round is not.

Damping rotates the field of directions one way, so the gap log(r_f/r_b) falls with the damping ratio zeta, for
weak friction at the rate 2 pi, and has one root, found by Newton's method in a bracket. Its derivatives by zeta,
by A and by every quantity follow from the wedge D of `slip`. At w = 1 - A there is D = 0, but for A itself, where
it is -A; at w = 1

    dr/dp = dw'/dp - D/r,    dgap/dp = (dr_f/dp)/r_f - (dr_b/dp)/r_b.

For A = 1 the orbit grazes the belt's speed, and d is the pure-slip threshold. The half forward is then the slip
from P, q = w = 0, and the half backward comes from the graze, q = -push with push = eta (mu_static - mu(0+)):
without a static excess they begin at one point, and the orbit is closed. For A to 0 it is the Hopf point.
"""

import math
from enum import IntEnum
from typing import Any

import numpy as np

from stickslip_sym.core.deadline import check_time, is_late
from stickslip_sym.core.errors import NotConverged, NoThreshold, OutOfTime
from stickslip_sym.motion.compiled import compilable
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import MOST_STEPS, PRECISE, TIGHT, End, follow, interval, rise_at

SIGNS = 1e-11
"""The relative tolerance of the steps along which the sign of a gap is decided."""
PARTED = 1e-7
"""The gap of an orbit beside which d jumps; where d is continuous it is that of rounding."""
ROUNDING = 1e-14
"""Relative, of a gap, a damping and an amplitude; of the terms of w' over their sum."""
_COARSE = 1e-5  # tolerance of the first steps
_SHARE = 0.03  # of the error of the damping ratio that is wanted, a tolerance
_STRONG, _STIFF = 30.0, 1e-9  # eta from which halves are stiff, and the tolerance there, unless digits are wanted
_LOOSER = 10.0  # of the tolerance, for the estimate of what the integration is off
_NEAR = 1e-2  # gap at which the tight tolerance is taken
_ROUGH = 1e-4  # gap above which coarse steps show its sign, and relative error of the slope by them
_SLOW = 0.5  # of the gap before, above which the tight steps are as good as they get
_UNSURE = 10.0  # times what the steps are off, above which a gap is none of theirs
_DONE = 1e-10  # gap after which the next secant is the last one
_MOST_GAPS = 100  # dampings that are tried
_PHASES = 64  # for the first guess
_FALL = -2 * math.pi  # of the gap with zeta, where friction is weak
_WILD = 1e12  # change of friction along an orbit, over its own forces, that is no use to follow
_FARTHEST = 1e6  # damping ratio over 1 + |eta|, and over the largest rise of friction, beyond which there is none
_PATIENT = 100.0  # times as long as the displacement takes at the belt's speed, after which a half creeps to rest


class Found(IntEnum):
    """How a search ends."""

    ROOT = 0
    NONE = 1  # there is none
    BEYOND = 2  # what was measured of the law
    LOST = 3  # without an answer
    LATE = 4


@compilable
def _standing(pieces: Any, above: bool) -> float:
    """Return a rise where the mass stands still, w = 1: its limit from slip speeds above, or from below."""
    at = interval(pieces, 0, len(pieces) - 1, 0, 1.0)
    if not above and at > 0 and pieces[at][0] == 1.0:
        at -= 1
    return rise_at((pieces, at, at, at), 1.0)


@compilable
def halves(
    rise: Any, eta: float, zeta: float, push: float, A: float, rtol: float, wanted: bool, D: float, source: Any
) -> Any:
    """Follow both halves from w = 1 - A to w = 1.

    - `push`: eta (mu_static - mu(0+)).
    - `wanted`, `D`, `source`: whether a wedge is, its value at w = 1 - A, and the fields of a `Wedge`.

    Returns for either half, the forward one first, whether it came to w = 1 (1), crept to rest (0), left the
      table of the law (-1) or took too many steps (-2), w' and D there, and how long it took; and the highest
      slip speed. Where mu jumps at w = 1 they are those on the side where w' is lower.
    """
    pieces = rise[0]
    whole = len(pieces) - 1
    w = 1.0 - A
    graze = 2.0 * zeta * w - push + eta * rise_at((pieces, 0, whole, 0), w)
    q = 0.0 if w == 0.0 else graze
    at_rest = eta * rise_at((pieces, 0, whole, 0), 1.0) if rise[1][len(rise[1]) - 1] > 1.0 else 0.0
    horizon = _PATIENT * (1.0 + 2.0 * abs(zeta) + abs(push) + abs(at_rest))
    # From here on q is the displacement from rest: near w = 1 its errors are to be small beside that.
    rest = 2.0 * zeta - push + at_rest
    push, q, graze = push + rest, q - rest, graze - rest
    end, (tau, q_f, highest, _, r_f, D_f), _, _ = follow(
        rise, eta, zeta, push, 0.0, 1.0, q, w, horizon, MOST_STEPS, 0, rtol, End.MAXIMUM.value, math.inf,
        (wanted, D, source), False,
    )  # fmt: skip
    if end == End.MAXIMUM:
        end, (more, _, _, _, r_f, D_f), _, _ = follow(
            rise, eta, zeta, push, 0.0, 1.0, q_f, highest, horizon, MOST_STEPS, 0, rtol, End.LEVEL.value, 1.0,
            (wanted, D_f, source), False,
        )  # fmt: skip
        tau += more
    stopped = (End.STEPS, End.FAILED, End.LATE)
    way = 1 if end == End.LEVEL else -1 if end == End.OUTSIDE else -2 if end in stopped else 0
    # Backward in time the equations are the same, with q and all of their factors negated.
    constant, linear, factor, own, shifts = source
    end, (tau_b, _, _, _, r_b, D_b), _, _ = follow(
        rise, -eta, -zeta, -push, 0.0, 1.0, -graze, w, horizon, MOST_STEPS, 0, rtol, End.LEVEL.value, 1.0,
        (wanted, D, (-constant, -linear, -factor, own, shifts)), False,
    )  # fmt: skip
    back = 1 if end == End.LEVEL else -2 if end in stopped else 0
    r_b = -r_b
    jump = eta * (_standing(pieces, True) - _standing(pieces, False)) if way == 1 and back == 1 else 0.0
    if jump < 0.0 and r_f < 0.0:
        r_f, D_f = r_f + jump, D_f * (1.0 + jump / r_f)
    elif jump > 0.0 and r_b < 0.0:
        r_b, D_b = r_b - jump, D_b * (1.0 - jump / r_b)
    return (way, r_f, D_f, tau), (back, r_b, D_b, tau_b), highest


@compilable
def gap(
    rise: Any, eta: float, zeta: float, push: float, A: float, rtol: float, wanted: bool, D: float, source: Any
) -> Any:
    """Return the gap, its derivative, whether the forward half left the table of the law, and the gap's rounding.

    Arguments as for `halves`; the derivative is that by the quantity of the wedge. The gap is infinite where a
    half creeps to rest, or the forward one leaves the table.
    """
    (way, r_f, D_f, _), (back, r_b, D_b, _), _ = halves(rise, eta, zeta, push, A, rtol, wanted, D, source)
    if way == 1 and back == 1 and r_f < 0.0 and r_b < 0.0:
        constant, linear, factor, pieces, _ = source
        b = constant + linear
        if factor != 0.0:
            b += factor * _standing(pieces, _standing(rise[0], True) >= _standing(rise[0], False))
        lifted = eta * _standing(rise[0], True)
        rounding = ROUNDING * (1.0 + (abs(lifted) + abs(push) + abs(zeta)) / abs(r_f))
        return math.log(r_f / r_b), (b - D_f / r_f) / r_f - (b - D_b / r_b) / r_b, False, rounding
    if rtol < _COARSE and (way == -2 or back == -2):
        return math.nan, 0.0, False, math.inf
    driven = way == -1 or (way == 1 and r_f < 0.0)
    return math.inf if driven else -math.inf, 0.0, way == -1, math.inf


@compilable
def sure_gap(rise: Any, eta: float, zeta: float, push: float, A: float, rtol: float, source: Any) -> Any:
    """Return the gap, and whether the forward half left the table: by coarse steps where they show its sign."""
    coarse = _STIFF if abs(eta) > _STRONG else _COARSE
    value, _, outside, _ = gap(rise, eta, zeta, push, A, coarse, False, 0.0, source)
    if outside or not _ROUGH < abs(value) < math.inf:
        value, _, outside, _ = gap(rise, eta, zeta, push, A, rtol, False, 0.0, source)
    return value, outside


@compilable
def needed(rise: Any, eta: float, push: float, A: float, tight: float, by_zeta: Any) -> Any:
    """Search for the damping ratio that an orbit needs.

    - `tight`: tolerance of the last steps.
    - `by_zeta`: the fields of the wedge by zeta.

    Returns how that ended, the damping ratio, its error, and between which ratios it lies.
    """
    low, high, slope = -math.inf, math.inf, _FALL
    zeta, largest = _harmonic(rise, eta, A)
    reach = 0.1 * max(abs(zeta), largest + abs(push))
    if max(largest, abs(push)) == 0.0:
        return Found.ROOT, 0.0, 0.0, low, high
    if not largest < _WILD:
        return Found.LOST, zeta, math.inf, low, high
    rtol = _STIFF if abs(eta) > _STRONG else _COARSE
    before, gap_before, beyond = math.nan, math.nan, False
    for _ in range(_MOST_GAPS):
        coarse = rtol > tight
        value, by, outside, rounding = gap(rise, eta, zeta, push, A, rtol, coarse, 0.0, by_zeta)
        if is_late():
            return Found.LATE, zeta, math.inf, low, high
        beyond = beyond or outside
        if -math.inf < by < 0.0 and coarse:
            slope = by
        elif math.isfinite(gap_before) and math.isfinite(value) and (value - gap_before) * (zeta - before) < 0.0:
            slope = (value - gap_before) / (zeta - before)
        if value > 0.0:
            low = max(low, zeta)
        elif value <= 0.0:
            high = min(high, zeta)
        else:
            return Found.LOST, zeta, math.inf, low, high
        before, unchanged, gap_before = zeta, abs(value) > _SLOW * abs(gap_before), value
        if not coarse and (abs(value) <= _DONE or (unchanged and abs(value) <= _NEAR and not beyond)):
            loose, _, _, _ = gap(rise, eta, zeta, push, A, _LOOSER * tight, False, 0.0, by_zeta)
            off = abs(loose - value) + rounding + (_LOOSER * tight if tight > PRECISE else 0.0)
            if abs(value) <= _DONE:
                error, ends = (off + _ROUGH * abs(value)) / -slope, zeta - value / slope
            else:  # the gap is no more than what the steps are off, or it jumps beside its root
                error, ends = (off + abs(value)) / -max(slope, _FALL), zeta
            if abs(value) <= max(_DONE, _UNSURE * off) and error <= _ROUGH * (abs(zeta) + largest):
                return Found.ROOT, ends, error + PRECISE * largest, low, high
        if math.isfinite(high - low) and high - low <= ROUNDING * max(abs(low), abs(high)):
            # The gap jumps there, as where the halves pass a jump of mu on one side only, or part by all digits;
            # or the law ends there, and the forward half leaves its table for less damping.
            _, _, outside, _ = gap(rise, eta, low, push, A, rtol, False, 0.0, by_zeta)
            if outside:
                return Found.BEYOND, zeta, math.inf, low, high
            error = _spread(rise, eta, push, A, _LOOSER * tight, by_zeta, low, high)
            end = Found.ROOT if error < math.inf else Found.LOST
            return end, zeta, error + PRECISE * largest, low, high
        if coarse and abs(value) <= _NEAR:
            zeta, rtol, low, high, gap_before = zeta - value / slope, tight, -math.inf, math.inf, math.nan
            continue
        # Newton's method may not help, as where a half ends close to rest.
        zeta = zeta - value / slope if math.isfinite(value) and not unchanged else math.nan
        if not (low < zeta < high and abs(zeta - before) <= 4.0 * (reach + abs(before))):
            if low > -math.inf and high < math.inf:
                zeta = 0.5 * (low + high)
            else:
                zeta = before + reach if value > 0.0 else before - reach
                reach *= 3.0
        if abs(zeta) > _FARTHEST * (1.0 + abs(eta) + largest):
            # Coarse steps that fail are taken for a half that creeps to rest; tight ones say that they failed.
            sure, _, _, _ = gap(rise, eta, before, push, A, tight, False, 0.0, by_zeta)
            end = Found.BEYOND if beyond else Found.LOST if math.isnan(sure) else Found.NONE
            return end, zeta, math.inf, low, high
    return Found.LOST, zeta, math.inf, low, high


@compilable
def needed_all(rise: Any, eta: Any, push: Any, A: Any, tight: float, wedge: Any, found: Any) -> None:
    """Search for the damping ratios that many orbits need: a row of what `needed` returns for each."""
    source = wedge[2]
    by_zeta = (0.0, -2.0, 0.0, source[3], source[4])
    for i in range(len(A)):
        end, zeta, error, low, high = needed(rise, eta[i], push[i], A[i], tight, by_zeta)
        found[i, 0], found[i, 1], found[i, 2], found[i, 3], found[i, 4] = end.value, zeta, error, low, high


@compilable
def highest_all(rise: Any, eta: Any, zeta: Any, A: Any, rtol: float, wedge: Any, found: Any) -> None:
    """Find the highest slip speeds over V of many orbits: infinite where one leaves the table or is lost."""
    for i in range(len(A)):
        (way, _, _, _), _, highest = halves(rise, eta[i], zeta[i], 0.0, A[i], rtol, False, 0.0, wedge[2])
        found[i, 0] = highest if way >= 0 else math.inf


@compilable
def _harmonic(rise: Any, eta: float, A: float) -> tuple[float, float]:
    """Return the damping ratio by harmonic balance over slip speeds from 1 - A to 1 + A, and the largest rise.

    The ratio is a first guess, by a few phases. The rise is 0 only if it is at the middle of each piece too: the
    bump of a law that is flat elsewhere lies between phases.
    """
    pieces, end = rise[0], rise[1][len(rise[1]) - 1]
    zeta, largest = 0.0, 0.0
    for i in range(_PHASES):
        cosine = math.cos((i + 0.5) * math.pi / _PHASES)
        lifted = eta * rise_at((pieces, 0, len(pieces) - 1, 0), min(1.0 - A * cosine, end))
        zeta += lifted * cosine / (A * _PHASES)
        largest = max(largest, abs(lifted))
    for i in range(len(pieces)):
        if 1.0 - A < pieces[i][1] < 1.0 + A:
            largest = max(largest, abs(eta * pieces[i][3]))
    return zeta, largest


@compilable
def _spread(
    rise: Any, eta: float, push: float, A: float, rtol: float, by_zeta: Any, low: float, high: float
) -> float:
    """Return how far from a jump of the gap a looser tolerance sees its sign change."""
    step = high - low
    while step <= _ROUGH * max(abs(low), abs(high)):
        below, _, _, _ = gap(rise, eta, low - step, push, A, rtol, False, 0.0, by_zeta)
        above, _, _, _ = gap(rise, eta, high + step, push, A, rtol, False, 0.0, by_zeta)
        if below > 0.0 >= above:
            return high - low + step
        step *= 10.0
    return math.inf


def needed_ratio(
    system: Dimensionless, A: float = 1.0, *, rtol: float = TIGHT, fast: bool = False
) -> tuple[float, float]:
    """Return the damping ratio that an orbit needs, and its error.

    - `A`: highest velocity over the belt's; 1 for the slip from P, static excess included.
    - `rtol`: relative error that is wanted.
    - `fast`: compiled where numba is there; a time limit is then looked at once.

    Raises `InputError` if the orbit goes beyond what was measured of the law.
    Raises `NoThreshold` if no damping ratio closes the orbit.
    Raises `NotConverged` when the bound on the work is reached.
    Raises `OutOfTime` when the time of a `time_limit` is up; it says the best ratio, and between which ones the
      root lies.
    """
    check_time()
    eta, push = system.eta, system.push(1) if A == 1.0 else 0.0
    wanted = _SHARE * rtol * abs(_harmonic(system.rise, eta, A)[0])
    loosest = _STIFF if abs(eta) > _STRONG else TIGHT
    tight = next((steps for steps in (loosest, TIGHT) if steps <= wanted), PRECISE)
    orbit = tuple(np.array([value]) for value in (eta, push, A))
    found = np.empty((1, 5))
    system.spread(needed_all, orbit, (tight,), found, few=0 if fast else 1)
    how, zeta, error, low, high = found[0].tolist()
    if how == Found.LATE or is_late():  # then the last gap may be wrong
        raise OutOfTime(
            f"the time limit was reached; the best value so far is c = {2 * zeta:.6g} sqrt(k m), and c lies "
            f"between {2 * low:.6g} and {2 * high:.6g} times sqrt(k m)"
        )
    if how == Found.ROOT:
        return zeta, error
    if how == Found.BEYOND and math.isfinite(system.w_max):
        raise system.unmeasured(system.w_max)
    place = f"at eta = {eta:g} and V = {system.V:g} m/s"
    if how == Found.NONE:
        raise NoThreshold(f"the slip from P returns to the belt's speed for every damping, or for none, {place}")
    raise NotConverged(
        f"the slip from P cannot be integrated {place}: friction is too strong, or its law too steep, for the "
        f"bound on the work; the damping ratio lies between {low:.10g} and {high:.10g}"
    )

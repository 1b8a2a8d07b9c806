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
from typing import Any, NamedTuple

import numpy as np

from stickslip_sym.core.deadline import check_time, is_late
from stickslip_sym.core.errors import NotConverged, NoThreshold, OutOfTime
from stickslip_sym.model.table import Pieces, Rise
from stickslip_sym.motion.compiled import compilable, compiled, is_compiling, is_ready
from stickslip_sym.motion.kernel.data import (
    ADDED,
    MOST_STEPS,
    PRECISE,
    TIGHT,
    Branch,
    End,
    Field,
    State,
    Stop,
    Wedge,
    no_wedge,
)
from stickslip_sym.motion.kernel.follow import follow
from stickslip_sym.motion.kernel.forces import interval, rise_at
from stickslip_sym.motion.slip import Dimensionless

SIGNS = 1e-11
"""The relative tolerance of the steps along which the sign of a gap is decided."""
PARTED = 1e-7
"""The gap of an orbit beside which d jumps; where d is continuous it is that of rounding."""
ROUNDING = 1e-14
"""Relative, of a gap, a damping and an amplitude; of the terms of w' over their sum."""
STRONG = 30.0
"""Eta, from which halves are stiff."""
_COARSE = 1e-5  # tolerance of the first steps
_SHARE = 0.03  # of the error of the damping ratio that is wanted, a tolerance
_STIFF = 1e-9  # tolerance where friction is strong, unless digits are wanted
_SKETCH = 1e-6  # or unless coarse steps suffice; below `_COARSE`, so that steps that fail are no creeping half
_LOOSER = 10.0  # of the tolerance, for the estimate of what the integration is off
_NEAR = 1e-2  # gap at which the tight tolerance is taken
_ROUGH = 1e-4  # gap above which coarse steps show its sign, and relative error of the slope by them
_CURVED = 10.0  # times the square of a gap, that it bends by up to its root
_SLOW = 0.5  # of the gap before, above which the tight steps are as good as they get
_UNSURE = 10.0  # times what the steps are off, above which a gap is none of theirs
_DONE = 1e-10  # gap after which the next secant is the last one
_MOST_GAPS = 100  # dampings that are tried
_PHASES = 64  # for the first guess
_FALL = -2 * math.pi  # of the gap with zeta, where friction is weak
_WILD = 1e12  # change of friction along an orbit, over its own forces, that is no use to follow
_FARTHEST = 1e6  # damping ratio over 1 + |eta|, and over the largest rise of friction, beyond which there is none
_PATIENT = 100.0  # times as long as the displacement takes at the belt's speed, after which a half creeps to rest


class Half(NamedTuple):
    """Half an orbit: its end, `LEVEL` where it came to w = 1, w' and the wedge D there, and how long it took."""

    end: End
    rate: float
    wedge: float
    tau: float


class Halves(NamedTuple):
    """Both halves of an orbit, and its highest slip speed."""

    ahead: Half
    back: Half
    highest: float


class Gap(NamedTuple):
    """The gap of an orbit.

    - `value`: infinite where a half creeps to rest, or the forward one leaves the table of the law.
    - `slope`: its derivative by the quantity of the wedge.
    - `outside`: whether the forward half left the table.
    - `rounding`: how far the value may be off for rounding alone.
    """

    value: float
    slope: float
    outside: bool
    rounding: float


class Needed(NamedTuple):
    """The damping ratio that an orbit needs, as far as it was found.

    - `end`: how the search ended: `CLOSED`, `NEVER`, `OUTSIDE`, `FAILED`, or `LATE`.
    - `zeta`, `error`: the damping ratio, and its error.
    - `low`, `high`: ratios between which it lies.
    """

    end: End
    zeta: float
    error: float
    low: float
    high: float


@compilable
def _standing(pieces: Pieces, above: bool) -> float:
    """Return a rise where the mass stands still, w = 1: its limit from slip speeds above, or from below."""
    at = interval(pieces, 0, len(pieces) - 1, 0, 1.0)
    if not above and at > 0 and pieces[at][0] == 1.0:
        at -= 1
    return rise_at(Branch(pieces, at, at, at), 1.0)


@compilable
def _is_stopped(end: End) -> bool:
    """Whether the work on a slip was given up."""
    return end in (End.STEPS, End.FAILED, End.LATE)


@compilable
def halves(
    rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float, wedge: Wedge, D: float
) -> Halves:
    """Follow both halves from w = 1 - A to w = 1.

    - `push`: eta (mu_static - mu(0+)).
    - `D`: the value of the wedge at w = 1 - A.

    Where mu jumps at w = 1 rates and wedges are those on the side where w' is lower.
    """
    pieces = rise.pieces
    whole = Branch(pieces, 0, len(pieces) - 1, 0)
    w = 1.0 - A
    graze = 2.0 * zeta * w - push + eta * rise_at(whole, w)
    q = 0.0 if w == 0.0 else graze
    at_rest = eta * rise_at(whole, 1.0) if rise.levels[-1] > 1.0 else 0.0
    horizon = _PATIENT * (1.0 + 2.0 * abs(zeta) + abs(push) + abs(at_rest))
    # From here on q is the displacement from rest: near w = 1 its errors are to be small beside that.
    rest = 2.0 * zeta - push + at_rest
    push, q, graze = push + rest, q - rest, graze - rest
    forward, to_top = Field(eta, push, 1.0, 2.0 * zeta), Stop(End.MAXIMUM.value, math.inf, horizon, MOST_STEPS, 0)
    to_rest = Stop(End.LEVEL.value, 1.0, horizon, MOST_STEPS, 0)
    end, top, _, _ = follow(rise, forward, 0.0, State(0.0, q, w, 1.0, 0.0, D), to_top, wedge, rtol, False)
    last, tau = top, top.tau
    if end == End.MAXIMUM:
        begin = State(0.0, top.q, top.w, 1.0, 0.0, top.wedge)
        end, last, _, _ = follow(rise, forward, 0.0, begin, to_rest, wedge, rtol, False)
        tau += last.tau
    ahead = Half(end, last.rate, last.wedge, tau)
    # Backward in time the equations are the same, with q and all of their factors negated.
    constant, linear, factor, own, shifts, wanted = wedge
    negated = Wedge(-constant, -linear, -factor, own, shifts, wanted)
    backward, begin = Field(-eta, -push, 1.0, -2.0 * zeta), State(0.0, -graze, w, 1.0, 0.0, D)
    end, last, _, _ = follow(rise, backward, 0.0, begin, to_rest, negated, rtol, False)
    back = Half(end, -last.rate, last.wedge, last.tau)
    if ahead.end == End.LEVEL and back.end == End.LEVEL:
        jump = eta * (_standing(pieces, True) - _standing(pieces, False))
        if jump < 0.0 and ahead.rate < 0.0:
            ahead = _across(ahead, jump)
        elif jump > 0.0 and back.rate < 0.0:
            back = _across(back, -jump)
    return Halves(ahead, back, top.w)


@compilable
def _across(half: Half, jump: float) -> Half:
    """Return the end of a half beyond a jump of w', with which the wedge changes."""
    return Half(half.end, half.rate + jump, half.wedge * (1.0 + jump / half.rate), half.tau)


@compilable
def gap(rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float, wedge: Wedge) -> Gap:
    """Return the gap; arguments as for `halves`."""
    ahead, back, _ = halves(rise, eta, zeta, push, A, rtol, wedge, 0.0)
    meet = ahead.end == End.LEVEL and back.end == End.LEVEL
    if meet and ahead.rate < 0.0 and back.rate < 0.0:
        constant, linear, factor, pieces, _, _ = wedge
        b = constant + linear
        if factor != 0.0:
            b += factor * _standing(pieces, _standing(rise.pieces, True) >= _standing(rise.pieces, False))
        lifted = eta * _standing(rise.pieces, True)
        rounding = ROUNDING * (1.0 + (abs(lifted) + abs(push) + abs(zeta)) / abs(ahead.rate))
        slope = (b - ahead.wedge / ahead.rate) / ahead.rate - (b - back.wedge / back.rate) / back.rate
        return Gap(math.log(ahead.rate / back.rate), slope, False, rounding)
    if rtol < _COARSE and (_is_stopped(ahead.end) or _is_stopped(back.end)):
        return Gap(math.nan, 0.0, False, math.inf)
    outside = ahead.end == End.OUTSIDE
    driven = outside or (ahead.end == End.LEVEL and ahead.rate < 0.0)
    return Gap(math.inf if driven else -math.inf, 0.0, outside, math.inf)


@compilable
def sure_gap(rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float) -> Gap:
    """Return the gap by coarse steps where they show its sign, without its derivative."""
    unwanted = no_wedge(rise)
    coarse = gap(rise, eta, zeta, push, A, _STIFF if abs(eta) > STRONG else _COARSE, unwanted)
    if not coarse.outside and _ROUGH < abs(coarse.value) < math.inf:
        return coarse
    return gap(rise, eta, zeta, push, A, rtol, unwanted)


@compilable
def needed(rise: Rise, eta: float, push: float, A: float, tight: float, rough: float) -> Needed:
    """Search for the damping ratio that an orbit needs.

    - `tight`: tolerance of the last steps.
    - `rough`: relative error for which coarse steps suffice; 0 if they never do.
    """
    unwanted = no_wedge(rise)
    by_zeta = Wedge(0.0, -2.0, 0.0, rise.pieces, unwanted.shifts, True)
    low, high, slope = -math.inf, math.inf, _FALL
    zeta, largest = _harmonic(rise, eta, A)
    reach = 0.1 * max(abs(zeta), largest + abs(push))
    if max(largest, abs(push)) == 0.0:
        return Needed(End.CLOSED, 0.0, 0.0, low, high)
    if not largest < _WILD:
        return Needed(End.FAILED, zeta, math.inf, low, high)
    rtol = (_SKETCH if rough > 0.0 else _STIFF) if abs(eta) > STRONG else _COARSE
    before, gap_before, beyond = math.nan, math.nan, False
    for _ in range(_MOST_GAPS):
        coarse = rtol > tight
        value, by, outside, rounding = gap(rise, eta, zeta, push, A, rtol, by_zeta if coarse else unwanted)
        if is_late():
            return Needed(End.LATE, zeta, math.inf, low, high)
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
            return Needed(End.FAILED, zeta, math.inf, low, high)
        before, unchanged, gap_before = zeta, abs(value) > _SLOW * abs(gap_before), value
        if not coarse and (abs(value) <= _DONE or (unchanged and abs(value) <= _NEAR and not beyond)):
            loose = gap(rise, eta, zeta, push, A, _LOOSER * tight, unwanted).value
            off = abs(loose - value) + rounding + (_LOOSER * tight if tight > PRECISE else 0.0)
            if abs(value) <= _DONE:
                error, ends = (off + _ROUGH * abs(value)) / -slope, zeta - value / slope
            else:  # the gap is no more than what the steps are off, or it jumps beside its root
                error, ends = (off + abs(value)) / -max(slope, _FALL), zeta
            if abs(value) <= max(_DONE, _UNSURE * off) and error <= _ROUGH * (abs(zeta) + largest):
                return Needed(End.CLOSED, ends, error + PRECISE * largest, low, high)
        if math.isfinite(high - low) and high - low <= ROUNDING * max(abs(low), abs(high)):
            # The gap jumps there, as where the halves pass a jump of mu on one side only, or part by all digits;
            # or the law ends there, and the forward half leaves its table for less damping.
            if gap(rise, eta, low, push, A, rtol, unwanted).outside:
                return Needed(End.OUTSIDE, zeta, math.inf, low, high)
            error = _spread(rise, eta, push, A, _LOOSER * tight, low, high)
            end = End.CLOSED if error < math.inf else End.FAILED
            return Needed(end, zeta, error + PRECISE * largest, low, high)
        if coarse and rough > 0.0 and not beyond:
            if abs(value) <= _NEAR and slope == by:
                off = ADDED * rtol + _CURVED * value * value
                if off / -slope > rough * abs(zeta):
                    closer = gap(rise, eta, zeta, push, A, _STIFF, unwanted).value
                    value, off = closer, abs(closer - value) + _CURVED * closer * closer + rounding + _DONE
                if off / -slope <= rough * max(abs(zeta), _ROUGH * largest):
                    error = off / -slope + PRECISE * largest
                    return Needed(End.CLOSED, zeta - value / slope, error, low, high)
                if abs(value) > _ROUGH:
                    zeta, gap_before = zeta - value / slope, math.nan
                    continue
            elif math.isfinite(high - low) and high - low <= rough * max(abs(low), abs(high)):
                return Needed(End.CLOSED, 0.5 * (low + high), high - low, low, high)
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
            sure = gap(rise, eta, before, push, A, tight, unwanted).value
            end = End.OUTSIDE if beyond else End.FAILED if math.isnan(sure) else End.NEVER
            return Needed(end, zeta, math.inf, low, high)
    return Needed(End.FAILED, zeta, math.inf, low, high)


@compilable
def needed_all(rise: Rise, columns: Any, tight: float, rows: Any) -> None:
    """Search for the damping ratios that many orbits need, from eta, push and A to rows as a `Needed` has them."""
    eta, push, A = columns
    for i in range(len(A)):
        need = needed(rise, eta[i], push[i], A[i], tight, 0.0)
        rows[i, 0] = need.end.value
        rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4] = need.zeta, need.error, need.low, need.high


@compilable
def rough_all(rise: Rise, columns: Any, rough: float, rows: Any) -> None:
    """Search by coarse steps where they suffice, from eta and push to the end, the damping ratio and its error."""
    eta, push = columns
    for i in range(len(eta)):
        need = needed(rise, eta[i], push[i], 1.0, TIGHT, rough)
        rows[i, 0], rows[i, 1], rows[i, 2] = need.end.value, need.zeta, need.error


@compilable
def _slope_all(rise: Rise, columns: Any, rtol: float, wedge: Wedge, rows: Any) -> None:
    """Find how gaps of slips from P change with the quantity of a wedge, from eta, zeta and push."""
    eta, zeta, push = columns
    for i in range(len(eta)):
        rows[i, 0] = gap(rise, eta[i], zeta[i], push[i], 1.0, rtol, wedge).slope


@compilable
def highest_all(rise: Rise, columns: Any, rtol: float, rows: Any) -> None:
    """Find the highest slip speeds over V of many orbits, from eta, zeta and A.

    They are infinite where one leaves the table or is lost.
    """
    eta, zeta, A = columns
    for i in range(len(A)):
        orbit = halves(rise, eta[i], zeta[i], 0.0, A[i], rtol, no_wedge(rise), 0.0)
        lost = orbit.ahead.end == End.OUTSIDE or _is_stopped(orbit.ahead.end)
        rows[i, 0] = math.inf if lost else orbit.highest


@compilable
def _harmonic(rise: Rise, eta: float, A: float) -> tuple[float, float]:
    """Return the damping ratio by harmonic balance over slip speeds from 1 - A to 1 + A, and the largest rise.

    The ratio is a first guess, by a few phases. The rise is 0 only if it is at the middle of each piece too: the
    bump of a law that is flat elsewhere lies between phases.
    """
    pieces, end = rise.pieces, rise.levels[-1]
    whole = Branch(pieces, 0, len(pieces) - 1, 0)
    zeta, largest = 0.0, 0.0
    for i in range(_PHASES):
        cosine = math.cos((i + 0.5) * math.pi / _PHASES)
        lifted = eta * rise_at(whole, min(1.0 - A * cosine, end))
        zeta += lifted * cosine / (A * _PHASES)
        largest = max(largest, abs(lifted))
    for i in range(len(pieces)):
        if 1.0 - A < pieces[i][1] < 1.0 + A:
            largest = max(largest, abs(eta * pieces[i][3]))
    return zeta, largest


@compilable
def _first_guess(rise: Rise, eta: float, A: float) -> float:
    """Return the first guess alone; machine code that other machine code calls has no entry from Python."""
    return _harmonic(rise, eta, A)[0]


@compilable
def _spread(rise: Rise, eta: float, push: float, A: float, rtol: float, low: float, high: float) -> float:
    """Return how far from a jump of the gap a looser tolerance sees its sign change."""
    step = high - low
    while step <= _ROUGH * max(abs(low), abs(high)):
        below = gap(rise, eta, low - step, push, A, rtol, no_wedge(rise)).value
        above = gap(rise, eta, high + step, push, A, rtol, no_wedge(rise)).value
        if below > 0.0 >= above:
            return high - low + step
        step *= 10.0
    return math.inf


def rough_ratio(system: Dimensionless, rtol: float, *, fast: bool = False) -> tuple[float, float]:
    """Return the damping ratio at which the slip from P grazes w = 1, by coarse steps if they do, and its error.

    - `fast`: compiled where numba is there, and its loading is no loss.

    Both are NaN where there is none; raises `OutOfTime` when the time of a `time_limit` is up.
    """
    orbit, rows = [np.array([value]) for value in (system.eta, system.push(1))], np.empty((1, 3))
    system.spread(rough_all, orbit, (rtol,), rows, few=0 if fast or is_ready(rough_all) else 1)
    check_time()
    end, zeta, error = rows[0].tolist()
    return (zeta, error) if end == End.CLOSED else (math.nan, math.nan)


def gap_slope(system: Dimensionless, zeta: float, wedge: Wedge) -> float:
    """Return how the gap of the slip from P changes with the quantity of a wedge, at a damping ratio."""
    slip, rows = [np.array([value]) for value in (system.eta, zeta, system.push(1))], np.empty((1, 1))
    fast = is_ready(needed_all) or is_ready(rough_all)
    if fast:
        wedge = wedge._replace(pieces=np.array(wedge.pieces), shifts=np.array(wedge.shifts))
    system.spread(_slope_all, slip, (TIGHT, wedge), rows, few=0 if fast else 1)
    check_time()
    return float(rows[0, 0])


def needed_ratio(
    system: Dimensionless, A: float = 1.0, *, rtol: float = TIGHT, fast: bool = False
) -> tuple[float, float]:
    """Return the damping ratio that an orbit needs, and its error.

    - `A`: highest velocity over the belt's; 1 for the slip from P, static excess included.
    - `rtol`: relative error that is wanted.
    - `fast`: compiled where numba is there, and its loading is no loss; a time limit is then looked at once.

    Raises `InputError` if the orbit goes beyond what was measured of the law.
    Raises `NoThreshold` if no damping ratio closes the orbit.
    Raises `NotConverged` when the bound on the work is reached.
    Raises `OutOfTime` when the time of a `time_limit` is up; it says the best ratio, and between which ones the
      root lies.
    """
    check_time()
    eta, push = system.eta, system.push(1) if A == 1.0 else 0.0
    fast = (fast and is_compiling()) or is_ready(needed_all)
    first = compiled(_first_guess) if fast else _first_guess  # in plain Python it takes longer than the search
    wanted = _SHARE * rtol * abs(first(system.table.at(system.V, arrays=fast), eta, A))
    loosest = _STIFF if abs(eta) > STRONG else TIGHT
    tight = next((steps for steps in (loosest, TIGHT) if steps <= wanted), PRECISE)
    orbit, rows = [np.array([value]) for value in (eta, push, A)], np.empty((1, 5))
    system.spread(needed_all, orbit, (tight,), rows, few=0 if fast else 1)
    end, zeta, error, low, high = rows[0].tolist()
    if end == End.LATE or is_late():  # then the last gap may be wrong
        raise OutOfTime(
            f"the time limit was reached; the best value so far is c = {2 * zeta:.6g} sqrt(k m), and c lies "
            f"between {2 * low:.6g} and {2 * high:.6g} times sqrt(k m)"
        )
    if end == End.CLOSED:
        return zeta, error
    if end == End.OUTSIDE and math.isfinite(system.w_max):
        raise system.unmeasured(system.w_max)
    place = f"at eta = {eta:g} and V = {system.V:g} m/s"
    if end == End.NEVER:
        raise NoThreshold(f"the slip from P returns to the belt's speed for every damping, or for none, {place}")
    raise NotConverged(
        f"the slip from P cannot be integrated {place}: friction is too strong, or its law too steep, for the "
        f"bound on the work; the damping ratio lies between {low:.10g} and {high:.10g}"
    )

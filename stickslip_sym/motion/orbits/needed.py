"""The damping that a slip orbit needs: d(A), for every law, by secants in a bracket of signs that are known.

With time in 1/omega and w = |x' - V|/V, an orbit in slip whose mass reaches A V at its fastest comes to
w = 1 - A, where w' = 0. Forward from there it goes over its highest slip speed down to w = 1, where the mass
stands still; backward it comes to w = 1 as well. The orbit is closed where both halves meet, with one rate r = w'.
Along an orbit's last stretch neighbouring motions part, by many powers of ten if friction is strong; backward they
close up. So both halves are steady where one way round is not.

Damping rotates the field of directions one way, so the gap log(r_f/r_b) falls with the damping ratio zeta, for
weak friction at the rate 2 pi, and has one root. A half may also creep to rest, or leave the table of the law:

    ahead     back      gap
    returns   returns   log(r_f/r_b)
    returns   creeps    infinite
    creeps    returns   -infinite
    leaves    any       infinite: the table of the law ends there
    else                not known: the search ends with the bracket that it has

Time is no bound of a half. With q the displacement from rest and x = w - 1 there is q' = -x: while |x| is not
small q is used up at that rate, and beside rest implicit steps grow with the slowness of the motion. So a half is
followed until it comes to w = 1, or within the tolerance of rest; that it took all its steps says nothing.

The derivatives of the gap by every quantity follow from the wedge D of `slip`. At w = 1 - A there is D = 0, but
for A itself, where it is -A; at w = 1

    dr/dp = dw'/dp - D/r,    dgap/dp = (dr_f/dp)/r_f - (dr_b/dp)/r_b.

For A = 1 the orbit grazes the belt's speed, and d is the pure-slip threshold. The half forward is then the slip
from P, q = w = 0, and the half backward comes from the graze, q = -push with push = eta (mu_static - mu(0+)):
without a static excess they begin at one point, and the orbit is closed. For A to 0 it is the Hopf point.
"""

import math
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.deadline import check_time, is_late
from stickslip_sym.core.errors import NotConverged, NoThreshold, OutOfTime
from stickslip_sym.model.table import Rise
from stickslip_sym.motion.compiled import compilable, is_compiling, is_ready
from stickslip_sym.motion.kernel.data import (
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
from stickslip_sym.motion.kernel.forces import rise_at, standing
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.numerics.known import Column, Unknown

SIGNS = 1e-11
"""The relative tolerance of the steps along which the sign of a gap is decided."""
PARTED = 1e-7
"""The gap of an orbit beside which d jumps; where d is continuous it is that of rounding."""
ROUNDING = 1e-14
"""Relative, of a gap, a damping and an amplitude; of the terms of w' over their sum."""
STRONG = 30.0
"""Eta, from which halves are stiff."""
_COARSE = 1e-5  # tolerance of steps that show the sign of a gap far from 0, the loosest
_STIFF = 1e-9  # the same where friction is strong
_ROUGH = 1e-4  # gap above which these steps show its sign
_LOOSEST = 1e-6  # tolerance of steps in a search
_FINER = 0.01  # times the tolerance, where it did not give the accuracy that is wanted
_SHARE = 0.03  # of the error of the damping ratio that is wanted, a tolerance; and of that, its relative error
_EVEN_SHARE = 1e-2  # of the relative error that is wanted, at most; all of it where friction is strong
_LOOSER = 10.0  # times the tolerance, for the estimate of what the integration is off
_CLOSE = 100.0  # times the tolerance of steps, a gap from which a secant leads to its root within their errors
_BENT = 0.01  # of a gap, that the last secant may be off
_SLOW = 0.5  # of the gap before, above which the secant does not help
_FALL = -2 * math.pi  # of the gap with zeta, where friction is weak
_MOST_GAPS = 200  # dampings that are tried
_PHASES = 64  # of an orbit, for the first guess
_WILD = 1e12  # change of friction along an orbit, over its own forces, that is no use to follow
_FARTHEST = 1e6  # damping ratio over 1 + |eta| and over the largest rise of friction, beyond which there is none
_UNSURE = 1e-4  # error of a damping ratio over the largest one at work, that is no value


class Outcome(IntEnum):
    """What becomes of a half."""

    RETURNS = 0  # it comes to w = 1
    CREEPS = 1  # it is shown to tend to rest, or comes so near that at w = 1 its rate is below all others
    LEAVES = 2  # it comes to where the table of the law ends
    UNKNOWN = 3  # it takes too many steps, or none is short enough


class Half(NamedTuple):
    """Half an orbit: its outcome, w' and the wedge D at w = 1, its highest w, and how long it took."""

    outcome: Outcome
    rate: float
    wedge: float
    highest: float
    tau: float


class Gap(NamedTuple):
    """The gap of an orbit.

    - `value`: NaN where its sign is not known; infinite where a half creeps to rest, or leaves the table.
    - `slope`: its derivative by the quantity of the wedge.
    - `leaves`: whether the forward half leaves the table of the law.
    - `rounding`: how far the value may be off for rounding alone.
    - `highest`: the highest slip speed over V; infinite where the forward half leaves the table, or is lost.
    """

    value: float
    slope: float
    leaves: bool
    rounding: float
    highest: float


class Needed(NamedTuple):
    """The damping ratio that an orbit needs, as far as it was found.

    - `end`: how the search ended: `CLOSED`, `NEVER`, `OUTSIDE`, `FAILED`, or `LATE`.
    - `zeta`, `error`: the damping ratio, and its error.
    - `low`, `high`: ratios between which it lies: the gap is above 0 at one, and not above 0 at the other.
    """

    end: End
    zeta: float
    error: float
    low: float
    high: float


@compilable
def _followed(
    rise: Rise, field: Field, begin: State, until: int, level: float, wedge: Wedge, rtol: float
) -> tuple[Outcome, State]:
    """Follow a slip to its maximum, or to a level, however long that takes."""
    stop = Stop(until, level, math.inf, MOST_STEPS, 0)
    end, state, _, _ = follow(rise, field, 0.0, begin, stop, wedge, rtol, False)
    outcome = Outcome.UNKNOWN
    if end == until:
        outcome = Outcome.RETURNS
    elif end == End.OUTSIDE:
        outcome = Outcome.LEAVES
    elif end == End.REST:
        outcome = Outcome.CREEPS
    return outcome, state


@compilable
def halves(
    rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float, wedge: Wedge, D: float
) -> tuple[Half, Half]:
    """Follow both halves from w = 1 - A to w = 1: ahead, and back.

    - `push`: eta (mu_static - mu(0+)).
    - `D`: the value of the wedge at w = 1 - A.

    Where mu jumps at w = 1 rates and wedges are those on the side where w' is lower.
    """
    pieces = rise.pieces
    w = 1.0 - A
    at_rest = 0.0
    if rise.levels[-1] > 1.0:
        at_rest = eta * standing(pieces, True)
    # q is the displacement from rest: near w = 1 its errors are to be small beside that.
    rest = 2.0 * zeta - push + at_rest
    graze = 2.0 * zeta * w - push + eta * rise_at(Branch(pieces, 0, len(pieces) - 1, 0), w) - rest
    q = graze
    if w == 0.0:
        q = -rest

    forward, begin = Field(eta, push + rest, 1.0, 2.0 * zeta), State(0.0, q, w, 1.0, 0.0, D)
    outcome, state = _followed(rise, forward, begin, End.MAXIMUM.value, math.inf, wedge, rtol)
    highest, tau = state.w, state.tau
    if outcome == Outcome.RETURNS:
        top = State(0.0, state.q, state.w, 1.0, 0.0, state.wedge)
        outcome, state = _followed(rise, forward, top, End.LEVEL.value, 1.0, wedge, rtol)
        tau += state.tau
    ahead = Half(outcome, state.rate, state.wedge, highest, tau)

    # Backward in time the equations are the same, with q and all of their factors negated.
    negated = Wedge(-wedge.constant, -wedge.linear, -wedge.factor, wedge.pieces, wedge.shifts, wedge.wanted)
    backward, begin = Field(-eta, -push - rest, 1.0, -2.0 * zeta), State(0.0, -graze, w, 1.0, 0.0, D)
    outcome, state = _followed(rise, backward, begin, End.LEVEL.value, 1.0, negated, rtol)
    back = Half(outcome, -state.rate, state.wedge, w, state.tau)

    if ahead.outcome == Outcome.RETURNS and back.outcome == Outcome.RETURNS:
        jump = eta * (standing(pieces, True) - standing(pieces, False))
        if jump < 0.0 and ahead.rate < 0.0:
            ahead = _across(ahead, jump)
        elif jump > 0.0 and back.rate < 0.0:
            back = _across(back, -jump)
    return ahead, back


@compilable
def _across(half: Half, jump: float) -> Half:
    """Return the end of a half beyond a jump of w', with which the wedge changes."""
    wedge = half.wedge * (1.0 + jump / half.rate)
    return Half(half.outcome, half.rate + jump, wedge, half.highest, half.tau)


@compilable
def gap(rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float, wedge: Wedge) -> Gap:
    """Return the gap; arguments as for `halves`."""
    ahead, back = halves(rise, eta, zeta, push, A, rtol, wedge, 0.0)
    r_f, r_b, highest = ahead.rate, back.rate, ahead.highest
    if ahead.outcome in (Outcome.LEAVES, Outcome.UNKNOWN):
        highest = math.inf
    if ahead.outcome == Outcome.LEAVES:
        return Gap(math.inf, 0.0, True, math.inf, highest)
    arrives, came = ahead.outcome == Outcome.RETURNS, back.outcome == Outcome.RETURNS
    if arrives and r_f < 0.0 and (back.outcome == Outcome.CREEPS or (came and r_b >= 0.0)):
        return Gap(math.inf, 0.0, False, math.inf, highest)
    if came and (ahead.outcome == Outcome.CREEPS or (arrives and r_f >= 0.0)):
        return Gap(-math.inf, 0.0, False, math.inf, highest)
    if not (arrives and came):
        return Gap(math.nan, 0.0, False, math.inf, highest)
    lifted = standing(rise.pieces, True)
    b = wedge.constant + wedge.linear
    if wedge.factor != 0.0:
        b += wedge.factor * standing(wedge.pieces, lifted >= standing(rise.pieces, False))
    slope = (b - ahead.wedge / r_f) / r_f - (b - back.wedge / r_b) / r_b
    rounding = ROUNDING * (1.0 + (abs(eta * lifted) + abs(push) + abs(zeta)) / abs(r_f))
    return Gap(math.log(r_f / r_b), slope, False, rounding, highest)


@compilable
def sure_gap(rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float) -> Gap:
    """Return the gap by coarse steps where they show its sign, without its derivative."""
    unwanted, coarse = no_wedge(rise), _COARSE
    if abs(eta) > STRONG:
        coarse = _STIFF
    glance = gap(rise, eta, zeta, push, A, coarse, unwanted)
    if not glance.leaves and _ROUGH < abs(glance.value) < math.inf:
        return glance
    return gap(rise, eta, zeta, push, A, rtol, unwanted)


@compilable
def _tolerance(eta: float, zeta: float, rtol: float) -> float:
    """Return the tolerance of steps for a relative error of a damping ratio of about that size."""
    most = _EVEN_SHARE
    if abs(eta) > STRONG:
        most = 1.0
    share = min(_SHARE * abs(zeta), most)
    return min(max(share * rtol, PRECISE), _LOOSEST)


@compilable
def needed(rise: Rise, eta: float, push: float, A: float, rtol: float) -> Needed:
    """Search for the damping ratio that an orbit needs, with a relative error that is wanted."""
    zeta, largest = _harmonic(rise, eta, A)
    if max(largest, abs(push)) == 0.0:
        return Needed(End.CLOSED, 0.0, 0.0, 0.0, 0.0)
    if not largest < _WILD:
        return Needed(End.FAILED, zeta, math.inf, -math.inf, math.inf)
    steps = _tolerance(eta, zeta, rtol)
    need = _searched(rise, eta, push, A, steps, zeta, largest)
    while need.end == End.CLOSED and need.error > rtol * abs(need.zeta) and steps > PRECISE:
        steps = max(_FINER * steps, PRECISE)
        finer = _searched(rise, eta, push, A, steps, zeta, largest)
        if finer.end != End.CLOSED or not finer.error < need.error:
            break
        need = finer
    return need


@compilable
def _searched(rise: Rise, eta: float, push: float, A: float, steps: float, zeta: float, largest: float) -> Needed:
    """Search by steps of one tolerance, and say what the result is off where the gap jumps."""
    found = _search(rise, eta, push, A, steps, zeta, largest)
    end, zeta, error, low, high = found
    if end != End.CLOSED or error < math.inf:
        return found
    # The gap jumps there: halves part by all digits, or the law has a jump, or its table ends.
    if gap(rise, eta, low, push, A, steps, no_wedge(rise)).leaves:
        return Needed(End.OUTSIDE, zeta, math.inf, low, high)
    looser = _search(rise, eta, push, A, _LOOSER * steps, zeta, largest)
    error = abs(looser.zeta - zeta) + (high - low) + _LOOSER * steps / -_FALL
    error += (PRECISE + _SHARE * steps) * (abs(zeta) + largest)
    if looser.end != End.CLOSED or error > _UNSURE * (abs(zeta) + largest):
        return Needed(End.FAILED, zeta, math.inf, low, high)
    return Needed(End.CLOSED, zeta, error, low, high)


@compilable
def _search(rise: Rise, eta: float, push: float, A: float, rtol: float, zeta: float, largest: float) -> Needed:
    """Search from a first guess, by steps of one tolerance.

    - `largest`: the largest rise of friction along the orbit, over its own forces.

    The error is infinite where the bracket collapsed: secants did not lead to a root.
    """
    low, high, slope = -math.inf, math.inf, _FALL
    reach = 0.1 * max(abs(zeta), largest + abs(push))
    last, before = math.nan, math.nan
    for _ in range(_MOST_GAPS):
        value, _, _, rounding, _ = gap(rise, eta, zeta, push, A, rtol, no_wedge(rise))
        if is_late():
            return Needed(End.LATE, zeta, math.inf, low, high)
        if math.isnan(value):
            return Needed(End.FAILED, zeta, math.inf, low, high)
        if value > 0.0:
            low = max(low, zeta)
        else:
            high = min(high, zeta)
        if math.isfinite(value) and math.isfinite(before) and (value - before) * (zeta - last) < 0.0:
            slope = (value - before) / (zeta - last)
        closer, is_slow = zeta - value / slope, abs(value) > _SLOW * abs(before)
        last, before = zeta, value
        if abs(value) <= _CLOSE * rtol:
            loose = gap(rise, eta, zeta, push, A, _LOOSER * rtol, no_wedge(rise)).value
            off = abs(loose - value) + rounding + _BENT * abs(value)
            if rtol > PRECISE:
                off += _LOOSER * rtol
            error = off / -slope + (PRECISE + _SHARE * rtol) * (abs(zeta) + largest)
            if error <= _UNSURE * (abs(zeta) + largest):
                return Needed(End.CLOSED, closer, error, low, high)
        if high - low < math.inf and high - low <= ROUNDING * max(abs(low), abs(high)):
            return Needed(End.CLOSED, zeta, math.inf, low, high)
        if abs(zeta) > _FARTHEST * (1.0 + abs(eta) + largest):
            return Needed(End.NEVER, zeta, math.inf, low, high)
        if math.isfinite(value) and low < closer < high and not is_slow:
            zeta = closer
        else:
            zeta, reach = _inner(low, high, zeta, reach), 3.0 * reach
    return Needed(End.FAILED, zeta, math.inf, low, high)


@compilable
def _inner(low: float, high: float, zeta: float, reach: float) -> float:
    """Return a damping ratio that halves a bracket, but within a reach of its end that was looked at."""
    if zeta == low:
        return min(low + reach, 0.5 * (low + high))
    return max(high - reach, 0.5 * (low + high))


@compilable
def needed_all(rise: Rise, columns: Any, rtol: float, rows: Any) -> None:
    """Search for the damping ratios that many orbits need, from eta, push and A to rows as a `Needed` has them."""
    eta, push, A = columns
    for i in range(len(A)):
        need = needed(rise, eta[i], push[i], A[i], rtol)
        rows[i, 0] = need.end.value
        rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4] = need.zeta, need.error, need.low, need.high


_UNKNOWN = {
    End.FAILED.value: Unknown("friction is too strong, or its law too steep, for the bound on the work"),
    End.LATE.value: Unknown("the time limit was reached"),
}


def damping_ratios(rows: FloatArray) -> Column:
    """Return the damping ratios in rows of `needed_all`.

    One is infinite where no damping is enough, or none too little. Where less lets an orbit leave the speeds that
    were measured it is the one at which that begins.
    """
    end, zeta, error, low, high = rows.T
    leaves, never = end == End.OUTSIDE, end == End.NEVER
    values = np.where(never, np.copysign(np.inf, zeta), zeta)
    errors = np.where(never, 0.0, np.where(leaves, high - low, error))
    return Column.of_codes(values, errors, end, _UNKNOWN)


@compilable
def gaps_all(rise: Rise, columns: Any, rtol: float, wedge: Wedge, rows: Any) -> None:
    """Find the gaps of many orbits, from eta, zeta, push and A to rows as a `Gap` has them."""
    eta, zeta, push, A = columns
    for i in range(len(A)):
        one = gap(rise, eta[i], zeta[i], push[i], A[i], rtol, wedge)
        rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4] = one


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


def gap_at(system: Dimensionless, A: float, *, rtol: float, wedge: Wedge | None = None) -> Gap:
    """Return the gap of an orbit at a system's own damping ratio: compiled, once that code is there.

    - `A`: highest velocity over the belt's; 1 for the slip from P, static excess included.
    - `rtol`: relative tolerance of the steps along which its sign is decided, where coarser ones do not.
    - `wedge`: that of the quantity for which the derivative is wanted.
    """
    push = system.push(1) if A == 1.0 else 0.0
    orbit = system.eta, system.zeta, push, A
    check_time()
    if is_ready(needed_all):
        source = no_wedge(system.rise) if wedge is None else wedge
        arrays = source._replace(pieces=np.array(source.pieces), shifts=np.array(source.shifts))
        rows = np.empty((1, len(Gap._fields)))
        system.spread(gaps_all, [np.array([value]) for value in orbit], (rtol, arrays), rows, few=0)
        value, slope, leaves, rounding, highest = rows[0].tolist()
        found = Gap(value, slope, bool(leaves), rounding, highest)
    elif wedge is None:
        found = sure_gap(system.rise, *orbit, rtol)
    else:
        found = gap(system.rise, *orbit, rtol, wedge)
    check_time()
    return found


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
    orbit: list[FloatArray] = [np.array([value]) for value in (eta, push, A)]
    rows = np.empty((1, 5))
    fast = (fast and is_compiling()) or is_ready(needed_all)
    system.spread(needed_all, orbit, (rtol,), rows, few=0 if fast else 1)
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
        raise NoThreshold(
            f"the slip that follows stick returns to the belt's speed for every damping, or for none, {place}"
        )
    raise NotConverged(
        f"the slip that follows stick cannot be integrated {place}: friction is too strong, or its law too steep, "
        f"for the bound on the work; the damping ratio lies between {low:.10g} and {high:.10g}"
    )

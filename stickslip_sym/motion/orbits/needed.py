"""The damping that a slip orbit needs: d(A), for every law, by secants in a bracket of signs that are known.

With time in 1/omega and w = |x' - V|/V, an orbit in slip whose mass reaches A V at its fastest comes to
w = 1 - A, where w' = 0. Forward from there it goes over its highest slip speed down to w = 1, where the mass
stands still; backward it comes to w = 1 as well. The orbit is closed where both halves meet, with one rate r = w'.
Along an orbit's last stretch neighbouring motions part, by many powers of ten if friction is strong; backward they
close up. So both halves are steady where one way round is not.

Damping rotates the field of directions one way, so the mismatch of velocities, g = log(r_f/r_b), falls with the
damping ratio zeta, for weak friction at the rate 2 pi, and has one root. A half may also creep to rest, or leave
the table of the law:

    ahead     back      mismatch
    returns   returns   log(r_f/r_b)
    returns   creeps    infinite
    creeps    returns   -infinite
    leaves    any       infinite: the table of the law ends there
    else                not known: the search ends with the bracket that it has

Time is no bound of a half. With q the displacement from rest and x = w - 1 there is q' = -x: while |x| is not
small q is used up at that rate, and beside rest implicit steps grow with the slowness of the motion. So a half is
followed until it comes to w = 1, or within the tolerance of rest; that it took all its steps says nothing.

The derivatives of the mismatch by every quantity follow from the wedge D of `slip`. At w = 1 - A there is D = 0,
but for A itself, where it is -A; at w = 1

    dr/dp = dw'/dp - D/r,    dg/dp = (dr_f/dp)/r_f - (dr_b/dp)/r_b.

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
from stickslip_sym.core.numbers import DOUBLE_BITS, ROOT_OF_ROUNDING, ROUNDING
from stickslip_sym.model.table import Rise
from stickslip_sym.motion.compiled import compilable, is_compiling, is_ready
from stickslip_sym.motion.kernel.follow import follow
from stickslip_sym.motion.kernel.forces import rise_at, standing
from stickslip_sym.motion.kernel.slip_data import (
    ADDED,
    LONGEST_STEP,
    MOST_STEPS,
    PRECISE,
    TIGHT,
    Branch,
    Field,
    SlipEnd,
    SlipState,
    Stop,
    Wedge,
    no_wedge,
)
from stickslip_sym.motion.orbits.expansion import FEWEST_PHASES
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.numerics.known import Column, Unknown

SIGNS = ADDED * PRECISE
"""The tolerance of the steps along which the sign of a mismatch is decided: errors of the table add up to it."""
PARTED = ROOT_OF_ROUNDING
"""The mismatch of an orbit beside which d jumps; where d is continuous it is that of rounding."""
STRONG = 30.0
"""Eta, from which halves are stiff."""
_LOOSEST = math.sqrt(TIGHT)  # tolerance of steps whose secant leads to a root within a tight one
_UNSURE = ADDED * _LOOSEST  # error of a damping ratio over the largest one at work, that is no value
_LOOSER = 10.0  # times the tolerance, for the estimate of what the integration is off
_FALL = -2 * math.pi  # of the mismatch with zeta, where friction is weak
_MOST_GAPS = 4 * DOUBLE_BITS  # dampings that are tried: halvings of a bracket, and as many to find one


class HalfOutcome(IntEnum):
    """What becomes of a half."""

    RETURNS = 0  # it comes to w = 1
    CREEPS = 1  # it is shown to tend to rest, or comes so near that at w = 1 its rate is below all others
    LEAVES = 2  # it comes to where the table of the law ends
    UNKNOWN = 3  # it takes too many steps, or none is short enough


class Half(NamedTuple):
    """Half an orbit: its outcome, w' and the wedge D at w = 1, its highest w, and how long it took."""

    outcome: HalfOutcome
    rate: float
    wedge: float
    highest: float
    tau: float


class VelocityMismatch(NamedTuple):
    """The mismatch of an orbit.

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


class SearchEnd(IntEnum):
    """How the search for the damping ratio of an orbit ended."""

    CLOSED = 0  # the orbit closes at the damping ratio that was found
    NEVER = 1  # no damping closes the orbit
    OUTSIDE = 2  # with less damping the orbit leaves the table of the law
    FAILED = 3  # the bound on the work was reached, or the mismatch is not known
    LATE = 4  # the time of a `time_limit` was up


class OrbitDampingRatio(NamedTuple):
    """The damping ratio that an orbit needs, as far as it was found.

    - `end`: how the search ended.
    - `zeta`, `error`: the damping ratio, and its error.
    - `low`, `high`: ratios between which it lies: the mismatch is above 0 at one, and not above 0 at the other.
    """

    end: SearchEnd
    zeta: float
    error: float
    low: float
    high: float


@compilable
def _follow_half(
    rise: Rise, field: Field, begin: SlipState, until: int, level: float, wedge: Wedge, rtol: float
) -> tuple[HalfOutcome, SlipState]:
    """Follow a slip to its maximum, or to a level, however long that takes."""
    longest = LONGEST_STEP
    if rise.gradual and abs(field.eta) <= STRONG:
        longest = math.inf
    stop = Stop(until, level, math.inf, MOST_STEPS, 0, longest)
    end, state, _, _ = follow(rise, field, 0.0, begin, stop, wedge, rtol, False)
    outcome = HalfOutcome.UNKNOWN
    if end == until:
        outcome = HalfOutcome.RETURNS
    elif end == SlipEnd.OUTSIDE:
        outcome = HalfOutcome.LEAVES
    elif end == SlipEnd.REST:
        outcome = HalfOutcome.CREEPS
    return outcome, state


@compilable
def forward_and_backward_orbit(
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

    forward = Field(eta, push + rest, 1.0, 2.0 * zeta)
    begin = SlipState(0.0, q, w, 1.0, 0.0, D)
    outcome, state = _follow_half(rise, forward, begin, SlipEnd.MAXIMUM.value, math.inf, wedge, rtol)
    highest = state.w
    tau = state.tau
    if outcome == HalfOutcome.RETURNS:
        top = SlipState(0.0, state.q, state.w, 1.0, 0.0, state.wedge)
        outcome, state = _follow_half(rise, forward, top, SlipEnd.LEVEL.value, 1.0, wedge, rtol)
        tau += state.tau
    ahead = Half(outcome, state.rate, state.wedge, highest, tau)

    # Backward in time the equations are the same, with q and all of their factors negated.
    negated = Wedge(-wedge.constant, -wedge.linear, -wedge.factor, wedge.pieces, wedge.shifts, wedge.wanted)
    backward = Field(-eta, -push - rest, 1.0, -2.0 * zeta)
    begin = SlipState(0.0, -graze, w, 1.0, 0.0, D)
    outcome, state = _follow_half(rise, backward, begin, SlipEnd.LEVEL.value, 1.0, negated, rtol)
    back = Half(outcome, -state.rate, state.wedge, w, state.tau)

    if ahead.outcome == HalfOutcome.RETURNS and back.outcome == HalfOutcome.RETURNS:
        jump = eta * (standing(pieces, True) - standing(pieces, False))
        if jump < 0.0 and ahead.rate < 0.0:
            ahead = _cross_jump(ahead, jump)
        elif jump > 0.0 and back.rate < 0.0:
            back = _cross_jump(back, -jump)
    return ahead, back


@compilable
def _cross_jump(half: Half, jump: float) -> Half:
    """Return the end of a half beyond a jump of w', with which the wedge changes."""
    wedge = half.wedge * (1.0 + jump / half.rate)
    return Half(half.outcome, half.rate + jump, wedge, half.highest, half.tau)


@compilable
def velocity_mismatch(
    rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float, wedge: Wedge
) -> VelocityMismatch:
    """Return the mismatch of an orbit; arguments as for `forward_and_backward_orbit`."""
    ahead, back = forward_and_backward_orbit(rise, eta, zeta, push, A, rtol, wedge, 0.0)
    r_f = ahead.rate
    r_b = back.rate
    highest = ahead.highest
    if ahead.outcome in (HalfOutcome.LEAVES, HalfOutcome.UNKNOWN):
        highest = math.inf
    if ahead.outcome == HalfOutcome.LEAVES:
        return VelocityMismatch(math.inf, 0.0, True, math.inf, highest)
    arrives = ahead.outcome == HalfOutcome.RETURNS
    came = back.outcome == HalfOutcome.RETURNS
    if arrives and r_f < 0.0 and (back.outcome == HalfOutcome.CREEPS or (came and r_b >= 0.0)):
        return VelocityMismatch(math.inf, 0.0, False, math.inf, highest)
    if came and (ahead.outcome == HalfOutcome.CREEPS or (arrives and r_f >= 0.0)):
        return VelocityMismatch(-math.inf, 0.0, False, math.inf, highest)
    if not (arrives and came):
        return VelocityMismatch(math.nan, 0.0, False, math.inf, highest)
    lifted = standing(rise.pieces, True)
    b = wedge.constant + wedge.linear
    if wedge.factor != 0.0:
        b += wedge.factor * standing(wedge.pieces, lifted >= standing(rise.pieces, False))
    slope = (b - ahead.wedge / r_f) / r_f - (b - back.wedge / r_b) / r_b
    rounding = ROUNDING * (1.0 + (abs(eta * lifted) + abs(push) + abs(zeta)) / abs(r_f))
    return VelocityMismatch(math.log(r_f / r_b), slope, False, rounding, highest)


@compilable
def mismatch_of_certain_sign(
    rise: Rise, eta: float, zeta: float, push: float, A: float, rtol: float
) -> VelocityMismatch:
    """Return the mismatch by loose steps where they show its sign, without its derivative."""
    unwanted = no_wedge(rise)
    if abs(eta) <= STRONG:
        glance = velocity_mismatch(rise, eta, zeta, push, A, _LOOSEST, unwanted)
        if not glance.leaves and ADDED * _LOOSEST < abs(glance.value) < math.inf:
            return glance
    return velocity_mismatch(rise, eta, zeta, push, A, rtol, unwanted)


@compilable
def _tolerance(eta: float, zeta: float, rtol: float) -> float:
    """Return the tolerance of steps for a relative error of a damping ratio of about that size."""
    share = 0.25 * abs(_FALL * zeta)  # the rest is for the secant, and for a first guess that is too large
    if abs(eta) <= STRONG:
        share = min(share, 1.0)
    return min(max(share * rtol / ADDED, PRECISE), _LOOSEST)


@compilable
def search_damping_ratio(rise: Rise, eta: float, push: float, A: float, rtol: float) -> OrbitDampingRatio:
    """Search for the damping ratio that an orbit needs, with a relative error that is wanted."""
    zeta, largest = _harmonic(rise, eta, A)
    if max(largest, abs(push)) == 0.0:
        return OrbitDampingRatio(SearchEnd.CLOSED, 0.0, 0.0, 0.0, 0.0)
    if not largest * TIGHT < 1.0:  # what the spring does is lost
        return OrbitDampingRatio(SearchEnd.FAILED, zeta, math.inf, -math.inf, math.inf)
    is_within_reach = rtol * abs(_FALL * zeta) >= ADDED * PRECISE
    if abs(eta) <= STRONG and is_within_reach and rise.gradual:
        need = _search_by_secants(rise, eta, push, A, rtol, zeta, largest)
        if need.end != SearchEnd.FAILED:
            return need
    steps = _tolerance(eta, zeta, rtol)
    need = _searched(rise, eta, push, A, steps, zeta, largest)
    if need.end == SearchEnd.CLOSED and need.error > rtol * abs(need.zeta) and steps > PRECISE:
        finer_steps = 0.5 * steps * rtol * abs(need.zeta) / need.error
        finer = _searched(rise, eta, push, A, max(finer_steps, PRECISE), zeta, largest)
        if finer.end == SearchEnd.CLOSED and finer.error < need.error:
            need = finer
    return need


@compilable
def _search_by_secants(
    rise: Rise, eta: float, push: float, A: float, rtol: float, zeta: float, largest: float
) -> OrbitDampingRatio:
    """Search from a first guess by secants alone; it has failed where these do not lead to the root.

    For moderate friction whose law varies gradually it is known what errors of steps add up to. So steps are as
    long as the error that is wanted allows, and loose while the mismatch is far from 0.
    """
    steps = _LOOSEST
    added_before = 0.0
    slope = _FALL
    bend = 1.0  # the slope may be anything before it was seen
    low = -math.inf
    high = math.inf
    last = math.nan
    before = math.nan
    for _ in range(_MOST_GAPS):
        value, _, _, rounding, _ = velocity_mismatch(rise, eta, zeta, push, A, steps, no_wedge(rise))
        if is_late():
            return OrbitDampingRatio(SearchEnd.LATE, zeta, math.inf, low, high)
        if not math.isfinite(value) or abs(value) > abs(before) + added_before:
            break
        added = ADDED * steps * max(rounding / ROUNDING, slope / _FALL)
        if value > added:
            low = max(low, zeta)
        elif value < -added:
            high = min(high, zeta)
        noise = added + added_before
        if (value - before) * (zeta - last) < 0.0 and noise < abs(value - before):
            # The rates change by a factor e, and with them the slope by as much, where a mismatch changes by 1.
            bend = abs(before) + noise / abs(value - before)
            slope = (value - before) / (zeta - last)
        closer = zeta - value / slope
        off = added + bend * abs(value)
        error = off / -slope + PRECISE * (abs(zeta) + largest)
        wanted = rtol * abs(closer)
        if error <= wanted:
            return OrbitDampingRatio(SearchEnd.CLOSED, closer, error, closer - error, closer + error)
        enough = 0.5 * wanted * -slope / added * steps  # the other half is for the secant
        if enough < PRECISE:
            break
        last = zeta
        before = value
        added_before = added
        zeta = closer
        steps = min(enough, _LOOSEST)
    return OrbitDampingRatio(SearchEnd.FAILED, zeta, math.inf, -math.inf, math.inf)


@compilable
def _searched(
    rise: Rise, eta: float, push: float, A: float, steps: float, zeta: float, largest: float
) -> OrbitDampingRatio:
    """Search by steps of one tolerance, and say what the result is off where the mismatch jumps."""
    found = _search(rise, eta, push, A, steps, zeta, largest)
    end, zeta, error, low, high = found
    if end != SearchEnd.CLOSED or error < math.inf:
        return found
    # The mismatch jumps there: halves part by all digits, or the law has a jump, or its table ends.
    if velocity_mismatch(rise, eta, low, push, A, steps, no_wedge(rise)).leaves:
        return OrbitDampingRatio(SearchEnd.OUTSIDE, zeta, math.inf, low, high)
    looser = _search(rise, eta, push, A, _LOOSER * steps, zeta, largest)
    error = abs(looser.zeta - zeta) + (high - low) + ADDED * steps / -_FALL
    error += (PRECISE + steps / ADDED) * (abs(zeta) + largest)
    if looser.end != SearchEnd.CLOSED or error > _UNSURE * (abs(zeta) + largest):
        return OrbitDampingRatio(SearchEnd.FAILED, zeta, math.inf, low, high)
    return OrbitDampingRatio(SearchEnd.CLOSED, zeta, error, low, high)


@compilable
def _search(
    rise: Rise, eta: float, push: float, A: float, rtol: float, zeta: float, largest: float
) -> OrbitDampingRatio:
    """Search from a first guess, by steps of one tolerance.

    - `largest`: the largest rise of friction along the orbit, over its own forces.

    The error is infinite where the bracket collapsed: secants did not lead to a root.
    """
    low = -math.inf
    high = math.inf
    slope = _FALL
    reach = 0.1 * max(abs(zeta), largest + abs(push))
    last = math.nan
    before = math.nan
    for _ in range(_MOST_GAPS):
        value, _, _, rounding, _ = velocity_mismatch(rise, eta, zeta, push, A, rtol, no_wedge(rise))
        if is_late():
            return OrbitDampingRatio(SearchEnd.LATE, zeta, math.inf, low, high)
        if math.isnan(value):
            return OrbitDampingRatio(SearchEnd.FAILED, zeta, math.inf, low, high)
        if value > 0.0:
            low = max(low, zeta)
        else:
            high = min(high, zeta)
        if math.isfinite(value) and math.isfinite(before) and (value - before) * (zeta - last) < 0.0:
            slope = (value - before) / (zeta - last)
        closer = zeta - value / slope
        is_slow = abs(value) > abs(before)
        last = zeta
        before = value
        if abs(value) <= ADDED * rtol:
            loose = velocity_mismatch(rise, eta, zeta, push, A, _LOOSER * rtol, no_wedge(rise)).value
            off = abs(loose - value) + rounding + abs(value) / ADDED
            if rtol > PRECISE:
                off += ADDED * rtol * max(1.0, slope / _FALL)
            error = off / -slope + (PRECISE + rtol / ADDED) * (abs(zeta) + largest)
            if error < math.inf:
                return OrbitDampingRatio(SearchEnd.CLOSED, closer, error, low, high)
        if high - low < math.inf and high - low <= ROUNDING * max(abs(low), abs(high)):
            return OrbitDampingRatio(SearchEnd.CLOSED, zeta, math.inf, low, high)
        if abs(zeta) * _LOOSEST > 1.0 + abs(eta) + largest:  # steps see nothing but the damping
            return OrbitDampingRatio(SearchEnd.NEVER, zeta, math.inf, low, high)
        if math.isfinite(value) and low < closer < high and not is_slow:
            zeta = closer
        else:
            zeta = _inner(low, high, zeta, reach)
            reach = 3.0 * reach
    return OrbitDampingRatio(SearchEnd.FAILED, zeta, math.inf, low, high)


@compilable
def _inner(low: float, high: float, zeta: float, reach: float) -> float:
    """Return a damping ratio that halves a bracket, but within a reach of its end that was looked at."""
    if zeta == low:
        return min(low + reach, 0.5 * (low + high))
    return max(high - reach, 0.5 * (low + high))


@compilable
def search_damping_ratios(rise: Rise, columns: Any, rtol: float, rows: Any) -> None:
    """Search for the damping ratios that many orbits need.

    - `columns`: eta, push and A.
    - `rows`: for what an `OrbitDampingRatio` has.
    """
    eta, push, A = columns
    for i in range(len(A)):
        need = search_damping_ratio(rise, eta[i], push[i], A[i], rtol)
        rows[i, 0] = need.end.value
        rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4] = need.zeta, need.error, need.low, need.high


_UNKNOWN = {
    SearchEnd.FAILED.value: Unknown("friction is too strong, or its law too steep, for the bound on the work"),
    SearchEnd.LATE.value: Unknown("the time limit was reached"),
}


def damping_ratios(rows: FloatArray) -> Column:
    """Return the damping ratios in rows of `search_damping_ratios`.

    One is infinite where no damping is enough, or none too little. Where less lets an orbit leave the speeds that
    were measured it is the one at which that begins.
    """
    end, zeta, error, low, high = rows.T
    leaves = end == SearchEnd.OUTSIDE
    never = end == SearchEnd.NEVER
    values = np.where(never, np.copysign(np.inf, zeta), zeta)
    errors = np.where(never, 0.0, np.where(leaves, high - low, error))
    return Column.of_codes(values, errors, end, _UNKNOWN)


@compilable
def velocity_mismatches(rise: Rise, columns: Any, rtol: float, wedge: Wedge, rows: Any) -> None:
    """Find the mismatches of many orbits, from eta, zeta, push and A to rows as a `VelocityMismatch` has them."""
    eta, zeta, push, A = columns
    for i in range(len(A)):
        one = velocity_mismatch(rise, eta[i], zeta[i], push[i], A[i], rtol, wedge)
        rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4] = one


@compilable
def _harmonic(rise: Rise, eta: float, A: float) -> tuple[float, float]:
    """Return the damping ratio by harmonic balance over slip speeds from 1 - A to 1 + A, and the largest rise.

    The ratio is a first guess, by a few phases. The rise is 0 only if it is at the middle of each piece too: the
    bump of a law that is flat elsewhere lies between phases.
    """
    pieces = rise.pieces
    end = rise.levels[-1]
    whole = Branch(pieces, 0, len(pieces) - 1, 0)
    zeta = 0.0
    largest = 0.0
    for i in range(FEWEST_PHASES):
        cosine = math.cos((i + 0.5) * math.pi / FEWEST_PHASES)
        lifted = eta * rise_at(whole, min(1.0 - A * cosine, end))
        zeta += lifted * cosine / (A * FEWEST_PHASES)
        largest = max(largest, abs(lifted))
    for i in range(len(pieces)):
        if 1.0 - A < pieces[i][1] < 1.0 + A:
            largest = max(largest, abs(eta * pieces[i][3]))
    return zeta, largest


def velocity_mismatch_at(
    system: NondimensionalOscillator, A: float, *, rtol: float, wedge: Wedge | None = None
) -> VelocityMismatch:
    """Return the mismatch of an orbit at a system's own damping ratio: compiled, once that code is there.

    - `A`: highest velocity over the belt's; 1 for the slip from P, static excess included.
    - `rtol`: relative tolerance of the steps along which its sign is decided, where coarser ones do not.
    - `wedge`: that of the quantity for which the derivative is wanted.
    """
    push = system.push(1) if A == 1.0 else 0.0
    orbit = system.eta, system.zeta, push, A
    check_time()
    if is_ready(search_damping_ratios):
        source = no_wedge(system.rise) if wedge is None else wedge
        arrays = source._replace(pieces=np.array(source.pieces), shifts=np.array(source.shifts))
        rows = np.empty((1, len(VelocityMismatch._fields)))
        system.spread(velocity_mismatches, [np.array([value]) for value in orbit], (rtol, arrays), rows, few=0)
        value, slope, leaves, rounding, highest = rows[0].tolist()
        found = VelocityMismatch(value, slope, bool(leaves), rounding, highest)
    elif wedge is None:
        found = mismatch_of_certain_sign(system.rise, *orbit, rtol)
    else:
        found = velocity_mismatch(system.rise, *orbit, rtol, wedge)
    check_time()
    return found


def orbit_damping_ratio(
    system: NondimensionalOscillator, A: float = 1.0, *, rtol: float = TIGHT, fast: bool = False
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
    eta = system.eta
    push = system.push(1) if A == 1.0 else 0.0
    orbit: list[FloatArray] = [np.array([value]) for value in (eta, push, A)]
    rows = np.empty((1, 5))
    fast = (fast and is_compiling()) or is_ready(search_damping_ratios)
    system.spread(search_damping_ratios, orbit, (rtol,), rows, few=0 if fast else 1)
    end, zeta, error, low, high = rows[0].tolist()
    if end == SearchEnd.LATE or is_late():  # then the last mismatch may be wrong
        raise OutOfTime(
            f"the time limit was reached; the best value so far is c = {2 * zeta:.6g} sqrt(k m), and c lies "
            f"between {2 * low:.6g} and {2 * high:.6g} times sqrt(k m)"
        )
    if end == SearchEnd.CLOSED:
        return zeta, error
    if end == SearchEnd.OUTSIDE and math.isfinite(system.w_max):
        raise system.unmeasured(system.w_max)
    place = f"at eta = {eta:g} and V = {system.V:g} m/s"
    if end == SearchEnd.NEVER:
        raise NoThreshold(
            f"the slip that follows stick returns to the belt's speed for every damping, or for none, {place}"
        )
    raise NotConverged(
        f"the slip that follows stick cannot be integrated {place}: friction is too strong, or its law too steep, "
        f"for the bound on the work; the damping ratio lies between {low:.10g} and {high:.10g}"
    )

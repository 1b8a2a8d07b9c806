"""`follow`: a slip from where it begins to where it ends, as a loop over steps."""

import math

from stickslip_sym.core.deadline import is_late
from stickslip_sym.core.numbers import EPSILON
from stickslip_sym.model.table import Rise
from stickslip_sym.motion.compiled import compilable, inlined
from stickslip_sym.motion.kernel.creeping import creeps
from stickslip_sym.motion.kernel.events import land
from stickslip_sym.motion.kernel.forces import (
    entered,
    interval_number,
    rate_at,
    rise_at,
    slope_at,
    slope_standing,
    standing,
)
from stickslip_sym.motion.kernel.slip_data import (
    ACCURATE_STEP,
    PRECISE,
    Branch,
    Extent,
    Field,
    Pace,
    Run,
    SlipEnd,
    SlipState,
    SlipStep,
    Stop,
    Trial,
    Wedge,
)
from stickslip_sym.motion.kernel.steps import AMPLIFIED, SHORTEST, stepped

_PAST = 2.0  # times the way to the end of a segment: its polynomials are of no use far beyond
_STIFF_DECAY = 10.0  # a decay of w, per unit of time, below which explicit steps are cheap enough
_STABLE = 2.5  # decay times a step, from which stability holds it short: the explicit method bears about 6
_LOOK = 100  # steps between two looks at the time limit
_STEPS_HELD_SHORT = 15  # steps held short by stability before the method changes
_NO_ERROR = 1e-7  # of the tolerance, that may be nothing but rounding
_REST_WITHIN = 10  # times the tolerance: nearer to rest the errors of steps do not let the mass come
_REST_WIDTH = 1e-6  # of w = 1, from where it is asked whether a mass is at rest


@compilable
def follow(
    rise: Rise, field: Field, hold: float, begin: SlipState, stop: Stop, wedge: Wedge, rtol: float, recorded: bool
) -> Run:
    """Follow slip from a state at tau = 0, whose side is that of the field; its rate is not read.

    - `hold`: 2 eta mu_static, the width in q of the range where static friction holds the mass.
    - `recorded`: keep the steps.
    """
    steps = [SlipStep(0.0, 0.0, 0.0, 0.0, 0.0, 0, False)]
    steps.pop()
    q = begin.q
    u = begin.side * begin.w
    farthest = rise.levels[-1]
    taken = 0
    passed = 0
    q_least = q
    q_most = q
    u_least = u
    u_most = u
    if not (begin.w <= farthest and abs(q) < math.inf):
        return Run(SlipEnd.OUTSIDE, begin, Extent(taken, passed, q, q, u, u), steps)
    segment, rising, state = _begun(rise, field, begin)
    branch = entered(rise, segment, True, state.w)
    pace = _first_pace(branch, field, state, stop.longest, rtol)
    at_kink = not rising and segment > 0 and state.w == rise.levels[segment]  # it leaves downward
    close = _REST_WIDTH + _REST_WITHIN * rtol
    end = SlipEnd.OPEN
    while end == SlipEnd.OPEN:
        if at_kink:
            at_kink = False
            before = state
            end, segment, rising, state, slide = _enter(rise, field, state, segment, rising, stop, wedge)
            if slide > -1.0:
                if recorded:
                    steps.append(SlipStep(before.tau, before.q, before.w, 0.0, slide, -1, False))
                taken = taken + 1
                q_least = min(q_least, state.q)
                q_most = max(q_most, state.q)
            if end != SlipEnd.OPEN:
                break
            branch = entered(rise, segment, rising, state.w)
            state = _add_rate(state, rate_at(branch, field, state.q, state.w))
        end = _interruption(state.tau, taken, stop)
        is_asked = taken % _LOOK == _LOOK - 1 and field.side > 0.0 and not recorded
        if is_asked and stop.horizon == math.inf and creeps(rise, field, state.q, state.w):
            end = SlipEnd.REST
        if end != SlipEnd.OPEN:
            break
        border = rise.levels[segment + 1] if rising else rise.levels[segment]
        most = stop.horizon - state.tau
        if _PAST * abs(border - state.w) < most * abs(state.rate):
            most = _PAST * abs(border - state.w) / abs(state.rate)
        trial, pace = _advance(branch, field, state, pace, most, stop.longest, rtol, wedge)
        shortest = SHORTEST * max(state.tau, 1.0)
        if pace.again:
            end = SlipEnd.FAILED if trial.length <= shortest else SlipEnd.OPEN
            continue
        event, trial = land(branch, field, state, trial, rising, border, stop.level, pace.implicit, rtol, wedge)
        if event != SlipEnd.OPEN and not trial.error < 1.0 and trial.length > shortest:
            pace = _shortened(pace, trial)
            continue
        if recorded:
            steps.append(SlipStep(state.tau, state.q, state.w, state.rate, trial.length, segment, pace.implicit))
        is_over = event == SlipEnd.OPEN and pace.tried == stop.horizon - state.tau
        tau = stop.horizon if is_over else state.tau + trial.length
        state = SlipState(tau, trial.q, trial.w, field.side, trial.rate, trial.wedge)
        taken = taken + 1
        u = field.side * trial.w
        q_least = min(q_least, trial.q)
        q_most = max(q_most, trial.q)
        u_least = min(u_least, u)
        u_most = max(u_most, u)
        near = interval_number(branch.pieces, branch.first, branch.last, branch.near, trial.w)
        if near != branch.near:
            branch = Branch(branch.pieces, branch.first, branch.last, near)
        may_rest = abs(trial.w - 1.0) <= close and event in (SlipEnd.OPEN, SlipEnd.LEVEL)
        ends_at = SlipEnd.OPEN
        if may_rest:
            ends_at = _is_beside_rest(rise, field, state, rising, rtol)
        if ends_at == SlipEnd.REST:
            end = SlipEnd.REST
        elif ends_at == SlipEnd.LEVEL:
            at_kink = True
            state = _place_on_jump(rise, field, state, rising, wedge)
            if stop.until == SlipEnd.LEVEL and stop.level == 1.0:
                end = SlipEnd.LEVEL
        elif event == SlipEnd.LEVEL:
            at_kink = state.w == border and border > 0.0
            if state.w == 0.0 and state.rate > 0.0 and stop.until == SlipEnd.MINIMUM:
                end = SlipEnd.MINIMUM  # it turned within rounding of the belt's speed
            elif state.w == 0.0 and (passed == stop.passes or -hold <= state.q <= 0.0):
                end = SlipEnd.RETURN
            elif state.w == 0.0:
                field, state = _cross(branch, field, hold, state)
                passed = passed + 1
                rising = True
            elif state.w == farthest:
                end = SlipEnd.OUTSIDE
            elif stop.until == SlipEnd.LEVEL and state.w == stop.level:
                end = SlipEnd.LEVEL
        elif event != SlipEnd.OPEN:
            rising = not rising
            state = _add_rate(state, 0.0)
            end = event if stop.until == event else SlipEnd.OPEN
    return Run(end, state, Extent(taken, passed, q_least, q_most, u_least, u_most), steps)


@compilable
def _begun(rise: Rise, field: Field, begin: SlipState) -> tuple[int, bool, SlipState]:
    """Return the segment of the law in which a slip begins, whether w rises there, and the state with its rate."""
    w = begin.w
    segment = 0
    while segment + 2 < len(rise.levels) and w >= rise.levels[segment + 1]:
        segment += 1
    branch = entered(rise, segment, True, w)
    rate = rate_at(branch, field, begin.q, w)
    forces = abs(field.push) + abs(field.eta * rise_at(branch, w)) + abs(begin.q) + abs(field.damping * w)
    noise = PRECISE * forces
    rising = w == 0.0 or rate > noise or (abs(rate) <= noise and w < field.side)
    return segment, rising, _add_rate(begin, rate)


@compilable
def _first_pace(branch: Branch, field: Field, state: SlipState, longest: float, rtol: float) -> Pace:
    """Return the pace of a slip that begins, implicit at once where no explicit step is short enough."""
    fastest = max(1.0, max(abs(1.0 - field.side * state.w), abs(state.rate)))
    length = min(ACCURATE_STEP * rtol**0.125 / fastest, longest)
    decay = field.eta * slope_at(branch, state.w) + field.damping
    return Pace(decay * SHORTEST > 1.0, 0, length, 0.0, length, False)


@compilable
def _interruption(tau: float, taken: int, stop: Stop) -> SlipEnd:
    """Return why a slip is not followed further, or that it is."""
    end = SlipEnd.OPEN
    if tau >= stop.horizon:
        end = SlipEnd.HORIZON
    elif taken >= stop.most:
        end = SlipEnd.STEPS
    elif taken % _LOOK == 0 and is_late():
        end = SlipEnd.LATE
    return end


@inlined
def _advance(
    branch: Branch, field: Field, state: SlipState, pace: Pace, most: float, longest: float, rtol: float,
    wedge: Wedge,
) -> tuple[Trial, Pace]:  # fmt: skip
    """Try a step of the kind and the length that the steps before it say, and return it with the pace after it.

    - `most`: its length at most; `longest`: that of an explicit one.

    The step is implicit where stability holds explicit ones short. One that is taken again is held short by
    accuracy, as where mu is singular.
    """
    implicit, held, length, tried, bearable, again = pace
    if not again:
        decay = field.eta * slope_at(branch, state.w) + field.damping
        # A third, so that the method does not change to and fro.
        if implicit and decay <= _STIFF_DECAY / 3.0:
            implicit = False
            held = 0
            length = rtol**0.125 / max(1.0, abs(state.rate))
        elif not implicit:
            held = held + 1 if decay > _STIFF_DECAY and decay * tried > _STABLE else 0
            implicit = held >= _STEPS_HELD_SHORT
    h = min(length, most)
    if not implicit:
        h = min(h, longest)
    trial = stepped(implicit, branch, field, state, h, rtol, wedge)
    error = trial.error
    again = not error < 1.0
    if again:
        length = h * max(0.2, 0.9 * error**-0.125 if error < math.inf else 0.0)
    else:
        # The longest step that the tolerance bears, which may go on falling as it fell in this one.
        before = bearable
        bearable = h * max(error, _NO_ERROR) ** -0.125
        length = 0.85 * bearable * min(1.0, bearable / before)
    return trial, Pace(implicit, held, length, h, bearable, again)


@compilable
def _shortened(pace: Pace, trial: Trial) -> Pace:
    """Return the pace for shorter steps to where the last one came, as where mu is singular at the level."""
    return Pace(pace.implicit, pace.held, 0.5 * trial.length, pace.tried, pace.bearable, True)


@compilable
def _cross(branch: Branch, field: Field, hold: float, state: SlipState) -> tuple[Field, SlipState]:
    """Return the forces and the state beyond the belt's speed: friction turns, and D changes as w' does."""
    side = 1.0 if state.q > 0.0 else -1.0
    field = Field(field.eta, field.push + 0.5 * (side - field.side) * hold, side, field.damping)
    rate = rate_at(branch, field, state.q, state.w)
    return field, SlipState(state.tau, state.q, state.w, side, rate, state.wedge * rate / state.rate)


@compilable
def _enter(
    rise: Rise, field: Field, state: SlipState, segment: int, rising: bool, stop: Stop, wedge: Wedge
) -> tuple[SlipEnd, int, bool, SlipState, float]:
    """Let a mass pass the kink between two segments of the law, or slide where mu jumps there.

    Returns the end if it is one, the segment beyond, whether w rises there, the state, and how long the mass
      slides, -1 if it does not.
    """
    beyond = segment + 1 if rising else segment - 1
    upper = max(segment, beyond)
    across = rate_at(entered(rise, beyond, rising, state.w), field, state.q, state.w)
    end = SlipEnd.OPEN
    slide = -1.0
    if (across >= 0.0) == rising or rise.jumps[upper] == 0.0:
        segment = beyond
        if wedge.wanted and rise.jumps[upper] != 0.0:
            state = _cross_jump_of_law(field, state, across, wedge.shifts[upper])
    elif field.side * state.w == 1.0:
        end = SlipEnd.REST
        state = _add_rate(state, 0.0)
    else:
        turn, segment, rising, slide = _slide(rise, field, state, upper, rising, stop.horizon)
        state = _slid(field, state, slide, wedge.shifts[upper])
        if turn == stop.until:
            end = turn
            state = _add_rate(state, 0.0)
    return end, segment, rising, state, slide


@compilable
def _cross_jump_of_law(field: Field, state: SlipState, across: float, shift: float) -> SlipState:
    """Return the state beyond a jump of mu, where w' is `across`; `shift` is that of the jump with p."""
    moved = shift * (1.0 - field.side * state.w)
    D = state.wedge
    if state.rate != 0.0:
        D = moved + (D - moved) * across / state.rate
    return SlipState(state.tau, state.q, state.w, state.side, state.rate, D)


@compilable
def _slide(
    rise: Rise, field: Field, state: SlipState, upper: int, came_rising: bool, horizon: float
) -> tuple[SlipEnd, int, bool, float]:
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
    turn = SlipEnd.OPEN
    if rising != came_rising:
        turn = SlipEnd.MINIMUM if rising else SlipEnd.MAXIMUM
    return turn, segment, rising, length


@compilable
def _slid(field: Field, state: SlipState, length: float, shift: float) -> SlipState:
    """Return the state after a slide at a jump of mu, the motions beside it lying on it."""
    speed = 1.0 - field.side * state.w
    return SlipState(state.tau + length, state.q + length * speed, state.w, state.side, 0.0, shift * speed)


@compilable
def _add_rate(state: SlipState, rate: float) -> SlipState:
    """Return a state with its rate."""
    return SlipState(state.tau, state.q, state.w, state.side, rate, state.wedge)


@compilable
def _is_beside_rest(rise: Rise, field: Field, state: SlipState, rising: bool, rtol: float) -> SlipEnd:
    """Return whether a mass with w near 1 is at rest within the tolerance, and stays there: `REST`.

    Where two segments of the law meet at rest without a jump, a motion may come to it in swings over both, where
    deviations decay on the mean; or creep to it on one side, where that side has real exponents below 0. Where mu
    jumps there and exponents are not real, it comes to w = 1 in less than half a swing, however near: `LEVEL`.
    """
    eta, push, side, damping = field
    q = state.q
    w = state.w
    pieces = rise.pieces
    if side < 0.0 or rise.levels[-1] <= 1.0 + _REST_WIDTH:
        return SlipEnd.OPEN
    above = eta * standing(pieces, True)
    below = eta * standing(pieces, False)
    faster = eta * slope_standing(pieces, True) + damping
    slower = eta * slope_standing(pieces, False) + damping
    is_slower = w < 1.0 or (w == 1.0 and rising)
    decay = faster
    lifted = above
    if is_slower:
        decay = slower
        lifted = below
    rest = damping - push + lifted
    fastest = max(abs(faster), abs(slower))
    noise = EPSILON * max(max(abs(push), abs(lifted)), max(abs(rest), abs(damping)))
    if fastest > _STIFF_DECAY:  # of implicit steps
        noise *= AMPLIFIED / fastest
    close = _REST_WITHIN * (rtol + noise)
    if abs(w - 1.0) > close or abs(q - rest) > close * max(1.0, abs(rest)):
        return SlipEnd.OPEN
    # x'' + decay x' + x = 0 has real exponents from 2 on.
    if decay >= 2.0 or (above == below and faster + slower > 0.0):
        return SlipEnd.REST
    comes = w != 1.0 and decay > 0.0 and is_slower == rising
    return SlipEnd.LEVEL if above != below and comes else SlipEnd.OPEN


@compilable
def _place_on_jump(rise: Rise, field: Field, state: SlipState, rising: bool, wedge: Wedge) -> SlipState:
    """Return the state where mu jumps at w = 1 of a mass that is at rest there but for rounding.

    Its displacement is that of rest on the side from which it came, and so is how that changes: dq/dp = -dw'/dp.
    """
    below = rising
    q = field.damping - field.push + field.eta * standing(rise.pieces, not below)
    rate = EPSILON if rising else -EPSILON
    change = wedge.constant + wedge.linear
    if wedge.factor != 0.0:
        change += wedge.factor * standing(wedge.pieces, not below)
    return SlipState(state.tau, q, 1.0, state.side, rate, rate * change)

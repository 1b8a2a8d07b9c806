"""The pure-slip threshold by simulation: the damping at which the slip from P grazes the belt's speed.

Nothing here knows a closed form, so the threshold is a check of every criterion. It is the needed damping of the
orbit with A = 1 (`search_damping_ratio`), for every law. Its derivatives follow from the same two halves: at the
threshold the mismatch is 0, so dzeta/dp = -(dg/dp)/(dg/dzeta) for every quantity p. Where the highest slip speed
touches one at which mu drops the mismatch steps past 0, and what is 0 is the distance between the two.
"""

import math
from dataclasses import replace

import numpy as np

from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import ROUNDING
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.expression.pieces import places, rate
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.model.table import Pieces
from stickslip_sym.motion.kernel.slip_data import ADDED, PRECISE, TIGHT, SlipEnd, Wedge
from stickslip_sym.motion.orbits.damping import DAMPING_RTOL, STEP_ERRORS
from stickslip_sym.motion.orbits.needed import PARTED, orbit_damping_ratio, velocity_mismatch_at
from stickslip_sym.motion.slip import SAME_AMPLITUDE, NondimensionalOscillator
from stickslip_sym.motion.thresholds.operating_points import VANISHING
from stickslip_sym.numerics.resolved import ERRORS_OF_CLEAR_SIGN

_TABULATED_OVER_HIGHEST = 1.5
"""Times the highest slip speed, up to which a derivative of the law is tabulated: steps try further."""
_OF_SPRING = 0.1  # friction may be far weaker than the spring, whose share of these errors is that
_MOST_FATE_STEPS = 2000  # of such a slip: the search for a threshold takes about as many


def grazing_damping(law: BoundLaw, osc: Oscillator, *, rtol: float, fast: bool = False) -> tuple[float, float]:
    """Return the damping c in kg/s at which the slip from P grazes the belt's speed, and its error in kg/s.

    - `osc`: its own c is not used.
    - `rtol`: relative error that is wanted; one of 1e-9 is sought in any case, at twice the cost of 1e-3.
    - `fast`: compiled where numba is there, for many dampings.

    The damping is negative where the slip does not return without any. One that is not computed among many is
    confirmed by the slip from P, which returns with a little less of it, and does not with a little more.

    Raises as `orbit_damping_ratio`, and `NotConverged` where the slip does something else.
    """
    system = NondimensionalOscillator.of(law, osc)
    zeta, error = orbit_damping_ratio(system, rtol=min(rtol, DAMPING_RTOL), fast=fast)
    unit = 2 * osc.impedance
    if not fast:
        _confirm(system, zeta, ERRORS_OF_CLEAR_SIGN * error)
    return zeta * unit, error * unit


def _confirm(system: NondimensionalOscillator, zeta: float, off: float) -> None:
    """Follow the slip from P at damping ratios on both sides of the threshold.

    They are as far from it as the errors of the slip itself, whose steps are not those of the two halves. One that
    takes many steps, as where it creeps to rest, neither confirms nor refutes.
    """
    largest = abs(zeta) + abs(system.push(1)) + abs(system.eta * system.table.rise(system.V))
    if max(off, largest) == 0.0:  # nothing but the spring acts, and all orbits are closed
        return
    errors = ADDED * (largest + _OF_SPRING)  # of a slip, over the tolerance of its steps
    off = max(off, STEP_ERRORS * errors * PRECISE)
    steps = off / (STEP_ERRORS * errors)
    while refuted := _refuted(system, zeta, off, steps):
        # By rounding it may be: where friction is strong it adds up along a slip, whatever the steps.
        if off > PARTED * largest:
            raise NotConverged(
                f"two ways to the threshold disagree at eta = {system.eta:g} and V = {system.V:g} m/s: both "
                f"halves of the grazing orbit meet at the damping ratio {zeta:.10g}, but {refuted} to the belt's "
                "speed; try another rtol"
            )
        off *= ERRORS_OF_CLEAR_SIGN


def _refuted(system: NondimensionalOscillator, zeta: float, off: float, steps: float) -> str:
    """Return what the slip from P does, and does not if the threshold is true, at a distance; or nothing."""
    ratios = np.array([zeta - off, zeta + off])
    slips = system.slips(
        np.zeros(2), np.zeros(2), ratios=(system.eta, ratios), until=SlipEnd.MINIMUM, level=1.0, rtol=steps,
        most=_MOST_FATE_STEPS,
    )  # fmt: skip
    check_time()
    fates = (
        ((SlipEnd.MINIMUM, SlipEnd.REST), "does not return"),
        ((SlipEnd.RETURN,), "returns"),
    )
    for ratio, end, (refuting, does) in zip(ratios, slips.end, fates, strict=True):
        if end in refuting:
            return f"at {ratio:.10g} the slip from P {does}"
    return ""


def grazing_sensitivity(law: FrictionLaw, osc: Oscillator) -> dict[str, float]:
    """Return dc/dp at the threshold for V, N, m, k and every parameter of the law.

    Raises as `orbit_damping_ratio`, and `NotConverged` where the halves do not meet within rounding.
    """
    bound = law.bound
    system = NondimensionalOscillator.of(bound, osc)
    zeta, error = orbit_damping_ratio(system)
    rise = system.rise
    eta = system.eta
    V = osc.V
    push = system.push(1)
    damped = replace(system, zeta=zeta + error)
    wedge = system.difference._replace(linear=-2.0)
    highest = damped.slip(0.0, 0.0, until=SlipEnd.MAXIMUM).w
    near = [i for i, w in enumerate(rise.levels[:-1]) if rise.jumps[i] and abs(w - highest) <= SAME_AMPLITUDE * w]
    parted = bool(near) and abs(velocity_mismatch_at(replace(system, zeta=zeta), 1.0, rtol=TIGHT).value) > PARTED

    def derivative(source: Wedge) -> float:
        if parted:
            check_time()
            top = damped.slip(0.0, 0.0, until=SlipEnd.MAXIMUM, wedge=(source, 0.0))
            return top.wedge / (1.0 - top.w) - source.shifts[near[0]]
        return velocity_mismatch_at(replace(system, zeta=zeta), 1.0, rtol=TIGHT, wedge=source).slope

    unit = 2 * osc.impedance
    slope = derivative(wedge)
    if not slope < 0.0:  # no number, or 0 where a half creeps to rest
        raise NotConverged(
            f"how the threshold changes is not known at eta = {eta:g} and V = {V:g} m/s: friction is so strong "
            "that the halves of the grazing orbit do not meet in double precision; try an average of the slope"
        )
    levels = [level * V for level in rise.levels[: len(rise.jumps)]]
    still = [0.0] * len(levels)
    friction = 1 / (V * osc.impedance)  # deta/dN
    excess = push / eta if eta else 0.0
    sources = {
        "V": Wedge(
            -push / V, 0.0, -eta / V, _changes_with_belt_speed(rise.pieces), [-level / V / V for level in levels]
        ),
        "N": Wedge(excess * friction, 0.0, -friction, rise.pieces, still),
    }
    if eta < VANISHING and 0.0 < abs(osc.N * derivative(sources["N"])) < ROUNDING:
        raise NotConverged(
            f"how the threshold changes is not known at eta = {eta:g} and V = {V:g} m/s: friction is so weak that "
            "its changes are lost in rounding; try an average of the slope"
        )
    for name, parameter in law.parameters.items():
        symbol = parameter.symbol
        partial = law.partial(name).bound.table_up_to(_TABULATED_OVER_HIGHEST * highest * V)
        onset = bound.number(rate(law.static_expr, symbol)) - partial.onset
        moves = [(bound.number(place), bound.number(rate(place, symbol)) / V) for place in places(law.expr)]
        shifts = [
            next((by for v, by in moves if math.isclose(v, level, rel_tol=SAME_AMPLITUDE)), 0.0)
            for level in levels
        ]
        sources[name] = Wedge(eta * onset, 0.0, -eta, partial.at(V).pieces, shifts)
    by = {name: -derivative(source) / slope * unit for name, source in sources.items()}
    by_impedance = (zeta * unit - osc.N * by["N"]) / 2  # c/sqrt(k m) depends on N/sqrt(k m) alone
    return by | {"m": by_impedance / osc.m, "k": by_impedance / osc.k}


def _changes_with_belt_speed(pieces: Pieces) -> list[tuple[float, ...]]:
    """Return the polynomials of w f'(w) - f(w) for those of f: how a rise over V changes with V, times V."""
    rows = []
    for low, origin, scale, *row in pieces:
        slope = [(k + 1) * c for k, c in enumerate(row[1:])] + [0.0]
        row = [origin * scale * s + (k - 1) * c for k, (s, c) in enumerate(zip(slope, row, strict=True))]
        rows.append((low, origin, scale, *row))
    return rows

"""Which motions an oscillator has: rest, stick-slip, pure slip, and where one ends and another begins.

Damping rotates the field of directions one way, so the transit from P, where every forward stick phase ends,
returns to the belt's speed for c below one threshold and not above. Rest attracts for c above -N mu'(V). Neither
excludes the other: between the two thresholds rest and stick-slip coexist, or a pure-slip limit cycle takes the
place of both.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stickslip_sym.cycles import LimitCycle
from stickslip_sym.friction import FrictionLaw
from stickslip_sym.oscillator import Oscillator, Scene, check_rtol
from stickslip_sym.slip import Point, SlipPhase, follow
from stickslip_sym.slip_orbits import SlipOrbits, next_peak, overtaking_cycle, slip_orbits
from stickslip_sym.transit import StickSlipCycle, lowest_slip_speed, stick_slip_cycle

__all__ = ["Regime", "Rest", "Separatrix", "graze", "regime"]

_SAMPLES = 257  # of a separatrix
_LONGEST = 1e3  # of dimensionless time, for a separatrix
_CLOSE = 1e-6  # slip speed over the belt's at a graze, below which its error is measured
_ROUNDING = 1e-14  # of a damping coefficient's terms


@dataclass(frozen=True)
class Rest:
    """The equilibrium, at which the belt slips under a mass that does not move.

    Attributes
    ----------
    x : float
        Displacement N mu(V)/k in m.
    rate : float
        Growth rate of small motions in 1/s, the larger real part of the two eigenvalues.
    stable : bool
        Whether it is negative, c > -N mu'(V).
    """

    x: float
    rate: float
    stable: bool

    def __str__(self) -> str:
        return f"rest at x = {self.x:.6g} m"


@dataclass(frozen=True)
class Separatrix:
    """A curve in the phase plane that parts two basins of attraction.

    Attributes
    ----------
    x, v : numpy.ndarray
        Displacement in m and velocity in m/s along it.
    kind : str
        "limit cycle": an unstable one, closed; "graze": the orbit that just touches the belt's speed, closed by
        the piece of the line v = V between its ends.
    """

    x: Any
    v: Any
    kind: str


@dataclass(frozen=True)
class Regime:
    """Every motion that an oscillator has.

    Attributes
    ----------
    rest : Rest
    stick_slip : StickSlipCycle or None
    cycles : tuple of LimitCycle
        All pure-slip limit cycles by ascending amplitude, unstable ones too; the last may overtake the belt.
    separatrices : tuple of Separatrix
        From inside out. With a negative damping that of motions without bound is not among them.
    unbounded : bool
        Whether motions far out grow without bound: a negative damping that friction does not outdo.
    undecided : tuple of str
        What lies within the tolerance of a boundary, in words; empty as a rule.
    """

    rest: Rest
    stick_slip: StickSlipCycle | None
    cycles: tuple[LimitCycle, ...]
    separatrices: tuple[Separatrix, ...]
    unbounded: bool
    undecided: tuple[str, ...]

    @property
    def attractors(self) -> tuple[Rest | LimitCycle | StickSlipCycle, ...]:
        """The motions that attract others, from inside out."""
        found: list[Rest | LimitCycle | StickSlipCycle] = [self.rest] if self.rest.stable else []
        found += [cycle for cycle in self.cycles if cycle.stable]
        return tuple(found if self.stick_slip is None else [*found, self.stick_slip])

    @property
    def coexist(self) -> bool:
        """Whether there is more than one attractor, so that the start decides."""
        return len(self.attractors) > 1

    def __str__(self) -> str:
        lines = [_in_words(attractor) for attractor in self.attractors]
        if self.unbounded:
            lines.append("motions far out grow without bound: the damping is negative")
        return "\n".join([*(lines or ["no attractor"]), *(f"undecided: {text}" for text in self.undecided)])


def _in_words(motion: Rest | LimitCycle | StickSlipCycle) -> str:
    if isinstance(motion, Rest):
        return str(motion)
    if isinstance(motion, LimitCycle):
        return f"pure slip with a highest velocity of {motion.amplitude:.6g} m/s, period {motion.period:.6g} s"
    return f"stick-slip of period {motion.period:.6g} s, of which stick {motion.stick_time:.6g} s"


def regime(law: FrictionLaw, osc: Oscillator, *, rtol: float = 1e-12) -> Regime:
    """Return every attractor of an oscillator, and the separatrices where there are several.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.

    Raises
    ------
    InputError
        For an unbound law or an unusable tolerance.
    NotConverged
        When the bound on the work is reached.
    """
    check_rtol(rtol)
    scene = Scene.of(law, osc)
    orbits = slip_orbits(law, osc, rtol=rtol)
    height = graze(scene, rtol)
    undecided = []
    if height == 0:
        undecided.append("the slip from P grazes the belt's speed within the error of the integration")
    growth = -(osc.c + osc.N * law.slope(osc.V)) / (2 * osc.m)
    if 0 in orbits.growth:
        undecided.append("slip orbits neither grow nor shrink")
    elif abs(2 * osc.m * growth) <= _ROUNDING * (abs(osc.c) + osc.N * abs(law.slope(osc.V))):
        undecided.append("rest neither attracts nor repels to first order")
    cycle = stick_slip_cycle(law, osc, rtol=rtol) if height < 0 else None
    overtaking = overtaking_cycle(law, osc, rtol=rtol) if height < 0 and cycle is None else None
    return Regime(
        rest=_rest(law, osc, growth),
        stick_slip=cycle,
        cycles=orbits.cycles if overtaking is None else (*orbits.cycles, overtaking),
        separatrices=tuple(_separatrices(scene, osc, law, orbits, cycle is not None, rtol)),
        unbounded=_unbounded(law, osc),
        undecided=tuple(undecided),
    )


def graze(scene: Scene, rtol: float) -> float:
    """Return the least slip speed, over V, after the slip from P: negative if it returns, 0 if none can tell.

    It is counted as 0 up to the tolerance, or if it changes by more than half of it when that is ten times wider.
    """
    lowest = lowest_slip_speed(scene, rtol)
    if lowest is None:
        return 1.0
    if abs(lowest) > _CLOSE:
        return lowest
    loose = lowest_slip_speed(scene, 10 * rtol)
    lost = loose is None or abs(loose - lowest) >= abs(lowest) / 2
    return 0.0 if lost or abs(lowest) <= rtol else lowest


def _rest(law: FrictionLaw, osc: Oscillator, growth: float) -> Rest:
    swing = growth**2 - osc.omega**2
    if swing <= 0:
        rate = growth
    else:
        rate = growth + math.sqrt(swing) if growth > 0 else osc.omega**2 / (growth - math.sqrt(swing))
    return Rest(osc.N * float(law.mu(osc.V)) / osc.k, rate, growth < 0)


def _unbounded(law: FrictionLaw, osc: Oscillator) -> bool:
    """Whether a negative damping outdoes friction at all high speeds."""
    if osc.c >= 0:
        return False
    if law.v_max is not None:
        return True
    fast = osc.V * np.logspace(6, 12, 3)
    return bool(np.all(osc.c + osc.N * law.mu(fast) / fast < 0))


def _separatrices(
    scene: Scene, osc: Oscillator, law: FrictionLaw, orbits: SlipOrbits, sticks: bool, rtol: float
) -> Iterator[Separatrix]:
    onset = osc.onset(law)

    def curve(slip: SlipPhase, kind: str, forward: int = 1) -> Separatrix:
        q, w = slip.at(np.linspace(slip.pieces[0].start.tau, slip.last.tau, _SAMPLES))
        return Separatrix(onset + osc.length * forward * q, osc.V * (1 - w), kind)

    for cycle in orbits.cycles:
        if not cycle.stable:
            yield curve(next_peak(scene, cycle.amplitude / osc.V, rtol)[1], "limit cycle")
    if sticks and orbits.growth[-1] < 0:
        # With time reversed and q mirrored the equations keep their form; friction and damping change sign.
        fold = scene.eta * (scene.static - scene.mu(0.0))
        backward = replace(scene, eta=-scene.eta, zeta=-scene.zeta)
        yield curve(follow(backward, Point(0.0, fold, 0.0), 1, horizon=_LONGEST, rtol=rtol), "graze", -1)

"""Which motions an oscillator has: rest, stick-slip, pure slip, and where one ends and another begins.

Damping rotates the field of directions one way, so the transit from P, where every forward stick phase ends,
returns to the belt's speed for c below one threshold and not above. Rest attracts for c above -N mu'(V). Neither
excludes the other: between the two thresholds rest and stick-slip coexist, or a pure-slip limit cycle takes the
place of both.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator, Scene
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.slip_orbits import SlipOrbits, next_peak, overtaking_cycle, slip_orbits
from stickslip_sym.motion.simulation.slip import follow
from stickslip_sym.motion.simulation.slip_phase import End, SlipPhase
from stickslip_sym.motion.simulation.steppers import Point
from stickslip_sym.motion.simulation.transit import StickSlipCycle, lowest_slip_speed, stick_slip_cycle
from stickslip_sym.output import drawing, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Attractor", "Regime", "Rest", "Separatrix", "graze", "grows_far_out", "regime", "swing"]

_SAMPLES = 257  # of a separatrix
_LONGEST = 1e3  # of dimensionless time, for a separatrix
_CLOSE = 1e-6  # slip speed over the belt's at a graze, below which its error is measured
_ROUNDING = 1e-14  # of a damping coefficient's terms
_SAME = 1e-12  # relative, of speeds and of coefficients of friction
_FAST = 1e12  # slip speed over the belt's, beyond every feature of a law: it stands for all that are higher


@dataclass(frozen=True)
class Rest:
    """The equilibrium, at which the belt slips under a mass that does not move.

    Attributes
    ----------
    x : float
        Displacement N mu(V)/k in m.
    rate : float
        Growth rate of small motions in 1/s, the larger real part of the two eigenvalues. Where mu has a kink at
        V it is the mean over the two halves of a swing, and infinite where mu jumps.
    stable : bool
        Whether it is negative, c > -N mu'(V).
    one_sided : bool
        Whether slower or faster motions come to it, though it is not stable: mu has a kink at V.
    """

    x: float
    rate: float
    stable: bool
    one_sided: bool = False

    def __str__(self) -> str:
        return f"rest at x = {self.x:.6g} m"

    def __repr__(self) -> str:
        return f"Rest: {self}, {'stable' if self.stable else 'unstable'}, growth rate {self.rate:.6g} 1/s"


Attractor = Rest | LimitCycle | StickSlipCycle
SeparatrixKind = Literal["limit cycle", "graze"]


@dataclass(frozen=True)
class Separatrix:
    """A curve in the phase plane that parts two basins of attraction.

    Attributes
    ----------
    x, v : numpy.ndarray
        Displacement in m and velocity in m/s along it.
    kind : str
        "limit cycle": an unstable one, closed; "graze": the orbit that just touches the belt's speed, closed by
        the part of the line v = V between its ends.
    """

    x: FloatArray
    v: FloatArray
    kind: SeparatrixKind

    def __repr__(self) -> str:
        return f"Separatrix: {self.kind}, {len(self.x)} points"


@dataclass(frozen=True)
class Regime(drawing.Drawn):
    """Every motion that an oscillator has.

    Attributes
    ----------
    rest : Rest
    stick_slip : StickSlipCycle or None
    cycles : tuple of LimitCycle
        All pure-slip limit cycles by ascending amplitude, unstable ones too; the last may overtake the belt.
    separatrices : tuple of Separatrix
        From inside out. That of motions without bound, where there are any, is not among them.
    unbounded : bool
        Whether motions far out grow without bound: a negative damping that friction does not outdo, or a
        coefficient of friction that falls below 0 for good.
    undecided : tuple of str
        What lies within the tolerance of a boundary, or was not found within the time limit, in words; empty as
        a rule.
    law, oscillator : FrictionLaw, Oscillator
        Whose motions they are.
    """

    rest: Rest
    stick_slip: StickSlipCycle | None
    cycles: tuple[LimitCycle, ...]
    separatrices: tuple[Separatrix, ...]
    unbounded: bool
    undecided: tuple[str, ...]
    law: FrictionLaw | None = None
    oscillator: Oscillator | None = None

    @property
    def attractors(self) -> tuple[Attractor, ...]:
        """The motions that attract others, from inside out."""
        found: list[Attractor] = [self.rest] if self.rest.stable else []
        found += [cycle for cycle in self.cycles if cycle.stable]
        return tuple(found if self.stick_slip is None else [*found, self.stick_slip])

    @property
    def coexist(self) -> bool:
        """Whether there is more than one attractor, so that the start decides."""
        return len(self.attractors) > 1

    def __str__(self) -> str:
        lines = [str(attractor) for attractor in self.attractors]
        if self.unbounded:
            lines.append("motions far out grow without bound: damping and friction feed them")
        return "\n".join([*(lines or ["no attractor"]), *(f"undecided: {text}" for text in self.undecided)])

    def __repr__(self) -> str:
        return f"Regime: {'; '.join(str(self).splitlines())}"

    def _repr_html_(self) -> str:
        motions = [self.rest, *self.cycles, *([] if self.stick_slip is None else [self.stick_slip])]
        attracting = self.attractors
        rows = [[str(motion), "attracts" if motion in attracting else "does not attract"] for motion in motions]
        notes = [*(["motions far out grow without bound"] if self.unbounded else []), *self.undecided]
        table = markup.table(["motion", "neighbours"], rows, caption="motions")
        return markup.block(drawing.picture(self.plot, "; ".join(row[0] for row in rows)), table, *notes)

    def _figure(self) -> "Figure":
        from stickslip_sym.motion.regimes.drawing import draw_regime

        return draw_regime(self)


def regime(law: FrictionLaw, osc: Oscillator, *, rtol: float = 1e-12, time_limit: float | None = None) -> Regime:
    """Return every attractor of an oscillator, and the separatrices where there are several.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which what is found is returned; `undecided` says what is not.

    Raises
    ------
    InputError
        For an unbound law or an unusable tolerance.
    NotConverged
        When the bound on the work is reached.
    """
    rtol = read_rtol(rtol)
    with deadline.time_limit(time_limit):
        return _found(law, osc, rtol)


def _found(law: FrictionLaw, osc: Oscillator, rtol: float) -> Regime:
    """Return what is found until the time is up: then every later part is left out, and named."""
    scene, undecided = Scene.of(law, osc), list[str]()
    rest = _rest(law, osc, scene)

    @contextmanager
    def part(name: str) -> Iterator[None]:
        try:
            yield
        except OutOfTime:
            undecided.append(f"{name}: not found within the time limit")

    orbits = overtaking = cycle = None
    separatrices: list[Separatrix] = []
    height = 1.0
    with part("whether the slip from P returns, and stick-slip"):
        height = graze(scene, rtol)
        cycle = stick_slip_cycle(law, osc, rtol=rtol) if height < 0 else None
    with part("the limit cycles in pure slip"):
        orbits = slip_orbits(law, osc, rtol=rtol)
    if height == 0:
        undecided.append("the slip from P grazes the belt's speed within the error of the integration")
    if orbits is not None and 0 in orbits.growth:
        undecided.append("slip orbits neither grow nor shrink")
    elif abs(rest.rate) * 2 * osc.m <= _ROUNDING * (abs(osc.c) + osc.N * abs(law.slope(osc.V))):
        undecided.append("rest neither attracts nor repels to first order")
    if rest.one_sided:
        undecided.append("rest attracts motions on one side of it, and repels those on the other")
    elif orbits is not None and rest.rate * orbits.growth[0] < 0:
        kind = "a stable" if rest.rate > 0 else "an unstable"
        undecided.append(f"{kind} limit cycle about rest is too small to find")
    with part("limit cycles that overtake the belt"):
        overtaking = overtaking_cycle(law, osc, rtol=rtol) if height < 0 and cycle is None else None
    with part("separatrices"):
        for separatrix in _separatrices(scene, osc, law, orbits, cycle is not None, rtol) if orbits else ():
            separatrices.append(separatrix)
    return Regime(
        rest=rest,
        stick_slip=cycle,
        cycles=(*(orbits.cycles if orbits else ()), *([] if overtaking is None else [overtaking])),
        separatrices=tuple(separatrices),
        unbounded=grows_far_out(law, osc),
        undecided=tuple(undecided),
        law=law,
        oscillator=osc,
    )


def graze(scene: Scene, rtol: float) -> float:
    """Return the first minimum of the slip speed, over V, after P: 0 where integration cannot tell its sign.

    Where the mass returns it is negative, and -infinity where it moves away for ever, as `lowest_slip_speed` has
    it; where the mass creeps to rest it is 1. It counts as 0 up to the tolerance, and where a tolerance ten times
    wider changes it by half of itself or more.
    """
    lowest = lowest_slip_speed(scene, rtol)
    if lowest is None:
        return 1.0
    if abs(lowest) > _CLOSE:
        return lowest
    loose = lowest_slip_speed(scene, 10 * rtol)
    lost = loose is None or abs(loose - lowest) >= abs(lowest) / 2
    return 0.0 if lost or abs(lowest) <= rtol else lowest


def _rest(law: FrictionLaw, osc: Oscillator, scene: Scene) -> Rest:
    x = osc.N * float(law.mu(osc.V)) / osc.k
    kink = next((i for i, branch in enumerate(scene.branches) if abs(branch.low - 1) <= _SAME), None)
    if kink is None:
        rate, _ = swing(osc, law.slope(osc.V))
        return Rest(x, rate, rate < 0)
    before, after = (scene.onset + scene.branches[i].rise(1.0) for i in (kink - 1, kink))
    sides = [swing(osc, law.slope(osc.V * (1 + side * 10 * _SAME))) for side in (-1, 1)]
    ends_here = any(rate < 0 and math.isinf(time) for rate, time in sides)
    if abs(after - before) > _SAME * max(abs(before), abs(after)) and osc.N > 0:
        # Where mu jumps up it holds the mass as static friction does; where it jumps down it drives it off.
        return Rest(x, math.copysign(math.inf, before - after), after > before, before > after and ends_here)
    aperiodic = [rate for rate, time in sides if math.isinf(time)]
    if aperiodic:  # motions on that side do not come back from it
        rate = max(aperiodic)
        return Rest(x, rate, rate < 0, rate >= 0 and ends_here)
    rate = sum(rate * time for rate, time in sides) / sum(time for _, time in sides)
    return Rest(x, rate, rate < 0)


def swing(osc: Oscillator, slope: float) -> tuple[float, float]:
    """Return the growth rate of small motions where mu has a slope, and how long half a swing takes."""
    growth = -(osc.c + osc.N * slope) / (2 * osc.m)
    excess = (growth - osc.omega) * (growth + osc.omega)
    if excess < 0:
        return growth, math.pi / math.sqrt(-excess)
    root = math.sqrt(excess)
    return (growth + root if growth > 0 else osc.omega**2 / (growth - root)), math.inf


def grows_far_out(law: FrictionLaw, osc: Oscillator) -> bool:
    """Whether damping and friction together feed motions at all high speeds."""
    if law.v_max is not None:
        return osc.c < 0
    fast = _FAST * osc.V
    return bool(osc.c + osc.N * law.mu(fast) / fast < 0)


def _separatrices(
    scene: Scene, osc: Oscillator, law: FrictionLaw, orbits: SlipOrbits, sticks: bool, rtol: float
) -> Iterator[Separatrix]:
    onset = osc.onset(law)

    def curve(slip: SlipPhase, kind: SeparatrixKind, forward: int = 1) -> Separatrix:
        q, w = slip.at(np.linspace(slip.interpolants[0].start.tau, slip.last.tau, _SAMPLES))
        return Separatrix(onset + osc.length * forward * q, osc.V * (1 - w), kind)

    for cycle in orbits.cycles:
        if not cycle.stable:
            yield curve(next_peak(scene, cycle.amplitude / osc.V, rtol)[1], "limit cycle")
    if sticks and orbits.growth[-1] < 0:
        # With time reversed and q mirrored the equations keep their form; friction and damping change sign.
        backward = replace(scene, eta=-scene.eta, zeta=-scene.zeta)
        slip = follow(backward, Point(0.0, backward.turn(0.0), 0.0), 1, horizon=_LONGEST, rtol=rtol)
        if slip.end is not End.UNBOUNDED:
            yield curve(slip, "graze", -1)

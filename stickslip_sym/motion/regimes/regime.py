"""Which motions an oscillator has: rest, stick-slip, pure slip, and where one ends and another begins.

Damping rotates the field of directions one way, so the transit from P, where every forward stick phase ends,
returns to the belt's speed for c below one threshold and not above. Rest attracts for c above -N mu'(V). Neither
excludes the other: between the two thresholds rest and stick-slip coexist, or a pure-slip limit cycle takes the
place of both.
"""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import ATTRACTORS
from stickslip_sym.motion.regimes.separatrix import Separatrix, SlipCurve
from stickslip_sym.motion.regimes.slip_orbits import lowest, next_peak, overtaking_cycle, slip_orbits
from stickslip_sym.motion.simulation.cycle import StickSlipCycle, stick_slip_cycle
from stickslip_sym.motion.slip import Dimensionless, End
from stickslip_sym.output import drawing, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Attractor",
    "Regime",
    "Rest",
    "friction_far_out",
    "graze",
    "grows_far_out",
    "regime",
    "separatrices_of",
    "swing",
]

_CLOSE = 1e-6  # slip speed over the belt's at a graze, below which its error is measured
_ROUNDING = 1e-14  # of a damping coefficient's terms
_SAME = 1e-12  # relative, of the belt's speed and a kink
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
    basins : tuple of Motion or None
        The motions to which those come that begin inside the first separatrix, between it and the second, ...,
        outside the last. None where separatrices do not settle it: a motion grows without bound or overtakes the
        belt, or mu jumps, so that motions may slide at a constant slip speed.
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
    basins: tuple[Motion, ...] | None
    unbounded: bool
    undecided: tuple[str, ...]
    law: FrictionLaw
    oscillator: Oscillator

    @property
    def attractors(self) -> tuple[Attractor, ...]:
        """The motions that attract others, from inside out."""
        return tuple(attractor for kind in ATTRACTORS for attractor in kind.of(self))

    @property
    def coexist(self) -> bool:
        """Whether there is more than one attractor, so that the initial condition decides."""
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


def regime(
    law: FrictionLaw | str, osc: Oscillator, *, rtol: float = 1e-12, time_limit: float | None = None
) -> Regime:
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
    law = as_law(law)
    rtol = read_rtol(rtol)
    with deadline.time_limit(time_limit):
        return _found(law, osc, rtol)


def _found(law: FrictionLaw, osc: Oscillator, rtol: float) -> Regime:
    """Return what is found until the time is up: then every later part is left out, and named."""
    system, undecided = Dimensionless.of(law, osc), list[str]()
    rest = _rest(law, osc, system)

    @contextmanager
    def part(name: str) -> Iterator[None]:
        try:
            yield
        except OutOfTime:
            undecided.append(f"{name}: not found within the time limit")

    orbits = overtaking = cycle = None
    height = 1.0
    with part("whether the slip from P returns, and stick-slip"):
        height = graze(system, rtol)
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
    separatrices, basins = list[Separatrix](), None
    with part("separatrices"):
        if orbits is not None:
            unstable = [one.amplitude for one in orbits.cycles if not one.stable]
            separatrices = separatrices_of(law, osc, unstable, cycle is not None and orbits.growth[-1] < 0, rtol)
    unbounded = grows_far_out(law, osc)
    if (
        orbits
        and not (undecided or unbounded or rest.one_sided or any(system.rise.jumps))
        and (height > 0 or cycle)
    ):
        bounds = [0.0, *unstable, osc.V]
        inside = [_motion_of(orbits.fate((low + high) / 2)) for low, high in pairwise(bounds)]
        if cycle is None or orbits.growth[-1] >= 0:
            basins = tuple(inside)
        elif len(separatrices) == len(inside) and separatrices[-1].curve_ends_on_belt:
            basins = (*inside, Motion.STICK_SLIP)
    return Regime(
        rest=rest,
        stick_slip=cycle,
        cycles=(*(orbits.cycles if orbits else ()), *([] if overtaking is None else [overtaking])),
        separatrices=tuple(separatrices),
        basins=basins,
        unbounded=unbounded,
        undecided=tuple(undecided),
        law=law,
        oscillator=osc,
    )


def graze(system: Dimensionless, rtol: float) -> float:
    """Return the first minimum of the slip speed, over V, after P: 0 where integration cannot tell its sign.

    Where the mass returns it is -w'^2/2, which continues the minimum through 0 with its value and its slope, and
    -infinity where the mass moves away for ever; where it creeps to rest it is 1. It counts as 0 up to the
    tolerance, and where a tolerance ten times wider changes it by half of itself or more.
    """
    height = lowest(system, rtol)
    if abs(height) > _CLOSE:
        return height
    lost = abs(lowest(system, 10 * rtol) - height) >= abs(height) / 2
    return 0.0 if lost or abs(height) <= rtol else height


def _rest(law: FrictionLaw, osc: Oscillator, system: Dimensionless) -> Rest:
    mu = float(law.mu(osc.V))
    x = osc.N * mu / osc.k
    levels = system.rise.levels
    kink = next((i for i in range(1, len(levels) - 1) if abs(levels[i] - 1) <= _SAME), None)
    if kink is None:
        rate, _ = swing(osc, law.slope(osc.V))
        return Rest(x, rate, rate < 0)
    jump = system.rise.jumps[kink]
    sides = [swing(osc, law.slope(osc.V * (1 + side * 10 * _SAME))) for side in (-1, 1)]
    ends_here = any(rate < 0 and math.isinf(time) for rate, time in sides)
    if jump != 0 and osc.N > 0:
        # Where mu jumps up it holds the mass as static friction does; where it jumps down it drives it off.
        return Rest(x, math.copysign(math.inf, -jump), jump > 0, jump < 0 and ends_here)
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
    return bool(osc.c + osc.N * friction_far_out(law, osc.V) < 0)


def friction_far_out(law: FrictionLaw, V: float) -> float:
    """Return mu(v)/v in s/m at slip speeds beyond every feature of a law; 0 if it is measured up to a speed."""
    if law.v_max is not None:
        return 0.0
    fast = _FAST * V
    return float(law.mu(fast)) / fast


def separatrices_of(
    law: FrictionLaw, osc: Oscillator, unstable: Sequence[float], grazes: bool, rtol: float
) -> list[Separatrix]:
    """Return the curves that part basins, from inside out.

    - `unstable`: amplitudes in m/s of the unstable limit cycles below the belt's speed.
    - `grazes`: whether the orbit that just touches the belt's speed parts motions that stick from others.
    """
    system, onset = Dimensionless.of(law, osc), osc.onset(law)
    curves = []
    for speed in unstable:
        _, _, slip = next_peak(system, speed / osc.V, rtol, recorded=True)
        curves.append(Separatrix("limit cycle", SlipCurve.of(system, slip, rtol), onset, osc))
    if grazes:
        slip = system.slip(system.turn(0.0), 0.0, rtol=rtol, backward=True, recorded=True)
        if slip.end is not End.OUTSIDE:
            curve = SlipCurve.of(system, slip, rtol, backward=True)
            curves.append(Separatrix("graze", curve, onset, osc))
    return curves


def _motion_of(fate: LimitCycle | float) -> Motion:
    """Return the motion that an orbit in slip tends to; one that grows up to the belt's speed comes to stick."""
    if isinstance(fate, LimitCycle):
        return Motion.PURE_SLIP
    return Motion.REST if fate == 0 else Motion.STICK_SLIP

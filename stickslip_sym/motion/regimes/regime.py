"""Which motions an oscillator has: rest, stick-slip, pure slip, and where one ends and another begins.

Damping rotates the field of directions one way, so the transit from P, where every forward stick phase ends,
returns to the belt's speed for c below one threshold and not above. Rest attracts for c above -N mu'(V). Neither
excludes the other: between the two thresholds rest and stick-slip coexist, or a pure-slip limit cycle takes the
place of both.
"""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray, ObjectArray
from stickslip_sym.core.errors import OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.regimes.attractors import ATTRACTORS
from stickslip_sym.motion.regimes.phase_plane import NEAR, PhasePlane, phase_plane
from stickslip_sym.motion.regimes.separatrix import Separatrix
from stickslip_sym.motion.simulation.cycle import StickSlipCycle
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.output import drawing, markup

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_ROUNDING = 1e-14  # of a damping coefficient's terms
_SAME = 1e-12  # relative, of the belt's speed and a kink
_SECONDS = 2.0  # of computation, for a curve that is a period of a motion
_RTOL = 1e-8
_GRAZE = "separatrix: orbit that touches the belt's speed"
_LOOKS: dict[str, dict[str, Any]] = {
    "stick-slip": {"color": "black", "linewidth": 2.2},
    "pure-slip cycle": {"color": "#009E73", "linewidth": 2.2},
    "pure-slip cycle, unstable": {"color": "#D55E00", "linewidth": 1.2, "linestyle": "--"},
    _GRAZE: {"color": "0.45", "linewidth": 1.2, "linestyle": "-."},
    "belt speed": {"color": "black", "linewidth": 0.8, "linestyle": ":", "zorder": 0},
}
_PARTS = {
    "whether the slip from P returns, and stick-slip": ("height", "stick_slip"),
    "the limit cycles in pure slip": ("slip_cycles", "growth"),
    "limit cycles that overtake the belt": ("overtaking",),
    "separatrices": ("separatrices",),
}
"""What a regime needs of the phase plane, in the order in which it is looked for, in words and by name."""


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
    rtol : float
        Relative tolerance of an integration step.
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
    rtol: float

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

    def draw(self, ax: "Axes") -> "list[Artist]":
        """Draw the phase plane, and return the handles of its legend: one of several curves of a kind."""
        law, osc = self.law, self.oscillator
        cycle = self.stick_slip
        periodic = [] if cycle is None else [("stick-slip", osc.onset(law), osc.V, cycle.period)]
        for one in self.cycles:
            # Where v is highest the forces are in balance; slower than the belt or faster, friction has its sign.
            slip = osc.V - one.amplitude
            force = osc.N * float(law.mu(abs(slip))) * (1 if slip >= 0 else -1)
            name = "pure-slip cycle" if one.stable else "pure-slip cycle, unstable"
            periodic.append((name, (force - osc.c * one.amplitude) / osc.k, one.amplitude, one.period))
        for name, x0, v0, period in periodic:
            motion = simulate(law, osc, t_end=period, x0=x0, v0=v0, rtol=_RTOL, time_limit=_SECONDS)
            state = motion.at(drawing.dense(np.unique(motion.t)))
            ax.plot(state.x, state.v, label=name, **_LOOKS[name])
        for curve in self.separatrices:
            if curve.kind == "graze":  # any other is drawn as the cycle that it is
                ax.plot(curve.x, curve.v, label=_GRAZE, **_LOOKS[_GRAZE])
        face, name = ("black", "rest") if self.rest.stable else ("white", "rest, unstable")
        ax.plot([self.rest.x], [0.0], "o", color="black", markerfacecolor=face, label=name)
        ax.axhline(osc.V, label="belt speed", **_LOOKS["belt speed"])
        ax.set(xlabel="displacement $x$ (m)", ylabel="velocity $\\dot x$ (m/s)")
        ax.locator_params(axis="x", nbins=6)
        ax.grid(alpha=0.25)
        handles, labels = ax.get_legend_handles_labels()
        return list(dict(zip(labels, handles, strict=True)).values())


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

    Examples
    --------
    >>> from stickslip_sym import Oscillator, laws, regime
    >>> print(regime(laws.exponential.typical(), Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)))
    rest at x = 0.0261867 m
    stick-slip of period 0.631968 s, of which stick 0.0453196 s
    """
    law, osc = as_law(law), as_oscillator(osc)
    rtol = read_rtol(rtol)
    with deadline.time_limit(time_limit):
        return _found(phase_plane(law, osc, rtol))


def by_side(found: Regime, x0: FloatArray, v0: FloatArray) -> ObjectArray:
    """Return what initial conditions lead to, arrays in m and m/s, by the separatrices that surround them.

    What begins outside all separatrices comes to stick, or goes round without sticking as P's orbit does, which
    lies outside them too: so does what begins faster than the belt, since it can only come down where the mass
    sticks, or farther out. It is None near a separatrix, and where separatrices do not settle the basins.
    """
    motions = np.full(np.broadcast_shapes(x0.shape, v0.shape), None, dtype=object)
    if found.basins is None:
        return motions
    osc = found.oscillator
    q, w = (x0 - osc.onset(found.law)) / osc.length, 1 - v0 / osc.V
    around, clear = np.zeros(motions.shape, dtype=np.intp), np.ones(motions.shape, dtype=bool)
    for separatrix in found.separatrices:
        inside = separatrix.curve.surrounds(q, np.where(w > 0, w, -1.0), NEAR * found.rtol)
        around += inside
        clear &= inside >= 0
    motions[clear] = np.array(found.basins[::-1], dtype=object)[around[clear]]
    return motions


def _found(plane: PhasePlane) -> Regime:
    """Return what is found until the time is up: then every later part is left out, and named."""
    law, osc, system = plane.law, plane.oscillator, plane.system
    parts, undecided = dict[str, Any](), list[str]()
    for words, names in _PARTS.items():
        try:
            parts |= {name: getattr(plane, name) for name in names}
        except OutOfTime:
            undecided.append(f"{words}: not found within the time limit")
    rest, height, growth = _rest(plane), parts.get("height", 1.0), parts.get("growth", ())
    cycles, separatrices = parts.get("slip_cycles", ()), parts.get("separatrices", ())
    cycle, overtaking = parts.get("stick_slip"), parts.get("overtaking")
    if height == 0:
        undecided.append("the slip from P grazes the belt's speed within the error of the integration")
    if 0 in growth:
        undecided.append("slip orbits neither grow nor shrink")
    elif abs(rest.rate) * 2 * osc.m <= _ROUNDING * (abs(osc.c) + osc.N * abs(law.slope(osc.V))):
        undecided.append("rest neither attracts nor repels to first order")
    if rest.one_sided:
        undecided.append("rest attracts motions on one side of it, and repels those on the other")
    elif growth and rest.rate * growth[0] < 0:
        kind = "a stable" if rest.rate > 0 else "an unstable"
        undecided.append(f"{kind} limit cycle about rest is too small to find")
    basins = None
    if not (undecided or plane.unbounded or any(system.rise.jumps)) and (height > 0 or cycle):
        unstable = [place for place, one in enumerate(cycles, 1) if not one.stable]
        grazes = cycle is not None and growth[-1] < 0
        basins = (*(plane.fate(place) for place in (0, *unstable)), *([Motion.STICK_SLIP] * grazes))
        if len(separatrices) < len(basins) - 1 or (grazes and not separatrices[-1].ends_on_belt):
            basins = None
    return Regime(
        rest, cycle, (*cycles, *([overtaking] if overtaking else [])), separatrices, basins, plane.unbounded,
        tuple(undecided), law, osc, plane.rtol,
    )  # fmt: skip


def _rest(plane: PhasePlane) -> Rest:
    law, osc, rise = plane.law, plane.oscillator, plane.system.rise
    x = osc.N * float(law.mu(osc.V)) / osc.k
    levels = rise.levels
    kink = next((i for i in range(1, len(levels) - 1) if abs(levels[i] - 1) <= _SAME), None)
    if kink is None:
        rate, _ = _swing(osc, law.slope(osc.V))
        return Rest(x, rate, rate < 0)
    jump = rise.jumps[kink]
    sides = [_swing(osc, law.slope(osc.V * (1 + side * 10 * _SAME))) for side in (-1, 1)]
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


def _swing(osc: Oscillator, slope: float) -> tuple[float, float]:
    """Return the growth rate of small motions where mu has a slope, and how long half a swing takes."""
    growth = -(osc.c + osc.N * slope) / (2 * osc.m)
    excess = (growth - osc.omega) * (growth + osc.omega)
    if excess < 0:
        return growth, math.pi / math.sqrt(-excess)
    root = math.sqrt(excess)
    return (growth + root if growth > 0 else osc.omega**2 / (growth - root)), math.inf

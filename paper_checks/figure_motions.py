"""Figures 3, 4, 5, 8 and 9: motions of the mass, computed with every event resolved."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from paper_checks.computed import law as paper_law
from paper_checks.computed import oscillator, response, threshold
from stickslip_sym import FrictionLaw, Oscillator, Phase, limit_cycles, simulate
from stickslip_sym.motion.orbits.cycles import LimitCycle
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.views.drawing import BLUE, ORANGE, finish, new_figure, panel_letters

PAPER = {"color": "black", "linewidth": 1.1}
"""How a line looks that the paper shows; what it leaves out is coloured, and thicker or dash-dotted."""
_LEFT_OUT: dict[str, Any] = {"color": BLUE, "linewidth": 1.3, "linestyle": (0, (6, 1.5, 1, 1.5))}

_SHOWN = 5.0  # s, as in the paper
_RTOL = 1e-9  # relative tolerance of a step: errors stay far below a line's width
_SAME = 1e-2  # distance of P and Q over V, below which the eye sees one point
_APART = 0.005  # s between points drawn; a period has 0.63 s
_STICK = {"color": "black", "linewidth": 2.6, "solid_capstyle": "butt"}


@dataclass(frozen=True)
class Piece:
    """A phase of a motion, sampled finely enough to be drawn."""

    phase: Phase
    t: Any
    x: Any
    v: Any


def pieces(motion: Trajectory) -> list[Piece]:
    """Split a motion into its phases."""
    found = []
    for stretch in motion.stretches:
        if stretch.end > stretch.start:
            steps = 1 if stretch.phase is Phase.STICK else math.ceil((stretch.end - stretch.start) / _APART)
            t = np.linspace(stretch.start, stretch.end, steps + 1)
            found.append(Piece(stretch.phase, t, *stretch.course(t)))
    return found


def fate(name: str, c: float, cycles: tuple[LimitCycle, ...]) -> str:
    """Say what becomes of a motion in the long run."""
    run = response(name, c)
    if run.kind == "stick-slip":
        return "sticks and slips for ever"
    stable = [cycle.amplitude for cycle in cycles if cycle.stable]
    if stable:
        return f"tends to a slip cycle, {stable[-1]:.4f} m/s"
    half = run.times[np.argmax(run.peaks < run.peaks[0] / 2)]
    return f"comes to rest, half way at {half:.1f} s"


def histories(name: str, dampings: tuple[float, ...]) -> Any:
    """Draw the velocity over time for several dampings: as in the paper, and what comes later."""
    law = paper_law(name)
    figure, axes = new_figure(
        7.2, 8.6, len(dampings), 2, sharex="col", sharey=True, gridspec_kw={"width_ratios": (2, 1)}
    )
    for (left, right), c in zip(axes, dampings, strict=True):
        osc = oscillator(c)
        for part in pieces(simulate(law, osc, t_end=_SHOWN, rtol=_RTOL)):
            left.plot(part.t, part.v, **(_STICK if part.phase is Phase.STICK else PAPER))
        run = response(name, c)
        right.plot(run.times, run.peaks, color=BLUE, linewidth=1.3, marker=".", markersize=2.5, linestyle="none")
        finish(left, xlim=(0, _SHOWN), ylim=(-1.0, 0.75), ylabel=r"$\dot{x}$ (m/s)")
        finish(right, xlim=(0, run.times[-1]))
        right.text(
            0.04, 0.06, fate(name, c, limit_cycles(law, osc)), transform=right.transAxes, color=BLUE, fontsize=8.5
        )
    panel_letters(axes[:, 0], [f"$c$ = {c:g} kg/s" for c in dampings])
    axes[0, 1].set_title("left out: peaks in the long run", loc="left", pad=4, color=BLUE)
    for ax in axes[-1]:
        ax.set_xlabel("$t$ (s)")
    return figure


def phase_plots(name: str, cases: tuple[tuple[str, float, float], ...]) -> Any:
    """Draw phase plots of a law for cases of a title, c in kg/s and V in m/s."""
    law = paper_law(name)
    figure, axes = new_figure(7.2, 2.9 if len(cases) == 3 else 3.5, 1, len(cases), sharex=True, sharey=True)
    titles = []
    for position, (ax, (title, c, V)) in enumerate(zip(axes[0], cases, strict=True)):
        osc = oscillator(c, V)
        for part in pieces(simulate(law, osc, t_end=_SHOWN, rtol=_RTOL)):
            ax.plot(part.x, part.v, **(_STICK if part.phase is Phase.STICK else PAPER | {"linewidth": 0.9}))
        onset = osc.onset(law)
        speed = response(name, c, V).after_a_cycle
        same = V - speed < _SAME * V
        for place, v in [("$P$, $Q$", V)] if same else [("$P$", V), ("$Q$", speed)]:
            ax.plot(onset, v, "o", color="black", markersize=4)
            ax.annotate(place, (onset, v), xytext=(2, -10 if v < V else 4), textcoords="offset points")
        _left_out(ax, law, osc, threshold(name, V))
        finish(ax, xlabel="$x$ (m)")
        titles.append(f"{title}\n$c$ = {c:g} kg/s, $V$ = {V:g} m/s")
        if position == 0:
            ax.set_ylabel(r"$\dot{x}$ (m/s)")
    fastest = max(V for _, _, V in cases)
    ax.set_ylim(-2.0 * fastest, 1.8 * fastest)  # for words above and below
    panel_letters(axes[0], titles)
    return figure


def _left_out(ax: Any, law: FrictionLaw, osc: Oscillator, needed: float) -> None:
    """Add the equilibrium and the pure-slip limit cycles, and say what is stable."""
    rest = osc.N * float(law.mu(osc.V)) / osc.k
    holds = -osc.N * float(law.slope(osc.V)) < osc.c
    ax.plot(rest, 0, marker="+", markersize=8, markeredgewidth=1.4, color=BLUE)
    cycles = limit_cycles(law, osc)
    for cycle in cycles:
        style = _LEFT_OUT | {"linestyle": "-"} if cycle.stable else _LEFT_OUT
        for part in pieces(_one_period(law, osc, cycle)):
            ax.plot(part.x, part.v, **style)
    words = [f"rest {'stable' if holds else 'unstable'}"]
    words += [f"slip cycle {'stable' if cycle.stable else 'unstable'}" for cycle in cycles]
    words.append(f"threshold {needed:.4f} kg/s")
    ax.text(0.03, 0.03, "\n".join(words), transform=ax.transAxes, color=BLUE, fontsize=8.5)
    if holds and osc.c < needed:
        both = "rest or stick–slip, by the initial condition"
        ax.text(0.03, 0.96, both, transform=ax.transAxes, color=ORANGE, va="top", fontsize=8.5)


def _one_period(law: FrictionLaw, osc: Oscillator, cycle: LimitCycle) -> Trajectory:
    """Simulate one period of a limit cycle from its highest velocity, where the forces balance."""
    v = cycle.amplitude
    x = (osc.N * float(law.mu(osc.V - v)) - osc.c * v) / osc.k
    return simulate(law, osc, t_end=cycle.period, x0=x, v0=v)

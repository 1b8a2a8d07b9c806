"""The phase plane of a regime: rest, every periodic motion, and the curves that part their basins."""

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.output.drawing import dense

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

__all__ = ["phase_plane_of"]

_SECONDS = 2.0  # of computation, for a curve that is a period of a motion
_RTOL = 1e-8
_LOOKS: dict[str, dict[str, Any]] = {
    "stick-slip": {"color": "black", "linewidth": 2.2},
    "pure-slip cycle": {"color": "#009E73", "linewidth": 2.2},
    "pure-slip cycle, unstable": {"color": "#D55E00", "linewidth": 1.2, "linestyle": "--"},
    "separatrix: orbit that touches the belt's speed": {"color": "0.45", "linewidth": 1.2, "linestyle": "-."},
    "belt speed": {"color": "black", "linewidth": 0.8, "linestyle": ":", "zorder": 0},
}


def phase_plane_of(ax: "Axes", found: Any) -> "list[Artist]":
    """Draw a regime in the phase plane, and return what its legend has: one of several curves of a kind."""
    law, osc = found.law, found.oscillator

    def draw(name: str, x: Any, v: Any) -> None:
        ax.plot(x, v, label=name, **_LOOKS[name])

    def draw_period(name: str, x0: float, v0: float, period: float) -> None:
        motion = simulate(law, osc, t_end=period, x0=x0, v0=v0, rtol=_RTOL, time_limit=_SECONDS)
        state = motion.at(dense(np.unique(motion.t)))
        draw(name, state.x, state.v)

    if found.stick_slip is not None:
        draw_period("stick-slip", osc.onset(law), osc.V, found.stick_slip.period)
    for cycle in found.cycles:
        # Where v is highest the forces are in balance; slower than the belt or faster, friction has its sign.
        slip = osc.V - cycle.amplitude
        force = osc.N * float(law.mu(abs(slip))) * (1 if slip >= 0 else -1)
        name = "pure-slip cycle" if cycle.stable else "pure-slip cycle, unstable"
        draw_period(name, (force - osc.c * cycle.amplitude) / osc.k, cycle.amplitude, cycle.period)
    for curve in found.separatrices:
        if curve.kind == "graze":  # any other is drawn as the cycle that it is
            draw("separatrix: orbit that touches the belt's speed", curve.x, curve.v)
    face, name = ("black", "rest") if found.rest.stable else ("white", "rest, unstable")
    ax.plot([found.rest.x], [0.0], "o", color="black", markerfacecolor=face, label=name)
    ax.axhline(osc.V, label="belt speed", **_LOOKS["belt speed"])
    ax.set(xlabel="displacement $x$ (m)", ylabel="velocity $\\dot x$ (m/s)")
    ax.locator_params(axis="x", nbins=6)
    ax.grid(alpha=0.25)
    handles, labels = ax.get_legend_handles_labels()
    return list(dict(zip(labels, handles, strict=True)).values())

"""The phase plane of a regime: rest, every periodic motion, and the curves that part their basins."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.simulation.simulate import simulate
from stickslip_sym.motion.simulation.trajectory import Trajectory
from stickslip_sym.output.drawing import dense, require_matplotlib

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_regime", "phase_plane"]

Style = dict[str, Any]
_SECONDS = 2.0  # of computation, for a curve that is a period of a motion
_RTOL = 1e-8
_STICK_SLIP: Style = {"color": "black", "linewidth": 2.2}
_STABLE: Style = {"color": "#009E73", "linewidth": 2.2}
_UNSTABLE: Style = {"color": "#D55E00", "linewidth": 1.2, "linestyle": "--"}
_SEPARATRIX: Style = {"color": "0.45", "linewidth": 1.2, "linestyle": "-."}
_BELT: Style = {"color": "black", "linewidth": 0.8, "linestyle": ":"}


def draw_regime(found: Any) -> "Figure":
    """Return the figure of a regime.

    Raises `InputError` if matplotlib is not installed.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.6, 4.6), layout="constrained")
    axes = figure.add_subplot()
    handles = phase_plane(axes, found)
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=2, fontsize=8, frameon=False)
    return figure


def phase_plane(axes: "Axes", found: Any) -> "dict[str, Artist]":
    """Draw a regime in the phase plane, and return what its legend has, by name."""
    for motion, label, style in _periodic(found, found.law, found.oscillator):
        state = motion.at(dense(np.unique(motion.t)))
        axes.plot(state.x, state.v, label=label, **style)
    for curve in found.separatrices:
        if curve.kind != "limit cycle":  # which is drawn as the cycle that it is
            axes.plot(curve.x, curve.v, label="separatrix: orbit that touches the belt's speed", **_SEPARATRIX)
    face = "black" if found.rest.stable else "white"
    name = "rest" if found.rest.stable else "rest, unstable"
    axes.plot([found.rest.x], [0.0], "o", color="black", markerfacecolor=face, label=name)
    axes.axhline(found.oscillator.V, label="belt speed", zorder=0, **_BELT)
    axes.set(xlabel="displacement $x$ (m)", ylabel="velocity $\\dot x$ (m/s)")
    axes.locator_params(axis="x", nbins=6)
    axes.grid(alpha=0.25)
    handles, labels = axes.get_legend_handles_labels()
    return dict(zip(labels, handles, strict=True))  # one of several cycles of a kind


def _periodic(found: Any, law: FrictionLaw, osc: Oscillator) -> Iterator[tuple[Trajectory, str, Style]]:
    """Yield a period of each periodic motion, its name and its look."""

    def period(x0: float, v0: float, seconds: float) -> Trajectory:
        return simulate(law, osc, t_end=seconds, x0=x0, v0=v0, rtol=_RTOL, time_limit=_SECONDS)

    if found.stick_slip is not None:
        yield period(osc.onset(law), osc.V, found.stick_slip.period), "stick-slip", _STICK_SLIP
    for cycle in found.cycles:
        # Where v is highest the forces are in balance; slower than the belt or faster, friction has its sign.
        slip = osc.V - cycle.amplitude
        force = osc.N * float(law.mu(abs(slip))) * (1 if slip >= 0 else -1)
        start = (force - osc.c * cycle.amplitude) / osc.k
        style = _STABLE if cycle.stable else _UNSTABLE
        name = "pure-slip cycle" if cycle.stable else "pure-slip cycle, unstable"
        yield period(start, cycle.amplitude, cycle.period), name, style

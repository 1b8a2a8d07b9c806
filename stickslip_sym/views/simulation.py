"""What is shown of motions in time: their course, what became of many, and the stick-slip cycle."""

import math
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.motion.simulation.cycle import StickSlipCycle
from stickslip_sym.motion.simulation.trajectory import Event, Phase, Trajectories, Trajectory, dense
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import MOST_DRAWN, empty_figure, finish, picture, save_drawing, styled

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELS = {"t": "time $t$ (s)", "x": "displacement $x$ (m)", "v": "velocity $\\dot x$ (m/s)"}
_STYLES: dict[Phase, dict[str, Any]] = {
    Phase.STICK: {"color": "black", "linewidth": 2.6},
    Phase.SLIP_BACK: {"color": "tab:blue", "linewidth": 1.1},
    Phase.SLIP_FORWARD: {"color": "tab:orange", "linewidth": 1.4, "linestyle": (0, (3, 1))},
}
"""In grey they differ by weight and by dashes."""


@dispatch.one_line.register(Trajectory)
def trajectory_in_a_line(motion: Trajectory) -> str:
    """Return what the motion is, and how far it was followed."""
    t = motion.t
    x = motion.x
    v = motion.v
    return (
        f"Trajectory: {motion.summary}; {len(t)} samples from t = {t[0]:.6g} to {t[-1]:.6g} s, "
        f"x from {x.min():.6g} to {x.max():.6g} m, v from {v.min():.6g} to {v.max():.6g} m/s, "
        f"{len(motion.events)} changes of phase, {motion.outcome.value}"
    )


@dispatch.notebook_html.register(Trajectory)
def trajectory_as_html(motion: Trajectory) -> str:
    """Return the line, the picture of the last rounds, and the changes of phase."""
    since = float(motion.t[max(motion.t.size - MOST_DRAWN, 0)])
    drawn = picture(lambda: motion.plot(since=since), motion.summary)
    is_cut = bool(drawn) and since != motion.t[0]
    cut = []
    if is_cut:
        cut = [f"The picture begins at t = {since:.6g} s."]
    rows = [_row_of_event(event) for event in markup.shortened(motion.events)]
    table = markup.html_table(["t in s", "x in m", "v in m/s", "begins"], rows)
    return markup.block(repr(motion), drawn, *cut, table)


def _row_of_event(event: Event | None) -> list[str]:
    if event is None:
        return ["..."] * 4
    return [f"{event.t:.9g}", f"{event.x:.9g}", f"{event.v:.9g}", event.begins.value]


@dispatch.draw.register(Trajectory)
def draw_trajectory(
    motion: Trajectory, ax: "Axes", x: str = "t", y: str = "v", *, since: float = -math.inf
) -> "list[Artist]":
    """Draw two of t, x and v over each other, with stick and slip in different styles."""
    lines = list["Artist"]()
    for phase, style in _STYLES.items():
        parts = list[FloatArray]()
        for stretch in motion.stretches:
            if stretch.phase is phase and stretch.end > since:
                t = dense(np.unique(np.maximum(stretch.samples[0], since)))
                parts += [np.array((t, *stretch.course(t))), np.full((3, 1), np.nan)]  # a gap between two
        if parts:
            state = dict(zip("txv", np.concatenate(parts, axis=1), strict=True))
            lines += ax.plot(state[x], state[y], label=phase.value, **style)
    return lines


@dispatch.plot.register(Trajectory)
def plot_trajectory(
    motion: Trajectory, path: str | Path | None, ax: "Axes | None", since: float | None = None
) -> "Figure":
    """Draw the time history and the phase plane, or in given axes the velocity over time alone."""
    first = -math.inf if since is None else since
    if ax is None:
        with styled():
            figure = _three_panels(motion, first)
    else:
        draw_trajectory(motion, ax, since=first)
        finish(ax, xlabel=_LABELS["t"], ylabel=_LABELS["v"])
        figure = ax.figure  # type: ignore[assignment]  # of a subfigure, that
    if path is not None:
        save_drawing(figure, Path(path))
    return figure


def _three_panels(motion: Trajectory, since: float) -> "Figure":
    """Return x and v over the time, and v over x."""
    figure: Figure = empty_figure()
    panels = figure.subplot_mosaic("xp;vp", width_ratios=(3, 2))
    panels["x"].sharex(panels["v"])
    for name, (across, up) in {"x": ("t", "x"), "v": ("t", "v"), "p": ("x", "v")}.items():
        draw_trajectory(motion, panels[name], across, up, since=since)
        finish(panels[name], xlabel=_LABELS[across], ylabel=_LABELS[up])
    panels["x"].set_xlabel("")
    panels["x"].tick_params(labelbottom=False)
    panels["p"].locator_params(axis="x", nbins=5)
    figure.align_ylabels([panels["x"], panels["v"]])
    figure.legend(handles=panels["p"].lines, loc="outside upper center", ncols=len(_STYLES))
    return figure


@dispatch.notebook_html.register(Trajectories)
def trajectories_as_html(motions: Trajectories) -> str:
    """Return the line, and how many motions there are of each kind."""
    rows = [[word, str(number)] for word, number in motions.count().items()]
    return markup.block(repr(motions), markup.html_table(["motion", "initial conditions"], rows))


@dispatch.notebook_html.register(StickSlipCycle)
def cycle_as_html(cycle: StickSlipCycle) -> str:
    """Return a table of its times and extremes."""
    units = {"period": "s", "stick_time": "s", "slip_time": "s", "x_min": "m", "x_max": "m"}
    rows = [
        [field.name, f"{getattr(cycle, field.name):.9g}", units.get(field.name, "m/s")] for field in fields(cycle)
    ]
    return markup.html_table(["quantity", "value", "unit"], rows, caption="stick-slip cycle")

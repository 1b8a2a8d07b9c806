"""What is shown of maps and sweeps: a line, a short table, and regions drawn by colour and hatching."""

from functools import singledispatch
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.motion.maps.basins import BasinMap
from stickslip_sym.motion.maps.cell_map import CellMap, regions_of_motions
from stickslip_sym.motion.maps.motions import MotionMap
from stickslip_sym.motion.maps.results_over_axes import ResultsOverAxes
from stickslip_sym.motion.maps.sweep import BasinSweep
from stickslip_sym.motion.regimes.attractors import Region
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import picture

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.path import Path

_LOGARITHMIC = 30.0  # ratio of an axis's ends from which equal ratios are drawn as equal steps
_CURVES = {
    "equilibrium": ("threshold of the equilibrium", ":", "black"),
    "least_squares": ("least-squares criterion", "--", "#0072B2"),
    "exact": ("exact threshold", "-", "black"),
}
"""The thresholds of an operating point: their names in legends, and how they are drawn."""
_LINES = {"Hopf": ":", "graze": "-", "fold": "--"}


# -- words ---------------------------------------------------------------------------------------------


@singledispatch
def summary(results: ResultsOverAxes) -> str:
    """Return the results in a line."""
    raise TypeError(f"there is no summary of a {type(results).__name__}")


@singledispatch
def short_table(results: ResultsOverAxes) -> HeadedRows:
    """Return the header and the rows of a short table."""
    raise TypeError(f"there is no table of a {type(results).__name__}")


def _axes_in_words(results: ResultsOverAxes) -> str:
    return f"{results.law.name or 'law'}, {' by '.join(map(str, results.axes))}"


@dispatch.one_line.register(ResultsOverAxes)
def results_in_a_line(results: ResultsOverAxes) -> str:
    """Return the law, the axes and the results."""
    return f"{type(results).__name__}: {_axes_in_words(results)}; {summary(results)}"


@dispatch.notebook_html.register(ResultsOverAxes)
def results_as_html(results: ResultsOverAxes) -> str:
    """Return the results in a line, their picture, and a short table."""
    table = markup.html_table(*short_table(results), caption=_axes_in_words(results))
    return markup.block(summary(results), picture(results.plot, _axes_in_words(results)), table)


@dispatch.title.register(ResultsOverAxes)
def title_of_results(results: ResultsOverAxes) -> str:
    """Return the law, and the quantities that are no axis."""
    return f"{results.law.name or 'friction law'}: {symbols.quantities_text(results.fixed)}"


@summary.register(CellMap)
def summary_of_cells(cells: CellMap) -> str:
    """Return how many cells there are of each motion."""
    return ", ".join(f"{n} {motion.value}" for motion, n in cells.count().items())


@summary.register(MotionMap)
def summary_of_motions(motions: MotionMap) -> str:
    """Return the same, and what is said of the law."""
    return "; ".join(filter(None, (summary_of_cells(motions), motions.note)))


@summary.register(BasinMap)
def summary_of_basins(basins: BasinMap) -> str:
    """Return the same of initial conditions, and how geometry was checked."""
    said = f"{summary_of_cells(basins)}; {basins.simulated} simulated"
    if not basins.disagreements:
        return said
    return f"{basins.disagreements} of {basins.simulated} simulated ones disagree with geometry; {said}"


@summary.register(BasinSweep)
def summary_of_sweep(sweep: BasinSweep) -> str:
    """Return where basins are born and die."""
    words = [*map(str, sweep.changes)] or ["no basin is born or dies"]
    return "; ".join([*words, *(f"{kind} from {values}" for kind, values in _unresolved(sweep))])


def _unresolved(sweep: BasinSweep) -> list[tuple[str, str]]:
    return [("folds not resolved", f"{low:.9g} to {high:.9g}") for low, high in sweep.unresolved]


@short_table.register(CellMap)
def table_of_cells(cells: CellMap) -> HeadedRows:
    """Return the number of cells of each motion."""
    return ["motion", "cells"], [[motion.value, str(n)] for motion, n in cells.count().items()]


@short_table.register(BasinMap)
def table_of_basins(basins: BasinMap) -> HeadedRows:
    """Return the number of initial conditions, and the share of the box, that lead to each motion."""
    rows = [[motion.value, str(n), str(basins.share.get(motion, ""))] for motion, n in basins.count().items()]
    return ["motion", "initial conditions", "share of the box"], rows


@short_table.register(BasinSweep)
def table_of_sweep(sweep: BasinSweep) -> HeadedRows:
    """Return where basins are born and die."""
    rows = [[change.kind, f"{change.value:.12g}", f"{change.error:.1g}"] for change in sweep.changes]
    rows += [[*row, ""] for row in _unresolved(sweep)]
    return ["where basins are born or die", sweep.x.label, "error"], rows


# -- pictures ------------------------------------------------------------------------------------------


def _look(region: Region) -> dict[str, Any]:
    """Return how a region is drawn, with its name for a legend."""
    line = {"edgecolor": "0.25", "linewidth": 0.5}
    return {"label": region.name, "facecolor": region.color, "hatch": region.hatch} | line


@dispatch.draw.register(CellMap)
def draw_cells(cells: CellMap, ax: "Axes") -> "list[Artist]":
    """Draw the regions, and return the handles of its legend."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch, PathPatch

    place, kinds = cells.regions()
    x_edges = _edges(cells.x.values)
    y_edges = _edges(cells.y.values)
    ax.pcolormesh(
        x_edges, y_edges, place, cmap=ListedColormap([kind.color for kind in kinds]),
        vmin=-0.5, vmax=len(kinds) - 0.5, rasterized=True,
    )  # fmt: skip
    for i, kind in enumerate(kinds):
        if kind.hatch:
            outline = _outline_of_cells(x_edges, y_edges, place == i)
            ax.add_patch(PathPatch(outline, facecolor="none", edgecolor="black", hatch=kind.hatch, linewidth=0))
    xscale, yscale = ("log" if _is_logarithmic(axis.values) else "linear" for axis in cells.axes)
    ax.set(xlabel=cells.x.label, ylabel=cells.y.label, xscale=xscale, yscale=yscale)
    ax.set(xlim=(x_edges[0], x_edges[-1]), ylim=(y_edges[0], y_edges[-1]))
    return [Patch(**_look(kind)) for kind in kinds]


@dispatch.draw.register(MotionMap)
def draw_motions(motions: MotionMap, ax: "Axes") -> "list[Artist]":
    """Draw the regions and the curves of the thresholds, and return the handles of its legend."""
    from matplotlib.lines import Line2D

    handles = draw_cells(motions, ax)
    for name, (label, style, color) in _CURVES.items():
        x = motions.x.values
        y = motions.y.values
        curve = motions.thresholds[name]
        look: dict[str, Any] = {"linestyle": style, "color": color, "linewidth": 1.6}
        beyond = curve - motions.fixed.get("c", 0.0)
        if "c" not in motions.fixed and np.isfinite(curve).any():
            ax.plot(*((x, curve[0]) if motions.y.name == "c" else (curve[:, 0], y)), **look)
        elif "c" in motions.fixed and min(curve.shape) > 1 and (beyond < 0).any() and (beyond > 0).any():
            ax.contour(x, y, beyond, levels=[0], colors=color, linestyles=[style], linewidths=1.6)
        else:
            continue
        handles.append(Line2D([], [], label=label, **look))
    return handles


@dispatch.draw.register(BasinMap)
def draw_basins(basins: BasinMap, ax: "Axes") -> "list[Artist]":
    """Draw the basins, separatrices and the belt's speed, and return the handles of its legend."""
    handles = draw_cells(basins, ax)
    for curve in basins.regime.separatrices:
        lines = ax.plot(curve.x, curve.v, "k-", linewidth=1.6, label="separatrix")
    belt = ax.axhline(basins.fixed["V"], color="black", linestyle=":", linewidth=1.0, label="belt speed")
    return [*handles, *(lines if basins.regime.separatrices else []), belt]


@dispatch.draw.register(BasinSweep)
def draw_sweep(sweep: BasinSweep, ax: "Axes") -> "list[Artist]":
    """Draw the shares above each other, and return the handles of its legend."""
    regions = {motion: region for motion, region in regions_of_motions().items() if motion in sweep.share}
    values = sweep.x.values
    shares = np.array([sweep.share[motion] for motion in regions])
    for change in sweep.changes:  # at which shares may jump
        place = int(np.searchsorted(values, change.value))
        sides = shares[:, [max(place - 1, 0), min(place, values.size - 1)]]
        values = np.insert(values, place, [change.value] * 2)
        shares = np.insert(shares, [place, place], sides, axis=1)
        ax.axvline(change.value, color="black", linestyle=_LINES[change.kind], linewidth=1.4)
        ax.annotate(
            f"{change.kind} {change.value:.6g}", (change.value, 0.02), rotation=90, fontsize=8, va="bottom",
            ha="right", backgroundcolor=(1, 1, 1, 0.7),
        )  # fmt: skip
    ax.set(xlabel=sweep.x.label, ylabel="share of the box of initial conditions", ylim=(0, 1))
    ax.margins(x=0)
    edges = np.vstack([np.zeros(shares.shape[1]), np.cumsum(shares, axis=0)])
    return [
        ax.fill_between(values, *edges[i : i + 2], **_look(region)) for i, region in enumerate(regions.values())
    ]


def _outline_of_cells(x_edges: FloatArray, y_edges: FloatArray, chosen: BoolArray) -> "Path":
    """Return the path round cells: a rectangle for each run of neighbours in a row."""
    from matplotlib.path import Path

    steps = np.diff(np.pad(chosen.astype(int), ((0, 0), (1, 1))), axis=1)
    (rows, first) = np.nonzero(steps == 1)
    (_, behind) = np.nonzero(steps == -1)
    left = x_edges[first]
    right = x_edges[behind]
    low = y_edges[rows]
    high = y_edges[rows + 1]
    corners = np.array([[left, low], [right, low], [right, high], [left, high], [left, low]])
    codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    return Path(corners.transpose(2, 0, 1).reshape(-1, 2), np.tile(codes, rows.size))


def _is_logarithmic(values: FloatArray) -> bool:
    """Whether the values are spread by equal ratios rather than equal steps."""
    if values.size < 3 or values[0] <= 0 or values[-1] / values[0] < _LOGARITHMIC:
        return False
    return bool(np.ptp(np.diff(np.log(values))) < 0.1 * np.diff(np.log(values)).mean())


def _edges(values: FloatArray) -> FloatArray:
    """Return the places half way between the values, and as far beyond the first and the last."""
    if values.size == 1:
        return values + np.array([-0.5, 0.5]) * (abs(float(values[0])) or 1.0) * 0.1
    if _is_logarithmic(values):
        return np.exp(_edges(np.log(values)))
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])

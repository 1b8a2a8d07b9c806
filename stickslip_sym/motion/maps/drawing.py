"""Maps of motions over two axes, drawn as regions by colour and hatching."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, cycle
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.motion.maps.results_over_axes import ResultsOverAxes
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Region

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.path import Path

_TOGETHER = [("#56B4E9", "oo"), ("#F0E442", "////"), ("#CC79A7", "xxxx"), ("#D55E00", "++")]
"""Colours and hatching of regions with several attractors, after Okabe and Ito like those of one."""
_LETTERS = "obx*" + "ghijklmnqrtuvwyz"
NO_ATTRACTOR = {
    Motion.UNBOUNDED: Region("grows without bound", "#000000", "", "^"),
    Motion.UNDECIDED: Region("undecided", "#FFFFFF", "", "?"),
}
FAILED = Region("failed", "#999999", "||", "!")
_LOGARITHMIC = 30.0  # ratio of an axis's ends from which equal ratios are drawn as equal steps


def regions_of_attractors() -> dict[tuple[str, ...], Region]:
    """Return the regions by the names of their attractors."""
    regions: dict[tuple[str, ...], Region] = {(kind.name,): kind.region for kind in ATTRACTORS}
    together = [kinds for count in range(2, len(ATTRACTORS) + 1) for kinds in combinations(ATTRACTORS, count)]
    for kinds, (color, hatch), letter in zip(together, cycle(_TOGETHER), cycle(_LETTERS)):
        *first, last = [kind.region.name for kind in kinds]
        name = f"{', '.join(first)} or {last}, by the initial condition"
        regions[tuple(kind.name for kind in kinds)] = Region(name, color, hatch, letter)
    return regions


def regions_of_motions() -> dict[Motion, Region]:
    """Return the regions of initial conditions by the motions that they lead to."""
    regions = {kind.motion: kind.region._replace(name=f"comes to {kind.region.name}") for kind in ATTRACTORS}
    return regions | NO_ATTRACTOR


@dataclass(frozen=True, repr=False)
class CellMap(ResultsOverAxes):
    """The motion of each cell of two axes; a kind of map says which regions its cells are in."""

    motion: ObjectArray

    @abstractmethod
    def _masks(self) -> Mapping[Region, BoolArray]:
        """Return the cells of each region; the last one counts, and where there is none a cell is undecided."""

    def count(self) -> dict[Motion, int]:
        """Return the number of cells of each motion, where there are any."""
        return {motion: n for motion in Motion if (n := int((self.motion == motion).sum()))}

    def _summary(self) -> str:
        return ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())

    def _rows(self) -> tuple[Sequence[str], list[list[str]]]:
        return ["motion", "cells"], [[motion.value, str(n)] for motion, n in self.count().items()]

    def regions(self) -> tuple[IntArray, list[Region]]:
        """Return for each cell the place of its region in a list of those that occur."""
        masks = self._masks()
        kinds = list(masks)
        index = np.full(self.motion.shape, kinds.index(NO_ATTRACTOR[Motion.UNDECIDED]))
        for i, mask in enumerate(masks.values()):
            index[mask] = i
        present, places = np.unique(index, return_inverse=True)
        return places.reshape(index.shape), [kinds[i] for i in present]

    def draw(self, ax: "Axes") -> "list[Artist]":
        """Draw it, and return the handles of its legend."""
        from matplotlib.colors import ListedColormap
        from matplotlib.patches import Patch, PathPatch

        place, kinds = self.regions()
        x_edges, y_edges = _edges(self.x.values), _edges(self.y.values)
        ax.pcolormesh(
            x_edges, y_edges, place, cmap=ListedColormap([kind.color for kind in kinds]),
            vmin=-0.5, vmax=len(kinds) - 0.5, rasterized=True,
        )  # fmt: skip
        for i, kind in enumerate(kinds):
            if kind.hatch:
                cells = _outline_of_cells(x_edges, y_edges, place == i)
                ax.add_patch(PathPatch(cells, facecolor="none", edgecolor="black", hatch=kind.hatch, linewidth=0))
        xscale, yscale = ("log" if _is_logarithmic(axis.values) else "linear" for axis in self.axes)
        ax.set(xlabel=self.x.label, ylabel=self.y.label, xscale=xscale, yscale=yscale)
        ax.set(xlim=(x_edges[0], x_edges[-1]), ylim=(y_edges[0], y_edges[-1]))
        return [Patch(**kind.look) for kind in kinds]


def _outline_of_cells(x_edges: FloatArray, y_edges: FloatArray, chosen: BoolArray) -> "Path":
    """Return the path round cells: a rectangle for each run of neighbours in a row."""
    from matplotlib.path import Path

    steps = np.diff(np.pad(chosen.astype(int), ((0, 0), (1, 1))), axis=1)
    (rows, first), (_, behind) = np.nonzero(steps == 1), np.nonzero(steps == -1)
    left, right, low, high = x_edges[first], x_edges[behind], y_edges[rows], y_edges[rows + 1]
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

"""`CellMap`: maps of motions over two axes, as regions that have a colour, a hatching and a letter each."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, cycle

import numpy as np

from stickslip_sym.core.aliases import BoolArray, IntArray, ObjectArray
from stickslip_sym.motion.maps.results_over_axes import ResultsOverAxes
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Region

_TOGETHER = [("#56B4E9", "oo"), ("#F0E442", "////"), ("#CC79A7", "xxxx"), ("#D55E00", "++")]
"""Colours and hatching of regions with several attractors, after Okabe and Ito like those of one."""
_LETTERS = "obx*" + "ghijklmnqrtuvwyz"
NO_ATTRACTOR = {
    Motion.UNBOUNDED: Region("grows without bound", "#000000", "", "^"),
    Motion.UNDECIDED: Region("undecided", "#FFFFFF", "", "?"),
}
FAILED = Region("failed", "#999999", "||", "!")


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
        counts = {motion: int((self.motion == motion).sum()) for motion in Motion}
        return {motion: count for motion, count in counts.items() if count}

    def regions(self) -> tuple[IntArray, list[Region]]:
        """Return for each cell the place of its region in a list of those that occur."""
        masks = self._masks()
        kinds = list(masks)
        index = np.full(self.motion.shape, kinds.index(NO_ATTRACTOR[Motion.UNDECIDED]))
        for i, mask in enumerate(masks.values()):
            index[mask] = i
        present, places = np.unique(index, return_inverse=True)
        return places.reshape(index.shape), [kinds[i] for i in present]

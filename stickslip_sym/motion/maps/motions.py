"""`motion_map`: which motions exist, and which one the mass comes to, over a plane of two quantities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.core.progress import report_counts_to
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.negative import note_at_rest
from stickslip_sym.motion.maps.cell_map import FAILED, NO_ATTRACTOR, CellMap, regions_of_attractors
from stickslip_sym.motion.maps.cells import CURVES, LATE, Cells, Reason, decide
from stickslip_sym.motion.maps.results_over_axes import OSCILLATOR, AxisValues, read_plane
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Region
from stickslip_sym.motion.workers import Workers, collect
from stickslip_sym.output import files

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CELLS = 100  # of a task: they share what is computed of a law, and one is decided by following motions too


@dataclass(frozen=True, repr=False)
class MotionMap(CellMap):
    """The motions over a plane; arrays have a row for each value of y, and a column for each of x.

    Attributes
    ----------
    axes, law, fixed
        As for `ResultsOverAxes`; the axes are x and y too.
    motion : numpy.ndarray of Motion
        What becomes of a mass that starts at x = 0 with the belt's speed.
    attractors : dict of str to numpy.ndarray of bool
        Which attractors exist: "rest", stable; "pure_slip", a stable cycle in pure slip; "stick_slip". None is
        marked in cells that were not decided. With c < 0 motions far out may grow without bound besides.
    reason : numpy.ndarray of Reason
        How each cell was decided.
    thresholds : dict of numpy.ndarray
        "equilibrium", "least_squares" and "exact", in kg/s. They broadcast with the cells: where c is an axis,
        each is a curve. Negative where motions need energy fed in; NaN where a threshold was not found.
    notes : dict of (int, int) to str
        By row and column, why a cell failed or was not decided.
    interrupted : bool
        Whether Ctrl-C ended the computation: cells that were not reached have the reason `Reason.TIME`.
    """

    reported = ("motion", "reason", "attractors")

    attractors: dict[str, BoolArray]
    reason: ObjectArray
    thresholds: dict[str, FloatArray]
    notes: dict[tuple[int, int], str]
    interrupted: bool = False

    @property
    def columns(self) -> dict[str, NDArray[np.generic]]:
        """The motion, the attractors, the reason and the thresholds."""
        return {
            "motion": files.texts(self.motion),
            **self.attractors,
            "reason": files.texts(self.reason),
            **{f"c_{name}": curve for name, curve in self.thresholds.items()},
        }

    @property
    def note(self) -> str:
        """What is said of a law that holds no mass at rest on the belt; empty for any other."""
        return note_at_rest(self.law.bound)

    def _masks(self) -> dict[Region, BoolArray]:
        masks = {
            region: np.all([exists == (name in names) for name, exists in self.attractors.items()], axis=0)
            for names, region in regions_of_attractors().items()
        }
        masks |= {region: self.motion == motion for motion, region in NO_ATTRACTOR.items()}
        return masks | {FAILED: (self.reason == Reason.FAILED) | (self.reason == Reason.TIME)}


def motion_map(
    law: FrictionLaw | str,
    *,
    x: AxisValues,
    y: AxisValues,
    V: float | None = None,
    N: float | None = None,
    m: float | None = None,
    k: float | None = None,
    c: float | None = None,
    rtol: float = 1e-8,
    workers: Workers = 1,
    progress: Callable[[int, int], None] | None = None,
    time_limit: float | None = None,
) -> MotionMap:
    """Return the motions over a plane of two quantities.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound, but for those that are an axis; an axis replaces a bound value.
    x, y : (str, array_like)
        The name of an axis, one of V, N, m, k, c or a parameter of the law, and its ascending values.
    V, N, m, k, c : float
        Those that are no axis, in SI units.
    rtol : float
        Cells in which c is closer to a threshold than this part of the largest one stay undecided, 1e-8 to 1e-3.
        Simulations are a hundred times finer.
    workers : int or concurrent.futures.Executor
        A number of threads, -1 for all processors, or an executor, such as a dask client's ``get_executor()``;
        results are the same.
    progress : callable, optional
        Called with the number of parts that are done, and of all.
    time_limit : float, optional
        Seconds after which the map is returned as it is: the reason of what is not decided by then is
        `Reason.TIME`. Ctrl-C ends it likewise.

    Returns
    -------
    MotionMap

    Raises
    ------
    InputError
        For an unusable axis, value, law or `workers`.
    NotConverged
        If every cell failed.

    Examples
    --------
    >>> from stickslip_sym import laws, motion_map
    >>> law = laws.exponential.typical()
    >>> found = motion_map(law, x=("V", [0.1, 0.5]), y=("c", [2.2, 7]), N=9.81, m=1, k=100)
    >>> [[str(motion.value) for motion in row] for row in found.motion]
    [['stick-slip', 'stick-slip'], ['rest', 'rest']]
    """
    law = as_law(law)
    axes, bound, fixed = read_plane(law, x, y, {"V": V, "N": N, "m": m, "k": k, "c": c})
    rtol = read_rtol(rtol, least=1e-8)
    grid = np.meshgrid(*(axis.values for axis in axes))
    shape = grid[0].shape
    names = [axis.name for axis in axes]
    points = {name: np.full(grid[0].size, value) for name, value in fixed.items()}
    points |= {name: values.ravel() for name, values in zip(names, grid, strict=True)}
    # Those of one law and belt speed beside each other, and along c those that differ in nothing else.
    keys = [*reversed(OSCILLATOR), *(name for name in names if name in law.parameters)]
    order = np.lexsort([points[name] for name in keys])
    rows = [order[i : i + _CELLS] for i in range(0, order.size, _CELLS)]
    with deadline.time_limit(time_limit), report_counts_to(progress):
        tasks = [{name: column[some] for name, column in points.items()} for some in rows]
        results = collect(partial(decide, bound, rtol), tasks, workers=workers, what="lines of cells")
    cells = Cells.unknown(order.size)
    for some, part in zip(rows, results, strict=True):
        cells.put(some, part or OutOfTime(LATE))
    # Where c is an axis a threshold is a curve along the other.
    curve: slice | tuple[slice, slice] = np.s_[:]
    if names[0] == "c":
        curve = np.s_[:, :1]
    elif names[1] == "c":
        curve = np.s_[:1]
    table = MotionMap(
        axes, bound, fixed,
        motion=cells.motion.reshape(shape),
        attractors={kind.name: row.reshape(shape) for kind, row in zip(ATTRACTORS, cells.attractors, strict=True)},
        reason=cells.reason.reshape(shape),
        thresholds={name: row.reshape(shape)[curve] for name, row in zip(CURVES, cells.thresholds, strict=True)},
        notes={divmod(i, shape[1]): cells.notes[i] for i in sorted(cells.notes)},
        interrupted=None in results,
    )  # fmt: skip
    if (table.reason == Reason.FAILED).all():
        raise NotConverged(f"every cell failed, the first one since {next(iter(table.notes.values()))}")
    return table

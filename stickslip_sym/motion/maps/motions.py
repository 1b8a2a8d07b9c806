"""`motion_map`: which motions exist, and which one the mass comes to, over a plane of two quantities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.motion.maps.cells import CURVES, LATE, Cells, Line, Reason, decide, reason_of
from stickslip_sym.motion.maps.drawing import FAILED, UNBOUNDED, UNDECIDED, paint, regions_of_attractors
from stickslip_sym.motion.maps.table import Axis, AxisValues, Table, count_of, read_plane
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.attractors import ATTRACTORS, Region
from stickslip_sym.motion.workers import Progress, Workers, collect
from stickslip_sym.output import files

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

_ALONG = ("c", "N", "m", "k")
_CELLS = 300  # of a task: so many share what is computed of a law


@dataclass(frozen=True, repr=False)
class MotionMap(Table):
    """The motions over a plane; arrays have a row for each value of y, and a column for each of x.

    Attributes
    ----------
    axes, law, fixed
        As for `Table`; the axes are x and y too.
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

    motion: ObjectArray
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
    def coexist(self) -> BoolArray:
        """Where more than one attractor exists, as an array of bool."""
        return np.asarray(sum(exists.astype(int) for exists in self.attractors.values()) > 1)

    def count(self) -> dict[Motion, int]:
        """Return the number of cells of each motion, where there are any."""
        return count_of(self.motion)

    def _summary(self) -> str:
        return ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())

    def _rows(self) -> tuple[Sequence[str], list[list[str]]]:
        return ["motion", "cells"], [[motion.value, str(n)] for motion, n in self.count().items()]

    def draw(self, ax: Axes) -> list[Artist]:
        """Draw it, and return the handles of its legend."""
        from matplotlib.lines import Line2D

        handles = paint(ax, self.x, self.y, *self.regions())
        for name, (label, style, color) in CURVES.items():
            x, y, curve = self.x.values, self.y.values, self.thresholds[name]
            look: dict[str, Any] = {"linestyle": style, "color": color, "linewidth": 1.6}
            beyond = curve - self.fixed.get("c", 0.0)
            if "c" not in self.fixed and np.isfinite(curve).any():
                ax.plot(*((x, curve[0]) if self.y.name == "c" else (curve[:, 0], y)), **look)
            elif "c" in self.fixed and min(curve.shape) > 1 and (beyond < 0).any() and (beyond > 0).any():
                ax.contour(x, y, beyond, levels=[0], colors=color, linestyles=[style], linewidths=1.6)
            else:
                continue
            handles.append(Line2D([], [], label=label, **look))
        return handles

    def regions(self) -> tuple[IntArray, list[Region]]:
        """Return for each cell the place of its region in a list of those that occur."""
        regions = regions_of_attractors()
        kinds = [*regions.values(), UNBOUNDED, UNDECIDED, FAILED]
        failed = (self.reason == Reason.FAILED) | (self.reason == Reason.TIME)
        exact = [
            np.all([exists == (name in names) for name, exists in self.attractors.items()], axis=0)
            for names in regions
        ]
        index = np.select(
            [failed, self.motion == Motion.UNDECIDED, self.motion == Motion.UNBOUNDED, *exact],
            [kinds.index(FAILED), kinds.index(UNDECIDED), kinds.index(UNBOUNDED), *range(len(regions))],
            kinds.index(UNDECIDED),
        )
        present, places = np.unique(index, return_inverse=True)
        return places.reshape(index.shape), [kinds[i] for i in present]


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
    progress: Progress | None = None,
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
    lines = _lines(fixed, axes)
    with deadline.time_limit(time_limit):
        count = max(1, _CELLS // lines[0].c.size)
        tasks = [lines[i : i + count] for i in range(0, len(lines), count)]
        results = collect(partial(decide, bound, rtol), tasks, workers=workers, progress=progress)
    shape = axes[1].values.size, axes[0].values.size
    found = MotionMap(
        axes, bound, fixed,
        motion=np.full(shape, Motion.UNDECIDED),
        attractors={kind.name: np.zeros(shape, dtype=bool) for kind in ATTRACTORS},
        reason=np.full(shape, Reason.TIME),
        thresholds={name: np.full(shape, np.nan) for name in CURVES},
        notes={},
        interrupted=None in results,
    )  # fmt: skip
    late = OutOfTime(LATE)
    for task, part in zip(tasks, results, strict=True):
        for line, cells in zip(task, part or [late] * len(task), strict=True):
            _fill(found, line, cells)
    if "c" not in fixed:
        once = np.s_[:1] if axes[1].name == "c" else np.s_[:, :1]
        found.thresholds.update({name: curve[once] for name, curve in found.thresholds.items()})
    if (found.reason == Reason.FAILED).all():
        raise NotConverged(f"every cell failed, the first one since {next(iter(found.notes.values()))}")
    return found


def _lines(fixed: dict[str, float], axes: tuple[Axis, Axis]) -> list[Line]:
    """Return the cells of a map as lines along c where it is an axis, else along one that leaves law and speed."""
    along = min(axes, key=lambda axis: [*_ALONG, axis.name].index(axis.name))
    across = axes[along is axes[0]]
    places = np.indices((axes[1].values.size, axes[0].values.size))
    if along is axes[1]:
        places = places.swapaxes(1, 2)
    lines = []
    for value, (rows, columns) in zip(across.values.tolist(), places.swapaxes(0, 1), strict=True):
        point = fixed | {across.name: value}
        if along.name == "c":
            lines.append(Line((rows[None], columns[None]), [point], along.values[None]))
            continue
        points = [point | {along.name: one} for one in along.values.tolist()]
        size = len(points) if along.name in _ALONG else 1
        for i in range(0, len(points), size):
            some = slice(i, i + size)
            c = np.full((size, 1), point["c"])
            lines.append(Line((rows[some, None], columns[some, None]), points[some], c))
    return lines


def _fill(found: MotionMap, line: Line, cells: Cells | StickSlipError) -> None:
    """Write the cells of a line into a map."""
    places = list(zip(*(part.ravel().tolist() for part in line.place), strict=True))
    if isinstance(cells, StickSlipError):
        found.reason[line.place] = reason_of(cells)
        found.notes.update(dict.fromkeys(places, str(cells)))
        return
    found.motion[line.place], found.reason[line.place] = cells.motion, cells.reason
    for wholes, parts in ((found.attractors, cells.attractors), (found.thresholds, cells.thresholds)):
        for name, part in parts.items():
            wholes[name][line.place] = part
    width = line.c.shape[1]
    found.notes.update({places[i * width + j]: text for (i, j), text in cells.notes.items()})

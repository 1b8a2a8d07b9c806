"""`motion_map`: which motions exist, and which one the mass comes to, over a plane of two quantities."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, ObjectArray
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.content import text_of_law
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.maps.axes import Axis, AxisValues, fixed_values, read_axes
from stickslip_sym.motion.maps.cells import CURVES, MOTIONS, REASONS, Attractor, Reason
from stickslip_sym.motion.maps.checkpoint import Progress, collect
from stickslip_sym.motion.maps.lines import decide_lines, lines_together, tasks_of
from stickslip_sym.motion.maps.workers import Workers
from stickslip_sym.motion.regimes.classification import Motion
from stickslip_sym.output import drawing, files, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["MotionMap", "motion_map"]


@dataclass(frozen=True, repr=False)
class MotionMap(drawing.Drawn):
    """The motions over a plane; arrays have a row for each value of y, and a column for each of x.

    Attributes
    ----------
    x, y : Axis
        Each with `name`, `values`, `unit` and `meaning`.
    law : FrictionLaw
    fixed : dict
        The quantities that are no axis, in SI units.
    motion : numpy.ndarray of Motion
        What becomes of a mass that starts at x = 0 with the belt's speed.
    stick_slip, rest, pure_slip : numpy.ndarray of bool
        Which attractors exist: a stick-slip cycle, stable rest, a stable cycle in pure slip. None is marked in
        cells that were not decided. With c < 0 motions far out may grow without bound besides.
    reason : numpy.ndarray of Reason
        How each cell was decided.
    thresholds : dict of numpy.ndarray
        "equilibrium", "least_squares" and "exact", in kg/s. They broadcast with the cells: where c is an axis,
        each is a curve. Negative where a smooth law's motions need energy fed in; NaN where a threshold was not
        found, and, for a law that is not smooth, where no c >= 0 is the exact one.
    notes : dict of (int, int) to str
        By row and column, why a cell failed or was not decided.
    """

    x: Axis
    y: Axis
    law: FrictionLaw
    fixed: dict[str, float]
    motion: ObjectArray
    stick_slip: BoolArray
    rest: BoolArray
    pure_slip: BoolArray
    reason: ObjectArray
    thresholds: dict[str, FloatArray]
    notes: dict[tuple[int, int], str]

    @property
    def coexist(self) -> BoolArray:
        """Where more than one attractor exists, as an array of bool."""
        return self.stick_slip.astype(int) + self.rest + self.pure_slip > 1

    def count(self) -> dict[Motion, int]:
        """Return the number of cells of each motion, where there are any."""
        return {motion: n for motion in Motion if (n := int((self.motion == motion).sum()))}

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())
        return f"MotionMap: {self.law.name or 'law'}, {self.x} by {self.y}; {counts}"

    def _repr_html_(self) -> str:
        rows = [[motion.value, str(n)] for motion, n in self.count().items()]
        title = f"{self.law.name or 'law'}, {self.x} by {self.y}"
        table = markup.table(["motion", "cells"], rows, caption=title)
        return markup.block(drawing.picture(self.plot, title), table)

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each cell: x, y, the motion, the attractors, the reason and the thresholds.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        X, Y = np.meshgrid(self.x.values, self.y.values)
        columns = {
            self.x.name: X,
            self.y.name: Y,
            "motion": files.texts(self.motion),
            "stick_slip": self.stick_slip.astype(int),
            "rest": self.rest.astype(int),
            "pure_slip": self.pure_slip.astype(int),
            "reason": files.texts(self.reason),
            **{f"c_{name}": np.broadcast_to(curve, X.shape) for name, curve in self.thresholds.items()},
        }
        files.write_csv(Path(path), columns)

    def to_npz(self, path: str | Path) -> None:
        """Write plain arrays, which ``numpy.load`` reads with ``allow_pickle=False``.

        They have the names of the attributes; the axes are "x" and "y" with "x_name", "x_unit" and so on, the
        thresholds "c_equilibrium" and so on. Motions and reasons are texts.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        arrays = {
            "motion": files.texts(self.motion),
            "stick_slip": self.stick_slip,
            "rest": self.rest,
            "pure_slip": self.pure_slip,
            "reason": files.texts(self.reason),
            **{f"c_{name}": curve for name, curve in self.thresholds.items()},
            **{f"fixed_{name}": np.array(value) for name, value in self.fixed.items()},
            "law": np.array(text_of_law(self.law)),
        }
        for side, axis in (("x", self.x), ("y", self.y)):
            arrays |= {side: axis.values, f"{side}_name": np.array(axis.name), f"{side}_unit": np.array(axis.unit)}
        files.write_npz(Path(path), arrays)

    def _figure(self) -> "Figure":
        from stickslip_sym.motion.maps.drawing import draw_map

        return draw_map(self)


def motion_map(
    law: FrictionLaw,
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
    checkpoint: str | Path | None = None,
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
    workers : int or map-like callable
        A number of processes, -1 for all processors, or a function such as ``pool.map``; results are the same.
    checkpoint : str or Path, optional
        A file in which finished lines of cells are kept, about 300 cells at once; a run that was killed goes on
        from it.
    progress : callable, optional
        Called with the number of lines that are done, and of all.
    time_limit : float, optional
        Seconds after which the map is returned as it is: the reason of what is not decided by then is
        `Reason.TIME`. Such lines are not kept in a checkpoint, and a later run goes on with them.

    Returns
    -------
    MotionMap

    Raises
    ------
    InputError
        For an unusable axis, value, law, `workers` or `checkpoint`.
    NotConverged
        If every cell failed.

    Examples
    --------
    >>> from stickslip_sym import laws, motion_map
    >>> law = laws.exponential.typical()
    >>> found = motion_map(law, x=("V", [0.1, 0.5]), y=("c", [2.2, 7]), N=9.81, m=1, k=100)
    >>> [[str(motion.value) for motion in row] for row in found.motion]
    [['stick-slip', 'stick-slip'], ['damped slip', 'damped slip']]
    """
    axes = read_axes(law, x, y)
    bound, fixed = fixed_values(law, axes, {"V": V, "N": N, "m": m, "k": k, "c": c})
    rtol = read_rtol(rtol, least=1e-8)
    # All cells of a line along c are decided together.
    turned = axes[0].name == "c"
    across, along = (axes[1], axes[0]) if turned else axes
    lines = [fixed | {across.name: value} for value in across.values.tolist()]
    tasks = tasks_of(text_of_law(bound), lines, along.name, along.values.tolist(), rtol)
    with deadline.time_limit(time_limit):
        found_lines = collect(
            decide_lines,
            tasks,
            together=lines_together(along.values.size),
            workers=workers,
            checkpoint=checkpoint,
            progress=progress,
        )

    def grid(name: str, read: Callable[[Any], Any], dtype: Any) -> Any:
        array = np.array([[read(entry) for entry in line[name]] for line in found_lines], dtype=dtype)
        return array if turned else array.T

    attractors = grid("attractors", int, int)
    notes = {(i, j) if turned else (j, i): text for i, line in enumerate(found_lines) for j, text in line["notes"]}
    found = MotionMap(
        *axes, law=bound, fixed=fixed,
        motion=grid("motion", MOTIONS.__getitem__, object),
        stick_slip=attractors & Attractor.STICK_SLIP > 0,
        rest=attractors & Attractor.REST > 0,
        pure_slip=attractors & Attractor.PURE_SLIP > 0,
        reason=grid("reason", REASONS.__getitem__, object),
        thresholds={name: grid(name, lambda value: np.nan if value is None else value, float) for name in CURVES},
        notes=notes,
    )  # fmt: skip
    if (found.reason == Reason.FAILED).all():
        raise NotConverged(f"every cell failed, the first one since {next(iter(notes.values()))}")
    return found

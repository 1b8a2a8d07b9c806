"""`basin_map`: which motion each initial condition leads to."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.axes import Axis, read_values, require_few
from stickslip_sym.motion.maps.cells import LATE
from stickslip_sym.motion.maps.drawing import paint, regions_of_motions
from stickslip_sym.motion.maps.shares import FINEST, Share, counted_shares, motions_by_side, shares_by_area
from stickslip_sym.motion.maps.table import Table, count_of
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.regimes.classification import classify_all
from stickslip_sym.motion.regimes.regime import Regime, regime
from stickslip_sym.motion.workers import Progress, Workers, collect
from stickslip_sym.output import files

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

__all__ = ["BasinMap", "basin_map"]

_TOGETHER = 1000  # initial conditions that are classified at once
_CHECKED = 200  # initial conditions that are simulated although geometry settles them
_SEED = 1  # of their choice


@dataclass(frozen=True, repr=False)
class BasinMap(Table):
    """The motions that initial conditions lead to.

    Attributes
    ----------
    axes, law, fixed
        As for `Table`: x0 in m and v0 in m/s, and the oscillator's quantities.
    motion : numpy.ndarray of Motion
        A row for each v0, a column for each x0.
    regime : Regime
        The attractors, and the separatrices of their basins.
    share : dict of Motion to Share
        The part of the box, from the lowest x0 and v0 to the highest, that leads to each motion: by the
        areas inside the separatrices, or counted where geometry does not settle them.
    simulated : int
        How many initial conditions were simulated: those that geometry does not settle, and a sample of the
        others as a check.
    disagreements : int
        How many of the sample lead elsewhere than geometry says; the simulated motion stands.
    notes : dict of (int, int) to str
        By row and column, why an initial condition failed, or what geometry said where it disagrees.
    """

    motion: ObjectArray
    regime: Regime
    share: dict[Motion, Share]
    simulated: int
    disagreements: int
    notes: dict[tuple[int, int], str]

    @property
    def columns(self) -> dict[str, NDArray[np.generic]]:
        """The motion."""
        return {"motion": files.texts(self.motion)}

    def count(self) -> dict[Motion, int]:
        """Return the number of initial conditions of each motion, where there are any."""
        return count_of(self.motion)

    def _summary(self) -> str:
        counts = ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())
        differ = f"; {self.disagreements} simulated ones disagree with geometry" if self.disagreements else ""
        return f"{counts}; {self.simulated} simulated{differ}"

    def _rows(self) -> tuple[Sequence[str], list[list[str]]]:
        rows = [[motion.value, str(n), str(self.share.get(motion, ""))] for motion, n in self.count().items()]
        return ["motion", "initial conditions", "share of the box"], rows

    def _draw(self, ax: Axes) -> list[Artist]:
        from matplotlib.lines import Line2D

        regions = {
            motion: region for motion, region in regions_of_motions().items() if (self.motion == motion).any()
        }
        place = np.zeros(self.motion.shape, dtype=int)
        for i, motion in enumerate(regions):
            place[self.motion == motion] = i
        handles = paint(ax, self.x.values, self.y.values, place, list(regions.values()))
        for curve in self.regime.separatrices:
            ax.plot(curve.x, curve.v, "k-", linewidth=1.6)
        if self.regime.separatrices:
            handles.append(Line2D([], [], color="black", linewidth=1.6, label="separatrix"))
        ax.axhline(self.fixed["V"], color="black", linestyle=":", linewidth=1.0)
        handles.append(Line2D([], [], color="black", linestyle=":", linewidth=1.0, label="belt speed"))
        ax.set(xlabel=self.x.label, ylabel=self.y.label)
        return handles


def basin_map(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    x0: ArrayLike,
    v0: ArrayLike,
    rtol: float = 1e-10,
    workers: Workers = 1,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> BasinMap:
    """Return the motion that each initial condition leads to, also faster than the belt.

    Motions do not cross in the plane of x and x', so the side of the separatrices on which an initial condition
    lies decides. Simulated are those within the error of a separatrix, all of them where jumps of mu or motions
    without bound leave geometry undecided, and a seeded sample of 200 as a check.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    x0, v0 : array_like
        Initial displacements in m and velocities in m/s, each ascending.
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    workers, progress
        As for `motion_map`.
    time_limit : float, optional
        Seconds after which it is returned as it is: what is not classified by then is undecided, with a note
        that says so. Ctrl-C ends it likewise.

    Returns
    -------
    BasinMap

    Raises
    ------
    InputError
        For an unusable value, law or `workers`.
    NotConverged
        If the attractors are not found, or every initial condition fails.
    """
    law = as_law(law)
    rtol = read_rtol(rtol)
    places, speeds = read_values("x0", x0), read_values("v0", v0)
    require_few(places.size, speeds.size)
    with deadline.time_limit(time_limit):
        found = regime(law, osc, rtol=FINEST)
        settled = motions_by_side(found, places, speeds)
        chosen = (settled < 0) | _sample(settled)
        rows, columns = np.nonzero(chosen)
        points = np.column_stack([places[columns], speeds[rows]])
        tasks = [points[i : i + _TOGETHER] for i in range(0, len(points), _TOGETHER)]
        results = collect(partial(_classified, law, osc, rtol), tasks, workers=workers, progress=progress)
        share = dict[Motion, Share]()
        if min(places.size, speeds.size) > 1:
            with suppress(OutOfTime):
                share = shares_by_area(found, (places[0], places[-1]), (speeds[0], speeds[-1]))
    index, notes, disagreements = settled.copy(), dict[tuple[int, int], str](), 0
    late = OutOfTime(LATE)
    fates: list[object] = []
    for task, part in zip(tasks, results, strict=True):
        fates += [late] * len(task) if part is None else part.tolist()
    for row, column, fate in zip(rows.tolist(), columns.tolist(), fates, strict=True):
        geometry = index[row, column]
        index[row, column] = MOTIONS.index(fate if isinstance(fate, Motion) else Motion.UNDECIDED)
        if not isinstance(fate, Motion):
            notes[row, column] = LATE if isinstance(fate, OutOfTime) else str(fate)
        elif geometry not in (-1, index[row, column]):
            disagreements += 1
            notes[row, column] = f"geometry says {MOTIONS[geometry].value}"
    if len(notes) - disagreements == index.size and LATE not in notes.values():
        raise NotConverged(f"every initial condition failed, the first one since {notes[0, 0]}")
    axes = (
        Axis("x0", places, "m", "initial displacement"), Axis("v0", speeds, "m/s", "initial velocity")
    )  # fmt: skip
    share = share or counted_shares(index)
    motion = np.array(MOTIONS, dtype=object)[index]
    return BasinMap(axes, law, asdict(osc), motion, found, share, len(fates), disagreements, notes)


def _sample(settled: IntArray) -> BoolArray:
    """Return which of the initial conditions that geometry settles are simulated as a check."""
    chosen = np.zeros(settled.shape, dtype=bool)
    known = np.flatnonzero(settled >= 0)
    chosen.flat[np.random.default_rng(_SEED).choice(known, min(known.size, _CHECKED), replace=False)] = True
    return chosen


def _classified(law: FrictionLaw, osc: Oscillator, rtol: float, points: FloatArray) -> ObjectArray:
    """Return what some initial conditions lead to, each a row of x0 and v0, or the errors in their places."""
    return classify_all(law, osc, *points.T, rtol=rtol)

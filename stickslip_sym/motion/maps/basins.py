"""`basin_map`: which motion each initial condition leads to."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.content import law_of_text, text_of_law
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.axes import Axis, read_values, require_few
from stickslip_sym.motion.maps.drawing import new_figure, paint, regions_of_motions, title, with_legend
from stickslip_sym.motion.maps.shares import FINEST, Share, counted_shares, motions_by_side, shares_by_area
from stickslip_sym.motion.motion import MOTIONS, Motion
from stickslip_sym.motion.regimes.attractors import Regime, regime
from stickslip_sym.motion.regimes.classification import classify_all
from stickslip_sym.motion.workers import Progress, Workers, collect
from stickslip_sym.output import drawing, files, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BasinMap", "basin_map"]

LATE = "not reached: time limit, or Ctrl-C"
Task = dict[str, Any]
_TOGETHER = 1000  # initial conditions that are classified at once
_CHECKED = 200  # initial conditions that are simulated although geometry settles them
_SEED = 1  # of their choice


@dataclass(frozen=True, repr=False)
class BasinMap(drawing.Drawn):
    """The motions that initial conditions lead to.

    Attributes
    ----------
    x0, v0 : numpy.ndarray
        Initial displacements in m and velocities in m/s.
    law : FrictionLaw
    oscillator : Oscillator
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

    x0: FloatArray
    v0: FloatArray
    law: FrictionLaw
    oscillator: Oscillator
    motion: ObjectArray
    regime: Regime
    share: dict[Motion, Share]
    simulated: int
    disagreements: int
    notes: dict[tuple[int, int], str]

    def count(self) -> dict[Motion, int]:
        """Return the number of initial conditions of each motion, where there are any."""
        return {motion: n for motion in Motion if (n := int((self.motion == motion).sum()))}

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())
        differ = f"; {self.disagreements} simulated ones disagree with geometry" if self.disagreements else ""
        return f"BasinMap: {self._place()}; {counts}; {self.simulated} simulated{differ}"

    def _repr_html_(self) -> str:
        rows = [[motion.value, str(n), str(self.share.get(motion, ""))] for motion, n in self.count().items()]
        table = markup.table(["motion", "initial conditions", "share of the box"], rows, caption=self._place())
        differ = [f"{self.disagreements} simulated ones disagree with geometry"] if self.disagreements else []
        return markup.block(drawing.picture(self.plot, self._place()), table, *differ)

    def _place(self) -> str:
        x0, v0 = Axis("x0", self.x0, "m", ""), Axis("v0", self.v0, "m/s", "")
        return f"{self.law.name or 'law'}, {x0} by {v0}"

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each initial condition: x0, v0 and the motion.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        X, Y = np.meshgrid(self.x0, self.v0)
        files.write_csv(Path(path), {"x0": X, "v0": Y, "motion": files.texts(self.motion)})

    def to_npz(self, path: str | Path) -> None:
        """Write plain arrays, which ``numpy.load`` reads with ``allow_pickle=False``.

        They are "x0", "v0", "motion" as text, "law" as text, and the oscillator's m, k, c, V and N.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        arrays = {"x0": self.x0, "v0": self.v0, "motion": files.texts(self.motion)}
        arrays |= {"law": np.array(text_of_law(self.law))}
        arrays |= {name: np.array(value) for name, value in asdict(self.oscillator).items()}
        files.write_npz(Path(path), arrays)

    def _figure(self) -> Figure:
        from matplotlib.lines import Line2D

        figure, axes = new_figure()
        regions = {
            motion: region for motion, region in regions_of_motions().items() if (self.motion == motion).any()
        }
        place = np.zeros(self.motion.shape, dtype=int)
        for i, motion in enumerate(regions):
            place[self.motion == motion] = i
        handles = paint(axes, self.x0, self.v0, place, list(regions.values()))
        for curve in self.regime.separatrices:
            axes.plot(curve.x, curve.v, "k-", linewidth=1.6)
        if self.regime.separatrices:
            handles.append(Line2D([], [], color="black", linewidth=1.6, label="separatrix"))
        axes.axhline(self.oscillator.V, color="black", linestyle=":", linewidth=1.0)
        handles.append(Line2D([], [], color="black", linestyle=":", linewidth=1.0, label="belt speed"))
        axes.set(xlabel="initial displacement x (m)", ylabel="initial velocity x' (m/s)")
        title(axes, self.law, asdict(self.oscillator))
        return with_legend(figure, handles)


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
    request = {"law": text_of_law(law), "oscillator": asdict(osc), "rtol": rtol}
    with deadline.time_limit(time_limit):
        found = regime(law, osc, rtol=FINEST)
        settled = motions_by_side(found, places, speeds)
        chosen = (settled < 0) | _sample(settled)
        rows, columns = np.nonzero(chosen)
        points = np.column_stack([places[columns], speeds[rows]]).tolist()
        tasks = [request | {"points": points[i : i + _TOGETHER]} for i in range(0, len(points), _TOGETHER)]
        results = collect(classify_task, tasks, workers=workers, progress=progress)
        share = dict[Motion, Share]()
        if min(places.size, speeds.size) > 1:
            with suppress(OutOfTime):
                share = shares_by_area(found, (places[0], places[-1]), (speeds[0], speeds[-1]))
    index, notes, disagreements, late = settled.copy(), dict[tuple[int, int], str](), 0, None in results
    fates = [fate for task, part in zip(tasks, results, strict=True) for fate in part or unreached(task)]
    for row, column, (motion, note) in zip(rows.tolist(), columns.tolist(), fates, strict=True):
        geometry, index[row, column] = index[row, column], motion
        if note:
            notes[row, column] = note
            late = late or note == LATE
        elif geometry not in (-1, motion):
            disagreements += 1
            notes[row, column] = f"geometry says {MOTIONS[geometry].value}"
    if len(notes) - disagreements == index.size and not late:
        raise NotConverged(f"every initial condition failed, the first one since {notes[0, 0]}")
    return BasinMap(
        places, speeds, law, osc, np.array(MOTIONS, dtype=object)[index], found, share or counted_shares(index),
        len(fates), disagreements, notes,
    )  # fmt: skip


def _sample(settled: IntArray) -> BoolArray:
    """Return which of the initial conditions that geometry settles are simulated as a check."""
    chosen = np.zeros(settled.shape, dtype=bool)
    known = np.flatnonzero(settled >= 0)
    chosen.flat[np.random.default_rng(_SEED).choice(known, min(known.size, _CHECKED), replace=False)] = True
    return chosen


def classify_task(task: Task) -> list[tuple[int, str]]:
    """Return the place in `MOTIONS` of what each initial condition leads to, and why it is undecided."""
    law, osc = law_of_text(task["law"]), Oscillator(**task["oscillator"])
    x0, v0 = np.array(task["points"], dtype=np.float64).T
    return [
        (MOTIONS.index(Motion.UNDECIDED), LATE if isinstance(one, OutOfTime) else str(one))
        if isinstance(one, StickSlipError)
        else (MOTIONS.index(one), "")
        for one in classify_all(law, osc, x0, v0, rtol=task["rtol"])
    ]


def unreached(task: Task) -> list[tuple[int, str]]:
    """Return the same of a task that was not carried out."""
    return [(MOTIONS.index(Motion.UNDECIDED), LATE)] * len(task["points"])

"""`basin_map`: which motion each start leads to."""

from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime, StickSlipError
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.content import law_of_text, text_of_law
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.axes import Axis, read_values, require_few
from stickslip_sym.motion.maps.cells import MOTIONS
from stickslip_sym.motion.maps.checkpoint import UNFINISHED, Plain, Progress, collect
from stickslip_sym.motion.maps.shares import Share, counted_shares, shares_of
from stickslip_sym.motion.maps.sides import FINEST, sides_of
from stickslip_sym.motion.maps.workers import Workers
from stickslip_sym.motion.regimes.attractors import Regime, regime
from stickslip_sym.motion.regimes.classification import Motion, classify_all
from stickslip_sym.output import drawing, files, markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["BasinMap", "basin_map"]

_CHECKED = 200  # starts that are simulated although geometry settles them
_SEED = 1  # of their choice


@dataclass(frozen=True, repr=False)
class BasinMap(drawing.Drawn):
    """The motions that starts lead to.

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
        The part of the box of starts, from the lowest x0 and v0 to the highest, that leads to each motion: by the
        areas inside the separatrices, or counted where geometry does not settle them.
    simulated : int
        How many starts were simulated: those that geometry does not settle, and a sample of the others as a check.
    disagreements : int
        How many of the sample lead elsewhere than geometry says; the simulated motion stands.
    notes : dict of (int, int) to str
        By row and column, why a start failed, or what geometry said where it disagrees.
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
        """Return the number of starts of each motion, where there are any."""
        return {motion: n for motion in Motion if (n := int((self.motion == motion).sum()))}

    def __repr__(self) -> str:
        counts = ", ".join(f"{n} {motion.value}" for motion, n in self.count().items())
        doubt = f"; {self.disagreements} simulated ones disagree with geometry" if self.disagreements else ""
        return f"BasinMap: {self._place()}; {counts}; {self.simulated} simulated{doubt}"

    def _repr_html_(self) -> str:
        rows = [[motion.value, str(n), str(self.share.get(motion, ""))] for motion, n in self.count().items()]
        table = markup.table(["motion", "starts", "share of the box"], rows, caption=self._place())
        doubt = [f"{self.disagreements} simulated starts disagree with geometry"] if self.disagreements else []
        return markup.block(drawing.picture(self.plot, self._place()), table, *doubt)

    def _place(self) -> str:
        x0, v0 = Axis("x0", self.x0, "m", ""), Axis("v0", self.v0, "m/s", "")
        return f"{self.law.name or 'law'}, {x0} by {v0}"

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each start: x0, v0 and the motion.

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

    def _figure(self) -> "Figure":
        from stickslip_sym.motion.maps.drawing import draw_basins

        return draw_basins(self)


def basin_map(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    x0: ArrayLike,
    v0: ArrayLike,
    rtol: float = 1e-10,
    workers: Workers = 1,
    checkpoint: str | Path | None = None,
    progress: Progress | None = None,
    time_limit: float | None = None,
) -> BasinMap:
    """Return the motion that each start leads to, also starts faster than the belt.

    Motions do not cross in the plane of x and x', so the side of the separatrices that a start lies on tells where
    it leads. Simulated are starts within the error of a separatrix, all of them where jumps of mu or motions
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
    workers, checkpoint, progress
        As for `motion_map`.
    time_limit : float, optional
        Seconds after which it is returned as it is: starts that are not classified by then are undecided, with a
        note that says so. Their lines are not kept in a checkpoint.

    Returns
    -------
    BasinMap

    Raises
    ------
    InputError
        For an unusable value, law, `workers` or `checkpoint`.
    NotConverged
        If the attractors are not found, or every start fails.
    """
    rtol = read_rtol(rtol)
    places, speeds = read_values("x0", x0), read_values("v0", v0)
    require_few(places.size, speeds.size)
    request = {"law": text_of_law(law), "oscillator": asdict(osc), "rtol": rtol}
    with deadline.time_limit(time_limit):
        found, sides, share = regime(law, osc, rtol=FINEST), None, None
        with suppress(OutOfTime):
            sides = sides_of(law, osc, found)
        settled = np.full((speeds.size, places.size), -1) if sides is None else sides.motions(places, speeds)
        chosen = (settled < 0) | _sample(settled)
        rows = np.flatnonzero(chosen.any(axis=1))
        tasks = [request | {"v0": float(speeds[row]), "x0": places[chosen[row]].tolist()} for row in rows]
        if deadline.time_left() <= 0:  # what geometry settles is not known, and nothing will be done
            checkpoint = None
        lines = collect(classify_line, tasks, workers=workers, checkpoint=checkpoint, progress=progress)
        if sides is not None and min(places.size, speeds.size) > 1:
            box = (float(places[0]), float(places[-1])), (float(speeds[0]), float(speeds[-1]))
            with suppress(OutOfTime):
                share = shares_of(law, osc, found, sides, *box)
    index, notes, disagreements = settled.copy(), dict[tuple[int, int], str](), 0
    for row, line in zip(rows.tolist(), lines, strict=True):
        columns = np.flatnonzero(chosen[row])
        index[row, columns] = line["motion"]
        notes |= {(row, int(columns[place])): text for place, text in line["notes"]}
        for column in columns[(settled[row, columns] >= 0) & (settled[row, columns] != line["motion"])].tolist():
            if (row, column) not in notes:
                disagreements += 1
                notes[row, column] = f"geometry says {MOTIONS[settled[row, column]].value}"
    if len(notes) - disagreements == index.size and not any(line[UNFINISHED] for line in lines):
        raise NotConverged(f"every start failed, the first one since {notes[0, 0]}")
    motion = np.array(MOTIONS, dtype=object)[index]
    return BasinMap(
        places,
        speeds,
        law,
        osc,
        motion,
        found,
        share or counted_shares(index),
        int(chosen.sum()),
        disagreements,
        notes,
    )


def _sample(settled: IntArray) -> BoolArray:
    """Return which of the starts that geometry settles are simulated as a check."""
    chosen = np.zeros(settled.shape, dtype=bool)
    known = np.flatnonzero(settled >= 0)
    chosen.flat[np.random.default_rng(_SEED).choice(known, min(known.size, _CHECKED), replace=False)] = True
    return chosen


def classify_line(task: Plain) -> Plain:
    """Classify starts of one line of a basin map: plain content in, plain content out."""
    law, osc = law_of_text(task["law"]), Oscillator(**task["oscillator"])
    motion, notes, unfinished = [], [], False
    places = np.array(task["x0"], dtype=np.float64)
    found = classify_all(law, osc, places, np.full(places.size, task["v0"]), rtol=task["rtol"])
    for place, one in enumerate(found):
        if isinstance(one, StickSlipError):
            unfinished = unfinished or isinstance(one, OutOfTime)
            notes.append([place, str(one)])
        motion.append(MOTIONS.index(Motion.UNDECIDED if isinstance(one, StickSlipError) else one))
    return {"motion": motion, "notes": notes, UNFINISHED: unfinished}

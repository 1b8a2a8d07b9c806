"""`basin_map`: which motion each initial condition leads to."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, ObjectArray
from stickslip_sym.core.errors import NotConverged, OutOfTime
from stickslip_sym.core.numbers import SEED, read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.kernel.slip_data import ADDED, TIGHT
from stickslip_sym.motion.maps.cell_map import CellMap, regions_of_motions
from stickslip_sym.motion.maps.cells import LATE
from stickslip_sym.motion.maps.results_over_axes import Axis, read_values, require_few
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.attractors import Region
from stickslip_sym.motion.regimes.classification import followed
from stickslip_sym.motion.regimes.regime import Regime, kept_regime
from stickslip_sym.output import files
from stickslip_sym.output.data import DataResult

if TYPE_CHECKING:
    from numpy.typing import NDArray

_CHECKED = 200  # initial conditions that are followed although geometry settles them


@dataclass(frozen=True)
class Share(DataResult):
    """A part of a box of initial conditions.

    Attributes
    ----------
    value : float
        From 0 to 1.
    error : float
        Estimated: from the same areas at a wider tolerance, or the standard error of a share that was counted.
    counted : bool
        Whether it is the share of the initial conditions, as where geometry does not settle the basins.
    """

    value: float
    error: float
    counted: bool = False

    def __str__(self) -> str:
        return f"{self.value:.10g} +- {self.error:.1g}{', counted' if self.counted else ''}"


@dataclass(frozen=True, repr=False)
class BasinMap(CellMap):
    """The motions that initial conditions lead to.

    Attributes
    ----------
    axes, law, fixed
        As for `ResultsOverAxes`: x0 in m and v0 in m/s, and the oscillator's quantities.
    motion : numpy.ndarray of Motion
        A row for each v0, a column for each x0.
    regime : Regime
        The attractors, and the separatrices of their basins.
    share : dict of Motion to Share
        The part of the box, from the lowest x0 and v0 to the highest, that leads to each motion: by the
        areas inside the separatrices, or counted where geometry does not settle them, or is wrong.
    simulated : int
        How many initial conditions were simulated: those that geometry does not settle, and a sample of the
        others as a check. If that disagrees with geometry all are, as far as the time limit lets.
    disagreements : int
        How many of them lead elsewhere than geometry says; the simulated motion stands.
    notes : dict of (int, int) to str
        By row and column, why an initial condition failed, or what geometry said where it disagrees.
    """

    regime: Regime
    share: dict[Motion, Share]
    simulated: int
    disagreements: int
    notes: dict[tuple[int, int], str]

    @property
    def columns(self) -> dict[str, NDArray[np.generic]]:
        """The motion."""
        return {"motion": files.texts(self.motion)}

    def _masks(self) -> dict[Region, BoolArray]:
        return {region: self.motion == motion for motion, region in regions_of_motions().items()}


def basin_map(
    law: FrictionLaw | str,
    osc: Oscillator,
    *,
    x0: ArrayLike,
    v0: ArrayLike,
    rtol: float = 1e-10,
    workers: int = 1,
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
    workers : int
        Threads for motions that are followed, where numba is there; -1 for all processors.
    time_limit : float, optional
        Seconds after which it is returned as it is: what is not classified by then is undecided, with a note
        that says so.

    Returns
    -------
    BasinMap

    Raises
    ------
    InputError
        For an unusable value, law or `workers`.
    NotConverged
        If the attractors are not found, or every initial condition fails.

    Examples
    --------
    >>> from stickslip_sym import Motion, Oscillator, basin_map, laws
    >>> law, osc = laws.exponential.typical(), Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    >>> found = basin_map(law, osc, x0=[-0.1, 0.0, 0.1], v0=[-0.5, 0.0, 0.5])
    >>> f"{found.share[Motion.REST].value:.6f} of the box come to rest"
    '0.223441 of the box come to rest'
    """
    law = as_law(law)
    osc = as_oscillator(osc)
    rtol = read_rtol(rtol)
    axes = (
        Axis("x0", read_values("x0", x0), "m", "initial displacement"),
        Axis("v0", read_values("v0", v0), "m/s", "initial velocity"),
    )
    x, v = (axis.values for axis in axes)
    require_few(x.size, v.size)
    plane = kept_regime(law, osc, TIGHT)  # separatrices are few, and decide about many initial conditions
    sides = np.full((v.size, x.size), None, dtype=object)
    share = dict[Motion, Share]()

    def simulated(chosen: BoolArray) -> ObjectArray:
        rows, columns = np.nonzero(chosen)
        return followed(law, osc, rtol, np.array([x[columns], v[rows]]), workers)

    def differ(fate: object, side: Motion | None) -> bool:
        return side is not None and isinstance(fate, Motion) and fate not in (side, Motion.UNDECIDED)

    with deadline.time_limit(time_limit):
        with suppress(OutOfTime):
            deadline.check_time()
            sides = plane.by_side(x, v[:, None])
            if min(x.size, v.size) > 1:
                share = shares_by_area(plane, (x[0], x[-1]), (v[0], v[-1]))
        fates = np.full(sides.shape, None, dtype=object)
        known = sides.astype(bool)
        chosen = ~known
        sample = np.flatnonzero(known)
        chosen.flat[np.random.default_rng(SEED).choice(sample, min(sample.size, _CHECKED), replace=False)] = True
        fates[chosen] = simulated(chosen)
        if any(differ(*pair) for pair in zip(fates[known & chosen], sides[known & chosen], strict=True)):
            share = {}  # the sides of the separatrices are not what decides
            fates[~chosen] = simulated(~chosen)
    motion = np.where(fates.astype(bool), fates, sides)
    notes = dict[tuple[int, int], str]()
    disagreements = 0
    for place in zip(*map(np.ndarray.tolist, np.nonzero(fates)), strict=True):
        fate = fates[place]
        if not isinstance(fate, Motion):
            motion[place] = Motion.UNDECIDED
            notes[place] = LATE if isinstance(fate, OutOfTime) else str(fate)
        elif differ(fate, sides[place]):
            disagreements += 1
            notes[place] = f"geometry says {sides[place].value}"
    if len(notes) - disagreements == motion.size and LATE not in notes.values():
        raise NotConverged(f"every initial condition failed, the first one since {notes[0, 0]}")
    if not share:
        for kind in Motion:
            if value := float(np.mean(motion == kind)):
                share[kind] = Share(value, math.sqrt(value * (1 - value) / motion.size), counted=True)
    return BasinMap(
        axes, law, asdict(osc), motion, plane, share, int(fates.astype(bool).sum()), disagreements, notes
    )


def shares_by_area(regime: Regime, x0: tuple[float, float], v0: tuple[float, float]) -> dict[Motion, Share]:
    """Return the shares of a box of initial conditions, by the areas inside the separatrices.

    They are empty where separatrices do not settle the basins.
    """
    if regime.basins is None:
        return {}
    osc = regime.oscillator
    motions = regime.basins
    curves = regime.separatrices
    least = [0.0 if curve.kind == "graze" else float(curve.w(0.0)) for curve in curves]
    q = (np.array(x0) - osc.onset(regime.law)) / osc.length
    w = np.clip(1 - np.array(v0[::-1]) / osc.V, 0.0, None)
    whole = float(q[1] - q[0]) * (v0[1] - v0[0]) / osc.V
    both = curves, kept_regime(regime.law, osc, ADDED * TIGHT).curves(least)  # again, for the error of the areas
    shares = np.array([np.diff([0.0, *(curve.area_within(q, w) / whole for curve in some), 1.0]) for some in both])
    summed = {motion: shares[:, [kind is motion for kind in motions]].sum(axis=1).tolist() for motion in motions}
    return {motion: Share(value, abs(value - rough) + math.ulp(1.0)) for motion, (value, rough) in summed.items()}

"""`basin_sweep`: how the basins of attraction change with one quantity, and where they are born and die.

They do at three kinds of place. Rest gains or loses stability where c = -N mu'(V) (Hopf); stick-slip begins or
ends where the slip from P just touches the belt's speed (graze): both are critical values. Two cycles in pure slip
meet where the damping that slip orbits need has an extremum (fold).
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.maps.basins import Share, shares_by_area
from stickslip_sym.motion.maps.drawing import regions_of_motions
from stickslip_sym.motion.maps.table import Axis, AxisValues, Table, placed, read_axis, read_values
from stickslip_sym.motion.margins.critical import critical
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.cycles import needed_damping
from stickslip_sym.motion.orbits.needed import ROUNDING
from stickslip_sym.motion.regimes.regime import regime
from stickslip_sym.motion.roots import sign_changes
from stickslip_sym.motion.steps import TIGHT

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

_LINES = {"Hopf": ":", "graze": "-", "fold": "--"}
_CLOSE = 1e-9  # relative error that is asked for of a graze, and that of an interpolated damping at a fold
_BESIDE = 1e-4  # relative distance at which the slope at a fold is taken


@dataclass(frozen=True)
class Change:
    """A value at which basins are born or die.

    Attributes
    ----------
    kind : {"Hopf", "graze", "fold"}
    value : float
        In the unit of the axis.
    error : float
        Estimated, absolute; where a fold is only known to lie between two values of the axis, half their distance.
    """

    kind: Literal["Hopf", "graze", "fold"]
    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.kind} at {self.value:.12g} +- {self.error:.1g}"


@dataclass(frozen=True, repr=False)
class BasinSweep(Table):
    """The shares of a box of initial conditions that lead to each motion, over one quantity.

    Attributes
    ----------
    axes, law, fixed
        As for `Table`; the axis is x too.
    share, error : dict of Motion to numpy.ndarray
        As `BasinMap.share` has them; NaN where geometry does not settle the basins.
    changes : tuple of Change
        Where basins are born and die between the first value and the last, by ascending value.
    x0, v0 : tuple of float
        The box: displacements in m, velocities in m/s.
    """

    share: dict[Motion, FloatArray]
    error: dict[Motion, FloatArray]
    changes: tuple[Change, ...]
    x0: tuple[float, float]
    v0: tuple[float, float]

    @property
    def columns(self) -> "dict[str, NDArray[np.generic]]":
        """The share of each motion and its error."""
        kinds = (("share", self.share), ("error", self.error))
        return {f"{kind} of {motion.value}": rows[motion] for motion in self.share for kind, rows in kinds}

    def _summary(self) -> str:
        return "; ".join(map(str, self.changes)) or "no basin is born or dies"

    def _rows(self) -> tuple[Sequence[str], list[list[str]]]:
        rows = [[change.kind, f"{change.value:.12g}", f"{change.error:.1g}"] for change in self.changes]
        return ["where basins are born or die", self.x.label, "error"], rows

    def draw(self, ax: "Axes") -> "list[Artist]":
        """Draw it, and return the handles of its legend."""
        regions = {motion: region for motion, region in regions_of_motions().items() if motion in self.share}
        values, shares = self.x.values, np.array([self.share[motion] for motion in regions])
        for change in self.changes:  # at which shares may jump
            place = int(np.searchsorted(values, change.value))
            sides = shares[:, [max(place - 1, 0), min(place, values.size - 1)]]
            values = np.insert(values, place, [change.value] * 2)
            shares = np.insert(shares, [place, place], sides, axis=1)
            ax.axvline(change.value, color="black", linestyle=_LINES[change.kind], linewidth=1.4)
            ax.annotate(
                f"{change.kind} {change.value:.6g}", (change.value, 0.02), rotation=90, fontsize=8, va="bottom",
                ha="right", backgroundcolor=(1, 1, 1, 0.7),
            )  # fmt: skip
        ax.set(xlabel=self.x.label, ylabel="share of the box of initial conditions", ylim=(0, 1))
        ax.margins(x=0)
        edges = np.vstack([np.zeros(shares.shape[1]), np.cumsum(shares, axis=0)])
        return [ax.fill_between(values, *edges[i : i + 2], **one.look) for i, one in enumerate(regions.values())]


def basin_sweep(
    law: FrictionLaw | str,
    osc: Oscillator,
    over: AxisValues,
    *,
    x0: tuple[float, float],
    v0: tuple[float, float],
    time_limit: float | None = None,
) -> BasinSweep:
    """Return the share of a box of initial conditions that each motion draws, over one quantity.

    The shares are areas inside the separatrices, so nothing is sampled.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    over : (str, array_like)
        V, N, m, k, c or a parameter of the law, and its values, ascending.
    x0, v0 : tuple of float
        The box of initial conditions: from and to, displacements in m and velocities in m/s.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Raises
    ------
    InputError
        For an unusable value, law or box.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> from stickslip_sym import Oscillator, basin_sweep, laws
    >>> law, osc = laws.exponential.typical(), Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
    >>> found = basin_sweep(law, osc, ("c", [1.5, 2.3, 3.0]), x0=(-0.1, 0.1), v0=(-0.5, 0.5))
    >>> [f"{change.kind} {change.value:.6f}" for change in found.changes]
    ['Hopf 1.970016', 'graze 2.573079']
    """
    law, osc = as_law(law), as_oscillator(osc)
    axis = read_axis(law, "over", over)
    box = _limits("x0", x0), _limits("v0", v0)

    def at(value: float) -> tuple[FrictionLaw, Oscillator]:
        return placed(law, asdict(osc) | {axis.name: value})

    values = axis.values.tolist()
    with deadline.time_limit(time_limit):
        regimes = [regime(*at(value), rtol=TIGHT) for value in values]
        shares = [shares_by_area(found, *box) for found in regimes]
        changes = _critical(*at(values[0]), axis)
        for ends, (before, after) in zip(pairwise(values), pairwise(regimes), strict=True):
            if len(before.cycles) != len(after.cycles):
                changes += _folds(at, *ends)
    present = [motion for motion in Motion if any(motion in share for share in shares)]
    none, unsettled = Share(0.0, 0.0), Share(math.nan, math.nan)
    table = {motion: [share.get(motion, none if share else unsettled) for share in shares] for motion in present}
    return BasinSweep(
        (axis,), law, {name: value for name, value in asdict(osc).items() if name != axis.name},
        {motion: np.array([share.value for share in row]) for motion, row in table.items()},
        {motion: np.array([share.error for share in row]) for motion, row in table.items()},
        tuple(sorted(changes, key=lambda change: change.value)), *box,
    )  # fmt: skip


def _limits(name: str, given: tuple[float, float]) -> tuple[float, float]:
    box = read_values(name, given).tolist()
    if len(box) != 2:
        raise InputError(
            f"the box of initial conditions goes from one {name} to a higher one, got {str(given)[:60]}"
        )
    return box[0], box[1]


def _critical(law: FrictionLaw, osc: Oscillator, axis: Axis) -> list[Change]:
    """Return where the damping is critical for rest, and for stick-slip."""
    grid = np.union1d(axis.values, (axis.values[1:] + axis.values[:-1]) / 2).tolist()
    others = {name: value for name, value in asdict(osc).items() if name != axis.name}
    changes = []
    if axis.name not in ("m", "k"):  # on which no average depends
        for one in critical(law, axis.name, **others, method="equilibrium", rtol=_CLOSE, within=grid):
            off = ROUNDING * abs(one.sensitivity.get("c", 1.0) * others.get("c", one.value))
            changes.append(Change("Hopf", one.value, off + ROUNDING * abs(one.value)))
    for one in critical(law, axis.name, **others, rtol=_CLOSE, within=grid):
        changes.append(Change("graze", one.value, (one.relative_error or 0.0) * abs(one.value)))
    return [one for one in changes if grid[0] <= one.value <= grid[-1]]


def _folds(at: Callable[[float], tuple[FrictionLaw, Oscillator]], *ends: float) -> Iterator[Change]:
    """Yield where an extremum of the damping that slip orbits need passes the damping that there is."""

    def excess(value: float) -> FloatArray:
        law, osc = at(value)
        return _extrema(law, replace(osc, c=0.0)) - 2 * osc.zeta

    try:
        values = [excess(value) for value in ends]
        if len(values[0]) == len(values[1]):
            for i, pair in enumerate(zip(*values, strict=True)):
                for value in sign_changes(lambda x, i=i: float(excess(x)[i]), ends, pair, ROUNDING):  # type: ignore[misc]
                    off = _BESIDE * (max(abs(end - value) for end in ends))
                    off = off if value + off < ends[1] else -off
                    slope = float(excess(value + off)[i] - excess(value)[i]) / off
                    error = _CLOSE / abs(slope) if slope else math.inf
                    yield Change("fold", value, error + ROUNDING * abs(value))
            return
    except (InputError, NotConverged):
        pass
    yield Change("fold", sum(ends) / 2, (ends[1] - ends[0]) / 2)  # it is only known to lie between the two


@lru_cache(maxsize=64)  # along c the oscillators of a sweep share them
def _extrema(law: FrictionLaw, osc: Oscillator) -> FloatArray:
    """Return the extrema of the damping that slip orbits need, over sqrt(k m)."""
    need = needed_damping(law, osc)
    return need.at(need.folds)

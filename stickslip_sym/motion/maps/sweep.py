"""`basin_sweep`: how the basins of attraction change with one quantity, and where they are born and die.

They do at three kinds of place. Rest gains or loses stability where c = -N mu'(V) (Hopf); stick-slip begins or
ends where the slip from P just touches the belt's speed (graze): both are critical values. Two cycles in pure slip
meet where the damping that slip orbits need has an extremum (fold).
"""

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
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
from stickslip_sym.motion.orbits.damping import needed_damping
from stickslip_sym.motion.orbits.needed import ROUNDING
from stickslip_sym.motion.regimes.regime import Regime, kept_regime
from stickslip_sym.motion.roots import NEAREST, closest, sign_changes
from stickslip_sym.motion.steps import TIGHT

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

_LINES = {"Hopf": ":", "graze": "-", "fold": "--"}
_CLOSE = 1e-9  # relative error that is asked for of a graze and a fold


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

    @cache
    def at(value: float) -> Regime:
        return kept_regime(*placed(law, asdict(osc) | {axis.name: value}), TIGHT)

    values = axis.values.tolist()
    with deadline.time_limit(time_limit):
        regimes = [at(value) for value in values]
        shares = [shares_by_area(found, *box) for found in regimes]
        changes = _critical(regimes[0].law, regimes[0].oscillator, axis)
        for low, high in pairwise(values):
            changes += _folds(at, low, high, max(abs(low), abs(high)))
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
    kinds: dict[Literal["Hopf", "graze"], str] = {"Hopf": "equilibrium", "graze": "auto"}
    if axis.name in ("m", "k"):  # on which no average depends
        del kinds["Hopf"]
    changes = []
    for kind, method in kinds.items():
        for one in critical(law, axis.name, **others, method=method, rtol=_CLOSE, within=grid):
            error = ROUNDING * abs(one.sensitivity.get("c", 1.0) * others.get("c", one.value))
            own = (one.relative_error or 0.0) if kind == "graze" else ROUNDING  # Hopf points are averages, exactly
            changes.append(Change(kind, one.value, error + own * abs(one.value)))
    return [one for one in changes if grid[0] <= one.value <= grid[-1]]


def _folds(at: Callable[[float], Regime], low: float, high: float, scale: float) -> list[Change]:
    """Return where two cycles in pure slip meet; distances are over a scale.

    Their number changes by two there. By one it changes where rest loses stability, and where a cycle touches the
    belt's speed. Once the two are close, the extremum of the gap between them passes 0 at the fold.
    """
    ends = at(low), at(high)
    numbers = [np.count_nonzero(np.diff(end.growth)) for end in ends]
    change = abs(numbers[0] - numbers[1])
    middle, half = (low + high) / 2, (high - low) / 2
    with suppress(InputError, NotConverged):  # then it is only known to lie between the two
        if change and half > NEAREST * scale:
            return _folds(at, low, middle, scale) + _folds(at, middle, high, scale)
        if change > 1:
            more = max(ends, key=lambda end: len(end.slip_cycles))
            amplitudes = np.array([cycle.amplitude for cycle in more.slip_cycles]) / more.oscillator.V
            first = int(np.argmin(np.diff(amplitudes)))
            inner, outer = amplitudes[first : first + 2].tolist()

            def extremum(value: float) -> float:
                need, damping = needed_damping(at(value).law, at(value).oscillator), 2 * at(value).oscillator.zeta
                sign, flat = -more.growth[first + 1], math.sqrt(ROUNDING)
                return closest(lambda A: need.gap(A, damping), inner, outer, sign, flat)[1]

            error = _CLOSE * scale * (1 + 1 / more.system.eta)  # of weak friction all gaps are small
            for value in sign_changes(extremum, (low, high), (extremum(low), extremum(high)), ROUNDING):
                return [Change("fold", value, error)]
    return [Change("fold", middle, half)] if change > 1 else []

"""`basin_sweep`: how the basins of attraction change with one quantity, and where they are born and die.

They do at three kinds of place. Rest gains or loses stability where c = -N mu'(V) (Hopf); stick-slip begins or
ends where the slip from P just touches the belt's speed (graze): both are critical values. Two cycles in pure slip
meet where the damping that slip orbits need has an extremum (fold).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Literal

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NO_RESULT, InputError
from stickslip_sym.core.numbers import LARGEST, ROUNDING
from stickslip_sym.core.progress import report_counts_to, steps
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator, as_oscillator
from stickslip_sym.motion.kernel.slip_data import TIGHT
from stickslip_sym.motion.maps.basins import Share, shares_by_area
from stickslip_sym.motion.maps.results_over_axes import (
    Axis,
    AxisValues,
    ResultsOverAxes,
    placed,
    read_axis,
    read_values,
)
from stickslip_sym.motion.margins.critical import critical
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.orbits.damping import DAMPING_RTOL, MOST_ORBITS, OF_ORBITS, needed_damping
from stickslip_sym.motion.regimes.regime import Regime, kept_regime
from stickslip_sym.numerics.known import Column, Unknown
from stickslip_sym.numerics.resolved import NO_VALUE, NODES, Piece, Resolved, Turn, fit_polynomial, nodes
from stickslip_sym.numerics.subdivide import Accept, joined
from stickslip_sym.output.data import DataResult

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LEAST_SHARE_OF_RANGE = 1e-4  # of the range of the quantity: extrema come and go within


@dataclass(frozen=True)
class Change(DataResult):
    """A value at which basins are born or die.

    Attributes
    ----------
    kind : {"Hopf", "graze", "fold"}
    value : float
        In the unit of the axis.
    error : float
        Estimated, absolute.
    """

    kind: Literal["Hopf", "graze", "fold"]
    value: float
    error: float

    def __str__(self) -> str:
        return f"{self.kind} at {self.value:.12g} +- {self.error:.1g}"


@dataclass(frozen=True, repr=False)
class BasinSweep(ResultsOverAxes):
    """The shares of a box of initial conditions that lead to each motion, over one quantity.

    Attributes
    ----------
    axes, law, fixed
        As for `ResultsOverAxes`; the axis is x too.
    share, error : dict of Motion to numpy.ndarray
        As `BasinMap.share` has them; NaN where geometry does not settle the basins.
    changes : tuple of Change
        Where basins are born and die between the first value and the last, by ascending value.
    unresolved : tuple of (float, float)
        Between which values there may be folds that `changes` does not have; empty as a rule.
    x0, v0 : tuple of float
        The box: displacements in m, velocities in m/s.
    """

    share: dict[Motion, FloatArray]
    error: dict[Motion, FloatArray]
    changes: tuple[Change, ...]
    unresolved: tuple[tuple[float, float], ...]
    x0: tuple[float, float]
    v0: tuple[float, float]

    @property
    def columns(self) -> dict[str, NDArray[np.generic]]:
        """The share of each motion and its error."""
        kinds = (("share", self.share), ("error", self.error))
        return {f"{kind} of {motion.value}": rows[motion] for motion in self.share for kind, rows in kinds}


def basin_sweep(
    law: FrictionLaw | str,
    osc: Oscillator,
    over: AxisValues,
    *,
    x0: tuple[float, float],
    v0: tuple[float, float],
    progress: Callable[[int, int], object] | None = None,
    time_limit: float | None = None,
) -> BasinSweep:
    """Return the share of a box of initial conditions that each motion draws, over one quantity.

    The shares are areas inside the separatrices, so nothing is sampled. Folds are the extrema of the damping that
    slip orbits need: over c they are read from it, over another quantity from polynomials that follow each.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    over : (str, array_like)
        V, N, m, k, c or a parameter of the law, and its values, ascending.
    x0, v0 : tuple of float
        The box of initial conditions: from and to, displacements in m and velocities in m/s.
    progress : callable, optional
        Called with the number of values that are done, and of all.
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
    law = as_law(law)
    osc = as_oscillator(osc)
    axis = read_axis(law, "over", over)
    box = _limits("x0", x0), _limits("v0", v0)

    @cache
    def at(value: float) -> Regime:
        return kept_regime(*placed(law, asdict(osc) | {axis.name: value}), TIGHT)

    values = axis.values.tolist()
    with deadline.time_limit(time_limit):
        with report_counts_to(progress), steps(values, f"{axis.name} = {{:.4g}}".format) as each:
            shares = [shares_by_area(at(value), *box) for value in each]
        folds, unresolved = _folds(at, values[0], values[-1], axis.name == "c")
        changes = [*_critical(at(values[0]).law, at(values[0]).oscillator, axis), *folds]
    present = [motion for motion in Motion if any(motion in share for share in shares)]
    none = Share(0.0, 0.0)
    unsettled = Share(math.nan, math.nan)
    table = {motion: [share.get(motion, none if share else unsettled) for share in shares] for motion in present}
    return BasinSweep(
        (axis,), law, {name: value for name, value in asdict(osc).items() if name != axis.name},
        {motion: np.array([share.value for share in row]) for motion, row in table.items()},
        {motion: np.array([share.error for share in row]) for motion, row in table.items()},
        tuple(sorted(changes, key=lambda change: change.value)), tuple(unresolved), *box,
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
        for root in critical(
            law, axis.name, **others, method=method, rtol=DAMPING_RTOL, within=(grid[0], grid[-1])
        ):
            error = ROUNDING * abs(root.sensitivity.get("c", 1.0) * others.get("c", root.value))
            # Hopf points are averages, exactly.
            own = (root.relative_error or 0.0) if kind == "graze" else ROUNDING
            changes.append(Change(kind, root.value, error + own * abs(root.value)))
    return [change for change in changes if grid[0] <= change.value <= grid[-1]]


def _folds(
    at: Callable[[float], Regime], low: float, high: float, over_damping: bool
) -> tuple[list[Change], list[tuple[float, float]]]:
    """Return where two cycles in pure slip meet between two values, and where such may be missed.

    They do where an extremum of the needed damping is the damping there is.
    """
    if over_damping:
        need = needed_damping(at(low).law, at(low).oscillator)
        unit = at(low).oscillator.impedance
        folds = [Change("fold", turn.value * unit, turn.error * unit) for turn in need.turns[1:-1]]
        missed = [(low, high)] if need.resolved.open or not need.covers_all_amplitudes else []
        return [fold for fold in folds if low <= fold.value <= high], missed

    @cache
    def excess(value: float) -> list[Turn] | Unknown:
        """Return the extrema of the needed damping minus what there is, with both ends."""
        try:
            osc = at(value).oscillator
            need = needed_damping(at(value).law, osc)
            if need.resolved.open or not need.covers_all_amplitudes:
                return NO_VALUE
        except NO_RESULT as error:
            return Unknown(*error.args)
        unit = osc.impedance
        return [Turn(turn.x, turn.value * unit - osc.c, turn.error * unit) for turn in need.turns]

    folds = list[Change]()
    unresolved = list[tuple[float, float]]()
    left = MOST_ORBITS  # and each takes some
    ranges = [(low, high)]
    while ranges:
        first, last = ranges.pop()
        left -= NODES
        values = nodes(np.array([first]), np.array([last])).ravel()
        rows: list[list[Turn] | Unknown] = [NO_VALUE]
        if left >= 0:
            rows = [excess(x) for x in values.tolist()]
        known = [row for row in rows if not isinstance(row, Unknown)]
        if len(known) == len(rows):
            branches = _branches(first, last, known)
            if branches is not None:
                folds += [fold for piece in branches for fold in _crossings(piece)]
                continue
            if _passed_by(known):
                continue
        if known and last - first > _LEAST_SHARE_OF_RANGE * (high - low):
            middle = (first + last) / 2
            ranges += [(middle, last), (first, middle)]
        else:
            unresolved.append((first, last))
    return folds, joined(unresolved)


def _branches(low: float, high: float, rows: list[list[Turn]]) -> list[Piece] | None:
    """Return extrema between two values as polynomials; None where they come or go, or are not followed."""
    kinds = {(len(turns), turns[0].value < turns[1 % len(turns)].value) for turns in rows}
    if len(kinds) > 1:
        return None
    pieces = list[Piece]()
    for branch in zip(*(turns[1:-1] for turns in rows), strict=True):
        values, errors = (np.array(column) for column in list(zip(*branch, strict=True))[1:])
        decision = fit_polynomial(low, high, Column.of(values, errors, NO_VALUE), OF_ORBITS)
        if not isinstance(decision, Accept):
            return None
        pieces.append(decision.payload)
    return pieces


def _passed_by(rows: list[list[Turn]]) -> bool:
    """Whether all extrema are farther from the damping there is than they move, those that come or go too."""
    moved = 0.0
    values = [np.clip([turn.value for turn in turns], -LARGEST, LARGEST) for turns in rows]
    for before, following in pairwise(values):
        apart = np.abs(before[:, None] - following)
        moved += max(apart.min(axis=0).max(), apart.min(axis=1).max())
    return bool(moved < min((np.abs(row[1:-1]).min() for row in values if row.size > 2), default=math.inf))


def _crossings(piece: Piece) -> list[Change]:
    """Return where an extremum is the damping there is."""
    step = math.sqrt(ROUNDING) * (piece.high - piece.low)
    folds = list[Change]()
    for root in Resolved((piece,), (), OF_ORBITS).roots():
        slope = (piece.at(root.x + step) - piece.at(root.x - step)) / (2 * step)
        folds.append(Change("fold", root.x, piece.error / abs(slope) if slope else piece.high - piece.low))
    return folds

"""A criterion in floats: averages of the falling slope at many belt speeds by Gauss's rule.

Panels in the phase of a harmonic motion, v = V (1 - A cos(theta)), are halved again and again towards rest, so
that features at any part of the belt's speed down to 1e-24 of it are resolved, and parted wherever the law's table
has narrow pieces or kinks. Jumps of mu are added. The slopes have to add up to the rise of mu: by how much they do
not is part of the error.
"""

import math
from collections.abc import Callable, Iterable
from functools import lru_cache, partial
from itertools import chain
from typing import NamedTuple, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import EPSILON, ROUNDING, SAME
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.table import AT_ONCE, RISE_RTOL, FrictionTable

_OCTAVES_TO_REST = round(-math.log2(AT_ONCE) / 2)  # of the phase, whose square is a slip speed
_PANEL_NODES = 16
_MOST_PARTS = 64  # of a panel: falls within a hundredth of their own speed are resolved
_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(_PANEL_NODES)
_DEGREES = np.arange(_PANEL_NODES - 2, _PANEL_NODES)
_HIGHEST_COEFFICIENTS = (_DEGREES[:, None] + 0.5) * np.polynomial.legendre.legvander(_GAUSS, _PANEL_NODES - 1).T[
    _DEGREES
]
"""From what the nodes of a panel add to an integral to the highest coefficients of Legendre's polynomials."""
Slope: TypeAlias = Callable[[FloatArray], FloatArray]
_Others: TypeAlias = tuple[Criterion, FrictionTable, bool, tuple[float, ...]]
_Three: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
_Four: TypeAlias = tuple[FloatArray, FloatArray, FloatArray, FloatArray]
_ROUNDING_OF_MU = 8 * EPSILON  # of mu: what rises are not known to


def gauss_average(
    law: BoundLaw, V: ArrayLike, A: ArrayLike = 1.0, *, criterion: Criterion = harmonic,
    table: FrictionTable | None = None, like: FrictionTable | None = None,
) -> _Three:  # fmt: skip
    """Return averages of -mu' by the weight of a criterion, their errors, and those of abs(mu'), in s/m.

    - `A`: they are over the slip speeds V (1 - A) to V (1 + A), for the harmonic criterion.
    - `table`: that of the law, where it is at hand.
    - `like`: in its place that of a smooth law which this one is the derivative of: it varies at the same speeds.
    """
    slope = partial(law.at_speeds, derivative=True)
    if criterion.weight is None:
        return _slope_at_belt_speed(slope, law.kinks, np.array(V, np.float64).ravel())
    if like is not None:
        return gauss_average_of_slope(slope, like, V, A, criterion=criterion)
    return gauss_average_of_slope(slope, table or law.table, V, A, criterion=criterion, own=True)


def gauss_average_of_slope(
    slope: Slope,
    table: FrictionTable,
    V: ArrayLike,
    A: ArrayLike = 1.0,
    *,
    criterion: Criterion,
    own: bool = False,
) -> _Three:
    """Return the same of a slope, a function of an array of slip speeds.

    - `table`: that of a law which varies at the same speeds.
    - `own`: whether it is that of the law whose slope this is.
    """
    V, A = (np.array(column, np.float64).ravel() for column in np.broadcast_arrays(V, A))
    if criterion.weight is None:
        return _slope_at_belt_speed(slope, table.kinks, V)
    parting = np.unique([*table.narrow.ravel(), *table.kinks])
    inside = (parting > (V * (1 - A))[:, None]) & (parting < (V * (1 + A))[:, None])
    parted = inside.any(axis=1)
    average, error, size = np.empty((3, V.size))
    for rows in chain([np.flatnonzero(~parted)], np.flatnonzero(parted)[:, None]):
        if rows.size:
            ends = tuple((parting[inside[rows[0]]] / V[rows[0]] - 1 + A[rows[0]]) / (2 * A[rows[0]]))
            points = slope, V[rows, None], A[rows, None], criterion, table, own, ends
            average[rows], error[rows], size[rows] = _settled_average(*points)
    return average, error, size


def _slope_at_belt_speed(slope: Slope, kinks: Iterable[float], V: FloatArray) -> _Three:
    """Return -mu'(V); at a kink the mean of the slopes on both sides, by which small motions decay."""
    value = slope(V)
    for kink in kinks:
        at = kink == V
        value[at] = (slope(np.nextafter(V[at], 0.0)) + slope(np.nextafter(V[at], np.inf))) / 2
    return -value, ROUNDING * np.abs(value), np.abs(value)


def _settled_average(slope: Slope, V: FloatArray, A: FloatArray, *others: *_Others) -> _Three:
    """Return what is asked for once polynomials follow it, or panels of half the width say the same.

    Arguments are as for `_sum_over_panels`.
    """
    average, size, off, error = _sum_over_panels(slope, V, A, *others, 1)
    again = np.flatnonzero(~(error <= SAME * np.abs(average)))
    parts = 1
    while again.size and parts < _MOST_PARTS:
        parts *= 2
        finer, size[again], off[again], _ = _sum_over_panels(slope, V[again], A[again], *others, parts)
        error[again] = np.abs(finer - average[again])
        average[again] = finer
        again = again[~(error[again] <= SAME * np.abs(finer))]
    return average, error + off + ROUNDING * size, size


def _sum_over_panels(
    slope: Slope, V: FloatArray, A: FloatArray, criterion: Criterion, table: FrictionTable, own: bool,
    parting: tuple[float, ...], parts: int,
) -> _Four:  # fmt: skip
    """Return averages of -mu' and of abs(mu'), what the sum of slopes is off, and tails, each in s/m.

    - `V`, `A`: columns.
    - `own`: whether the table is that of the law, and not of one which it is the derivative of.
    - `parting`: where panels end, as parts of the range of slip speeds.

    A tail is what the highest two polynomials through the nodes of each panel hold, summed.
    """
    panels = _graded(criterion, parts, parting)
    slopes = slope(V * ((1 - A) + 2 * A * panels.squares))
    # No product of matrices: threads would wait for each other longer than they work.
    fall = slopes * panels.weighted
    average = -fall.sum(axis=1)
    size = np.abs(fall).sum(axis=1)
    tails = np.abs(np.einsum("...j,kj->...k", fall.reshape(len(V), -1, _PANEL_NODES), _HIGHEST_COEFFICIENTS)).sum(
        axis=(1, 2)
    )
    if not own:
        return average, size, 0.0 * average, tails

    speeds = V * ((1 - A) + 2 * A * panels.ends)
    values = table.values(speeds)
    rises = np.diff(values, axis=1)
    for kink, jump in zip(table.kinks, table.jumps[1:].tolist(), strict=True):
        if jump and parting and speeds[0, 0] < kink < speeds[0, -1]:
            at = int(np.abs(speeds[0] - kink).argmin())
            height = jump * panels.heights[at] / (V * A)[:, 0]
            average = average - height
            size = size + np.abs(height)
            rises[:, at - (speeds[0, at] >= kink)] -= jump  # of the panel on whose side rounding put the end
    # Slopes at rounded speeds do not add up to the rise where mu is steep; the rise is what counts there.
    summed = (slopes * panels.share).reshape(len(V), -1, _PANEL_NODES).sum(axis=2)
    lack, off = _lacking_rise(rises / (V * A) - summed, V * A, np.abs(values), panels.heights)
    average -= lack
    return average, size, np.where(speeds[:, -1] <= table.end, off, np.inf), tails


def _lacking_rise(
    lack: FloatArray, per_slope: FloatArray, sizes: FloatArray, heights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what rises that the sums of slopes lack add to -<mu'>, and what that may be off.

    - `lack`: of each panel, as a slope; `per_slope` turns it into a rise.
    - `sizes`: of mu at the ends of the panels.
    - `heights`: the weight there.
    """
    larger = np.maximum(sizes[:, 1:], sizes[:, :-1])
    amount = np.abs(lack) * per_slope
    # Far out it is a difference of numbers that are nearly the same, and the slopes are what is known.
    lack[amount <= _ROUNDING_OF_MU * larger] = 0.0
    middle = (heights[1:] + heights[:-1]) / 2

    # Where in a panel it lacks is not known, nor whether it does where a table may be off by as much.
    highest = np.maximum(heights[1:], heights[:-1])
    change = np.abs(np.diff(heights))
    uncertain = np.where(amount <= RISE_RTOL * larger, highest, change)
    return (lack * middle).sum(axis=1), (np.abs(lack) * uncertain).sum(axis=1)


class _Panels(NamedTuple):
    """Panels in the phase theta, and Gauss's nodes on each, as parts of the range of slip speeds.

    - `ends`, `squares`: sin(theta/2)^2 at the ends of the panels, and at the nodes.
    - `share`: of each node of s = (v - V)/(V A).
    - `weighted`: times the weight of the criterion.
    - `heights`: that weight at the ends.
    """

    ends: FloatArray
    squares: FloatArray
    share: FloatArray
    weighted: FloatArray
    heights: FloatArray


@lru_cache(maxsize=32)
def _graded(criterion: Criterion, parts: int, parting: tuple[float, ...]) -> _Panels:
    """Return panels that are graded towards rest, each cut into parts."""
    whole = np.unique([0.0, *np.pi * 2.0 ** np.arange(-_OCTAVES_TO_REST, 1), *2 * np.arcsin(np.sqrt(parting))])
    ends = np.interp(np.arange(parts * (whole.size - 1) + 1) / parts, np.arange(whole.size), whole)
    half = np.diff(ends)[:, None] / 2
    theta = (ends[:-1, None] + half * (1 + _GAUSS)).ravel()
    share = (half * _WEIGHTS).ravel() * np.sin(theta)
    squares = np.sin(theta / 2) ** 2
    at_ends = np.sin(ends / 2) ** 2
    weights = _weight(criterion, theta)
    heights = _weight(criterion, ends)
    return _Panels(at_ends, squares, share, share * weights, heights)


def _weight(criterion: Criterion, theta: FloatArray) -> FloatArray:
    """Return the weight of a criterion at phases."""
    values: FloatArray = _kernel_from_ends(criterion)(2 * np.sin(theta / 2) ** 2, 2 * np.cos(theta / 2) ** 2)
    return values + 0.0 * theta  # of a constant weight


@lru_cache(maxsize=32)
def _kernel_from_ends(criterion: Criterion) -> Callable[[FloatArray, FloatArray], FloatArray]:
    p, q = sp.symbols("p q", positive=True)
    return function_of([p, q], criterion.from_ends(p, q), "numpy")

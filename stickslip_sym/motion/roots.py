"""Where functions of one quantity change their sign.

The damping d(A) that a periodic orbit of amplitude A V needs lies above that of the oscillator where orbits grow
in a round, and below where they shrink. So a limit cycle lies between two amplitudes where one grows and the other
does not. Where both do the same, there is none between them if they do it by much more than their growth bends;
else the range of amplitudes is halved, down to beside a fold.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray

NEAREST = 1e-3
"""Lowest amplitude over the belt's speed that is looked at; a smaller cycle shows by the growth at rest."""

_RANGES = 4  # of amplitude at first; graded towards the belt's speed, where laws are steep
_SEARCHED = 3  # halvings of a range with a cycle in it, so that no pair of others hides there
_MOST_HALVINGS = 9
_BENT = 2.0  # times its second difference, by which a value is far from a level; a parabola comes no closer


class OrbitSigns(NamedTuple):
    """What the slip orbits of each row do.

    - `cycle`, `stable`: whether there is a limit cycle in pure slip up to the belt's speed, and a stable one.
    - `open`: row, and two amplitudes between which it is not known whether the value touches 0: beside a fold, or
      since values are missing.
    """

    cycle: BoolArray
    stable: BoolArray
    open: list[tuple[int, float, float]]


def orbit_signs(value: Callable[[IntArray, FloatArray], FloatArray], grows_at_rest: BoolArray) -> OrbitSigns:
    """Return where functions of amplitude, one for each row, lie above 0 and where below.

    - `value`: of the sign of the growth in a round, by the numbers of rows and the amplitudes over V.
    - `grows_at_rest`: whether it is positive in the limit of small amplitudes, an entry for each row.
    """
    rows = np.arange(len(grows_at_rest))
    places = np.broadcast_to(np.linspace(0, 1, _RANGES + 1), (rows.size, _RANGES + 1))
    values = value(np.repeat(rows, _RANGES + 1), _amplitude(places.ravel())).reshape(places.shape)
    cycle = (values[:, 0] > 0) != grows_at_rest  # smaller than all that are looked at
    stable, left_open = cycle & grows_at_rest, list[tuple[int, float, float]]()
    row, bends = np.repeat(rows, _RANGES), np.full((rows.size, _RANGES), np.inf)
    ranges = np.array([places[:, :-1], places[:, 1:], values[:, :-1], values[:, 1:], bends]).reshape(5, -1)
    for halvings in range(_MOST_HALVINGS + 1):
        low, high, at_low, at_high, bend = ranges
        least, most, margin = np.minimum(at_low, at_high), np.maximum(at_low, at_high), _BENT * bend
        inside = (least <= 0) & (most >= 0)
        unsure = ~(inside | (least > margin) | (most < -margin))
        left = unsure | inside
        if halvings >= _SEARCHED:
            cycle[row[inside]] = True
            stable[row[inside & (at_low > at_high)]] = True
            left = unsure
        # One value that is no number may lie at a zero; where two beside each other are, so are those between.
        given_up = unsure if halvings == _MOST_HALVINGS else np.isnan(at_low) & np.isnan(at_high)
        left_open += zip(row[given_up].tolist(), *_amplitude(ranges[:2, given_up]).tolist(), strict=True)
        left &= ~np.isin(row, row[given_up])
        if not left.any():
            break
        row, (low, high, at_low, at_high, _) = row[left], ranges[:, left]
        middle = (low + high) / 2
        at_middle = value(row, _amplitude(middle))
        bend = np.abs(at_low + at_high - 2 * at_middle)
        ranges = np.hstack([[low, middle, at_low, at_middle, bend], [middle, high, at_middle, at_high, bend]])
        row = np.tile(row, 2)
    return OrbitSigns(cycle, stable, left_open)


def _amplitude(place: FloatArray) -> FloatArray:
    """Return amplitudes over the belt's speed at places from 0 to 1."""
    return np.asarray(NEAREST + (1 - NEAREST) * (1 - np.cos(np.pi * place)) / 2)

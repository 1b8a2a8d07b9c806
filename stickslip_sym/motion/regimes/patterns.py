"""Between which amplitudes slip orbits grow and between which they shrink, for many oscillators at once.

The damping d(A) that a periodic orbit of amplitude A V needs (`cycles`) lies above that of the oscillator where
orbits grow in a round, and below where they shrink. So a limit cycle lies between two amplitudes where one grows
and the other does not. Where both do the same, there is none between them if the return map, which grows with
A since orbits do not cross, takes the one beyond the other; or if the growth is far from 0 for how it bends. Else
the amplitudes between are looked at, up to a fold.
"""

from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.motion.regimes.rounds import AWAY, CREEPS, RETURN, TURN, Family, arrive

__all__ = ["Patterns", "patterns"]

_NEAREST, _LAST = 1e-3, 1 - 1e-6  # amplitudes over the belt's speed; smaller cycles show by the growth at rest
_FIRST = 8  # ranges of amplitude; graded towards the belt's speed, where laws are steep
_CYCLE, _MOST_HALVINGS = 2, 8  # of these ranges: where there is a cycle, and where it is not known
_BENT = 2.0  # times its second difference, by which the growth is far from 0; a parabola comes closer by an eighth
_RTOL = 1e-7  # of steps, over the amplitude
_ESCAPED = 1e6  # the next peak over V of a motion that goes on ever faster
_UNSURE = 1e-5  # growth in a round of which integrations do not tell the sign


@dataclass(frozen=True)
class Patterns:
    """What slip orbits do, one entry for each oscillator.

    Attributes
    ----------
    cycle, stable : numpy.ndarray of bool
        Whether there is a limit cycle in pure slip up to the belt's speed, and a stable one.
    grows : numpy.ndarray of bool
        Whether the orbits next to the belt's speed grow.
    known : numpy.ndarray of bool
        False beside a fold or a bifurcation, or where a slip was not followed to its end.
    """

    cycle: BoolArray
    stable: BoolArray
    grows: BoolArray
    known: BoolArray


@dataclass
class _Ranges:
    """Ranges of amplitude, of which several may belong to one oscillator."""

    row: IntArray
    low: FloatArray  # 0 to 1 for the lowest to the highest amplitude, as the next
    high: FloatArray
    after_low: FloatArray  # the next peaks
    after_high: FloatArray
    bend: FloatArray  # of the growth, its second difference over the range and what is next to it

    def some(self, chosen: BoolArray) -> "_Ranges":
        columns = (self.low, self.high, self.after_low, self.after_high, self.bend)
        return _Ranges(self.row[chosen], *(column[chosen] for column in columns))


def patterns(family: Family, zeta: FloatArray, at_rest: FloatArray) -> Patterns:
    """Return where slip orbits grow.

    - `zeta`: damping ratios.
    - `at_rest`: those below which rest is unstable.
    """
    count = len(zeta)
    cycle, stable, known = np.zeros((3, count), bool)
    known[:] = True
    rows, places = np.arange(count), np.arange(_FIRST + 1) / _FIRST
    after = _after(family, zeta, np.repeat(rows, _FIRST + 1), np.tile(places, count)).reshape(count, _FIRST + 1)
    growth = after / _amplitude(places) - 1
    bends = np.abs(np.diff(growth, n=2))
    bends = np.maximum(bends[:, [0, *range(_FIRST - 1)]], bends[:, [*range(_FIRST - 1), _FIRST - 2]])
    low, high = (np.tile(side, count) for side in (places[:-1], places[1:]))
    left = _Ranges(np.repeat(rows, _FIRST), low, high, after[:, :-1].ravel(), after[:, 1:].ravel(), bends.ravel())
    grows, falls = after[:, 0] > _NEAREST, after[:, 0] <= _NEAREST
    born = np.where(at_rest > zeta, falls, grows)  # a cycle that is smaller than all that are followed
    cycle |= born
    stable |= born & falls
    for halvings in range(_MOST_HALVINGS):
        A_low, A_high = _amplitude(left.low), _amplitude(left.high)
        gains = left.after_low / A_low - 1, left.after_high / A_high - 1
        least = np.minimum(*np.abs(gains))
        known[left.row[~(least > _UNSURE)]] = False
        between = (gains[0] > 0) != (gains[1] > 0)
        if halvings >= _CYCLE:
            cycle[left.row[between]] = True
            stable[left.row[between & (gains[0] > 0)]] = True
            passed = between
        else:
            passed = np.zeros(between.shape, bool)
        passed |= (left.after_low >= A_high) | (left.after_high <= A_low) | ~between & (least > _BENT * left.bend)
        left = left.some(~passed & known[left.row])
        if not left.row.size:
            break
        middle = (left.low + left.high) / 2
        at_middle = _after(family, zeta, left.row, middle)
        A_low, A_high = _amplitude(left.low), _amplitude(left.high)
        bend = np.abs(left.after_low / A_low + left.after_high / A_high - 2 * at_middle / _amplitude(middle))
        left = _Ranges(
            np.tile(left.row, 2), np.r_[left.low, middle], np.r_[middle, left.high],
            np.r_[left.after_low, at_middle], np.r_[at_middle, left.after_high], np.tile(bend, 2),
        )  # fmt: skip
    known[left.row] = False
    return Patterns(cycle, stable, after[:, -1] > _LAST, known)


def _amplitude(place: FloatArray) -> FloatArray:
    return np.asarray(_NEAREST + (_LAST - _NEAREST) * (1 - np.cos(np.pi * place)) / 2)


def _after(family: Family, zeta: FloatArray, row: IntArray, place: FloatArray) -> FloatArray:
    """Return the next peaks over V: 1 + w'^2/2 where the mass meets the belt, 0 at rest, NaN if not known."""
    some, A = family.rows(row), _amplitude(place)
    w = 1 - A
    q = 2 * zeta[row] * w - some.friction(w, some.piece(w))
    found = arrive(some, zeta[row], q, w, _RTOL * A)
    codes = [found.end == code for code in (TURN, RETURN, CREEPS, AWAY)]
    return np.select(codes, [1 - found.w, 1 + found.slope**2 / 2, 0.0, _ESCAPED], np.nan)

"""Branches of sweeps: rising and falling speed, both directions, and by how much friction differs between them.

Friction of a rising speed is above or below that of a falling one by its hysteresis, and a force sensor with an
offset shows another coefficient in each direction. Beside a smooth curve of the speed both differences are linear
in what is sought: an offset times the direction, and a polynomial of the speed, half of it for each branch.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.special import chdtri

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.numbers import ROOT_OF_ROUNDING
from stickslip_sym.core.probabilities import VERY_UNLIKELY
from stickslip_sym.core.uncertain import text_with_error
from stickslip_sym.model.measured.noise import SAME_COEFFICIENT, correlation_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_SHARE_OF_TURN = 0.1  # of the range of speeds: a smaller return of the speed is jitter, and ends no branch
_RELATIVE_DWELL_WIDTH = 0.02  # relative: rows this near to a turn's speed dwell there, half of them on each branch
_FEWEST_SPEEDS_OF_BRANCH = 4  # speeds of a branch; rows in random order turn after one or two
_IN_ORDER = 0.8  # share of the rows that belong to such branches where speeds were swept
ROWS_TO_SAMPLE = 10_000  # rows, that tell of more what they are like: a curve to a hundredth of their noise
_MOST_HYSTERESIS_DEGREE = 4  # degree of the hysteresis in the share of rows below a speed
_MOST_COLUMNS = 30  # of the smooth curve, one for `_ROWS_A_COLUMN` rows
_ROWS_A_COLUMN = 6
_WORTH_A_TERM = float(chdtri(1, VERY_UNLIKELY))  # fall of n log(sum of squares), which noise shows very seldom
FEW = 0.05  # share of the rows, of which less does not matter


@dataclass(frozen=True, eq=False)
class SweepBranches:
    """How rows of measurements were swept, and by how much branches and directions differ.

    Attributes
    ----------
    rising, falling : int
        Numbers of branches; 0 where speeds were not swept up and down.
    sweep : ndarray of shape (n,)
        1 for a row on a rising branch, -1 on a falling one, 0 where there are none.
    terms : ndarray of shape (n, q)
        The columns that differ between branches or directions, whose factors the measurements settle.
    hysteresis : ndarray of shape (n,)
        By how much mu of a row is above the mean of both branches.
    gap, standard_error : float
        By how much mu is larger on rising branches, on average.
    offset : float
        What was taken from mu in the direction of positive speed, and added in the other.
    alone : str
        Where rows are on rising or on falling branches only, so that their mean is not measured; empty if nowhere.
    """

    reported = ("rising", "falling", "gap", "standard_error", "offset", "alone")

    rising: int
    falling: int
    sweep: IntArray
    terms: FloatArray
    hysteresis: FloatArray
    gap: float = 0.0
    standard_error: float = 0.0
    offset: float = 0.0
    alone: str = ""

    @property
    def differ(self) -> bool:
        """Whether rising and falling branches differ."""
        return bool(self.hysteresis.any())

    def __str__(self) -> str:
        said = []
        if self.offset:
            said.append(f"an offset of mu between the directions, {self.offset:.3g}, removed")
        if self.rising:
            counts = f"{self.rising} rising and {self.falling} falling branch{'es' * (self.falling > 1)}"
            gap = text_with_error(abs(self.gap), self.standard_error)
            above = "rising" if self.gap > 0 else "falling"
            cause = "hysteresis" if self.rising + self.falling > 2 else "hysteresis, or drift"
            apart = "alike"
            if self.differ:
                apart = f"{above} above by {gap} on average ({cause}), their mean taken"
            said.append(f"{counts}, {apart}" + f"; {self.alone}" * bool(self.alone and self.differ))
        return ", ".join(said)


def sweep_branches_of(
    v: FloatArray, mu: FloatArray, weights: FloatArray, order: IntArray, direction: IntArray | None = None
) -> SweepBranches | None:
    """Return how rows at ascending speeds, of which `order` says where they stood, were swept; None for one sweep.

    `direction` is 1 or -1 where both directions were measured, and 0 for a row without one.
    """
    sweep = np.zeros(len(v), dtype=np.int64)
    rising = 0
    falling = 0
    in_turn = np.argsort(order)
    sweep[in_turn], rising, falling = _sweeps(v[in_turn])
    both = direction is not None and (direction > 0).any() and (direction < 0).any()
    if not (rising or both):
        return None
    names = list[str]()
    columns = list[FloatArray]()
    if direction is not None and both and np.less_equal(*_shared_speeds(v, direction)):
        # Elsewhere one curve describes both.
        names.append("offset")
        columns.append(direction.astype(np.float64))
    if rising:
        hysteresis = _branch_terms(v, sweep)
        names += ["hysteresis"] * len(hysteresis)
        columns += hysteresis
    none = SweepBranches(rising, falling, sweep, np.zeros((len(v), 0)), np.zeros(len(v)))
    smooth = weights[:, None] * splines(v).toarray()
    if not columns or len(v) < smooth.shape[1] + len(columns) + _FEWEST_SPEEDS_OF_BRANCH:
        return none if rising else None
    columns_of_curve, triangle = np.linalg.qr(smooth)
    rotation, sizes, _ = np.linalg.svd(triangle)
    # Where no speed lies between knots, a curve has no size.
    curve = columns_of_curve @ rotation[:, sizes > ROOT_OF_ROUNDING * sizes[0]]

    def beside(rows: FloatArray) -> FloatArray:
        rest: FloatArray = rows - curve @ (curve.T @ rows)
        return rest

    terms = weights[:, None] * np.array(columns).T
    left = beside(terms)
    y = beside(weights * mu)
    apart = np.linalg.norm(left, axis=0) > ROOT_OF_ROUNDING * np.linalg.norm(terms, axis=0)
    n = len(v) - curve.shape[1]
    best = math.inf
    chosen = list[int]()
    if not (apart.any() and mu.any()):
        return none if rising else None
    all_terms = np.flatnonzero(apart)
    rest = y - left[:, all_terms] @ np.linalg.lstsq(left[:, all_terms], y, rcond=None)[0]
    floor = n * (SAME_COEFFICIENT * float(np.max(np.abs(weights * mu)))) ** 2
    alike = 1.0  # so many rows count as one
    if rest @ rest > floor:
        alike, _, _ = correlation_of(rest[in_turn], 0)
    for tried in _choices(names):
        if not apart[tried].all():
            continue
        rest = y - left[:, tried] @ np.linalg.lstsq(left[:, tried], y, rcond=None)[0]
        score = n / alike * math.log(max(float(rest @ rest), floor)) + _WORTH_A_TERM * len(tried)
        if score < best:
            best = score
            chosen = tried
            variance = float(rest @ rest) / (n - len(tried))
    if not chosen:
        return none if rising else None
    factors = np.linalg.lstsq(left[:, chosen], y, rcond=None)[0]
    covariance = alike * variance * np.linalg.inv(left[:, chosen].T @ left[:, chosen])
    of_gap = np.array([names[i] == "hysteresis" for i in chosen])
    raw = np.array(columns).T[:, chosen]
    mean = np.mean(2 * sweep[:, None] * raw, axis=0) * of_gap
    return SweepBranches(
        rising, falling, sweep, raw,
        hysteresis=(raw * of_gap) @ factors,
        gap=float(mean @ factors),
        standard_error=float(np.sqrt(mean @ covariance @ mean)),
        offset=float(np.sum(factors[~of_gap])),
        alone=_alone(v, sweep) if rising else "",
    )  # fmt: skip


def _choices(names: Sequence[str]) -> list[list[int]]:
    """Return which terms may be there: with the offset or without, and the hysteresis up to some degree."""
    offset = [i for i, name in enumerate(names) if name == "offset"]
    degrees = [i for i, name in enumerate(names) if name == "hysteresis"]
    return [
        first + degrees[:count] for count in range(len(degrees) + 1) for first in ([], offset)[: 1 + len(offset)]
    ]


def _sweeps(v: FloatArray) -> tuple[IntArray, int, int]:
    """Return 1 for each row, in turn, of a rising branch and -1 of a falling one, and the numbers of both."""
    if _is_shuffled(v):
        return np.zeros(len(v), dtype=np.int64), 0, 0
    ends = np.array([0, *_turns(v), len(v)])
    lengths = np.diff(ends)
    halves = (lengths + 1) // 2
    apart = _sums(v, ends[1:] - halves, ends[1:]) - _sums(v, ends[:-1], ends[:-1] + halves)
    ways = np.where(apart >= 0, 1, -1)
    run = np.repeat(np.arange(len(lengths)), lengths)
    swept = _different(v, run, len(lengths)) >= _FEWEST_SPEEDS_OF_BRANCH
    rising, falling = (int((swept & (ways == way)).sum()) for way in (1, -1))
    if not (rising and falling) or lengths[swept].sum() < _IN_ORDER * len(v):
        return np.zeros(len(v), dtype=np.int64), 0, 0
    return ways[run], rising, falling


def _sums(v: FloatArray, first: IntArray, end: IntArray) -> FloatArray:
    """Return the sum of the rows from each first to before each end."""
    ends = np.column_stack([first, end]).ravel()
    sums = np.add.reduceat(np.append(v, 0.0), ends)[::2]
    return np.where(end > first, sums, 0.0)


def _different(v: FloatArray, run: IntArray, count: int) -> IntArray:
    """Return how many different speeds each run of rows has."""
    order = np.lexsort((v, run))
    new = np.r_[True, (np.diff(v[order]) != 0) | (np.diff(run[order]) != 0)]
    return np.bincount(run[order][new], minlength=count)


def _is_shuffled(v: FloatArray) -> bool:
    """Return whether many rows are in random order, as stretches of them tell: most branches have too few rows."""
    if len(v) <= ROWS_TO_SAMPLE:
        return False
    rows = math.isqrt(ROWS_TO_SAMPLE)  # in as many stretches
    stretches = np.linspace(0, len(v) - rows, rows).astype(int)
    turns = sum(len(_turns(v[first : first + rows], float(np.ptp(v)))) for first in stretches)
    # Branches for a row, if enough rows are on branches of enough rows.
    most = 1 / _FEWEST_SPEEDS_OF_BRANCH + 1 - _IN_ORDER
    return turns > most * ROWS_TO_SAMPLE


def _turns(v: FloatArray, span: float | None = None) -> list[int]:
    """Return the rows with which new branches begin; a dwell at a turn is halved."""
    least = _SHARE_OF_TURN * (float(np.ptp(v)) if span is None else span)
    turns = list[int]()
    way = 0
    low = 0
    high = 0
    lowest = highest = float(v[0])
    for i, speed in enumerate(v.tolist()):
        if speed < lowest:
            low = i
            lowest = speed
        if speed > highest:
            high = i
            highest = speed
        if way >= 0 and highest - speed > least:
            if way:
                turns += [high]
            way = -1
            low = i
            lowest = speed
        elif way <= 0 and speed - lowest > least:
            if way:
                turns += [low]
            way = 1
            high = i
            highest = speed
    middles = []
    for turn in turns:
        first = last = turn
        near = min(_RELATIVE_DWELL_WIDTH * v[turn], least / 2)  # else a row might dwell at two turns
        while first > 0 and abs(v[first - 1] - v[turn]) <= near:
            first -= 1
        while last < len(v) - 1 and abs(v[last + 1] - v[turn]) <= near:
            last += 1
        middles.append((first + last) // 2 + 1)
    return middles


def _knots(v: FloatArray) -> FloatArray:
    """Return speeds with as many rows between any two."""
    return np.unique(
        np.quantile(v, np.linspace(0, 1, int(np.clip(len(v) // _ROWS_A_COLUMN - 2, 2, _MOST_COLUMNS - 2))))
    )


def splines(v: FloatArray) -> "csr_array":
    """Return the cubic splines of the speed between such knots as columns; a constant for one speed."""
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_array

    knots = _knots(v)
    if len(knots) < 2:
        return csr_array(np.ones((len(v), 1)))
    return csr_array(BSpline.design_matrix(v, np.pad(knots, 3, mode="edge"), 3))


def _branch_terms(v: FloatArray, sweep: IntArray) -> list[FloatArray]:
    """Return polynomials of the speed, where both branches reach it, and held beyond, as half of a difference."""
    low, high = _shared_speeds(v, sweep)
    shared = [sweep[(v >= low) & (v <= high)] == way for way in (1, -1)]
    if low >= high or min(map(np.sum, shared)) < _FEWEST_SPEEDS_OF_BRANCH:
        return []
    knots = _knots(v)  # the polynomials are as fine as the rows are dense
    share = np.interp(np.clip(v, low, high), knots, np.linspace(0, 1, len(knots)))
    x = 2 * (share - share[0]) / (share[-1] - share[0]) - 1
    return list(np.polynomial.legendre.legvander(x, _MOST_HYSTERESIS_DEGREE).T * sweep / 2)


def _shared_speeds(v: FloatArray, side: IntArray) -> tuple[float, float]:
    """Return the lowest and the highest speed that both kinds of branches, or both directions, reach."""
    up = v[side > 0]
    down = v[side < 0]
    return float(max(up[0], down[0])), float(min(up[-1], down[-1]))


def _alone(v: FloatArray, sweep: IntArray) -> str:
    """Return where more than a few rows are on one kind of branch only."""
    low, high = _shared_speeds(v, sweep)
    said = []
    for outside, where in ((v < low, f"below {low:.3g} m/s"), (v > high, f"above {high:.3g} m/s")):
        if outside.sum() > FEW * len(v):
            said.append(f"{where} {'rising' if sweep[outside].sum() > 0 else 'falling'} branches only")
    return ", ".join(said)

"""The least squares of a friction law and measurements, by SciPy's `leastsq` with exact derivatives."""

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from heapq import heapify, heappop, heappush
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from scipy.optimize import least_squares, leastsq, lsq_linear

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import NEXT_TO_ZERO, ROOT_OF_ROUNDING, ROUNDING, SAME, SEED
from stickslip_sym.model.at_rest import reals
from stickslip_sym.model.expression.dimensions import parse_unit
from stickslip_sym.model.fitting.features import PHASES, SearchGrid, features_of
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements

_CONVERGED = range(1, 5)  # what `leastsq` returns where one of its tolerances is met
_LARGEST_LOGARITHM = -math.log(NEXT_TO_ZERO)  # of a positive value

_STARTS = 4  # different ones; for most laws the best few of the trials lead to one minimum
_TRIALS = 40  # for each parameter in which mu is not linear; half of them where each has grids
_BEYOND = 4.0  # times 1, and its inverse, for pure numbers that are tried; for speeds, times the measured ones
_RESIDUALS_A_BATCH = 500_000  # residuals of a grid that are computed at a time
_GAPS_LOOKED_AT = 60  # gaps between speeds on either side, among which a place is looked for again
_BEST_OF_GRID = 2  # neighbours, each with the same wave half a turn on, which bounds of its height may ask for


class Minimum(NamedTuple):
    """Where a sum of squares is least, and the sum."""

    p: FloatArray
    chi_squared: float


class Problem:
    """The least squares of a law and measurements: residuals are divided by sigma where it is known.

    Differences between branches and directions have factors of their own, which are eliminated.
    """

    def __init__(self, law: FrictionLaw, measured: Measurements) -> None:
        self.law = law
        self.measured = measured
        used = {name: p for name, p in law.parameters.items() if p.symbol in law.expr.free_symbols}
        self.names = tuple(name for name in used if name not in law.values)
        known = tuple(name for name in used if name in law.values)
        free, bound = ([used[name].symbol for name in names] for names in (self.names, known))
        slopes = [sp.diff(law.expr, symbol) for symbol in free]
        arguments = [symbols.v, *free, *bound]
        self._value, self._derivatives = (function_of(arguments, rows, "numpy") for rows in ([law.expr], slopes))
        linear: list[Expr] = []  # jointly: each with those before it
        for symbol, slope in zip(free, slopes, strict=True):
            if slope != 0 and not slope.has(symbol, *linear):  # it is 0 for the place of a jump
                linear.append(symbol)
        basis = [slope for symbol, slope in zip(free, slopes, strict=True) if symbol in linear]
        self._basis = function_of(arguments, basis, "numpy")
        self.known = [float(law.values[name]) for name in known]
        self.positive = np.array([used[name].positive for name in self.names], dtype=bool)
        self.linear = np.array([symbol in linear for symbol in free], dtype=bool)
        self._units = [used[name].unit for name in self.names]
        self._v = np.maximum(measured.v, NEXT_TO_ZERO)  # a power of 0 has no derivative by its exponent
        self._weights = measured.weights
        self._mu = measured.project_out_branches(self._weights * measured.mu)
        self.sought = np.flatnonzero(~self.linear).tolist()
        self.features = features_of(law.expr, free, bound, self.sought, measured.speeds)

    def residuals(self, p: FloatArray) -> FloatArray:
        """Return the measured less the fitted coefficients, times the weights; NaN where mu is not real."""
        return np.asarray(self._mu - self._weighted(self._value, p)[0])

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of the fitted coefficients to the parameters, times the weights: shape (n, k)."""
        return self._weighted(self._derivatives, p).T

    def _weighted(self, function: Callable[..., Any], p: Sequence[FloatArray] | FloatArray) -> FloatArray:
        """Return rows of a function times the weights, at one set of values or, by columns, at a grid of them."""
        v = self._v
        grids = p
        if isinstance(p, list):
            shape = np.broadcast_shapes(v.shape, *map(np.shape, p))
            v = np.broadcast_to(v, shape)
            grids = [np.broadcast_to(values, shape) for values in p]  # conditions have one shape
        with np.errstate(all="ignore"):
            values = function(v, *grids, *self.known)
            rows = np.empty((len(values), *v.shape))
            for row, column in zip(rows, values, strict=True):
                row[...] = self._weights * reals(column)
            return self.measured.project_out_branches(rows)

    def minimum(self, start: FloatArray) -> Minimum | None:
        """Return the minimum that a start leads to, kinks and jumps in the best gap near; None without one."""
        logarithmic = self.positive & ~self.linear  # their bound 0 is no law's value: their logarithms are varied
        highest = np.where(logarithmic, _LARGEST_LOGARITHM, np.inf)
        lowest = np.where(self.positive & self.linear, 0.0, -highest)
        # Beside one as large, what other rows leave would be rounding.
        outside = float(np.max(np.abs(self._weights * self.measured.mu))) / ROOT_OF_ROUNDING + 1.0

        def values(x: FloatArray) -> FloatArray:
            p = x.copy()
            with np.errstate(over="ignore"):
                p[logarithmic] = np.exp(x[logarithmic])
            return p

        def residuals(x: FloatArray) -> FloatArray:
            left = -self.residuals(values(x))
            left[np.isnan(left)] = outside
            return left.clip(-outside, outside)

        def slopes(x: FloatArray) -> FloatArray:
            p = values(x)
            with np.errstate(all="ignore"):
                raw = self.jacobian(p) * np.where(logarithmic, p, 1.0)
            return np.where(np.isfinite(raw), raw.clip(-1 / NEXT_TO_ZERO, 1 / NEXT_TO_ZERO), 0.0)

        p = start
        if len(start):
            begin = np.where(logarithmic, np.log(np.maximum(start, np.exp(-_LARGEST_LOGARITHM))), start)
            begin = np.clip(begin, lowest, highest)  # rounding may leave a start just outside
            how: dict[str, Any] = {"ftol": SAME, "xtol": SAME}
            # Levenberg and Marquardt's method knows no bounds, and follows flat valleys in fewer steps.
            with np.errstate(all="ignore"):  # in its covariance, which is not used
                x, _, _, _, status = leastsq(
                    residuals,
                    begin,
                    Dfun=slopes,
                    full_output=True,
                    gtol=ROUNDING,
                    **how,
                )
            if (x < lowest).any() or (x > highest).any():
                result = least_squares(
                    residuals, begin, slopes, bounds=(lowest, highest), method="dogbox",
                    x_scale="jac", gtol=None, **how,
                )  # fmt: skip
                if result.status <= 0:
                    return None
                x = result.x
            elif status not in _CONVERGED:
                return None
            p = values(x)
        chi_squared = float(np.sum(self.residuals(p) ** 2))
        if not np.isfinite(chi_squared):
            return None
        for feature in self.features:
            if feature.breaks:
                moved = self._moved(p, feature, self.levels_near(feature, p))
                if np.sum(self.residuals(moved) ** 2) < (1 - ROOT_OF_ROUNDING) * chi_squared:
                    return self.minimum(moved)
        return Minimum(p, chi_squared)

    def measured_at(self, feature: SearchGrid, p: FloatArray) -> float:
        """Return the place in m/s, or the radians, of a feature."""
        with np.errstate(all="ignore"):
            return float(feature.measure(*p, *self.known))

    def levels_near(self, feature: SearchGrid, p: FloatArray) -> FloatArray:
        """Return the middles of the gaps between speeds that are next to a place."""
        speeds = self.measured.speeds[self.measured.speeds > 0]
        gap = int(np.searchsorted(speeds, self.measured_at(feature, p)))
        near = speeds[max(gap - _GAPS_LOOKED_AT, 0) : gap + _GAPS_LOOKED_AT]
        return (near[1:] + near[:-1]) / 2

    def _moved(self, p: FloatArray, feature: SearchGrid, levels: FloatArray) -> FloatArray:
        """Return values with a feature at the best of some levels, all but the linear ones kept."""
        points = feature.grid(p, self.known, levels)
        if not len(points):
            return p
        best = points[np.argsort(self._misfits(points), kind="stable")[:_BEST_OF_GRID]]
        for i, rate in feature.phases:
            turned = best.copy()
            turned[:, i] *= 1 + np.pi / (
                turned[:, i] * [abs(float(rate(*candidate, *self.known))) for candidate in best]
            )
            best = np.concatenate([best, turned])
        tried = [self._with_linear(candidate) for candidate in best]
        return min(tried, key=lambda candidate: np.nan_to_num(np.sum(self.residuals(candidate) ** 2), nan=np.inf))

    def _misfits(self, points: FloatArray) -> FloatArray:
        """Return the sum of squares at each of many values, least over the linear ones of any sign."""
        size = max(1, _RESIDUALS_A_BATCH // len(self._v))
        misfits = list[FloatArray]()
        for first in range(0, len(points), size):
            columns = list(np.where(self.linear, 0.0, points[first : first + size]).T[:, :, None])
            target = self._mu - self._weighted(self._value, columns)[0]
            left = np.sum(target**2, axis=1)
            if self.linear.any():
                matrix = np.nan_to_num(self._weighted(self._basis, columns).transpose(1, 2, 0))
                matrix = matrix / np.maximum(np.linalg.norm(matrix, axis=1, keepdims=True), 1e-300)
                moments = np.einsum("gnk,gn->gk", matrix, np.nan_to_num(target))
                normal = matrix.transpose(0, 2, 1) @ matrix + ROOT_OF_ROUNDING * np.eye(matrix.shape[2])
                left = left - np.sum(moments * np.linalg.solve(normal, moments[:, :, None])[:, :, 0], axis=1)
            misfits.append(np.nan_to_num(left, nan=np.inf))
        return np.concatenate(misfits)

    def rivals(self, best: FloatArray) -> Iterator[tuple[int, Minimum]]:
        """Yield the least minimum away from each wave and smooth place, with the parameter that it differs in."""
        for feature in self.features:
            points = feature.grid(best, self.known, feature.levels)
            if feature.breaks or len(points) < 2:
                continue
            block = len(PHASES) ** len(feature.phases)
            misfits = self._misfits(points).reshape(-1, block)
            least = misfits.min(axis=1)
            levels = np.array([self.measured_at(feature, node) for node in points[::block]])
            low = high = int(np.argmin(np.abs(levels - self.measured_at(feature, best))))
            while low > 0 and least[low - 1] >= least[low]:
                low -= 1
            while high < len(least) - 1 and least[high + 1] >= least[high]:
                high += 1
            outside = np.r_[0:low, high + 1 : len(least)]
            if len(outside):
                row = int(outside[np.argmin(least[outside])])
                minimum = self.minimum(self._with_linear(points[row * block + int(np.argmin(misfits[row]))]))
                around = levels[max(low - 1, 0)], levels[min(high + 1, len(levels) - 1)]
                if minimum is None or around[0] <= self.measured_at(feature, minimum.p) <= around[1]:
                    continue  # it led to the best
                yield feature.moved, minimum

    def starts(self) -> Iterator[FloatArray]:
        """Yield a few starts that differ, the best of random trials first."""
        moved = {i for feature in self.features for i in (feature.moved, *dict(feature.phases))}
        a_gap = 1 / len(self.measured.speeds)  # relative, between the highest of even speeds
        apart = np.where([i in moved for i in self.sought], a_gap, np.log(2))
        chosen = np.empty((0, len(self.sought)))
        for p in self._best_first(self._trials(moved)):
            sought = p[self.sought]
            with np.errstate(divide="ignore", invalid="ignore"):
                distances = np.abs(np.log(sought / chosen))
            if (distances <= apart).all(axis=1).any():
                continue

            yield p
            chosen = np.vstack([chosen, sought])
            if len(chosen) == _STARTS:
                return

    def _trials(self, moved: Collection[int]) -> list[FloatArray]:
        """Return random values where mu is not linear in them, with places and waves moved to their best."""
        count = _TRIALS * sum(i not in moved for i in self.sought)
        if self.features:
            count //= 2

        passes = 1
        if len(self.features) > 1:
            passes = 2  # each is moved again, once the others are
            count = max(count, _STARTS)

        trials = list[FloatArray]()
        draw = self._drawing()
        for _ in range(max(count, 1)):
            p = draw()
            for feature in self.features * passes:
                p = self._moved(p, feature, feature.levels)
            trials.append(p)
        return trials

    def _drawing(self) -> Callable[[], FloatArray]:
        """Return what draws values: powers of speeds near the measured ones, and pure numbers."""
        rng = np.random.default_rng(SEED)
        powers = [_power_of_speed(self._units[i]) for i in self.sought]
        speeds = 0.1, 1.0  # where all are at rest
        above = self._v[self._v > NEXT_TO_ZERO]
        if len(above):
            speeds = above.min() / _BEYOND, above.max() * _BEYOND

        def draw() -> FloatArray:
            p: FloatArray = np.zeros(len(self.names))
            for i, power in zip(self.sought, powers, strict=True):
                sign = 1 if self.positive[i] else int(rng.choice([-1, 1]))
                if power is None:
                    power = int(rng.choice([-1, 0, 1]))
                size = float(np.exp(rng.uniform(*np.log(speeds if power else (1 / _BEYOND, _BEYOND)))))
                p[i] = sign * size ** (power or 1)
            return p

        return draw

    def _best_first(self, trials: Sequence[FloatArray]) -> Iterator[FloatArray]:
        """Yield trials with the best of their linear values, in ascending order of the sum of squares.

        That with linear values of any sign is no larger, and says which trials need not be solved yet.
        """
        least = self._misfits(np.array(trials))
        waiting: list[tuple[float, int, bool]] = [(float(misfit), i, False) for i, misfit in enumerate(least)]
        heapify(waiting)
        solved = dict[int, FloatArray]()
        while waiting:
            misfit, i, is_solved = heappop(waiting)
            if is_solved:
                yield solved[i]
                continue
            solved[i] = self._with_linear(trials[i])
            misfit = float(np.sum(self.residuals(solved[i]) ** 2))
            if np.isfinite(misfit):
                heappush(waiting, (misfit, i, True))

    def _with_linear(self, p: FloatArray) -> FloatArray:
        """Return the values with the best of those in which mu is linear, not below 0 where they are positive."""
        p = np.where(self.linear, 0.0, p)
        target = self.residuals(p)
        matrix = self.jacobian(p)[:, self.linear]
        if not (np.isfinite(target).all() and np.isfinite(matrix).all()):
            return np.full_like(p, np.nan)
        if self.linear.any():
            sizes = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
            lowest = np.where(self.positive[self.linear], 0.0, -np.inf)
            p[self.linear] = lsq_linear(matrix / sizes, target, bounds=(lowest, np.inf), method="bvls").x / sizes
        return p


def _power_of_speed(unit: str | None) -> int | None:
    """Return which power of a speed a unit is; None if it is not known, or no power of a speed."""
    if unit is None:
        return None
    powers = {str(base): power for base, power in parse_unit(unit).as_powers_dict().items() if base != 1}
    length = powers.pop("[m]", 0)
    time = powers.pop("[s]", 0)
    if length == -time and int(length) == length and not powers:
        return int(length)
    return None

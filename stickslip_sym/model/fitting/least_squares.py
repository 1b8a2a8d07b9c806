"""The least squares of a friction law and measurements, by SciPy's `least_squares` with exact derivatives."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import sympy as sp
from scipy.optimize import least_squares, lsq_linear

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.at_rest import reals
from stickslip_sym.model.expression.units import parse_unit
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements

_AT_REST = 1e-200  # m/s, in place of 0, where a power of v has no derivative with respect to its exponent
_TOLERANCE = 1e-11  # relative, of the sum of squares and of the values; rounding allows 1e-14
_EVALUATIONS = 600  # of the law, for one start; more are needed only where values grow without bound
_OUTSIDE = 1e6  # largest residual, in units of the largest weighted mu, and where the law has no real value
_LARGEST_LOGARITHM = 690.0  # of a positive value, short of overflow
_STEEPEST = 1e100  # largest derivative of a residual: its square and sums of such are finite

_SEED = 1785
_TRIALS = 40  # for each parameter in which mu is not linear
_BEYOND = 3.0  # factor above the largest and below the smallest measured speed, between which speeds are tried
_EXPONENTS = 0.2, 4.0  # the range of pure numbers that are tried
_APART = 0.7  # natural logarithms by which some value differs between two starts


class Minimum(NamedTuple):
    """Where a sum of squares is least, and the sum."""

    p: FloatArray
    chi_squared: float


class Problem:
    """The least squares of a law and measurements: residuals are divided by sigma where it is known."""

    def __init__(self, law: FrictionLaw, measured: Measurements) -> None:
        self.law, self.measured = law, measured
        used = {name: p for name, p in law.parameters.items() if p.symbol in law.expr.free_symbols}
        self.names = tuple(name for name in used if name not in law.values)
        known = tuple(name for name in used if name in law.values)
        free, bound = ([used[name].symbol for name in names] for names in (self.names, known))
        slopes = [sp.diff(law.expr, symbol) for symbol in free]
        self._value, self._derivatives = (
            function_of([symbols.v, *free, *bound], rows, "numpy") for rows in ([law.expr], slopes)
        )
        linear: list[Expr] = []  # jointly: each with those before it
        for symbol, slope in zip(free, slopes, strict=True):
            if slope != 0 and not slope.has(symbol, *linear):  # it is 0 for the place of a jump
                linear.append(symbol)
        self._known = [float(law.values[name]) for name in known]
        self.positive = np.array([used[name].positive for name in self.names], dtype=bool)
        self.linear = np.array([symbol in linear for symbol in free], dtype=bool)
        self._units = [used[name].unit for name in self.names]
        self._v, self._weights = np.maximum(measured.v, _AT_REST), measured.weights

    def residuals(self, p: FloatArray) -> FloatArray:
        """Return the measured less the fitted coefficients, times the weights; NaN where mu is not real."""
        return np.asarray(self._weights * self.measured.mu - self._weighted(self._value, p)[0])

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of the fitted coefficients to the parameters, times the weights: shape (n, k)."""
        return self._weighted(self._derivatives, p).T

    def _weighted(self, function: Callable[..., Any], p: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            values = function(self._v, *p, *self._known)
            return np.array([self._weights * reals(np.broadcast_to(one, self._v.shape)) for one in values])

    def minimum(self, start: FloatArray) -> Minimum | None:
        """Return the minimum that a start leads to; None if it does not converge."""
        logarithmic = self.positive & ~self.linear  # their bound 0 is no law's value: their logarithms are varied
        highest = np.where(logarithmic, _LARGEST_LOGARITHM, np.inf)
        lowest = np.where(self.positive & self.linear, 0.0, -highest)
        outside = _OUTSIDE * float(np.max(np.abs(self._weights * self.measured.mu))) + 1.0

        def values(x: FloatArray) -> FloatArray:
            return np.where(logarithmic, np.exp(np.where(logarithmic, x, 0.0)), x)

        def residuals(x: FloatArray) -> FloatArray:
            return np.nan_to_num(np.clip(-self.residuals(values(x)), -outside, outside), nan=outside)

        def slopes(x: FloatArray) -> FloatArray:
            p = values(x)
            with np.errstate(all="ignore"):
                raw = self.jacobian(p) * np.where(logarithmic, p, 1.0)
            return np.where(np.isfinite(raw), np.clip(raw, -_STEEPEST, _STEEPEST), 0.0)

        p = start
        if len(start):
            begin = np.where(logarithmic, np.log(np.maximum(start, np.exp(-_LARGEST_LOGARITHM))), start)
            result = least_squares(
                residuals, np.clip(begin, lowest, highest), slopes,  # rounding may leave a start just outside
                bounds=(lowest, highest), method="dogbox",
                x_scale="jac", ftol=_TOLERANCE, xtol=_TOLERANCE, gtol=None, max_nfev=_EVALUATIONS,
            )  # fmt: skip
            if result.status <= 0:
                return None
            p = values(result.x)
        chi_squared = float(np.sum(self.residuals(p) ** 2))
        return Minimum(p, chi_squared) if np.isfinite(chi_squared) else None

    def starts(self, count: int) -> list[FloatArray]:
        """Return up to `count` starts that differ, the best of random trials first."""
        rng = np.random.default_rng(_SEED)
        sought = np.flatnonzero(~self.linear)
        powers = [_power_of_speed(self._units[i]) for i in sought]
        above = self._v[self._v > _AT_REST]
        speeds = (above.min() / _BEYOND, above.max() * _BEYOND) if len(above) else (0.1, 1.0)
        tried: list[Minimum] = []
        for _ in range(_TRIALS * len(sought) if len(sought) else 1):
            p: FloatArray = np.zeros(len(self.names))
            for i, known in zip(sought, powers, strict=True):
                sign = 1 if self.positive[i] else int(rng.choice([-1, 1]))
                power = int(rng.choice([-1, 0, 1])) if known is None else known
                drawn = float(np.exp(rng.uniform(*np.log(speeds if power else _EXPONENTS))))
                p[i] = sign * drawn ** (power or 1)
            p = self._with_linear(p)
            misfit = float(np.sum(self.residuals(p) ** 2))
            if np.isfinite(misfit):
                tried.append(Minimum(p, misfit))
        chosen: list[FloatArray] = []
        for p, _ in sorted(tried, key=lambda trial: trial.chi_squared):
            with np.errstate(divide="ignore", invalid="ignore"):
                near = [(np.abs(np.log(p[sought] / other[sought])) <= _APART).all() for other in chosen]
            if len(chosen) < count and not any(near):
                chosen.append(p)
        return chosen

    def _with_linear(self, p: FloatArray) -> FloatArray:
        """Return the values with the best of those in which mu is linear, not below 0 where they are positive."""
        target, matrix = self.residuals(p), self.jacobian(p)[:, self.linear]
        if not (np.isfinite(target).all() and np.isfinite(matrix).all()):
            return np.full_like(p, np.nan)
        if self.linear.any():
            sizes = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
            lowest = np.where(self.positive[self.linear], 0.0, -np.inf)
            p = p.copy()
            p[self.linear] = lsq_linear(matrix / sizes, target, bounds=(lowest, np.inf), method="bvls").x / sizes
        return p


def _power_of_speed(unit: str | None) -> int | None:
    """Return which power of a speed a unit is; None if it is not known, or no power of a speed."""
    if unit is None:
        return None
    powers = {str(base): power for base, power in parse_unit(unit).as_powers_dict().items() if base != 1}
    length, time = powers.pop("[m]", 0), powers.pop("[s]", 0)
    return int(length) if length == -time and int(length) == length and not powers else None

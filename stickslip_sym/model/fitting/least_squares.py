"""The least squares of a friction law and measurements, by SciPy's `least_squares` with exact derivatives."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.expression.units import parse_unit
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements

__all__ = ["Minimum", "Parametric", "Problem"]

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


class Parametric:
    """mu(v; p) of a law at some speeds, where p are the parameters without a value.

    Parameters
    ----------
    law : FrictionLaw
    v : ndarray
        In m/s; 0 stands for the limit 0+.

    Attributes
    ----------
    names : tuple of str
        The free parameters.
    positive : ndarray of bool
        Whether each of them is never negative.
    linear : ndarray of bool
        Whether mu is linear in each, jointly with the others that are marked.
    """

    def __init__(self, law: FrictionLaw, v: FloatArray) -> None:
        parameters = {name: p for name, p in law.parameters.items() if p.symbol in law.expr.free_symbols}
        self._value, self._derivatives, linear = _compiled(law.expr, tuple(p.symbol for p in parameters.values()))
        self._values = np.array([float(law.values.get(name, np.nan)) for name in parameters])
        self._free = np.isnan(self._values)
        self._v = np.maximum(v, _AT_REST)
        self.names = tuple(name for name in parameters if name not in law.values)
        self.positive = np.array([parameters[name].positive for name in self.names], dtype=bool)
        self.linear = np.array(linear, dtype=bool)[self._free]

    def mu(self, p: FloatArray) -> FloatArray:
        """Return the coefficients at the speeds, of shape (n,); not finite where there is none."""
        return self._reals(self._value, p).ravel()

    def jacobian(self, p: FloatArray) -> FloatArray:
        """Return the derivatives of mu to the free parameters, of shape (n, len(names))."""
        return self._reals(self._derivatives, p)[self._free, :].T

    def _reals(self, function: Callable[..., Any], p: FloatArray) -> NDArray[np.float64]:
        values = self._values.copy()
        values[self._free] = p
        with np.errstate(all="ignore"):
            results = [np.broadcast_to(result, self._v.shape) for result in function(self._v, *values)]
        return np.array([np.where(np.imag(result) == 0, np.real(result), np.nan) for result in results])


@lru_cache(maxsize=128)
def _compiled(
    expr: Expr, parameters: tuple[Expr, ...]
) -> tuple[Callable[..., Any], Callable[..., Any], tuple[bool, ...]]:
    """Return a formula and its derivatives as functions of arrays, and in which parameters it is linear."""
    derivatives = [sp.diff(expr, parameter) for parameter in parameters]
    linear: list[Expr] = []
    for parameter, derivative in zip(parameters, derivatives, strict=True):
        if not derivative.has(parameter, *linear):
            linear.append(parameter)
    value, slopes = (function_of([symbols.v, *parameters], rows, "numpy") for rows in ([expr], derivatives))
    return value, slopes, tuple(parameter in linear for parameter in parameters)


@dataclass(frozen=True)
class Minimum:
    """Where a sum of squares is least: the values, which of them the bound 0 holds, and the sum."""

    p: FloatArray
    held: BoolArray
    chi_squared: float


class Problem:
    """The least squares of a law and measurements: residuals are divided by sigma where it is known.

    Positive parameters in which mu is not linear are varied as logarithms: their bound 0 is no law's value. Those
    in which it is linear may be held at 0; the others are free.
    """

    def __init__(self, law: FrictionLaw, measured: Measurements) -> None:
        self.model = Parametric(law, measured.v)
        self._law, self._v, self._mu, self._weights = law, measured.v, measured.mu, measured.weights
        self._logarithmic = self.model.positive & ~self.model.linear
        self._outside = _OUTSIDE * float(np.max(np.abs(self._weights * self._mu))) + 1.0

    def residuals(self, p: FloatArray) -> FloatArray:
        """Return the measured less the fitted coefficients, times the weights, of shape (n,)."""
        return self._weights * (self._mu - self.model.mu(p))

    def minimum(self, start: FloatArray, fixed: int | None = None) -> Minimum | None:
        """Return the minimum that a start leads to, over all values but one; None if it does not converge."""
        from scipy.optimize import least_squares

        varied = np.arange(len(start)) != fixed
        if not varied.any():
            return self._at(start)
        lowest = np.where(self._logarithmic, -_LARGEST_LOGARITHM, np.where(self.model.positive, 0.0, -np.inf))
        highest = np.where(self._logarithmic, _LARGEST_LOGARITHM, np.inf)
        everything = np.where(self._logarithmic, np.log(np.maximum(start, np.exp(-_LARGEST_LOGARITHM))), start)
        everything = np.clip(everything, lowest, highest)  # rounding may leave a start just outside

        def whole(x: FloatArray) -> FloatArray:
            values = everything.copy()
            values[varied] = x
            return np.where(self._logarithmic, np.exp(np.where(self._logarithmic, values, 0.0)), values)

        result = least_squares(
            lambda x: self._bounded(whole(x)), everything[varied], lambda x: self._slopes(whole(x))[:, varied],
            bounds=(lowest[varied], highest[varied]), method="dogbox", x_scale="jac", ftol=_TOLERANCE,
            xtol=_TOLERANCE, gtol=None, max_nfev=_EVALUATIONS,
        )  # fmt: skip
        return self._at(whole(result.x)) if result.status > 0 else None

    def _at(self, p: FloatArray) -> Minimum | None:
        chi_squared = float(np.sum(self.residuals(p) ** 2))
        held = self.model.positive & self.model.linear & (p == 0)
        return Minimum(p, held, chi_squared) if np.isfinite(chi_squared) else None

    def _bounded(self, p: FloatArray) -> FloatArray:
        residuals = -self.residuals(p)
        return np.where(np.isfinite(residuals), np.clip(residuals, -self._outside, self._outside), self._outside)

    def _slopes(self, p: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            slopes = self._weights[:, None] * self.model.jacobian(p) * np.where(self._logarithmic, p, 1.0)
        return np.where(np.isfinite(slopes), np.clip(slopes, -_STEEPEST, _STEEPEST), 0.0)

    def starts(self, count: int) -> list[FloatArray]:
        """Return up to `count` starts that differ, the best first.

        For some values of the others, the parameters in which mu is linear are the solution of a linear problem.
        So only the others are tried, at random on the scale that their unit gives: a speed among the measured
        speeds, an exponent about 1.
        """
        rng = np.random.default_rng(_SEED)
        sought = np.flatnonzero(~self.model.linear)
        powers = {i: _power_of_speed(self._law.parameters[self.model.names[i]].unit) for i in sought}
        tried: list[tuple[float, FloatArray]] = []
        for _ in range(_TRIALS * len(sought) if len(sought) else 1):
            p: FloatArray = np.zeros(len(self.model.names))
            for i in sought:
                sign = 1 if self.model.positive[i] else int(rng.choice([-1, 1]))
                p[i] = sign * _draw(rng, powers[i], self._v)
            p = self._with_linear(p)
            misfit = float(np.sum(self.residuals(p) ** 2))
            if np.isfinite(misfit):
                tried.append((misfit, p))
        chosen: list[FloatArray] = []
        for _, p in sorted(tried, key=lambda trial: trial[0]):
            if len(chosen) < count and all(_differ(p[sought], other[sought]) for other in chosen):
                chosen.append(p)
        return chosen

    def _with_linear(self, p: FloatArray) -> FloatArray:
        """Return the values with the best of those in which mu is linear, not below 0 where they are positive."""
        from scipy.optimize import lsq_linear

        linear = self.model.linear
        if not linear.any():
            return p
        target, matrix = self.residuals(p), (self._weights[:, None] * self.model.jacobian(p))[:, linear]
        if not (np.isfinite(target).all() and np.isfinite(matrix).all()):
            return np.full_like(p, np.nan)
        sizes = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
        lowest = np.where(self.model.positive[linear], 0.0, -np.inf)
        p = p.copy()
        p[linear] = lsq_linear(matrix / sizes, target, bounds=(lowest, np.inf), method="bvls").x / sizes
        return p


def _differ(p: FloatArray, other: FloatArray) -> bool:
    with np.errstate(divide="ignore", invalid="ignore"):
        return bool((~(np.abs(np.log(p / other)) <= _APART)).any())


def _power_of_speed(unit: str | None) -> int | None:
    """Return which power of a speed a unit is; None if it is not known, or no power of a speed."""
    if unit is None:
        return None
    powers = {str(base): power for base, power in parse_unit(unit).as_powers_dict().items() if base != 1}
    length, time = powers.pop("[m]", 0), powers.pop("[s]", 0)
    return int(length) if length == -time and int(length) == length and not powers else None


def _draw(rng: np.random.Generator, power: int | None, v: FloatArray) -> float:
    """Return a positive value of a plausible size."""
    if power is None:
        power = int(rng.choice([-1, 0, 1]))
    if power == 0:
        return float(np.exp(rng.uniform(*np.log(_EXPONENTS))))
    above = v[v > 0]
    low, high = (above.min() / _BEYOND, above.max() * _BEYOND) if len(above) else (0.1, 1.0)
    return float(np.exp(rng.uniform(np.log(low), np.log(high)))) ** power

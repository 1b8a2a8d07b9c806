"""The least squares of a law and measurements, solved by lmfit with exact derivatives."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.parametric import Parametric

if TYPE_CHECKING:
    from lmfit import Minimizer, Parameters

__all__ = ["Minimum", "Problem", "require_lmfit"]

FloatArray = NDArray[np.float64]

_TOLERANCE = 1e-11  # relative, of the sum of squares and of the values; rounding allows 1e-14
_EVALUATIONS = 600  # of the law, for one start; more are needed only where values grow without bound
_OUTSIDE = 1e6  # largest residual, in units of the largest weighted mu, and where the law has no real value
_TINY = 1e-300  # a positive value, short of underflow; its inverse is the largest
_STEEPEST = 1e100  # largest derivative of a residual: its square and sums of such are finite


def require_lmfit() -> None:
    """Refuse to fit without lmfit."""
    try:
        import lmfit  # noqa: F401  # only to see that it is there
    except ImportError:
        raise InputError('fits need lmfit: pip install "stickslip_sym[fit]"') from None


@dataclass(frozen=True)
class Minimum:
    """Where a sum of squares is least: the values, which of them the bound 0 holds, the sum, and its AIC."""

    p: FloatArray
    held: NDArray[np.bool_]
    chi_squared: float
    aic: float


class Problem:
    """Least squares of a law and measurements, as lmfit solves them.

    Positive parameters in which mu is not linear are varied as logarithms: their bound 0 is no law's value. The
    others are free, and one that would be below its bound 0 is held there: a transformation that keeps it
    above has no derivative at the bound, where the method then creeps.
    """

    def __init__(self, model: Parametric, measured: Measurements) -> None:
        self.model = model
        self.mu = measured.mu
        self.weights = np.ones(len(measured)) if measured.sigma is None else 1 / measured.sigma
        self.logarithmic = model.positive & ~model.linear
        self._outside = _OUTSIDE * float(np.max(np.abs(self.weights * self.mu))) + 1.0

    def minimum(self, start: FloatArray) -> Minimum | None:
        """Return the minimum that a start leads to; None if it does not converge."""
        held = np.zeros(len(start), dtype=bool)
        for _ in range(2 * len(start) + 1):
            result = self.minimizer(start, held).leastsq()
            p = self.values(result.params)
            below = self.model.positive & (p < 0)
            if below.any():
                held = held | below
                if held.all():
                    return None
                start = np.where(held, 0.0, p if result.success else start)
                continue
            if not result.success:
                return None
            residual = self.weights * (self.model.mu(p) - self.mu)
            if not np.isfinite(residual).all():
                return None
            inward = held.copy()
            inward[held] = self._derivatives(result.params, held).T @ residual < 0
            if not inward.any():
                return Minimum(p, held, float(result.chisqr), float(result.aic) + 2 * int(held.sum()))
            held, start = held & ~inward, p
        return None

    def minimizer(self, start: FloatArray, held: NDArray[np.bool_]) -> "Minimizer":
        """Return lmfit's minimizer of the weighted residuals, with exact derivatives."""
        import lmfit

        parameters = lmfit.Parameters()
        for i, value in enumerate(start):  # names of our own: those of a law may mean something to lmfit
            varied = np.log(np.clip(value, _TINY, 1 / _TINY)) if self.logarithmic[i] else value
            parameters.add(f"p{i}", value=float(varied), vary=not held[i])
        return lmfit.Minimizer(
            self._residual, parameters, scale_covar=False, Dfun=self._derivatives, ftol=_TOLERANCE,
            xtol=_TOLERANCE, max_nfev=_EVALUATIONS,
        )  # fmt: skip

    def values(self, parameters: "Parameters") -> FloatArray:
        """Return the law's values of lmfit's parameters."""
        p = np.array([parameter.value for parameter in parameters.values()])
        with np.errstate(over="ignore"):
            return np.where(self.logarithmic, np.exp(np.where(self.logarithmic, p, 0.0)), p)

    def _residual(self, parameters: "Parameters") -> FloatArray:
        found = self.weights * (self.model.mu(self.values(parameters)) - self.mu)
        return np.where(np.isfinite(found), np.clip(found, -self._outside, self._outside), self._outside)

    def _derivatives(self, parameters: "Parameters", chosen: NDArray[np.bool_] | None = None) -> FloatArray:
        p = self.values(parameters)
        inner = np.where(self.logarithmic, p, 1.0)
        varying = [parameter.vary for parameter in parameters.values()] if chosen is None else chosen
        with np.errstate(all="ignore"):
            found = (self.weights[:, None] * self.model.jacobian(p) * inner)[:, varying]
        return np.where(np.isfinite(found), np.clip(found, -_STEEPEST, _STEEPEST), 0.0)

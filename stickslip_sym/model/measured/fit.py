"""`Fit`: a law with values from measurements, and how well they are known."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.parametric import FittedLaw, Parametric
from stickslip_sym.output import markup
from stickslip_sym.output.drawing import Drawn, picture
from stickslip_sym.output.tables import table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Fit"]

_HEADS = ["parameter", "value", "95 % interval", "unit"]

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Drawn):
    """A friction law fitted to measurements.

    Attributes
    ----------
    law : FrictionLaw
        Bound with the fitted values.
    values : dict of str to float
        Of the parameters that were fitted.
    covariance : ndarray of shape (k, k)
        Of the fitted parameters, in the order of `values`.
    measured : Measurements
    chi_squared : float
        Sum of the squared residuals, divided by sigma where it is known.
    dof : int
        Degrees of freedom n - k: rows less parameters.
    aicc : float
        Akaike's criterion, corrected for few rows: less is better.
    weight : float
        Akaike weight among the laws that were fitted together: 1 if no other could be meant.
    warnings : tuple of str
        What the measurements do not determine, and what to fix.

    References
    ----------
    K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, Springer 2002: AICc and weights.
    """

    law: Any
    values: Mapping[str, float]
    covariance: FloatArray
    measured: Measurements
    chi_squared: float
    dof: int
    aicc: float
    weight: float = 1.0
    warnings: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The law's name, or its formula."""
        return str(self.law.name or self.law.text)

    @property
    def standard_errors(self) -> dict[str, float]:
        """Standard error of each fitted parameter."""
        return dict(zip(self.values, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> FloatArray:
        """Correlations of the fitted parameters, of shape (k, k)."""
        errors = np.sqrt(np.diag(self.covariance))
        return np.asarray(self.covariance / np.outer(errors, errors))

    @property
    def sigma(self) -> float:
        """Residual standard deviation of mu: the root of sum (mu_i - mu(v_i))^2 / (n - k)."""
        return float(np.sqrt(np.sum(self.residuals**2) / self.dof))

    @cached_property
    def residuals(self) -> FloatArray:
        """Measured less fitted coefficients, of shape (n,)."""
        return np.asarray(self.measured.mu - self._model(self.measured.v).mu(self._p))

    @cached_property
    def uncertain(self) -> dict[str, UFloat]:
        """The fitted parameters as correlated `uncertainties.UFloat`."""
        import warnings

        from uncertainties import correlated_values

        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that a standard error of 0 says nothing
            return dict(zip(self.values, correlated_values(list(self._p), self.covariance), strict=True))

    @property
    def free_law(self) -> FittedLaw:
        """The law without the values that were fitted."""
        from copy import copy

        free = copy(self.law)
        free._values = {name: value for name, value in self.law._values.items() if name not in self.values}
        return free  # type: ignore[no-any-return]

    def confidence(self, level: float = 0.95, *, profile: bool = False) -> dict[str, tuple[float, float]]:
        """Return an interval for each fitted parameter that holds the true value with a probability.

        Parameters
        ----------
        level : float
            The probability, between 0 and 1.
        profile : bool
            Search where the sum of squares has risen so far, instead of the standard error times a quantile of
            Student's t (of the normal distribution where sigma is known). It serves where the law bends much in
            its parameters, and takes longer.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.
        """
        quantile = self._quantile(level)
        if profile:
            from stickslip_sym.model.measured.profiles import profile_intervals

            return profile_intervals(self.free_law, self.measured, self.values, self.standard_errors, level)
        errors = self.standard_errors
        return {
            name: (value - quantile * errors[name], value + quantile * errors[name])
            for name, value in self.values.items()
        }

    def band(self, v: ArrayLike, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper end of the interval that holds the true mu at each speed, to first order."""
        speeds = np.asarray(v, dtype=np.float64)
        model = self._model(speeds)
        derivatives, mu = model.jacobian(self._p), model.mu(self._p)
        half = self._quantile(level) * np.sqrt(np.einsum("ni,ij,nj->n", derivatives, self.covariance, derivatives))
        return mu - half, mu + half

    def _quantile(self, level: float) -> float:
        from scipy.special import ndtri, stdtrit

        if not 0 < level < 1:
            raise InputError(f"level = {level:g} is no probability between 0 and 1; 0.95 is usual")
        above = (1 + level) / 2
        return float(ndtri(above) if self.measured.sigma is not None else stdtrit(self.dof, above))

    @property
    def _p(self) -> FloatArray:
        return np.array(list(self.values.values()))

    def _model(self, v: FloatArray) -> Parametric:
        return Parametric(self.free_law, v)

    def _rows(self) -> list[list[str]]:
        errors, intervals = self.standard_errors, self.confidence()
        return [
            [
                name,
                _rounded(value, errors[name]),
                "{:.4g} to {:.4g}".format(*intervals[name]),
                _unit(self.law, name),
            ]
            for name, value in self.values.items()
        ]

    def __str__(self) -> str:
        head = f"{self.name}: mu(v) = {self.law.text}" if self.law.name else f"mu(v) = {self.law.text}"
        about = f"residual standard deviation {self.sigma:.3g}, AICc {self.aicc:.6g}, weight {self.weight:.2g}"
        parts = [head, table(_HEADS, self._rows()), about]
        return "\n\n".join([*parts, *(f"warning: {text}" for text in self.warnings)])

    def __repr__(self) -> str:
        return f"Fit: {self.name}, {self.values_in_words()}"

    def values_in_words(self) -> str:
        """Return the fitted parameters with their standard errors, in a line."""
        errors = self.standard_errors
        return ", ".join(f"{name} = {_rounded(value, errors[name])}" for name, value in self.values.items())

    def _repr_html_(self) -> str:
        values = markup.table(_HEADS, self._rows())
        drawn = picture(self._figure, f"measured friction and the fitted law {self.name}")
        return markup.block(f"{self.name}: mu(v) = {self.law.text}", values, drawn, *self.warnings)

    def content(self) -> dict[str, object]:
        """Return all that the fit says as nested dictionaries and lists that JSON holds."""
        intervals = self.confidence()
        return {
            "law": self.name,
            "formula": self.law.text,
            "parameters": {
                name: {
                    "value": value,
                    "standard_error": self.standard_errors[name],
                    "confidence_95": list(intervals[name]),
                    "unit": self.law.parameters[name].unit,
                }
                for name, value in self.values.items()
            },
            "covariance": self.covariance.tolist(),
            "sigma": self.sigma,
            "chi_squared": self.chi_squared,
            "degrees_of_freedom": self.dof,
            "aicc": self.aicc,
            "weight": self.weight,
            "warnings": list(self.warnings),
        }

    def to_json(self) -> str:
        """Return all that the fit says as JSON."""
        return json.dumps(self.content(), indent=2, ensure_ascii=False, allow_nan=False)

    def _figure(self) -> "Figure":
        from stickslip_sym.model.measured.picture import draw_fit

        return draw_fit(self.name, self.measured, self.residuals, self.law.at_speeds, self.band)


def _rounded(value: float, error: float) -> str:
    """Return a value with its standard error, two digits of it."""
    if error == 0:
        return f"{value:g}"
    from uncertainties import ufloat

    return f"{ufloat(value, error):.2u}"


def _unit(law: FittedLaw, name: str) -> str:
    return law.parameters[name].unit or ""

"""`Fit`: a law with values from measurements, and how well they are known; `Fits`: several laws, ranked."""

import json
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ndtri, stdtrit
from uncertainties import UFloat, correlated_values

from stickslip_sym.core.aliases import FloatArray, Span
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.names import lookup
from stickslip_sym.core.numbers import read_array, real
from stickslip_sym.core.probabilities import UNLIKELY, USUAL_PROBABILITY
from stickslip_sym.core.uncertain import text_with_error
from stickslip_sym.model.error_band import error_band
from stickslip_sym.model.fitting.averaged import Averaged, ByLaw
from stickslip_sym.model.fitting.least_squares import Problem
from stickslip_sym.model.fitting.weights import rounding_variance, speeds_that_count, weigh
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output.content import content
from stickslip_sym.output.data import DataResult, TableResult, columns_of
from stickslip_sym.output.shown import Drawn, Report

_SEARCHED = 64.0  # half widths by standard errors, within which the end of an interval is sought
_NEAR_REST = 0.1  # of V: slip speeds below it are a part of 0 to 2 V that does not matter


# -- fits -------------------------------------------------------------------------------------------


class _Report(Report, Drawn):
    """A report that is shown as JSON and as a picture too."""

    def to_json(self) -> str:
        """Return all that is said as JSON."""
        return json.dumps(content(self), indent=2, ensure_ascii=False, allow_nan=False)


@dataclass(frozen=True, eq=False, repr=False)
class Fit(_Report, DataResult, by_identity=True):
    """A friction law fitted to measurements.

    Attributes
    ----------
    free_law : FrictionLaw
        The law without the values that were fitted.
    values : dict of str to float
        Of the parameters that were fitted.
    covariance : ndarray of shape (k, k)
        Of the fitted parameters, in the order of `values`.
    measured : Measurements
    chi_squared : float
        Sum of the squared residuals, divided by sigma where it is known.
    dof : float
        Degrees of freedom n/f - k: rows less parameters, where f is `inflation`.
    inflation : float
        So many rows count as one: (1 + r)/(1 - r) of residuals correlated by r from row to row, along the file
        or along the speed. 1 where they are not.
    noise : str
        What is assumed of the noise, in a sentence.
    jumps : tuple of str
        The parameters that are places of jumps, whose intervals are those where the sum of squares has not risen.
    jump_intervals : dict of str to (float, float)
        These intervals, with a probability of 0.95.
    warnings : tuple of str
        What the measurements do not determine, and what to fix.
    aicc : float
        Akaike's criterion, corrected for few rows: less is better; infinite where they are too few.
    weight : float
        Of the law among those that were fitted together, as `Fits` says: 1 if no other could be meant.

    References
    ----------
    K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, Springer 2002: AICc and weights.

    B. E. Hansen, Sample splitting and threshold estimation, Econometrica 68 (2000) 575: intervals of jumps.
    """

    reported = (
        "law", "values", "standard_errors", "confidence", "covariance", "sigma", "chi_squared", "dof", "inflation",
        "noise", "measured", "aicc", "weight", "warnings",
    )  # fmt: skip

    free_law: FrictionLaw
    values: Mapping[str, float]
    covariance: FloatArray
    measured: Measurements
    chi_squared: float
    dof: float
    inflation: float
    noise: str = ""
    jumps: tuple[str, ...] = ()
    jump_intervals: Mapping[str, Span] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    aicc: float = math.inf
    weight: float = 1.0

    @cached_property
    def law(self) -> FrictionLaw:
        """The law with the fitted values."""
        return self.free_law.bind(**self.values)

    @property
    def name(self) -> str:
        """The law's name, or its formula."""
        return str(self.free_law.name or self.free_law.text)

    @property
    def standard_errors(self) -> dict[str, float]:
        """Standard error of each fitted parameter."""
        return dict(zip(self.values, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def sigma(self) -> float:
        """Residual standard deviation of mu: the root of sum (mu_i - mu(v_i))^2 / (n - k)."""
        settled = len(self.values) + self.measured.differences
        return float(np.sqrt(np.sum(self.residuals**2) / (len(self.measured) - settled)))

    @cached_property
    def variance(self) -> float:
        """By how much the sum of squares rises for one standard error: 1 for independent noise of known sigma.

        Where it is estimated it is no less than what rounding of the coefficients alone has.
        """
        if self.measured.sigma is not None:
            return self.inflation
        return max(self.chi_squared / self.dof, rounding_variance(self.measured))

    @cached_property
    def residuals(self) -> FloatArray:
        """Measured less fitted coefficients, and less what branches and directions differ by, of shape (n,)."""
        weights = self.measured.weights
        left = weights * (self.measured.mu - self.law.at_speeds(self.measured.v))
        return np.asarray(self.measured.project_out_branches(left) / weights)

    @cached_property
    def uncertain(self) -> dict[str, UFloat]:
        """The fitted parameters as correlated `uncertainties.UFloat`."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that a standard error of 0 says nothing
            values = correlated_values(list(self.values.values()), self.covariance)
        return dict(zip(self.values, values, strict=True))

    def extrapolation(self, V: float) -> str | None:
        """Return which part of 0 to 2 V, where thresholds take friction from, was not measured; None if none."""
        low = float(self.measured.v[0])
        high = float(self.measured.v[-1])
        beyond = []
        if high * (1 + 1e-9) < 2 * V:
            beyond = [f"above {high:.3g} m/s"]
        if low > _NEAR_REST * V:
            beyond += [f"below {low:.3g} m/s"]
        if not beyond:
            return None
        return (
            f"extrapolated {' and '.join(beyond)}: thresholds take friction from 0 to 2 V = {2 * V:.3g} m/s, and "
            f"it was measured from {low:.3g} to {high:.3g} m/s"
        )

    def confidence(self, level: float = USUAL_PROBABILITY, *, profile: bool = False) -> dict[str, Span]:
        """Return an interval for each fitted parameter that holds the true value with a probability.

        Parameters
        ----------
        level : float
            The probability, between 0 and 1.
        profile : bool
            Search where the sum of squares has risen so far, instead of the standard error times a quantile of
            Student's t (of the normal distribution where sigma is known). Right also where the law bends much
            in its parameters, and takes longer. Places of jumps are always sought so.

        Raises
        ------
        InputError
            If the level is not between 0 and 1.
        """
        quantile = self._quantile(level)
        intervals = dict[str, Span]()
        for (name, value), error in zip(self.values.items(), self.standard_errors.values(), strict=True):
            half = quantile * error
            if level == USUAL_PROBABILITY and name in self.jump_intervals:
                intervals[name] = self.jump_intervals[name]
            elif name in self.jumps:
                intervals[name] = self._gap(name, -1, level), self._gap(name, 1, level)
            elif profile:
                intervals[name] = self._end(name, -half, quantile), self._end(name, half, quantile)
            else:
                intervals[name] = value - half, value + half
        return intervals

    def _rise(self, name: str, value: float) -> float:
        """Return how many variances the sum of squares, least over the other values, has risen."""
        others = np.array([p for key, p in self.values.items() if key != name])
        minimum = Problem(self.free_law.bind(**{name: value}), self.measured).minimum(others)
        rise = math.inf
        if minimum is not None:
            rise = minimum.chi_squared - self.chi_squared
        if rise > 0:
            return min(rise / self.variance, 1e300)
        return 0.0

    def _gap(self, name: str, side: int, level: float) -> float:
        """Return up to which measured speed a jump may be; infinite beyond all of them.

        The rise of chi-squared at the true place is above x with the probability 1 - (1 - exp(-x/2))^2, at most.
        """
        problem = Problem(self.free_law, self.measured)
        feature = next(feature for feature in problem.features if problem.names[feature.moved] == name)
        p = np.array(list(self.values.values()))
        speeds = self.measured.speeds
        first = int(np.searchsorted(speeds, problem.measured_at(feature, p)))
        beyond = len(speeds) - first if side > 0 else first  # gaps on this side, and one without an end
        most = -2 * math.log1p(-math.sqrt(level)) * (self._quantile(level) / ndtri((1 + level) / 2)) ** 2

        def value(level: float) -> float:
            return float(feature.grid(p, problem.known, np.array([level]))[0, feature.moved])

        def may_be(gaps: int) -> bool:
            i = first + side * gaps
            return bool(self._rise(name, value((speeds[i - 1] + speeds[i]) / 2)) <= most)

        within = 0
        step = 1
        while within + step < beyond and may_be(within + step):
            within, step = within + step, max(1, within // 8)
        if within + step >= beyond:
            return side * math.inf
        return value(float(speeds[first + side * (within + step - 1) - (side < 0)]))

    def _end(self, name: str, step: float, quantile: float) -> float:
        """Return where the sum of squares, least over the other values, has risen; infinite, or 0, if nowhere."""
        value = self.values[name]
        if step == 0:
            return value

        def risen(steps: float) -> float:
            return self._rise(name, value + steps * step) - quantile**2

        bounded = self.free_law.parameters[name].positive and step < 0
        farthest = _SEARCHED
        if bounded:
            farthest = min(_SEARCHED, -(1 - 1e-9) * value / step)
        below = 0.0
        above = min(0.5, farthest)
        while risen(above) <= 0:
            if above >= farthest:
                if bounded:
                    return 0.0
                return math.copysign(math.inf, step)
            below = above
            above = min(2 * above, farthest)
        return float(value + step * brentq(risen, below, above, xtol=1e-6))

    def band(self, v: ArrayLike, level: float = 0.95) -> tuple[FloatArray, FloatArray]:
        """Return the lower and upper end of the interval that holds the true mu at each speed, to first order."""
        speeds = np.asarray(read_array("v", v), np.float64)
        return error_band(self.law.bind(**self.uncertain), speeds, self._quantile(level))

    def _quantile(self, level: float) -> float:
        if not 0 < real("level", level) < 1:
            raise InputError(f"level = {level:g} is no probability between 0 and 1; 0.95 is usual")
        above = (1 + level) / 2
        return float(ndtri(above) if self.measured.sigma is not None else stdtrit(self.dof, above))

    def __repr__(self) -> str:
        return f"Fit: {self.name}, {self.values_in_words}"

    @property
    def values_in_words(self) -> str:
        """The fitted parameters with their standard errors, in a line."""
        pairs = zip(self.values.items(), self.standard_errors.values(), strict=True)
        return ", ".join(
            f"{name} = {text_with_error(value, error).replace(' ', '')}" for (name, value), error in pairs
        )


class Fits(_Report, Sequence[Fit], TableResult):
    """Fits of several laws to the same measurements, the best first.

    Attributes
    ----------
    measured : Measurements
    fits : tuple of Fit
    rejected : dict of str to str
        Laws that these measurements do not determine, each with the reason.

    Notes
    -----
    With n different speeds, S the sum of squares of the means at each speed about a law of k parameters, and
    nu = n - k of the law with the least S/(n - k), a weight is exp(-3 k/2) S^(-(nu + 1)/2): for many speeds
    between Akaike's and Schwarz's, and finite from n = k + 1 on. Where so many rows as `Fit.inflation` count as
    one, n is less by that. Laws whose fitted curves are one share the weight of one.
    """

    reported = ("measured", "fits", "rejected")

    def __init__(self, fits: Sequence[Fit], measured: Measurements, rejected: Mapping[str, str]) -> None:
        weighing = weigh(measured, fits)
        weighed = [
            replace(fit, aicc=_aicc(fit, weighing.inflation), weight=weight)
            for fit, weight in zip(fits, weighing.weights.tolist(), strict=True)
        ]
        self.fits = tuple(sorted(weighed, key=lambda fit: (-fit.weight, fit.chi_squared)))
        self._weighing = weighing
        self.measured = measured
        self.rejected = dict(rejected)

    @property
    def best(self) -> Fit:
        """The fit with the greatest weight."""
        return self.fits[0]

    def _table_columns(self) -> dict[str, list[Any]]:
        of_laws = columns_of(self.fits, "name", "weight", "sigma", "chi_squared", "dof", "aicc")
        return {"law": of_laws.pop("name"), **of_laws, "values": [dict(fit.values) for fit in self.fits]}

    def average(self, quantity: Callable[[FrictionLaw], Any]) -> Averaged:
        """Return a quantity by each law that may be meant, and its average by their weights.

        Parameters
        ----------
        quantity : callable
            What a law with standard errors gives, with a `value` and an `uncertainty`, which may be None, as
            ``lambda law: pure_slip_damping(law, V=0.5, N=9.81)``; if it has `unmeasured`, `ByLaw` says what that
            is. Laws whose weight is below a hundredth of the best one's are left out.

        Raises
        ------
        InputError
            If no law has such a quantity.

        Examples
        --------
        >>> import stickslip_sym as ss
        >>> v = [0.01 * i for i in range(1, 120)]
        >>> mu = [0.4 - 0.1 * x + 0.002 * (-1) ** i for i, x in enumerate(v)]
        >>> fits = ss.fit(v, mu, laws=["linear"])
        >>> averaged = fits.average(lambda law: ss.pure_slip_damping(law, V=0.5, N=9.81))
        >>> f"{averaged.value:.2f} +/- {averaged.standard_error:.3f}"
        '0.98 +/- 0.005'
        """
        rows = list[ByLaw]()
        refused = dict[str, str]()
        unknown = 0.0
        for fit in self.likely:
            try:
                estimate = quantity(fit.law.bind(**fit.uncertain))
            except StickSlipError as error:
                refused[fit.name] = str(error)
                unknown += fit.weight
                continue
            of_fit, of_point = _parts_of_error(estimate, fit)
            # The noise is one for all laws, and not what each leaves.
            of_fit *= math.sqrt(self._weighing.variance / fit.variance)
            spread = math.hypot(of_fit, of_point)
            unmeasured = float(getattr(estimate, "unmeasured", 0.0))
            rows.append(ByLaw(fit.name, fit.weight, float(estimate.value), spread, of_point, unmeasured))
        if not rows:
            raise InputError(f"no law has it: {next(iter(refused.items()))}")
        return Averaged.of(
            rows,
            refused,
            speeds=speeds_that_count(self.measured),
            dof=self._weighing.dof,
            unknown=unknown / (unknown + sum(row.weight for row in rows)),
            lowest=float(self.measured.v[0]),
        )

    @property
    def likely(self) -> tuple[Fit, ...]:
        """The fits of laws that may be meant: those whose weight is not below a hundredth of the best one's."""
        return tuple(fit for fit in self.fits if fit.weight >= UNLIKELY * self.best.weight)

    @overload
    def __getitem__(self, place: SupportsIndex | str) -> Fit: ...
    @overload
    def __getitem__(self, place: slice) -> tuple[Fit, ...]: ...
    def __getitem__(self, place: SupportsIndex | str | slice) -> Fit | tuple[Fit, ...]:
        """Return a fit by its rank from 0, or by its law's name."""
        if isinstance(place, str):
            return lookup("fit of the law", place, {fit.name: fit for fit in self.fits})
        return self.fits[place]

    def __len__(self) -> int:
        return len(self.fits)

    def __repr__(self) -> str:
        return f"Fits: {', '.join(f'{fit.name} ({fit.weight:.2g})' for fit in self.fits)}; {self.measured}"


def _parts_of_error(estimate: Any, fit: Fit) -> tuple[float, float]:
    """Return the parts of a quantity's standard error that fitted parameters bring, and all others."""
    whole = float(estimate.uncertainty or 0.0)
    budget = getattr(estimate, "budget", None)
    if budget is None:
        return whole, 0.0
    share = sum(float(budget.shares[name]) for name in budget.names if name in fit.values)
    of_fit = whole * math.sqrt(min(max(share, 0.0), 1.0))
    return of_fit, math.sqrt(max(whole**2 - of_fit**2, 0.0))


def _aicc(fit: Fit, inflation: float) -> float:
    """Return Akaike's criterion, corrected for few rows, where so many correlated rows count as one."""
    count = len(fit.measured)
    known = fit.measured.sigma is not None
    k = len(fit.values) + fit.measured.differences + (not known)  # an unknown sigma is one more parameter
    if count - k - 1 <= 0:
        return math.inf
    deviance = fit.chi_squared
    if not known:
        deviance = count * math.log(max(fit.chi_squared, 1e-300) / count)
    return deviance / inflation + 2 * k + 2 * k * (k + 1) / (count - k - 1)

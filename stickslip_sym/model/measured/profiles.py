"""Confidence intervals from the sum of squares itself, where standard errors do not serve."""

import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.model.measured.least_squares import Problem, require_lmfit
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.parametric import FittedLaw, Parametric

if TYPE_CHECKING:
    from lmfit.minimizer import MinimizerResult

__all__ = ["profile_intervals"]


def profile_intervals(
    law: FittedLaw, measured: Measurements, values: Mapping[str, float], errors: Mapping[str, float], level: float
) -> dict[str, tuple[float, float]]:
    """Return for each parameter where the sum of squares, minimal over the others, has risen to the level.

    By lmfit's `conf_interval`: an F-test where sigma is not known, a chi-squared test where it is. A side on which
    no such place is found is infinite, or the bound 0 of a positive parameter.
    """
    require_lmfit()
    import lmfit
    from scipy.special import chdtr

    model = Parametric(law, measured.v)
    problem = Problem(model, measured)
    p = np.array(list(values.values()))
    held = model.positive & (p == 0)
    minimizer = problem.minimizer(p, held)
    result = minimizer.leastsq()
    scale = np.where(problem.logarithmic, p, 1.0)
    for i, error in enumerate(errors.values()):
        result.params[f"p{i}"].stderr = error / scale[i]  # the first step of the search

    def probability(best: "MinimizerResult", other: "MinimizerResult") -> float:
        return float(chdtr(1, other.chisqr - best.chisqr))

    test: Callable[..., float] | None = None if measured.sigma is None else probability
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of sides without an end, which are returned as such
        found = lmfit.conf_interval(minimizer, result, sigmas=[level], prob_func=test)
    intervals = dict.fromkeys(model.names, (0.0, 0.0))
    for key, places in found.items():
        i = int(key[1:])
        ends = np.array([places[0][1], places[-1][1]])
        low, high = np.exp(ends) if problem.logarithmic[i] else ends
        intervals[model.names[i]] = float(max(low, 0.0) if model.positive[i] else low), float(high)
    return intervals

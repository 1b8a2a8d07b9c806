"""One law fitted to measurements: the best of several starts, and whether the measurements determine it."""

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.core.errors import InputError
from stickslip_sym.model.measured.fits import Fit
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.parametric import FittedLaw, Parametric
from stickslip_sym.model.measured.starts import starts

__all__ = ["fit_law", "profile_intervals", "require_lmfit"]

FloatArray = NDArray[np.float64]

_STARTS = 4  # that differ; the first few of the trials lead to one minimum for most laws
_SINGULAR = 1e-7  # of the largest singular value of the scaled derivatives: below, a combination has no effect
_SAME = 1e-8  # relative difference of two sums of squares that are one minimum; two starts in it are enough
_TOLERANCE = 1e-11  # relative, of the sum of squares and of the values; rounding allows 1e-14
_EVALUATIONS = 600  # of the law, for one start; more are taken only towards values without end
_OUTSIDE = 1e6  # residual, in units of the largest weighted mu, where the law has no real value: a step back
_AT_BOUND = 1e-3  # standard errors from 0: closer, the bound holds the value
_LOOSE = 0.5  # relative standard error of a positive parameter that is worth a warning
_ALIKE = 0.999  # correlation of two parameters that is worth a warning
_UNLIKELY = 1e-3  # probability of so large residuals, if sigma is right, that is worth a warning
_RISEN = 0.75  # of the largest mu: a law with mu(0) = 0 has built up friction where it first reaches this


def require_lmfit() -> None:
    """Refuse to fit without lmfit."""
    try:
        import lmfit  # noqa: F401  # only to see that it is there
    except ImportError:
        raise InputError('fits need lmfit: pip install "stickslip_sym[fit]"') from None


def fit_law(law: FittedLaw, measured: Measurements) -> Fit | str:
    """Return the fit of a law's free parameters, or why these measurements do not determine them.

    Residuals are divided by sigma where it is known; the covariance is then s^2 = 1 times (J^T J)^-1, and else
    s^2 = sum of squares / (n - k). J holds the exact derivatives of the residuals to the k free parameters.
    """
    model = Parametric(law, measured.v)
    count, k = len(measured), len(model.names)
    if k == 0:
        return "it has no parameter without a value"
    if len(measured.speeds) < k or count < k + 3:
        return (
            f"it has {k} free parameters, and {count} rows at {len(measured.speeds)} speeds are too few for them"
        )
    weights = np.ones(count) if measured.sigma is None else 1 / measured.sigma
    best: Any = None
    for start in starts(law, model, measured.v, measured.mu, weights, _STARTS):
        result = _minimizer(model, measured.mu, weights, start).leastsq()
        if not result.success:
            continue
        if best is not None and abs(result.chisqr - best.chisqr) <= _SAME * best.chisqr:
            break
        if best is None or result.chisqr < best.chisqr:
            best = result
    if best is None:
        return "no start converged"
    p = np.array([parameter.value for parameter in best.params.values()])
    derivatives = weights[:, None] * model.jacobian(p)
    if reason := _undetermined(model.names, p, derivatives) or _unseen_rise(law, model.names, p, measured):
        return reason
    chi_squared, dof = float(best.chisqr), count - k
    variance = chi_squared / dof if measured.sigma is None else 1.0
    sizes = np.linalg.norm(derivatives, axis=0)
    covariance = variance * np.linalg.inv((derivatives / sizes).T @ (derivatives / sizes)) / np.outer(sizes, sizes)
    errors = np.sqrt(np.diag(covariance))
    at_bound = model.positive & (p < _AT_BOUND * errors)
    p = _on_bound(model, p, at_bound)
    values = dict(zip(model.names, p.tolist(), strict=True))
    return Fit(
        law=law.bind(**values),
        values=values,
        covariance=covariance,
        measured=measured,
        chi_squared=chi_squared,
        dof=dof,
        aicc=_aicc(best, k, count, known=measured.sigma is not None),
        warnings=(
            *_loose(model, p, covariance, at_bound),
            *_scatter(chi_squared, dof, known=measured.sigma is not None),
        ),
    )


def _minimizer(model: Parametric, mu: FloatArray, weights: FloatArray, start: FloatArray) -> Any:
    """Return lmfit's minimizer of the weighted residuals, with exact derivatives."""
    import lmfit

    parameters = lmfit.Parameters()
    # Names of our own: those of a law may mean something to lmfit.
    for i, (value, positive) in enumerate(zip(start, model.positive, strict=True)):
        parameters.add(f"p{i}", value=float(value), min=0.0 if positive else -np.inf)
    outside = _OUTSIDE * float(np.max(np.abs(weights * mu))) + 1.0

    def values(given: Any) -> FloatArray:
        return np.array([parameter.value for parameter in given.values()])

    def residual(given: Any) -> FloatArray:
        found = weights * (model.mu(values(given)) - mu)
        return np.where(np.isfinite(found), found, outside)

    def derivatives(given: Any) -> FloatArray:
        varying = [parameter.vary for parameter in given.values()]
        found = weights[:, None] * model.jacobian(values(given))[:, varying]
        return np.where(np.isfinite(found), found, 0.0)

    return lmfit.Minimizer(
        residual, parameters, scale_covar=False, Dfun=derivatives, ftol=_TOLERANCE, xtol=_TOLERANCE,
        max_nfev=_EVALUATIONS,
    )  # fmt: skip


def _aicc(result: Any, k: int, count: int, *, known: bool) -> float:
    """Return Akaike's criterion, corrected for few rows; an unknown sigma is one more parameter."""
    total = k if known else k + 1
    aic = float(result.chisqr) + 2 * k if known else float(result.aic) + 2
    return aic + 2 * total * (total + 1) / (count - total - 1)


def _undetermined(names: tuple[str, ...], p: FloatArray, derivatives: FloatArray) -> str | None:
    """Return which parameters have no effect, or cannot be told apart; None if each is determined."""
    sizes = np.linalg.norm(derivatives, axis=0)
    relative = sizes * np.abs(p)
    if not (np.isfinite(sizes).all() and sizes.all()):
        without = [name for name, size in zip(names, sizes, strict=True) if not (np.isfinite(size) and size)]
        return f"these measurements say nothing of {', '.join(without)}; fix it: {_fixed(without[0])}"
    _, singular, rows = np.linalg.svd(derivatives / sizes, full_matrices=False)
    if singular[-1] > _SINGULAR * singular[0]:
        return None
    part = np.abs(rows[-1])
    mixed = [name for name, size in zip(names, part, strict=True) if size > 0.1 * part.max()]
    weakest = min(mixed, key=lambda name: relative[names.index(name)])
    return f"these measurements do not tell {' and '.join(mixed)} apart; fix one: {_fixed(weakest)}"


def _fixed(name: str) -> str:
    return f"law.bind({name}=...)"


def _unseen_rise(law: FittedLaw, names: tuple[str, ...], p: FloatArray, measured: Measurements) -> str | None:
    """Return that a law with mu(0) = 0 was not measured where it builds up friction."""
    end = float(measured.v[-1])
    grid = end * np.geomspace(1e-8, 1, 400)
    at_rest, *mu = Parametric(law, np.array([0.0, *grid])).mu(p)
    if not (abs(at_rest) < 1e-9 * np.max(np.abs(mu)) and np.isfinite(mu).all()):
        return None
    risen = float(grid[np.argmax(np.array(mu) >= _RISEN * np.max(mu))])
    seen = measured.speeds[(measured.speeds > 0) & (measured.speeds < risen)]
    if len(seen) >= 2:
        return None
    return (
        f"its friction builds up below {risen:.2g} m/s, where {len(seen)} speeds were measured; measure there at "
        "two or more, or take a law with a jump at v = 0"
    )


def _on_bound(model: Parametric, p: FloatArray, at_bound: NDArray[np.bool_]) -> FloatArray:
    """Return the values with those that their bound holds at 0, where the law has values there."""
    held = np.where(at_bound, 0.0, p)
    return held if np.isfinite(model.mu(held)).all() else p


def _loose(
    model: Parametric, p: FloatArray, covariance: FloatArray, at_bound: NDArray[np.bool_]
) -> list[str]:  # fmt: skip
    """Return a sentence for each parameter that the measurements hardly determine, with what to fix."""
    errors = np.sqrt(np.diag(covariance))
    said = []
    for i, name in enumerate(model.names):
        if at_bound[i]:
            said.append(
                f"{name} is held at its bound 0: the measurements ask for no {name}; fix it: law.bind({name}=0)"
            )
        elif model.positive[i] and errors[i] > _LOOSE * p[i]:
            said.append(
                f"{name} = {p[i]:.3g} has a standard error of {errors[i]:.2g}: these measurements hardly "
                f"determine it; fix it, {_fixed(name)}, or take a law without it"
            )
    correlation = covariance / np.outer(errors, errors)
    for i, j in combinations(range(len(p)), 2):
        if abs(correlation[i, j]) > _ALIKE:
            said.append(
                f"{model.names[i]} and {model.names[j]} are hardly told apart, correlation "
                f"{correlation[i, j]:.4f}; fix one: {_fixed(model.names[j])}"
            )
    return said


def _scatter(chi_squared: float, dof: int, *, known: bool) -> list[str]:
    from scipy.special import chdtrc

    if not known or chdtrc(dof, chi_squared) > _UNLIKELY:
        return []
    return [
        f"residuals are {np.sqrt(chi_squared / dof):.2g} times sigma: the law does not describe the measurements, "
        "or sigma is too small; the standard errors rest on sigma"
    ]


def profile_intervals(fit: Fit, level: float) -> dict[str, tuple[float, float]]:
    """Return for each parameter where the sum of squares, minimal over the others, has risen to the level.

    By lmfit's `conf_interval`: an F-test where sigma is not known, a chi-squared test where it is. A side on which
    no such place is found is infinite, or the bound 0 of a positive parameter.
    """
    require_lmfit()
    import warnings

    import lmfit
    from scipy.special import chdtr

    measured = fit.measured
    weights = np.ones(len(measured)) if measured.sigma is None else 1 / measured.sigma
    model = Parametric(fit.free_law, measured.v)
    minimizer = _minimizer(model, measured.mu, weights, np.array(list(fit.values.values())))
    result = minimizer.leastsq()
    for parameter, error in zip(result.params.values(), fit.standard_errors.values(), strict=True):
        parameter.stderr = error  # the first step of the search

    def probability(best: Any, other: Any) -> float:
        return float(chdtr(1, other.chisqr - best.chisqr))

    test: Callable[..., float] | None = None if measured.sigma is None else probability
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of sides without an end, which are returned as such
        found = lmfit.conf_interval(minimizer, result, sigmas=[level], prob_func=test)
    intervals = {}
    for (name, places), positive in zip(found.items(), model.positive, strict=True):
        low, high = places[0][1], places[-1][1]
        intervals[model.names[int(name[1:])]] = (max(low, 0.0) if positive else low, high)
    return intervals

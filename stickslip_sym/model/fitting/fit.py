"""`fit`: friction laws fitted to measurements, each by the best of several starts, and ranked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtr, chdtrc, fdtrc

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import SAME
from stickslip_sym.model.fitting.least_squares import Minimum, Problem
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.laws import laws as catalogue
from stickslip_sym.model.measured.measurements import Measurements

_STARTS = 4  # different ones; for most laws the best few of the trials lead to one minimum
_MANY = 1000  # rows, from which starts lead to a minimum of the means of bins, and the best to one of all rows
_BINS = 300
_SINGULAR = 1e-7  # least singular value of the scaled derivatives over the largest: a smaller one has no effect
_SAME = 1e-8  # relative difference of two sums of squares that are one minimum; two starts in it are enough
_NOTHING = 100.0  # relative standard error, beyond which a parameter that is not linear was not measured
_LOOSE = 0.5  # relative standard error of a positive parameter that is worth a warning
_MIXED = 0.1  # part in the direction without effect, over the largest: smaller parts are not named
_ALIKE = 0.999  # correlation of two parameters that is worth a warning
_UNLIKELY = 1e-3  # probability of what residuals show, if what is assumed of them holds, that is worth a warning
_CORRELATED = 2.5  # standard deviations of the correlation of white noise, above which noise is correlated
_FEWEST = 8  # rows, up to which no correlation stands out
_MOST_CORRELATED = 0.95  # beyond it the rows are too few to tell noise from a trend
_RISEN = 0.75  # of the largest mu: a law with mu(0) = 0 has built up friction where it first reaches this


def fit(
    v: ArrayLike | Measurements,
    mu: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    laws: str | FrictionLaw | Iterable[str | FrictionLaw] | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Fits:
    """Fit friction laws to measurements by least squares, and rank them by AICc.

    Parameters
    ----------
    v : array_like of shape (n,) or Measurements
        Slip speeds in m/s; or measurements as `read_measurements` returns them, without `mu` and `sigma`.
    mu : array_like of shape (n,)
        Coefficients of friction.
    sigma : float or array_like of shape (n,), optional
        Standard deviation of each coefficient. Without it, it is one for all rows, and estimated.
    laws : name, formula, FrictionLaw, or several of them, optional
        What to fit; every law of the catalogue by default. Parameters that have a value keep it.
    progress : callable, optional
        Called with the number of laws that are done, and of all.

    Returns
    -------
    Fits
        The best first; `Fits.rejected` says which laws these measurements do not determine, and why.

    Raises
    ------
    InputError
        For what is no measurement or law, or if no law can be fitted.

    Notes
    -----
    The sum of ((mu_i - mu(v_i; p)) / sigma_i)^2 is minimised by SciPy's ``least_squares``, with exact
    derivatives, from several starts. Parameters that are declared positive stay so. Laws with
    mu(0) = 0 are fitted only where the speeds reach below the one at which their friction has built up.

    Examples
    --------
    >>> import numpy as np
    >>> v = np.linspace(0, 1, 50)
    >>> mu = 0.2 + 0.3 * np.exp(-3 * v) + 0.01 * np.cos(50 * v)
    >>> fits = fit(v, mu, laws=["exponential", "gaussian"])
    >>> fits.best.name, f"{fits.best.values['alpha']:.1f}"
    ('exponential', '3.1')
    """
    if isinstance(v, Measurements):
        if mu is not None or sigma is not None:
            raise InputError("mu and sigma are given twice: measurements have their own")
        measured = v
    elif mu is None:
        raise InputError("mu is missing; give fit(v, mu), or fit(read_measurements(path))")
    else:
        measured = Measurements.of(v, mu, sigma)
    chosen, fits, rejected = _laws(laws), list[Fit](), dict[str, str]()
    count = progress or (lambda done, total: None)
    for done, (name, law) in enumerate(chosen.items()):
        count(done, len(chosen))
        try:
            fits.append(_fit_law(law, measured))
        except InputError as error:
            rejected[name] = str(error)
    count(len(chosen), len(chosen))
    if not fits:
        reasons = "; ".join(f"{name}: {reason}" for name, reason in list(rejected.items())[:3])
        raise InputError(f"no law could be fitted to {len(measured)} rows: {reasons}")
    return Fits(fits, measured, rejected)


def _laws(given: str | FrictionLaw | Iterable[str | FrictionLaw] | None) -> dict[str, FrictionLaw]:
    """Return the laws to fit, each by its name or its formula."""
    if given is None:
        return dict(catalogue)
    laws: dict[str, FrictionLaw] = {}
    for one in [given] if isinstance(given, str) or not isinstance(given, Iterable) else given:
        law = as_law(one)
        name = law.name or law.text
        if law.curve is not None:
            raise InputError(
                f"{name} goes through measured points, and has nothing to fit; name a law or a formula"
            )
        if law.uncertain:
            raise InputError(
                f"{name}: {min(law.uncertain)} is fixed with a standard error, which no fit carries on; give its "
                "value without it, or leave it free"
            )
        if name in laws:
            raise InputError(f"the law {name} is given twice; give each once, or another name")
        laws[name] = law
    if not laws:
        raise InputError("there is no law to fit; leave laws out for those of the catalogue")
    return laws


def _fit_law(law: FrictionLaw, measured: Measurements) -> Fit:
    """Return the fit of a law's free parameters, or refuse one that these measurements do not determine."""
    problem = Problem(law, measured)
    names, count, k = problem.names, len(measured), len(problem.names)
    if k == 0:
        raise InputError("it has no parameter without a value")
    if len(measured.speeds) < k or count < k + 2:
        rows = f"{count} rows at {len(measured.speeds)} speeds"
        raise InputError(f"it has {k} free parameter{'s' * (k > 1)}, and {rows} are too few")
    best = _best(problem)
    if best is None:
        raise InputError(
            "no start converged: its values run away without an end; fix one of them, or take a simpler law"
        )
    p, chi_squared = best.p[_order(law, problem, best.p)], best.chi_squared
    values = dict(zip(names, p.tolist(), strict=True))
    derivatives = problem.jacobian(p)
    sizes = np.linalg.norm(derivatives, axis=0)
    effective = np.isfinite(sizes) & (sizes > 0)
    if not effective.all():
        raise _undetermined(names, np.flatnonzero(~effective)[:1], sizes)
    _, singular, rows_of_v = np.linalg.svd(derivatives / sizes, full_matrices=False)
    if singular[-1] <= _SINGULAR * singular[0]:
        part = np.abs(rows_of_v[-1])
        raise _undetermined(names, np.flatnonzero(part > _MIXED * part.max()), sizes * p)
    _require_rise(law.bind(**values), measured)
    correlation = _correlation(problem.residuals(p), measured, k)
    inflation = (1 + correlation) / (1 - correlation)
    dof = max(count / inflation - k, 1.0)
    root = rows_of_v.T / singular / sizes[:, None]  # of (J^T J)^-1
    covariance = (inflation if measured.sigma is not None else chi_squared / dof) * (root @ root.T)
    errors = np.sqrt(np.diag(covariance))
    for i in np.flatnonzero(~problem.linear & (errors > _NOTHING * np.abs(p))):
        alike = np.abs(covariance[i]) > _ALIKE * errors[i] * errors
        raise _undetermined(names, np.flatnonzero(alike), p / errors)
    return Fit(
        free_law=law,
        values=values,
        covariance=covariance,
        measured=measured,
        chi_squared=chi_squared,
        dof=dof,
        inflation=inflation,
        warnings=tuple(_warnings(problem, p, covariance, correlation, chi_squared)),
    )


def _best(problem: Problem) -> Minimum | None:
    """Return the least of the minima that several starts lead to; of many rows, those of means of bins."""
    measured, coarse = problem.measured, problem
    if len(measured) > _MANY:
        means = measured.binned(_BINS)  # whose own scatter is no sigma
        coarse = Problem(problem.law, means if measured.sigma is not None else replace(means, sigma=None))
    best: Minimum | None = None
    for minimum in filter(None, map(coarse.minimum, coarse.starts(_STARTS))):
        if best is not None and abs(minimum.chi_squared - best.chi_squared) <= _SAME * best.chi_squared:
            break
        best = min(best or minimum, minimum, key=lambda one: one.chi_squared)
    return best if coarse is problem or best is None else problem.minimum(best.p)


def _order(law: FrictionLaw, problem: Problem, p: FloatArray) -> list[int]:
    """Return the order of values that can change places in which they stand as the typical ones do."""
    order = list(range(len(p)))
    parameters = [law.parameters[name] for name in problem.names]
    typical = [float(one.typical or i) for i, one in enumerate(parameters)]
    amplitudes = [[], *([pair] for pair in combinations(np.flatnonzero(problem.linear).tolist(), 2))]
    for i, j in combinations(np.flatnonzero(~problem.linear).tolist(), 2):
        for more in amplitudes if (p[i] < p[j]) != (typical[i] < typical[j]) else ():
            changed = order.copy()
            for a, b in [(i, j), *more]:
                changed[a], changed[b] = order[b], order[a]
            swap = {one.symbol: parameters[place].symbol for one, place in zip(parameters, changed, strict=True)}
            if law.expr.xreplace(swap) == law.expr:
                return changed
    return order


def _correlation(residuals: FloatArray, measured: Measurements, k: int) -> float:
    """Return the correlation of residuals from row to row of the file, 0 where white noise would show as much."""
    count = len(residuals)
    rounding = SAME * np.max(np.abs(measured.weights * measured.mu))
    if measured.order is None or count <= _FEWEST or np.max(np.abs(residuals)) <= rounding:
        return 0.0
    e = residuals[np.argsort(measured.order)]
    lagged = float(np.sum(e[1:] * e[:-1]) / np.sum(e**2))
    # The k parameters follow part of the noise, which so seems less correlated by about (k + 3 r)/n.
    corrected, deviation = (lagged * count + k) / (count - 3), np.sqrt(count) / (count - 3)
    return 0.0 if corrected <= _CORRELATED * deviation else min(corrected, _MOST_CORRELATED)


def _require_rise(law: FrictionLaw, measured: Measurements) -> None:
    """Refuse a law with mu(0) = 0 that was not measured where it builds up friction."""
    grid = float(measured.v[-1]) * np.geomspace(1e-8, 1, 400)
    at_rest, *mu = law.at_speeds(np.array([np.finfo(np.float64).tiny, *grid]))
    if abs(at_rest) < 1e-9 * np.max(np.abs(mu)) and np.isfinite(mu).all():
        risen = float(grid[np.argmax(np.array(mu) >= _RISEN * np.max(mu))])
        seen = int(((measured.speeds > 0) & (measured.speeds < risen)).sum())
        if seen < 2:
            raise InputError(
                f"its friction builds up below {risen:.2g} m/s, where {seen} speeds were measured; measure there "
                "at two or more, or take a law with a jump at v = 0"
            )


def _undetermined(names: tuple[str, ...], which: IntArray, strength: FloatArray) -> InputError:
    """Return that one parameter says nothing, or several are not distinguished, and which to fix: the weakest."""
    weakest = names[min(which, key=lambda i: abs(strength[i]))]
    if len(which) == 1:
        return InputError(f"these measurements say nothing of {weakest}; fix it: law.bind({weakest}=...)")
    mixed = " and ".join(names[i] for i in which)
    return InputError(f"these measurements do not tell {mixed} apart; fix one: law.bind({weakest}=...)")


def _warnings(
    problem: Problem, p: FloatArray, covariance: FloatArray, correlation: float, chi_squared: float
) -> Iterator[str]:
    """Yield what the measurements hardly determine, and what their residuals contradict, with what to do."""
    names, errors, measured = problem.names, np.sqrt(np.diag(covariance)), problem.measured
    for i, name in enumerate(names):
        if problem.positive[i] and problem.linear[i] and p[i] == 0:
            yield (
                f"{name} is held at its bound 0, where the measurements ask for less; fix it: law.bind({name}=0), "
                f"or declare Parameter({name!r}, positive=False) if any sign is meant"
            )
        elif problem.positive[i] and errors[i] > _LOOSE * p[i]:
            yield (
                f"{name} = {p[i]:.3g} has a standard error of {errors[i]:.2g}: these measurements hardly "
                f"determine it; fix it, law.bind({name}=...), or take a law without it"
            )
    for i, j in combinations(np.flatnonzero(errors).tolist(), 2):
        if abs(alike := covariance[i, j] / errors[i] / errors[j]) > _ALIKE:
            yield (
                f"{names[i]} and {names[j]} are hardly distinguished, correlation {alike:.4f}; fix one: "
                f"law.bind({names[j]}=...)"
            )
    count, dof, inflation = len(measured), len(measured) - len(names), (1 + correlation) / (1 - correlation)
    if correlation:
        yield (
            f"residuals of successive rows of the file are correlated, {correlation:.2f}: {count} rows count as "
            f"{count / inflation:.0f}, and standard errors are {np.sqrt(inflation):.2g} times as wide; noise is "
            "slow, or the law does not describe the measurements"
        )
    known = measured.sigma is not None
    size = f"residuals are {np.sqrt(chi_squared / dof):.2g}{' times sigma' if known else ''}"
    if known and chdtrc(dof, chi_squared / inflation) <= _UNLIKELY:
        yield (
            f"{size}: the law does not describe the measurements, or sigma is too small; the standard errors rest "
            "on sigma"
        )
    elif known and chdtr(dof, chi_squared) <= _UNLIKELY:
        means = " and the file counts them," if measured.counts is not None else ""
        yield (
            f"{size}: sigma is too large; if each mu is the mean of n values,{means} and sigma is the standard "
            "deviation of one value, sigma/sqrt(n) belongs in its place; standard errors rest on it"
        )
    means_of_speeds = measured.averaged()
    _, index = np.unique(measured.v, return_inverse=True)
    scatter = float(np.sum((measured.weights * (measured.mu - means_of_speeds.mu[index])) ** 2))
    repeats, shapes = count - len(means_of_speeds), len(means_of_speeds) - len(names)
    if repeats > 0 and shapes > 0 and scatter > 0:
        ratio = (chi_squared - scatter) / shapes / (scatter / repeats)
        if fdtrc(shapes, repeats, ratio / inflation) <= _UNLIKELY:
            yield (
                f"the law does not describe the measurements: {size}, and repeats at one speed scatter by "
                f"{np.sqrt(scatter / repeats):.2g}; take another law"
            )

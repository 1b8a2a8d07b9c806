"""`fit`: friction laws fitted to measurements, each by the best of several starts, and ranked."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import combinations, islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import chdtr, chdtrc, chdtri, fdtrc

from stickslip_sym.core.aliases import FloatArray, IntArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import ROOT_OF_ROUNDING, SAME
from stickslip_sym.core.probabilities import NORMAL, UNLIKELY, VERY_UNLIKELY
from stickslip_sym.core.progress import report_counts_to, steps
from stickslip_sym.core.remedies import AnySign, Argument, ParameterValues
from stickslip_sym.model.fitting.lack_of_fit import chance_of_residuals, polynomials_of_rank
from stickslip_sym.model.fitting.least_squares import Minimum, Problem
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.fitting.weights import rounding_variance
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.laws import laws as catalogue
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.noise import SAME_COEFFICIENT, correlation_of

_USUAL: Any = {"divide": "warn", "over": "warn", "under": "ignore", "invalid": "warn"}
"""What NumPy does about errors unless a user has set otherwise: products underflow within SciPy's solvers too."""
_BINS = 300  # of many rows: starts lead to a minimum of their means, and the best to one of all rows
_ERROR_OF_UNMEASURED = 100.0
"""Relative standard error, beyond which a parameter that is not linear was not measured."""
_ERROR_WORTH_A_WARNING = 0.5  # relative standard error of a positive parameter that is worth a warning
_MIXED = 0.1  # part in the direction without effect, over the largest: smaller parts are not named
_CORRELATION_WORTH_A_WARNING = 0.999  # correlation of two parameters that is worth a warning
_RISEN = 0.75  # of the largest mu: a law with mu(0) = 0 has built up friction where it first reaches this


def fit(
    v: ArrayLike | Measurements,
    mu: ArrayLike | None = None,
    sigma: ArrayLike | None = None,
    laws: str | FrictionLaw | Iterable[str | FrictionLaw] | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> Fits:
    """Fit friction laws to measurements by least squares, and rank them by their weights, as `Fits` says.

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
    The sum of ((mu_i - mu(v_i; p)) / sigma_i)^2 is minimised by SciPy's ``leastsq``, with exact
    derivatives, from several starts. Places and frequencies are looked for on grids as fine as the measurements
    resolve, with the parameters in which mu is linear eliminated (variable projection). Parameters that are
    declared positive stay so. Laws with mu(0) = 0 are fitted only where the speeds reach below the one at which
    their friction has built up. Noise that is correlated along the file or along the speed, up to four rows apart,
    widens the standard errors; what is assumed of it is `Fit.noise`.

    Where the speed rises and falls, and branches differ, the law is that of their mean: the hysteresis, a
    polynomial in the share of rows below a speed, has factors of its own, which are
    eliminated; so has an offset of directions.

    References
    ----------
    G. H. Golub and V. Pereyra, SIAM J. Numer. Anal. 10 (1973) 413: variable projection.

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
    with report_counts_to(progress), np.errstate(**_USUAL):
        return _fits(_laws_to_fit(laws), measured)


def _fits(chosen: dict[str, FrictionLaw], measured: Measurements) -> Fits:
    """Fit laws by their names, and rank them."""
    fits = list[Fit]()
    rejected = dict[str, InputError]()
    with steps(chosen, str) as names:
        for name in names:
            try:
                fits.append(_fit_law(chosen[name], measured))
            except InputError as error:
                rejected[name] = error
    if not fits:
        reasons = [part for name, error in islice(rejected.items(), 3) for part in ("; ", f"{name}: ", error)]
        raise InputError(f"no law could be fitted to {len(measured)} rows: ", *reasons[1:])
    return Fits(fits, measured, {name: str(error) for name, error in rejected.items()})


def _laws_to_fit(given: str | FrictionLaw | Iterable[str | FrictionLaw] | None) -> dict[str, FrictionLaw]:
    """Return the laws to fit, each by its name or its formula."""
    if given is None:
        return dict(catalogue)
    laws: dict[str, FrictionLaw] = {}
    for law_or_formula in [given] if isinstance(given, str) or not isinstance(given, Iterable) else given:
        law = as_law(law_or_formula)
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
    names = problem.names
    count = len(measured)
    k = len(problem.names)
    settled = k + measured.differences
    if k == 0:
        raise InputError("it has no parameter without a value")
    if len(measured.speeds) < k or count <= settled:
        rows = f"{count} rows at {len(measured.speeds)} speed{'s' * (len(measured.speeds) != 1)}"
        raise InputError(f"it has {k} free parameter{'s' * (k > 1)}, and {rows} are too few")
    best, rivals = _best_minimum(problem)
    if best is None:
        raise InputError(
            "no start converged: its values run away without an end; fix one of them, or take a simpler law"
        )
    p = best.p[_order(law, problem, best.p)]
    chi_squared = best.chi_squared
    values = dict(zip(names, p.tolist(), strict=True))
    jumps = _places_of_jumps(problem, p)
    smooth = np.array([name not in jumps for name in names])
    derivatives = problem.jacobian(p)[:, smooth]
    place = np.flatnonzero(smooth)
    sizes = np.linalg.norm(derivatives, axis=0)
    effective = np.isfinite(sizes) & (sizes > 0)
    if not effective.all():
        raise _undetermined(names, place[~effective][:1], p)
    _, singular, rows_of_v = np.linalg.svd(derivatives / sizes, full_matrices=False)
    if smooth.any() and singular[-1] <= ROOT_OF_ROUNDING * singular[0]:  # its square is rounding
        part = np.abs(rows_of_v[-1])
        strength = np.zeros(k)
        strength[smooth] = sizes * p[smooth]
        raise _undetermined(names, place[part > _MIXED * part.max()], strength)
    _require_rise(law.bind(**values), measured)
    noise = _noise_of(problem.residuals(p), measured, settled)
    inflation = noise.inflation
    dof = max(count / inflation - settled, 1.0)
    root = rows_of_v.T / singular / sizes[:, None]  # of (J^T J)^-1
    covariance = np.zeros((k, k))
    covariance[np.ix_(smooth, smooth)] = inflation * (root @ root.T)
    if measured.sigma is None:
        covariance *= max(chi_squared / dof, rounding_variance(measured)) / inflation
    fitted = Fit(
        free_law=law,
        values=values,
        covariance=covariance,
        measured=measured,
        chi_squared=chi_squared,
        dof=dof,
        inflation=inflation,
        noise=noise.assumed(known=measured.sigma is not None),
        jumps=jumps,
    )
    intervals = {name: interval for name, interval in fitted.confidence().items() if name in jumps}
    for i in np.flatnonzero(~smooth):  # without a derivative: as wide as the interval of a normal distribution
        low, high = intervals[names[i]]
        if not np.isfinite(high - low):
            raise _undetermined(names, np.array([i]), p)
        covariance[i, i] = ((high - low) / 2 / NORMAL) ** 2
    errors = np.sqrt(np.diag(covariance))
    for i in np.flatnonzero(smooth & ~problem.linear & (errors > _ERROR_OF_UNMEASURED * np.abs(p))):
        alike = np.abs(covariance[i]) > _CORRELATION_WORTH_A_WARNING * errors[i] * errors
        raise _undetermined(names, np.flatnonzero(alike), p / np.maximum(errors, np.finfo(float).tiny))
    warned = [*_warnings(problem, p, covariance, noise, chi_squared), *_rivals(fitted, rivals)]
    warned += _notes_on_rest(law.bind(**values), measured)
    if not noise.lag:  # slow noise follows the speed too
        warned += _lack_of_fit(problem, p, derivatives)
    return replace(fitted, jump_intervals=intervals, warnings=tuple(warned))


def _best_minimum(problem: Problem) -> tuple[Minimum | None, list[tuple[int, Minimum]]]:
    """Return the least of the minima that several starts lead to, and other minima in a place or a frequency.

    Those of many rows are sought for means of bins.
    """
    measured = problem.measured
    coarse = problem
    if len(measured) > 3 * _BINS:
        means = measured.binned(_BINS)  # whose own scatter is no sigma
        coarse = Problem(problem.law, means if measured.sigma is not None else replace(means, sigma=None))
    best: Minimum | None = None
    for minimum in filter(None, map(coarse.minimum, coarse.starts())):
        if best is not None and abs(minimum.chi_squared - best.chi_squared) <= ROOT_OF_ROUNDING * best.chi_squared:
            break
        best = min(best or minimum, minimum, key=lambda reached: reached.chi_squared)
    if best is None:
        return None, []
    rivals = list(coarse.rivals(best.p))
    if coarse is not problem:
        best = problem.minimum(best.p)
        refined = [(i, problem.minimum(rival.p)) for i, rival in rivals]
        rivals = [(i, minimum) for i, minimum in refined if minimum is not None]
    return best, rivals


def _places_of_jumps(problem: Problem, p: FloatArray) -> tuple[str, ...]:
    """Return the parameters that are places of jumps of mu, which no derivative sees."""
    law = problem.law.bind(**dict(zip(problem.names, p.tolist(), strict=True)))
    names = []
    for feature in problem.features:
        place = problem.measured_at(feature, p)
        if feature.breaks and place > 0:
            below, at, above = law.at_speeds(place * np.array([1 - ROOT_OF_ROUNDING, 1, 1 + ROOT_OF_ROUNDING]))
            if abs(above - below) > SAME_COEFFICIENT * max(abs(at), abs(above), abs(below)):
                if not feature.alone:
                    raise InputError(
                        "mu jumps at a place that several free parameters move; fix all but one of them"
                    )
                names.append(problem.names[feature.moved])
    return tuple(names)


def _rivals(fitted: Fit, rivals: list[tuple[int, Minimum]]) -> Iterator[str]:
    """Yield which other places and frequencies describe the measurements nearly as well."""
    for i, minimum in rivals:
        name = list(fitted.values)[i]
        rise = minimum.chi_squared - fitted.chi_squared
        if rise <= chdtri(1, VERY_UNLIKELY) * fitted.variance:  # the noise may have chosen
            yield (
                f"{name} = {minimum.p[i]:.4g} describes the measurements nearly as well as "
                f"{fitted.values[name]:.4g}: standard errors hold for one of them; measure at more speeds, or "
                f"fix it: {ParameterValues.of(name)}"
            )


def _order(law: FrictionLaw, problem: Problem, p: FloatArray) -> list[int]:
    """Return the order of values that can change places in which they stand as the typical ones do."""
    order = list(range(len(p)))
    parameters = [law.parameters[name] for name in problem.names]
    typical = [float(parameter.typical or i) for i, parameter in enumerate(parameters)]
    amplitudes = [[], *([pair] for pair in combinations(np.flatnonzero(problem.linear).tolist(), 2))]
    for i, j in combinations(np.flatnonzero(~problem.linear).tolist(), 2):
        for more in amplitudes if (p[i] < p[j]) != (typical[i] < typical[j]) else ():
            changed = order.copy()
            for a, b in [(i, j), *more]:
                changed[a], changed[b] = order[b], order[a]
            swap = {
                parameter.symbol: parameters[place].symbol
                for parameter, place in zip(parameters, changed, strict=True)
            }
            if law.expr.xreplace(swap) == law.expr:
                return changed
    return order


class _Noise(NamedTuple):
    """How noise is correlated: how many rows count as one, how far apart in which order, and that of the file."""

    inflation: float = 1.0
    correlation: float = 0.0
    lag: int = 0
    order: str = ""
    along_the_file: float = 1.0

    def assumed(self, *, known: bool) -> str:
        """Return what is assumed of the noise."""
        size = "of the standard deviations sigma" if known else "of one standard deviation, estimated"
        if not self.lag:
            return f"noise is taken as independent from row to row, {size}"
        return f"noise is taken as correlated {self.order}, {self.inflation:.2g} rows counting as one, {size}"


def _noise_of(residuals: FloatArray, measured: Measurements, k: int) -> _Noise:
    """Return how residuals are correlated along the file and along the speed: the stronger of the two."""
    rounding = SAME * np.max(np.abs(measured.weights * measured.mu))
    if np.max(np.abs(residuals)) <= rounding:
        return _Noise()
    along_speed = _Noise(*correlation_of(residuals, k), "along the speed")
    if measured.order is None:
        return along_speed
    along_file = _Noise(*correlation_of(residuals[np.argsort(measured.order)], k), "along the file")
    stronger = along_file if along_file.inflation >= along_speed.inflation else along_speed
    return stronger._replace(along_the_file=along_file.inflation)


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
        return InputError(f"these measurements say nothing of {weakest}; fix it: ", ParameterValues.of(weakest))
    mixed = " and ".join(names[i] for i in which)
    return InputError(f"these measurements do not tell {mixed} apart; fix one: ", ParameterValues.of(weakest))


def _notes_on_rest(law: FrictionLaw, measured: Measurements) -> Iterator[str]:
    """Yield that rows at rest reach a coefficient above that of the first slip, if they do."""
    if measured.static_at_least is None or law.static is not None:
        return
    first = float(law.at_speeds(np.array([ROOT_OF_ROUNDING * measured.v[-1]]))[0])
    if measured.static_at_least > first:
        static = Argument("static", f"{measured.static_at_least:.4g}")
        yield (
            f"rows at rest reach mu = {measured.static_at_least:.4g}, above mu(0+) = {first:.4g} of the law: the "
            f"static coefficient is at least that, and moves the threshold; give it: {static}"
        )


def _lack_of_fit(problem: Problem, p: FloatArray, derivatives: FloatArray) -> Iterator[str]:
    """Yield that residuals follow the speed, if they do."""
    measured = problem.measured
    polynomials = measured.weights * polynomials_of_rank(measured.v, derivatives.shape[1]).T
    chance = chance_of_residuals(
        problem.residuals(p),
        derivatives,
        measured.project_out_branches(polynomials).T,
        rounding_variance(measured),
    )
    if chance is not None and chance < UNLIKELY:
        least = f"{chance:.1g}" if chance >= VERY_UNLIKELY else f"less than {VERY_UNLIKELY:g}"
        yield (
            "the law does not describe the measurements: residuals follow the speed as noise would with a "
            f"probability of {least}; take another law"
        )


def _warnings(
    problem: Problem, p: FloatArray, covariance: FloatArray, noise: _Noise, chi_squared: float
) -> Iterator[str]:
    """Yield what the measurements hardly determine, and what their residuals contradict, with what to do."""
    names = problem.names
    errors = np.sqrt(np.diag(covariance))
    measured = problem.measured
    for i, name in enumerate(names):
        if problem.positive[i] and problem.linear[i] and p[i] == 0:
            yield (
                f"{name} is held at its bound 0, where the measurements ask for less; fix it, "
                f"{ParameterValues({name: 0})}, or, if any sign is meant, {AnySign(name)}"
            )
        elif problem.positive[i] and errors[i] > _ERROR_WORTH_A_WARNING * p[i]:
            yield (
                f"{name} = {p[i]:.3g} has a standard error of {errors[i]:.2g}: these measurements hardly "
                f"determine it; fix it, {ParameterValues.of(name)}, or take a law without it"
            )
    for i, j in combinations(np.flatnonzero(errors).tolist(), 2):
        if abs(alike := covariance[i, j] / errors[i] / errors[j]) > _CORRELATION_WORTH_A_WARNING:
            yield (
                f"{names[i]} and {names[j]} are hardly distinguished, correlation {alike:.4f}; fix one: "
                f"{ParameterValues.of(names[j])}"
            )
    settled = len(names) + measured.differences
    count = len(measured)
    dof = len(measured) - settled
    inflation = noise.inflation
    if noise.lag:
        apart = "successive rows" if noise.lag == 1 else f"rows {noise.lag} apart"
        yield (
            f"residuals of {apart} {noise.order} are correlated, {noise.correlation:.2f}: {count} rows count as "
            f"{count / inflation:.0f}, and standard errors are {np.sqrt(inflation):.2g} times as wide; noise is "
            "slow, or the law does not describe the measurements"
        )
    known = measured.sigma is not None
    size = f"residuals are {np.sqrt(chi_squared / dof):.2g}{' times sigma' if known else ''}"
    if known and chdtrc(dof, chi_squared / inflation) <= VERY_UNLIKELY:
        yield (
            f"{size}: the law does not describe the measurements, or sigma is too small; the standard errors rest "
            "on sigma"
        )
    elif known and chdtr(dof, chi_squared) <= VERY_UNLIKELY:
        means = " and the file counts them," if measured.counts is not None else ""
        yield (
            f"{size}: sigma is too large; if each mu is the mean of n values,{means} and sigma is the standard "
            "deviation of one value, sigma/sqrt(n) belongs in its place; standard errors rest on it"
        )
    branches = measured.branches
    if branches is not None and branches.differ and branches.alone:
        yield (
            f"{branches.alone}: elsewhere they differ, and the law is that of their mean; measure both branches "
            "at all speeds, or fit the rows of one"
        )
    means_of_speeds = measured.averaged()
    _, index = np.unique(measured.v, return_inverse=True)
    scatter = float(np.sum((measured.weights * (measured.means - means_of_speeds.mu[index])) ** 2))
    repeats = count - len(means_of_speeds)
    shapes = len(means_of_speeds) - len(names)
    if repeats > 0 and shapes > 0 and scatter > 0:
        ratio = (chi_squared - scatter) / shapes / (scatter / repeats)
        # Along the speed, a law that does not describe them is what correlates the residuals.
        if fdtrc(shapes, repeats, ratio / noise.along_the_file) <= VERY_UNLIKELY:
            yield (
                f"the law does not describe the measurements: {size}, and repeats at one speed scatter by "
                f"{np.sqrt(scatter / repeats):.2g}; take another law"
            )

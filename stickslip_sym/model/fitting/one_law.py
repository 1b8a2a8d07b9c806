"""One law fitted to measurements: the best of several starts, and whether the measurements determine it."""

from dataclasses import replace
from itertools import combinations

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.model.fitting.least_squares import Minimum, Parametric, Problem
from stickslip_sym.model.fitting.result import Fit
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements

__all__ = ["fit_law"]

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
_ROUNDING = 1e-12  # of the largest mu: residuals as small are no noise
_FEWEST = 8  # rows, up to which no correlation stands out
_MOST_CORRELATED = 0.95  # beyond it the rows are too few to tell noise from a trend
_RISEN = 0.75  # of the largest mu: a law with mu(0) = 0 has built up friction where it first reaches this


def fit_law(law: FrictionLaw, measured: Measurements) -> Fit | str:
    """Return the fit of a law's free parameters, or why these measurements do not determine them.

    Residuals are divided by sigma where it is known; the covariance is then f times (J^T J)^-1, and else s^2 times
    it, where s^2 = sum of squares / (n/f - k). J holds the exact derivatives of the residuals to the k free
    parameters, and f = (1 + r)/(1 - r) is 1 where the noise has no correlation r from row to row.
    """
    names = Parametric(law, measured.v).names
    count, k = len(measured), len(names)
    if k == 0:
        return "it has no parameter without a value"
    if len(measured.speeds) < k or count < k + 2:
        rows = f"{count} rows at {len(measured.speeds)} speeds"
        return f"it has {k} free parameter{'s' * (k > 1)}, and {rows} are too few"
    problem = Problem(law, measured)
    best = _best(law, problem, measured)
    if best is None:
        return "no start converged: its values run away without an end; fix one of them, or take a simpler law"
    order = _order(law, problem.model, best.p)
    p, held = best.p[order], best.held[order]
    chi_squared, known = best.chi_squared, measured.sigma is not None
    derivatives = measured.weights[:, None] * problem.model.jacobian(p)
    if reason := _undetermined(names, p, derivatives) or _unseen_rise(law, p, measured):
        return reason
    correlation = _correlation(problem.residuals(p), measured, k)
    inflation = (1 + correlation) / (1 - correlation)
    dof = max(count / inflation - k, 1.0)
    sizes = np.linalg.norm(derivatives, axis=0)
    inverse = np.linalg.inv((derivatives / sizes).T @ (derivatives / sizes))
    variance = inflation if known else chi_squared / dof
    covariance = variance * (inverse + inverse.T) / (2 * np.outer(sizes, sizes))
    errors = np.sqrt(np.diag(covariance))
    for i in np.flatnonzero(~problem.model.linear & (errors > _NOTHING * np.abs(p))):
        alike = np.flatnonzero(np.abs(covariance[i]) > _ALIKE * errors[i] * errors)
        return _apart(names, alike, p / errors) if len(alike) > 1 else _nothing(names[i])
    return Fit(
        free_law=law,
        values=dict(zip(names, p.tolist(), strict=True)),
        covariance=covariance,
        measured=measured,
        chi_squared=chi_squared,
        dof=dof,
        inflation=inflation,
        warnings=(
            *_loose(problem.model, p, covariance, held), *_noise(correlation, count),
            *_scatter(chi_squared, measured, k, inflation),
        ),
    )  # fmt: skip


def _best(law: FrictionLaw, problem: Problem, measured: Measurements) -> Minimum | None:
    """Return the least of the minima that several starts lead to."""
    coarse = problem
    if len(measured) > _MANY:
        means = measured.binned(_BINS)  # whose own scatter is no sigma
        coarse = Problem(law, means if measured.sigma is not None else replace(means, sigma=None))
    best: Minimum | None = None
    for start in coarse.starts(_STARTS):
        minimum = coarse.minimum(start)
        if minimum is None:
            continue
        if best is not None and abs(minimum.chi_squared - best.chi_squared) <= _SAME * best.chi_squared:
            break
        if best is None or minimum.chi_squared < best.chi_squared:
            best = minimum
    return best if coarse is problem or best is None else problem.minimum(best.p)


def _order(law: FrictionLaw, model: Parametric, p: FloatArray) -> list[int]:
    """Return the order of the values in which like terms stand as their typical values do.

    Where two parameters can change places, each with its amplitude, two minima are one: a fast and a slow drop.
    """
    order = list(range(len(p)))
    symbols = [law.parameters[name].symbol for name in model.names]
    typical = [float(law.parameters[name].typical or i) for i, name in enumerate(model.names)]
    amplitudes = list(combinations(np.flatnonzero(model.linear).tolist(), 2))
    for i, j in combinations(np.flatnonzero(~model.linear).tolist(), 2):
        for pairs in ([(i, j)], *([(i, j), pair] for pair in amplitudes)):
            swap = {symbols[a]: symbols[b] for pair in pairs for a, b in (pair, pair[::-1])}
            if law.expr.xreplace(swap) == law.expr and (p[i] < p[j]) != (typical[i] < typical[j]):
                for a, b in pairs:
                    order[a], order[b] = order[b], order[a]
                return order
    return order


def _correlation(residuals: FloatArray, measured: Measurements, k: int) -> float:
    """Return the correlation of residuals from row to row of the file, 0 where white noise would show as much.

    The k parameters follow part of the noise, and make it seem less correlated by about (k + 3 r)/n.
    """
    count = len(residuals)
    rounding = _ROUNDING * np.max(np.abs(measured.weights * measured.mu))
    if measured.order is None or count <= _FEWEST or np.max(np.abs(residuals)) <= rounding:
        return 0.0
    e = residuals[np.argsort(measured.order)]
    lagged = float(np.sum(e[1:] * e[:-1]) / np.sum(e**2))
    corrected, deviation = (lagged * count + k) / (count - 3), np.sqrt(count) / (count - 3)
    return 0.0 if corrected <= _CORRELATED * deviation else min(corrected, _MOST_CORRELATED)


def _undetermined(names: tuple[str, ...], p: FloatArray, derivatives: FloatArray) -> str | None:
    """Return which parameters have no effect, or cannot be told apart; None if each is determined."""
    sizes = np.linalg.norm(derivatives, axis=0)
    if not (np.isfinite(sizes).all() and sizes.all()):
        without = [name for name, size in zip(names, sizes, strict=True) if not (np.isfinite(size) and size)]
        return _nothing(without[0])
    _, singular, rows = np.linalg.svd(derivatives / sizes, full_matrices=False)
    if singular[-1] > _SINGULAR * singular[0]:
        return None
    part = np.abs(rows[-1])
    return _apart(names, np.flatnonzero(part > _MIXED * part.max()), sizes * p)


def _apart(names: tuple[str, ...], which: IntArray, strength: FloatArray) -> str:
    """Return that some parameters cannot be told apart, and to fix the one with the least effect."""
    weakest = min(which, key=lambda i: abs(strength[i]))
    mixed = " and ".join(names[i] for i in which)
    return f"these measurements do not tell {mixed} apart; fix one: {_fixed(names[weakest])}"


def _nothing(name: str) -> str:
    return f"these measurements say nothing of {name}; fix it: {_fixed(name)}"


def _fixed(name: str) -> str:
    return f"law.bind({name}=...)"


def _unseen_rise(law: FrictionLaw, p: FloatArray, measured: Measurements) -> str | None:
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


def _loose(model: Parametric, p: FloatArray, covariance: FloatArray, held: BoolArray) -> list[str]:
    """Return a sentence for each parameter that the measurements hardly determine, with what to fix."""
    errors = np.sqrt(np.diag(covariance))
    sentences = []
    for i, name in enumerate(model.names):
        if held[i]:
            sentences.append(
                f"{name} is held at its bound 0, where the measurements ask for less; fix it: law.bind({name}=0), "
                f"or declare Parameter({name!r}, positive=False) if any sign is meant"
            )
        elif model.positive[i] and errors[i] > _LOOSE * p[i]:
            sentences.append(
                f"{name} = {p[i]:.3g} has a standard error of {errors[i]:.2g}: these measurements hardly "
                f"determine it; fix it, {_fixed(name)}, or take a law without it"
            )
    for i, j in combinations(np.flatnonzero(errors).tolist(), 2):
        correlation = covariance[i, j] / errors[i] / errors[j]
        if abs(correlation) > _ALIKE:
            sentences.append(
                f"{model.names[i]} and {model.names[j]} are hardly told apart, correlation "
                f"{correlation:.4f}; fix one: {_fixed(model.names[j])}"
            )
    return sentences


def _noise(correlation: float, count: int) -> list[str]:
    if not correlation:
        return []
    effective = count * (1 - correlation) / (1 + correlation)
    return [
        f"residuals of successive rows of the file are correlated, {correlation:.2f}: {count} rows count as "
        f"{effective:.0f}, and standard errors are {np.sqrt(count / effective):.2g} times as wide; noise is slow, "
        "or the law does not describe the measurements"
    ]


def _scatter(chi_squared: float, measured: Measurements, k: int, inflation: float) -> list[str]:
    """Return whether residuals are too large or too small for sigma, or for the scatter of repeated speeds."""
    from scipy.special import chdtr, chdtrc, fdtrc

    sentences = []
    dof = len(measured) - k
    if measured.sigma is not None:
        ratio = f"residuals are {np.sqrt(chi_squared / dof):.2g} times sigma"
        if chdtrc(dof, chi_squared / inflation) <= _UNLIKELY:
            sentences.append(
                f"{ratio}: the law does not describe the measurements, or sigma is too small; the standard errors "
                "rest on sigma"
            )
        elif chdtr(dof, chi_squared) <= _UNLIKELY:
            means = " and the file counts them," if measured.counts is not None else ""
            sentences.append(
                f"{ratio}: sigma is too large; if each mu is the mean of n values,{means} and sigma is the "
                "standard deviation of one value, sigma/sqrt(n) belongs in its place; standard errors rest on it"
            )
    weights = measured.weights**2
    _, index = np.unique(measured.v, return_inverse=True)
    mean = np.bincount(index, weights * measured.mu) / np.bincount(index, weights)
    scatter = float(np.sum(weights * (measured.mu - mean[index]) ** 2))
    repeats, shapes = len(measured) - len(mean), len(mean) - k
    if repeats > 0 and shapes > 0 and scatter > 0:
        ratio_of_variances = (chi_squared - scatter) / shapes / (scatter / repeats)
        if fdtrc(shapes, repeats, ratio_of_variances / inflation) <= _UNLIKELY:
            unit = " times sigma" if measured.sigma is not None else ""
            sentences.append(
                "the law does not describe the measurements: "
                f"residuals are {np.sqrt(chi_squared / dof):.2g}{unit}, "
                f"and repeats at one speed scatter by {np.sqrt(scatter / repeats):.2g}; take another law"
            )
    return sentences

"""One law fitted to measurements: the best of several starts, and whether the measurements determine it."""

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.model.measured.fit import Fit
from stickslip_sym.model.measured.least_squares import Minimum, Problem
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.measured.parametric import FittedLaw, Parametric
from stickslip_sym.model.measured.starts import starts

__all__ = ["fit_law"]

FloatArray = NDArray[np.float64]

_STARTS = 4  # different ones; for most laws the best few of the trials lead to one minimum
_SINGULAR = 1e-7  # least singular value of the scaled derivatives over the largest: a smaller one has no effect
_SAME = 1e-8  # relative difference of two sums of squares that are one minimum; two starts in it are enough
_NOTHING = 100.0  # relative standard error, beyond which a parameter that is not linear was not measured
_LOOSE = 0.5  # relative standard error of a positive parameter that is worth a warning
_MIXED = 0.1  # part in the direction without effect, over the largest: smaller parts are not named
_ALIKE = 0.999  # correlation of two parameters that is worth a warning
_UNLIKELY = 1e-3  # probability of so large residuals, if sigma is right, that is worth a warning
_RISEN = 0.75  # of the largest mu: a law with mu(0) = 0 has built up friction where it first reaches this


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
    problem = Problem(model, measured)
    best: Minimum | None = None
    for start in starts(law, model, measured.v, measured.mu, problem.weights, _STARTS):
        found = problem.minimum(start)
        if found is None:
            continue
        if best is not None and abs(found.chi_squared - best.chi_squared) <= _SAME * best.chi_squared:
            break
        if best is None or found.chi_squared < best.chi_squared:
            best = found
    if best is None:
        return "no start converged: its values run away without an end; fix one of them, or take a simpler law"
    order = _order(law, model, best.p)
    p, held = best.p[order], best.held[order]
    chi_squared, dof = best.chi_squared, count - k
    derivatives = problem.weights[:, None] * model.jacobian(p)
    if reason := _undetermined(model.names, p, derivatives) or _unseen_rise(law, p, measured):
        return reason
    variance = chi_squared / dof if measured.sigma is None else 1.0
    sizes = np.linalg.norm(derivatives, axis=0)
    inverse = np.linalg.inv((derivatives / sizes).T @ (derivatives / sizes))
    covariance = variance * (inverse + inverse.T) / (2 * np.outer(sizes, sizes))
    errors = np.sqrt(np.diag(covariance))
    for i in np.flatnonzero(~model.linear & (errors > _NOTHING * np.abs(p))):
        alike = np.flatnonzero(np.abs(covariance[i]) > _ALIKE * errors[i] * errors)
        return _apart(model.names, alike, p / errors) if len(alike) > 1 else _nothing(model.names[i])
    values = dict(zip(model.names, p.tolist(), strict=True))
    known = measured.sigma is not None
    return Fit(
        law=law.bind(**values),
        values=values,
        covariance=covariance,
        measured=measured,
        chi_squared=chi_squared,
        dof=dof,
        aicc=_aicc(best.aic, chi_squared, k, count, known=known),
        warnings=(*_loose(model, p, covariance, held), *_scatter(chi_squared, dof, known=known)),
    )


def _order(law: FittedLaw, model: Parametric, p: FloatArray) -> list[int]:
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


def _aicc(aic: float, chi_squared: float, k: int, count: int, *, known: bool) -> float:
    """Return Akaike's criterion, corrected for few rows; an unknown sigma is one more parameter."""
    total = k if known else k + 1
    criterion = chi_squared + 2 * k if known else aic + 2
    return criterion + 2 * total * (total + 1) / (count - total - 1)


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


def _apart(names: tuple[str, ...], which: NDArray[np.intp], strength: FloatArray) -> str:
    """Return that some parameters cannot be told apart, and to fix the one with the least effect."""
    weakest = min(which, key=lambda i: abs(strength[i]))
    mixed = " and ".join(names[i] for i in which)
    return f"these measurements do not tell {mixed} apart; fix one: {_fixed(names[weakest])}"


def _nothing(name: str) -> str:
    return f"these measurements say nothing of {name}; fix it: {_fixed(name)}"


def _fixed(name: str) -> str:
    return f"law.bind({name}=...)"


def _unseen_rise(law: FittedLaw, p: FloatArray, measured: Measurements) -> str | None:
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


def _loose(
    model: Parametric, p: FloatArray, covariance: FloatArray, held: NDArray[np.bool_]
) -> list[str]:  # fmt: skip
    """Return a sentence for each parameter that the measurements hardly determine, with what to fix."""
    errors = np.sqrt(np.diag(covariance))
    said = []
    for i, name in enumerate(model.names):
        if held[i]:
            said.append(
                f"{name} is held at its bound 0, where the measurements ask for less; fix it: law.bind({name}=0), "
                f"or declare Parameter({name!r}, positive=False) if any sign is meant"
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

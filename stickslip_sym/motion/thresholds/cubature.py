"""Whether the first order serves for the standard error of a threshold: the second, by cubature."""

import warnings
from collections.abc import Mapping
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.core.aliases import FloatArray, Numbers
from stickslip_sym.core.errors import InputWarning, OutOfTime, StickSlipError
from stickslip_sym.motion.thresholds.rungs import Rung, rungs
from stickslip_sym.motion.thresholds.scenes import Scenes
from stickslip_sym.motion.thresholds.uncertainty import Errors

__all__ = ["second_over_first", "shifted", "warn_of_ratio"]

_TIGHT = 1e-8  # relative error of a threshold at a point of the cubature, far below what it is compared with
_HIDDEN = 10.0  # times that error, what two thresholds may differ by for no other reason
_SERVES = 0.1  # of the first order's standard error, by which the second order's may differ
_RANK = 1e-12  # of the largest eigenvalue of the correlations, below which one is 0


def second_over_first(
    scenes: Scenes, first: FloatArray, method: NDArray[np.str_], errors: Errors, own: Rung | None
) -> tuple[FloatArray, str]:
    """Return the standard error of thresholds to second order over that to first, and why it is NaN where it is.

    The threshold is computed at the 2 n^2 + 1 points of a cubature of the fifth degree (McNamee and Stenger 1967)
    for n normal quantities, correlated as they are: the variance is exact for a threshold that is a quadratic
    function of them, products included.

    Parameters
    ----------
    scenes : Scenes
    first : numpy.ndarray, shape (n,)
        The standard errors to first order.
    method : numpy.ndarray of str
        Of each scene.
    errors : Errors
    own : Rung or None
        The rung, where it is not one of the ladder.
    """
    found, reason = np.full(len(scenes), np.nan), ""
    apart = len(errors.covariance) > 1
    for chosen in np.unique(method):
        rows = np.flatnonzero(method == chosen)
        rung = own or rungs()["simulation" if chosen == "proof" else str(chosen)]
        for part in rows[:, None] if apart else [rows]:
            try:
                covariance = errors.rows(part[0]).covariance.reshape(len(errors.names), -1)
                found[part] = _by_cubature(scenes.rows(part), first[part], rung, covariance, errors.names)
            except OutOfTime:
                raise
            except StickSlipError as error:
                reason = str(error)
    return found, reason


def _by_cubature(
    scenes: Scenes, first: FloatArray, rung: Rung, covariance: FloatArray, names: tuple[str, ...]
) -> FloatArray:
    directions = _directions(covariance)
    points, weights = _fifth_degree(directions.shape[1])
    values = np.array([
        rung.compute(shifted(scenes, dict(zip(names, directions @ point, strict=True))), _tolerance(rung)).value
        for point in points
    ])  # fmt: skip
    off = values - values[0]  # the first point is the mean itself
    mean = (weights[:, None] * off).sum(axis=0)
    variance = (weights[:, None] * off**2).sum(axis=0) - mean**2
    # Standard errors that the thresholds' own errors hide are too small for a second order.
    hidden = _HIDDEN * _tolerance(rung) * np.abs(values[0])
    with np.errstate(all="ignore"):
        second = np.where(variance >= 0, np.sqrt(variance), np.inf)
        return np.where((first <= hidden) & (np.abs(off).max(axis=0) <= hidden), 1.0, second / first)


def _tolerance(rung: Rung) -> float:
    return min(max(_TIGHT, rung.tightest), rung.loosest)


def shifted(scenes: Scenes, by: Mapping[str, float]) -> Scenes:
    """Return scenes with some quantities and parameters shifted.

    Raises
    ------
    InputError
        If one leaves where it may be.
    """
    law = scenes.law
    parameters = {name: float(law.values[name]) + by[name] for name in law.parameters if name in by}
    columns = {"V": scenes.V, "N": scenes.N, "m": scenes.m, "k": scenes.k}
    moved = {name: None if column is None else column + by.get(name, 0.0) for name, column in columns.items()}
    return Scenes.of(law.bind(**parameters), **moved)


def _directions(covariance: FloatArray) -> FloatArray:
    """Return a matrix L with L L^T = covariance, without columns of zeros."""
    size = np.sqrt(np.diagonal(covariance))
    unit = np.where(size > 0, size, 1.0)
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    kept = eigenvalues > _RANK * eigenvalues.max(initial=0.0)
    matrix: FloatArray = unit[:, None] * vectors[:, kept] * np.sqrt(eigenvalues[kept])
    return matrix


def _fifth_degree(n: int) -> tuple[FloatArray, FloatArray]:
    """Return points and weights that integrate polynomials of degree 5 over n standard normal variables."""
    unit, far = np.eye(n), np.sqrt(3.0)
    axes = [sign * far * one for one in unit for sign in (-1, 1)]
    pairs = [
        far * (first * unit[i] + second * unit[j])
        for i, j in combinations(range(n), 2)
        for first, second in product((-1, 1), repeat=2)
    ]
    weights = [1 + (n * n - 7 * n) / 18, *[(4 - n) / 18] * len(axes), *[1 / 36] * len(pairs)]
    return np.array([np.zeros(n), *axes, *pairs]), np.array(weights)


def warn_of_ratio(ratio: Numbers, reason: str) -> None:
    """Warn where the second order says that the first does not serve.

    Warns
    -----
    InputWarning
    """
    ratio = np.ravel(ratio)
    if np.isnan(ratio).any():
        warnings.warn(
            f"the standard error of c could not be checked by its second order: {reason or 'there is no value'}; "
            "take it as a rough one",
            InputWarning,
            stacklevel=3,
        )
    elif ratio.size and (worst := ratio[np.abs(ratio - 1).argmax()]) and abs(worst - 1) > _SERVES:
        warnings.warn(
            f"the standard error of c is {worst:.2f} times as large to second order: the errors of the parameters "
            "are too large for the first order to serve",
            InputWarning,
            stacklevel=3,
        )

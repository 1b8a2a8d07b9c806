"""What the standard errors of quantities and parameters do to a threshold, to first and to second order."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from uncertainties import covariance_matrix

from stickslip_sym.core.aliases import FloatArray, Numbers
from stickslip_sym.core.errors import NO_RESULT, InputWarning
from stickslip_sym.core.numbers import SAME
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.output.content import content
from stickslip_sym.output.data import TableResult
from stickslip_sym.output.shown import Report

_OUTER_NODE = np.sqrt(3.0)  # standard errors; the outer nodes of the Gauss rule of three for normal errors
_SUFFICES = 0.1  # of the first order's standard error, by which the second order's may differ


def standard_errors(points: OperatingPoints) -> tuple[tuple[str, ...], FloatArray]:
    """Return the names of all that carries a standard error at some points, and the covariance."""
    carriers: dict[str, UFloat] = {**points.uncertain, **points.law.uncertain}
    covariance = np.array(covariance_matrix(list(carriers.values())))
    return tuple(carriers), covariance.reshape(len(carriers), len(carriers))


# -- first order -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Budget(Report, TableResult):
    """Which standard error brings how much of that of a threshold, to first order.

    The variance is the sum of s_i C_ij s_j, s the sensitivities and C the covariance. The share of i is its row
    of the sum over the whole: shares add up to 1. Where errors are correlated a share may be negative, and to know
    that quantity exactly does not take just its share away.

    Attributes
    ----------
    names : tuple of str
        Largest share first.
    deviations : mapping of str to float
        Standard errors, in SI units.
    alone : mapping of str to float or numpy.ndarray
        What each would do if there were no other, abs(s_i) times its standard error, in kg/s.
    shares : mapping of str to float or numpy.ndarray
        Of the variance.
    uncertainty : float or numpy.ndarray
        Standard error of the threshold, in kg/s.
    correlated : list of (str, str, float)
        Pairs with their coefficient of correlation.
    """

    reported = ("deviations", "alone", "shares", "correlated")

    names: tuple[str, ...]
    deviations: Mapping[str, float]
    alone: Mapping[str, Any]
    shares: Mapping[str, Any]
    uncertainty: Any
    correlated: list[tuple[str, str, float]]

    @classmethod
    def of(
        cls, names: Sequence[str], covariance: FloatArray, sensitivity: Mapping[str, Numbers],
        shape: tuple[int, ...],
    ) -> "Budget":  # fmt: skip
        """Return the budget of thresholds with given sensitivities."""
        s = np.stack([np.ravel(sensitivity[name]) for name in names])
        parts = s * (covariance @ s)
        variance = np.maximum(parts.sum(axis=0), 0.0)
        with np.errstate(all="ignore"):
            shares = np.where(variance > 0, parts / variance, 0.0)
        sizes = np.sqrt(np.diagonal(covariance))
        correlation = covariance / np.outer(sizes, sizes)
        pairs = [(names[i], names[j], float(correlation[i, j])) for i, j in combinations(range(len(names)), 2)]
        order = np.argsort(-shares.sum(axis=1), kind="stable").tolist()
        return cls(
            tuple(names[i] for i in order),
            {names[i]: float(sizes[i]) for i in order},
            {names[i]: shaped(np.abs(s[i]) * sizes[i], shape) for i in order},
            {names[i]: shaped(shares[i], shape) for i in order},
            shaped(np.sqrt(variance), shape),
            [pair for pair in pairs if abs(pair[2]) > SAME],
        )

    def _table_columns(self) -> dict[str, list[Any]]:
        said = {"standard_error": self.deviations, "alone": self.alone, "share": self.shares}
        columns = {title: [content(of[name]) for name in self.names] for title, of in said.items()}
        return {"quantity": list(self.names), **columns}


def shaped(column: FloatArray, shape: tuple[int, ...]) -> Any:
    """Return a flat array in the shape that the operating points had, as a float for one point."""
    if shape == ():
        return float(column[0])
    return np.asarray(column).reshape(shape)


def ranged(values: Numbers, form: str) -> str:
    """Return numbers as text, from the lowest to the highest."""
    if not np.size(values):
        return ""
    low, high = (format(float(end(values)), form) for end in (np.min, np.max))
    if low == high:
        return low
    return f"{low} to {high}"


# -- second order ----------------------------------------------------------------------------------


def second_order_ratio(
    points: OperatingPoints, value: FloatArray, gradient: Callable[[OperatingPoints], Mapping[str, FloatArray]]
) -> tuple[FloatArray, str]:
    """Return the standard error of thresholds to second order over that to first, and why it is not known.

    In independent standard normal variables x, with covariance C = L L^T, the threshold is
    a x + h x x/2 + t x x x/6, its variance sum a_j^2 + sum h_ij^2/2 + sum a_j t_iij up to the fourth order
    in the errors. All of it follows from the gradients sqrt(3) standard errors up and down each axis: 2 n of
    them for n errors, products included.

    - `value`: the thresholds; standard errors below their rounding need no second order.
    - `gradient`: from points to the derivatives of their thresholds, by name.

    The ratios are NaN where a quantity off by sqrt(3) standard errors leaves where it may be, or there is no
    threshold.
    """
    names, covariance = standard_errors(points)
    size = np.sqrt(np.diagonal(covariance))
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    kept = eigenvalues > SAME * eigenvalues.max()
    L = size[:, None] * vectors[:, kept] * np.sqrt(eigenvalues[kept])

    def slope(shift: FloatArray) -> FloatArray:
        """Return the gradient by x, one column a point."""
        by = gradient(points.shifted(dict(zip(names, shift.tolist(), strict=True))))
        return np.asarray(L.T @ np.stack([by[name] for name in names]))

    try:
        a = slope(np.zeros(len(names)))
        up, down = (np.array([slope(side * _OUTER_NODE * axis) for axis in L.T]) for side in (1, -1))
    except NO_RESULT as error:
        return np.full(len(points), np.nan), str(error)
    h = (up - down) / (2 * _OUTER_NODE)
    t = (up + down - 2 * a) / _OUTER_NODE**2
    first = (a**2).sum(axis=0)
    second = np.maximum(first + (h**2).sum(axis=(0, 1)) / 2 + (a * t).sum(axis=(0, 1)), 0.0)
    with np.errstate(all="ignore"):
        return np.where(second > (SAME * value) ** 2, np.sqrt(second / first), 1.0), ""


def warn_of_ratio(ratio: Numbers, reason: str) -> None:
    """Warn where the second order says that the first does not suffice."""
    ratio = np.ravel(ratio)
    worst = 1.0
    if ratio.size:
        worst = ratio[np.abs(ratio - 1).argmax()]  # NaN where there is any
    if np.isnan(worst):
        message = (
            f"the standard error of c could not be checked by its second order: {reason or 'there is no value'}; "
            "take it as a rough one"
        )
    elif abs(worst - 1) > _SUFFICES:
        message = (
            f"the standard error of c is {worst:.2f} times as large to second order: the errors of the "
            "parameters are too large for the first order to suffice"
        )
    else:
        return
    warnings.warn(message, InputWarning, stacklevel=3)

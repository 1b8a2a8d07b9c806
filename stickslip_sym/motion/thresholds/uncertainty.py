"""What the standard errors of quantities and parameters do to a threshold, to first and to second order."""

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from uncertainties import covariance_matrix

from stickslip_sym.core.aliases import FloatArray, Numbers, ObjectArray
from stickslip_sym.core.errors import NO_RESULT, InputWarning
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import harmonic
from stickslip_sym.motion.thresholds.averages import average_changes
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.output import markup
from stickslip_sym.output.tables import table

_PART = 0.1  # of the parameters' standard error, that of the method; and its largest relative error
_CORRELATED = 1e-9  # a coefficient of correlation below is rounding
_FAR = np.sqrt(3.0)  # standard errors; the outer nodes of the Gauss rule of three for normal errors
_SUFFICES = 0.1  # of the first order's standard error, by which the second order's may differ
_ROUNDING = 1e-12  # of a threshold, a standard error; and of the largest eigenvalue of correlations, another


@dataclass(frozen=True)
class Errors:
    """The standard errors of some operating points of one law.

    - `names`: of what carries an error.
    - `covariance`: of all points, shape (1, names, names), or of each.
    """

    names: tuple[str, ...]
    covariance: FloatArray

    @property
    def deviations(self) -> FloatArray:
        """Standard errors, one row a point."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    @property
    def correlated(self) -> list[tuple[str, str, float]]:
        """The pairs that are correlated, with the largest coefficient that any point has."""
        size = self.deviations
        with np.errstate(all="ignore"):
            r = np.nan_to_num(self.covariance / (size[:, :, None] * size[:, None, :]))
        largest = np.take_along_axis(r, np.abs(r).argmax(axis=0)[None], axis=0)[0]
        pairs = combinations(range(len(self.names)), 2)
        found = [(self.names[i], self.names[j], float(largest[i, j])) for i, j in pairs]
        return [pair for pair in found if abs(pair[2]) > _CORRELATED]


def standard_errors(points: OperatingPoints) -> Errors | None:
    """Return the covariance of all that carries a standard error at some points; None where nothing does."""
    carriers: dict[str, UFloat | ObjectArray] = {**points.uncertain, **points.law.uncertain}
    if not carriers:
        return None
    single = all(isinstance(value, UFloat) for value in carriers.values())
    covariance = np.zeros((1 if single else len(points), len(carriers), len(carriers)))
    for row, found in enumerate(covariance):
        values = [value if isinstance(value, UFloat) else value[row] for value in carriers.values()]
        carrying = [i for i, value in enumerate(values) if isinstance(value, UFloat)]
        if carrying:
            found[np.ix_(carrying, carrying)] = covariance_matrix([values[i] for i in carrying])
    return Errors(tuple(carriers), covariance)


# -- first order -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Budget:
    """Which standard error brings how much of that of a threshold, to first order.

    The variance is the sum of s_i C_ij s_j, s the sensitivities and C the covariance. The share of i is its row
    of the sum over the whole: shares add up to 1. Where errors are correlated a share may be negative, and to know
    that quantity exactly does not take just its share away.

    Attributes
    ----------
    names : tuple of str
        Largest share first.
    deviations : mapping of str to float or numpy.ndarray
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
    deviations: Mapping[str, Any]
    alone: Mapping[str, Any]
    shares: Mapping[str, Any]
    uncertainty: Any
    correlated: list[tuple[str, str, float]]

    @classmethod
    def of(cls, errors: Errors, sensitivity: Mapping[str, Numbers], shape: tuple[int, ...]) -> "Budget":
        """Return the budget of thresholds with given sensitivities."""
        s = np.stack([np.ravel(sensitivity[name]) for name in errors.names], axis=1)
        parts = s * (errors.covariance @ s[:, :, None])[:, :, 0]
        variance = np.maximum(parts.sum(axis=1), 0.0)
        with np.errstate(all="ignore"):
            shares = np.where(variance[:, None] > 0, parts / variance[:, None], 0.0)
        sizes = np.broadcast_to(errors.deviations, s.shape)
        order = np.argsort(-shares.mean(axis=0), kind="stable") if len(s) else np.arange(len(errors.names))

        def columns(values: FloatArray) -> dict[str, Any]:
            return {errors.names[i]: shaped(values[:, i], shape) for i in order}

        return cls(
            tuple(errors.names[i] for i in order), columns(sizes), columns(np.abs(s) * sizes), columns(shares),
            shaped(np.sqrt(variance), shape), errors.correlated,
        )  # fmt: skip

    @property
    def _cells(self) -> tuple[list[str], list[list[str]]]:
        rows = []
        for name in self.names:
            share = _range(100 * np.asarray(self.shares[name]), ".1f")
            rows.append(
                [name, _range(self.deviations[name], ".3g"), _range(self.alone[name], ".3g"), f"{share} %"]
            )
        return ["quantity", "standard error", "alone, kg/s", "share of the variance"], rows

    @property
    def _remark(self) -> str:
        pairs = ", ".join(f"{one} and {other} ({r:+.2f})" for one, other, r in self.correlated)
        return f"correlated: {pairs}; their shares hold only together" if pairs else ""

    def __str__(self) -> str:
        return table(*self._cells) + (f"\n{self._remark}" if self._remark else "")

    def _repr_html_(self) -> str:
        return markup.table(*self._cells, caption=self._remark or "budget of the standard error")


def shaped(column: FloatArray, shape: tuple[int, ...]) -> Any:
    """Return a flat array in the shape that the operating points had, as a float for one point."""
    return float(column[0]) if shape == () else np.asarray(column).reshape(shape)


def _range(values: Numbers, form: str) -> str:
    if not np.size(values):
        return ""
    low, high = (format(float(end(values)), form) for end in (np.min, np.max))
    return low if low == high else f"{low} to {high}"


def deserved_tolerance(points: OperatingPoints) -> float:
    """Return the relative error of a method that is small beside what the parameters do to harmonic averages.

    A tenth of the smallest relative standard error of any point, which adds half a percent to it; 0 where nothing
    carries an error.
    """
    errors = standard_errors(points)
    if errors is None or not len(points):
        return 0.0
    nothing = np.zeros(len(points))
    by = dict.fromkeys(errors.names, nothing) | average_changes(harmonic, points, nothing)
    with np.errstate(all="ignore"):
        relative = Budget.of(errors, by, (len(points),)).uncertainty / np.abs(points.N * by["N"])
    return _PART * min(float(np.nan_to_num(relative, nan=0.0).min()), 1.0)


# -- second order ----------------------------------------------------------------------------------


def second_order_ratio(
    points: OperatingPoints, value: FloatArray, gradient: Callable[..., Mapping[str, FloatArray]], errors: Errors
) -> tuple[FloatArray, str]:
    """Return the standard error of thresholds to second order over that to first, and why it is not known.

    In independent standard normal variables x, with covariance C = L L^T, the threshold is
    a x + h x x/2 + t x x x/6, its variance sum a_j^2 + sum h_ij^2/2 + sum a_j t_iij up to the fourth order
    in the errors. All of it follows from the gradients sqrt(3) standard errors up and down each axis: 2 n of
    them for n errors, products included.

    - `value`: the thresholds; standard errors below their rounding need no second order.
    - `gradient`: from points, and the rows that they stand for, to the derivatives of their thresholds, by name.

    The ratios are NaN where a quantity off by sqrt(3) standard errors leaves where it may be, or there is no
    threshold.
    """
    every = np.arange(len(points))
    parts = [every] if len(errors.covariance) == 1 else every[:, None]
    try:
        return np.concatenate([
            _ratios(points.rows(rows), value[rows], partial(gradient, rows=rows), errors.names, covariance)
            for rows, covariance in zip(parts, errors.covariance, strict=True)
        ]), ""  # fmt: skip
    except NO_RESULT as error:
        return np.full(len(points), np.nan), str(error)


def _ratios(
    points: OperatingPoints,
    value: FloatArray,
    gradient: Callable[..., Mapping[str, FloatArray]],
    names: Sequence[str],
    covariance: FloatArray,
) -> FloatArray:
    L = _axes(covariance)

    def slope(shift: FloatArray) -> FloatArray:
        """Return the gradient by x, one column a point."""
        by = gradient(points.shifted(dict(zip(names, shift.tolist(), strict=True))))
        return np.asarray(L.T @ np.stack([by[name] for name in names]))

    a = slope(np.zeros(len(names)))
    first = second = (a**2).sum(axis=0)
    if L.shape[1]:
        up, down = (np.array([slope(side * _FAR * axis) for axis in L.T]) for side in (1, -1))
        h, t = (up - down) / (2 * _FAR), (up + down - 2 * a) / _FAR**2
        second = np.maximum(first + (h**2).sum(axis=(0, 1)) / 2 + (a * t).sum(axis=(0, 1)), 0.0)
    with np.errstate(all="ignore"):
        return np.where(second > (_ROUNDING * value) ** 2, np.sqrt(second / first), 1.0)


def _axes(covariance: FloatArray) -> FloatArray:
    """Return a matrix L with L L^T = covariance, without columns of zeros."""
    size = np.sqrt(np.diagonal(covariance))
    unit = np.where(size > 0, size, 1.0)
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(unit, unit))
    kept = eigenvalues > _ROUNDING * eigenvalues.max(initial=0.0)
    return np.asarray(unit[:, None] * vectors[:, kept] * np.sqrt(eigenvalues[kept]))


def warn_of_ratio(ratio: Numbers, reason: str) -> None:
    """Warn where the second order says that the first does not suffice."""
    ratio = np.ravel(ratio)
    worst = ratio[np.abs(ratio - 1).argmax()] if ratio.size else 1.0  # NaN where there is any
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

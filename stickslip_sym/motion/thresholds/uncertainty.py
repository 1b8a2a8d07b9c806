"""What the standard errors of quantities and parameters do to a threshold, to first order."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from stickslip_sym.core.aliases import FloatArray, Numbers, ObjectArray, Rows
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.criteria.criterion import harmonic
from stickslip_sym.motion.thresholds.rungs import rungs
from stickslip_sym.motion.thresholds.scenes import Scenes
from stickslip_sym.output import markup
from stickslip_sym.output.tables import table

__all__ = ["Budget", "Errors", "deserved_tolerance", "standard_errors"]

_PART = 0.1  # of the parameters' standard error, that of the method
_LARGEST = 0.1  # relative error of a method, however little is known of the parameters
_CORRELATED = 1e-9  # a coefficient of correlation below is rounding


@dataclass(frozen=True)
class Errors:
    """The standard errors of some scenes of one law.

    Attributes
    ----------
    names : tuple of str
        Of what carries an error.
    covariance : numpy.ndarray, shape (n, names, names) or (1, names, names)
        Of each scene, or of all.
    """

    names: tuple[str, ...]
    covariance: FloatArray

    @property
    def deviations(self) -> FloatArray:
        """Standard errors, one row a scene."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))

    @property
    def correlated(self) -> list[tuple[str, str, float]]:
        """The pairs that are correlated, with the largest coefficient that any scene has."""
        size = self.deviations
        with np.errstate(all="ignore"):
            r = np.nan_to_num(self.covariance / (size[:, :, None] * size[:, None, :]))
        largest = np.take_along_axis(r, np.abs(r).argmax(axis=0)[None], axis=0)[0]
        pairs = combinations(range(len(self.names)), 2)
        return [
            (self.names[i], self.names[j], float(largest[i, j]))
            for i, j in pairs
            if abs(largest[i, j]) > _CORRELATED
        ]

    def rows(self, chosen: Rows) -> "Errors":
        """Return those of some scenes."""
        return Errors(self.names, self.covariance if len(self.covariance) == 1 else self.covariance[chosen])


def standard_errors(scenes: Scenes) -> Errors | None:
    """Return the covariance of all that carries a standard error in some scenes; None where nothing does."""
    given: dict[str, UFloat | ObjectArray] = {**scenes.uncertain, **scenes.law.uncertain}
    if not given:
        return None
    single = all(isinstance(value, UFloat) for value in given.values())
    count = 1 if single else len(scenes)
    covariance = np.array([
        _covariance([value if isinstance(value, UFloat) else value[row] for value in given.values()])
        for row in range(count)
    ]).reshape(count, len(given), len(given))  # fmt: skip
    return Errors(tuple(given), covariance)


def _covariance(values: list[float | UFloat]) -> FloatArray:
    import uncertainties

    carrying = [place for place, value in enumerate(values) if isinstance(value, UFloat)]
    whole = np.zeros((len(values), len(values)))
    if carrying:
        found = uncertainties.covariance_matrix([values[place] for place in carrying])
        whole[np.ix_(carrying, carrying)] = found
    return whole


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
        parts = s * np.einsum(
            "nij,nj->ni", np.broadcast_to(errors.covariance, (len(s), *errors.covariance.shape[1:])), s
        )
        variance = np.maximum(parts.sum(axis=1), 0.0)
        with np.errstate(all="ignore"):
            shares = np.where(variance[:, None] > 0, parts / variance[:, None], 0.0)
        sizes = np.broadcast_to(errors.deviations, s.shape)

        def columns(values: FloatArray) -> dict[str, Any]:
            shaped = {name: _shaped(values[:, i], shape) for i, name in enumerate(errors.names)}
            return {name: shaped[name] for name in order}

        order = (
            [errors.names[i] for i in np.argsort(-shares.mean(axis=0), kind="stable")] if len(s) else errors.names
        )
        return cls(
            tuple(order), columns(sizes), columns(np.abs(s) * sizes), columns(shares),
            _shaped(np.sqrt(variance), shape), errors.correlated,
        )  # fmt: skip

    @property
    def _cells(self) -> tuple[list[str], list[list[str]]]:
        header = ["quantity", "standard error", "alone, kg/s", "share of the variance"]
        rows = [
            [
                name,
                _range(self.deviations[name], ".3g"),
                _range(self.alone[name], ".3g"),
                _range(100 * np.asarray(self.shares[name]), ".1f") + " %",
            ]
            for name in self.names
        ]
        return header, rows

    @property
    def _remark(self) -> str:
        if not self.correlated:
            return ""
        pairs = ", ".join(f"{one} and {other} ({r:+.2f})" for one, other, r in self.correlated)
        return f"correlated: {pairs}; their shares hold only together"

    def __str__(self) -> str:
        return table(*self._cells) + (f"\n{self._remark}" if self._remark else "")

    def _repr_html_(self) -> str:
        header, rows = self._cells
        return markup.table(header, rows, caption=self._remark or "budget of the standard error")


def _shaped(column: FloatArray, shape: tuple[int, ...]) -> Any:
    return float(column[0]) if shape == () else np.asarray(column).reshape(shape)


def _range(values: Numbers, form: str) -> str:
    if not np.size(values):
        return ""
    low, high = (format(float(end(values)), form) for end in (np.min, np.max))
    return low if low == high else f"{low} to {high}"


def deserved_tolerance(scenes: Scenes) -> float:
    """Return the relative error of a method that is small beside what the parameters do to harmonic averages.

    A tenth of the smallest relative standard error of any scene, which adds half a percent to it; 0 where nothing
    carries an error.
    """
    errors = standard_errors(scenes)
    if errors is None or not len(scenes):
        return 0.0
    from stickslip_sym.motion.thresholds.sensitivity import sensitivities

    nothing = np.zeros(len(scenes))
    by = sensitivities(scenes, rungs()[harmonic.name], nothing, nothing)
    budget = Budget.of(errors, {name: by.get(name, nothing) for name in errors.names}, (len(scenes),))
    with np.errstate(all="ignore"):
        relative = budget.uncertainty / np.abs(scenes.N * by["N"])
    return min(_PART * float(np.nan_to_num(relative, nan=0.0).min()), _LARGEST)

"""`Averaged`: a quantity by each law that may be meant, how likely it is above a value, and its intervals."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr, ndtri, stdtr, stdtrit

from stickslip_sym.core.aliases import FloatArray, Span
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import NEXT_TO_ZERO, ROOT_OF_ROUNDING
from stickslip_sym.core.probabilities import UNLIKELY, USUAL_PROBABILITY
from stickslip_sym.output.data import DataResult, TableResult, columns_of

_PROBABILITIES = (np.arange(400) + 0.5) / 400  # probabilities at which the narrower of two errors is averaged over
_BUILDS_UP = 0.03  # probability that friction builds up from 0 below the lowest measured speed, of each law
_SHARES = (np.arange(8) + 0.5) / 8  # of the part that hangs on it, which any share of may be missing


@dataclass(frozen=True)
class ByLaw(DataResult):
    """A quantity by one law: the law's name and weight, the value and its standard error.

    `of_point` is the part of the standard error that is none of the fit: of the operating point, normal.
    `unmeasured` is by how much the value is less if friction builds up from 0 to the lowest measured speed, where
    the law was not measured, and not as the law continues.
    """

    law: str
    weight: float
    value: float
    standard_error: float
    of_point: float = 0.0
    unmeasured: float = 0.0

    @property
    def of_fit(self) -> float:
        """The part of the standard error that the fit brings."""
        return float(np.sqrt(max(self.standard_error**2 - self.of_point**2, 0.0)))


@dataclass(frozen=True)
class Averaged(TableResult):
    """A quantity by each of several laws, and its average by their weights.

    Each law's value has a Student distribution, whose scale comes from one noise for all laws. With a probability
    of 3 % friction builds up from 0 below the lowest measured speed, and the value is less by a share, any from 0
    to 1, of what hangs on that.

    Attributes
    ----------
    rows : tuple of ByLaw
    refused : dict of str to str
        Laws that have no such quantity, each with the reason.
    value : float
        The sum of weights times values, of the laws that have one.
    standard_error : float
        The root of the sum of w_i (s_i^2 + (c_i - value)^2): of values and of the choice of law.
    speeds : int
        How many speeds were measured.
    dof : float
        Degrees of freedom of the noise; 0 where no law has fewer parameters than there are speeds.
    unknown : float
        The weight of the laws that have no such quantity, over that of all.
    lowest : float
        The lowest measured speed in m/s.

    References
    ----------
    K. P. Burnham and D. R. Anderson, Sociological Methods & Research 33 (2004) 261: unconditional variance.
    """

    rows: tuple[ByLaw, ...]
    refused: Mapping[str, str]
    value: float
    standard_error: float
    speeds: int = 0
    dof: float = 0.0
    unknown: float = 0.0
    lowest: float = 0.0

    @classmethod
    def of(
        cls,
        rows: Sequence[ByLaw],
        refused: Mapping[str, str],
        *,
        speeds: int,
        dof: float,
        unknown: float,
        lowest: float = 0.0,
    ) -> "Averaged":
        """Return the average of a quantity by some laws."""
        weights = np.array([row.weight for row in rows])
        values = np.array([row.value for row in rows])
        errors = np.array([row.standard_error for row in rows])
        mean = float(np.average(values, weights=weights))
        variance = float(np.average(errors**2 + (values - mean) ** 2, weights=weights))
        return cls(tuple(rows), refused, mean, float(np.sqrt(variance)), speeds, dof, unknown, lowest)

    @property
    def unmeasured(self) -> float:
        """By how much the average is less if friction builds up from 0 to the lowest measured speed."""
        return float(np.average([row.unmeasured for row in self.rows], weights=self._weights))

    def above(self, value: float, standard_error: float = 0.0) -> float:
        """Return the probability that the quantity is above a value, which may have a normal error of its own.

        Raises
        ------
        InputError
            If no law has fewer parameters than there are speeds, and nothing says how large the noise is.
        """
        return float(np.average(self.above_by_law(value, standard_error), weights=self._weights))

    def above_by_law(self, value: float, standard_error: float = 0.0) -> FloatArray:
        """Return this probability by each law, or raise the same error."""
        if self.dof <= 0:
            raise InputError(
                f"no law has fewer parameters than the {self.speeds} speeds that were measured, and the noise is "
                "not known; measure at more speeds, or give sigma"
            )
        return np.array([self._above_by(row, value, standard_error) for row in self.rows])

    def _above_by(self, row: ByLaw, value: float, standard_error: float) -> float:
        error = float(np.hypot(row.of_point, standard_error))

        def above(missing: float) -> float:
            return _probability_above(row.value - missing - value, row.of_fit, self.dof, error)

        if row.unmeasured <= 0:
            return above(0.0)
        built_up = float(np.mean([above(share * row.unmeasured) for share in _SHARES]))
        return (1 - _BUILDS_UP) * above(0.0) + _BUILDS_UP * built_up

    def _table_columns(self) -> dict[str, list[Any]]:
        return columns_of(self.rows, "law", "weight", "value", "standard_error")

    def interval(self, level: float = USUAL_PROBABILITY) -> Span:
        """Return the interval that holds the quantity with a probability, averaged over laws.

        If friction may build up from 0 where it was not measured, it reaches down to what it is then.
        """
        measured = replace(self, rows=tuple(replace(row, unmeasured=0.0) for row in self.rows))
        low, high = measured.range(1 - (1 - level) * UNLIKELY)  # far beyond the ends
        if not (np.isfinite([low, high]).all() and low < high):
            return low - self.unmeasured, high

        resolved = ROOT_OF_ROUNDING * (high - low)
        bracket = low - resolved, high + resolved  # values without an error are steps of the probability

        def end(share: float) -> float:
            return float(brentq(lambda value: measured.above(value) - share, *bracket, xtol=resolved))

        return end((1 + level) / 2) - self.unmeasured, end((1 - level) / 2)

    def range(self, level: float = USUAL_PROBABILITY) -> Span:
        """Return from where to where such intervals of all laws reach together, each by its law alone.

        If friction may build up from 0 where it was not measured, they reach down to what it is then.
        """
        share = (1 + level) / 2
        student = stdtrit(self.dof, share) if self.dof > 0 else np.inf
        ends = list[Span]()
        for row in self.rows:
            of_fit = student * row.of_fit if row.of_fit > 0 else 0.0
            half = float(np.hypot(of_fit, ndtri(share) * row.of_point))
            ends.append((row.value - max(row.unmeasured, 0.0) - half, row.value + half))
        return min(low for low, _ in ends), max(high for _, high in ends)

    @property
    def _weights(self) -> FloatArray:
        return np.array([row.weight for row in self.rows])


def _probability_above(distance: float, scale: float, dof: float, error: float) -> float:
    """Return the probability of distance + scale t + error z > 0, with t Student's and z normal.

    The narrower of the two is averaged over: degrees of freedom by Welch and Satterthwaite are too many where t
    has one or two.
    """
    if error <= 0:
        return float(stdtr(dof, distance / max(scale, NEXT_TO_ZERO)))
    if error < scale:
        return float(np.mean(stdtr(dof, (distance + error * ndtri(_PROBABILITIES)) / scale)))
    return float(np.mean(ndtr((distance + scale * stdtrit(dof, _PROBABILITIES)) / error)))

"""What is not known, as a value of its own.

- A function that may fail to find out returns `X | Unknown`. A type checker then refuses every use of the result
  as an X until the caller has decided: by `isinstance(x, Unknown)`, or by `required`, which raises.
- None says something else: it is known that there is none.
- Numbers for many rows at once are a `Column`: values with bounds, and for each row the reason why it has no
  value. What is claimed of rows is asked by `surely`, what is excluded by `perhaps`. Its values come out by
  `required`, or by `filled`, which names what stands for the unknown ones.
- Compiled kernels know no unions: they fill rows with values and a code, an `IntEnum`. `Column.of_codes`, beside
  the call of the kernel, translates it, and no code goes further.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NoReturn, ParamSpec, TypeVar

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray, Numbers, Rows
from stickslip_sym.core.errors import NO_RESULT, NotConverged
from stickslip_sym.core.remedies import Remedy

X = TypeVar("X")
Arguments = ParamSpec("Arguments")


class Unknown:
    """That something is not known, and why.

    Attributes
    ----------
    reason : tuple of str or Remedy
        Parts of a message, as those of the errors of the package.
    """

    __slots__ = ("reason",)

    def __init__(self, *reason: str | Remedy) -> None:
        self.reason = reason

    def __bool__(self) -> NoReturn:
        raise TypeError(f"it is not known whether this holds: {self}")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Unknown):
            raise TypeError(f"what is not known equals nothing: {self}")
        return self.reason == other.reason

    def __hash__(self) -> int:
        return hash(self.reason)

    def __str__(self) -> str:
        return "".join(map(str, self.reason))

    def __repr__(self) -> str:
        return f"Unknown({str(self)!r})"


def required(value: X | Unknown) -> X:
    """Return what is known, or raise `NotConverged` with the reason why it is not."""
    if isinstance(value, Unknown):
        raise NotConverged(*value.reason)
    return value


def attempted(
    function: Callable[Arguments, X | Unknown], *args: Arguments.args, **kwargs: Arguments.kwargs
) -> X | Unknown:
    """Return what a function returns, or why it has no result; the end of a time limit goes on upwards."""
    try:
        return function(*args, **kwargs)
    except NO_RESULT as error:
        return Unknown(*error.args)


@dataclass(frozen=True, eq=False)
class Column:
    """Numbers, each between two bounds, or not known.

    Attributes
    ----------
    low, high : numpy.ndarray
        Bounds of each number; those of a number that is not known may be finite too.
    codes : numpy.ndarray of int
        0 for a number that is known, else the place in `reasons` plus 1.
    reasons : tuple of Unknown
    """

    _values: FloatArray
    low: FloatArray
    high: FloatArray
    codes: IntArray
    reasons: tuple[Unknown, ...]

    @classmethod
    def of(
        cls,
        values: FloatArray,
        errors: Numbers,
        why: Unknown,
        *,
        low: Numbers = -np.inf,
        high: Numbers = np.inf,
    ) -> "Column":
        """Take numbers and their errors.

        - `why`: the reason of those that are NaN.
        - `low`, `high`: what bounds those all the same.
        """
        known = ~np.isnan(values)
        least = np.where(known, values - errors, low)
        most = np.where(known, values + errors, high)
        return cls(values, least, most, np.where(known, 0, 1), (why,))

    @classmethod
    def of_codes(
        cls, values: FloatArray, errors: FloatArray, codes: FloatArray, meanings: Mapping[int, Unknown]
    ) -> "Column":
        """Take what a kernel returned: a number is known unless its code has a meaning."""
        reasons = np.zeros(values.shape, dtype=np.intp)
        for place, code in enumerate(meanings):
            reasons[codes == code] = place + 1
        unknown = reasons > 0
        return cls(
            np.where(unknown, np.nan, values),
            np.where(unknown, -np.inf, values - errors),
            np.where(unknown, np.inf, values + errors),
            reasons,
            tuple(meanings.values()),
        )

    def __len__(self) -> int:
        return self.codes.size

    def __getitem__(self, rows: Rows) -> "Column":
        return Column(self._values[rows], self.low[rows], self.high[rows], self.codes[rows], self.reasons)

    @property
    def known(self) -> BoolArray:
        """Which numbers are known."""
        return np.asarray(self.codes == 0)

    @property
    def errors(self) -> FloatArray:
        """Half of what lies between the bounds; 0 for a number that is infinite."""
        finite = np.isfinite(self._values) | ~self.known
        return np.asarray(np.subtract(self.high, self.low, out=np.zeros(len(self)), where=finite) / 2)

    def replaced(self, rows: BoolArray, others: "Column") -> "Column":
        """Return the same with other numbers in some rows."""
        values = self._values.copy()
        low = self.low.copy()
        high = self.high.copy()
        codes = self.codes.copy()
        values[rows], low[rows], high[rows] = others._values, others.low, others.high
        codes[rows] = np.where(others.known, 0, others.codes + len(self.reasons))
        return Column(values, low, high, codes, (*self.reasons, *others.reasons))

    def at(self, row: int) -> float | Unknown:
        """Return one number."""
        code = int(self.codes[row])
        if code:
            return self.reasons[code - 1]
        return float(self._values[row])

    def required(self) -> FloatArray:
        """Return all numbers, or raise `NotConverged` with the reason of the first that is not known."""
        for row in np.flatnonzero(self.codes)[:1]:
            required(self.at(row))
        return self._values

    def filled(self, stand_in: float) -> FloatArray:
        """Return all numbers, with a stand-in for those that are not known: NaN for tables, files and pictures."""
        return np.where(self.known, self._values, stand_in)

    def surely(self, *, above: float = -np.inf, below: float = np.inf) -> BoolArray:
        """Whether the bounds show that a number lies between two levels: of what is claimed."""
        return np.asarray((self.low > above) & (self.high < below))

    def perhaps(self, *, above: float = -np.inf, below: float = np.inf) -> BoolArray:
        """Whether the bounds leave it open that a number lies between two levels: of what is excluded."""
        return np.asarray((self.high > above) & (self.low < below))

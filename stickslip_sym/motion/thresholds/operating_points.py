"""`OperatingPoints`: where thresholds are asked for, as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray, Rational, Rows
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import exact, fraction, read_array
from stickslip_sym.core.uncertain import UFloat, split
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator

__all__ = ["OperatingPoints", "Quantity"]

Quantity: TypeAlias = ArrayLike | UFloat | Sequence[UFloat]
"""One number or an array of them, as users give it; each may carry a standard error."""


@dataclass(frozen=True)
class OperatingPoints:
    """Operating points of one law: flat arrays of one length; m and k are None where they were not given.

    Attributes
    ----------
    law : FrictionLaw
    V, N : numpy.ndarray, shape (n,)
        In m/s and N.
    m, k : numpy.ndarray, shape (n,), or None
        In kg and N/m.
    shape : tuple of int
        That the broadcast arguments had.
    exact : mapping of str to Fraction
        What was given as text, exactly.
    uncertain : mapping of str
        What carries a standard error, with it: one number for all points, or an array with one for each.
    """

    law: FrictionLaw
    V: FloatArray
    N: FloatArray
    m: Any
    k: Any
    shape: tuple[int, ...]
    exact: Mapping[str, Fraction] = field(default_factory=dict)
    uncertain: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls, law: FrictionLaw, osc: Oscillator | None = None, /, **values: Quantity | None
    ) -> "OperatingPoints":
        """Broadcast V, N, m and k, or take those of an oscillator.

        Raises
        ------
        InputError
            For numbers that are missing, not finite or of the wrong sign, shapes that do not broadcast, only one
            of m and k, or an oscillator together with numbers.
        """
        numbers = {name: value for name, value in values.items() if value is not None}
        if osc is not None:
            numbers = _of_oscillator(osc, numbers)
        for name in ("V", "N"):
            if name not in numbers:
                raise InputError(
                    f"the {symbols.QUANTITIES[name].meaning} is missing: give {name}=..., or an Oscillator"
                )
        if ("m" in numbers) != ("k" in numbers):
            raise InputError("give both the mass m and the stiffness k, or neither")
        pairs = {name: _split(value, name) for name, value in numbers.items()}
        errors = {name: read for name, (_, read) in pairs.items() if read is not None}
        exactly = {name: fraction(value, name) for name, (value, _) in pairs.items() if isinstance(value, str)}
        columns = {
            name: _column(name, float(exactly[name]) if name in exactly else value)
            for name, (value, _) in pairs.items()
        }
        try:
            whole = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in columns.items())
            raise InputError(f"the shapes do not broadcast: {shapes}") from None
        flat = {name: column.ravel() for name, column in whole.items()}
        shape = whole["V"].shape
        uncertain = {
            name: read if isinstance(read, UFloat) else np.broadcast_to(read, shape).ravel()
            for name, read in errors.items()
        }
        return cls(law, flat["V"], flat["N"], flat.get("m"), flat.get("k"), shape, exactly, uncertain)

    def __len__(self) -> int:
        return len(self.V)

    @property
    def columns(self) -> dict[str, FloatArray]:
        """The quantities that were given, by name."""
        columns = {"V": self.V, "N": self.N, "m": self.m, "k": self.k}
        return {name: column for name, column in columns.items() if column is not None}

    def rows(self, chosen: Rows) -> "OperatingPoints":
        """Return some of the points."""
        m, k = (None if column is None else column[chosen] for column in (self.m, self.k))
        uncertain = {
            name: read if isinstance(read, UFloat) else read[chosen] for name, read in self.uncertain.items()
        }
        V = self.V[chosen]
        return OperatingPoints(self.law, V, self.N[chosen], m, k, V.shape, self.exact, uncertain)

    def exact_row(self, row: int) -> dict[str, Rational]:
        """Return V, N, m and k of one point exactly: text as the decimal it says, a float as the binary it is."""
        return {name: exact(self.exact.get(name, column[row]), name) for name, column in self.columns.items()}

    def oscillator(self, row: int, c: float = 0.0) -> Oscillator:
        """Return one point as an oscillator; it needs m and k."""
        return Oscillator(c=c, **{name: column[row] for name, column in self.columns.items()})

    def shifted(self, by: Mapping[str, float]) -> "OperatingPoints":
        """Return the points with some quantities and parameters of the law shifted.

        Raises
        ------
        InputError
            If one leaves where it may be.
        """
        law = self.law
        parameters = {name: float(law.values[name]) + by[name] for name in law.parameters if name in by}
        moved = {name: column + by.get(name, 0.0) for name, column in self.columns.items()}
        return OperatingPoints.of(law.bind(**parameters) if parameters else law, **moved)

    @property
    def impedance(self) -> FloatArray:
        """The unit of damping, sqrt(k m) in kg/s."""
        found: FloatArray = np.sqrt(self.k) * np.sqrt(self.m)
        return found

    def label(self, row: int) -> str:
        """Say which point it is."""
        return ", ".join(f"{name} = {column[row]:g}" for name, column in self.columns.items())


def _of_oscillator(osc: Oscillator, numbers: Mapping[str, Quantity]) -> dict[str, Quantity]:
    if not isinstance(osc, Oscillator):
        raise InputError(
            f"got {osc!r} where an Oscillator is expected; write (law, Oscillator(...)), or give V=, N=, m= and k="
        )
    if numbers:
        raise InputError(f"{', '.join(numbers)} was given beside an Oscillator, which holds it; give one of both")
    return {name: getattr(osc, name) for name in ("V", "N", "m", "k")}


def _split(value: Quantity | None, name: str) -> tuple[Any, Any]:
    """Separate numbers from their standard errors, one by one in an array that has any."""
    array = np.asarray(value, dtype=object) if isinstance(value, list | tuple | np.ndarray) else None
    if array is None or not any(isinstance(item, UFloat) for item in array.flat):
        return split(value, name)
    pairs = [split(item, name) for item in array.flat]
    numbers = np.array([float(number) for number, _ in pairs]).reshape(array.shape)
    errors = np.empty(array.size, dtype=object)
    errors[:] = [float(number) if read is None else read for number, read in pairs]
    return numbers, errors.reshape(array.shape)


def _column(name: str, value: ArrayLike) -> FloatArray:
    if np.ma.is_masked(value):
        raise InputError(f"{name} has masked entries; drop them, or fill them with a number")
    array: FloatArray = read_array(name, value).astype(np.float64, copy=False)
    lowest = array.min(initial=np.inf)
    if lowest < 0 or (lowest == 0 and name != "N"):
        required = "not be negative" if name == "N" else "be positive"
        raise InputError(f"{name} = {lowest:g} must {required}: it is the {symbols.QUANTITIES[name].meaning}")
    return array

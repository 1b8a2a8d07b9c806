"""`Scenes`: where thresholds are asked for, by arrays."""

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

__all__ = ["Quantity", "Scenes"]

Quantity: TypeAlias = ArrayLike | UFloat | Sequence[UFloat]
"""One number or an array of them, as users give it; each may carry a standard error."""


@dataclass(frozen=True)
class Scenes:
    """Scenes of one law, flat arrays of one length; m and k are None where they were not given.

    What was given as text is kept, exactly, in `exact`. What carries a standard error is kept with it in
    `uncertain`: one number that all scenes have, or an array with one a scene.
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
    def of(cls, law: FrictionLaw, **values: Quantity | None) -> "Scenes":
        """Broadcast V, N, m and k.

        Raises `InputError` for numbers that are not finite or have the wrong sign, shapes that do not broadcast,
          or only one of m and k.
        """
        pairs = {name: _split(value, name) for name, value in values.items()}
        plain = {name: number for name, (number, _) in pairs.items()}
        errors = {name: read for name, (_, read) in pairs.items() if read is not None}
        exactly = {name: fraction(value, name) for name, value in plain.items() if isinstance(value, str)}
        numbers = plain | {name: float(value) for name, value in exactly.items()}
        given = {name: _column(name, value) for name, value in numbers.items() if value is not None}
        if ("m" in given) != ("k" in given):
            raise InputError("give both the mass m and the stiffness k, or neither")
        try:
            columns = dict(zip(given, np.broadcast_arrays(*given.values()), strict=True))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in given.items())
            raise InputError(f"the shapes do not broadcast: {shapes}") from None
        flat = {name: column.ravel() for name, column in columns.items()}
        shape = columns["V"].shape
        uncertain = {
            name: read if isinstance(read, UFloat) else np.broadcast_to(read, shape).ravel()
            for name, read in errors.items()
        }
        return cls(law, flat["V"], flat["N"], flat.get("m"), flat.get("k"), shape, exactly, uncertain)

    def __len__(self) -> int:
        return len(self.V)

    def rows(self, chosen: Rows) -> "Scenes":
        """Return some of the scenes."""
        m, k = (None if column is None else column[chosen] for column in (self.m, self.k))
        uncertain = {
            name: read if isinstance(read, UFloat) else read[chosen] for name, read in self.uncertain.items()
        }
        return Scenes(self.law, self.V[chosen], self.N[chosen], m, k, self.V[chosen].shape, self.exact, uncertain)

    def exact_row(self, row: int) -> dict[str, Rational]:
        """Return V, N, m and k of one scene exactly: text as the decimal it says, a float as the binary it is."""
        columns = {"V": self.V, "N": self.N, "m": self.m, "k": self.k}
        return {name: exact(self.exact.get(name, column[row]), name) for name, column in columns.items()}

    @property
    def impedance(self) -> FloatArray:
        """The unit of damping, sqrt(k m) in kg/s."""
        found: FloatArray = np.sqrt(self.k) * np.sqrt(self.m)
        return found

    def label(self, row: int) -> str:
        """Say which scene it is."""
        columns = (("V", self.V), ("N", self.N), ("m", self.m), ("k", self.k))
        return ", ".join(f"{name} = {column[row]:g}" for name, column in columns if column is not None)


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

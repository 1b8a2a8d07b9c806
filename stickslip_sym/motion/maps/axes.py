"""The axes of a map: quantities of the oscillator or parameters of its law, with their values and units."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import read_array, real, suggestion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator

__all__ = [
    "OSCILLATOR", "Axis", "AxisValues", "fixed_values", "read_axes", "read_axis", "read_values", "require_few",
]  # fmt: skip

AxisValues = tuple[str, ArrayLike]
"""The name of an axis, and its values."""
OSCILLATOR = ("V", "N", "m", "k", "c")
_MOST_CELLS = 1_000_000  # of a map; more are taken for a mistake


@dataclass(frozen=True)
class Axis:
    """An axis of a map."""

    name: str  # as in formulas
    values: FloatArray  # ascending
    unit: str  # SI, "1" for a pure number, and empty where it is not known
    meaning: str

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        return f"{self.name} = {self.values[0]:g} to {self.values[-1]:g}{unit}"

    @property
    def label(self) -> str:
        """The meaning, the symbol and the unit."""
        unit = f" ({self.unit})" if self.unit not in ("", "1") else ""
        return f"{self.meaning or 'parameter'} {self.name}{unit}"


def read_values(name: str, values: ArrayLike) -> FloatArray:
    """Return the values of an axis as an array.

    Raises `InputError` if they are not finite numbers in ascending order.
    """
    array = np.array(read_array(name, values), dtype=np.float64)
    if array.ndim != 1 or not array.size:
        raise InputError(f"the values of {name} are one row of numbers, got an array of shape {array.shape}")
    if not (np.diff(array) > 0).all():
        raise InputError(f"the values of {name} do not ascend; sort them, and give each once")
    return array


def read_axes(law: FrictionLaw, x: AxisValues, y: AxisValues) -> tuple[Axis, Axis]:
    """Return the two axes of a map.

    Raises `InputError` for an unknown name, the same one twice, unusable values, or too many cells.
    """
    axes = read_axis(law, "x", x), read_axis(law, "y", y)
    if axes[0].name == axes[1].name:
        raise InputError(f"both axes are {axes[0].name}; take another quantity for one of them")
    require_few(*(axis.values.size for axis in axes))
    return axes


def require_few(columns: int, rows: int) -> None:
    """Refuse a map of more than a million cells."""
    if columns * rows > _MOST_CELLS:
        raise InputError(f"{columns} x {rows} cells are more than {_MOST_CELLS}; take fewer values on an axis")


def read_axis(law: FrictionLaw, side: str, given: AxisValues) -> Axis:
    """Return an axis given as a name and its values; `side` is how an error calls it.

    Raises `InputError` for an unknown name, or unusable values.
    """
    if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != 2 or not isinstance(given[0], str):
        raise InputError(
            f'{side} is a name and its values, such as {side}=("V", [0.1, 0.2]), got {str(given)[:60]}'
        )
    name, values = given
    known = [*OSCILLATOR, *law.parameters]
    if name not in known:
        raise InputError(
            f"no axis can be {name[:60]!r}{suggestion(name, known)}; this law's map has: {', '.join(known)}"
        )
    array = read_values(name, values)
    if name in OSCILLATOR:
        quantity = symbols.QUANTITIES[name]
        return Axis(name, array, quantity.unit, quantity.meaning)
    parameter = law.parameters[name]
    return Axis(name, array, parameter.unit or "", parameter.meaning)


def fixed_values(
    law: FrictionLaw, axes: tuple[Axis, ...], given: Mapping[str, float | None]
) -> tuple[FrictionLaw, dict[str, float]]:
    """Return the law with a value for each parameter, and the quantities that are no axis.

    Raises `InputError` for a quantity that is missing, given twice, or has the wrong sign anywhere on the map.
    """
    on_axis = {axis.name: axis for axis in axes}
    values = {}
    for name in OSCILLATOR:
        value = given.get(name)
        if name in on_axis:
            if value is not None:
                raise InputError(f"{name} is an axis, and given as {value} too; leave one of the two out")
        elif value is None:
            meaning = symbols.QUANTITIES[name].meaning
            raise InputError(f"{name} is missing: give the {meaning}, or make it an axis")
        else:
            values[name] = real(name, value)
    for end in (0, -1):
        corner = {name: float(axis.values[end]) for name, axis in on_axis.items()}
        law = law.bind(**{name: value for name, value in corner.items() if name not in OSCILLATOR})
        point = values | corner
        Oscillator(**{name: point[name] for name in OSCILLATOR})
    if law.missing:
        names = ", ".join(law.missing)
        raise InputError(f"the law has no value for {names}; bind them first, or make one an axis")
    return law, values

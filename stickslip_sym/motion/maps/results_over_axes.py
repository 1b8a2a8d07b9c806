"""`ResultsOverAxes`: results over one axis or two, as text, in notebooks, files and pictures; and its axes."""

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.names import suggestion
from stickslip_sym.core.numbers import read_array, real
from stickslip_sym.core.remedies import ParameterValues
from stickslip_sym.core.units import si_number
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.law_content import text_of_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.output import files
from stickslip_sym.output.data import TableResult
from stickslip_sym.output.shown import Drawn, views_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

AxisValues = tuple[str, ArrayLike]
"""The name of an axis, and its values."""
OSCILLATOR = ("V", "N", "m", "k", "c")
MOST_CELLS = 1_000_000  # of a map; more are taken for a mistake


@dataclass(frozen=True)
class Axis:
    """An axis of a map."""

    reported = ("name", "unit", "values")

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


@dataclass(frozen=True, repr=False)
class ResultsOverAxes(Drawn, TableResult):
    """Results over one axis or two; a kind of results says what its columns are.

    Attributes
    ----------
    axes : tuple of Axis
        Each with `name`, `values`, `unit` and `meaning`; the first is horizontal in pictures, and arrays have a
        row for each value of the second.
    law : FrictionLaw
    fixed : dict of str to float
        The quantities that are no axis, in SI units.
    """

    axes: tuple[Axis, ...]
    law: FrictionLaw
    fixed: dict[str, float]

    @property
    def x(self) -> Axis:
        """The horizontal axis."""
        return self.axes[0]

    @property
    def y(self) -> Axis:
        """The vertical axis of two."""
        return self.axes[1]

    @property
    @abstractmethod
    def columns(self) -> "dict[str, NDArray[np.generic]]":
        """The results by their names in files; they broadcast with the cells."""

    def __repr__(self) -> str:
        return views_of(self).one_line(self)

    def _table_columns(self) -> "dict[str, NDArray[np.generic]]":
        """Return a row for each cell: its place on the axes, and every column."""
        grid = np.meshgrid(*(axis.values for axis in self.axes))
        places = {axis.name: values for axis, values in zip(self.axes, grid, strict=True)}
        cells = {name: np.broadcast_to(column, grid[0].shape) for name, column in self.columns.items()}
        return {name: np.ravel(column) for name, column in {**places, **cells}.items()}

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each cell: its place on the axes, and every column.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        columns = self._table_columns()
        for name, column in columns.items():
            if column.dtype == bool:
                columns[name] = column.astype(int)
        files.write_csv(Path(path), columns)

    def to_npz(self, path: str | Path) -> None:
        """Write plain arrays, which ``numpy.load`` reads with ``allow_pickle=False``.

        They are the columns; the axes as "x" with "x_name" and "x_unit", and likewise "y"; the quantities that are
        no axis as "fixed_N" and so on; and the law as text.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        arrays = self.columns | {f"fixed_{name}": np.array(value) for name, value in self.fixed.items()}
        for side, axis in zip("xy", self.axes, strict=False):
            arrays |= {side: axis.values, f"{side}_name": np.array(axis.name), f"{side}_unit": np.array(axis.unit)}
        files.write_npz(Path(path), arrays | {"law": np.array(text_of_law(self.law))})


# -- what is given -----------------------------------------------------------------------------------


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


def require_few(columns: int, rows: int) -> None:
    """Refuse a map of more than a million cells."""
    if columns * rows > MOST_CELLS:
        raise InputError(f"{columns} x {rows} cells are more than {MOST_CELLS}; take fewer values on an axis")


def read_axis(law: FrictionLaw, side: str, given: AxisValues) -> Axis:
    """Return an axis given as a name and its values; `side` is how an error calls it.

    Raises `InputError` for an unknown name, or unusable values.
    """
    if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != 2 or not isinstance(given[0], str):
        raise InputError(
            f'{side} is a name and its values, such as {side}=("V", [0.1, 0.2]), got {str(given)[:60]}'
        )
    name, values = given
    quantities = {name: symbols.QUANTITIES[name] for name in OSCILLATOR} | dict(law.parameters)
    if name not in quantities:
        raise InputError(
            f"no axis can be {name[:60]!r}{suggestion(name, list(quantities))}; this law's map has: "
            f"{', '.join(quantities)}"
        )
    quantity = quantities[name]
    if isinstance(values, list | tuple) and any(isinstance(value, str) for value in values):
        values = [real(name, si_number(value, name, quantity.unit or "")) for value in values]
    return Axis(name, read_values(name, values), quantity.unit or "", quantity.meaning)


def read_plane(
    law: FrictionLaw, x: AxisValues, y: AxisValues, given: Mapping[str, float | None]
) -> tuple[tuple[Axis, Axis], FrictionLaw, dict[str, float]]:
    """Return the axes of a map, the law with a value for each parameter, and the quantities that are no axis.

    Raises `InputError` for an unknown name, the same one twice, unusable values, too many cells, or a quantity
    that is missing, given twice, or has the wrong sign anywhere on the map.
    """
    axes = read_axis(law, "x", x), read_axis(law, "y", y)
    names = [axis.name for axis in axes]
    if names[0] == names[1]:
        raise InputError(f"both axes are {names[0]}; take another quantity for one of them")
    require_few(*(axis.values.size for axis in axes))
    values = {}
    for name, value in given.items():
        if name in names and value is not None:
            raise InputError(f"{name} is an axis, and given as {value} too; leave one of the two out")
        if name not in names and value is None:
            meaning = symbols.QUANTITIES[name].meaning
            raise InputError(f"{name} is missing: give the {meaning}, or make it an axis")
        if value is not None:
            values[name] = real(name, value)
    for end in (0, -1):
        law, _ = placed(law, values | {axis.name: float(axis.values[end]) for axis in axes})
    if law.missing:
        raise InputError(
            f"the law has no value for {', '.join(law.missing)}; make one an axis, or give it first: ",
            ParameterValues.of(*law.missing),
        )
    return axes, law, values


def placed(law: FrictionLaw, values: Mapping[str, float]) -> tuple[FrictionLaw, Oscillator]:
    """Return the law and the oscillator with values of V, N, m, k and c, and of parameters, in their places."""
    law = law.bind(**{name: value for name, value in values.items() if name not in OSCILLATOR})
    return law, Oscillator(**{name: values[name] for name in OSCILLATOR})

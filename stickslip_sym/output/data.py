"""Results in other people's programs: dictionaries, and tables of pandas."""

from abc import abstractmethod
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.aliases import Json
from stickslip_sym.core.equality import say_the_same
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Call
from stickslip_sym.output.content import content

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class DataResult:
    """A result that is handed over as a dictionary, and equal to another of its class that says the same.

    A class that is made ``by_identity`` holds functions: each of its results is equal to itself alone.
    """

    def __init_subclass__(cls, by_identity: bool = False, **options: Any) -> None:
        super().__init_subclass__(**options)
        if by_identity:
            cls.__eq__ = object.__eq__  # type: ignore[method-assign]
        elif cls.__eq__ in (object.__eq__, say_the_same):
            cls.__eq__ = say_the_same  # type: ignore[method-assign]  # which a dataclass keeps

    def to_dict(self) -> Json:
        """Return what the result says, as ``--json`` prints it.

        Returns
        -------
        dict
            Of dictionaries, lists, text, numbers in SI units, bools and None, which ``json.dumps`` takes: None
            stands for a number that is not known, formulas are text, and enumerations their values.
        """
        said = content(self)
        assert isinstance(said, dict)
        return said


class TableResult(DataResult):
    """A result that is a table too."""

    @abstractmethod
    def _table_columns(self) -> "Mapping[str, ArrayLike]":
        """Return the columns by name, all of one length, in the order in which they are read."""

    def to_pandas(self) -> Any:
        """Return the table as a ``pandas.DataFrame``, in SI units.

        Returns
        -------
        pandas.DataFrame
            One row for each line of the table, with NaN or None where a number is not known.

        Raises
        ------
        InputError
            If pandas is not installed: this package needs it for nothing else.
        """
        try:
            from pandas import DataFrame
        except ImportError:
            instead = Call("to_dict()", "--json")
            raise InputError("pandas is not installed: pip install pandas; or take ", instead) from None
        return DataFrame(self._table_columns())


def columns_of(rows: Iterable[object], *names: str) -> dict[str, list[Any]]:
    """Return attributes of rows, as `content` makes them, by their names."""
    listed = list(rows)
    return {name: [content(getattr(row, name)) for row in listed] for name in names}

"""`Report`: a result that says what it says in sentences and tables, as text and in notebooks."""

from abc import abstractmethod

from stickslip_sym.output import markup
from stickslip_sym.output.tables import table

Rows = tuple[list[str], list[list[str]]]
"""A table: its header and its rows."""


class Report:
    """A result that shows what it says as text and as HTML."""

    @abstractmethod
    def _parts(self) -> list[str | Rows]:
        """Return sentences, and tables as a header and rows, in the order in which they are shown."""

    def __str__(self) -> str:
        return "\n\n".join(part if isinstance(part, str) else table(*part) for part in self._parts())

    def _repr_html_(self) -> str:
        return markup.block(*(part if isinstance(part, str) else markup.table(*part) for part in self._parts()))

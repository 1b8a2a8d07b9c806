"""The door to `stickslip_sym.views`, where what results show is made.

`views` stands above every kind of result, and imports them. Nothing below imports it: a method that shows a result
asks for its views here when it is called, by name.
"""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

if TYPE_CHECKING:
    from matplotlib.artist import Artist as Artist
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure

HeadedRows = tuple[list[str], list[list[str]]]
"""A table: its header and its rows."""


class Views(Protocol):
    """What can be shown of a result; `stickslip_sym.views.dispatch` has these functions, for each class."""

    def one_line(self, result: object) -> str:
        """Return a result in a line, for a terminal."""

    def plain_text(self, result: object) -> str:
        """Return a result as sentences and tables."""

    def notebook_html(self, result: object) -> str:
        """Return a result as HTML, for a notebook."""

    def notebook_latex(self, result: object) -> str:
        """Return a result as LaTeX, for a notebook."""

    def draw(self, result: object, ax: "Axes", *given: Any, **how: Any) -> "Sequence[Artist]":
        """Draw a result as a panel, and return the handles of its legend."""

    def plot(self, result: object, path: str | Path | None, ax: "Axes | None", **how: Any) -> "Figure":
        """Draw a result, and write the drawing to a file."""

    def page(self, result: object) -> str:
        """Return the page of a result: HTML that stands alone."""

    def print_page(self, result: object, path: Path) -> None:
        """Print the page of a result to a PDF file."""


def views_of(result: object) -> Views:
    """Return the views of a result."""
    dispatch = import_module("stickslip_sym.views.dispatch")
    dispatch.load_views(type(result))
    return cast("Views", dispatch)


class Shown:
    """A result that notebooks show."""

    def _repr_html_(self) -> str:
        return views_of(self).notebook_html(self)


class Report(Shown):
    """A result that says what it says in sentences and tables."""

    def __str__(self) -> str:
        return views_of(self).plain_text(self)


class Drawn(Shown):
    """A result that has a picture: one panel, or a figure of several."""

    def draw(self, ax: "Axes") -> "Sequence[Artist]":
        """Draw it as a panel, and return the handles of its legend."""
        return views_of(self).draw(self, ax)

    def plot(self, path: str | Path | None = None, *, ax: "Axes | None" = None) -> "Figure":
        """Draw it: regions or basins in colours and hatching, curves between them, orbits, or costs.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to: SVG, PNG or PDF, by its ending.
        ax : matplotlib.axes.Axes, optional
            Axes of a figure of your own to draw a panel in, with the legend inside them.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If matplotlib is not installed, or cannot write the file.
        """
        return views_of(self).plot(self, path, ax)

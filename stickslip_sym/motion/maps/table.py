"""`Table`: results over one axis or two, as text, in notebooks, in files and in pictures."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.core.aliases import ObjectArray
from stickslip_sym.model.content import text_of_law
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.maps.axes import Axis
from stickslip_sym.motion.maps.drawing import new_figure, title, with_legend
from stickslip_sym.motion.motion import Motion
from stickslip_sym.output import drawing, files, markup

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

__all__ = ["Table", "count_of"]


@dataclass(frozen=True, repr=False)
class Table(drawing.Drawn):
    """Results over one axis or two; a kind of results says what its columns, words and drawing are.

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

    @abstractmethod
    def _summary(self) -> str:
        """Return the results in a line."""

    @abstractmethod
    def _rows(self) -> tuple[Sequence[str], list[list[str]]]:
        """Return the header and the rows of a short table."""

    @abstractmethod
    def _draw(self, ax: "Axes") -> "list[Artist]":
        """Draw the results, and return the handles of the legend."""

    @property
    def _place(self) -> str:
        return f"{self.law.name or 'law'}, {' by '.join(map(str, self.axes))}"

    def __repr__(self) -> str:
        return f"{type(self).__name__}: {self._place}; {self._summary()}"

    def _repr_html_(self) -> str:
        header, rows = self._rows()
        picture = drawing.picture(self.plot, self._place)
        return markup.block(picture, markup.table(header, rows, caption=self._place), self._summary())

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each cell: its place on the axes, and every column.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        grid = np.meshgrid(*(axis.values for axis in self.axes))
        places = {axis.name: values for axis, values in zip(self.axes, grid, strict=True)}
        columns = {name: np.broadcast_to(column, grid[0].shape) for name, column in self.columns.items()}
        numbers = {
            name: column.astype(int) if column.dtype == bool else column for name, column in columns.items()
        }
        files.write_csv(Path(path), places | numbers)

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

    def plot(self, path: str | Path | None = None, *, ax: "Axes | None" = None) -> "Figure":
        """Draw regions by colour and hatching, curves between them, and a legend.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to, as for `Drawn.plot`; so is what is raised.
        ax : matplotlib.axes.Axes, optional
            Axes of a figure of your own to draw in, with the legend inside them.

        Returns
        -------
        matplotlib.figure.Figure
        """
        if ax is None:
            return super().plot(path)
        ax.legend(handles=self._draw(ax), fontsize=8)
        figure: Figure = ax.figure  # type: ignore[assignment]  # of a subfigure, that
        if path is not None:
            drawing.save(figure, Path(path))
        return figure

    def _figure(self) -> "Figure":
        figure, ax = new_figure()
        handles = self._draw(ax)
        title(ax, self.law, self.fixed)
        return with_legend(figure, handles)


def count_of(motion: ObjectArray) -> dict[Motion, int]:
    """Return the number of cells of each motion, where there are any."""
    return {one: n for one in Motion if (n := int((motion == one).sum()))}

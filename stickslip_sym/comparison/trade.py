"""Time and error of the methods for one number: which dominate which, as text and as a picture."""

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from stickslip_sym.output import drawing, markup
from stickslip_sym.output.tables import duration, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_WIDTH, _HEIGHT = 7.2, 3.5  # inches, of a panel of the picture
_SMALLEST = 1e-51  # error of a method whose own is less
_TITLE = 95  # characters of a line above a panel
_MARKERS = "os^Dv<>"
_COLORS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:olive", "tab:cyan")
_TITLES = {"largest": "largest error up to V = 1 m/s"}  # of what else is known, where its name says too little


@dataclass(frozen=True)
class Row:
    """One method at one tolerance, measured.

    Attributes
    ----------
    method : str
    setting : str
        Its tolerance, number of nodes, digits or initial conditions; empty where there is nothing to set.
    seconds : float
        Time of the processor, to one number; NaN where the method gives none.
    error : float
        Relative; NaN where the method gives no number.
    further : mapping
        What else is known: of a threshold its status and largest error over belt speeds, of a share its value
        and standard error.
    """

    method: str
    setting: str = ""
    seconds: float = math.nan
    error: float = math.nan
    further: Mapping[str, float | str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The method, and after a comma its setting."""
        return ", ".join(filter(None, (self.method, self.setting)))

    @property
    def found(self) -> bool:
        """Whether the method gives a number."""
        return not math.isnan(self.seconds)


@dataclass(frozen=True)
class Trade:
    """The methods for one number, measured at one operating point.

    Attributes
    ----------
    number : str
        What kind of number: "value" of a criterion, "threshold" or "share" of a basin.
    title : str
        Which number it is, and at which operating point.
    rows : tuple of Row
    point : mapping
        Name to number, in SI units.
    box : mapping
        From and to, of the initial displacements x0 and velocities v0.
    """

    number: str
    title: str
    rows: tuple[Row, ...]
    point: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def dominators(self) -> dict[str, tuple[str, ...]]:
        """For each method which ones dominate it: at least as fast and as accurate, and better in one of the two.

        Named are those that are not dominated themselves: they suffice, as one of them dominates what any does.
        """
        costs = {row.name: (row.seconds, row.error) for row in self.rows}
        by = {
            name: [other for other, cost in costs.items() if cost != mine and np.less_equal(cost, mine).all()]
            for name, mine in costs.items()
        }
        return {name: tuple(other for other in others if not by[other]) for name, others in by.items()}

    @property
    def _table(self) -> tuple[list[str], list[list[str]]]:
        """The header and the cells of a table, as text."""
        columns = list(dict.fromkeys(key for row in self.rows for key in row.further))

        def further(row: Row, key: str) -> str:
            value = row.further.get(key, "")
            if isinstance(value, str):
                return value
            return "not measured" if math.isnan(value) else f"{value:.11g}" if key == "share" else f"{value:.2g}"

        cells = []
        for row, by in zip(self.rows, self.dominators.values(), strict=True):
            measured = [duration(row.seconds), f"{row.error:.1e}"] if row.found else ["no number", ""]
            cells.append([row.name, *measured, *(further(row, key) for key in columns), "; ".join(by)])
        titles = [_TITLES.get(key, key) for key in columns]
        return ["method", f"time a {self.number}", "relative error", *titles, "dominated by"], cells

    def __str__(self) -> str:
        return f"{self.title}\n\n{table(*self._table)}"

    def _repr_html_(self) -> str:
        return markup.table(*self._table, caption=self.title)

    def draw(self, ax: "Axes") -> None:
        """Draw error against time: filled what no other method dominates, and hollow what one does.

        A method has a colour, and its settings have different markers.
        """
        by, front = self.dominators, list[tuple[float, float]]()
        methods = list(dict.fromkeys(row.method for row in self.rows))
        settings = Counter[str]()
        for row in (row for row in self.rows if row.found):
            color = _COLORS[methods.index(row.method) % len(_COLORS)]
            marker = _MARKERS[settings[row.method] % len(_MARKERS)]
            settings[row.method] += 1
            at = row.seconds, max(row.error, _SMALLEST)
            face = "white" if by[row.name] else color
            ax.plot(*at, marker, color=color, markerfacecolor=face, label=row.name)
            front += [] if by[row.name] else [at]
        if front:
            ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), fontsize=8)
            ax.plot(*np.transpose(sorted(front)), drawstyle="steps-post", color="0.75", lw=1, zorder=0)
        ax.axhline(2.0**-52, color="0.8", lw=0.8, ls=":", zorder=0)
        ax.set(xscale="log", yscale="log", xlabel=f"time for one {self.number} (s)", ylabel="relative error")
        ax.set_title(fill(self.title, _TITLE), fontsize=8)
        ax.minorticks_off()
        ax.grid(alpha=0.25)


@dataclass(frozen=True, repr=False)
class Tradeoff(drawing.Drawn):
    """What each method for a number costs, and how far it is off, from one run.

    Attributes
    ----------
    trades : dict of str to Trade
        By kind: "criterion", "threshold" and "basin", as far as they were asked for and measured. Each has `rows`,
        with `seconds` and relative `error`, and `dominators`.
    refused : dict of str to str
        Of the others that were asked for, why there is none.
    """

    trades: dict[str, Trade]
    refused: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        none = [f"{kind}: none: {reason}" for kind, reason in self.refused.items()]
        return "\n\n".join([*map(str, self.trades.values()), *none])

    def __repr__(self) -> str:
        counts = ", ".join(f"{len(trade.rows)} methods for a {kind}" for kind, trade in self.trades.items())
        return f"Tradeoff: {counts or 'nothing'}"

    def _repr_html_(self) -> str:
        picture = drawing.picture(self.plot, repr(self))
        return markup.block(picture, *(trade._repr_html_() for trade in self.trades.values()))

    def _figure(self) -> "Figure":
        figure: Figure
        figure, axes = drawing.new_figure(_WIDTH, _HEIGHT * len(self.trades), len(self.trades))
        for trade, ax in zip(self.trades.values(), axes[:, 0], strict=True):
            trade.draw(ax)
        return figure

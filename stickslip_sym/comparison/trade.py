"""Time and error of the methods for one number, measured: which dominate which, as text and as a picture."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from time import process_time
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.output import drawing, markup
from stickslip_sym.output.tables import duration, table, wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Candidate", "Row", "Trade", "Tradeoff", "dominators", "draw", "measured"]

_LEAST, _ENOUGH = 3, 0.02  # repetitions of a measurement, and seconds that they take together, at least
_WIDTH, _HEIGHT = 7.2, 3.5  # inches, of a panel of the picture
_SMALLEST = 1e-51  # error of a method whose own is less
_ROUNDING = 2.0**-52
_TITLE = 95  # characters of a line above a panel
_MARKERS = "os^Dv<>"
_COLORS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:olive", "tab:cyan")


@dataclass(frozen=True)
class Candidate:
    """One method at one tolerance: a call of `compute` gives `count` values. What takes long is timed once."""

    method: str
    setting: str
    compute: Callable[[], Any]
    count: int = 1
    repeated: bool = True


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

    def dominates(self, other: "Row") -> bool:
        """Whether it is at least as fast and at least as accurate as another, and better in one of the two."""
        at_least = self.seconds <= other.seconds and self.error <= other.error
        return at_least and (self.seconds < other.seconds or self.error < other.error)


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
    columns : mapping of str to str
        Titles of what else is known of every row, by its key.
    """

    number: str
    title: str
    rows: tuple[Row, ...]
    point: Mapping[str, float] = field(default_factory=dict)
    box: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)

    @property
    def dominators(self) -> dict[str, tuple[str, ...]]:
        """For each method which ones dominate it: at least as fast and as accurate, and better in one of the two.

        Named are those that are not dominated themselves.
        """
        return dominators(self.rows)

    @property
    def header(self) -> list[str]:
        """Titles of the table's columns."""
        return ["method", f"time a {self.number}", "relative error", *self.columns.values(), "dominated by"]

    @property
    def cells(self) -> list[list[str]]:
        """The table's cells as text, a line for each row."""

        def further(row: Row, key: str) -> str:
            value = row.further.get(key, "")
            if isinstance(value, str):
                return value
            return "not measured" if math.isnan(value) else f"{value:.11g}" if key == "share" else f"{value:.2g}"

        return [
            [
                row.name,
                duration(row.seconds) if row.found else "no number",
                f"{row.error:.1e}" if row.found else "",
                *(further(row, key) for key in self.columns),
                "; ".join(by),
            ]
            for row, by in zip(self.rows, self.dominators.values(), strict=True)
        ]

    def __str__(self) -> str:
        return f"{self.title}\n\n{table(self.header, self.cells)}"


def dominators(rows: Iterable[Row]) -> dict[str, tuple[str, ...]]:
    """Return for each row which ones dominate it, of those that none dominates.

    They suffice: what is dominated at all is dominated by one of them.
    """
    rows = list(rows)
    front = [row for row in rows if not any(other.dominates(row) for other in rows)]
    return {row.name: tuple(other.name for other in front if other.dominates(row)) for row in rows}


def measured(
    trade: Trade,
    candidates: Iterable[Candidate],
    judge: Callable[[Candidate, Any], tuple[float, Mapping[str, float | str]]],
) -> Trade:
    """Measure every candidate; `judge` gives the relative error of its result, and what else is known.

    A candidate that fails, or is left when time is up, has no number.
    """
    rows = []
    for one in candidates:
        times: list[float] = []
        least, enough = (_LEAST, _ENOUGH) if one.repeated else (1, 0.0)
        try:
            with np.errstate(all="ignore"):
                while len(times) < least or sum(times) < enough:
                    deadline.check_time()
                    begin = process_time()
                    result = one.compute()
                    times.append(process_time() - begin)
        except (ArithmeticError, NameError, StickSlipError):  # NumPy has no polylog, and lambdify prints it
            rows.append(Row(one.method, one.setting))
        else:
            rows.append(Row(one.method, one.setting, min(times) / one.count, *judge(one, result)))
    return replace(trade, rows=tuple(rows))


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
        tables = [markup.table(trade.header, trade.cells, caption=trade.title) for trade in self.trades.values()]
        return markup.block(drawing.picture(self.plot, repr(self)), *tables)

    def _figure(self) -> "Figure":
        rows = max(1, len(self.trades))
        figure: Figure
        figure, axes = drawing.new_figure(_WIDTH, _HEIGHT * rows, rows)
        for trade, ax in zip(self.trades.values(), axes[:, 0], strict=False):
            draw(trade, ax)
        return figure


def draw(trade: Trade, ax: "Axes") -> None:
    """Draw error against time: filled what no other method dominates, and hollow what one does.

    A method has a colour, and its settings have different markers.
    """
    by, front = trade.dominators, []
    methods = list(dict.fromkeys(row.method for row in trade.rows))
    settings = Counter[str]()
    for row in trade.rows:
        if not row.found:
            continue
        color, marker = (
            _COLORS[methods.index(row.method) % len(_COLORS)],
            _MARKERS[settings[row.method] % len(_MARKERS)],
        )
        settings[row.method] += 1
        at = row.seconds, max(row.error, _SMALLEST)
        face = "white" if by[row.name] else color
        ax.plot(*at, marker, color=color, markerfacecolor=face, label=row.name)
        front += [] if by[row.name] else [at]
    if settings:
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), fontsize=8)
    ax.plot(*np.reshape(sorted(front), (-1, 2)).T, drawstyle="steps-post", color="0.75", lw=1, zorder=0)
    ax.axhline(_ROUNDING, color="0.8", lw=0.8, ls=":", zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=f"time for one {trade.number} (s)", ylabel="relative error")
    ax.set_title("\n".join(wrapped(trade.title, _TITLE)), fontsize=8)
    ax.minorticks_off()
    ax.grid(alpha=0.25)

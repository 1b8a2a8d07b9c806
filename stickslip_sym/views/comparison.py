"""What is shown of comparisons: tables of methods, pictures of their costs, and the words of a study."""

from collections import Counter
from collections.abc import Callable
from functools import partial, singledispatch
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.comparison.compare import Comparison, Row
from stickslip_sym.comparison.crosscheck import CrossCheck
from stickslip_sym.comparison.study import Study
from stickslip_sym.comparison.tradeoff import DIGITS, Trade, Tradeoff
from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.output.tables import TERMINAL_WIDTH, aligned_table
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import FIGURE_HEIGHT, new_figure, picture, save_drawing
from stickslip_sym.views.pages.study_page import page_of_study, print_page_of_study
from stickslip_sym.views.threshold_plane import figure_of_plane

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SMALLEST = 10.0 ** -(DIGITS[-1] + 1)  # error of a method whose own is less
_MARKERS = "os^Dv<>"
_COLORS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:olive", "tab:cyan")
Columns = dict[str, Callable[[Row], str]]
"""What stands in the cells of a table, by its titles."""


# -- tables of methods ---------------------------------------------------------------------------------


@singledispatch
def columns(comparison: Comparison) -> Columns:
    """Return the columns of a table of methods."""
    return {
        "method": lambda row: row.name,
        "c in kg/s": lambda row: row.text("value", ".12g"),
        "relative error": lambda row: row.text("relative_error"),
        "status": lambda row: row.text("status"),
        "time": lambda row: row.text("seconds"),
    }


@columns.register(CrossCheck)
def columns_of_crosscheck(check: CrossCheck) -> Columns:
    """Return the columns for a criterion: differences from the first method."""
    usual = columns.dispatch(Comparison)(check)
    of_first = {"difference": lambda row: row.text("relative_error", ".2g")}
    return {name: usual[name] for name in ("method", "c in kg/s")} | of_first | {"time": usual["time"]}


@columns.register(Trade)
def columns_of_trade(trade: Trade) -> Columns:
    """Return the columns with what else was measured, and by which methods each is dominated."""
    usual = columns.dispatch(Comparison)(trade)
    dominators = trade.dominators
    if trade.number == "share":
        usual = {"share" if name == "c in kg/s" else name: cell for name, cell in usual.items()}
    for name in dict.fromkeys(name for row in trade.rows for name in row.further):
        usual[name] = partial(Row.text, column=name)
    return usual | {"dominated by": lambda row: "; ".join(dominators[row.name])}


def table_of_methods(comparison: Comparison) -> HeadedRows:
    """Return the table, without columns in which nothing stands."""
    cells = {title: [cell(row) for row in comparison.rows] for title, cell in columns(comparison).items()}
    shown = {title: column for title, column in cells.items() if any(column)}
    return list(shown), [list(row) for row in zip(*shown.values(), strict=True)]


@dispatch.parts.register(Comparison)
def parts_of_comparison(comparison: Comparison) -> list[str | HeadedRows]:
    """Return the table."""
    return [table_of_methods(comparison)]


@dispatch.parts.register(Trade)
def parts_of_trade(trade: Trade) -> list[str | HeadedRows]:
    """Return the title, and the table."""
    return [trade.title, table_of_methods(trade)]


@dispatch.plain_text.register(CrossCheck)
def crosscheck_as_text(check: CrossCheck) -> str:
    """Return the table, and the remarks below it."""
    return "\n".join([aligned_table(*table_of_methods(check)), *check.remarks])


@dispatch.notebook_html.register(Comparison)
def comparison_as_html(comparison: Comparison) -> str:
    """Return the table."""
    return markup.block(markup.html_table(*table_of_methods(comparison), caption=repr(comparison)))


@dispatch.plot.register(Comparison)
def plot_comparison(comparison: Comparison, path: str | Path | None, ax: None) -> "Figure":
    """Draw thresholds over the belt speed, with the last of the methods' that there is, and its point."""
    found = [row.threshold for row in comparison.rows if row.threshold is not None]
    if not found:
        raise InputError("no method gave a threshold to draw; the reasons are in the rows")
    figure = figure_of_plane(found[-1])
    if path is not None:
        save_drawing(figure, Path(path))
    return figure


# -- costs ---------------------------------------------------------------------------------------------


@dispatch.plain_text.register(Tradeoff)
def tradeoff_as_text(found: Tradeoff) -> str:
    """Return a table for each number, and why there is none for others."""
    none = [f"{kind}: none: {reason}" for kind, reason in found.refused.items()]
    return "\n\n".join([*map(str, found.trades.values()), *none])


@dispatch.notebook_html.register(Tradeoff)
def tradeoff_as_html(found: Tradeoff) -> str:
    """Return the picture, and the tables below it."""
    tables = [markup.Markup(comparison_as_html(trade)) for trade in found.trades.values()]
    return markup.block(picture(found.plot, repr(found)), *tables)


@dispatch.figure.register(Tradeoff)
def figure_of_tradeoff(found: Tradeoff) -> "Figure":
    """Return a panel for each number."""
    figure: Figure
    count = len(found.trades)
    figure, axes = new_figure(height=count * FIGURE_HEIGHT, rows=count)
    for trade, ax in zip(found.trades.values(), axes[:, 0], strict=True):
        draw_trade(trade, ax)
    return figure


@dispatch.draw.register(Trade)
def draw_trade(trade: Trade, ax: "Axes") -> list[Any]:
    """Draw error against time: filled what no other method dominates, and hollow what one does.

    A method has a colour, and its settings have different markers. It has its legend already.
    """
    dominators = trade.dominators
    front = list[tuple[float, float]]()
    methods = list(dict.fromkeys(row.method for row in trade.rows))
    settings = Counter[str]()
    for row in (row for row in trade.rows if row.value is not None):
        color = _COLORS[methods.index(row.method) % len(_COLORS)]
        marker = _MARKERS[settings[row.method] % len(_MARKERS)]
        settings[row.method] += 1
        at = row.seconds, max(row.relative_error or 0.0, _SMALLEST)
        face = "white" if dominators[row.name] else color
        ax.plot(*at, marker, color=color, markerfacecolor=face, label=row.name)
        if not dominators[row.name]:
            front.append(at)
    if front:
        ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), fontsize=8)
        ax.plot(*np.transpose(sorted(front)), drawstyle="steps-post", color="0.75", lw=1, zorder=0)
    ax.axhline(2.0**-52, color="0.8", lw=0.8, ls=":", zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=f"time for one {trade.number} (s)", ylabel="relative error")
    ax.set_title(fill(trade.title, TERMINAL_WIDTH), fontsize=8)
    ax.minorticks_off()
    ax.grid(alpha=0.25)
    return []


# -- a study -------------------------------------------------------------------------------------------

dispatch.page.register(Study, page_of_study)
dispatch.print_page.register(Study, print_page_of_study)


@dispatch.plain_text.register(Study)
def study_as_text(study: Study) -> str:
    """Return warnings, the decision, the operating point, and what else was found."""
    values = {name: study.value(name) for name in ("c", "V", "N", "m", "k")}
    point = f"{study.law.name or study.law.text}, {symbols.quantities_text(values, study.defaults)}"
    headline, *others = study.findings
    return "\n".join([*(f"warning: {text}" for text in study.warnings), headline, point, *others])


@dispatch.notebook_html.register(Study)
def study_as_html(study: Study) -> str:
    """Return the text, and the threshold by every method."""
    answers = [[row.name, row.text("value", ".10g")] for row in study.answers]
    return markup.block(*str(study).splitlines(), markup.html_table(["method", "c in kg/s"], answers))

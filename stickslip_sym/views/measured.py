"""What is shown of measurements: what was read, the first rows, and the points."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stickslip_sym.core.aliases import FloatArray, Rows
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import MOST_DRAWN, finish, picture

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


@dispatch.parts.register(Measurements)
def preview_of_measurements(measured: Measurements) -> list[str | HeadedRows]:
    """Return what was read in lines, and the first rows as a table."""
    return ["\n".join(_lines(measured)), _first_rows(measured)]


def _lines(measured: Measurements) -> list[str]:
    """Return what was understood, how and where it is written, and the blocks of the file."""
    blocks = [f"{block}{'' if block.read else ', not read'}" for block in measured.blocks]
    return [line for line in (measured.understood, measured.written, measured.source, *blocks) if line]


def _first_rows(measured: Measurements) -> HeadedRows:
    columns = measured.columns
    rows = [[f"{value:.6g}" for value in row] for row in zip(*columns.values(), strict=True)]
    left = []
    if len(rows) > markup.ENDS:
        left = [["...", *[""] * (len(columns) - 1)]]
    return ["v in m/s", "mu", "sigma"][: len(columns)], rows[: markup.ENDS] + left


@dispatch.notebook_html.register(Measurements)
def measurements_as_html(measured: Measurements) -> str:
    """Return the preview, a line below the other, and the picture."""
    text = markup.block(*_lines(measured), markup.html_table(*_first_rows(measured)))
    return markup.block(markup.Markup(text), picture(measured.plot, "measured friction"))


@dispatch.draw.register(Measurements)
def draw_measurements(measured: Measurements, ax: "Axes") -> "Sequence[Artist]":
    """Draw mu of the slip speed in a panel, and return the handles of its legend."""
    shown = draw_rows(ax, measured, measured.mu)
    finish(ax, xlabel="slip speed $v$ (m/s)", ylabel=r"coefficient of friction $\mu$")
    return shown


def draw_rows(ax: "Axes", measured: Measurements, y: FloatArray) -> "list[Artist]":
    """Draw a value for each row with its standard deviation, rising and falling branches apart."""
    v = measured.v
    sigma = measured.sigma
    branches = measured.branches
    shown = list["Artist"]()
    drawn = len(measured) > MOST_DRAWN
    if sigma is not None:
        ax.errorbar(v, y, sigma, fmt="none", ecolor="0.35", elinewidth=0.6, alpha=0.6, rasterized=drawn)
    kinds: list[tuple[str, str, str, Rows]] = [("measured", ".", "0.35", slice(None))]
    if branches is not None and branches.rising:
        sweep = branches.sweep
        kinds = [("rising speed", "^", "#D55E00", sweep > 0), ("falling speed", "v", "#009E73", sweep < 0)]
    for label, marker, color, rows in kinds:
        shown += ax.plot(v[rows], y[rows], marker, color=color, markersize=3.5, label=label, rasterized=drawn)
    return shown

"""What is shown of fits: parameters with their intervals, laws by rank, and the law through what was measured."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.uncertain import interval_text, text_with_error
from stickslip_sym.model.fitting.result import Fit, Fits
from stickslip_sym.model.fitting.weights import RANKED, speeds_that_count
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import BLUE, finish, new_figure, picture
from stickslip_sym.views.measured import draw_rows, preview_of_measurements
from stickslip_sym.views.model import draw_law

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


@dispatch.parts.register(Fit)
def parts_of_fit(fit: Fit) -> list[str | HeadedRows]:
    """Return the law, its parameters with their intervals, how well it fits, and warnings."""
    rows = []
    for name, (low, high) in fit.confidence().items():
        value = text_with_error(fit.values[name], fit.standard_errors[name])
        rows.append([name, value, interval_text(low, high), fit.law.parameters[name].unit or ""])
    about = f"residual standard deviation {fit.sigma:.3g}, AICc {fit.aicc:.6g}, weight {fit.weight:.2g}"
    about += f"; {fit.noise}" * bool(fit.noise)
    if fit.measured.branches is not None and fit.measured.branches.differ:
        about += "; the law is that of the mean of rising and falling branches"
    law = f"{f'{fit.name}: ' if fit.law.name else ''}mu(v) = {fit.law.text}"
    header = ["parameter", "value", "95 % interval", "unit"]
    return [law, (header, rows), about, *(f"warning: {text}" for text in fit.warnings)]


@dispatch.parts.register(Fits)
def parts_of_fits(fits: Fits) -> list[str | HeadedRows]:
    """Return what was measured, the laws that may be meant by rank, and the others by name."""
    rows = []
    least = min(fit.aicc for fit in fits)
    for fit in fits.likely:
        above = "-"
        if math.isfinite(fit.aicc):
            above = f"{fit.aicc - least:.1f}"
        rows.append([fit.name, above, f"{fit.weight:.3f}", f"{fit.sigma:.3g}", fit.values_in_words])
    parts = preview_of_measurements(fits.measured)
    parts.append((["law", "AICc above", "weight", "sigma", "values"], rows))
    unlikely = [fit for fit in fits if fit not in fits.likely]
    if unlikely:
        parts.append(f"a hundred times less likely, or more: {', '.join(fit.name for fit in unlikely)}")
    speeds = speeds_that_count(fits.measured)
    if speeds < RANKED:
        parts.append(f"too few rows to rank laws: {speeds} speeds; measure at {RANKED} speeds or more")
    parts += [f"warning: {fit.name}: {text}" for fit in fits.likely for text in fit.warnings]
    if others := [fit.name for fit in unlikely if fit.warnings]:
        parts.append(f"warnings of less likely laws, each printed with its fit: {', '.join(others)}")
    if fits.rejected:
        parts.append((["not fitted", "because"], [[name, why] for name, why in fits.rejected.items()]))
    return parts


@dispatch.notebook_html.register(Fit)
@dispatch.notebook_html.register(Fits)
def fit_as_html(fitted: Fit | Fits) -> str:
    """Return what the text says, and the figure below it."""
    said = dispatch.parts_as_html(fitted)
    return markup.block(said, picture(lambda: dispatch.figure(fitted), "measured friction and the fitted law"))


@dispatch.draw.register(Fit)
def draw_fit(fit: Fit, ax: Any) -> "Sequence[Artist]":
    """Draw the law with its band and the measured points in a panel, and return the handles of its legend."""
    draw_law(ax, fit.law, float(fit.measured.v[-1]), fit.measured, fit.band, fit.name)
    return [handle for handle in ax.get_legend_handles_labels()[0] if not isinstance(handle, tuple)]


@dispatch.draw.register(Fits)
def draw_best_fit(fits: Fits, ax: "Axes") -> "Sequence[Artist]":
    """Draw the best fit in a panel, and return the handles of its legend."""
    return draw_fit(fits.best, ax)


@dispatch.figure.register(Fit)
def figure_of_fit(fit: Fit) -> "Figure":
    """Return the law with its band and the measured points, and the residuals below."""
    figure: Figure
    figure, ((above,), (below,)) = new_figure(rows=2, sharex=True, height_ratios=[3, 1])
    draw_fit(fit, above)
    draw_rows(below, fit.measured, fit.residuals)
    below.axhline(0, color=BLUE, linewidth=1)
    finish(below, xlabel=above.get_xlabel(), ylabel="residual")
    above.set_xlabel("")
    return figure


@dispatch.figure.register(Fits)
def figure_of_best_fit(fits: Fits) -> "Figure":
    """Return the figure of the best fit."""
    return figure_of_fit(fits.best)

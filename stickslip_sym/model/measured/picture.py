"""The picture of a fit: measured points, the curve with its band, and the residuals below."""

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip_sym.output.drawing import require_matplotlib

if TYPE_CHECKING:
    from stickslip_sym.model.measured.fits import Fit

__all__ = ["draw_fit"]

_POINTS, _CURVE, _BAND = "0.35", "#0072B2", "#56B4E9"  # told apart by the colour-blind, and in print


def draw_fit(fit: "Fit") -> Any:
    """Return a figure of a fit.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    measured = fit.measured
    figure = Figure(figsize=(6.4, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    v = np.unique([*np.linspace(0, measured.v[-1], 300), *np.geomspace(1e-4, 1, 100) * measured.v[-1]])[1:]
    low, high = fit.band(v)
    above.fill_between(v, low, high, color=_BAND, alpha=0.4, linewidth=0, label="95 % band of the curve")
    above.plot(v, fit.law.at_speeds(v), color=_CURVE, label=fit.name[:60])
    for axes, y in ((above, measured.mu), (below, fit.residuals)):
        if measured.sigma is not None:
            axes.errorbar(measured.v, y, measured.sigma, fmt="none", ecolor=_POINTS, elinewidth=0.6, alpha=0.6)
        axes.plot(measured.v, y, ".", color=_POINTS, markersize=3, label="measured" if axes is above else None)
    below.axhline(0, color=_CURVE, linewidth=1)
    above.set_ylabel("coefficient of friction mu")
    below.set_ylabel("residual")
    below.set_xlabel("slip speed v in m/s")
    above.legend(frameon=False)
    return figure

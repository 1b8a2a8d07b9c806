"""The picture of a fit: measured points, the curve with its band, and the residuals below."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output.drawing import require_matplotlib

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_fit"]

FloatArray = NDArray[np.float64]

_POINTS, _CURVE, _BAND = "0.35", "#0072B2", "#56B4E9"  # told apart by the colour-blind, and in print


def draw_fit(
    name: str,
    measured: Measurements,
    residuals: FloatArray,
    curve: Callable[[FloatArray], FloatArray],
    band: Callable[[FloatArray], tuple[FloatArray, FloatArray]],
) -> "Figure":
    """Return a figure of a fit, of the fitted curve and its band as functions of the slip speed.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
    v = np.unique([*np.linspace(0, measured.v[-1], 300), *np.geomspace(1e-4, 1, 100) * measured.v[-1]])[1:]
    low, high = band(v)
    above.fill_between(v, low, high, color=_BAND, alpha=0.4, linewidth=0, label="95 % band of the curve")
    above.plot(v, curve(v), color=_CURVE, label=name[:60])
    for axes, y in ((above, measured.mu), (below, residuals)):
        if measured.sigma is not None:
            axes.errorbar(measured.v, y, measured.sigma, fmt="none", ecolor=_POINTS, elinewidth=0.6, alpha=0.6)
        axes.plot(measured.v, y, ".", color=_POINTS, markersize=3, label="measured" if axes is above else None)
    below.axhline(0, color=_CURVE, linewidth=1)
    above.set_ylabel("coefficient of friction mu")
    below.set_ylabel("residual")
    below.set_xlabel("slip speed v in m/s")
    above.legend(frameon=False)
    return figure

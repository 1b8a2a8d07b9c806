"""The curve of a law with what its standard errors leave open, as numbers and as a picture."""

from collections.abc import Callable
from typing import Any

import numpy as np
from uncertainties import covariance_matrix

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.output.drawing import BLUE, finish

Band = Callable[[FloatArray], tuple[FloatArray, FloatArray]]

_NORMAL = 1.96  # standard errors on either side, 95 % of a normal distribution


def band(law: FrictionLaw, v: FloatArray, quantile: float = _NORMAL) -> tuple[FloatArray, FloatArray]:
    """Return mu less and plus so many of its standard errors, which are those of the parameters to first order."""
    mu, half = law.at_speeds(v), np.zeros(v.shape)
    if law.uncertain:
        covariance = np.array(covariance_matrix(list(law.uncertain.values())))
        by = np.array([law.partial(name).at_speeds(v) for name in law.uncertain])
        half = quantile * np.sqrt(np.einsum("in,ij,jn->n", by, covariance, by))
    return mu - half, mu + half


def draw_points(ax: Any, measured: Measurements, y: FloatArray, **look: Any) -> None:
    """Draw a value for each measured row, with its standard deviation where it is known."""
    if measured.sigma is not None:
        ax.errorbar(measured.v, y, measured.sigma, fmt="none", ecolor="0.35", elinewidth=0.6, alpha=0.6)
    ax.plot(measured.v, y, ".", color="0.35", markersize=3.5, **look)


def draw_law(
    ax: Any, law: FrictionLaw, top: float, measured: Measurements | None, band: Band | None, label: str
) -> None:
    """Draw mu up to a slip speed, with the 95 % band that a function of speeds gives, and what was measured."""
    v = np.unique([*np.linspace(0, top, 300), *np.geomspace(1e-4, 1, 100) * top])[1:]
    if measured is not None:
        draw_points(ax, measured, measured.mu, label="measured")
    if band is not None:
        ax.fill_between(v, *band(v), color="#56B4E9", alpha=0.45, linewidth=0, label="95 % band")
    ax.plot(v, law.at_speeds(v), color=BLUE, linewidth=1.6, label=label)
    ax.legend(loc="best")
    finish(ax, xlabel="slip speed $v$ (m/s)", ylabel=r"coefficient of friction $\mu$", xlim=(0, top))

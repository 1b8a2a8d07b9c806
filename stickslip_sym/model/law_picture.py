"""The picture of a friction law: mu over the slip speed, what standard errors leave open, and measured points."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from uncertainties import UFloat, covariance_matrix

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import real
from stickslip_sym.core.remedies import Argument
from stickslip_sym.output.drawing import BLUE, finish, new_figure, save, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stickslip_sym.model.measured.measurements import Measurements

_OF_LAW = 5.5, 3.6  # inches
_TITLE = 60  # characters of a legend
NORMAL = 1.96
"""Standard errors on either side, 95 % of a normal distribution."""
Band = Callable[[FloatArray], tuple[FloatArray, FloatArray]]


class DrawnLaw(Protocol):
    """What a picture needs of a friction law."""

    name: str | None

    @property
    def text(self) -> str:
        """The formula."""

    @property
    def uncertain(self) -> Mapping[str, UFloat]:
        """The values that carry a standard error."""

    def at_speeds(self, speeds: FloatArray) -> FloatArray:
        """Return mu at slip speeds."""

    def partial(self, name: str) -> "DrawnLaw":
        """Return the derivative with respect to a parameter."""


def band(law: DrawnLaw, v: FloatArray, quantile: float = NORMAL) -> tuple[FloatArray, FloatArray]:
    """Return mu less and plus so many of its standard errors, which are those of the parameters to first order."""
    mu, half = law.at_speeds(v), np.zeros(v.shape)
    if law.uncertain:
        covariance = np.array(covariance_matrix(list(law.uncertain.values())))
        by = np.array([law.partial(name).at_speeds(v) for name in law.uncertain])
        half = quantile * np.sqrt(np.einsum("in,ij,jn->n", by, covariance, by))
    return mu - half, mu + half


def draw_law(
    ax: Any, law: DrawnLaw, top: float, measured: "Measurements | None", band: Band | None, label: str
) -> None:
    """Draw mu up to a slip speed, with the 95 % band that a function of speeds gives, and what was measured."""
    v = np.unique([*np.linspace(0, top, 300), *np.geomspace(1e-4, 1, 100) * top])[1:]
    if measured is not None:
        measured.draw_rows(ax, measured.mu)
    if band is not None:
        ax.fill_between(v, *band(v), color="#56B4E9", alpha=0.45, linewidth=0, label="95 % band")
    ax.plot(v, law.at_speeds(v), color=BLUE, linewidth=1.6, label=label)
    ax.legend(loc="best")
    finish(ax, xlabel="slip speed $v$ (m/s)", ylabel=r"coefficient of friction $\mu$", xlim=(0, top))


def figure_of_law(law: DrawnLaw, v_max: float, path: str | Path | None, ax: "Axes | None") -> "Figure":
    """Draw a law on its own, as `FrictionLaw.plot` does."""
    top = real("v_max", v_max)
    if not 0 < top < math.inf:
        raise InputError(
            f"v_max = {top:g} is no slip speed; give the highest one in m/s, as ", Argument("v_max", 1.0)
        )
    bounds = partial(band, law) if law.uncertain else None
    with styled():
        if ax is None:
            _, axes = new_figure(*_OF_LAW)
            ax = axes[0, 0]
        draw_law(ax, law, top, None, bounds, law.name or law.text[:_TITLE])
        figure: Any = ax.figure
        if path is not None:
            save(figure, Path(path))
    return figure  # type: ignore[no-any-return]

"""The plane of damping over belt speed: thresholds by averages and exactly, and what exists between them."""

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from uncertainties import UFloat

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NotConverged, NoThreshold, StickSlipError
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.output.drawing import BLUE, GREEN, ORANGE, finish, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Look = dict[str, Any]
Plane: TypeAlias = dict[str, FloatArray]
"""Belt speeds V, slope averages, exact thresholds in kg/s and their standard errors there; NaN where none is."""
_POINTS = 33  # of a curve over belt speed
_REACHED = 2.0  # times the belt speed
_DRAWN = 1e-4  # relative error of that curve, below the width of a line
_HEIGHT, _BELOW = 1.35, 0.06  # of the plane, over the highest damping on it, and below 0 and the lowest
_AVERAGES = {"equilibrium": (ORANGE, "--"), "least_squares": ("black", ":"), "harmonic": ("0.35", "-.")}
_EXPANSION = {"second_order": ("#CC79A7", (0, (3, 1, 1, 1)))}
_SIZE = 6.0, 4.2  # inches, of a picture of its own

BAND = 1.96
"""Standard errors on either side, 95 % of a normal distribution."""
ABOVE: Look = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2, "fontsize": 7.5}
"""Of a legend above its picture."""


def plane(law: FrictionLaw, given: Mapping[str, float | UFloat], speed: float) -> Plane:
    """Return the thresholds, for given N, m and k, up to twice a belt speed, or as far as mu was measured."""
    top = _REACHED * speed if law.v_max is None else min(_REACHED * speed, float(law.v_max) / 2)
    V = np.linspace(top / _POINTS, top, _POINTS)
    averages = {name: pure_slip_damping(law, V=V, N=given["N"], method=name).value for name in _AVERAGES}

    def exact(V: FloatArray) -> FloatArray:
        try:
            threshold = pure_slip_damping(law, V=V, N=given["N"], m=given["m"], k=given["k"], rtol=_DRAWN)
        except (NotConverged, NoThreshold):
            return np.full((2, 1), np.nan) if len(V) == 1 else np.hstack([exact(speed) for speed in V[:, None]])
        spread = 0.0 if threshold.budget is None else threshold.budget.uncertainty
        return np.array([threshold.value, np.broadcast_to(spread, V.shape)])

    return {"V": V, **averages, **dict(zip(("exact", "standard error"), exact(V), strict=True))}


def draw_plane(
    ax: Any, curves: Plane, osc: Oscillator, spread: Mapping[str, float], point: str = "operating point"
) -> None:
    """Draw the thresholds over belt speed, what exists between them, and a point with its error bars."""
    V, rest, exact = (curves[name] for name in ("V", "equilibrium", "exact"))
    # Opaque: an SVG gives a hatch the opacity of its face.
    both: Look = {"facecolor": "#fcf0e8", "edgecolor": ORANGE, "hatch": "////", "linewidth": 0}
    slips: Look = {"facecolor": "#e8f6f1", "edgecolor": GREEN, "hatch": r"\\\\..", "linewidth": 0}
    for lower, upper, style, label in (
        (rest, exact, both, "rest or stick-slip, by the initial condition"),
        (exact, rest, slips, "limit cycle in pure slip"),
    ):
        if (where := upper > lower).any():  # where neither is NaN
            ax.fill_between(V, lower, upper, where=where, label=label, **style)
    if np.nanmax(curves["standard error"], initial=0.0) > 0:
        half = BAND * curves["standard error"]
        shade: Look = {"color": "#56B4E9", "alpha": 0.45, "linewidth": 0}
        ax.fill_between(V, exact - half, exact + half, label="95 % band", **shade)
    ax.plot(V, exact, color=BLUE, linewidth=2, label="threshold")
    for name, (color, dashes) in (_AVERAGES | _EXPANSION).items():
        if name in curves:
            ax.plot(V, curves[name], color=color, linestyle=dashes, label=name.replace("_", " "))
    ax.errorbar(
        [osc.V], [osc.c], [spread["c"]], [spread["V"]], fmt="o", color="black", markersize=6,
        markerfacecolor="white", markeredgewidth=1.5, zorder=5, label=point,
    )  # fmt: skip
    ax.legend(**ABOVE)  # not beside the operating point, whose marker looks like a second one there
    finish(ax, xlabel="belt speed $V$ (m/s)", ylabel="damping $c$ (kg/s)", xlim=(0, V[-1]))
    near = np.concatenate([exact, rest])[np.tile(V >= osc.V / 3, 2)]
    highest = max(near[np.isfinite(near)].max(initial=0.0), osc.c, 1e-9)
    lowest = min(0.0, osc.c - spread["c"])
    ax.set_ylim(lowest - _BELOW * (highest - lowest), _HEIGHT * highest)


def figure_of(threshold: Threshold[float]) -> "Figure":
    """Return the plane at V, N, m and k, the expansion in it, with the threshold that was computed at V."""
    points = threshold.points
    law, numbers = points.law, {name: float(column[0]) for name, column in points.columns.items()}
    point: dict[str, float | UFloat] = {**numbers, **points.uncertain}
    nominal = {name: getattr(value, "nominal_value", value) for name, value in point.items()}
    curves = plane(law, point, nominal["V"])
    rest = {name: nominal[name] for name in "Nmk"}
    with suppress(StickSlipError):  # a law with kinks has none
        curves["second_order"] = pure_slip_damping(law, V=curves["V"], **rest, method="second_order").value
    spread = {"V": BAND * getattr(point["V"], "std_dev", 0.0), "c": BAND * (threshold.uncertainty or 0.0)}
    with styled():
        figure: Figure
        figure, axes = new_figure(*_SIZE)
        at = Oscillator(c=threshold.value, **nominal)
        draw_plane(axes[0, 0], curves, at, spread, f"{threshold.method} at $V$ = {nominal['V']:.4g} m/s")
    return figure

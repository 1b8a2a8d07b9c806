"""The plane of damping over belt speed, drawn: thresholds, and what exists between them."""

from collections.abc import Mapping
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from uncertainties import UFloat

from stickslip_sym.comparison.plane import Plane, plane
from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.core.probabilities import NORMAL
from stickslip_sym.core.remedies import Argument
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.views.drawing import BLUE, GREEN, ORANGE, finish, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Look = dict[str, Any]
_LINES = {
    "equilibrium": (ORANGE, "--"),
    "least_squares": ("black", ":"),
    "harmonic": ("0.35", "-."),
    "second_order": ("#CC79A7", (0, (3, 1, 1, 1))),
}

ABOVE: Look = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2, "fontsize": 7.5}
"""Of a legend above its picture."""


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
        half = NORMAL * curves["standard error"]
        shade: Look = {"color": "#56B4E9", "alpha": 0.45, "linewidth": 0}
        ax.fill_between(V, exact - half, exact + half, label="95 % band", **shade)
    ax.plot(V, exact, color=BLUE, linewidth=2, label="threshold")
    for name, (color, dashes) in _LINES.items():
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
    margin = ax.margins()[1] * (highest - lowest)
    ax.set_ylim(lowest - margin, highest + margin)


def figure_of_plane(threshold: Threshold[float]) -> "Figure":
    """Return the plane at V, N, m and k, the expansion in it, with the threshold that was computed at V."""
    points = threshold.points
    law = points.law
    numbers = {name: float(column[0]) for name, column in points.columns.items()}
    point: dict[str, float | UFloat] = {**numbers, **points.uncertain}
    nominal = {name: getattr(value, "nominal_value", value) for name, value in point.items()}
    if missing := sorted({"m", "k"} - nominal.keys()):
        raise InputError(
            f"the picture shows the threshold itself, which depends on {' and '.join(missing)}; compare with ",
            Argument("m", 1), " and ", Argument("k", 100), ", for example",
        )  # fmt: skip
    curves = plane(law, point, nominal["V"])
    rest = {name: nominal[name] for name in "Nmk"}
    with suppress(StickSlipError):  # a law with kinks has none
        curves["second_order"] = pure_slip_damping(law, V=curves["V"], **rest, method="second_order").value
    spread = {"V": NORMAL * getattr(point["V"], "std_dev", 0.0), "c": NORMAL * (threshold.uncertainty or 0.0)}
    with styled():
        figure: Figure
        figure, axes = new_figure()
        at = Oscillator(c=threshold.value, **nominal)
        draw_plane(axes[0, 0], curves, at, spread, f"{threshold.method} at $V$ = {nominal['V']:.4g} m/s")
    return figure

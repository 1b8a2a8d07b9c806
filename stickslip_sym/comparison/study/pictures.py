"""The figures of a study. They hold no text of the user's; the name of the law stands on the page."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NotConverged, NoThreshold
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.fitting.result import band, draw_law
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping
from stickslip_sym.output.drawing import BLUE, GREEN, ORANGE, finish, new_figure, styled, svg_uri

Look = dict[str, Any]
Study: TypeAlias = Any
"""A `Study`, which asks for its pictures and so cannot be imported."""
Plane: TypeAlias = dict[str, FloatArray]
"""Belt speeds V, slope averages, exact thresholds in kg/s and their standard errors there; NaN where none is."""
_SIZE = 4.6, 3.1  # inches: two beside each other on a screen and on paper
_BAND = 1.96  # standard errors, 95 % of a normal distribution
_POINTS = 33  # of a curve over belt speed
_WIDEST = 2.0  # times the belt speed
_RTOL = 1e-4  # of that curve, below the width of a line
_MANY = 2000  # points of the motion over time
_HEIGHT = 1.35  # of the plane, over the highest of thresholds at the operating point and its damping
_AVERAGES = {"equilibrium": (ORANGE, "--"), "least_squares": ("black", ":"), "harmonic": ("0.35", "-.")}


def plane(law: FrictionLaw, given: Mapping[str, float | UFloat], speed: float) -> Plane:
    """Return the thresholds, for given N, m and k, up to twice a belt speed, or as far as mu was measured."""
    top = _WIDEST * speed if law.v_max is None else min(_WIDEST * speed, float(law.v_max) / 2)
    V = np.linspace(top / _POINTS, top, _POINTS)
    averages = {name: pure_slip_damping(law, V=V, N=given["N"], method=name).value for name in _AVERAGES}

    def exact(V: FloatArray) -> FloatArray:
        try:
            found = pure_slip_damping(law, V=V, N=given["N"], m=given["m"], k=given["k"], rtol=_RTOL)
        except (NotConverged, NoThreshold):
            return np.full((2, 1), np.nan) if len(V) == 1 else np.hstack([exact(one) for one in V[:, None]])
        spread = 0.0 if found.budget is None else found.budget.uncertainty
        return np.array([found.value, np.broadcast_to(spread, V.shape)])

    return {"V": V, **averages, **dict(zip(("exact", "standard error"), exact(V), strict=True))}


def pictures(study: Study) -> Iterator[tuple[str, str]]:
    """Yield name and data URI of each figure whose part could be computed."""
    for name, (part, draw) in _PICTURES.items():
        if getattr(study, part) is not None:
            with styled():
                figure, axes = new_figure(*_SIZE)
                draw(axes[0, 0], study)
                yield name, svg_uri(figure)


def _law(ax: Any, study: Study) -> None:
    law, V, fit, measured = study.law, study.oscillator.V, study.fit, study.measured
    top = max(2.2 * V, 0.0 if measured is None else float(measured.v[-1]))
    top = top if law.v_max is None else min(top, float(law.v_max))
    span: Look = {"facecolor": "0.93", "edgecolor": "0.8", "linewidth": 0.6, "zorder": 0}
    ax.axvspan(0, min(2 * V, top), label="0 to $2V$", **span)
    ax.axvline(V, color="black", linestyle=":", linewidth=1, label="belt speed $V$")
    bounds = fit.band if fit is not None else partial(band, law) if law.uncertain else None
    draw_law(ax, law, top, measured, bounds, r"$\mu(v)$")


def _plane(ax: Any, study: Study) -> None:
    found, osc = study.plane, study.oscillator
    V, rest, exact = (found[name] for name in ("V", "equilibrium", "exact"))
    # Opaque: an SVG gives a hatch the opacity of its face.
    both: Look = {"facecolor": "#fcf0e8", "edgecolor": ORANGE, "hatch": "////", "linewidth": 0}
    slips: Look = {"facecolor": "#e8f6f1", "edgecolor": GREEN, "hatch": r"\\\\..", "linewidth": 0}
    for lower, upper, style, label in (
        (rest, exact, both, "rest or stick-slip, by the initial condition"),
        (exact, rest, slips, "limit cycle in pure slip"),
    ):
        if (where := upper > lower).any():  # where neither is NaN
            ax.fill_between(V, lower, upper, where=where, label=label, **style)
    if np.nanmax(found["standard error"], initial=0.0) > 0:
        half = _BAND * found["standard error"]
        shade: Look = {"color": "#56B4E9", "alpha": 0.45, "linewidth": 0}
        ax.fill_between(V, exact - half, exact + half, label="95 % band", **shade)
    ax.plot(V, exact, color=BLUE, linewidth=2, label="threshold")
    for name, (color, dashes) in _AVERAGES.items():
        ax.plot(V, found[name], color=color, linestyle=dashes, label=name.replace("_", " "))
    spread = {name: _BAND * (study.standard_error(name) or 0.0) for name in "Vc"}
    ax.errorbar(
        [osc.V], [osc.c], [spread["c"]], [spread["V"]], fmt="o", color="black", markersize=6,
        markerfacecolor="white", markeredgewidth=1.5, zorder=5, label="operating point",
    )  # fmt: skip
    ax.legend(loc="upper right", fontsize=7.5)
    finish(ax, xlabel="belt speed $V$ (m/s)", ylabel="damping $c$ (kg/s)", xlim=(0, V[-1]))
    near = np.concatenate([exact, rest])[np.tile(V >= osc.V / 3, 2)]
    highest = max(near[np.isfinite(near)].max(initial=0.0), osc.c, 1e-9)
    ax.set_ylim(min(0.0, 1.2 * osc.c), _HEIGHT * highest)


def _time(ax: Any, study: Study) -> None:
    end = study.motion.stretches[-1].end
    study.motion.draw(ax)
    ax.axhline(study.oscillator.V, color="black", linestyle=":", linewidth=0.8, zorder=0, label="belt speed")
    ax.legend(loc="lower right", ncols=2)
    finish(ax, xlabel="time $t$ (s)", ylabel=r"velocity $\dot x$ (m/s)", xlim=(0, end))
    low, high = ax.get_ylim()
    ax.set_ylim(low - 0.22 * (high - low), high)  # for the legend


def _phase_plane(ax: Any, study: Study) -> None:
    handles = study.regime.draw(ax)
    if study.motion is not None:
        state = study.motion.at(np.linspace(0, study.motion.stretches[-1].end, _MANY))
        handles += ax.plot(state.x, state.v, color="0.7", linewidth=0.7, zorder=0, label="motion over time")
    finish(ax)
    place: Look = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2, "fontsize": 7.5}
    ax.legend(handles=handles, **place)


_PICTURES = {
    "law": ("law", _law),
    "plane": ("plane", _plane),
    "time": ("motion", _time),
    "phase": ("regime", _phase_plane),
}
"""By name: the part of a study that it shows, and how it is drawn; what it shows in words is in the template."""

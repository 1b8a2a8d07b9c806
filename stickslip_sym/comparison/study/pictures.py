"""The figures of a study. No text of a user's stands in them: what the law is called, the page says."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip_sym.comparison.study.plane import Plane
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.fitting.result import Fit
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.measured.measurements import Measurements
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.regimes.drawing import phase_plane_of
from stickslip_sym.motion.regimes.regime import Regime
from stickslip_sym.motion.simulation.trajectory import Phase, Trajectory
from stickslip_sym.output.drawing import BLUE, GREEN, ORANGE, finish, new_figure, styled, svg_uri

__all__ = ["ALT", "CAPTIONS", "draw_law", "draw_phase_plane", "draw_plane", "draw_time", "picture"]

_SIZE = 4.6, 3.1  # inches: two beside each other on a screen and on paper
_BAND = 1.96  # standard errors, 95 % of a normal distribution
_SMOOTH = 60  # points of a curve in slip, for each period of free vibration
_MANY = 1000  # points of the motion in the phase plane
_AVERAGES = {"equilibrium": (ORANGE, "--"), "least_squares": ("black", ":"), "harmonic": ("0.35", "-.")}
ALT = {
    "law": "Coefficient of friction over slip speed, with measured points and the 95 % band where there are any.",
    "plane": "Thresholds of damping over belt speed, with regions of coexistence, and the operating point.",
    "time": "Velocity of the mass over time, from x = 0 with the belt's speed.",
    "phase": "Phase plane: velocity over displacement, with attractors and separatrices.",
}
CAPTIONS = {
    "law": "Friction law. The threshold depends on slip speeds from 0 to 2V only, or little more.",
    "plane": "Damping over belt speed. Below the threshold a mass that sticks goes on sticking and slipping. "
    "Hatched: between the threshold and the stability of the equilibrium (dashed) the initial condition decides, "
    "or a limit cycle in pure slip attracts.",
    "time": "Motion from x = 0 with the belt’s speed. Thick lines are stick.",
    "phase": "Phase plane. A separatrix parts the initial conditions that lead to different attractors.",
}
_HEIGHT = 1.35  # of the plane, over the highest of thresholds at the operating point and its damping


def picture(draw: Callable[[Any], None]) -> str:
    """Return a figure of one panel as a data URI; `draw` is given the axes.

    Raises `InputError` if matplotlib is not installed.
    """
    with styled():
        figure, axes = new_figure(*_SIZE)
        draw(axes[0, 0])
        return svg_uri(figure)


def draw_law(ax: Any, law: FrictionLaw, V: float, *, measured: Measurements | None, fit: Fit | None) -> None:
    """Draw mu over the slip speed, with the band of its errors, what was measured, and the range of 0 to 2V."""
    top = 2.2 * V if measured is None else max(2.2 * V, float(measured.v[-1]))
    top = top if law.v_max is None else min(top, float(law.v_max))
    v = np.unique([*np.linspace(0, top, 241), *np.geomspace(1e-4, 1, 81) * top])[1:]
    if measured is not None:
        if measured.sigma is not None:
            ax.errorbar(
                measured.v, measured.mu, measured.sigma, fmt="none", ecolor="0.35", elinewidth=0.6, alpha=0.6
            )
        ax.plot(measured.v, measured.mu, ".", color="0.35", markersize=3.5, label="measured")
    band = _band(law, v) if fit is None else fit.band(v)
    if band is not None:
        ax.fill_between(v, *band, color="#56B4E9", alpha=0.45, linewidth=0, label="95 % band")
    ax.plot(v, law.at_speeds(v), color=BLUE, linewidth=1.6, label=r"$\mu(v)$")
    ax.axvspan(
        0,
        min(2 * V, top),
        facecolor="0.93",
        edgecolor="0.8",
        linewidth=0.6,
        zorder=0,
        label="0 to $2V$",
    )
    ax.axvline(V, color="black", linestyle=":", linewidth=1, label="belt speed $V$")
    ax.legend(loc="best")
    finish(ax, xlabel="slip speed $v$ (m/s)", ylabel=r"coefficient of friction $\mu$", xlim=(0, top))


def _band(law: FrictionLaw, v: NDArray[np.float64]) -> tuple[FloatArray, FloatArray] | None:
    """Return the band that the parameters' standard errors give the curve, to first order."""
    if not law.uncertain:
        return None
    from uncertainties import covariance_matrix

    covariance = np.array(covariance_matrix(list(law.uncertain.values())))
    by = np.array([np.broadcast_to(law.partial(name).at_speeds(v), v.shape) for name in law.uncertain])
    half = _BAND * np.sqrt(np.einsum("in,ij,jn->n", by, covariance, by))
    mu = law.at_speeds(v)
    return mu - half, mu + half


def draw_plane(ax: Any, plane: Plane, osc: Oscillator, errors: Mapping[str, UFloat]) -> None:
    """Draw thresholds over belt speed, where motions coexist, and the operating point."""
    top = _HEIGHT * _highest(plane, osc.V, osc.c)
    _regions(ax, plane)
    if plane.uncertainty is not None:
        half = _BAND * plane.uncertainty
        ends = plane.exact - half, plane.exact + half
        ax.fill_between(plane.V, *ends, color="#56B4E9", alpha=0.45, linewidth=0, label="95 % band")
    ax.plot(plane.V, plane.exact, color=BLUE, linewidth=2, label=f"threshold ({plane.method})")
    for name, (color, style) in _AVERAGES.items():
        ax.plot(plane.V, plane.averages[name], color=color, linestyle=style, label=name.replace("_", " "))
    spread = {name: errors[name].std_dev if name in errors else 0.0 for name in ("V", "c")}
    ax.errorbar(
        [osc.V], [osc.c], [_BAND * spread["c"]], [_BAND * spread["V"]], fmt="o", color="black", markersize=6,
        markerfacecolor="white", markeredgewidth=1.5, zorder=5, label="operating point",
    )  # fmt: skip
    ax.legend(loc="upper right", fontsize=7.5)
    finish(ax, xlabel="belt speed $V$ (m/s)", ylabel="damping $c$ (kg/s)", xlim=(0, plane.V[-1]))
    ax.set_ylim(min(0.0, 1.2 * osc.c), top)


def _highest(plane: Plane, V: float, c: float) -> float:
    """Return the height of what matters near the operating point."""
    near = plane.V >= V / 3
    curves = np.concatenate([plane.exact[near], plane.averages["equilibrium"][near]])
    finite = curves[np.isfinite(curves)]
    return float(max(finite.max(initial=0.0), c, 1e-9))


def _regions(ax: Any, plane: Plane) -> None:
    """Hatch where rest and stick-slip coexist, and where a limit cycle in pure slip is stable."""
    rest, exact = plane.averages["equilibrium"], plane.exact
    # Opaque: an SVG gives a hatch the opacity of its face.
    both = {"facecolor": "#fcf0e8", "edgecolor": ORANGE, "hatch": "////", "linewidth": 0}
    slips = {"facecolor": "#e8f6f1", "edgecolor": GREEN, "hatch": r"\\\\..", "linewidth": 0}
    for lower, upper, style, label in (
        (rest, exact, both, "rest or stick-slip, by the initial condition"),
        (exact, rest, slips, "limit cycle in pure slip"),
    ):
        where = np.isfinite(lower) & np.isfinite(upper) & (upper > lower)
        if where.any():
            ax.fill_between(plane.V, lower, upper, where=where, label=label, **style)


def draw_time(ax: Any, motion: Trajectory) -> None:
    """Draw the velocity over time; thick lines are stick."""
    osc = motion.oscillator
    _stretches(ax, motion, 2 * np.pi / osc.omega)
    ax.axhline(osc.V, color="black", linestyle=":", linewidth=0.8, zorder=0, label="belt speed")
    ax.legend(loc="lower right", ncols=3)
    finish(ax, xlabel="time $t$ (s)", ylabel=r"velocity $\dot x$ (m/s)", xlim=(0, motion.stretches[-1].end))
    low, high = ax.get_ylim()
    ax.set_ylim(low - 0.22 * (high - low), high)  # room for the legend


def _stretches(ax: Any, motion: Trajectory, period: float) -> None:
    named = set[str]()
    for stretch in motion.stretches:
        sticks = stretch.phase is Phase.STICK
        slips = _SMOOTH * (1 + int((stretch.end - stretch.start) / period))
        t = np.linspace(stretch.start, stretch.end, 2 if sticks else slips)
        _, v = stretch.course(t)
        look = {"color": ORANGE, "linewidth": 3.0} if sticks else {"color": BLUE, "linewidth": 1.2}
        name = "stick" if sticks else "slip"
        ax.plot(t, v, solid_capstyle="butt", label="_" if name in named else name, **look)
        named.add(name)


def draw_phase_plane(ax: Any, regime: Regime, motion: Trajectory | None) -> None:
    """Draw attractors and separatrices, and a motion among them."""
    handles = phase_plane_of(ax, regime)
    if motion is not None:
        state = motion.at(np.linspace(0, motion.stretches[-1].end, _MANY))
        handles += ax.plot(state.x, state.v, color="0.7", linewidth=0.7, zorder=0, label="motion over time")
    finish(ax)
    ax.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize=7.5)

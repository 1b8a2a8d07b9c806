"""Figures 2, 6, 7 and 10: the friction laws, and thresholds in the plane of belt speed and damping."""

from typing import Any

import numpy as np
import sympy as sp

from derivations import paper
from paper_checks.computed import LAWS, SPEEDS, law, oscillator, over_speeds, threshold, thresholds
from paper_checks.figure_motions import PAPER
from paper_checks.printed import PRINTED
from stickslip_sym import slope_average, symbols
from stickslip_sym.comparison.tradeoff import pure_slip_by_scan
from stickslip_sym.views.drawing import BLUE, GREEN, ORANGE, finish, new_figure, panel_letters

_HIGHEST = 6.0  # kg/s, the paper's axis
_SCANNED = (0.2, 0.4, 0.6, 0.8)  # m/s, on both sides of the speed at which the paper prints the number
_AROUND = 0.05  # kg/s about the exact threshold, scanned
_EXACT = {"color": BLUE, "linewidth": 3.6, "alpha": 0.55, "solid_capstyle": "butt", "zorder": 1.5}
_NUMBER = {"exponential": "(17)", "polynomial": "(18)"}
_PRINTED = {"exponential": "N2", "polynomial": "N3"}


def printed_criterion(name: str, mu_m: str = "0.2") -> Any:
    """Return the printed closed form (17) or (18) at the belt speeds of the figures."""
    formula = paper.equations()[_NUMBER[name]].xreplace(law(name, mu_m).point)
    return over_speeds(formula, name)


def stability_of_rest(name: str, mu_m: str = "0.2") -> Any:
    """Return the damping below which rest is unstable, Galvanetto and Bishop's criterion."""
    return -oscillator().N * law(name, mu_m).slope(SPEEDS)


def scanned(name: str, V: float) -> float:
    """Return the paper's numerical threshold: Newmark runs, here only near the exact one."""
    near = threshold(name, V)
    steps = np.arange(round((near - _AROUND) * 1000), round((near + _AROUND) * 1000)) / 1000
    return pure_slip_by_scan(law(name), oscillator(V=V), steps)


def friction_laws() -> Any:
    """Draw figure 2: both laws, and the straight line that the criterion puts in place of each."""
    figure, axes = new_figure(7.2, 2.9, 1, 2, sharey=True)
    v, V = np.linspace(0, 2, 401), 0.5
    fitted = np.linspace(0, 2 * V, 2)
    for ax, name in zip(axes[0], LAWS, strict=True):
        ax.plot(v, law(name).mu(v), **PAPER)
        a, b = (_coefficient(name, part, V) for part in ("a", "b"))
        ax.plot(fitted, b - a * fitted, color=BLUE, linestyle=(0, (6, 1.5, 1, 1.5)), linewidth=1.3)
        ax.axvspan(0, 2 * V, color=BLUE, alpha=0.07, linewidth=0)
        ax.text(0.53, 0.37, r"$b - a\,|v_r|$ of (8), (15)", color=BLUE, fontsize=8.5)
        words = "fitted to $0 \\leq |v_r| \\leq 2V$,\n$V$ = 0.5 m/s"
        ax.text(V, 0.03, words, color=BLUE, ha="center", fontsize=8.5)
        ax.set_yticks([0, 0.2, 0.5], ["0", r"$\mu_m$", r"$\mu_s$"])
        finish(ax, xlabel="$|v_r|$ (m/s)", xlim=(0, 2), ylim=(0, 0.62))
    axes[0, 1].plot([1, 1], [0, 0.2], color="black", linewidth=0.6, linestyle=":")
    axes[0, 1].annotate("$v_m$", (1, 0.2), xytext=(-4, 5), textcoords="offset points")
    axes[0, 0].set_ylabel(r"$\mu$ (–)")
    panel_letters(axes[0], ["exponential law (3)", "polynomial law (4)"])
    return figure


def _coefficient(name: str, part: str, V: float) -> float:
    """Return a or b of (15) for a law."""
    printed = paper.equations()[f"(15) {part}"].subs(symbols.V, sp.Rational(str(V)))
    mu = law(name).expr.xreplace(law(name).point)
    return float(printed.replace(symbols.mu, lambda speed: mu.subs(symbols.v, speed)).doit().evalf())


def plane(name: str) -> Any:
    """Draw figure 6 or 7: criteria, the exact threshold, and what there is between them."""
    figure, axes = new_figure(5.6, 6.6, 2, 1, sharex=True, gridspec_kw={"height_ratios": (3, 1.15)})
    top, bottom = axes[:, 0]
    exact, rest, printed = thresholds(name), stability_of_rest(name), printed_criterion(name)
    between(top, exact, rest)
    top.plot(SPEEDS, exact, **_EXACT, label="left out: exact threshold")
    top.plot(SPEEDS, printed, **PAPER, label=f"criterion {_NUMBER[name]}")
    top.plot(SPEEDS, rest, **PAPER, linestyle="--", label="Galvanetto & Bishop")
    bottom.axhline(0, **_EXACT)
    bottom.fill_between(SPEEDS, 0, printed - exact, color="0.85", linewidth=0)
    bottom.plot(SPEEDS, printed - exact, **PAPER)
    if name == "polynomial":
        harmonic = slope_average(law(name), "harmonic")(V=SPEEDS, N=oscillator().N)
        top.plot(SPEEDS, harmonic, **PAPER, linestyle=":", label="Thomsen & Fidlin")
        bottom.plot(SPEEDS, harmonic - exact, **PAPER, linestyle=":")
    runs = np.array([scanned(name, V) for V in _SCANNED])
    at = np.array([threshold(name, V) for V in _SCANNED])
    circles = {"linestyle": "none", "marker": "o", "color": "black", "markerfacecolor": "none"}
    top.plot(_SCANNED, runs, **circles, markersize=5.5, label="Newmark scan")
    bottom.plot(_SCANNED, runs - at, **circles, markersize=5.5)
    stated, V = float(PRINTED[_PRINTED[name]]["c"]), oscillator().V
    top.plot(V, stated, **circles | {"marker": "s"}, markersize=5.5, label=f"printed: {stated:g} kg/s")
    bottom.plot(V, stated - threshold(name, V), **circles | {"marker": "s"}, markersize=5.5)
    for letter, V in zip("AB" if name == "exponential" else "CD", (0.5, 0.8), strict=True):
        top.plot(V, 2, "k.", markersize=7)
        top.annotate(f"${letter}$", (V, 2), xytext=(4, 4), textcoords="offset points")
    top.legend(loc="upper right")
    top.text(0.16, 1.0, "stick–slip")
    top.text(0.83, 2.75, "damped slip")
    far = int(np.argmax(np.abs(rest - exact)))
    words = f"Galvanetto & Bishop off the scale: {rest[far] - exact[far]:+.2f} kg/s at {SPEEDS[far]:.2f} m/s"
    bottom.text(0.02, 0.06, words.replace("-", "−"), transform=bottom.transAxes, fontsize=8.5)
    finish(top, ylabel="$c$ (kg/s)", xlim=(0, 1), ylim=(0, _HIGHEST))
    finish(bottom, xlabel="$V$ (m/s)", ylabel="$c$ − exact (kg/s)", ylim=(-0.13, 0.13))
    panel_letters((top, bottom), ["thresholds", "left out: distance from the exact threshold"])
    return figure


def between(ax: Any, exact: Any, rest: Any, *, labelled: bool = True) -> None:
    """Hatch where rest and stick-slip coexist, and where a slip limit cycle is stable."""
    # Opaque: an SVG gives a hatch the opacity of its face.
    both = {"facecolor": "#fcf0e8", "edgecolor": ORANGE, "hatch": "////", "linewidth": 0}
    slips = {"facecolor": "#e8f6f1", "edgecolor": GREEN, "hatch": r"\\\\..", "linewidth": 0}
    lowest = np.maximum(exact, 0)
    for lower, upper, style, label in (
        (rest, exact, both, "left out: rest or stick–slip"),
        (lowest, rest, slips, "left out: slip cycle, no stick"),
    ):
        if (upper > lower).any():
            label = label if labelled else "_"
            ax.fill_between(SPEEDS, lower, upper, where=upper > lower, **style, label=label)


def several_minima() -> Any:
    """Draw figure 10: three values of mu_m for both laws."""
    figure, axes = new_figure(7.2, 3.6, 1, 2, sharey=True)
    for ax, name in zip(axes[0], LAWS, strict=True):
        for mu_m, style in (("0.2", "-"), ("0.3", "--"), ("0.4", ":")):
            exact, printed = thresholds(name, mu_m), printed_criterion(name, mu_m)
            last = mu_m == "0.4"
            ax.plot(SPEEDS, printed, **PAPER, linestyle=style, label=rf"$\mu_m$ = {mu_m}")
            ax.plot(SPEEDS, exact, **_EXACT, label="left out: exact threshold" if last else "_")
            between(ax, exact, stability_of_rest(name, mu_m), labelled=last)
        finish(ax, xlabel="$V$ (m/s)", xlim=(0, 1), ylim=(0, _HIGHEST))
        ax.legend(loc="upper right", handlelength=2.6)
    axes[0, 0].set_ylabel("$c$ (kg/s)")
    panel_letters(axes[0], ["exponential law", "polynomial law"])
    return figure

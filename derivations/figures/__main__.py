"""Draw the figures of the derivation: ``python -m derivations.figures`` writes them beside this file."""

from pathlib import Path

import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

import stickslip_sym as ss

FOLDER = Path(__file__).parent
COLOURS = {"equilibrium": "tab:orange", "least_squares": "tab:blue", "harmonic": "tab:green"}


def weights() -> Figure:
    """Draw what each criterion weighs the falling slope with."""
    figure = Figure(figsize=(6, 3), layout="constrained")
    ax = figure.subplots()
    s = np.linspace(-1, 1, 400)
    ax.plot(s, 5 / 8 * (1 - s**4), COLOURS["least_squares"], label="least squares, (5/8)(1 - s$^4$)")
    ax.plot(s, 2 / np.pi * np.sqrt(1 - s**2), COLOURS["harmonic"], label=r"harmonic, (2/$\pi$)(1 - s$^2$)$^{1/2}$")
    ax.axvline(0, color=COLOURS["equilibrium"], label="equilibrium, all at s = 0")
    ax.set(xlabel="s = (v - V)/V", ylabel="weight of the slope", ylim=(0, 0.75))
    ax.legend(loc="lower center")
    return figure


def criterion() -> Figure:
    """Draw (16), the criterion of the equilibrium and the exact threshold over the belt speed."""
    figure = Figure(figsize=(7, 3), layout="constrained")
    speeds = np.linspace(0.02, 1, 50)
    for ax, law in zip(figure.subplots(1, 2, sharey=True), (ss.laws.exponential, ss.laws.polynomial), strict=True):
        bound = law.typical()
        for name in ("equilibrium", "least_squares"):
            label = "(16)" if name == "least_squares" else name
            ax.plot(speeds, ss.slope_average(bound, name)(V=speeds, N=9.81), COLOURS[name], label=label)
        exact = [ss.pure_slip_damping(bound, V=V, N=9.81, m=1, k=100, method="orbit").value for V in speeds[::3]]
        ax.plot(speeds[::3], exact, "ko", markersize=3, label="exact threshold")
        ax.set(title=law.name, xlabel="V in m/s", ylim=(0, None))
        ax.grid(alpha=0.3)
    figure.axes[0].set_ylabel("c in kg/s")
    figure.axes[0].legend()
    return figure


if __name__ == "__main__":
    rcParams.update({"svg.hashsalt": "stickslip_sym", "svg.fonttype": "none"})
    for draw in (weights, criterion):
        draw().savefig(FOLDER / f"{draw.__name__}.svg", metadata={"Date": None})

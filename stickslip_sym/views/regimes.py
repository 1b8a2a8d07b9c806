"""What is shown of a regime: its motions in words, and the phase plane."""

from typing import TYPE_CHECKING, Any

from stickslip_sym.model.negative import note_at_rest
from stickslip_sym.motion.regimes.regime import Regime
from stickslip_sym.views import dispatch, markup
from stickslip_sym.views.drawing import picture

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes

_GRAZE, _BELT = "separatrix: orbit that touches the belt's speed", "belt speed"
_LOOKS: dict[str, dict[str, Any]] = {
    "stick-slip": {"color": "black", "linewidth": 2.2},
    "pure-slip cycle": {"color": "#009E73", "linewidth": 2.2},
    "pure-slip cycle, unstable": {"color": "#D55E00", "linewidth": 1.2, "linestyle": "--"},
    _GRAZE: {"color": "0.45", "linewidth": 1.2, "linestyle": "-."},
    _BELT: {"color": "black", "linewidth": 0.8, "linestyle": ":", "zorder": 0},
}


def _notes(regime: Regime) -> list[str]:
    """Return what is said besides the attractors."""
    words = list[str]()
    if not (regime.attractors or regime.misses_an_attractor):
        words.append("no attractor")
    if at_rest := note_at_rest(regime.law.bound, regime.oscillator.N):
        words.append(at_rest)
    if regime.unbounded:
        words.append("motions far out grow without bound: damping and friction feed them")
    return [*words, *(f"undecided: {text}" for text in regime.undecided)]


@dispatch.plain_text.register(Regime)
def regime_as_text(regime: Regime) -> str:
    """Return the attractors, and what is said besides, a line each."""
    return "\n".join([*map(str, regime.attractors), *_notes(regime)])


@dispatch.notebook_html.register(Regime)
def regime_as_html(regime: Regime) -> str:
    """Return the phase plane, a table of the motions, and what is said besides."""
    motions = [regime.rest, *regime.cycles, *([] if regime.stick_slip is None else [regime.stick_slip])]
    attracting = regime.attractors
    rows = [[str(motion), "attracts" if motion in attracting else "does not attract"] for motion in motions]
    table = markup.html_table(["motion", "neighbours"], rows, caption="motions")
    drawn = picture(regime.plot, "; ".join(row[0] for row in rows))
    return markup.block(drawn, table, *_notes(regime))


@dispatch.draw.register(Regime)
def draw_phase_plane(regime: Regime, ax: "Axes") -> "list[Artist]":
    """Draw the phase plane, and return the handles of its legend: one of several curves of a kind."""
    for name, x, v in regime.periodic_curves:
        ax.plot(x, v, label=name, **_LOOKS[name])
    for curve in regime.separatrices:
        if curve.kind == "graze":  # any other is drawn as the cycle that it is
            ax.plot(curve.x, curve.v, label=_GRAZE, **_LOOKS[_GRAZE])
    face, name = ("black", "rest") if regime.rest.stable else ("white", "rest, unstable")
    ax.plot([regime.rest.x], [0.0], "o", color="black", markerfacecolor=face, label=name)
    ax.axhline(regime.oscillator.V, label=_BELT, **_LOOKS[_BELT])
    ax.set(xlabel="displacement $x$ (m)", ylabel="velocity $\\dot x$ (m/s)")
    ax.locator_params(axis="x", nbins=6)
    ax.grid(alpha=0.25)
    handles, labels = ax.get_legend_handles_labels()
    return list(dict(zip(labels, handles, strict=True)).values())

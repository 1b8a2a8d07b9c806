"""The picture of a trade-off: error against time, a panel for each kind of number."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stickslip_sym.comparison.ways import Trade
from stickslip_sym.output import drawing
from stickslip_sym.output.tables import wrapped

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw"]

_WIDTH, _HEIGHT = 7.2, 3.5  # inches, of a panel
_LEAST = 1e-51  # error of a way whose own is less
_ROUNDING = 2.0**-52
_TITLE = 95  # characters of a line above a panel
_ROOM = 12  # times the longest time, for the labels to its right
_COLORS = ("tab:blue", "tab:red", "tab:green", "tab:purple", "tab:orange", "tab:brown", "tab:olive", "tab:cyan")


def draw(trades: Sequence[Trade[Any]]) -> "Figure":
    """Draw error against time: filled what no other way dominates, and hollow what one does.

    Raises `InputError` if matplotlib is not installed.
    """
    drawing.require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(_WIDTH, _HEIGHT * max(1, len(trades))), layout="constrained")
    for place, trade in enumerate(trades):
        _panel(figure.add_subplot(len(trades), 1, place + 1), trade)
    return figure


def _panel(axes: "Axes", trade: Trade[Any]) -> None:
    ways = [way for way in trade.ways if way.found]
    by = trade.dominators
    families = list(dict.fromkeys(_family(way.name) for way in trade.ways))
    labels, named = [], set()
    for way in ways:
        family = _family(way.name)
        color = _COLORS[families.index(family) % len(_COLORS)]
        place = way.seconds, max(way.error, _LEAST)
        axes.plot(*place, "o", color=color, markerfacecolor="white" if by[way.name] else color)
        labels.append((way.name.removeprefix(f"{family}, ") if family in named else way.name, place, color))
        named.add(family)
    front = sorted((way.seconds, max(way.error, _LEAST)) for way in ways if not by[way.name])
    axes.plot(
        *zip(*front, strict=True) if front else ((), ()), drawstyle="steps-post", color="0.75", lw=1, zorder=0
    )
    axes.set(xscale="log", yscale="log", xlabel=f"time for one {trade.number} (s)", ylabel="relative error")
    axes.set_title("\n".join(wrapped(trade.title, _TITLE)), fontsize=8)
    axes.margins(0.08, 0.12)
    left, right = axes.get_xlim()
    axes.set_xlim(left, right * _ROOM)
    axes.axhline(_ROUNDING, color="0.8", lw=0.8, ls=":", zorder=0)
    axes.minorticks_off()
    axes.grid(alpha=0.25)
    drawing.label(axes, labels)


def _family(name: str) -> str:
    return name.split(",")[0]

"""The style that the figures of pages share.

Colours are Okabe and Ito's, which colour-blind readers tell apart. Nothing is told by colour alone: lines differ
in style or width too, regions are hatched, and each is labelled.
"""

import base64
import io
from typing import Any

from stickslip_sym.core.errors import InputError

__all__ = [
    "BLUE",
    "GREEN",
    "ORANGE",
    "finish",
    "new_figure",
    "panel_letters",
    "styled",
    "svg",
    "svg_uri",
]

BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"
_STYLE: Any = {
    "font.family": "serif",
    "font.serif": ["STIXGeneral"],  # comes with matplotlib, so that every machine draws the same
    "mathtext.fontset": "stix",
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.linewidth": 0.7,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "hatch.linewidth": 0.5,
    "svg.fonttype": "path",
    "svg.hashsalt": "stickslip_sym",  # the same picture is the same file
}


def styled() -> Any:
    """Return the context in which figures are drawn and saved.

    Raises
    ------
    InputError
        If matplotlib is not installed.
    """
    try:
        from matplotlib import rc_context
    except ImportError:
        raise InputError("figures need matplotlib: pip install 'stickslip_sym[plot]'") from None
    return rc_context(_STYLE)


def new_figure(width: float, height: float, rows: int = 1, columns: int = 1, **layout: Any) -> tuple[Any, Any]:
    """Return a figure of a size in inches, and its array of axes."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **layout)


def finish(axes: Any, **labels: Any) -> None:
    """Label an axis pair; a name given as `x` or `y` has its unit in it."""
    axes.set(**labels)
    axes.grid(color="0.92", linewidth=0.5)
    axes.set_axisbelow(True)


def panel_letters(axes: Any, titles: list[str]) -> None:
    """Write (a), (b), ... and a title above each of several axes."""
    for letter, ax, title in zip("abcdefgh", axes, titles, strict=False):
        ax.set_title(f"({letter})  {title}", loc="left", pad=4)


def svg(figure: Any) -> bytes:
    """Return a figure as SVG, the same bytes for the same figure."""
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return stream.getvalue()


def svg_uri(figure: Any) -> str:
    """Return a figure as a data URI."""
    return f"data:image/svg+xml;base64,{base64.b64encode(svg(figure)).decode()}"

"""What every drawing needs: matplotlib, or a message without it; one style; the same file each time.

Colours are Okabe and Ito's, which colour-blind readers distinguish. Colour alone carries no meaning: lines
differ in style or width too, regions are hatched, and each is labelled.
"""

import io
from base64 import b64encode
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.output.files import write_text
from stickslip_sym.views.markup import Markup

if TYPE_CHECKING:
    from matplotlib.figure import Figure


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
    "svg.hashsalt": "stickslip_sym",  # the same picture is the same file
    "svg.fonttype": "path",  # a text looks the same, and is as wide, where the font is missing
    "pdf.fonttype": 42,  # TrueType, which journals ask for
}
_TIMELESS: Any = {
    "svg": {"Date": None, "Creator": None},
    "pdf": {"CreationDate": None},
    "png": {"Software": None},
}
"""What files would say of the time and the machine that made them."""
FIGURE_WIDTH, FIGURE_HEIGHT = 7.0, 4.7  # inches, of a figure as wide as a notebook's text
MOST_DRAWN = 3000  # points that are drawn each by itself: more take seconds, and are not seen


def require_matplotlib() -> None:
    """Refuse to draw without matplotlib."""
    try:
        import matplotlib.figure  # noqa: F401  # only to see that it is there, and whole
    except ImportError:
        raise InputError("plots need matplotlib: pip install matplotlib") from None


def styled(**more: Any) -> Any:
    """Return the context in which figures are drawn and saved, with more of matplotlib's parameters.

    Raises `InputError` if matplotlib is not installed.
    """
    require_matplotlib()
    from matplotlib import rc_context

    return rc_context(_STYLE | more)


def empty_figure(width: float = FIGURE_WIDTH, height: float = FIGURE_HEIGHT) -> Any:
    """Return a figure of a size in inches, without axes."""
    from stickslip_sym.views.notebook_figure import NotebookFigure

    return NotebookFigure(figsize=(width, height), layout="constrained")


def new_figure(
    width: float = FIGURE_WIDTH, height: float = FIGURE_HEIGHT, rows: int = 1, columns: int = 1, **layout: Any
) -> tuple[Any, Any]:
    """Return a figure of a size in inches, and its array of axes."""
    figure = empty_figure(width, height)
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


def _rendered(figure: "Figure", kind: str, dpi: int | str = 160) -> bytes:
    """Return a figure as the content of a file; the same bytes for the same figure."""
    stream = io.BytesIO()
    with styled():
        figure.savefig(stream, format=kind, dpi=dpi, metadata=_TIMELESS.get(kind))
    return stream.getvalue()


def svg_uri(figure: "Figure") -> str:
    """Return a figure as a data URI."""
    return f"data:image/svg+xml;base64,{b64encode(_rendered(figure, 'svg')).decode()}"


def picture(draw: "Callable[[], Figure]", alt: str) -> Markup:
    """Return a drawing as HTML that holds it; nothing where matplotlib is missing, or there is nothing to draw.

    - `draw`: it returns the figure; it is not called without matplotlib.
    - `alt`: what the picture shows, for those who do not see it.
    """
    try:
        require_matplotlib()
        figure = draw()
    except StickSlipError:
        return Markup("")
    content = b64encode(_rendered(figure, "png", "figure")).decode()
    return Markup(f'<img src="data:image/png;base64,{content}" alt="{escape(alt)}"/>')


def save_drawing(figure: "Figure", path: Path) -> None:
    """Write a drawing to a file, in the format of its name; refuse a format that matplotlib does not know."""
    if not path.suffix:
        path = path.with_suffix(".png")
    try:
        content = _rendered(figure, path.suffix.lower().removeprefix("."))
    except ValueError as error:
        name = f"{path.stem or 'picture'}.png"
        raise InputError(f"cannot draw to {path.name!r}: {error}; try a name such as {name}") from None
    write_text(path, content)

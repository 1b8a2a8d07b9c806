"""What every drawing needs: matplotlib, or a word that it is missing, and a file that is the same each time."""

import io
from abc import ABC, abstractmethod
from base64 import b64encode
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stickslip_sym.core.errors import InputError, StickSlipError
from stickslip_sym.output.files import require_name
from stickslip_sym.output.markup import Markup

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stickslip_sym.core.aliases import FloatArray

__all__ = ["Drawn", "dense", "label", "picture", "require_matplotlib", "save"]

_STYLE: Any = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "stickslip_sym",  # the same picture is the same file
    "hatch.linewidth": 0.6,
}
_DENSE = 8  # points drawn for each step of an integration
_INLINE = 90  # pixels an inch, of a picture among text
_POINT = 4  # half the width of a point, in pixels
_APART = 8  # pixels between labels that stand side by side
_NEAR = 12  # points of height up to which a label needs no line to what it names
_BESIDE = [
    (side * (8 if abs(up) <= 12 else 20), up)
    for up in (0, 7, -7, *(sign * up for up in range(20, 130, 12) for sign in (1, -1)))
    for side in (1, -1)
]
"""Places of a label, by preference: to the right and up from its point, in points."""


def require_matplotlib() -> None:
    """Refuse to draw without matplotlib."""
    try:
        import matplotlib.figure  # noqa: F401  # only to see that it is there, and whole
    except ImportError:
        raise InputError("plots need matplotlib: pip install 'stickslip_sym[plot]'") from None


class Drawn(ABC):
    """A result that has a picture."""

    @abstractmethod
    def _figure(self) -> "Figure":
        """Return its matplotlib.figure.Figure."""

    def plot(self, path: str | Path | None = None) -> "Figure":
        """Draw it: regions or basins told apart by colour and hatching, curves between them, orbits, or costs.

        Parameters
        ----------
        path : str or Path, optional
            A file to draw to: SVG, PNG or PDF, by its ending.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If matplotlib is not installed, or cannot write the file.
        """
        figure = self._figure()
        if path is not None:
            save(figure, Path(path))
        return figure


def label(axes: "Axes", labels: Sequence[tuple[str, tuple[float, float], str]]) -> None:
    """Write names beside points, each (name, place, colour), where none covers another or a point."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.text import Text
    from matplotlib.transforms import Bbox

    figure: Any = axes.figure
    renderer = FigureCanvasAgg(figure).get_renderer()  # type: ignore[no-untyped-call]
    figure.draw_without_rendering()
    points = [axes.transData.transform(place) for _, place, _ in labels]
    taken = [Bbox.from_bounds(x - _POINT, y - _POINT, 2 * _POINT, 2 * _POINT) for x, y in points]
    for name, place, color in labels:
        for right, up in _BESIDE:
            line = {"arrowstyle": "-", "color": color, "lw": 0.5, "relpos": (float(right < 0), 0.5)}
            text = axes.annotate(
                name, place, xytext=(right, up), textcoords="offset points", fontsize=8, color=color,
                ha="left" if right > 0 else "right", va="center",
                arrowprops=line if abs(up) > _NEAR else None,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )  # fmt: skip
            text.update_positions(renderer)
            box = Text.get_window_extent(text, renderer)  # that of an annotation has its line too
            inside = (
                axes.bbox.x0 < box.x0 and box.x1 < axes.bbox.x1 and axes.bbox.y0 < box.y0 and box.y1 < axes.bbox.y1
            )
            if inside and not any(map(box.overlaps, taken)):
                break
            text.remove()
        else:
            axes.add_artist(text)
        taken.append(box.padded(_APART, 0))


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
    from matplotlib import rc_context

    stream = io.BytesIO()
    with rc_context(_STYLE):
        figure.savefig(stream, format="png", dpi=_INLINE, metadata={"Software": None})
    content = b64encode(stream.getvalue()).decode()
    return Markup(f'<img src="data:image/png;base64,{content}" alt="{escape(alt)}"/>')


def dense(ends: "FloatArray") -> "FloatArray":
    """Return places between the ends of steps, dense enough for a smooth curve."""
    import numpy as np

    return np.interp(np.arange(_DENSE * (ends.size - 1) + 1) / _DENSE, np.arange(ends.size), ends)


def save(figure: "Figure", path: Path) -> None:
    """Write a drawing to a file, in the format of its name.

    Raises
    ------
    InputError
        If the file cannot be written, or matplotlib does not know its format.
    """
    require_name(path)
    from matplotlib import rc_context

    try:
        with rc_context(_STYLE):
            figure.savefig(path, dpi=160, metadata={"Date": None} if path.suffix == ".svg" else None)
    except (OSError, ValueError) as error:
        name = f"{path.stem or 'picture'}.png"
        raise InputError(f"cannot draw to {path.name!r}: {error}; try a name such as {name}") from None

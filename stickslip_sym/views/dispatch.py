"""The views, each a function that is chosen by the class of the result.

A result is a line and a text, HTML and LaTeX, a panel and a figure, as far as there are functions for its class.
"""

from collections.abc import Sequence
from functools import lru_cache, singledispatch
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip_sym.core.errors import InputError
from stickslip_sym.output import tables
from stickslip_sym.output.shown import HeadedRows
from stickslip_sym.views import markup
from stickslip_sym.views.drawing import new_figure, save_drawing, styled

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FOLDERS = {
    "model", "measured", "fitting",
    "formula",
    "simulation", "orbits", "regimes", "maps", "margins", "thresholds",
    "comparison",
}  # fmt: skip
"""Whose results have views: each has a module here of its name."""


@lru_cache
def load_views(cls: type) -> None:
    """Import the views of a class of results: those of the folder where it, or the class that it extends, is."""
    for base in cls.__mro__:
        folder = f".{base.__module__}".split(".")[-2]
        if folder in _FOLDERS:
            import_module(f"stickslip_sym.views.{folder}")
            return


# -- words ---------------------------------------------------------------------------------------------


@singledispatch
def parts(result: object) -> list[str | HeadedRows]:
    """Return sentences, and tables as a header and rows, in their order; of most results one sentence."""
    return [str(result)]


@singledispatch
def one_line(result: object) -> str:
    """Return a result in a line, for a terminal."""
    raise TypeError(f"there is no line for a {type(result).__name__}")


@singledispatch
def plain_text(result: object) -> str:
    """Return a result as text, its parts one below the other."""
    return "\n\n".join(part if isinstance(part, str) else tables.aligned_table(*part) for part in parts(result))


@singledispatch
def notebook_html(result: object) -> str:
    """Return a result as HTML, its parts one below the other."""
    return parts_as_html(result)


def parts_as_html(result: object) -> markup.Markup:
    """Return the parts of a result as HTML, one below the other."""
    shown = [part if isinstance(part, str) else markup.html_table(*part) for part in parts(result)]
    return markup.Markup(markup.block(*shown))


@singledispatch
def notebook_latex(result: object) -> str:
    """Return a result as LaTeX, for a notebook."""
    raise TypeError(f"there is no LaTeX for a {type(result).__name__}")


@singledispatch
def page(result: object) -> str:
    """Return the page of a result: HTML that stands alone."""
    raise TypeError(f"there is no page of a {type(result).__name__}")


@singledispatch
def print_page(result: object, path: Path) -> None:
    """Print the page of a result to a PDF file."""
    raise TypeError(f"there is no page of a {type(result).__name__}")


# -- pictures ------------------------------------------------------------------------------------------


@singledispatch
def draw(result: object, ax: "Axes") -> "Sequence[Artist]":
    """Draw a result as a panel, and return the handles of its legend."""
    raise InputError(f"{type(result).__name__} is drawn as a figure of several panels; leave ax out")


@singledispatch
def title(result: object) -> str:
    """Return the title of a panel in a figure of its own."""
    return ""


@singledispatch
def figure(result: object) -> "Figure":
    """Return a result as a figure of its own: as a rule one panel, with its legend below."""
    made, axes = new_figure()
    handles = draw(result, axes[0, 0])
    axes[0, 0].set_title(title(result), fontsize=10)
    made.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=8, handlelength=3, handleheight=1.6)
    return made  # type: ignore[no-any-return]


@singledispatch
def plot(result: object, path: str | Path | None, ax: "Axes | None") -> "Figure":
    """Draw a result, in a figure of its own or as a panel, and write the drawing to a file."""
    if ax is None:
        with styled():
            drawn = figure(result)
    else:
        ax.legend(handles=draw(result, ax), fontsize=8)
        drawn = ax.figure  # type: ignore[assignment]  # of a subfigure, that
    if path is not None:
        save_drawing(drawn, Path(path))
    return drawn

"""What every drawing needs: matplotlib, or a word that it is missing, and a file that anybody draws again."""

from pathlib import Path
from typing import Any

from stickslip_sym.errors import InputError

__all__ = ["require_matplotlib", "save"]

_STYLE: Any = {
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "stickslip_sym",  # the same picture is the same file
    "hatch.linewidth": 0.6,
}


def require_matplotlib() -> None:
    """Refuse to draw without matplotlib."""
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise InputError("plots need matplotlib: pip install 'stickslip_sym[plot]'") from None


def save(figure: Any, path: Path) -> None:
    """Write a drawing to a file, in the format of its name.

    Raises
    ------
    InputError
        If the file cannot be written, or matplotlib does not know its format.
    """
    from matplotlib import rc_context

    try:
        with rc_context(_STYLE):
            figure.savefig(path, dpi=160, metadata={"Date": None} if path.suffix == ".svg" else None)
    except (OSError, ValueError) as error:
        name = f"{path.stem or 'picture'}.png"
        raise InputError(f"cannot draw to {path.name!r}: {error}; try a name such as {name}") from None

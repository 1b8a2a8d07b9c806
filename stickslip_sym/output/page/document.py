"""The frame of a page: head, sections, tables that scroll by themselves, and what computed it."""

import platform
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from stickslip_sym.core.version import __version__
from stickslip_sym.output.page.elements import Html, element, raw

__all__ = ["colophon", "now", "page", "table", "versions"]

_STYLE = Path(__file__).with_name("page.css")
_PACKAGES = ("sympy", "mpmath", "numpy", "scipy", "matplotlib")


def page(title: str, top: Sequence[Html], sections: Sequence[Html], footer: Html, style: str = "") -> str:
    """Return a whole page: well-formed XML that is HTML too.

    - `top`: what stands before the main part: a header, contents.
    - `style`: a sheet of its own, after the one that all pages share.
    """
    sheet = _STYLE.read_text(encoding="utf-8") + style
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", title),
        element("link", rel="icon", href="data:,"),
        element("style", raw(sheet)),
    )
    body = element("body", *top, element("main", *sections), footer)
    return "<!DOCTYPE html>\n" + element("html", head, body, lang="en") + "\n"


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Html:
    """Return a table; a cell is text, or an element ``td`` or ``th``."""
    head = element("thead", element("tr", *(element("th", name, scope="col") for name in columns)))
    lines = [element("tr", *map(_cell, row)) for row in rows]
    return element("div", element("table", head, element("tbody", *lines)), class_="scroll")


def _cell(content: str) -> Html:
    if isinstance(content, Html) and content.startswith(("<td", "<th")):
        return content
    return element("td", content)


def versions(*more: str) -> dict[str, str]:
    """Return what computes here: Python, packages and more of them, as far as they are installed, the machine."""
    found = {"python": platform.python_version(), "stickslip_sym": __version__}
    for name in (*_PACKAGES, *more):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found | {"platform": platform.platform(), "machine": platform.machine()}


def now() -> str:
    """Return the time as pages tell it."""
    return datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")


def colophon(time: str, versions: Mapping[str, str]) -> Html:
    """Return the footer that says when a page was computed, and by what."""
    words = "; ".join(f"{name} {text}" for name, text in versions.items())
    return element("footer", element("p", f"Computed {time} by {words}."), id="versions")

"""Results as HTML for notebooks. Text is escaped and never typeset; formulas are LaTeX for the notebook to set."""

from collections.abc import Sequence
from html import escape
from typing import TypeVar

__all__ = ["Markup", "block", "formula", "shortened", "table"]

_PLAIN = 'class="mathjax_ignore tex2jax_ignore"'  # a dollar sign in a name starts no formula
_LONGEST = 4000  # characters of a formula
_ENDS = 5  # items that are shown at either end of a long list


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def formula(latex: str) -> Markup:
    """Return LaTeX as a formula in a line of text; of one that fills a page, its length."""
    if len(latex) > _LONGEST:
        return Markup(f"<i>a formula of {len(latex)} characters of LaTeX</i>")
    return Markup(f"<span>${escape(latex)}$</span>")


def block(*parts: str) -> str:
    """Return paragraphs and tables, one below the other."""
    inner = "".join(part if isinstance(part, Markup) else f"<p {_PLAIN}>{escape(part)}</p>" for part in parts)
    return f"<div>{inner}</div>"


def table(header: Sequence[str], rows: Sequence[Sequence[str]], *, caption: str = "") -> Markup:
    """Return rows under a header as a table; cells are plain text, or `Markup`."""
    title = f"<caption {_PLAIN}>{escape(caption)}</caption>" if caption else ""
    head = "".join(f"<th>{escape(name)}</th>" for name in header)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    return Markup(f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")


def _cell(text: str) -> str:
    return f"<td>{text}</td>" if isinstance(text, Markup) else f"<td {_PLAIN}>{escape(text)}</td>"


Item = TypeVar("Item")


def shortened(rows: Sequence[Item]) -> list[Item | None]:
    """Return the rows, or the first and the last of many with a None between that stands for the rest."""
    if len(rows) <= 2 * _ENDS + 1:
        return list(rows)
    return [*rows[:_ENDS], None, *rows[-_ENDS:]]

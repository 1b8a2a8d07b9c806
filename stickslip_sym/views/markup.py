"""HTML from Python, all text escaped: elements of pages, and results for notebooks.

Formulas of results are LaTeX for the notebook to set; other text of theirs is never typeset.
"""

import re
from collections.abc import Sequence
from html import escape
from typing import TypeVar

from stickslip_sym.core.foreign import printable
from stickslip_sym.output.tables import MOST_FORMULA_CHARACTERS

_PLAIN = 'class="mathjax_ignore tex2jax_ignore"'  # a dollar sign in a name starts no formula
ENDS = 5  # items that are shown at either end of a long list
_SUBSCRIPT = re.compile(r"\b(mu|[a-zA-Z])_([a-zA-Z]|max|min|\d+)\b")
_POWER = re.compile(r"(?:\*\*|\^)(-?[\d.]*\d)")
_MINUS = re.compile(r"(?<![\w.])-(?=[\w(.<])|(?<= )-(?= )")
_WORD = re.compile(r"\b(mu|alpha|eta|oo)\b")
_LETTERS = {"mu": "μ", "alpha": "α", "eta": "η", "oo": "∞"}
_SIGNS = {"<=": "≤", ">=": "≥", "->": "→", "x''": "ẍ", "x'": "ẋ"}


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()

    def __html__(self) -> str:
        """Return it as it is: templates ask for this before they escape."""
        return self


def escaped(text: str, *, quote: bool = False) -> str:
    """Return text as it stands in markup; what is no character of XML becomes a replacement character."""
    return escape(printable(text, lines=True), quote=quote)


def element(tag: str, /, *children: str, **attributes: str) -> Markup:
    """Return an element; an attribute may end in an underscore, and inside it stands for a hyphen."""
    named = {name.removesuffix("_").replace("_", "-"): value for name, value in attributes.items()}
    written = "".join(f' {name}="{escaped(value, quote=True)}"' for name, value in named.items())
    inside = "".join(child if isinstance(child, Markup) else escaped(child) for child in children)
    return Markup(f"<{tag}{written}>{inside}</{tag}>")


def marked_prose(text: str) -> Markup:
    """Return a sentence with its plain-text mathematics as a reader expects it: indices, dots, signs."""
    for plain, sign in _SIGNS.items():
        text = text.replace(plain, sign)

    def index(match: re.Match[str]) -> str:
        return f"<i>{_LETTERS.get(match[1], match[1])}</i><sub>{match[2]}</sub>"

    marked = _SUBSCRIPT.sub(index, escaped(text))
    marked = _POWER.sub(lambda match: f"<sup>{match[1]}</sup>", marked).replace("*", "\u2009")
    marked = _MINUS.sub("−", marked)
    return Markup(_WORD.sub(lambda match: f"<i>{_LETTERS[match[1]]}</i>", marked))


def inline_formula(latex: str) -> Markup:
    """Return LaTeX as a formula in a line of text; of one that fills a page, its length."""
    if len(latex) > MOST_FORMULA_CHARACTERS:
        return Markup(f"<i>a formula of {len(latex)} characters of LaTeX</i>")
    return Markup(f"<span>${escape(latex)}$</span>")


def block(*parts: str) -> str:
    """Return paragraphs and tables, one below the other."""
    inner = "".join(part if isinstance(part, Markup) else f"<p {_PLAIN}>{escaped(part)}</p>" for part in parts)
    return f"<div>{inner}</div>"


def html_table(header: Sequence[str], rows: Sequence[Sequence[str]], *, caption: str = "") -> Markup:
    """Return rows under a header as a table; cells are plain text, or `Markup`."""
    title = ""
    if caption:
        title = f"<caption {_PLAIN}>{escaped(caption)}</caption>"
    head = "".join(f"<th>{escaped(name)}</th>" for name in header)
    body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in rows)
    return Markup(f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")


def _cell(text: str) -> str:
    if isinstance(text, Markup):
        return f"<td>{text}</td>"
    return f"<td {_PLAIN}>{escaped(text)}</td>"


Item = TypeVar("Item")


def shortened(rows: Sequence[Item]) -> list[Item | None]:
    """Return the rows, or the first and the last of many with a None between that stands for the rest."""
    if len(rows) <= 2 * ENDS + 1:
        return list(rows)
    return [*rows[:ENDS], None, *rows[-ENDS:]]

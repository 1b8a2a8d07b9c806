"""HTML from Python, all text escaped: `element` takes texts and elements, and returns an element."""

import re
from html import escape

__all__ = ["Html", "element", "escaped", "prose", "raw"]

_NO_CHARACTER = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML takes for no character: controls, and halves of pairs, as in names of files that are not UTF-8."""
_EMPTY = frozenset({"img", "meta", "br", "link"})
_SUBSCRIPT = re.compile(r"\b(mu|[a-zA-Z])_([a-zA-Z]|max|min|\d+)\b")
_POWER = re.compile(r"(?:\*\*|\^)(-?[\d.]*\d)")
_MINUS = re.compile(r"(?<![\w.])-(?=[\w(.<])|(?<= )-(?= )")
_WORD = re.compile(r"\b(mu|alpha|eta|oo)\b")
_LETTERS = {"mu": "μ", "alpha": "α", "eta": "η", "oo": "∞"}
_SIGNS = {"<=": "≤", ">=": "≥", "->": "→", "x''": "ẍ", "x'": "ẋ"}


class Html(str):
    """Text that is markup already."""

    def __html__(self) -> str:
        """Return it as it is: templates ask for this before they escape."""
        return self


def raw(markup: str) -> Html:
    """Mark text as markup."""
    return Html(markup)


def escaped(text: str, *, quote: bool = False) -> str:
    """Return text as it stands in markup; what is no character of XML becomes a replacement character."""
    return escape(_NO_CHARACTER.sub("\ufffd", text), quote=quote)


def element(tag: str, /, *children: str, **attributes: str) -> Html:
    """Return an element; an attribute may end in an underscore, and inside it stands for a hyphen."""
    named = {name.removesuffix("_").replace("_", "-"): value for name, value in attributes.items()}
    written = "".join(f' {name}="{escaped(value, quote=True)}"' for name, value in named.items())
    if tag in _EMPTY:
        return Html(f"<{tag}{written}/>")
    inside = "".join(child if isinstance(child, Html) else escaped(child) for child in children)
    return Html(f"<{tag}{written}>{inside}</{tag}>")


def prose(text: str) -> Html:
    """Return a sentence with its plain-text mathematics as a reader expects it: indices, dots, signs."""
    for plain, sign in _SIGNS.items():
        text = text.replace(plain, sign)

    def index(match: re.Match[str]) -> str:
        return f"<i>{_LETTERS.get(match[1], match[1])}</i><sub>{match[2]}</sub>"

    marked = _SUBSCRIPT.sub(index, escaped(text))
    marked = _POWER.sub(lambda match: f"<sup>{match[1]}</sup>", marked).replace("*", "\u2009")
    marked = _MINUS.sub("−", marked)
    return Html(_WORD.sub(lambda match: f"<i>{_LETTERS[match[1]]}</i>", marked))

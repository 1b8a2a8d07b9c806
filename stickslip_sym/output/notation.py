r"""How symbols are written in LaTeX: ``mu_s`` is ``\mu_{\mathrm{s}}``, unless the user wants it otherwise.

Subscripts that are letters describe, so they stand upright; subscripts that are numbers count. What a user
gives instead goes into the document as it is if it reads as one symbol; its commands are the user's business.
"""

import re
from collections.abc import Iterable

from stickslip_sym.core.aliases import Notation
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.names import suggestion

_GREEK = frozenset(
    {
        "alpha", "beta", "gamma", "delta", "epsilon", "varepsilon", "zeta", "eta", "theta", "vartheta", "iota",
        "kappa", "lambda", "mu", "nu", "xi", "pi", "varpi", "rho", "varrho", "sigma", "varsigma", "tau", "upsilon",
        "phi", "varphi", "chi", "psi", "omega",
        "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega",
    }
)  # fmt: skip
_SPELLED = {"lamda": "lambda", "Lamda": "Lambda"}  # lambda is a word of Python
_PARTS = re.compile(r"([A-Za-z]+?)_?(\d*)")
_FOREIGN = re.compile(r"[^A-Za-z0-9\\{}_^ ,;!'*+-]")
_SCRIPT = r"\s*(?:@|\\[A-Za-z]+|[A-Za-z0-9*'+-])"
_ONE = re.compile(
    rf"\s*(?:\\Delta(?![A-Za-z])\s*)?(?:[A-Za-z]|\\[A-Za-z]+\s*@?)\s*(?:(?:_{_SCRIPT})?\s*(?:\^{_SCRIPT}|'+)?|"
    rf"(?:\^{_SCRIPT}|'+)\s*_{_SCRIPT})(?:\s|\\[,!;])*"
)
"""A letter, or a command with its argument, its scripts, and the change of it; @ is what stands in braces."""
_OTHERWISE = re.compile(r"\^[{\s]*[+-]?\s*[0-9]|(?<![_^])(?<!\\text)\{(?:\s*[0-9]|[^{}]*[*+-])")
"""A power, a number or a sum that would be taken for one."""
_MOST_NOTATION_CHARACTERS = 60


def latex_name(name: str) -> str:
    r"""Return the LaTeX of a symbol's name, e.g. ``v_{\mathrm{m}}`` for ``v_m`` and ``a_{1}`` for ``a1``."""
    head, *subscripts = (part for part in name.split("_") if part)
    match = _PARTS.fullmatch(head)
    if match and match[2]:
        head = match[1]
        subscripts = [match[2], *subscripts]
    written = [part if part.isdigit() else f"\\mathrm{{{part}}}" for part in subscripts]
    return _base(head) + (f"_{{{','.join(written)}}}" if written else "")


def _base(word: str) -> str:
    word = _SPELLED.get(word, word)
    if word in _GREEK:
        return f"\\{word}"
    return word if len(word) == 1 else f"\\mathit{{{word}}}"


def notation_of(names: Iterable[str], given: Notation | None = None) -> dict[str, str]:
    """Return the LaTeX of each name, what is given in its place; refuse two symbols that would look the same."""
    names = set(names)
    given = given or {}
    chosen = {name: given[name] for name in sorted(names) if given.get(name) is not None}
    for name, latex in chosen.items():
        _check(name, latex)
    notation = distinct_notation(names - set(chosen), {}) | chosen
    looks: dict[str, str] = {}
    for name, latex in sorted(notation.items()):
        other = looks.setdefault(look(latex), name)
        if other != name:
            raise InputError(
                f"{other} and {name} would both be printed as {latex!r}; choose another symbol for one"
            )
    return notation


def distinct_notation(names: Iterable[str], known: Notation) -> dict[str, str]:
    """Return the LaTeX of each name: what is known, and for others what looks like none of the rest."""
    notation = dict(known)
    for name in sorted(set(names) - set(known)):
        latex = latex_name(name)
        notation[name] = _spelled_out(name) if look(latex) in set(map(look, notation.values())) else latex
    return notation


def _spelled_out(name: str) -> str:
    return f"\\mathit{{{name}}}".replace("_", r"\_")


def check_known(given: Notation, names: Iterable[str]) -> None:
    """Refuse notation for a symbol that does not occur."""
    known = list(dict.fromkeys(names))
    for name in given:
        if name not in known:
            raise InputError(
                f"there is no symbol {name[:40]!r} to print otherwise{suggestion(name, known)}; "
                f"there are: {', '.join(known)}"
            )


def _check(name: str, latex: str) -> None:
    """Refuse LaTeX that does not read as one symbol."""
    inner = latex if isinstance(latex, str) else ""
    while (outline := _outline(inner)).strip() == "@":
        inner = inner.strip()[1:-1]
    reads_otherwise = _OTHERWISE.search(inner) or _FOREIGN.search(inner)
    if len(inner) > _MOST_NOTATION_CHARACTERS or reads_otherwise or not _ONE.fullmatch(outline):
        raise InputError(
            f"the LaTeX of {name}, {latex!r}, is not one symbol in at most {_MOST_NOTATION_CHARACTERS} "
            "characters, but a product, a sum, a number, or something else; put several letters into "
            r"\mathit{...}; write a symbol such as v_b, \beta or v_{\mathrm{belt}}"
        )


def _outline(latex: str) -> str:
    """Return LaTeX with @ for what stands in braces."""
    while (shorter := re.sub(r"\{[^{}]*\}", "@", latex)) != latex:
        latex = shorter
    return latex


def look(latex: str) -> str:
    """Return what two symbols that look alike have in common."""
    return re.sub(r"\\mathrm|\\operatorname|\\text(?![a-z])|[{} ]", "", latex)

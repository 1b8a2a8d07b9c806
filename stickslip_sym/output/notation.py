r"""How symbols are written in LaTeX: ``mu_s`` is ``\mu_{\mathrm{s}}``, unless the user wants it otherwise.

Subscripts that are letters describe, so they stand upright; subscripts that are numbers count. What a user
gives instead goes into the document as it is, so only commands that print a symbol may stand in it.
"""

import re
from collections.abc import Iterable, Iterator, Mapping

from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import suggestion

__all__ = ["check_known", "latex_name", "look", "notation_of", "told_apart"]

_GREEK = frozenset(
    {
        "alpha", "beta", "gamma", "delta", "epsilon", "varepsilon", "zeta", "eta", "theta", "vartheta", "iota",
        "kappa", "lambda", "mu", "nu", "xi", "pi", "varpi", "rho", "varrho", "sigma", "varsigma", "tau", "upsilon",
        "phi", "varphi", "chi", "psi", "omega",
        "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi", "Psi", "Omega",
    }
)  # fmt: skip
_SPELLED = {"lamda": "lambda", "Lamda": "Lambda"}  # lambda is a word of Python
_SIGNS = frozenset(
    {
        "ell", "hbar", "star", "ast", "prime", "circ", "dagger", "perp", "parallel", "infty", ",", "!", ";",
    }
)  # fmt: skip
_WORDS = frozenset({"text", "operatorname"})  # no mathematics stands in these
_ALPHABETS = frozenset({"mathrm", "mathit", "mathbf", "mathsf", "mathcal", "boldsymbol"})
_STYLES = _WORDS | _ALPHABETS | {
    "hat", "widehat", "tilde", "widetilde", "bar", "overline", "underline", "vec", "dot", "ddot",
}  # fmt: skip
"""Commands of amsmath that take an argument."""
_COMMAND = re.compile(r"\\([A-Za-z]+|.|$)", re.S)
_FOREIGN = re.compile(r"[^A-Za-z0-9\\{}_^ ,;!'*+-]")
_PARTS = re.compile(r"([A-Za-z]+?)_?(\d*)")
_GROUP = re.compile(r"\{[^{}]")
_WORD = re.compile(r"\{[A-Za-z0-9 -]+\}")
_NO_SCRIPT = re.compile(r"[_^]\s*([_^'@]|$)|^\s*[_^']")
_LETTER = rf"[A-Za-z]|\\(?:{'|'.join(sorted(_GREEK | {'ell', 'hbar'}))})(?![A-Za-z])"
_MARK = r"\s|'|\\[,!;]|_\s*[A-Za-z0-9*'+-]|\^\s*[A-Za-z*'+-]|[_^]\s*\\[A-Za-z]+"
_ONE = re.compile(rf"\s*(?:\\Delta(?![A-Za-z])\s*)?(?:{_LETTER})(?:{_MARK})*")
"""A letter with its scripts, and the change of it."""
_LONGEST = 60


def latex_name(name: str) -> str:
    r"""Return the LaTeX of a symbol's name, e.g. ``v_{\mathrm{m}}`` for ``v_m`` and ``a_{1}`` for ``a1``."""
    head, *subscripts = (part for part in name.split("_") if part)
    match = _PARTS.fullmatch(head)
    if match and match[2]:
        head, subscripts = match[1], [match[2], *subscripts]
    written = [part if part.isdigit() else f"\\mathrm{{{part}}}" for part in subscripts]
    return _base(head) + (f"_{{{','.join(written)}}}" if written else "")


def _base(word: str) -> str:
    word = _SPELLED.get(word, word)
    if word in _GREEK:
        return f"\\{word}"
    return word if len(word) == 1 else f"\\mathit{{{word}}}"


def notation_of(names: Iterable[str], given: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return the LaTeX of each name, with what is given put in place.

    Raises
    ------
    InputError
        For LaTeX that may not be used, or two symbols that would look the same.
    """
    given = {name: latex for name, latex in (given or {}).items() if latex is not None}
    found: dict[str, str] = {}
    looks: dict[str, str] = {}
    for name in sorted(set(names)):
        if name in given:
            latex = given[name]
            _check(name, latex)
        else:
            latex = latex_name(name)
            if look(latex) in looks and looks[look(latex)] not in given:  # a1 beside a_1
                latex = _spelled_out(name)
        other = looks.setdefault(look(latex), name)
        if other != name:
            raise InputError(
                f"{other} and {name} would both be printed as {latex!r}; choose another symbol for one"
            )
        found[name] = latex
    return found


def told_apart(names: Iterable[str], known: Mapping[str, str]) -> dict[str, str]:
    """Return the LaTeX of each name: what is known, and for others what looks like none of the rest."""
    found = dict(known)
    for name in sorted(set(names) - set(known)):
        latex = latex_name(name)
        found[name] = _spelled_out(name) if look(latex) in set(map(look, found.values())) else latex
    return found


def _spelled_out(name: str) -> str:
    return f"\\mathit{{{name}}}".replace("_", r"\_")


def check_known(given: Mapping[str, str], names: Iterable[str]) -> None:
    """Refuse notation for a symbol that does not occur.

    Raises
    ------
    InputError
        With the closest name.
    """
    known = list(dict.fromkeys(names))
    for name in given:
        if name not in known:
            raise InputError(
                f"there is no symbol {name[:40]!r} to print otherwise{suggestion(name, known)}; "
                f"there are: {', '.join(known)}"
            )


def _check(name: str, latex: str) -> None:
    r"""Refuse LaTeX that is no symbol, or that could do more than print one.

    Raises
    ------
    InputError
        With what cannot be used, and examples of what can.
    """
    example = r"write a symbol such as v_b, \beta or v_{\mathrm{belt}}"
    if not isinstance(latex, str) or not latex.strip() or len(latex) > _LONGEST:
        raise InputError(f"the LaTeX of {name} is a text of 1 to {_LONGEST} characters; {example}")
    if foreign := _FOREIGN.search(latex):
        raise InputError(f"the LaTeX of {name}, {latex!r}, has the character {foreign[0]!r}; {example}")
    for command in _COMMAND.findall(latex):
        if command not in _GREEK | _SIGNS | _STYLES:
            raise InputError(
                f"the LaTeX of {name} has the command \\{command}, which prints no symbol with amsmath; {example}"
            )
    depth = 0
    for character in latex:
        depth += (character == "{") - (character == "}")
        if depth < 0:
            break
    if depth:
        raise InputError(f"the braces of the LaTeX of {name}, {latex!r}, do not match; {example}")
    for found in _COMMAND.finditer(latex):
        if found[1] in _STYLES and not (_WORD if found[1] in _WORDS else _GROUP).match(latex, found.end()):
            raise InputError(f"{found[0]} in the LaTeX of {name} needs its argument in braces; {example}")
    for level in _levels(latex):
        superscripts = level.count("^") + ("'" in level)
        if level.count("_") > 1 or superscripts > 1 or _NO_SCRIPT.search(level):
            raise InputError(
                f"the LaTeX of {name}, {latex!r}, has a subscript or superscript of nothing, or two of them, "
                f"or one without its braces; {example}"
            )
    if not _is_one_symbol(latex):
        raise InputError(
            f"the LaTeX of {name}, {latex!r}, reads as a product, a sum or a number, not as one symbol; "
            f"put several letters into \\mathit{{...}}; {example}"
        )


def _levels(latex: str) -> Iterator[str]:
    """Yield what stands in each pair of braces, and around them all, with a letter for each inner pair."""
    plain = re.sub(r"\\([A-Za-z]+|.)", lambda found: "@" if found[1] in _STYLES else "x", latex)
    while inner := re.search(r"\{([^{}]*)\}", plain):
        yield inner[1]
        plain = f"{plain[: inner.start()]}x{plain[inner.end() :]}"
    yield plain


def _is_one_symbol(latex: str) -> bool:
    r"""Tell whether LaTeX is a letter or a word with scripts and accents, or the change of one like \Delta v."""
    while inner := re.search(r"(\\[A-Za-z]+|[_^])?\s*\{([^{}]*)\}", latex):
        before, content = inner[1] or "", inner[2]
        if before in ("_", "^"):
            # An exponent that is a number would be taken for a power.
            shorter = f"{before}{'2' if re.match(r'[ +-]*[0-9]', content) else 'x'} "
        elif before[1:] in _ALPHABETS | _WORDS:
            # Words need a letter in front, and no sign but a hyphen where it is not a minus.
            word = r"[A-Za-z][A-Za-z0-9 -]*" if before == r"\text" else r"[A-Za-z][A-Za-z0-9 ]*"
            if not re.fullmatch(word, content) and not _ONE.fullmatch(content):
                return False
            shorter = " x"
        else:  # braces are not seen; an accent covers all that it stands over
            shorter = " x" if before[1:] in _STYLES else f"{before} {content}"
        latex = latex[: inner.start()] + shorter + latex[inner.end() :]
    return bool(_ONE.fullmatch(latex))


def look(latex: str) -> str:
    """Return what two symbols that look alike have in common."""
    return re.sub(r"\\mathrm|\\operatorname|\\text(?![a-z])|[{} ]", "", latex)

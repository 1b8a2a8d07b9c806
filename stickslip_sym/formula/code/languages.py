"""The table of languages; each is imported when it is first asked for, as the command line shows this table."""

from importlib import import_module
from typing import TYPE_CHECKING

from stickslip_sym.core.numbers import lookup

if TYPE_CHECKING:
    from stickslip_sym.formula.code.language import Language

__all__ = ["DESCRIPTIONS", "LANGUAGES", "find"]

DESCRIPTIONS = {
    "python": "A NumPy module.",
    "c": "C99; it needs libm only.",
    "octave": "Octave or MATLAB.",
}
"""What a file in each language is, by the name of its module here."""

LANGUAGES: "dict[str, Language]" = {}
"""Languages that are loaded; one that is put here, with a description, is known by its name from then on."""


def find(name: str) -> "Language":
    """Return a language by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    lookup("language", name, DESCRIPTIONS)
    if name not in LANGUAGES:
        LANGUAGES[name] = import_module(f"stickslip_sym.formula.code.{name}").language
    return LANGUAGES[name]

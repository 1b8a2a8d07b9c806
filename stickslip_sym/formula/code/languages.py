"""The languages that criteria are written in: what each supplies, and the table of them.

One more language is one file here that supplies what `Language` says, and its line in `DESCRIPTIONS`. Nothing slow
is imported before a language is asked for: the command line shows the table in its help.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Protocol, cast

from stickslip_sym.core.errors import InputError

if TYPE_CHECKING:
    from stickslip_sym.core.aliases import FloatArray
    from stickslip_sym.formula.code import c, octave, python
    from stickslip_sym.formula.code.dialect import Dialect

__all__ = ["DESCRIPTIONS", "Language", "find", "register"]

DESCRIPTIONS = {
    "python": "A NumPy module.",
    "c": "C99; it needs libm only.",
    "octave": "An Octave script.",
}
"""What a file in each language is, by the name of its module here."""

_registered: dict[str, "Language"] = {}


Branch = tuple[float, str, str, str]
"""The r from which it holds, definitions before the function, the lines that compute g, and the term's product."""


class Language(Protocol):
    """What a module, or an object, supplies so that criteria are written in a language.

    All is text. Names that begin with an underscore belong to one criterion, and `damping` is renamed where
    several are written. Texts that compute something leave it in `result`, or are
    it, as its own `term` wants.

    Attributes
    ----------
    dialect : Dialect
        How an expression is written, and which names are taken.
    exp, log, sqrt : str
        The functions.
    one : str
        The number 1 in the shape of the arguments.
    brackets : str
        The two that enclose a list of numbers.
    line : str
        The definition of a local number, with {name} and {value}, which may go over several lines.
    """

    dialect: "Dialect"
    exp: str
    log: str
    sqrt: str
    one: str
    brackets: str
    line: str

    def head(self, title: str, products: bool) -> str:
        """Return what stands first, with the functions that `product` calls if they are needed."""

    def product(self, number: str, factors: list[tuple[str, float]], rest: str) -> str:
        """Return number * rest * product of powers of bases, computed so that nothing overflows on the way."""

    def table(self, name: str, rows: "FloatArray") -> str:
        """Return an array of the coefficients of all panels, and a function NAME_at(r, first) for g."""

    def term(
        self, number: int, arguments: list[str], ratio: str, branches: list[tuple[float, str, str, str]]
    ) -> str:
        """Return the function of one term.

        `ratio` is the product that r is.
        """

    def function(self, name: str, arguments: list[str], text: str) -> str:
        """Return a function of numbers, or of arrays, with an expression for its value."""

    def steps(self, places_and_heights: list[tuple[str, str]], weight: str) -> str:
        """Return the lines that add what the jumps of mu contribute to the average."""

    def average(
        self, arguments: list[str], scales: list[str], kinks: list[str], weight: str, rules: list[tuple[str, str]],
        nodes: tuple[int, int], first_panel: float, most_halvings: int, steps: str,
    ) -> str:  # fmt: skip
        """Return the adaptive average of the slope over panels, halved until two Gauss rules agree."""

    def total(self, public: list[str], arguments: list[str], terms: int | None) -> str:
        """Return the function `damping` itself: the sum of so many terms, or the average where that is None."""


if TYPE_CHECKING:
    _checked: tuple[Language, ...] = c, octave, python


def register(name: str, language: Language, description: str) -> None:
    """Add a language from outside: `export_code` and the command ``export --NAME`` know it from then on.

    Raises
    ------
    InputError
        If there is one of that name, or the name is no word.
    """
    if name in DESCRIPTIONS or not name.isidentifier():
        raise InputError(f"{name!r} cannot be the name of a language; give another word than {[*DESCRIPTIONS]}")
    DESCRIPTIONS[name], _registered[name] = description, language


def find(name: str) -> Language:
    """Return a language by its name.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    from stickslip_sym.core.numbers import lookup

    lookup("language", name, DESCRIPTIONS)
    if name not in _registered:
        _registered[name] = cast(Language, import_module(f"stickslip_sym.formula.code.{name}"))
    return _registered[name]

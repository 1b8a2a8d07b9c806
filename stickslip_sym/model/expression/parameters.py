"""`Parameter`: a named number of a friction law, with its meaning, unit and typical value."""

import keyword
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.foreign import printable
from stickslip_sym.core.numbers import fraction, require_type
from stickslip_sym.core.remedies import Argument
from stickslip_sym.model.expression.dimensions import parse_unit
from stickslip_sym.model.expression.parsing import NAME, taken

_ARGUMENTS = frozenset({"self", "digits", "on_invalid"})


@dataclass(frozen=True)
class Parameter:
    """A parameter of a friction law.

    Attributes
    ----------
    name : str
        A letter, then letters, digits or underscores.
    meaning : str
        What it is, in a few words.
    unit : str, optional
        SI unit as text, "1" for a pure number.
    typical : str, optional
        A value to try the law with, as decimal text (kept exact).
    positive : bool
        Whether the parameter is never negative. Formulas are simplified under this assumption, so
        values that break it are refused.
    """

    name: str
    meaning: str = ""
    unit: str | None = None
    typical: str | None = None
    positive: bool = True

    def __post_init__(self) -> None:
        _check_name(self.name)
        require_type("meaning", self.meaning, str, "text")
        object.__setattr__(self, "meaning", printable(self.meaning))
        require_type("typical", self.typical, str | None, "decimal text")
        require_type("positive", self.positive, bool, "True or False")
        if self.unit is not None:
            parse_unit(self.unit)
        if self.typical is not None and fraction(self.typical, self.name) < 0 and self.positive:
            raise InputError(
                f"the typical value {self.typical} of {self.name!r} is negative, but the parameter is declared "
                "positive; if any sign is meant, declare it with ",
                Argument("positive", False),
            )

    @cached_property
    def symbol(self) -> Expr:
        """The parameter in an expression."""
        if self.positive:
            return sp.Symbol(self.name, positive=True)
        return sp.Symbol(self.name, real=True)


def _check_name(name: str) -> None:
    require_type("the name of a parameter", name, str, "text")
    if not NAME.fullmatch(name) or keyword.iskeyword(name):
        raise InputError(f"{name[:45]!r} is not a usable parameter name: a letter, then letters, digits or '_'")
    used = {
        **dict.fromkeys(taken(), "a function or a constant"),
        **dict.fromkeys(_ARGUMENTS, "an argument of functions that take parameters by name"),
        **{
            name: f"the {quantity.meaning} everywhere in this package"
            for name, quantity in symbols.QUANTITIES.items()
        },
    }
    if name in used:
        advice = ", or write v for the slip speed" if name == "V" else ""
        raise InputError(f"{name!r} is taken: it is {used[name]}; rename the parameter{advice}")

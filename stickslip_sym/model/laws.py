"""The catalogue of friction laws, and what users may write for a law. The texts are in `model/catalogue.py`."""

from collections import UserDict
from collections.abc import Callable
from functools import partial
from typing import Self

import sympy as sp

from stickslip_sym.core.aliases import Expr, Json
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.names import lookup, suggestion
from stickslip_sym.model.catalogue import ENTRIES, PARAMETERS, LawEntry
from stickslip_sym.model.expression.parameters import Parameter
from stickslip_sym.model.expression.parsing import NAME
from stickslip_sym.model.expression.reading import require_evaluation
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output.shown import Shown

__all__ = ["Catalogue", "as_law", "laws"]


class Catalogue(Shown, UserDict[str, FrictionLaw]):
    """Friction laws by name, also as attributes; each is read when it is first asked for."""

    data: Json

    def __getitem__(self, name: str) -> FrictionLaw:
        entry: FrictionLaw | Callable[[], FrictionLaw] = self.data[name]
        if not isinstance(entry, FrictionLaw):
            entry = self.data[name] = entry()
        return entry

    def __getattr__(self, name: str) -> FrictionLaw:
        if name.startswith("_") or name == "data" or name not in self:
            known = [] if name == "data" else list(self)
            raise AttributeError(f"there is no law {name!r}{suggestion(name, known)}")
        return self[name]

    def __repr__(self) -> str:
        return f"Catalogue({', '.join(self)})"

    def __dir__(self) -> list[str]:
        return sorted([*super().__dir__(), *self])

    @property
    def catalogue(self) -> Self:
        """The catalogue itself, as a mapping."""
        return self

    def find(self, name: str) -> FrictionLaw:
        """Return a law by its name; for another name the refusal suggests the closest one."""
        return lookup("law", name, self)


def as_law(law: FrictionLaw | str | float | Expr) -> FrictionLaw:
    """Return the friction law that is meant: a law itself, the name of one of the catalogue, or a formula.

    Text that is one name is that of a law of the catalogue, unless it begins with mu: a constant coefficient.
    """
    require_evaluation()
    if isinstance(law, FrictionLaw):
        return law
    if isinstance(law, str) and NAME.fullmatch(law.strip()) and not law.strip().startswith("mu"):
        return laws.find(law.strip())
    if isinstance(law, str | int | float | sp.Basic):
        return FrictionLaw(law)
    raise InputError(
        "a friction law is needed: a FrictionLaw, the name of a law of the catalogue, or a formula such as "
        f"'mu_s - a*v'; got {type(law).__name__}"
    )


def _read_entry(entry: LawEntry) -> FrictionLaw:
    described = {parameter.name: Parameter(*parameter) for parameter in (*PARAMETERS, *entry.own)}
    return FrictionLaw(
        entry.formula,
        parameters=[described[name] for name in entry.parameters.split()],
        name=entry.name,
        validity=entry.validity,
        source=entry.source,
    )


laws = Catalogue()
"""Every law of the catalogue."""
laws.data |= {entry.name: partial(_read_entry, entry) for entry in ENTRIES}

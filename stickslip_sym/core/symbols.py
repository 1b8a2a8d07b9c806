"""Every symbol of the oscillator once: its meaning, its SI unit, its assumptions.

The parameters of friction laws are not here; each law brings its own (`friction.Parameter`). A symbol is made when
it is first asked for: the meanings and units are wanted without SymPy.
"""

from dataclasses import dataclass
from functools import cached_property
from threading import RLock
from typing import TYPE_CHECKING

from stickslip_sym.core.algebra import sp
from stickslip_sym.core.aliases import Expr

if TYPE_CHECKING:
    V: Expr
    N: Expr
    m: Expr
    k: Expr
    c: Expr
    v: Expr
    x: Expr
    t: Expr
    u: Expr
    s: Expr
    theta: Expr
    a: Expr
    b: Expr
    mu: Expr

__all__ = [
    "QUANTITIES", "RESERVED", "N", "Quantity", "V", "a", "b", "c", "k", "m", "mu", "s", "t", "theta", "u", "v",
    "x",
]  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """A physical quantity: its name, what it means, its SI unit as text, and what SymPy may assume of it."""

    name: str
    meaning: str
    unit: str
    assumption: str

    @cached_property
    def symbol(self) -> Expr:
        """The symbol of the quantity."""
        return sp.Symbol(self.name, **{self.assumption: True})


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("V", "belt speed", "m/s", "positive"),
        Quantity("N", "normal force", "N", "positive"),
        Quantity("m", "mass", "kg", "positive"),
        Quantity("k", "spring stiffness", "N/m", "positive"),
        Quantity("c", "viscous damping coefficient", "kg/s", "real"),
        Quantity("v", "slip speed |x' - V|", "m/s", "nonnegative"),
        Quantity("x", "displacement of the mass", "m", "real"),
        Quantity("t", "time", "s", "real"),
    )
}

RESERVED = frozenset(QUANTITIES)
"""Names that a parameter of a friction law may not have."""

# Used inside derivations only. Dummies, so that a law may use these names for its own parameters.
_DUMMIES = {"u": "nonnegative", "s": "real", "theta": "real", "a": "real", "b": "real"}


def _made() -> dict[str, Expr]:
    """Return every symbol by its name."""
    dummies = {name: sp.Dummy(name, **{assumption: True}) for name, assumption in _DUMMIES.items()}
    known = {name: quantity.symbol for name, quantity in QUANTITIES.items()}
    return known | dummies | {"mu": sp.Function("mu", real=True)}


def __getattr__(name: str) -> Expr:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    with _MAKING:  # threads must agree on the dummies
        if name not in globals():
            globals().update(_made())
    return globals()[name]


_MAKING = RLock()

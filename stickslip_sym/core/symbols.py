"""Every symbol of the oscillator once: its meaning, its SI unit, its assumptions.

The parameters of friction laws are not here; each law brings its own (`Parameter`).
"""

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from stickslip_sym.core.aliases import Expr


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

V, N, m, k, c, v, x, t = (quantity.symbol for quantity in QUANTITIES.values())
mu: Expr = sp.Function("mu", real=True)

# Used inside derivations only. Dummies, so that a law may use these names for its own parameters.
u: Expr = sp.Dummy("u", nonnegative=True)
s, theta, a, b = (sp.Dummy(name, real=True) for name in ("s", "theta", "a", "b"))

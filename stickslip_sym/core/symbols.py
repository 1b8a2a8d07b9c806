"""Every symbol of the oscillator once: its meaning, its SI unit, its assumptions.

The parameters of friction laws are not here; each law brings its own (`friction.Parameter`).
"""

from dataclasses import dataclass

import sympy as sp

from stickslip_sym.core.aliases import Expr

__all__ = [
    "QUANTITIES", "RESERVED", "N", "Quantity", "V", "a", "b", "c", "k", "m", "mu", "s", "t", "theta", "u", "v",
    "x",
]  # fmt: skip  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """A physical quantity: its symbol, what it means, and its SI unit as text."""

    symbol: Expr
    meaning: str
    unit: str


V = sp.Symbol("V", positive=True)
N = sp.Symbol("N", positive=True)
m = sp.Symbol("m", positive=True)
k = sp.Symbol("k", positive=True)
c = sp.Symbol("c", real=True)
v = sp.Symbol("v", nonnegative=True)
x = sp.Symbol("x", real=True)
t = sp.Symbol("t", real=True)

# Used inside derivations only. Dummies, so that a law may use these names for its own parameters.
u = sp.Dummy("u", nonnegative=True)
s = sp.Dummy("s", real=True)
theta = sp.Dummy("theta", real=True)
a = sp.Dummy("a", real=True)
b = sp.Dummy("b", real=True)
mu = sp.Function("mu", real=True)

QUANTITIES = {
    quantity.symbol.name: quantity
    for quantity in (
        Quantity(V, "belt speed", "m/s"),
        Quantity(N, "normal force", "N"),
        Quantity(m, "mass", "kg"),
        Quantity(k, "spring stiffness", "N/m"),
        Quantity(c, "viscous damping coefficient", "kg/s"),
        Quantity(v, "slip speed |x' - V|", "m/s"),
        Quantity(x, "displacement of the mass", "m"),
        Quantity(t, "time", "s"),
    )
}

RESERVED = frozenset(QUANTITIES)
"""Names that a parameter of a friction law may not have."""

"""Every symbol of the oscillator once: its meaning, its SI unit, its assumptions.

The parameters of friction laws are not here; each law brings its own (`Parameter`).
"""

from collections.abc import Container, Mapping
from typing import NamedTuple

import sympy as sp

from stickslip_sym.core.aliases import Expr, UndefinedFunction
from stickslip_sym.core.errors import InputError

_NO_BELT = (
    "on a belt that stands still nothing drives the mass, so take a small speed such as 1e-6 instead",
    "x counts along the belt, so where it runs backward change the signs of V, x0 and v0",
)


class Quantity(NamedTuple):
    """A physical quantity: its symbol, what it means, and its SI unit as text."""

    symbol: Expr
    meaning: str
    unit: str


QUANTITIES = {
    quantity.symbol.name: quantity
    for quantity in (
        Quantity(sp.Symbol("V", positive=True), "belt speed", "m/s"),
        Quantity(sp.Symbol("N", positive=True), "normal force", "N"),
        Quantity(sp.Symbol("m", positive=True), "mass", "kg"),
        Quantity(sp.Symbol("k", positive=True), "spring stiffness", "N/m"),
        Quantity(sp.Symbol("c", real=True), "viscous damping coefficient", "kg/s"),
        Quantity(sp.Symbol("v", nonnegative=True), "slip speed |x' - V|", "m/s"),
        Quantity(sp.Symbol("x", real=True), "displacement of the mass", "m"),
        Quantity(sp.Symbol("t", real=True), "time", "s"),
    )
}

V, N, m, k, c, v, x, t = (quantity.symbol for quantity in QUANTITIES.values())
mu: UndefinedFunction = sp.Function("mu", real=True)

# Used inside derivations only. Dummies, so that a law may use these names for its own parameters.
u: Expr = sp.Dummy("u", nonnegative=True)
s, theta, a, b = (sp.Dummy(name, real=True) for name in ("s", "theta", "a", "b"))


def quantities_text(values: Mapping[str, object], defaults: Container[str] = ()) -> str:
    """Return quantities as text, e.g. ``V = 0.5 m/s (default), N = 9.81 N``."""
    texts = {name: f"{value:g}" if isinstance(value, float) else str(value) for name, value in values.items()}
    return ", ".join(
        f"{name} = {text} {QUANTITIES[name].unit}{' (default)' if name in defaults else ''}"
        for name, text in texts.items()
    )


def require_sign(name: str, value: float | Expr) -> None:
    """Refuse a value of V, N, m or k that is not positive; a normal force may be 0."""
    if value < 0 or (value == 0 and name != "N"):
        required = "not be negative" if name == "N" else "be positive"
        advice = ""
        if name == "V":
            advice = f"; {_NO_BELT[bool(value < 0)]}"
        raise InputError(
            f"{name} = {float(value):g} must {required}: it is the {QUANTITIES[name].meaning}{advice}"
        )

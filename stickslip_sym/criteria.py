"""The criteria: each a weight over which the falling slope of mu is averaged.

With s = (v - V)/V in [-1, 1] every criterion reads

    c = N <-mu'(V(1 + s))>_w = -N * integral_{-1}^{1} w(s) mu'(V(1 + s)) ds,    integral of w = 1.
"""

from dataclasses import dataclass
from typing import Any

import sympy as sp

from stickslip_sym import symbols
from stickslip_sym.errors import InputError
from stickslip_sym.values import lookup

__all__ = ["Criterion", "catalogue", "equilibrium", "find", "least_squares"]


@dataclass(frozen=True)
class Criterion:
    """A slope average.

    Attributes
    ----------
    name : str
    weight : sympy.Expr or None
        w(s) on [-1, 1] with unit integral and w(-1) = w(1) = 0; None for the Dirac delta at s = 0.
    source : str
    """

    name: str
    weight: Any | None
    source: str

    @property
    def moment_kernel(self) -> Any:
        """The kernel K(u) with c = integral_0^{2V} mu(u) K(u) du, from one integration by parts.

        The boundary terms vanish because the weight does at s = -1 and s = 1.
        """
        if self.weight is None:
            raise InputError(f"the criterion {self.name!r} takes the slope at one point; it has no kernel")
        slope = sp.diff(self.weight, symbols.s)
        s_of_u = (symbols.u - symbols.V) / symbols.V
        return sp.factor(symbols.N * slope.subs(symbols.s, s_of_u) / symbols.V**2)


equilibrium = Criterion("equilibrium", None, "linear stability of the equilibrium, e.g. Galvanetto & Bishop 1999")
least_squares = Criterion(
    "least_squares", sp.Rational(5, 8) * (1 - symbols.s**4), "Won & Chung 2016, eq. (16), integrated by parts"
)

catalogue: dict[str, Criterion] = {criterion.name: criterion for criterion in (equilibrium, least_squares)}
"""Every criterion by name."""


def find(criterion: str | Criterion) -> Criterion:
    """Return a criterion by its name; a criterion passes through.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    return criterion if isinstance(criterion, Criterion) else lookup("criterion", criterion, catalogue)

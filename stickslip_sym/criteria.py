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

__all__ = ["Criterion", "catalogue", "equilibrium", "find", "harmonic", "least_squares"]


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

    def even_moment(self, j: int) -> Any:
        """Return the mean of s^2j: an integral for a polynomial weight, a Beta function for the harmonic one."""
        s = symbols.s
        if self.is_polynomial:
            return sp.integrate(sp.expand(self.weight * s ** (2 * j)), (s, -1, 1))
        if self.weight == harmonic.weight:
            return sp.catalan(j) / sp.Integer(4) ** j
        return sp.integrate(self.weight * s ** (2 * j), (s, -1, 1))

    @property
    def moment_kernel(self) -> Any:
        """The kernel K(v) with c = integral_0^{2V} mu(v) K(v) dv, from one integration by parts.

        The boundary terms vanish because the weight does at s = -1 and s = 1.
        """
        s_of_v = (symbols.v - symbols.V) / symbols.V
        return sp.factor(symbols.N * self._weight_slope.subs(symbols.s, s_of_v) / symbols.V**2)

    @property
    def angle_kernel(self) -> Any:
        """The kernel A(theta) with c = integral_0^pi mu(V(1 - cos(theta))) A(theta) dtheta."""
        cosine = -sp.cos(symbols.theta)
        kernel = self._weight_slope.subs(symbols.s, cosine) * sp.sin(symbols.theta)
        # sin(theta) is not negative on [0, pi], so sqrt(1 - cos^2) is sin.
        kernel = kernel.subs(sp.sqrt(1 - sp.cos(symbols.theta) ** 2), sp.sin(symbols.theta))
        return symbols.N / symbols.V * kernel

    @property
    def is_polynomial(self) -> bool:
        """Whether the weight is a polynomial, so that criteria are ordinary moments of mu."""
        return self.weight is not None and bool(self.weight.is_polynomial(symbols.s))

    @property
    def _weight_slope(self) -> Any:
        if self.weight is None:
            raise InputError(f"the criterion {self.name!r} takes the slope at one point; it has no kernel")
        return sp.diff(self.weight, symbols.s)


equilibrium = Criterion("equilibrium", None, "linear stability of the equilibrium, e.g. Galvanetto & Bishop 1999")
least_squares = Criterion(
    "least_squares", sp.Rational(5, 8) * (1 - symbols.s**4), "Won & Chung 2016, eq. (16), integrated by parts"
)

harmonic = Criterion(
    "harmonic",
    2 / sp.pi * sp.sqrt(1 - symbols.s**2),
    "first-harmonic energy balance at velocity amplitude V; for the polynomial law Thomsen & Fidlin 2003",
)

catalogue: dict[str, Criterion] = {
    criterion.name: criterion for criterion in (equilibrium, least_squares, harmonic)
}
"""Every criterion by name."""


def find(criterion: str | Criterion) -> Criterion:
    """Return a criterion by its name; a criterion passes through.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    return criterion if isinstance(criterion, Criterion) else lookup("criterion", criterion, catalogue)

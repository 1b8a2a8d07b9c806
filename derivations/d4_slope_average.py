"""The criterion as an average of the falling slope, for an arbitrary differentiable function mu.

Equation (16) weighs mu itself with a kernel that changes sign, and divides by V^5. Integrated by parts
it weighs the slope of mu with a positive weight of unit integral, and no digits cancel.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import criteria
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, c, mu, s, u
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import Antiderivative, ChangeOfVariable


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive c = N <-mu'>_w, w = (5/8)(1 - s^4), from (16); `replaced` may hold another "weight"."""
    changes = dict(replaced or {})
    weight = changes.pop("weight", criteria.least_squares.weight)
    printed = paper.equations(changes)
    local = mu(V * (1 + s))
    slope = sp.diff(local, s) / V

    def average(integrand: Expr) -> Expr:
        return sp.Integral(integrand, (s, -1, 1))

    d = Derivation("slope_average", "The criterion (16) as an average of the falling slope")
    centred = d.equal(
        "substitute u = V(1 + s) in (16)",
        "s runs from -1 to 1 as u runs from 0 to 2V, and V - u = -V s",
        printed["(16)"],
        -5 * N / (2 * V) * average(s**3 * local),
        by=ChangeOfVariable(u, s, V * (1 + s)),
        shown=c,
    )
    product = average(sp.diff(weight * local, s))
    d.equal(
        "the derivative of w mu integrates to nothing",
        "w vanishes at s = -1 and s = 1",
        product,
        0,
        by=Antiderivative(weight * local, s),
    )
    d.equal(
        "integrate by parts: subtract N/V times that nothing",
        "w' = -(5/2) s^3, and the derivative of mu(V(1 + s)) is V mu'(V(1 + s))",
        centred,
        -N * average(weight * slope),
        label="slope average",
        by=lambda expr: expr - N / V * product,
        shown=c,
    )
    d.equal("the weight has unit integral", "a polynomial", average(weight), 1)
    inside = sp.Symbol("p", positive=True)
    # s^2 = 1/(1 + p) runs over (0, 1) as p runs over (0, oo).
    d.positive(
        "the weight is positive inside",
        "with s^2 = 1/(1 + p), p > 0",
        sp.factor(weight.subs(s, (1 + inside) ** -sp.Rational(1, 2))),
    )
    return d

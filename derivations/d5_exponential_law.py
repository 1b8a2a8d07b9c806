"""The exponential law (3): from (16) to the closed form (17)."""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import FrictionLaw, laws
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, c, mu, u, v
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import Antiderivative


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (17)."""
    printed = paper.equations(replaced)
    d = Derivation("exponential_law", "The exponential law: (16) to (17)")
    formula = integrate_law(d, laws.exponential, printed, "(3)")
    d.equal(
        "write with hyperbolic functions",
        "cosh and sinh are sums of exponentials",
        formula,
        printed["(17)"],
        label="(17)",
        shown=c,
    )
    return d


def integrate_law(d: Derivation, law: FrictionLaw, printed: Mapping[str, Any], label: str) -> Expr:
    """Add the steps from (16) to the closed form for the law printed under `label`, and return the form."""
    coefficient = printed[label]
    d.equal(
        f"take the law {label}",
        "it is the catalogue's",
        law.expr.subs(v, u),
        coefficient,
        label=label,
        shown=mu(u),
    )
    primitive = sp.integrate(sp.expand(coefficient * (V - u) ** 3), u)
    return d.equal(
        f"put {label} into (16)",
        "an antiderivative of mu(u) (V - u)^3 at 2V less that at 0; it is differentiated back",
        printed["(16)"].replace(mu, lambda speed: coefficient.subs(u, speed)),
        sp.factor(5 * N / (2 * V**5) * (primitive.subs(u, 2 * V) - primitive.subs(u, 0))),
        by=Antiderivative(primitive, u),
        shown=c,
    )

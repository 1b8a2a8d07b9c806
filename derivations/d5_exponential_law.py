"""The exponential law (3): from (16) to the closed form (17)."""

from collections.abc import Mapping
from typing import Any

from derivations import paper
from stickslip_sym import Derivation, derive, laws
from stickslip_sym.symbols import c, mu, u, v


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (17)."""
    printed = paper.equations(replaced)
    law = laws.exponential
    form = derive(law, "least_squares")
    d = Derivation("exponential_law", "The exponential law: (16) to (17)")
    d.equal(
        "take the law (3)",
        "it is the catalogue's",
        law.expr.subs(v, u),
        printed["(3)"],
        label="(3)",
        shown=mu(u),
    )
    first = form.derivation.steps[0]
    d.equal(
        "put (3) into (16)",
        "with u for |v_r|",
        printed["(16)"].replace(mu, lambda speed: printed["(3)"].subs(u, speed)),
        first.statement.rhs,
        shown=c,
    )
    d.steps += form.derivation.steps[1:]
    d.equal(
        "write with hyperbolic functions",
        "cosh and sinh are sums of exponentials",
        form.expr,
        printed["(17)"],
        label="(17)",
        shown=c,
    )
    return d

"""The polynomial law (4): from (16) to the closed form (18), and the belt speed where it vanishes."""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import Derivation, derive, laws
from stickslip_sym.symbols import V, c, mu, u, v


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (18), and its zero sqrt(21/26) v_m."""
    printed = paper.equations(replaced)
    law = laws.polynomial
    form = derive(law, "least_squares")
    d = Derivation("polynomial_law", "The polynomial law: (16) to (18), and the zero of (18)")
    d.equal(
        "take the law (4)",
        "it is the catalogue's",
        law.expr.subs(v, u),
        printed["(4)"],
        label="(4)",
        shown=mu(u),
    )
    first = form.derivation.steps[0]
    d.equal(
        "put (4) into (16)",
        "with u for |v_r|",
        printed["(16)"].replace(mu, lambda speed: printed["(4)"].subs(u, speed)),
        first.statement.rhs,
        shown=c,
    )
    d.steps += form.derivation.steps[1:]
    criterion = d.equal(
        "the printed form",
        "both sides are the same expression",
        form.expr,
        printed["(18)"],
        label="(18)",
        shown=c,
    )
    d.equal(
        "the transition speed without damping is where (18) vanishes",
        "put it into (18)",
        criterion.subs(V, printed["transition speed"]),
        0,
        label="transition speed",
    )
    mu_s, mu_m = (paper.polynomial[name] for name in ("mu_s", "mu_m"))
    difference = sp.Symbol("D", positive=True)
    d.positive(
        "it is the only one: (18) falls with the belt speed",
        "mu_s = mu_m + D with D > 0",
        -sp.diff(criterion, V).subs(mu_s, mu_m + difference),
    )
    return d

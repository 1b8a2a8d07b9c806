"""The polynomial law (4): from (16) to the closed form (18), and the belt speed where it vanishes."""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from derivations.d5_exponential_law import integrate_law
from stickslip_sym import laws
from stickslip_sym.core.symbols import V, c
from stickslip_sym.formula.derivation import Derivation


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (18), and its zero sqrt(21/26) v_m."""
    printed = paper.equations(replaced)
    d = Derivation("polynomial_law", "The polynomial law: (16) to (18), and the zero of (18)")
    formula = integrate_law(d, laws.polynomial, printed, "(4)")
    criterion = d.equal(
        "the printed form",
        "both sides are the same expression",
        formula,
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

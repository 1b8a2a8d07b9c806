"""The exponential law (3): from (16) to the closed form (17)."""

from collections.abc import Mapping
from functools import cache
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import ClosedForm, Derivation, FrictionLaw, derive, laws
from stickslip_sym.core.symbols import c, mu, u, v


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


@cache
def closed_form(law: FrictionLaw) -> ClosedForm:
    """Integrate a law, once for all calls; equations that replace the paper's do not enter."""
    return derive(law, "least_squares")


def integrate_law(d: Derivation, law: FrictionLaw, printed: Mapping[str, Any], label: str) -> Any:
    """Add the steps from (16) to the closed form for the law printed under `label`, and return the form."""
    form = closed_form(law)
    d.equal(
        f"take the law {label}",
        "it is the catalogue's",
        law.expr.subs(v, u),
        printed[label],
        label=label,
        shown=mu(u),
    )
    steps = form.derivation.steps
    d.equal(
        f"put {label} into (16)",
        "with v for |v_r|; the criterion is the sum of those of the law's terms",
        printed["(16)"].replace(mu, lambda speed: printed[label].subs(u, speed)),
        sp.Add(*[step.statement.lhs for step in steps if step.statement.lhs.has(sp.Integral)]),
        shown=c,
    )
    d.steps += steps[1:]
    return form.expr

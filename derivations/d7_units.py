"""Every criterion comes out in kg/s.

Each symbol is replaced by itself times its unit. A formula is dimensionally right exactly if all units
then come out in front as one factor: for a damping coefficient, kg/s.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import laws
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import QUANTITIES, N, V, c, mu, s, u
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import ChangeOfVariable
from stickslip_sym.model.expression.dimensions import multiply_by_units, parse_unit


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Prove the unit of (16), for any law, and of the closed forms (17), (18) and of the equilibrium."""
    printed = paper.equations(replaced)
    damping = parse_unit(QUANTITIES["c"].unit)
    point = {QUANTITIES[name].symbol: QUANTITIES[name].unit for name in ("V", "N")}
    d = Derivation("units", "Every criterion is a damping coefficient, in kg/s")

    # A law for a speed in m/s is a function of the pure number v/v_0, whatever the speed v_0 is.
    v_0 = sp.Symbol("v_0", positive=True)
    any_law = printed["(16)"].replace(mu, lambda speed: mu(speed / v_0))
    d.equal(
        "(16) for any law",
        "mu is a function of v/v_0; the variable of integration is a speed too",
        multiply_by_units(any_law, point | {v_0: "m/s"}),
        any_law * damping,
        by=ChangeOfVariable(u, s, s * parse_unit("m/s")),
    )

    def equilibrium(label: str) -> Expr:
        force: Expr = printed[label]
        return -N * sp.diff(force, u).subs(u, V)

    formulas = {
        "(17)": (printed["(17)"], laws.exponential),
        "(18)": (printed["(18)"], laws.polynomial),
        "equilibrium, exponential law": (equilibrium("(3)"), laws.exponential),
        "equilibrium, polynomial law": (equilibrium("(4)"), laws.polynomial),
    }
    for name, (expr, law) in formulas.items():
        parameters = {p.symbol: p.unit for p in law.parameters.values() if p.unit}
        listed = ", ".join(f"{symbol} in {unit}" for symbol, unit in (point | parameters).items() if unit != "1")
        d.equal(name, listed, multiply_by_units(expr, point | parameters), expr * damping, label=name, shown=c)
    return d

"""Work and energy over a cycle: equations (5), (6) and (7).

From P the mass slips away from the belt, and after a cycle it passes the same place again, at Q.
Newton's law, multiplied by the velocity and integrated, says what friction and damping did meanwhile.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym.core.symbols import c, k, m, t
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import Antiderivative


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (5), (6) and (7)."""
    printed = paper.equations(replaced)
    x, speed = paper.motion, sp.diff(paper.motion, t)
    force = paper.equation_of_motion_force()
    d = Derivation("energy_balance", "Work and energy from P to Q: (5), (6), (7)")
    kinetic = d.equal(
        "multiply Newton's law f - c x' - k x = m x'' by x' and integrate from P to Q",
        "m x'' x' is the derivative of m x'^2/2",
        paper.over_cycle((force - c * speed - k * x) * speed),
        printed["(5)"],
        label="(5)",
        by=Antiderivative(m * speed**2 / 2, t),
        shown=paper.over_cycle((sp.Function("f")(t) - c * speed - k * x) * speed),
    )
    x_P, x_Q = paper.value(x, paper.t_P), paper.value(x, paper.t_Q)
    spring = d.equal(
        "the spring's work",
        "k x x' is the derivative of k x^2/2",
        paper.over_cycle(k * x * speed),
        k * (x_Q**2 - x_P**2) / 2,
        by=Antiderivative(k * x**2 / 2, t),
    )
    d.equal(
        "which vanishes",
        "Q is at the place of P, x_Q = x_P",
        spring.subs(x_Q, x_P),
        0,
        shown=paper.over_cycle(k * x * speed),
    )
    speeds = {paper.value(speed, paper.t_Q): paper.value(speed, paper.t_P)}
    d.equal(
        "friction and damping balance",
        "(5) plus the spring's work; in stick-slip and in pure slip V_Q = V_P and x_Q = x_P",
        (kinetic + spring).subs(speeds).subs(x_Q, x_P),
        0,
        label="(6)",
        shown=paper.over_cycle((sp.Function("f")(t) - c * speed) * speed),
    )
    slower, lack = sp.symbols("V_Q d", positive=True)
    loss = -kinetic.subs({paper.value(speed, paper.t_Q): slower, paper.value(speed, paper.t_P): slower + lack})
    d.positive(
        "damped slip loses energy: minus the integral of (6)",
        "(5) with V_P = V_Q + d, d > 0, at the same place",
        loss,
        label="(7)",
    )
    return d

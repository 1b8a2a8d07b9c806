"""A linear coefficient makes the balance solvable: equations (8) to (11).

With mu_L = -a|v_r| + b the integral of (6) needs no knowledge of the motion but that it closes.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym.core.symbols import N, V, a, b, c, t, u
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import Antiderivative


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (9), (10) and (11)."""
    printed = paper.equations(replaced)
    speed = sp.diff(paper.motion, t)
    d = Derivation("linearised_force", "The balance with a linear coefficient: (9), (10), (11)")

    slip_speed = sp.Symbol("w", positive=True)
    relative = -slip_speed
    force = d.equal(
        "the kinetic force (2) with mu_L of (8), for v_r = -w",
        "during slip below the belt's speed v_r < 0, so sgn(v_r) = -1 and |v_r| = w",
        -sp.sign(relative) * printed["(8)"].subs(u, sp.Abs(relative)) * N,
        N * (-a * slip_speed + b),
        shown=sp.Symbol("f"),
    )
    d.equal(
        "put w = V - x'",
        "that is the definition of the relative velocity, v_r = x' - V",
        force.subs(slip_speed, V - paper.velocity),
        printed["(9)"],
        label="(9)",
        shown=sp.Symbol("f"),
    )

    work = paper.over_cycle((printed["(9)"].subs(paper.velocity, speed) - c * speed) * speed)
    travel, square = paper.over_cycle(speed), paper.over_cycle(speed**2)
    split = d.equal(
        "put (9) into (6)",
        "the integral is linear in its integrand",
        work,
        (b - a * V) * N * travel + (a * N - c) * square,
    )
    x_P, x_Q = (paper.value(paper.motion, time) for time in (paper.t_P, paper.t_Q))
    distance = d.equal(
        "the integral of the velocity",
        "x' is the derivative of x",
        travel,
        x_Q - x_P,
        by=Antiderivative(paper.motion, t),
    )
    balance = d.equal(
        "rearrange",
        "the two steps before; (6) asks that it is 0",
        split.subs(travel, distance),
        printed["(10)"],
        label="(10)",
        shown=work,
    )

    J = sp.Symbol("J", positive=True)
    closed = d.equal(
        "let the motion close",
        "in pure slip x_Q = x_P; J is the integral of x'^2, positive since x' = V at P",
        balance.subs(x_Q, x_P).subs(square, J),
        (a * N - c) * J,
        shown=work,
    )
    d.positive(
        "the balance falls strictly with c, so it vanishes for one c only",
        "it is linear in c with the slope -J",
        -sp.diff(closed, c),
    )
    d.equal(
        "the balance vanishes if and only if",
        "the only root in c",
        sp.solve(closed, c)[0],
        printed["(11)"],
        label="(11)",
        shown=c,
    )
    return d

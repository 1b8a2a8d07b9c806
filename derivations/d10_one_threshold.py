"""One damping parts stick-slip from slip, for an arbitrary friction law.

In the plane of displacement and velocity the motion follows the field (x', x''). More damping turns that field one
way at every point, and moves P, where stick ends, inwards. So of two orbits that leave their P the one with more
damping stays inside the other: if it comes back to the belt's speed, so does the other. The return depends on c
through one threshold only, and where it is just lost the orbit grazes.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import Derivation
from stickslip_sym.core.symbols import N, V, c, k, m, mu, x


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive how the field and P depend on c; `replaced` may hold another "field" or another "P"."""
    velocity = paper.velocity
    mu_s = paper.exponential["mu_s"]
    claimed = {"field": -(velocity**2) / m, "P": (mu_s * N - c * V) / k} | dict(replaced or {})
    d = Derivation("one_threshold", "One damping parts stick-slip from slip, for any law")

    field = sp.Matrix([velocity, (N * mu(V - velocity) - c * velocity - k * x) / m])
    turn = d.equal(
        "the field against its change with c: the determinant of both",
        "only x'' holds c, and friction does not",
        sp.Matrix.hstack(field, sp.diff(field, c)).det(),
        claimed["field"],
        label="field",
    )
    speed = sp.Symbol("s", positive=True)
    d.positive(
        "more damping turns the field clockwise wherever the mass moves",
        "for either sign of x', x'^2 = s^2 > 0",
        -turn.subs(velocity, speed),
    )

    (place,) = sp.solve(c * V + k * x - mu_s * N, x)
    onset = d.equal(
        "P, where every forward stick phase ends",
        "there c x' + k x of (1) has grown to mu_s N, at x' = V",
        place,
        claimed["P"],
        label="P",
        shown=x,
    )
    d.positive("it moves inwards as c grows", "the slope of P with c, at the belt's speed", -sp.diff(onset, c))

    rates = {velocity: V, x: onset}
    d.equal(
        "at P the slip begins with no acceleration",
        "where mu(0+) is the static coefficient",
        field[1].subs(rates).subs(mu(0), mu_s),
        0,
        shown=sp.Symbol("x''"),
    )
    # Along the motion x changes at the rate x'; the velocity does not yet.
    d.positive(
        "and with a loss of speed that grows as t^2: the relative velocity has a double root",
        "the jerk is -k V/m",
        -(sp.diff(field[1], x) * velocity).subs(rates),
    )
    return d

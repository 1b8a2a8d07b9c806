"""One damping separates stick-slip from slip, for an arbitrary friction law.

*Lemma.* Let c1 < c2. If the slip that leaves P comes back to the belt's speed at the damping c2, it does so at c1.

In the plane of displacement x and velocity v = x' the motion follows the field (v, x''). The steps below compute
how the field and P depend on c; the argument needs these, and three theorems of topology and of differential
equations.

*Conditions.* mu is locally Lipschitz for slip speeds above 0, so that one orbit runs through each point with v <
V (Picard and Lindelöf); it is continuous at 0+, and the static coefficient is at least mu(0+); it is bounded
below at the slip speeds that orbits reach; c1 >= 0. A jump of mu breaks the first condition, and a law that
falls without bound may break the third: `pure_slip_damping` with the method "proof" checks both, and refuses.

*Argument.* Let arc 2 be the slip at c2 from P2 to its return R2. It leaves downwards, passes v = 0 on the right
of the equilibrium, runs back below, passes v = 0 on the left, and rises to R2: a turn of v above 0 would be a
maximum, and an orbit that has one below the belt's speed is shut in by itself, so on the way up x'' > 0. With
the line v = V between its ends arc 2 is a closed curve without double points, which has an inside (Jordan), and
the equilibrium, the same for every c, lies there: an index of a closed curve along which the field turns once
(Poincaré). Slip 1 starts outside, since P1 lies to the right of P2. It never enters: at every point of arc 2
with v not 0 field 1 points outwards, and where an orbit of field 1 touches arc 2 at v = 0 it passes from inside
to outside. Outside there is no equilibrium, so it cannot come to rest: it falls to v = 0 on the right; below, mu
being bounded from below, the spring brings it back to v = 0, on the left of arc 2; and there its x'' is larger
than on arc 2 at the same v, where it is positive, so that it rises to v = V. That is the return.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, c, k, m, mu, x
from stickslip_sym.formula.derivation import Derivation


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive how the field and P depend on c; `replaced` may hold another equation by its label."""
    velocity = paper.velocity
    mu_s = paper.exponential["mu_s"]
    c1, more = sp.symbols("c_1 d", positive=True)
    speed = sp.Symbol("s", positive=True)
    claimed = {
        "field": -(velocity**2) / m,
        "P": (mu_s * N - c * V) / k,
        "equilibrium": N * mu(V) / k,
        "turn": -k * velocity / m,
        "touch": -more / (3 * m * sp.Symbol("a") ** 2),
        "nullcline": more * velocity / k,
    } | dict(replaced or {})
    d = Derivation("one_threshold", "One damping separates stick-slip from slip, for any law")

    force = N * mu(V - velocity) - c * velocity - k * x
    field = sp.Matrix([velocity, force / m])
    turn = d.equal(
        "the field against its change with c: the determinant of both",
        "only x'' holds c, and friction does not",
        sp.Matrix.hstack(field, sp.diff(field, c)).det(),
        claimed["field"],
        label="field",
    )
    d.positive(
        "more damping turns the field clockwise wherever the mass moves",
        "for either sign of x', x'^2 = s^2 > 0: an orbit with less damping crosses one with more outwards",
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

    (rest,) = sp.solve(force.subs(velocity, 0), x)
    d.equal(
        "the equilibrium is the same for every c",
        "at v = 0 damping has no part in x''; no other point of v = 0 has x'' = 0",
        rest,
        claimed["equilibrium"],
        label="equilibrium",
        shown=x,
    )
    along = sp.diff(field[1], x) * velocity  # the rate of x'' where x'' = 0: v does not change there
    d.equal(
        "where v turns its second derivative has the sign of -v",
        "along an orbit, with x'' = 0: above v = 0 every turn is a maximum",
        along,
        claimed["turn"],
        label="turn",
        shown=sp.Symbol("x'''"),
    )

    # Where x'' = a + b v + ... near v = 0, the orbit has x = x_0 + v^2/(2a) - b v^3/(3a^2) + ...
    a = sp.Symbol("a")
    slopes = [(sp.diff(force, velocity) / m).doit().subs(velocity, 0).subs(c, value) for value in (c1, c1 + more)]
    b = sp.Symbol("b")
    cubic = sp.series(velocity / (a + b * velocity), velocity, 0, 3).removeO().coeff(velocity, 2) / 3
    d.equal(
        "at v = 0 both fields are the same, and orbits that touch there part with v^3",
        "x_1 - x_2 of the orbits at c_1 and c_1 + d: above v = 0 the first lies inside, below it outside",
        sp.expand(cubic.subs(b, slopes[0]) - cubic.subs(b, slopes[1])),
        claimed["touch"],
        label="touch",
        shown=sp.Symbol("x_1") - sp.Symbol("x_2"),
    )
    gap = d.equal(
        "the line x'' = 0 lies further to the right with less damping, above v = 0",
        "x there at c_1 less x at c_1 + d: left of arc 2 a slip with less damping speeds up more",
        *_gap(force, c1, more, claimed["nullcline"]),
        label="nullcline",
    )
    d.positive(
        "so what drives slip 2 up to the belt's speed drives slip 1 too",
        "with v = s > 0",
        gap.subs(velocity, speed),
    )
    return d


def _gap(force: Expr, c1: Expr, more: Expr, claimed: Expr) -> tuple[Expr, Expr]:
    less, greater = (sp.solve(force.subs(c, value), x)[0] for value in (c1, c1 + more))
    return less - greater, claimed

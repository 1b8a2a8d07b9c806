"""The best linear coefficient: equations (12) to (16), for an arbitrary function mu.

The linear mu_L is fitted to mu over the velocities -V to V of a harmonic motion, weighted with x'^2
since the balance (6) weighs the force with the velocity.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import V, a, b, c, mu, u
from stickslip_sym.formula.derivation import Derivation
from stickslip_sym.formula.proof.theorems import ChangeOfVariable, LinearSolution


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive (13), (14), (15) and (16)."""
    printed = paper.equations(replaced)
    S = sp.Function("S")(a, b)
    d = Derivation("least_squares", "The least-squares fit for any mu: (12) to (16)")
    deviation = d.equal(
        "substitute x' = V - u in (12)",
        "u = |v_r| = V - x' runs from 2V to 0 as x' runs from -V to V, and dx' = -du",
        printed["(12)"],
        printed["(13)"],
        label="(13)",
        by=ChangeOfVariable(paper.velocity, u, V - u),
        shown=S,
    )

    def moment(integrand: Expr) -> Expr:
        return sp.Integral(integrand, (u, 0, 2 * V))

    weight = (V - u) ** 2
    by_a = d.equal(
        "differentiate under the integral with respect to a",
        "the integrand is a polynomial in a and b, and the limits do not depend on them",
        sp.diff(deviation, a),
        2 * moment(mu(u) * u * weight) + sp.Rational(32, 15) * V**5 * a - sp.Rational(4, 3) * V**4 * b,
        label="(14) a",
        shown=sp.Derivative(S, a),
    )
    by_b = d.equal(
        "and with respect to b",
        "likewise",
        sp.diff(deviation, b),
        -2 * moment(mu(u) * weight) - sp.Rational(4, 3) * V**4 * a + sp.Rational(4, 3) * V**3 * b,
        label="(14) b",
        shown=sp.Derivative(S, b),
    )
    solution = LinearSolution([by_a, by_b], [a, b])
    d.equal(
        "solve both equations for a",
        "they are linear in a and b",
        a,
        printed["(15) a"],
        label="(15) a",
        by=solution,
    )
    d.equal("and for b", "likewise", b, printed["(15) b"], label="(15) b", by=solution)

    by_aa, by_ab, by_ba, by_bb = (sp.Derivative(first, over) for first in (by_a, by_b) for over in (a, b))
    d.positive(
        "the solution is a minimum: the first principal minor of the Hessian",
        "S is a quadratic in a and b whose Hessian does not depend on mu",
        by_aa,
    )
    d.positive(
        "and the determinant of the Hessian",
        "both minors positive: positive definite, and unique",
        by_aa * by_bb - by_ab * by_ba,
    )
    d.equal(
        "put a into (11), c = a N",
        "the pure-slip condition",
        printed["(11)"],
        printed["(16)"],
        label="(16)",
        by=solution,
        shown=c,
    )
    return d

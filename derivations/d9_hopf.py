"""Where the equilibrium loses its stability, and the limit cycles born there.

With the displacement y measured from the equilibrium, m y'' + c y' + k y = N (mu(V - y') - mu(V)).
For a velocity amplitude A the work of friction and damping over a harmonic cycle balances if
c = N <-mu'(V + A cos)>, weighted with sin^2: the harmonic criterion with A in place of V.
"""

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from derivations import paper
from derivations.d8_second_order import take_polynomial_law
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, c, k, m, mu, theta, v
from stickslip_sym.formula.derivation import Derivation


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive the Hopf bifurcation, its criticality and the amplitude of the polynomial law's cycle.

    `replaced` may hold another law "(4)" or squared amplitude "A^2".
    """
    changes = dict(replaced or {})
    amplitude = changes.pop("A^2", None)
    printed = paper.equations(changes)
    d = Derivation("hopf", "The Hopf bifurcation at c = -N mu'(V), and the limit cycle born there")
    _linear(d)
    _criticality(d)
    law = take_polynomial_law(d, printed)
    _polynomial_law(d, law, amplitude)
    return d


def _linear(d: Derivation) -> None:
    y_1, y_2 = sp.symbols("y_1 y_2", real=True)
    field = sp.Matrix([y_2, (N * (mu(V - y_2) - mu(V)) - c * y_2 - k * y_1) / m])
    jacobian = field.jacobian([y_1, y_2]).subs({y_1: 0, y_2: 0}).doit()
    trace = d.equal(
        "linearise about the equilibrium: the trace of the Jacobian",
        "twice the real part of its eigenvalues",
        jacobian.trace(),
        -(c + N * sp.diff(mu(V), V)) / m,
    )
    d.positive("the determinant", "so where the trace is 0 the eigenvalues are imaginary", jacobian.det())
    d.equal(
        "they cross the imaginary axis at",
        "the root of the trace: the equilibrium criterion",
        sp.solve(trace, c)[0],
        -N * sp.diff(mu(V), V),
        label="Hopf",
        shown=c,
    )
    d.positive(
        "they cross it with speed",
        "their real part falls with c at the rate 1/(2 m)",
        -sp.diff(trace / 2, c),
    )


def _average(slope: Callable[[Expr], Expr], A: Expr) -> Expr:
    """Return the harmonic balance, c/N, of a slope mu'(V + s) that is a polynomial in s."""
    s = sp.Dummy("s", real=True)
    integrand = sp.expand((-slope(s)).subs(s, A * sp.cos(theta)) * sp.sin(theta) ** 2)
    return sp.expand(2 * sp.integrate(integrand, (theta, 0, sp.pi)) / sp.pi)


def _criticality(d: Derivation) -> None:
    A = sp.Symbol("A", positive=True)
    slopes = sp.symbols("mu1 mu2 mu3 mu4", real=True)

    def taylor(s: Expr) -> Expr:
        return sp.Add(*[slope * s**n / sp.factorial(n) for n, slope in enumerate(slopes)])

    need = d.equal(
        "the damping of a cycle of velocity amplitude A, to order A^3",
        "Taylor's expansion of mu' about V, averaged with (2/pi) sin^2 over half a period; mun is the n-th "
        "derivative of mu at V",
        N * _average(taylor, A),
        -N * (slopes[0] + slopes[2] * A**2 / 8),
        label="amplitude",
        shown=c,
    )
    mu3 = sp.Symbol("q", positive=True)
    d.positive(
        "mu'''(V) > 0: the damping needed falls with the amplitude, so cycles live below the Hopf point",
        "there the equilibrium is unstable: the bifurcation is supercritical, the cycle stable",
        -sp.diff(need, A).subs(slopes[2], mu3),
        label="supercritical",
    )
    d.positive(
        "mu'''(V) < 0: it rises, so cycles live above the Hopf point",
        "there the equilibrium is stable: the bifurcation is subcritical, the cycle unstable",
        sp.diff(need, A).subs(slopes[2], -mu3),
        label="subcritical",
    )


def _polynomial_law(d: Derivation, law: Expr, replaced: Expr | None) -> None:
    A = sp.Symbol("A", positive=True)
    slope = sp.diff(law, v)
    need = d.equal(
        "the harmonic balance of (4)",
        "its slope has no powers above the second, so nothing is left out",
        N * _average(lambda s: slope.subs(v, V + s), A),
        N * drop() * 3 * (4 * v_m() ** 2 - 4 * V**2 - A**2) / (8 * v_m() ** 3),
        shown=c,
    )
    square = 4 * (v_m() ** 2 - V**2) - 8 * c * v_m() ** 3 / (3 * N * drop())
    d.equal(
        "solved for the amplitude",
        "it is linear in A^2",
        sp.solve(need.subs(A**2, sp.Symbol("a")) - c, sp.Symbol("a"))[0],
        square if replaced is None else replaced,
        label="A^2",
        shown=A**2,
    )
    d.equal(
        "at A = V it grazes the belt's speed",
        "the harmonic criterion",
        need.subs(A, V),
        N * drop() * (12 * v_m() ** 2 - 15 * V**2) / (8 * v_m() ** 3),
        shown=c,
    )


def drop() -> Expr:
    """Return mu_s - mu_m of the law (4)."""
    return paper.polynomial["mu_s"] - paper.polynomial["mu_m"]


def v_m() -> Expr:
    """Return the speed of the lowest coefficient of the law (4)."""
    return paper.polynomial["v_m"]

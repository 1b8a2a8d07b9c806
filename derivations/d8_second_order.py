"""The pure-slip threshold for weak friction, to second order: where mass and stiffness enter.

With time in 1/omega, z = x'/V, eta = N/(V sqrt(k m)), M(z) = mu(V(1 - z)) and chat = c V/N, slip obeys

    z'' + z = eta d/dtau (M(z) - chat z).

The periodic orbit that grazes the belt's speed, max z = 1, is expanded in eta by the method of Lindstedt and
Poincare: theta = (1 + eta^2 W) tau, z = cos(theta) + eta z1 + eta^2 z2 + ..., chat = chat0 + eta^2 chat2. First
for any law, harmonic by harmonic; then as a closed form for polynomial laws.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from derivations import paper
from stickslip_sym import laws
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, c, k, m, mu, theta, u, v
from stickslip_sym.formula.derivation import Derivation

eta = sp.Symbol("eta", positive=True)
chat0, chat1, chat2, W = sp.symbols("chat_0 chat_1 chat_2 W", real=True)
E = sp.Symbol("E", positive=True)  # exp(i theta): trigonometric polynomials are rational functions of it


def derivation(replaced: Mapping[str, Any] | None = None) -> Derivation:
    """Derive the second-order threshold; `replaced` may hold another law "(4)" or "second order" formula."""
    changes = dict(replaced or {})
    formula = changes.pop("second order", None)
    printed = paper.equations(changes)
    d = Derivation("second_order", "The threshold to second order in N/(V sqrt(k m)): mass and stiffness enter")
    _any_law(d)
    law = take_polynomial_law(d, printed)
    _polynomial_law(d, law)
    d.equal(
        "the pure-slip damping c = (N/V)(chat_0 + eta^2 chat_2)",
        "eta^2 = N^2/(V^2 k m); the first part is the harmonic criterion, the second is new",
        threshold(law),
        law_4() if formula is None else formula,
        label="second order",
        shown=c,
    )
    return d


def law_4() -> Expr:
    """Return c of the law (4) to second order, as it is to be printed."""
    mu_s, mu_m, v_m = (paper.polynomial[name] for name in ("mu_s", "mu_m", "v_m"))
    drop = mu_s - mu_m
    weak = N * drop * (12 * v_m**2 - 15 * V**2) / (8 * v_m**3)
    return weak + sp.Rational(31149, 81920) * N**3 * drop**3 * V**6 / (k * m * v_m**9)


def take_polynomial_law(d: Derivation, printed: Mapping[str, Any]) -> Expr:
    """Add the step that takes the law (4) as it is printed, and return it."""
    return d.equal(
        "take the law (4)",
        "it is the catalogue's",
        laws.polynomial.expr,
        printed["(4)"].subs(u, v),
        label="(4)",
        shown=mu(v),
    )


def _any_law(d: Derivation) -> None:
    """Add the expansion for an arbitrary law, order by order and harmonic by harmonic."""
    M = sp.Function("M", real=True)
    z0 = sp.cos(theta)
    z1, z2, z3 = (sp.Function(f"z{order}", real=True)(theta) for order in (1, 2, 3))
    z = z0 + eta * z1 + eta**2 * z2 + eta**3 * z3
    pace, chat = 1 + eta**2 * W, chat0 + eta * chat1 + eta**2 * chat2
    force = M(z) - chat * z
    balance = pace**2 * sp.diff(z, theta, 2) + z - eta * pace * sp.diff(force, theta)

    def order(expr: Expr, power: int) -> Expr:
        return (sp.diff(expr, eta, power).subs(eta, 0) / sp.factorial(power)).doit()

    w = sp.Dummy("w", real=True)
    slope, curvature = (sp.diff(M(w), w, n).subs(w, z0) for n in (1, 2))
    first = M(z0) - chat0 * z0
    second = (slope - chat0) * z1 - chat1 * z0
    third = (slope - chat0) * z2 + curvature * z1**2 / 2 - chat1 * z1 - chat2 * z0
    equations = (
        ("first", z1, first, 0),
        ("second", z2, second, -2 * W * z0),
        ("third", z3, third + W * first, 2 * W * sp.diff(z1, theta, 2)),
    )
    for power, (name, unknown, pushed, rest) in enumerate(equations, 1):
        d.equal(
            f"collect what is of the {name} order in eta",
            "Taylor's theorem in eta, for any M that is smooth enough",
            order(balance, power),
            sp.diff(unknown, theta, 2) + unknown + rest - sp.diff(pushed, theta),
            label=f"order {power}",
        )
    _harmonics(d)
    _height(d)


def _harmonics(d: Derivation) -> None:
    """Solve the three orders for one harmonic each, as sums of sines or cosines."""
    n = sp.Symbol("n", integer=True, positive=True)
    m_n, f_n, f_1, h = sp.symbols("m_n f_n f_1 h", real=True)
    b_n, a_n = n * m_n / (n**2 - 1), -n * f_n / (n**2 - 1)

    def left(part: Expr) -> Expr:
        return sp.diff(part, theta, 2) + part

    d.equal(
        "first order, n >= 2: M(cos) = sum of m_n cos(n theta) pushes z1 = sum of b_n sin(n theta)",
        "b_n = n m_n/(n^2 - 1)",
        left(b_n * sp.sin(n * theta)),
        sp.diff(m_n * sp.cos(n * theta), theta),
        label="b_n",
    )
    m_1 = sp.Symbol("m_1", real=True)
    d.equal(
        "first order, n = 1: nothing may push in resonance",
        "the fundamental of M(cos) - chat_0 cos is m_1 - chat_0: the harmonic criterion",
        sp.solve(m_1 - chat0, chat0)[0],
        m_1,
        shown=chat0,
        label="chat_0",
    )
    d.equal(
        "second order, n >= 2: f = (M' - chat_0) z1 = sum of f_n sin(n theta) pushes z2 = sum of a_n cos(n theta)",
        "a_n = -n f_n/(n^2 - 1); f is odd as z1 is, so chat_1, which would push by a cosine, is 0",
        left(a_n * sp.cos(n * theta)),
        sp.diff(f_n * sp.sin(n * theta), theta),
        label="a_n",
    )
    d.equal(
        "second order, n = 1: the frequency moves by W = -f_1/2",
        "then nothing pushes in resonance",
        -2 * W * sp.cos(theta) - sp.diff(f_1 * sp.sin(theta), theta),
        0,
        by=lambda expr: expr.subs(W, -f_1 / 2).doit(),
        label="W",
    )
    d.equal(
        "third order, n = 1: h is the fundamental of (M' - chat_0) z2 + M'' z1^2/2",
        "z1 and M(cos) - chat_0 cos have no fundamental, so W does not matter",
        sp.solve(sp.diff((h - chat2) * sp.cos(theta), theta), chat2)[0],
        h,
        shown=chat2,
        label="chat_2",
    )


def _height(d: Derivation) -> None:
    """Expand the highest velocity, which is to be 1."""
    place, B, others, a_1 = sp.symbols("tau_1 B A a_1", real=True)
    top = eta * place
    z = sp.cos(top) + eta * B * top + eta**2 * (a_1 + others)
    rise = B * place - place**2 / 2 + a_1 + others
    d.equal(
        "the velocity at theta = eta tau_1, to second order",
        "z1(0) = 0 and z1'(0) = B, the sum of n b_n; z2(0) = a_1 + A, A the sum of the other a_n",
        sp.series(z, eta, 0, 3).removeO(),
        1 + eta**2 * rise,
    )
    d.equal(
        "it is highest at tau_1 = B",
        "there its derivative vanishes",
        sp.solve(sp.diff(rise, place), place)[0],
        B,
        shown=place,
    )
    d.equal(
        "and 1 there",
        "the orbit grazes the belt's speed",
        sp.solve(rise.subs(place, B), a_1)[0],
        -(B**2) / 2 - others,
        shown=a_1,
        label="a_1",
    )


# -- polynomial laws -------------------------------------------------------------------------------


def _by_phase(expr: Expr) -> Expr:
    """Differentiate a Laurent polynomial in E = exp(i theta) with respect to theta."""
    return sp.expand(sp.I * E * sp.diff(expr, E))


def _harmonic(expr: Expr, n: int) -> Expr:
    """Return the coefficient of E^n of a Laurent polynomial."""
    return sp.expand(expr).coeff(E, n)


def _degree(expr: Expr) -> int:
    powers = [term.as_powers_dict().get(E, 0) for term in sp.Add.make_args(sp.expand(expr))]
    return int(max(powers, default=0))


def _cosine(n: int) -> Expr:
    return (E**n + E**-n) / 2


def _sine(n: int) -> Expr:
    return (E**n - E**-n) / (2 * sp.I)


def expansion(law: Expr) -> dict[str, Any]:
    """Expand the grazing orbit of a law that is a polynomial in v.

    Returns
    -------
    dict
        "M", "slope" and "curvature" on cos(theta), "z1", "z2", "W", "chat_0" and "chat_2", where E stands for
        exp(i theta).
    """
    w = sp.Dummy("w")
    M = sp.expand(law.subs(v, V * (1 - w)))
    on_circle = [sp.expand(sp.diff(M, w, n).subs(w, _cosine(1))) for n in range(3)]
    first = 2 * _harmonic(on_circle[0], 1)
    z1 = sp.Add(
        *[2 * _harmonic(on_circle[0], n) * n / (n**2 - 1) * _sine(n) for n in range(2, _degree(on_circle[0]) + 1)]
    )
    pushed = sp.expand((on_circle[1] - first) * z1)
    f = [2 * sp.I * _harmonic(pushed, n) for n in range(_degree(pushed) + 1)]
    a = [-n * f[n] / (n**2 - 1) for n in range(2, len(f))]
    bend = sp.Add(
        *[2 * _harmonic(on_circle[0], n) * n**2 / (n**2 - 1) for n in range(2, _degree(on_circle[0]) + 1)]
    )
    z2 = (-(bend**2) / 2 - sp.Add(*a)) * _cosine(1) + sp.Add(*[part * _cosine(n) for n, part in enumerate(a, 2)])
    last = sp.expand((on_circle[1] - first) * z2 + on_circle[2] * z1**2 / 2)
    return {
        "M": on_circle[0], "slope": on_circle[1], "curvature": on_circle[2],
        "z1": z1, "z2": z2, "W": -f[1] / 2 if len(f) > 1 else sp.Integer(0),
        "chat_0": first, "chat_2": 2 * _harmonic(last, 1),
    }  # fmt: skip


def threshold(law: Expr) -> Expr:
    """Return c of a polynomial law to second order, in V, N, m, k and the law's parameters."""
    found = expansion(law)
    ratio = N**2 / (V**2 * k * m)
    first, second = (sp.factor(found[name]) for name in ("chat_0", "chat_2"))
    return N / V * (first + ratio * second)


def _polynomial_law(d: Derivation, law: Expr) -> None:
    """Put the expansion of a polynomial law into the equations of the three orders."""
    x = expansion(law)
    z0, z1, z2 = _cosine(1), x["z1"], x["z2"]
    pull = x["slope"] - x["chat_0"]
    M, Z1, Z2 = (sp.Function(name, real=True) for name in ("M", "z1", "z2"))
    circle = sp.cos(theta)

    def shown(part: Expr, pushed: Expr) -> Expr:
        return sp.Derivative(part, (theta, 2)) + part - sp.Derivative(pushed, theta)

    def balance(part: Expr, pushed: Expr) -> Expr:
        return _by_phase(_by_phase(part)) + part - _by_phase(pushed)

    d.equal(
        "its z1 solves the first order",
        "with E = exp(i theta) every term is a polynomial in E and 1/E, and d/dtheta is i E d/dE",
        balance(z1, x["M"] - x["chat_0"] * z0),
        0,
        shown=shown(Z1(theta), M(circle) - chat0 * circle),
    )
    d.equal(
        "its z2 solves the second order",
        "likewise",
        balance(z2, pull * z1) - 2 * x["W"] * z0,
        0,
        shown=shown(Z2(theta), (sp.Function("M'")(circle) - chat0) * Z1(theta)) - 2 * W * circle,
    )
    d.equal(
        "the fundamental of (M' - chat_0) z2 + M'' z1^2/2",
        "the coefficients of E and 1/E are equal, and their sum is that of cos(theta)",
        _harmonic(pull * z2 + x["curvature"] * z1**2 / 2, -1) * 2,
        sp.factor(x["chat_2"]),
        shown=chat2,
    )
    d.equal(
        "the orbit grazes the belt's speed",
        "z2(0) = -z1'(0)^2/2",
        sp.factor(z2.subs(E, 1)),
        sp.factor(-(_by_phase(z1).subs(E, 1) ** 2) / 2),
        shown=Z2(0),
    )

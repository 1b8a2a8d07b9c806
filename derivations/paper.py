"""The paper's equations as they are printed, each once, by their numbers.

H.-I. Won and J. Chung, Stick-slip vibration of an oscillator with damping, Nonlinear Dynamics (2016).
Where the paper writes |v_r| inside an integral, the variable is u; the velocity of the mass, where it
is a variable of its own, is `velocity`.
"""

from collections.abc import Mapping
from typing import Any

import sympy as sp

from stickslip_sym import laws
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.symbols import N, V, a, b, c, k, m, mu, t, u

motion = sp.Function("x", real=True)(t)
t_P, t_Q = sp.symbols("t_P t_Q", real=True)
velocity = sp.Symbol("xdot", real=True)

exponential = {name: parameter.symbol for name, parameter in laws.exponential.parameters.items()}
polynomial = {name: parameter.symbol for name, parameter in laws.polynomial.parameters.items()}


def over_cycle(integrand: Expr) -> Expr:
    """Integrate over the time T from P to Q."""
    return sp.Integral(integrand, (t, t_P, t_Q))


def value(expr: Expr, time: Expr) -> Expr:
    """Return the value of an expression at a time."""
    return expr.subs(t, time)


def equations(replaced: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return the printed equations, some replaced by others.

    (5) is its right side; (10) its left side, equal to 0; (3), (4), (8), (9), (11) to (13) and
    (15) to (18) are the right sides that define mu, mu_L, f, c, S, a, b and c.
    """
    speed = sp.diff(motion, t)
    mu_s, mu_m, alpha = (exponential[name] for name in ("mu_s", "mu_m", "alpha"))
    v_m = polynomial["v_m"]
    aV = alpha * V
    printed = {
        "(3)": mu_m + (mu_s - mu_m) * sp.exp(-alpha * u),
        "(4)": mu_s - 3 * (mu_s - mu_m) / (2 * v_m) * u + (mu_s - mu_m) / (2 * v_m**3) * u**3,
        "(5)": m * (value(speed, t_Q) ** 2 - value(speed, t_P) ** 2) / 2,
        "(8)": -a * u + b,
        "(9)": N * (a * (velocity - V) + b),
        "(10)": (b - a * V) * N * (value(motion, t_Q) - value(motion, t_P)) + (a * N - c) * over_cycle(speed**2),
        "(11)": a * N,
        "(12)": sp.Integral((mu(V - velocity) - (-a * (V - velocity) + b)) ** 2 * velocity**2, (velocity, -V, V)),
        "(13)": sp.Integral((mu(u) + a * u - b) ** 2 * (V - u) ** 2, (u, 0, 2 * V)),
        "(15) a": 5 / (2 * V**5) * sp.Integral(mu(u) * (V - u) ** 3, (u, 0, 2 * V)),
        "(15) b": sp.Integral(mu(u) * (V - u) ** 2 * (8 * V - 5 * u), (u, 0, 2 * V)) / (2 * V**4),
        "(16)": 5 * N / (2 * V**5) * sp.Integral(mu(u) * (V - u) ** 3, (u, 0, 2 * V)),
        "(17)": 5
        * N
        * (mu_s - mu_m)
        * sp.exp(-aV)
        * ((6 * aV + aV**3) * sp.cosh(aV) - (6 + 3 * aV**2) * sp.sinh(aV))
        / (V**5 * alpha**4),
        "(18)": (mu_s - mu_m) * N * (21 * v_m**2 - 26 * V**2) / (14 * v_m**3),
        "transition speed": sp.sqrt(sp.Rational(21, 26)) * v_m,
    }
    unknown = (replaced or {}).keys() - printed.keys()
    if unknown:
        raise KeyError(f"no printed equation is called {', '.join(sorted(unknown))}")
    return printed | dict(replaced or {})


def equation_of_motion_force() -> Expr:
    """Return the friction force that Newton's law (2) asks for, f = m x'' + c x' + k x."""
    return m * sp.diff(motion, t, 2) + c * sp.diff(motion, t) + k * motion

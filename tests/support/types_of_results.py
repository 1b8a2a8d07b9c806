"""What type checkers know of results: mypy reads this, and refuses it where one of these types is another."""

from typing import assert_type

import numpy as np
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.aliases import Condition, Expr, FloatArray, Mpf


def types_of_results(law: ss.FrictionLaw, oscillator: ss.Oscillator, speeds: FloatArray) -> None:
    """Use results as a program does; nothing runs it."""
    assert_type(ss.pure_slip_damping(law, oscillator).value, float)
    assert_type(ss.pure_slip_damping(law, V=0.5, N="9.81").value, float)
    assert_type(ss.pure_slip_damping(law, V=speeds, N=9.81).value, FloatArray)
    assert_type(ss.pure_slip_damping(law, oscillator).relative_error, float | None)
    assert_type(ss.derive(law)(V=0.5, N=9.81), float)
    assert_type(ss.slope_average(law)(V=speeds, N=np.float64(9.81)), FloatArray)
    assert_type(law.mu(0.5), float)
    assert_type(law.slope(speeds), FloatArray)
    fits = ss.fit(speeds, speeds)
    assert_type(fits[0], ss.results.Fit)
    assert_type(fits["linear"], ss.results.Fit)
    assert_type(fits[:2], tuple[ss.results.Fit, ...])
    assert_type(ss.margins(law, oscillator).threshold.value, float)
    assert_type(ss.simulate(law, oscillator, t_end=1.0), ss.results.Trajectory)


def types_of_expressions(expr: Expr, condition: Condition, number: Mpf) -> None:
    """Use expressions: each line with a comment is refused, or the comment is; nothing runs it."""
    assert_type(2 * expr**2 + 1, Expr)
    assert_type(sp.exp(expr), Expr)
    assert_type(sp.diff(expr, ss.symbols.v), Expr)
    assert_type(sp.Rational(1, 2) + 1, sp.Rational)
    assert_type(expr < 1, Condition)
    assert_type(number + 1, Mpf)
    expr.nonsense(1)  # type: ignore[attr-defined]
    expr.subs(1).nonsense  # type: ignore[attr-defined]  # noqa: B018
    expr + "1"  # type: ignore[operator]
    expr + condition  # type: ignore[operator]
    condition + 1  # type: ignore[operator]
    sp.diff(None)  # type: ignore[call-overload]
    number.nonsense()  # type: ignore[attr-defined]
    ss.derive("exponential").expr.nonsense  # type: ignore[attr-defined]  # noqa: B018

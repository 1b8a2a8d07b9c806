"""A criterion at the ends of its range, V -> 0 and V -> infinity, and the belt speeds at which it vanishes.

A criterion averages -N mu' over slip speeds from 0 to 2 V with a bounded weight of unit integral. So where mu' has
a finite limit as v falls to 0, every criterion tends to -N times that as V does, and likewise at infinity; where
mu' grows like v^n, a criterion grows like the mean of (1 + s)^n. What is left is the limit of the slope: by
rules where they serve, else by SymPy in a process that is killed when its time is up.
"""

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.formula.derivation.closed_form import ClosedForm
from stickslip_sym.formula.derivation.tidy import tidy
from stickslip_sym.formula.integration import search
from stickslip_sym.model.law import FrictionLaw

__all__ = ["Ends", "Zeros", "ends", "zeros"]

_SPEEDS = 10.0 ** np.linspace(-12, 12, 385)  # belt speeds in m/s between which a sign is looked at
_ROOT = float(4 * np.finfo(np.float64).eps)
_BOUNDED = (sp.tanh, sp.atan, sp.erf, sp.sin, sp.cos)


@dataclass(frozen=True)
class Ends:
    """What a criterion tends to.

    Attributes
    ----------
    at_rest : sympy.Expr or None
        Its limit as V falls to 0; None where it was not found.
    far : sympy.Expr or None
        Its limit as V grows, or its leading term there if that has V in it; None where it was not found.
    """

    at_rest: Expr | None
    far: Expr | None


def ends(form: ClosedForm, *, time_limit: float = 5.0) -> Ends:
    """Return the limits of a criterion for low and for high belt speeds.

    Parameters
    ----------
    form : ClosedForm
    time_limit : float
        Seconds that SymPy may take where rules do not serve, for both.
    """
    # Positive, where the slip speed may be 0: only then SymPy knows that exp(-v) falls.
    speed = symbols.V
    slope = form.law.slope_expr.xreplace({symbols.v: speed})
    deadline = time.monotonic() + time_limit
    at_rest, far = _slope_at_rest(slope, deadline), _slope_far(slope, form, deadline)
    return Ends(
        *(None if found is None else tidy(-symbols.N * found, form.law.expr, speed) for found in (at_rest, far))
    )


def _slope_at_rest(slope: Expr, deadline: float) -> Expr | None:
    if slope.has(sp.Piecewise):
        return None  # its first piece may end at 0
    roots = [power for power in slope.atoms(sp.Pow) if power.base.subs(symbols.V, 0) == 0]
    if all(power.exp.is_nonnegative for power in roots):
        value = slope.subs(symbols.V, 0)  # what is finite there is continuous
        if not value.has(sp.zoo, sp.nan, sp.oo):
            return value
    return search.limit(slope, symbols.V, sp.S.Zero, deadline)


def _slope_far(slope: Expr, form: ClosedForm, deadline: float) -> Expr | None:
    """Return the limit of a criterion over -N, or its leading term, as V grows."""
    V = symbols.V
    monomials: dict[int, Expr] = {}
    for term in sp.Add.make_args(sp.expand(slope)):
        coefficient, power = term.as_independent(V)[0], sp.degree(term, V) if term.is_polynomial(V) else None
        if power is not None:
            monomials[power] = monomials.get(power, 0) + coefficient
            continue
        growth = _growth(term)
        if growth is None or not growth < 0:
            return search.limit(slope, V, sp.oo, deadline)
    monomials = {power: sp.factor(total) for power, total in monomials.items() if sp.factor(total) != 0}
    top = max(monomials, default=0)
    constant = monomials.get(top, sp.S.Zero)
    return constant * form.criterion.mean_power(top) * V**top


def _growth(expr: Expr) -> Expr | None:
    """Return a bound on the power of V like which an expression grows; None where no rule gives one."""
    V = symbols.V
    if not expr.has(V) or isinstance(expr, _BOUNDED):
        return sp.S.Zero
    if expr == V:
        return sp.S.One
    if isinstance(expr, sp.exp | sp.sech):
        argument = expr.args[0]
        inside = None if argument.is_Add else _growth(argument)
        dies = inside is not None and inside.is_positive and (argument.is_negative or isinstance(expr, sp.sech))
        return -sp.oo if dies else None
    parts = [_growth(argument) for argument in expr.args]
    if any(part is None for part in parts):
        return None
    if expr.is_Mul:
        return sp.Add(*parts)
    if expr.is_Add:
        return sp.Max(*parts)
    if expr.is_Pow and not expr.exp.has(V):
        # Terms of opposite signs may leave a base smaller than its largest term: no bound for one over it.
        cancels = expr.base.is_Add and not all(term.is_positive for term in expr.base.args)
        return None if expr.exp.is_negative and cancels else parts[0] * expr.exp
    return None


@dataclass(frozen=True)
class Zeros:
    """The belt speeds at which a criterion vanishes: the transition speeds of the undamped oscillator.

    Attributes
    ----------
    formula : sympy.Expr or None
        The one positive zero, where it has a formula.
    values : tuple of float or None
        The zeros for typical parameters, in m/s; None where there is a formula, or they are not known.
    everywhere : bool
        Whether the criterion is 0 at all belt speeds.
    """

    formula: Expr | None
    values: tuple[float, ...] | None
    everywhere: bool = False


def zeros(form: ClosedForm) -> Zeros:
    """Return the belt speeds at which a criterion vanishes, by formula or for the typical parameters."""
    V = symbols.V
    if form.expr == 0:
        return Zeros(None, None, True)
    numerator = sp.numer(sp.together(form.expr))
    if numerator.is_polynomial(V):
        polynomial = sp.Poly(sp.expand(numerator), V)
        powers = [monomial[0] for monomial in polynomial.monoms()]
        if len(powers) == 1:
            return Zeros(None, ())
        if len(powers) == 2 and powers[1] == 0:
            found = sp.factor(-polynomial.nth(0) / polynomial.nth(powers[0])) ** sp.Rational(1, powers[0])
            if found.is_positive:
                return Zeros(found, None)
    law = form.law.typical()
    if law.missing:
        return Zeros(None, None)
    return Zeros(None, _crossings(law, form))


def _crossings(law: FrictionLaw, form: ClosedForm) -> tuple[float, ...] | None:
    """Return the belt speeds at which the criterion of a bound law changes its sign; None if it has no value."""
    values: dict[str, Any] = {name: float(value) for name, value in law.values.items()}

    def per_force(V: ArrayLike) -> Any:
        return form(V=V, N=1.0, **values)

    grid = _SPEEDS if law.v_max is None else _SPEEDS[float(law.v_max) >= 2 * _SPEEDS]
    try:
        c = per_force(grid)
    except StickSlipError:
        return None
    # Far above and below the scale of a law its criterion may have rounded to 0, which is no crossing.
    places = np.flatnonzero(c[:-1] * c[1:] < 0)
    return tuple(float(brentq(per_force, grid[i], grid[i + 1], xtol=1e-300, rtol=_ROOT)) for i in places)

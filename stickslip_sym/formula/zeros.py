"""The belt speeds at which a criterion vanishes: by formula, or as numbers for typical parameters."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.model.law import FrictionLaw

__all__ = ["Zeros", "zeros"]

_SPEEDS = 10.0 ** np.linspace(-12, 12, 385)  # belt speeds in m/s between which a sign is looked at
_ROOT = float(4 * np.finfo(np.float64).eps)


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

"""The belt speeds at which a criterion vanishes: by formula, or as numbers for typical parameters."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from scipy.optimize import brentq

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.model.law import FrictionLaw

_SPEEDS = 10.0 ** np.linspace(-12, 12, 385)  # belt speeds in m/s between which a sign is looked at
_ROOT = float(4 * np.finfo(np.float64).eps)


@dataclass(frozen=True)
class Zeros:
    """The belt speeds at which a criterion vanishes: the transition speeds of the undamped oscillator."""

    formula: Expr | None = None
    values: tuple[float, ...] | None = None
    everywhere: bool = False


def zeros(form: ClosedForm) -> Zeros:
    """Return the belt speeds at which a criterion vanishes, by formula or for the typical parameters."""
    if form.expr == 0:
        return Zeros(everywhere=True)
    numerator = sp.numer(sp.together(form.expr))
    if numerator.is_polynomial(symbols.V):
        match sp.Poly(sp.expand(numerator), symbols.V).terms():
            case [_]:
                return Zeros(values=())
            case [((power,), highest), ((0,), constant)]:
                found = sp.factor(-constant / highest) ** sp.Rational(1, power)
                if found.is_positive:
                    return Zeros(found)
    law = form.law.typical()
    return Zeros() if law.missing else Zeros(values=_crossings(law, form))


def _crossings(law: FrictionLaw, form: ClosedForm) -> tuple[float, ...] | None:
    """Return the belt speeds at which the criterion of a bound law changes its sign; None if it has no value."""
    values: dict[str, Any] = {name: float(value) for name, value in law.values.items()}
    grid = _SPEEDS if law.v_max is None else _SPEEDS[float(law.v_max) >= 2 * _SPEEDS]
    try:
        c = form(V=grid, N=1.0, **values)
    except StickSlipError:
        return None

    def per_force(V: float) -> Any:
        return form(V=V, N=1.0, **values)

    # Far above and below the scale of a law its criterion may have rounded to 0, which is no crossing.
    places = np.flatnonzero(c[:-1] * c[1:] < 0)
    return tuple(float(brentq(per_force, grid[i], grid[i + 1], xtol=1e-300, rtol=_ROOT)) for i in places)

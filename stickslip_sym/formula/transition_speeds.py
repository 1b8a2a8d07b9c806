"""The belt speeds at which a criterion vanishes, the transition speeds of the undamped oscillator, where exact.

That is by formula; for typical parameters as the zeros of a rational function, which are those of a polynomial and
counted exactly; or where the slope of mu has one sign. Others are critical values of the belt speed at c = 0.
"""

from dataclasses import dataclass, replace
from enum import Enum

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.functions import write_sech
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.model.expression.letters import substitute_numbers


class Sign(Enum):
    """The sign of a criterion that vanishes nowhere."""

    POSITIVE = 1
    NEGATIVE = -1


@dataclass(frozen=True)
class TransitionSpeeds:
    """The belt speeds at which a criterion vanishes.

    - `formula`: the only one, in terms of the parameters.
    - `values`: all in m/s, ascending; None where they are not known exactly.
    - `sign`: that of the criterion at all belt speeds, where the slope of mu has one sign.
    - `at_typical_values`: whether values and sign are those for the typical parameters.
    - `everywhere`: whether it vanishes at all belt speeds.
    """

    formula: Expr | None = None
    values: tuple[float, ...] | None = None
    everywhere: bool = False
    sign: Sign | None = None
    at_typical_values: bool = False


def transition_speeds(form: ClosedForm) -> TransitionSpeeds:
    """Return the belt speeds at which a criterion vanishes, by formula or for the typical parameters."""
    if form.expr == 0:
        return TransitionSpeeds(everywhere=True)
    if (sign := _sign_of_average(form, {})) is not None:
        return TransitionSpeeds(values=(), sign=sign)
    if form.general is not None:
        vanishing = transition_speeds(form.general)
        if vanishing.formula is not None:
            return replace(vanishing, formula=substitute_numbers(vanishing.formula, form.meanings))
        if vanishing.everywhere:
            return vanishing
        return _speeds_at_typical_values(form)
    numerator = sp.numer(sp.together(form.expr))
    if numerator.is_polynomial(symbols.V):
        match sp.Poly(sp.expand(numerator), symbols.V).terms():
            case [_]:
                return TransitionSpeeds(values=())
            case [((power,), highest), ((0,), constant)]:
                speed = sp.factor(-constant / highest) ** sp.Rational(1, power)
                if speed.is_positive:
                    return TransitionSpeeds(speed)
    return _speeds_at_typical_values(form)


def _speeds_at_typical_values(form: ClosedForm) -> TransitionSpeeds:
    law = form.law.typical()
    if law.missing:
        return TransitionSpeeds()
    point = law.point
    sign = _sign_of_average(form, point)
    values = _zeros_of_rational_function(form.expr, point)
    if sign is not None:
        values = ()
    return TransitionSpeeds(values=values, sign=sign, at_typical_values=bool(point))


def _sign_of_average(form: ClosedForm, point: Substitution) -> Sign | None:
    """Return the sign of an average of a slope of one sign at all slip speeds; None where that is not known."""
    mu = sp.Add(*(term.expr for term in form.terms))
    if mu.has(sp.Piecewise) or not _is_average(form.criterion):
        return None
    # With V for v, which is positive where a slip speed may be 0.
    slope = write_sech(sp.diff(mu, symbols.v)).xreplace({**point, symbols.v: symbols.V})
    if slope.is_positive:
        return Sign.NEGATIVE
    return Sign.POSITIVE if slope.is_negative else None


def _is_average(criterion: Criterion) -> bool:
    """Whether the weight is negative nowhere."""
    if not criterion.is_polynomial:
        return True
    inside = [root for root in criterion.from_rest.real_roots() if 0 < root < 2]
    return all(inside.count(root) % 2 == 0 for root in inside)


def _zeros_of_rational_function(expr: Expr, point: Substitution) -> tuple[float, ...] | None:
    """Return all zeros of a rational function of V at rational values of its parameters; None for another one."""
    per_force = expr.xreplace({symbols.N: sp.S.One, **point})
    if not per_force.is_rational_function(symbols.V):
        return None
    polynomial = sp.Poly(sp.numer(sp.cancel(per_force)), symbols.V)
    if not all(c.is_Rational for c in polynomial.all_coeffs()):
        return None
    roots = (float(root) for root, _ in polynomial.real_roots(multiple=False, radicals=False))
    return tuple(root for root in roots if root > 0)

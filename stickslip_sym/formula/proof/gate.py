"""The gate: every closed form is compared with its definition before it is returned.

At random points both sides are enclosed: the formula in ball arithmetic, the definition by integrals of the
profile with proved bounds, which know no antiderivative. A right formula overlaps; one off in the thirtieth digit
does not.
"""

import math
import random
from collections.abc import Sequence
from contextlib import suppress
from fractions import Fraction

import sympy as sp
from flint import acb, arb

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Substitution
from stickslip_sym.core.balls import ball, ball_value
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.functions import write_sech
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.numbers import SEED, exact
from stickslip_sym.core.precision import mp, refined, working_precision
from stickslip_sym.core.status import Status
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.enclosure import Enclosure, average_enclosure, enclosure_of
from stickslip_sym.formula.exact import to_ball
from stickslip_sym.formula.proof.proving import DIGITS_OF_EQUALITY, MOST_PROOF_BITS, Verdict
from stickslip_sym.model.expression.pieces import kinks_at
from stickslip_sym.model.lipschitz import BITS_OF_SIGNS
from stickslip_sym.model.terms import shapes_of

GATE_POINTS = 12
GATE_DIGITS = 30
_MOST_DRAWS = 40
_DECADES = 3  # to both sides of 1, of the belt speed and of every shape, for the points of the gate
_EXPONENT_DECADES = 0.5  # of a shape that is an exponent
_BITS_OF_GATE = math.ceil((GATE_DIGITS + 1) * math.log2(10))  # of these digits, and the last is rounded
_NEARLY_AT_REST = sp.Rational(1, 10**6)  # of the belt speed, where a profile is looked at


def verify(profile: Expr, criterion: Criterion, closed: Expr, conditions: Sequence[Condition] = ()) -> Verdict:
    """Compare a formula F(V) for the average of a profile g(v) with its definition at seeded log-uniform points.

    Points at which the profile has no real value, or a side is not known to `GATE_DIGITS` digits, say nothing, nor
    do those at which one of the `conditions` between shapes does not hold; others are drawn in their place.
    ESTIMATED if too few say something.
    """
    rng = random.Random(SEED)
    exponents = {node.exp for node in profile.atoms(sp.Pow)}
    for node in profile.atoms(sp.exp):
        if node.has(sp.log):
            exponents |= node.free_symbols
    compared = 0
    enclosed = True
    for _ in range(_MOST_DRAWS):
        check_time()
        point = {}
        for symbol in (symbols.V, *shapes_of(profile)):
            decades = _EXPONENT_DECADES if symbol in exponents else _DECADES
            sign = 1 if symbol.is_nonnegative else rng.choice((-1, 1))
            point[symbol] = sign * exact(f"{10 ** rng.uniform(-decades, decades):.6g}", symbol.name)
        if not all(condition.subs(point) for condition in conditions) or not _is_real(profile, criterion, point):
            continue
        try:
            expected, surely = _definition(profile, criterion, point)
            value, too = to_ball(write_sech(closed), point, GATE_DIGITS + 1)
        except (InputError, NotConverged):
            continue
        got = enclosure_of(value)
        digits = GATE_DIGITS if surely else DIGITS_OF_EQUALITY
        if not all(_is_known(side, profile, point, digits) for side in (expected, got)):
            continue
        if not expected.overlaps(got):
            words = ", ".join(f"{symbol} = {float(value):g}" for symbol, value in point.items())
            sides = expected.apart(got)
            return Verdict(Status.REFUTED, f"formula {sides[1]}, definition {sides[0]} at {words}", point)
        compared += 1
        enclosed = enclosed and surely and too
        if compared == GATE_POINTS or not closed.free_symbols:
            what = f"enclosures to {GATE_DIGITS}" if enclosed else f"quadrature to {DIGITS_OF_EQUALITY}"
            return Verdict(Status.CHECKED, f"agrees with {what} digits at {GATE_POINTS} random points")
    evidence = f"only {compared} of {_MOST_DRAWS} points could be compared with the definition"
    return Verdict(Status.ESTIMATED, evidence)


def _profile_at_share(profile: Expr, point: Substitution, share: Expr) -> acb:
    """Return a profile at a share of V."""
    with working_precision(BITS_OF_SIGNS):
        return ball_value(profile, {**point, symbols.v: share * point[symbols.V]})


def _is_real(profile: Expr, criterion: Criterion, point: Substitution) -> bool:
    """Whether a profile is real at the lowest and at the highest slip speeds that its average needs."""
    shares = (sp.S.One,) if criterion.weight is None else (_NEARLY_AT_REST, sp.Integer(2))
    values = [_profile_at_share(profile, point, share) for share in shares]
    return all(value.is_finite() and value.imag.contains(0) for value in values)


def _is_known(side: Enclosure, profile: Expr, point: Substitution, digits: int) -> bool:
    """Whether an enclosure says enough: to so many digits, or that the value is 0 beside g(V)/V."""
    if side.digits >= digits:
        return True
    size = abs(complex(_profile_at_share(profile, point, sp.S.One))) / float(point[symbols.V])
    return 0 in side and side.radius <= Fraction(size) / 10**GATE_DIGITS


def _definition(profile: Expr, criterion: Criterion, point: Substitution) -> tuple[Enclosure, bool]:
    """Return the average by its definition, and whether it is enclosed for certain."""
    shapes = {symbol: value for symbol, value in point.items() if symbol != symbols.V}

    def enclosed() -> arb:
        value = average_enclosure(profile, shapes, criterion, ball(point[symbols.V]).real)
        if not value.is_finite():
            raise NotConverged(f"the average of {profile} is not enclosed")
        return value

    with suppress(InputError, NotConverged):
        return enclosure_of(refined(enclosed, _BITS_OF_GATE, MOST_PROOF_BITS)), True
    # The profile is infinite at v = 0, or holds a function that is not enclosed.
    mu = function_of([symbols.v], profile.xreplace(shapes), mp.context)
    kinks = kinks_at(profile, shapes)
    number = exact(quadrature.average(mu, kinks, criterion, point[symbols.V], GATE_DIGITS), "value")
    margin = abs(number) / 10**DIGITS_OF_EQUALITY
    return Enclosure.of(number - margin, number + margin), False

"""The gate: every closed form is compared with its definition before it is returned.

At seeded points both sides are enclosed: the formula in ball arithmetic, the definition by integrals of mu with
proved bounds, which know no antiderivative. A right formula overlaps; one off in the thirtieth digit does not.
"""

import random
from collections.abc import Mapping
from fractions import Fraction

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.balls import working_precision
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import exact
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.criteria.enclosure import Enclosure, enclose, enclosure_of
from stickslip_sym.formula.derivation.proving import Status, Verdict
from stickslip_sym.formula.evaluation.conditioning import without_squares
from stickslip_sym.formula.evaluation.exact import to_ball
from stickslip_sym.model.law import FrictionLaw

__all__ = ["GATE_POINTS", "verify"]

GATE_POINTS = 12
GATE_DIGITS = 30
_GATE_SEED = 1
_MOST_DRAWS = 40
_DECADES = (-3, 3)  # of every parameter, for the points of the gate
_EXPONENT_DECADES = (-0.5, 0.7)  # of a parameter that is an exponent
_BITS = 160  # to which the ends of an enclosed formula are rounded outwards
_LOST = 3  # digits that are not claimed where a side is not enclosed


def verify(law: FrictionLaw, criterion: Criterion, expr: Expr) -> Verdict:
    """Compare a formula for the damping coefficient with its definition at seeded log-uniform points.

    Points at which the law has no real value, or a side is not known to `GATE_DIGITS` digits, say nothing; others
    are drawn in their place. UNDECIDED if too few say something.
    """
    rng = random.Random(_GATE_SEED)
    symbol_of = {"V": symbols.V, "N": symbols.N} | {n: p.symbol for n, p in law.parameters.items()}
    exponents = {node.exp for node in law.expr.atoms(sp.Pow)}
    compared, enclosed = 0, True
    for _ in range(_MOST_DRAWS):
        check_time()
        values = {
            name: f"{10 ** rng.uniform(*(_EXPONENT_DECADES if symbol in exponents else _DECADES)):.6g}"
            for name, symbol in symbol_of.items()
        }
        if law.v_max is not None:
            # Every piece of the law has its turn, the lowest speeds too.
            share = rng.uniform(0, 1) if compared % 2 else 10 ** rng.uniform(2 * _DECADES[0], 0)
            values["V"] = f"{share * float(law.v_max / 2):.6g}"
        scene = {name: values.pop(name) for name in ("V", "N")}
        point = {symbol_of[name]: exact(value, name) for name, value in (scene | values).items()}
        try:
            expected, surely = _definition(law.bind(**values), criterion, scene)
            value, too = to_ball(without_squares(expr), point, GATE_DIGITS)
        except (InputError, NotConverged):
            continue
        with working_precision(_BITS):
            got = enclosure_of(value)
        if not all(_is_known(side, law.bind(**values), scene) for side in (expected, got)):
            continue
        if not expected.overlaps(got):
            words = ", ".join(f"{symbol} = {float(value):g}" for symbol, value in point.items())
            sides = expected.apart(got)
            return Verdict(Status.REFUTED, f"formula {sides[1]}, quadrature {sides[0]} at {words}", point)
        compared, enclosed = compared + 1, enclosed and surely and too
        if compared == GATE_POINTS:
            digits, what = (GATE_DIGITS, "enclosures") if enclosed else (GATE_DIGITS - _LOST, "quadrature")
            return Verdict(Status.CHECKED, f"agrees with {what} to {digits} digits at {GATE_POINTS} seeded points")
    return Verdict(Status.UNDECIDED, f"only {compared} of {_MOST_DRAWS} points could be compared with quadrature")


def _is_known(side: Enclosure, law: FrictionLaw, scene: Mapping[str, str]) -> bool:
    """Whether an enclosure says enough: to its last digits, or that the value is 0 beside N mu(V)/V."""
    if side.digits >= GATE_DIGITS - _LOST:
        return True
    terms = float(scene["N"]) / float(scene["V"]) * abs(float(law.mu(float(scene["V"]))))
    return 0 in side and side.radius <= Fraction(terms) / 10**GATE_DIGITS


def _definition(law: FrictionLaw, criterion: Criterion, scene: Mapping[str, str]) -> tuple[Enclosure, bool]:
    """Return the criterion by its definition, and whether it is enclosed for certain."""
    try:
        return enclose(law, criterion, **scene, digits=GATE_DIGITS), True
    except (InputError, NotConverged):  # mu is infinite at v = 0, or holds a function that is not enclosed
        return _around(quadrature.damping(law, criterion, **scene, digits=GATE_DIGITS)), False


def _around(value: Mpf) -> Enclosure:
    """Return a value that is right to all but the last digits as an enclosure."""
    number = exact(value, "value")
    room = abs(number) / sp.Integer(10) ** (GATE_DIGITS - _LOST)
    return Enclosure.of(number - room, number + room)

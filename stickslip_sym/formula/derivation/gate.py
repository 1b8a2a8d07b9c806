"""The gate: every closed form is compared with quadrature of its definition before anybody sees it."""

import random
from typing import Any

import mpmath
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import exact
from stickslip_sym.criteria import quadrature
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.derivation.proving import Status, Verdict
from stickslip_sym.formula.evaluation.exact import exact_value
from stickslip_sym.model.law import FrictionLaw

__all__ = ["GATE_POINTS", "verify"]

GATE_POINTS = 12
GATE_DIGITS = 30
_GATE_SEED = 1
_MOST_DRAWS = 40
_DECADES = (-3, 3)  # of every parameter, for the points of the gate
_EXPONENT_DECADES = (-0.5, 0.7)  # of a parameter that is an exponent
_COUNTS_AS_ZERO = mpmath.mpf("1e-350")  # quadrature returns 0 for less than 1e-400 of its integrand


def verify(law: FrictionLaw, criterion: Criterion, expr: Any) -> Verdict:
    """Compare a formula for the damping coefficient with quadrature at seeded log-uniform points.

    Points at which the law has no real value, or the criterion is too small for either side to tell from 0, say
    nothing; others are drawn in their place. UNDECIDED if too few say something.
    """
    rng = random.Random(_GATE_SEED)
    symbol_of = {"V": symbols.V, "N": symbols.N} | {n: p.symbol for n, p in law.parameters.items()}
    exponents = {node.exp for node in law.expr.atoms(sp.Pow)}
    compared = 0
    for _ in range(_MOST_DRAWS):
        check_time()
        values = {
            name: f"{10 ** rng.uniform(*(_EXPONENT_DECADES if symbol in exponents else _DECADES)):.6g}"
            for name, symbol in symbol_of.items()
        }
        if law.v_max is not None:
            # Every piece has its turn, the lowest speeds too.
            share = rng.uniform(0, 1) if compared % 2 else 10 ** rng.uniform(2 * _DECADES[0], 0)
            values["V"] = f"{share * float(law.v_max / 2):.6g}"
        scene = {name: values.pop(name) for name in ("V", "N")}
        point = {symbol_of[name]: exact(value, name) for name, value in (scene | values).items()}
        try:
            expected = quadrature.damping(law.bind(**values), criterion, **scene, digits=GATE_DIGITS)
            got = exact_value(expr, law.slope_expr, point, GATE_DIGITS)
        except (InputError, NotConverged):
            continue
        allowed = max(abs(expected) * mpmath.mpf(10) ** (3 - GATE_DIGITS), _COUNTS_AS_ZERO)
        if abs(got - expected) > allowed:
            words = ", ".join(f"{symbol} = {float(value):g}" for symbol, value in point.items())
            apart = 8 + max(0, mpmath.mag(expected) - mpmath.mag(got - expected)) // 3
            sides = [mpmath.nstr(value, apart) for value in (got, expected)]
            found = f"formula {sides[0]}, quadrature {sides[1]} at {words}"
            return Verdict(Status.REFUTED, found, point)
        compared += 1
        if compared == GATE_POINTS:
            evidence = f"agrees with quadrature to {GATE_DIGITS - 3} digits at {GATE_POINTS} seeded points"
            return Verdict(Status.CHECKED, evidence)
    evidence = f"only {compared} of {_MOST_DRAWS} points could be compared with quadrature"
    return Verdict(Status.UNDECIDED, evidence)

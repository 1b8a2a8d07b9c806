"""Proving and refuting equations.

An equation is PROVED when the difference of its sides reduces to zero by exact symbolic computation,
for every value of its symbols and every choice of its unknown functions; functions in pieces are compared
piece by piece. Where a theorem is needed on the way (a change of variable, the fundamental theorem of
calculus) a `by` names it, and its hypotheses are checked. An equation that fails is REFUTED by a point:
exact values at which balls around its sides, integrals and all, have no number in common. Where these balls leave
it open, no more than ESTIMATED is claimed.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import sympy as sp
from flint import acb, arb
from sympy.core.function import AppliedUndef

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Substitution
from stickslip_sym.core.balls import ball, ball_function, integrated
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.numbers import SEED
from stickslip_sym.core.precision import refined
from stickslip_sym.core.status import Status
from stickslip_sym.criteria.enclosure import enclosure_of, smooth_pieces
from stickslip_sym.formula.exact import formula_ball
from stickslip_sym.formula.proof.normal_form import normal_form, single_limit
from stickslip_sym.formula.proof.theorems import By
from stickslip_sym.model.expression.pieces import kinks_at
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.shown import Shown

_RANDOM_POINTS = 8
DIGITS_OF_EQUALITY = 22  # of the sides' size, to which they are the same, errors included, to count as equal
_SIZE_OF_ZERO = arb("1e-60")  # what both sides may differ by where they are 0
_STRICT = (sp.StrictLessThan, sp.StrictGreaterThan)
_BINDING = (sp.Integral, sp.Sum, sp.Product, sp.Derivative, sp.Subs, sp.Limit, sp.Lambda)
_BITS_OF_VALUE = math.ceil((DIGITS_OF_EQUALITY + 3) * math.log2(10))  # bits of a value that are enough
MOST_PROOF_BITS = 784  # of working precision
_MOST_INTEGRAND_VALUES = 3000  # of an integrand, before its integral counts as unknown, as that over a pole does


@dataclass(frozen=True)
class Verdict(Shown, DataResult):
    """The outcome of a proof or a check.

    Attributes
    ----------
    status : Status
    evidence : str
        What was computed, in words.
    point : mapping
        For REFUTED: the values of symbols and functions at which it fails.
    """

    status: Status
    evidence: str
    point: Substitution = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.status.value}: {self.evidence}"

    def __repr__(self) -> str:
        return f"Verdict: {self}"


def prove_equal(lhs: Expr, rhs: Expr, by: By | None = None, checked: Verdict | None = None) -> Verdict:
    """Prove or refute lhs = rhs, both of which may hold unknown functions, and integrals over them."""
    lhs = sp.sympify(lhs)
    rhs = sp.sympify(rhs)
    obstacle = "the difference does not reduce to 0"
    try:
        if _vanishes((lhs if by is None else by(lhs)) - rhs):
            return Verdict(Status.PROVED, "the difference reduces to 0")
    except ValueError as error:
        obstacle = str(error)
    if checked is not None:
        # Points at which the formula has no value say nothing to a check, and are a fault of the formula.
        refuted, *_ = _judge_at_points((rhs,), lambda value: True)
        return refuted or Verdict(checked.status, f"{checked.evidence}; {obstacle}", checked.point)
    verdict, agreed, open_ = _judge_at_points((lhs, rhs), _judge_equal)
    if verdict is not None:
        return verdict
    obstacle += open_
    if agreed < _RANDOM_POINTS // 2:
        evidence = (
            f"only {agreed} of {_RANDOM_POINTS} points say anything to {DIGITS_OF_EQUALITY} digits; {obstacle}"
        )
        return Verdict(Status.ESTIMATED, evidence)
    where = (
        f"{_RANDOM_POINTS} random points"
        if agreed == _RANDOM_POINTS
        else f"{agreed} of {_RANDOM_POINTS} random points"
    )
    return Verdict(Status.CHECKED, f"equal to {DIGITS_OF_EQUALITY} digits at {where}; {obstacle}")


def prove_positive(expr: Expr) -> Verdict:
    """Prove or refute expr > 0, from the signs of its symbols."""
    if any(form.is_positive for form in (expr, sp.factor(expr), sp.expand(expr))):
        return Verdict(Status.PROVED, "every factor is positive")
    verdict, positive, _ = _judge_at_points((expr,), _judge_positive)
    if verdict is not None:
        return verdict
    if positive < _RANDOM_POINTS:
        return Verdict(
            Status.ESTIMATED, f"its sign is certain at {positive} of {_RANDOM_POINTS} random points only"
        )
    return Verdict(Status.CHECKED, f"positive at {_RANDOM_POINTS} random points; no proof was found")


# -- exactly ---------------------------------------------------------------------------------------


def _vanishes(difference: Expr) -> bool:
    """Tell whether a difference is known to be 0: as it stands, or on every piece of the functions in it.

    Functions in pieces whose places are the same take the same piece at every speed, and are replaced together. A
    function under an integral or a derivative takes more than one of its pieces, and stays.
    """
    # What both sides have in common goes first: over one denominator it would be many times longer.
    difference = sp.Add(*sp.Add.make_args(sp.expand_mul(difference)))
    if difference == 0 or normal_form(difference) == 0:
        return True
    nodes = sorted(difference.atoms(sp.Piecewise), key=sp.count_ops)
    if not nodes or any(node.has(sp.Piecewise) for node in difference.atoms(*_BINDING)):
        return False
    outer = _conditions(nodes[-1])
    together = [node for node in nodes if _conditions(node) == outer]
    return all(
        _vanishes(difference.xreplace({node: node.args[i][0] for node in together})) for i in range(len(outer))
    )


def _conditions(node: sp.Piecewise) -> list[Expr | Condition]:
    """Return the conditions of a function in pieces, each a < b as b - a."""
    conditions = [holds for _, holds in node.args]
    return [sp.cancel(holds.gts - holds.lts) if isinstance(holds, _STRICT) else holds for holds in conditions]


# -- at points -------------------------------------------------------------------------------------


def _judge_at_points(sides: tuple[Expr, ...], judge: Callable[..., str | bool]) -> tuple[Verdict | None, int, str]:
    """Judge balls at random points; return a refutation, how many points agreed, what was in the way.

    `judge` says in words how the sides fail, or whether they surely hold.
    """
    holds = 0
    obstacles = ""
    for point in _random_points(*sides):
        judged: str | bool = False
        try:
            judged = judge(*[_value(side, point) for side in sides])
        except NotConverged as failure:
            obstacles += f"; {failure}"
        except ArithmeticError:
            judged = "a side is not finite"
        if isinstance(judged, str):
            where = ", ".join(_word(key, value) for key, value in point.items())
            return Verdict(Status.REFUTED, f"{judged} at {where}", point), holds, obstacles
        holds += judged
    return None, holds, obstacles


def _judge_equal(left: acb, right: acb) -> str | bool:
    if not left.overlaps(right):
        part, unit = ("imag", "i") if left.real.overlaps(right.real) else ("real", "")
        first = enclosure_of(getattr(left, part))
        second = enclosure_of(getattr(right, part))
        return "left {0}{2}, right {1}{2}".format(*first.apart(second), unit)
    size = left.abs_upper() + right.abs_upper()
    return bool((left - right).abs_upper() <= (size * arb(10) ** -DIGITS_OF_EQUALITY).max(_SIZE_OF_ZERO))


def _judge_positive(value: acb) -> str | bool:
    if value.real <= 0 or not value.imag.contains(0):
        return f"it is {value.str(8, radius=False)}"
    return bool(value.real > 0)


def _random_points(*sides: Expr) -> list[dict[Expr, Expr]]:
    """Draw seeded exact values for all symbols, and polynomials for all unknown functions."""
    rng = random.Random(SEED)
    # Units are atoms with a name and a positive value, like symbols.
    atoms = set().union(*(side.atoms(sp.AtomicExpr) for side in sides))
    units = {atom for atom in atoms if not (atom.is_number or atom.is_Symbol)}
    symbols = sorted(units.union(*(side.free_symbols for side in sides)), key=str)
    functions = sorted({node.func for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    w = sp.Symbol("w", real=True)
    points = []
    for number in range(_RANDOM_POINTS):
        point: dict[Any, Expr] = {}
        either = 0  # symbols so far that may have either sign
        for symbol in symbols:
            value = sp.Rational(rng.randint(3, 40), rng.randint(7, 13))
            if symbol.is_nonnegative is None:
                # The first three such symbols run through all combinations of signs.
                if number >> (either % 3) & 1:
                    value *= -1
                either += 1
            point[symbol] = value
        for function in functions:
            coefficients = [sp.Rational(rng.randint(-9, 9), 7) for _ in range(8)]
            point[function] = sp.Lambda(w, sp.Poly(coefficients, w).as_expr())
        points.append(point)
    return points


def _word(key: Expr, value: Expr) -> str:
    if isinstance(value, sp.Lambda):
        return f"{key}({value.variables[0]}) = {value.expr}"
    return f"{key} = {value}"


# -- a ball around a value, integrals and all -------------------------------------------------------


def _value(expr: Expr, point: Substitution) -> acb:
    """Return a ball around an expression at exact values of its symbols and examples of its functions.

    Raises
    ------
    NotConverged
        Where none is found.
    ArithmeticError
        For an expression that has no finite value, for certain.
    """
    for function, example in point.items():
        if isinstance(example, sp.Lambda):
            expr = expr.replace(function, example)
    expr = expr.replace(lambda node: isinstance(node, sp.Derivative | sp.Subs), lambda node: node.doit())
    if expr.has(AppliedUndef):
        raise NotConverged(f"{expr} holds a function without a value")
    values = {key: value for key, value in point.items() if not isinstance(value, sp.Lambda)}
    found = expr.atoms(sp.Integral)
    inner = set().union(*(arg.atoms(sp.Integral) for node in found for arg in node.args))
    outer = {node: sp.Dummy(real=True) for node in found - inner}
    expr = expr.xreplace(outer).xreplace(values)
    if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise ZeroDivisionError
    integrals = {symbol: node.subs(values).doit(integrals=False) for node, symbol in outer.items()}

    def computed() -> acb:
        return formula_ball(expr, {symbol: _ball_of_integral(integral) for symbol, integral in integrals.items()})[
            0
        ]

    try:
        value = refined(computed, _BITS_OF_VALUE, MOST_PROOF_BITS)
    except InputError as failure:
        raise NotConverged(str(failure)) from None
    except ValueError:
        raise ZeroDivisionError from None
    if not value.is_finite():
        raise NotConverged("its value is not certain")
    return value


def _ball_of_integral(integral: Expr) -> acb:
    """Return a ball around an integral of numbers at the working precision; not finite where Arb finds none."""
    if not isinstance(integral, sp.Integral) or integral.function.is_polynomial(*integral.variables):
        return formula_ball(integral.doit(), {})[0]
    try:
        x, *limits = single_limit(integral)
    except ValueError as failure:
        raise NotConverged(str(failure)) from None
    if not all(limit.is_real and limit.is_finite for limit in limits):
        raise NotConverged(f"the limits of {integral} are not finite")
    low, high = sorted(limits)
    total = acb(0)
    for way, start, end in ((1, sp.Max(low, 0), high), (-1, sp.Max(-high, 0), -low)):
        if start < end:
            # The slip speed is nonnegative, and what SymPy simplifies by that holds on either side of 0.
            f = integral.function.xreplace({x: way * symbols.v})
            if way < 0 and f.has(sp.Piecewise):
                raise NotConverged(f"{integral} is in pieces below 0")
            ends = [start, *(kink for kink in kinks_at(f, {}) if start < kink < end), end]
            for piece, (left, right) in zip(smooth_pieces(f, {}, ends), pairwise(ends), strict=True):
                integrand = ball_function(piece, symbols.v, {})
                total += integrated(integrand, ball(left), ball(right), eval_limit=_MOST_INTEGRAND_VALUES)
    return total if limits[0] == low else -total

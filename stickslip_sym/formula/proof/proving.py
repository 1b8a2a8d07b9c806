"""Proving and refuting equations.

An equation is PROVED when the difference of its sides reduces to zero by exact symbolic computation,
for every value of its symbols and every choice of its unknown functions; functions in pieces are compared
piece by piece. Where a theorem is needed on the way (a change of variable, the fundamental theorem of
calculus) a `by` names it, and its hypotheses are checked. An equation that fails is REFUTED by a point:
exact values at which its sides differ by more than the errors of evaluating them. Where these errors leave
it open, no more than ESTIMATED is claimed.
"""

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass, field

import mpmath
import sympy as sp
from sympy.core.function import AppliedUndef

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.status import Status
from stickslip_sym.formula.proof.certain import NotFinite, certain_value
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.formula.proof.theorems import By
from stickslip_sym.output import markup

__all__ = ["Verdict", "prove_equal", "prove_positive"]

_SAMPLES = 8
_DIGITS = 30
_AGREE = mpmath.mpf("1e-22")  # of the sides' size: what they may differ by, errors included, to count as equal
_STRICT = (sp.StrictLessThan, sp.StrictGreaterThan)
_BINDING = (sp.Integral, sp.Sum, sp.Product, sp.Derivative, sp.Subs, sp.Limit, sp.Lambda)
_NOTHING = mpmath.mpf("1e-60")  # what both sides may differ by where they are 0


@dataclass(frozen=True)
class Verdict:
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
    point: Mapping[Expr, Expr] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.status.value}: {self.evidence}"

    def __repr__(self) -> str:
        return f"Verdict: {self}"

    def _repr_html_(self) -> str:
        return markup.block(str(self))


def prove_equal(lhs: Expr, rhs: Expr, by: By | None = None, checked: Verdict | None = None) -> Verdict:
    """Prove or refute lhs = rhs.

    Parameters
    ----------
    lhs, rhs : sympy.Expr
        May hold unknown functions, and integrals over them.
    by : callable, optional
        A theorem that is applied to `lhs` first.
    checked : Verdict, optional
        What is known otherwise, and holds if the proof fails; without it the sides are compared at points.

    Returns
    -------
    Verdict
        PROVED, or REFUTED with a point, or CHECKED if the sides agree at points but the proof failed,
        or ESTIMATED if too few points say anything.
    """
    lhs, rhs = sp.sympify(lhs), sp.sympify(rhs)
    obstacle = "the difference does not reduce to 0"
    try:
        if _vanishes((lhs if by is None else by(lhs)) - rhs):
            return Verdict(Status.PROVED, "the difference reduces to 0")
    except ValueError as error:
        obstacle = str(error)
    if checked is not None:
        return Verdict(checked.status, f"{checked.evidence}; {obstacle}", checked.point)
    return _compared(lhs, rhs, obstacle)


def _vanishes(difference: Expr) -> bool:
    """Tell whether a difference is known to be 0: as it stands, or on every piece of the functions in it.

    Functions in pieces whose places are the same take the same piece at every speed, and are replaced together. A
    function under an integral or a derivative takes more than one of its pieces, and stays.
    """
    if normal_form(difference) == 0:
        return True
    nodes = sorted(difference.atoms(sp.Piecewise), key=sp.default_sort_key)
    if not nodes or any(node.has(sp.Piecewise) for node in difference.atoms(*_BINDING)):
        return False
    outer = next(
        node for node in nodes if not any(node in other.atoms(sp.Piecewise) for other in nodes if other != node)
    )
    together = [node for node in nodes if _same_places(node, outer)]
    return bool(together) and all(
        _vanishes(difference.xreplace({node: node.args[i].expr for node in together}))
        for i in range(len(outer.args))
    )


def _same_places(first: Expr, second: Expr) -> bool:
    """Tell whether two functions in pieces are known to change from piece to piece at the same places.

    Each condition but the last is one strict inequality, a < b, known by b - a.
    """
    if len(first.args) != len(second.args):
        return False
    *before, last = [(one.cond, other.cond) for one, other in zip(first.args, second.args, strict=True)]
    return last == (sp.true, sp.true) and all(
        isinstance(one, _STRICT)
        and isinstance(other, _STRICT)
        and normal_form((one.gts - one.lts) - (other.gts - other.lts)) == 0
        for one, other in before
    )


def _compared(lhs: Expr, rhs: Expr, obstacle: str) -> Verdict:
    """Compare two sides at points: refute them only if they differ by more than the errors of both."""
    agreed = 0
    for point in _points(lhs, rhs):
        sides: list[tuple[Mpf, Mpf]] = []
        for name, side in (("left", lhs), ("right", rhs)):
            try:
                sides.append(certain_value(side, point))
            except NotFinite as failure:
                evidence = f"{name} is not finite, {failure}, at {_words(point)}"
                return Verdict(Status.REFUTED, evidence, point)
            except NotConverged as failure:
                obstacle = f"{obstacle}; {failure}"
        if len(sides) < 2:
            continue
        with mpmath.workdps(4 * _DIGITS):
            (left, left_error), (right, right_error) = sides
            difference, error, size = abs(left - right), left_error + right_error, abs(left) + abs(right)
            if difference > error:
                shown = [mpmath.nstr(value, _digits_apart(size, difference)) for value in (left, right)]
                evidence = f"left {shown[0]}, right {shown[1]} at {_words(point)}"
                return Verdict(Status.REFUTED, evidence, point)
            agreed += difference + error <= max(_AGREE * size, _NOTHING)
    if agreed < _SAMPLES // 2:
        evidence = f"only {agreed} of {_SAMPLES} points say anything to {_DIGITS - 8} digits; {obstacle}"
        return Verdict(Status.ESTIMATED, evidence)
    where = f"{_SAMPLES} seeded points" if agreed == _SAMPLES else f"{agreed} of {_SAMPLES} seeded points"
    return Verdict(Status.CHECKED, f"equal to {_DIGITS - 8} digits at {where}; {obstacle}")


def _digits_apart(size: Mpf, difference: Mpf) -> int:
    """Return how many digits of two numbers show that they differ."""
    return 8 + max(0, int(math.log10(2) * (mpmath.mag(size) - mpmath.mag(difference))))


def prove_positive(expr: Expr) -> Verdict:
    """Prove or refute expr > 0, from the signs of its symbols."""
    for form in (expr, sp.factor(expr), sp.expand(expr)):
        if form.is_positive:
            return Verdict(Status.PROVED, "every factor is positive")
    known = 0
    for point in _points(expr):
        try:
            value, error = certain_value(expr, point)
        except NotFinite as failure:
            return Verdict(Status.REFUTED, f"it is not finite, {failure}, at {_words(point)}", point)
        except NotConverged:
            continue
        if isinstance(value, mpmath.mpc) or value <= -error:
            return Verdict(Status.REFUTED, f"it is {mpmath.nstr(value, 8)} at {_words(point)}", point)
        known += value > error
    if known < _SAMPLES:
        return Verdict(Status.ESTIMATED, f"its sign is certain at {known} of {_SAMPLES} seeded points only")
    return Verdict(Status.CHECKED, f"positive at {_SAMPLES} seeded points; no proof was found")


def _points(*sides: Expr) -> list[dict[Expr, Expr]]:
    """Draw seeded exact values for all symbols, and polynomials for all unknown functions."""
    random_numbers = random.Random(20160428)
    # Units are atoms with a name and a positive value, like symbols.
    atoms = set().union(*(side.atoms(sp.AtomicExpr) for side in sides))
    units = {atom for atom in atoms if not (atom.is_number or atom.is_Symbol)}
    symbols = sorted(units.union(*(side.free_symbols for side in sides)), key=str)
    functions = sorted({node.func for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    points = []
    for number in range(_SAMPLES):
        point: dict[Expr, Expr] = {}
        either = 0  # symbols so far that may have either sign
        for symbol in symbols:
            value = sp.Rational(random_numbers.randint(3, 40), random_numbers.randint(7, 13))
            if symbol.is_nonnegative is None:
                # The first three such symbols run through all combinations of signs.
                value *= -1 if number >> (either % 3) & 1 else 1
                either += 1
            point[symbol] = value
        for function in functions:
            w = sp.Symbol("w", real=True)
            coefficients = [sp.Rational(random_numbers.randint(-9, 9), 7) for _ in range(8)]
            point[function] = sp.Lambda(w, sp.Poly(coefficients, w).as_expr())
        points.append(point)
    return points


def _words(point: Mapping[Expr, Expr]) -> str:
    return ", ".join(
        f"{key}({value.variables[0]}) = {value.expr}" if isinstance(value, sp.Lambda) else f"{key} = {value}"
        for key, value in point.items()
    )

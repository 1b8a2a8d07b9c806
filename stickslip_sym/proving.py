"""Proving and refuting equations.

An equation is PROVED when the difference of its sides reduces to zero by exact symbolic computation,
for every value of its symbols and every choice of its unknown functions. Where a theorem is needed on
the way (a change of variable, the fundamental theorem of calculus) a `by` names it, and its hypotheses
are checked. An equation that fails is REFUTED by a point: exact values at which its sides differ.
"""

import random
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef

from stickslip_sym import html_text
from stickslip_sym.normal_form import normal_form
from stickslip_sym.theorems import By

__all__ = ["Status", "Verdict", "prove_equal", "prove_positive"]

_SAMPLES = 8
_DIGITS = 30
_AGREE = sp.Rational(1, 10**22)  # sides that differ by less, relatively, count as equal in a sample


class Status(Enum):
    """What a computation established."""

    PROVED = "PROVED"
    CHECKED = "CHECKED"
    REFUTED = "REFUTED"


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
    point: Mapping[Any, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.status.value}: {self.evidence}"

    def __repr__(self) -> str:
        return f"Verdict: {self}"

    def _repr_html_(self) -> str:
        return html_text.block(str(self))


def prove_equal(lhs: Any, rhs: Any, by: By | None = None) -> Verdict:
    """Prove or refute lhs = rhs.

    Parameters
    ----------
    lhs, rhs : sympy.Expr
        May hold unknown functions, and integrals over them.
    by : callable, optional
        A theorem that is applied to `lhs` first.

    Returns
    -------
    Verdict
        PROVED, or REFUTED with a point, or CHECKED if no point refutes it but the proof failed.
    """
    lhs, rhs = sp.sympify(lhs), sp.sympify(rhs)
    obstacle = "the difference does not reduce to 0"
    try:
        if normal_form((lhs if by is None else by(lhs)) - rhs) == 0:
            return Verdict(Status.PROVED, "the difference reduces to 0")
    except ValueError as error:
        obstacle = str(error)
    for point in _points(lhs, rhs):
        left, right = (_at(side, point) for side in (lhs, rhs))
        if not (left.is_finite and right.is_finite and left.is_number and right.is_number):
            evidence = f"left {left}, right {right}, not both finite, at {_words(point)}"
            return Verdict(Status.REFUTED, evidence, point)
        if abs(left - right) > _AGREE * (abs(left) + abs(right)):
            evidence = f"left {sp.N(left, 8)}, right {sp.N(right, 8)} at {_words(point)}"
            return Verdict(Status.REFUTED, evidence, point)
    return Verdict(Status.CHECKED, f"equal to {_DIGITS - 8} digits at {_SAMPLES} seeded points; {obstacle}")


def prove_positive(expr: Any) -> Verdict:
    """Prove or refute expr > 0, from the signs of its symbols."""
    for form in (expr, sp.factor(expr), sp.expand(expr)):
        if form.is_positive:
            return Verdict(Status.PROVED, "every factor is positive")
    for point in _points(expr):
        value = _at(expr, point)
        if not value.is_positive:
            return Verdict(Status.REFUTED, f"it is {sp.N(value, 8)} at {_words(point)}", point)
    return Verdict(Status.CHECKED, f"positive at {_SAMPLES} seeded points; no proof was found")


def _points(*sides: Any) -> list[dict[Any, Any]]:
    """Draw seeded exact values for all symbols, and polynomials for all unknown functions."""
    random_numbers = random.Random(20160428)
    # Units are atoms with a name and a positive value, like symbols.
    atoms = set().union(*(side.atoms(sp.AtomicExpr) for side in sides))
    units = {atom for atom in atoms if not (atom.is_number or atom.is_Symbol)}
    symbols = sorted(units.union(*(side.free_symbols for side in sides)), key=str)
    functions = sorted({node.func for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    points = []
    for number in range(_SAMPLES):
        point: dict[Any, Any] = {}
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


def _at(expr: Any, point: Mapping[Any, Any]) -> Any:
    """Evaluate at a point to `_DIGITS` digits; integrals of polynomials exactly, others by quadrature."""
    functions = {key: value for key, value in point.items() if isinstance(value, sp.Lambda)}
    for function, example in functions.items():
        expr = expr.replace(function, example)
    expr = expr.replace(lambda node: isinstance(node, sp.Derivative | sp.Subs), lambda node: node.doit())
    expr = expr.subs({key: value for key, value in point.items() if key not in functions})
    expr = expr.replace(lambda node: isinstance(node, sp.Integral), _polynomial_integral)
    try:
        return sp.N(expr, _DIGITS)
    except TypeError:  # SymPy's way to say that an integrand is infinite somewhere
        return sp.nan


def _polynomial_integral(integral: Any) -> Any:
    variable = integral.variables[0]
    return integral.doit() if integral.function.is_polynomial(variable) else integral


def _words(point: Mapping[Any, Any]) -> str:
    return ", ".join(
        f"{key}({value.variables[0]}) = {value.expr}" if isinstance(value, sp.Lambda) else f"{key} = {value}"
        for key, value in point.items()
    )

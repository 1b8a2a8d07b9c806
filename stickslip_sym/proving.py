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
from typing import Any, Protocol

import sympy as sp
from sympy.core.function import AppliedUndef

__all__ = [
    "Antiderivative", "By", "ChangeOfVariable", "Status", "Verdict",
    "normal_form", "prove_equal", "prove_positive",
]  # fmt: skip

_BOUND = sp.Symbol("xi", real=True)  # the variable of every integral in normal form
_SAMPLES = 6
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


class By(Protocol):
    """A theorem applied to the left side of an equation; raises ValueError where it does not apply."""

    def __call__(self, expr: Any) -> Any:
        """Return an expression equal to `expr`."""


@dataclass(frozen=True)
class ChangeOfVariable:
    """Substitute ``old = image(new)``, with `image` linear, in every integral over `old`."""

    old: Any
    new: Any
    image: Any

    def __call__(self, expr: Any) -> Any:
        """Apply integration by substitution; a linear image is one to one and smooth."""
        slope = sp.diff(self.image, self.new)
        if slope.has(self.new) or not slope.is_nonzero:
            raise ValueError(f"{self.old} = {self.image} is not linear in {self.new}")

        def substitute(integral: Any) -> Any:
            variable, *limits = integral.limits[0]
            if variable != self.old:
                return integral
            low, high = (sp.expand((limit - self.image.subs(self.new, 0)) / slope) for limit in limits)
            return sp.Integral(integral.function.subs(self.old, self.image) * slope, (self.new, low, high))

        return expr.replace(lambda node: isinstance(node, sp.Integral), substitute)


@dataclass(frozen=True)
class Antiderivative:
    """Evaluate every integral over `variable` whose integrand is the derivative of `primitive`."""

    primitive: Any
    variable: Any

    def __call__(self, expr: Any) -> Any:
        """Apply the fundamental theorem of calculus, after differentiating the primitive."""

        def evaluate(integral: Any) -> Any:
            variable, low, high = integral.limits[0]
            if variable != self.variable:
                return integral
            if normal_form(sp.diff(self.primitive, variable) - integral.function) != 0:
                raise ValueError(f"{self.primitive} is not an antiderivative of {integral.function}")
            ends = [self.primitive.subs(variable, end) for end in (high, low)]
            if any(end.has(sp.zoo, sp.oo, sp.nan) for end in ends):
                raise ValueError(f"{self.primitive} is not finite on [{low}, {high}]")
            return ends[0] - ends[1]

        return expr.replace(lambda node: isinstance(node, sp.Integral), evaluate)


def normal_form(expr: Any) -> Any:
    """Reduce an expression so that zero becomes 0.

    Integrals are split by linearity, and done where their integrand is a polynomial. Hyperbolic
    functions become exponentials. What is left is put over one denominator, and its numerator expanded:
    a polynomial in symbols, exponentials and integrals of unknown functions.
    """
    expr = sp.sympify(expr).replace(lambda node: isinstance(node, sp.Integral), _split)
    expr = expr.rewrite((sp.sinh, sp.cosh, sp.tanh), sp.exp)
    numerator, _ = sp.fraction(sp.together(expr))
    return sp.expand(numerator)


def _split(integral: Any) -> Any:
    """Split an integral over its sum, do the polynomial parts, and give the others one notation.

    That is: limits from low to high, and one name for the variable of integration.
    """
    variable, low, high = integral.limits[0]
    low, high = sp.expand(low), sp.expand(high)
    sign = 1
    if sp.default_sort_key(low) > sp.default_sort_key(high):
        low, high, sign = high, low, -1
    total = sp.Integer(0)
    for term in sp.Add.make_args(sp.expand(integral.function.subs(variable, _BOUND))):
        constant, rest = term.as_independent(_BOUND, as_Add=False)
        if rest.is_polynomial(_BOUND):
            part = sp.integrate(rest, (_BOUND, low, high))
        else:
            part = sp.Integral(rest, (_BOUND, low, high))
        total += sign * constant * part
    return total


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
        if value <= 0:
            return Verdict(Status.REFUTED, f"it is {sp.N(value, 8)} at {_words(point)}", point)
    return Verdict(Status.CHECKED, f"positive at {_SAMPLES} seeded points; no proof was found")


def _points(*sides: Any) -> list[dict[Any, Any]]:
    """Draw seeded exact values for all symbols, and polynomials for all unknown functions."""
    random_numbers = random.Random(20160428)
    # Units are atoms with a name and a positive value, like symbols.
    atoms = set().union(*(side.free_symbols | side.atoms(sp.AtomicExpr) for side in sides))
    bound = {variable for side in sides for node in side.atoms(sp.Integral) for variable in node.variables}
    symbols = sorted((atom for atom in atoms - bound if not atom.is_number), key=str)
    functions = sorted({node.func for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    points = []
    for _ in range(_SAMPLES):
        point: dict[Any, Any] = {}
        for symbol in symbols:
            value = sp.Rational(random_numbers.randint(3, 40), random_numbers.randint(7, 13))
            sign = -1 if symbol.is_nonnegative is None and random_numbers.random() < 0.5 else 1
            point[symbol] = sign * value
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
    return sp.N(expr, _DIGITS)


def _polynomial_integral(integral: Any) -> Any:
    variable = integral.variables[0]
    return integral.doit() if integral.function.is_polynomial(variable) else integral


def _words(point: Mapping[Any, Any]) -> str:
    return ", ".join(
        f"{key}({value.variables[0]}) = {value.expr}" if isinstance(value, sp.Lambda) else f"{key} = {value}"
        for key, value in point.items()
    )

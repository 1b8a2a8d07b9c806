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
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import combinations, pairwise

import mpmath
import sympy as sp
from flint import arb
from sympy.core.function import AppliedUndef
from sympy.core.relational import Relational

from stickslip_sym.core.aliases import Expr, Mpf
from stickslip_sym.core.errors import InputError, NotConverged
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.core.precision import from_mpmath, in_mpmath, refined, working_precision
from stickslip_sym.core.status import Status
from stickslip_sym.formula.exact import formula_ball
from stickslip_sym.formula.proof.normal_form import normal_form, single_limit
from stickslip_sym.formula.proof.theorems import By
from stickslip_sym.output import markup

_SAMPLES = 8
_DIGITS = 22  # of the sides' size, to which they are the same, errors included, to count as equal
_NOTHING = mpmath.mpf("1e-60")  # what both sides may differ by where they are 0
_STRICT = (sp.StrictLessThan, sp.StrictGreaterThan)
_BINDING = (sp.Integral, sp.Sum, sp.Product, sp.Derivative, sp.Subs, sp.Limit, sp.Lambda)

_ENOUGH, _MOST_BITS = 83, 784  # bits of a value, 25 digits, that are enough; of working precision
_QUADRATURE_DIGITS = 60  # next to an end, a root's integral below the rounding of x is below 1e-30
_DEGREES = (7, 8)  # of the tanh-sinh rule: it halves its step so many times
_DEGREE_OF_SIZE = 4  # of the rule that tells how large an integrand is
_LOST = 30  # digits that count as rounding
_NEAR_BITS = 400  # for the integrand there
_NEAR = tuple(sp.Rational(1, 10**k) for k in (12, 24))  # of the way to a place where the integrand may be infinite


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
    """Prove or refute lhs = rhs, both of which may hold unknown functions, and integrals over them."""
    lhs, rhs = sp.sympify(lhs), sp.sympify(rhs)
    obstacle = "the difference does not reduce to 0"
    try:
        if _vanishes((lhs if by is None else by(lhs)) - rhs):
            return Verdict(Status.PROVED, "the difference reduces to 0")
    except ValueError as error:
        obstacle = str(error)
    if checked is not None:
        return Verdict(checked.status, f"{checked.evidence}; {obstacle}", checked.point)
    verdict, agreed, open_ = _at_points({"left": lhs, "right": rhs}, _equal)
    if verdict is not None:
        return verdict
    obstacle += open_
    if agreed < _SAMPLES // 2:
        evidence = f"only {agreed} of {_SAMPLES} points say anything to {_DIGITS} digits; {obstacle}"
        return Verdict(Status.ESTIMATED, evidence)
    where = f"{_SAMPLES} seeded points" if agreed == _SAMPLES else f"{agreed} of {_SAMPLES} seeded points"
    return Verdict(Status.CHECKED, f"equal to {_DIGITS} digits at {where}; {obstacle}")


def prove_positive(expr: Expr) -> Verdict:
    """Prove or refute expr > 0, from the signs of its symbols."""
    if any(form.is_positive for form in (expr, sp.factor(expr), sp.expand(expr))):
        return Verdict(Status.PROVED, "every factor is positive")
    verdict, positive, _ = _at_points({"it": expr}, _positive)
    if verdict is not None:
        return verdict
    if positive < _SAMPLES:
        return Verdict(Status.ESTIMATED, f"its sign is certain at {positive} of {_SAMPLES} seeded points only")
    return Verdict(Status.CHECKED, f"positive at {_SAMPLES} seeded points; no proof was found")


# -- exactly ---------------------------------------------------------------------------------------


def _vanishes(difference: Expr) -> bool:
    """Tell whether a difference is known to be 0: as it stands, or on every piece of the functions in it.

    Functions in pieces whose places are the same take the same piece at every speed, and are replaced together. A
    function under an integral or a derivative takes more than one of its pieces, and stays.
    """
    if normal_form(difference) == 0:
        return True
    nodes = sorted(difference.atoms(sp.Piecewise), key=sp.count_ops)
    if not nodes or any(node.has(sp.Piecewise) for node in difference.atoms(*_BINDING)):
        return False
    outer = _conditions(nodes[-1])
    together = [node for node in nodes if _conditions(node) == outer]
    return all(
        _vanishes(difference.xreplace({node: node.args[i].expr for node in together})) for i in range(len(outer))
    )


def _conditions(node: Expr) -> list[Expr]:
    """Return the conditions of a function in pieces, each a < b as b - a."""
    conditions = [holds for _, holds in node.args]
    return [sp.cancel(holds.gts - holds.lts) if isinstance(holds, _STRICT) else holds for holds in conditions]


# -- at points -------------------------------------------------------------------------------------


def _at_points(sides: Mapping[str, Expr], judge: Callable[..., str | bool]) -> tuple[Verdict | None, int, str]:
    """Judge values and their errors at seeded points; return a refutation, how many agreed, what was in the way.

    `judge` says in words how the sides fail, or whether they surely hold.
    """
    holds, obstacles = 0, ""
    for point in _points(*sides.values()):
        values: list[tuple[Mpf, Mpf]] = []
        judged: str | bool = False
        for name, side in sides.items():
            try:
                values.append(certain_value(side, point))
            except NotFinite as failure:
                judged = f"{name} is not finite, {failure},"
                break
            except NotConverged as failure:
                obstacles += f"; {failure}"
        if len(values) == len(sides):
            with mpmath.workdps(2 * _QUADRATURE_DIGITS):
                judged = judge(*values)
        if isinstance(judged, str):
            where = ", ".join(_word(key, value) for key, value in point.items())
            return Verdict(Status.REFUTED, f"{judged} at {where}", point), holds, obstacles
        holds += judged
    return None, holds, obstacles


def _equal(left: tuple[Mpf, Mpf], right: tuple[Mpf, Mpf]) -> str | bool:
    difference, error, size = abs(left[0] - right[0]), left[1] + right[1], abs(left[0]) + abs(right[0])
    if difference > error:
        digits = 8 + max(0, int(math.log10(2) * (mpmath.mag(size) - mpmath.mag(difference))))  # that show it
        return "left {}, right {}".format(*(mpmath.nstr(value, digits) for value, _ in (left, right)))
    return bool(difference + error <= max(size * mpmath.mpf(10) ** -_DIGITS, _NOTHING))


def _positive(of: tuple[Mpf, Mpf]) -> str | bool:
    value, error = of
    if isinstance(value, mpmath.mpc) or value <= -error:
        return f"it is {mpmath.nstr(value, 8)}"
    return bool(value > error)


def _points(*sides: Expr) -> list[dict[Expr, Expr]]:
    """Draw seeded exact values for all symbols, and polynomials for all unknown functions."""
    rng = random.Random(20160428)
    # Units are atoms with a name and a positive value, like symbols.
    atoms = set().union(*(side.atoms(sp.AtomicExpr) for side in sides))
    units = {atom for atom in atoms if not (atom.is_number or atom.is_Symbol)}
    symbols = sorted(units.union(*(side.free_symbols for side in sides)), key=str)
    functions = sorted({node.func for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    w = sp.Symbol("w", real=True)
    points = []
    for number in range(_SAMPLES):
        point: dict[Expr, Expr] = {}
        either = 0  # symbols so far that may have either sign
        for symbol in symbols:
            value = sp.Rational(rng.randint(3, 40), rng.randint(7, 13))
            if symbol.is_nonnegative is None:
                # The first three such symbols run through all combinations of signs.
                value *= -1 if number >> (either % 3) & 1 else 1
                either += 1
            point[symbol] = value
        for function in functions:
            coefficients = [sp.Rational(rng.randint(-9, 9), 7) for _ in range(8)]
            point[function] = sp.Lambda(w, sp.Poly(coefficients, w).as_expr())
        points.append(point)
    return points


def _word(key: Expr, value: Expr) -> str:
    return f"{key}({value.variables[0]}) = {value.expr}" if isinstance(value, sp.Lambda) else f"{key} = {value}"


# -- a value and its error, integrals and all -------------------------------------------------------


class NotFinite(ArithmeticError):
    """An expression that has no finite value, for certain; the message says where it fails."""


def certain_value(expr: Expr, point: Mapping[Expr, Expr]) -> tuple[Mpf, Mpf]:
    """Return an expression at exact values of its symbols and examples of its functions, and an error bound."""
    for function, example in point.items():
        if isinstance(example, sp.Lambda):
            expr = expr.replace(function, example)
    expr = expr.replace(lambda node: isinstance(node, sp.Derivative | sp.Subs), lambda node: node.doit())
    if expr.has(AppliedUndef):
        raise NotConverged(f"{expr} holds a function without a value")
    values = {key: value for key, value in point.items() if not isinstance(value, sp.Lambda)}
    integrals = expr.atoms(sp.Integral)
    inner = set().union(*(arg.atoms(sp.Integral) for node in integrals for arg in node.args))
    outer = {node: sp.Dummy(real=True) for node in integrals - inner}
    known = {symbol: from_mpmath(*_integral(node.subs(values))) for node, symbol in outer.items()}
    expr = expr.xreplace(outer).xreplace(values)
    if expr.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
        raise NotFinite("a function has no value there" if expr is sp.nan else f"it is {expr}")
    try:
        value = refined(lambda: formula_ball(expr, known)[0], _ENOUGH, _MOST_BITS)
    except InputError as failure:
        raise NotConverged(str(failure)) from None
    except (ZeroDivisionError, ValueError, OverflowError) as failure:
        raise NotFinite(str(failure) or "a function has no value there") from None
    if not value.is_finite():
        raise NotConverged("its value is not certain")
    return in_mpmath(value), in_mpmath(arb(value.rad()))


def _integral(integral: Expr) -> tuple[Mpf, Mpf]:
    """Return an integral of numbers and its error."""
    if not isinstance(integral, sp.Integral) or integral.function.is_polynomial(*integral.variables):
        return certain_value(integral.doit(), {})
    try:
        variable, low, high = single_limit(integral)
    except ValueError as failure:
        raise NotConverged(str(failure)) from None
    if not (low.is_real and high.is_real and low.is_finite and high.is_finite):
        raise NotConverged(f"the limits of {integral} are not finite")
    # As limits of the variable only: its assumptions are the user's, and must not decide anything here.
    x = sp.Dummy(variable.name, real=True)
    f = integral.function.xreplace({variable: x})
    between = [place for place in _places(f, x) if min(low, high) < place < max(low, high)]
    ends = [low, *sorted(between, key=sp.N, reverse=bool(low > high)), high]
    for left, right in pairwise(ends):
        _require_integrable(f, x, left, right - left)
        _require_integrable(f, x, right, left - right)
    function = function_of([x], f, "mpmath")
    with mpmath.workdps(_QUADRATURE_DIGITS):
        nodes = [mpmath.mpmathify(function_of([], end, "mpmath")()) for end in ends]

        def inside(place: Mpf) -> Mpf:
            return function(place) if place not in nodes else mpmath.mpf(0)  # the rule's weight there is nothing

        try:
            rough, fine = (mpmath.quad(inside, nodes, maxdegree=degree) for degree in _DEGREES)
            size = mpmath.quad(lambda place: abs(inside(place)), nodes, maxdegree=_DEGREE_OF_SIZE)
        except (ZeroDivisionError, ValueError):
            raise NotConverged("the integrand has no value somewhere") from None
        return fine, 2 * abs(fine - rough) + abs(size) * mpmath.mpf(10) ** (_LOST - _QUADRATURE_DIGITS)


def _places(f: Expr, x: Expr) -> list[Expr]:
    """Return the real places where an integrand may have a kink, a jump, or no finite value."""
    suspects = {relation.lhs - relation.rhs for relation in f.atoms(Relational)}
    suspects |= {node.args[0] for node in f.atoms(sp.Abs, sp.sign, sp.log)}
    suspects |= {a - b for node in f.atoms(sp.Min, sp.Max) for a, b in combinations(node.args, 2)}
    suspects |= {node.base for node in f.atoms(sp.Pow) if not (node.exp.is_Integer and node.exp > 0)}
    found: set[Expr] = set()
    for numerator in (sp.numer(sp.together(suspect)) for suspect in suspects):
        if numerator.has(x) and numerator.is_polynomial(x):
            polynomial = sp.Poly(numerator, x)
            if polynomial.degree() == 1:
                found.add(-polynomial.nth(0) / polynomial.nth(1))
            elif polynomial.domain.is_QQ or polynomial.domain.is_ZZ:
                found |= set(polynomial.real_roots())
    return [place for place in found if place.is_real]


def _require_integrable(f: Expr, x: Expr, place: Expr, way: Expr) -> None:
    """Refuse an integrand that grows like 1/x or faster towards a place."""
    sizes = []
    for share in _NEAR:
        with working_precision(_NEAR_BITS):
            try:
                found, _ = formula_ball(f.xreplace({x: place + share * way}), {})
            except (InputError, NotConverged, ArithmeticError, ValueError):
                return
            if not found.rel_accuracy_bits() > 3:
                return
            sizes.append(abs(in_mpmath(found)) * mpmath.mpf(share.p) / share.q)
    if sizes[0] > 0 and sizes[1] > sizes[0] / 2:
        raise NotFinite(f"the integrand grows like 1/x or faster at {place}")

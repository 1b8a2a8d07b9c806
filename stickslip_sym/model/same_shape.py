"""The law of the catalogue of which a law with numbers is an example, and the values of its parameters."""

from collections.abc import Iterator

import sympy as sp

from stickslip_sym.core.aliases import Expr, Substitution
from stickslip_sym.core.symbols import v
from stickslip_sym.model.expression.letters import is_same, substitute_numbers
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import laws
from stickslip_sym.model.terms import Term

_Equation = tuple[Expr, Expr]
"""An expression in the parameters of a law of the catalogue, and the number that it is."""


def law_of_same_shape(law: FrictionLaw) -> tuple[FrictionLaw, Substitution] | None:
    """Return a law of the catalogue and values for which it is the law given, which has no parameters; or None.

    The values are positive rational numbers. Of several laws it is the first one of the catalogue.
    """
    if law.parameters or law.curve is not None:
        return None
    kinds = _kinds(law.expr)
    for candidate in laws.values():
        if _kinds(candidate.expr) != kinds:
            continue
        values = _shared_values(candidate, law)
        if values is not None and is_same(substitute_numbers(candidate.expr, values), law.expr):
            return candidate, values
    return None


def _kinds(expr: Expr) -> set[type]:
    """Return the kinds of functions of v in a formula, that have to be the same."""
    return {type(node) for node in expr.atoms(sp.Function) if node.has(v)}


def _shared_values(candidate: FrictionLaw, law: FrictionLaw) -> dict[Expr, Expr] | None:
    """Return the values of all parameters that the terms of both laws agree in, or None."""
    equations = _equations(candidate.terms, law.terms)
    unknown = [parameter.symbol for parameter in candidate.parameters.values()]
    values: dict[Expr, Expr] = {}
    while equations is not None and len(values) < len(unknown):
        solvable = (equation for equation in equations if len(equation[0].free_symbols) == 1)
        equation = next(solvable, None)
        if equation is None:
            return None
        left, right = equation
        (symbol,) = left.free_symbols
        solutions = [value for value in sp.solve(left - right, symbol) if value.is_Rational and value > 0]
        if len(solutions) != 1:
            return None
        values[symbol] = solutions[0]
        equations = [(substitute_numbers(one, {symbol: solutions[0]}), other) for one, other in equations]
    if equations is not None:
        return {symbol: values[symbol] for symbol in unknown}
    return None


def _equations(general: tuple[Term, ...], special: tuple[Term, ...]) -> list[_Equation] | None:
    """Return equations between the terms of two laws; None where their profiles differ."""
    ones, others = (
        sp.Add(*[term.expr for term in terms if term.profile.is_polynomial(v)]) for terms in (general, special)
    )
    degree = max(sp.degree(ones, v), sp.degree(others, v), 0)
    equations = [(sp.expand(ones).coeff(v, n), sp.expand(others).coeff(v, n)) for n in range(int(degree) + 1)]
    left = [term for term in special if not term.profile.is_polynomial(v)]
    for term in general:
        if term.profile.is_polynomial(v):
            continue
        match = next((other for other in left if other.profile == term.profile), None)
        if match is None:
            return None
        left.remove(match)
        equations += _equations_of_terms(term, match)
    return None if left else equations


def _equations_of_terms(general: Term, special: Term) -> Iterator[_Equation]:
    yield general.scale, special.scale
    yield general.amplitude, special.amplitude
    for shape, meaning in general.shapes.items():
        yield meaning, special.shapes[shape]

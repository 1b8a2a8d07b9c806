"""Taking the terms of a law apart: which family a term belongs to, and its parts.

Each function returns the parts of a term of one kind, or None where the term is not of that kind. `u` is
the slip speed, nonnegative; parameters are positive.
"""

from collections.abc import Callable, Mapping

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.model.terms import split_polynomial

__all__ = [
    "as_function", "as_linear", "as_power", "as_single", "as_stretched", "first_rule",
    "minus_discriminant", "partial_fractions",
]  # fmt: skip


def first_rule(rules: Mapping[str, Callable[..., Expr]], *arguments: Expr) -> tuple[str, Expr] | None:
    """Return the name of the first rule that applies and its result, or None."""
    for name, rule in rules.items():
        result = rule(*arguments)
        if result is not None:
            return name, result
    return None


def as_single(rest: Expr, u: Expr) -> tuple[Expr, Expr] | None:
    """Match polynomial * factor, one factor that is no polynomial; return both."""
    polynomial, others = split_polynomial(rest, u)
    return (polynomial, others[0]) if len(others) == 1 else None


def as_linear(expr: Expr, u: Expr) -> tuple[Expr, Expr] | None:
    """Return (rate, shift) of rate * u + shift with rate != 0, or None."""
    if not expr.is_polynomial(u) or sp.degree(expr, u) != 1:
        return None
    rate, shift = sp.Poly(expr, u).all_coeffs()
    return rate, shift


def as_function(rest: Expr, u: Expr, function: Expr, degree: int = 1) -> tuple[Expr, ...] | None:
    """Match p(u) * function(polynomial of a degree); return p, the argument, its coefficients from the highest."""
    single = as_single(rest, u)
    if single is None or not isinstance(single[1], function):
        return None
    argument = single[1].args[0]
    if not argument.is_polynomial(u) or sp.degree(argument, u) != degree:
        return None
    return (single[0], argument, *sp.Poly(argument, u).all_coeffs())


def as_power(rest: Expr, u: Expr) -> tuple[Expr, Expr, Expr, Expr, Expr] | None:
    """Match polynomial * (rate * u + shift)**p, p no integer; return polynomial, base, rate, shift, p."""
    single = as_single(rest, u)
    if single is None or not single[1].is_Pow:
        return None
    polynomial, (base, exponent) = single[0], single[1].as_base_exp()
    linear = as_linear(base, u)
    if linear is None or exponent.has(u) or exponent.is_integer:
        return None
    return (polynomial, base, *linear, exponent)


def as_stretched(rest: Expr, u: Expr) -> tuple[Expr, Expr, Expr, Expr] | None:
    """Match p(u) * u**q * exp(-k u**d + b); return p * exp(b), q, k, d."""
    polynomial, others = split_polynomial(rest, u)
    exponentials = [factor for factor in others if isinstance(factor, sp.exp)]
    powers = [factor for factor in others if factor.is_Pow and factor.base == u]
    if len(exponentials) != 1 or len(others) != 1 + len(powers):
        return None
    exponent = sp.expand_power_base(sp.expand(exponentials[0].args[0]))
    constant, varying = exponent.as_independent(u, as_Add=True)
    factor, monomial = varying.as_independent(u, as_Add=False)
    base, d = monomial.as_base_exp()
    if base != u or d.has(u):
        return None
    q = sp.Mul(*powers).as_base_exp()[1] if powers else sp.Integer(0)
    return polynomial * sp.exp(constant), q, -factor, d


def partial_fractions(rest: Expr, u: Expr) -> tuple[Expr, list[tuple[Expr, Expr, int]]] | None:
    """Split a rational function into a polynomial and fractions (numerator, base, power).

    Bases have degree 1 or 2 and leading coefficient 1; None for a factor of higher degree, or one that is
    not known to be positive for all u >= 0.
    """
    if not rest.is_rational_function(u):
        return None
    polynomial, fractions = sp.Integer(0), []
    for term in sp.Add.make_args(sp.apart(sp.together(rest), u)):
        numerator, denominator = sp.fraction(sp.factor(term))
        constant, varying = denominator.as_independent(u, as_Add=False)
        if varying == 1:
            polynomial += numerator / constant
            continue
        base, power = varying.as_base_exp()
        monic = sp.Poly(base, u)
        if monic.degree() > 2 or not power.is_Integer:
            return None
        lead = monic.LC()
        coefficients = [sp.cancel(c / lead) for c in monic.all_coeffs()]
        if not _is_positive(coefficients):
            return None
        base = sp.Poly(coefficients, u).as_expr()
        fractions.append((numerator / (constant * lead**power), base, int(power)))
    return polynomial, fractions


def _is_positive(coefficients: list[Expr]) -> bool:
    """Tell whether a monic polynomial of degree 1 or 2 is known to be positive for all u >= 0."""
    *middle, c = coefficients[1:]
    if c == 0 and not middle:
        return True  # u itself: for u > 0, as in a piece of a law
    if not c.is_positive:
        return False
    return all(b.is_nonnegative or minus_discriminant(b, c).is_positive for b in middle)


def minus_discriminant(b: Expr, c: Expr) -> Expr:
    """Return minus the discriminant of u^2 + b u + c."""
    return sp.factor(4 * c - b**2)

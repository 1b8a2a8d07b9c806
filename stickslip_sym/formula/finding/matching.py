"""Which rule is for a term: its polynomial, the kinds of its other factors, and what they hold.

`u` is the slip speed, nonnegative; parameters are positive.
"""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import sympy as sp
from sympy.simplify.fu import TR8

from stickslip_sym.core.aliases import Expr
from stickslip_sym.model.terms import split_polynomial

Kinds = tuple[type[Expr] | tuple[type[Expr], ...], ...]


class Rule(NamedTuple):
    """How a polynomial times factors of some kinds is integrated or averaged.

    `apply` takes the polynomial, each factor that is none, and what `first_rule` was given beside; of a function
    whose argument is a polynomial of a `degree` its coefficients too. Without `kinds` it takes the product of the
    factors instead. It returns None where the rule does not apply.
    """

    name: str
    kinds: Kinds | None
    apply: Callable[..., Expr | None]
    degree: int | None = None


def first_rule(rules: Sequence[Rule], rest: Expr, kernel: Expr, u: Expr, *more: Expr) -> tuple[str, Expr] | None:
    """Return the name of the first rule that applies to a term times a polynomial, and its result, or None."""
    polynomial, factors = split_polynomial(rest, u)
    factors.sort(key=lambda factor: str(factor.func))
    functions = [_function_of_power(factor) for factor in factors]
    for name, kinds, apply, degree in rules:
        given: list[Expr | list[Expr]] = [*factors]
        if kinds is None:
            given = [sp.Mul(*factors)]
        if kinds is not None and not (len(kinds) == len(factors) and all(map(isinstance, functions, kinds))):
            continue
        if degree is not None:
            line = coefficients(functions[0].args[0], u)
            if len(line) != degree + 1:
                continue
            given = [*factors, line]
        result = apply(polynomial * kernel, *given, u, *more)
        if result is not None:
            return name, result
    return None


def _function_of_power(factor: Expr) -> Expr:
    """Return a factor, or the function of which it is a whole power."""
    base, exponent = factor.as_base_exp()
    if isinstance(base, sp.Function) and exponent.is_Integer and exponent > 0:
        return base
    return factor


def coefficients(expr: Expr, u: Expr) -> list[Expr]:
    """Return the coefficients of a polynomial in u from the highest, or no coefficient of what is none."""
    if expr.is_polynomial(u):
        return list(sp.Poly(expr, u).all_coeffs())
    return []


def argument_coefficients(node: Expr, kinds: type[Expr] | tuple[type[Expr], ...], u: Expr) -> list[Expr]:
    """Return `coefficients` of the argument of a function of some kinds; none of anything else."""
    if isinstance(node, kinds):
        return coefficients(node.args[0], u)
    return []


def as_damped_wave(factors: Expr, u: Expr) -> tuple[Expr, Expr, list[Expr], list[Expr]] | None:
    """Match exp(a u + c) cos(b u + d), or sin; return both functions, [a, c] and [b, d]."""
    exponential, wave = factors.as_independent(sp.sin, sp.cos, as_Add=False)
    rates = argument_coefficients(exponential, sp.exp, u)
    turns = argument_coefficients(wave, (sp.sin, sp.cos), u)
    if len(rates) == len(turns) == 2:
        return exponential, wave, rates, turns
    return None


def as_power(node: Expr, u: Expr) -> tuple[Expr, Expr, Expr, Expr] | None:
    """Match (rate u + shift)^p, p no integer; return base, rate, shift, p."""
    base, p = node.as_base_exp()
    line = coefficients(base, u)
    if len(line) == 2 and not (p.has(u) or p.is_integer):
        return base, line[0], line[1], p
    return None


def as_binomial(factors: Expr, u: Expr) -> tuple[Expr, Expr, Expr, Expr, Expr] | None:
    """Match u^q (b + a u^d)^p, all of a, b, d positive; return q, b, a, d, p."""
    powers = [factor.as_base_exp() for factor in sp.Mul.make_args(factors)]
    q = sp.Add(*[p for base, p in powers if base == u])
    others = [power for power in powers if power[0] != u]
    if len(others) != 1 or q.has(u):
        return None
    ((base, p),) = others
    b, power = base.as_independent(u, as_Add=True)
    a, monomial = power.as_independent(u, as_Add=False)
    of, d = monomial.as_base_exp()
    positive = a.is_positive and b.is_positive and d.is_positive
    if of == u and positive and not (p.has(u) or d.has(u)):
        return (q, b, a, d, p)
    return None


def as_stretched(factors: Expr, u: Expr) -> tuple[Expr, Expr, Expr, Expr] | None:
    """Match u^q exp(-k u^d + b); return exp(b), q, k, d."""
    power, exponential = factors.as_independent(sp.exp, as_Add=False)
    base, q = power.as_base_exp()
    if not isinstance(exponential, sp.exp) or base not in (u, 1):
        return None
    exponent = sp.expand_power_base(sp.expand(exponential.args[0]))
    constant, varying = exponent.as_independent(u, as_Add=True)
    factor, monomial = sp.factor_terms(varying).as_independent(u, as_Add=False)
    of, d = monomial.as_base_exp()
    if of == u and not d.has(u):
        return (sp.exp(constant), q if base == u else sp.Integer(0), -factor, d)
    return None


def partial_fractions(rest: Expr, u: Expr) -> tuple[Expr, list[tuple[Expr, list[Expr], int]]] | None:
    """Split a rational function into a polynomial and fractions: numerator, coefficients of the base, power.

    Bases have degree 1 or 2 and leading coefficient 1; None for a factor of higher degree, or one that is
    not known to be positive for all u >= 0.
    """
    if not rest.is_rational_function(u):
        return None
    polynomial = sp.S.Zero
    fractions = []
    for term in sp.Add.make_args(sp.apart(sp.together(rest), u)):
        numerator, denominator = sp.fraction(sp.factor(term))
        constant, varying = denominator.as_independent(u, as_Add=False)
        if varying == 1:
            polynomial += numerator / constant
            continue
        base, power = varying.as_base_exp()
        lead, *others = coefficients(base, u)
        monic = [sp.Integer(1), *(sp.cancel(c / lead) for c in others)]
        match monic[1:]:  # known to be positive for all u > 0; u itself, as in a piece of a law
            case [c]:
                positive = c == 0 or c.is_positive
            case [b, c]:
                positive = c.is_positive and (b.is_nonnegative or minus_discriminant(b, c).is_positive)
            case _:
                positive = False
        if not (power.is_Integer and positive):
            return None
        fractions.append((numerator / (constant * lead**power), monic, int(power)))
    return polynomial, fractions


def waves_apart(expr: Expr) -> Expr:
    """Write powers and products of sines and cosines as sums of them, as sin(x)^2 = (1 - cos(2 x))/2."""
    powers = [node for node in expr.atoms(sp.Pow) if isinstance(node.base, sp.sin | sp.cos)]
    products = [node for node in expr.atoms(sp.Mul) if len([f for f in node.args if f.has(sp.sin, sp.cos)]) > 1]
    if powers or products:
        return sp.expand(TR8(expr))
    return expr


def minus_discriminant(b: Expr, c: Expr) -> Expr:
    """Return minus the discriminant of u^2 + b u + c."""
    return sp.factor(4 * c - b**2)

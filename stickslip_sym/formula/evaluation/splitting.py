"""A law as a sum of terms, each an amplitude times a function of v over one scale."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.evaluation.conditioning import speed_scales
from stickslip_sym.formula.integration.terms import grouped

__all__ = ["Term", "split"]

Factors = Mapping[Any, Any]
"""Powers of what is multiplied: expressions of the parameters to rational exponents."""


@dataclass(frozen=True)
class Term:
    """A term of a law: its criterion is number * product(amplitude) * N * F(V / (size * product(scale))).

    Attributes
    ----------
    number, size : sympy.Expr
        Positive or negative, and positive.
    amplitude, scale : mapping
        Expressions of the parameters to rational exponents.
    mu : sympy.Expr
        The function whose slope F averages, in v and the `shapes`.
    shapes : tuple of Symbol
        Parameters that are neither amplitude nor scale, such as an exponent.
    """

    number: Expr
    amplitude: Factors
    size: Expr
    scale: Factors
    mu: Expr
    shapes: tuple[Expr, ...]


def split(mu: Expr) -> list[Term] | None:
    """Split a law into terms; None for a law in pieces, or with an amplitude that may cancel."""
    v = symbols.v
    if mu.has(sp.Piecewise, sp.Abs, sp.Min, sp.Max):
        return None
    polynomial, others = sp.Integer(0), []
    for rest, constant in grouped(mu, v).items():
        if rest.is_polynomial(v):
            polynomial += constant * (rest - rest.subs(v, 0))
        else:
            others.append((constant, rest))
    terms = _polynomial_terms(polynomial, v)
    for constant, rest in others:
        found = _term(constant, rest, v)
        if found is None:
            return None
        terms.append(found)
    return None if any(term is None for term in terms) else terms


def _polynomial_terms(polynomial: Expr, v: Expr) -> list[Expr]:
    """Take a polynomial with one scale as one term, which rounds as one; else split it by powers."""
    if polynomial == 0:
        return []
    powers = sp.Poly(polynomial, v).terms()
    if len(powers) > 1:
        whole = _term(sp.Integer(1), polynomial, v)
        if whole is not None and not whole.shapes:
            return [whole]
    return [_term(sp.factor(coefficient), v ** int(k), v) for (k,), coefficient in powers]


def _term(constant: Expr, rest: Expr, v: Expr) -> Term | None:
    candidates = [_scaled(constant, rest, v, scale) for scale in (*speed_scales(rest, v), sp.Integer(1))]
    found = [candidate for candidate in candidates if candidate is not None]
    return min(found, key=lambda term: len(term.shapes), default=None)


def _scaled(constant: Expr, rest: Expr, v: Expr, scale: Expr) -> Term | None:
    if not scale.is_positive:
        return None  # r = V/scale would have no sign, and branches are for r > 0
    mu = rest.subs(v, scale * v)
    if mu.is_rational_function(v):
        mu = sp.factor(mu)
    else:
        mu = sp.powdenest(sp.expand_power_base(mu, force=True))
        mu = mu.replace(sp.exp, lambda exponent: sp.exp(sp.factor(exponent)))
    coefficient, mu = mu.as_independent(v, as_Add=False)
    size, powers = _factors(scale)
    if mu.is_polynomial(v):
        # Sizes such as sqrt(3) stay with the coefficients: there they become fractions.
        mu = sp.Poly(mu.subs(v, v / size), v)
        content, monic = mu.monic().as_expr().as_content_primitive()
        coefficient, size, mu = coefficient * mu.LC() * content * size, sp.Integer(1), monic
    number, amplitude = _factors(constant * coefficient / scale)
    if amplitude is None or powers is None:
        return None
    return Term(number, amplitude, size, powers, mu, tuple(sorted(mu.free_symbols - {v}, key=str)))


def _factors(product: Expr) -> tuple[Expr, Factors | None]:
    """Split a product into a number and powers; None for powers that are not constant, or may cancel."""
    number: Expr = sp.Integer(1)
    powers: dict[Expr, Expr] = {}
    for base, exponent in sp.factor(product).as_powers_dict().items():
        if base.is_number and exponent.is_number:
            number *= base**exponent
        elif not exponent.is_Rational or not _is_accurate(base):
            return number, None
        else:
            powers[base] = powers.get(base, 0) + exponent
    return number, powers


def _is_accurate(base: Expr) -> bool:
    """Tell whether an expression rounds to a few units: inputs, their sums, and sums of what is positive."""
    if base.is_Symbol:
        return True
    terms = sp.Add.make_args(base)
    if all(term.is_Symbol or (-term).is_Symbol for term in terms) and len(terms) == 2:
        return True
    return all(term.is_positive for term in terms) or all(term.is_negative for term in terms)

"""Antiderivatives by rules of our own, and the shape in which a result is printed.

The rules work term by term on an expanded sum. Whoever uses an antiderivative proves it by
differentiation, so a wrong rule cannot produce a wrong result, only a REFUTED step.
"""

from typing import Any

import sympy as sp

from stickslip_sym.errors import NoClosedForm
from stickslip_sym.printing import text

__all__ = ["antiderivative", "tidy"]


def antiderivative(f: Any, kernel: Any, x: Any) -> Any:
    """Return an antiderivative of f(x) times a polynomial kernel.

    Raises
    ------
    NoClosedForm
        Naming the first term of `f` that no rule covers.
    """
    total = sp.Integer(0)
    for rest, constant in grouped(f, x).items():
        primitive = _polynomial(rest, kernel, x)
        if primitive is None:
            primitive = _polynomial_times_exponential(rest, kernel, x)
        if primitive is None:
            raise NoClosedForm(
                f"no rule integrates the term {text(constant * rest)}; rules exist for powers of v and for powers "
                "times exp(a v + b). Quadrature serves all the same: stickslip_sym.quadrature.damping"
            )
        total += constant * primitive
    return total


def grouped(f: Any, x: Any) -> dict[Any, Any]:
    """Split a sum into functions of `x` and their constant factors, f = sum of constant times function."""
    constants: dict[Any, Any] = {}
    for term in sp.Add.make_args(sp.expand(f, power_exp=False)):
        constant, rest = term.as_independent(x, as_Add=False)
        constants[rest] = constants.get(rest, 0) + constant
    return {rest: sp.factor(constant) for rest, constant in constants.items()}


def _polynomial(rest: Any, kernel: Any, x: Any) -> Any | None:
    if not rest.is_polynomial(x):
        return None
    powers = sp.Poly(rest * kernel, x).terms()
    return sp.Add(*[coefficient * x ** (n + 1) / (n + 1) for (n,), coefficient in powers])


def _polynomial_times_exponential(rest: Any, kernel: Any, x: Any) -> Any | None:
    """Integrate p(x) exp(a x + b), p a polynomial, by parts until p is used up."""
    exponentials = [factor for factor in sp.Mul.make_args(rest) if isinstance(factor, sp.exp)]
    if len(exponentials) != 1:
        return None
    (exponential,) = exponentials
    polynomial = rest / exponential * kernel
    rate = sp.diff(exponential.exp, x)
    if not polynomial.is_polynomial(x) or rate.has(x) or rate == 0:
        return None
    total = sp.Integer(0)
    power = rate
    while polynomial != 0:
        total += polynomial / power
        polynomial = -sp.factor_terms(sp.diff(polynomial, x))
        power *= rate
    return total * exponential


def tidy(expr: Any, model: Any, small: Any) -> Any:
    """Rewrite a result as a person would print it.

    The factors come out, what multiplies an exponential is collected, growing exponentials are divided
    out, and each factor has the sign that it has in `model` (the formula of the law) or that is positive
    for a small value of the symbol `small`.
    """
    factored = sp.factor(expr)
    exponentials = sp.Mul(*[factor for factor in sp.Mul.make_args(factored) if isinstance(factor, sp.exp)])
    factors = []
    for factor in sp.Mul.make_args(factored / exponentials):
        if factor.is_Add and factor.has(sp.exp):
            factor = sp.expand(factor * exponentials, power_exp=False)
            exponentials = sp.Integer(1)
        factors.append(factor)
    factors.append(exponentials)
    sign, printed = 1, []
    for factor in factors:
        if factor.is_Add and _should_flip(factor, model, small):
            sign, factor = -sign, -factor
        printed.append(sp.collect(factor, sorted(factor.atoms(sp.exp), key=str)))
    return sp.Mul(sign, *printed)


def _should_flip(factor: Any, model: Any, small: Any) -> bool:
    for node in sp.preorder_traversal(model):
        if node in (factor, -factor):
            return bool(node == -factor)
    if not factor.has(small):
        return False
    leading = sp.limit(factor, small, 0, "+")
    if leading.is_zero:
        # It vanishes for small values because its terms cancel: let the fewer ones carry a minus.
        signs = [term.could_extract_minus_sign() for term in sp.Add.make_args(sp.expand(factor))]
        return bool(2 * sum(signs) > len(signs))
    return bool(leading.is_negative)

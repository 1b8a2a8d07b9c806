"""Antiderivatives of a term of a law times a polynomial kernel, one rule for each family of terms.

A rule takes (rest, kernel, u) and returns F with F' = rest * kernel, real and smooth for u >= 0, or None
where it does not apply. F is proved by differentiation wherever it is used, so a wrong rule cannot give a wrong
result.
"""

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import Lerch
from stickslip_sym.formula.finding.ladders import (
    LADDERS,
    POWER_LADDERS,
    asinh_ladder,
    by_parts,
    climb,
    erf_ladder,
)
from stickslip_sym.formula.finding.matching import (
    as_function,
    as_linear,
    as_power,
    as_single,
    as_stretched,
    first_rule,
    minus_discriminant,
    partial_fractions,
)
from stickslip_sym.model.terms import grouped, split_polynomial

__all__ = ["antiderivative"]

_HALF = sp.Rational(1, 2)


def antiderivative(rest: Expr, kernel: Expr, u: Expr) -> tuple[str, Expr] | None:
    """Return the names of the rules that integrate rest * kernel, term by term, and what they give, or None."""
    found, total = [], sp.Integer(0)
    for part, constant in grouped(rest, u).items():
        by_rule = first_rule(_RULES, part, kernel, u)
        if by_rule is None:
            return None
        found.append(by_rule[0])
        total += constant * by_rule[1]
    return ", ".join(dict.fromkeys(found)), total


def _polynomial(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate a polynomial."""
    return sp.Poly(rest * kernel, u).integrate().as_expr() if rest.is_polynomial(u) else None


def _function(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n times one function of a linear argument (`LADDERS`)."""
    for function, ladder in LADDERS.items():
        match = as_function(rest, u, function)
        if match is not None:
            polynomial, argument, *_ = match
            return climb(polynomial * kernel, ladder, argument, u)
    return None


def _function_power(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n tanh(x)^k and u^n sech(x)^k, k = 2, 3, ..."""
    single = as_single(rest, u)
    if single is None or not single[1].is_Pow:
        return None
    polynomial, (base, n) = single[0], single[1].as_base_exp()
    ladder = POWER_LADDERS.get(base.func)
    if ladder is None or not (n.is_Integer and n > 1) or as_linear(base.args[0], u) is None:
        return None
    return climb(polynomial * kernel, lambda x, j: ladder(x, int(n), j), base.args[0], u)


def _power(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (a u + b)^p, p no integer (for b = 0: p > -1)."""
    match = as_power(rest, u)
    if match is None:
        return None
    polynomial, base, rate, shift, p = match
    if shift == 0:
        terms = sp.Poly(polynomial * kernel, u).terms()
        return sp.Add(*[c * base**p * u ** (n + 1) / (n + 1 + p) for (n,), c in terms])

    def ladder(j: int) -> Expr:
        return base ** (p + j) / (sp.rf(p + 1, j) * rate**j)

    return by_parts(polynomial * kernel, ladder, u)


def _root(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """u^n (a u^2 + b u + c)^(k/2), k odd and >= -1, the quadratic positive: asinh. Holds u/sqrt(u^2 + w^2)."""
    single = as_single(rest, u)
    if single is None or not single[1].is_Pow:
        return None
    polynomial, (base, exponent) = single[0], single[1].as_base_exp()
    if not base.is_polynomial(u) or sp.degree(base, u) != 2:
        return None
    a, b, c = sp.Poly(base, u).all_coeffs()
    gap = sp.factor(4 * a * c - b**2)
    if not (a.is_positive and gap.is_positive and (exponent + _HALF).is_integer and exponent >= -_HALF):
        return None
    argument = (2 * a * u + b) / sp.sqrt(gap)
    factor = 2 * sp.sqrt(a / gap)  # 1/sqrt(base) = factor/sqrt(1 + argument^2)
    polynomial = polynomial * base ** (exponent + _HALF) * kernel

    def ladder(x: Expr, j: int) -> Expr:
        return asinh_ladder(x, j - 1).subs(sp.sqrt(1 + x**2), factor * sp.sqrt(base))

    return factor * climb(polynomial, ladder, argument, u)


def _log_of_polynomial(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n log(Q(u)) by parts: what is left, the integral of u^n times Q'/Q, is rational."""
    single = as_single(rest, u)
    if single is None or not isinstance(single[1], sp.log) or not single[1].args[0].is_polynomial(u):
        return None
    polynomial, logarithm = single
    whole = sp.Poly(polynomial * kernel, u).integrate().as_expr()
    left = _rational(whole * sp.diff(logarithm, u), sp.Integer(1), u)
    return None if left is None else whole * logarithm - left


def _gaussian(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u^2 + b u + c), a > 0."""
    match = as_function(rest, u, sp.exp, degree=2)
    if match is None:
        return None
    polynomial, _, a, b, c = match
    root = sp.sqrt(-a)
    argument = root * (u + b / (2 * a))
    factor = sp.exp(c - b**2 / (4 * a)) * sp.sqrt(sp.pi) / 2
    return factor * climb(polynomial * kernel, lambda x, j: erf_ladder(x, j - 1), argument, u)


def _stretched(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^q exp(-(u/w)^d), d and q symbolic: lower incomplete gamma functions."""
    match = as_stretched(rest, u)
    if match is None:
        return None
    polynomial, q, k, d = match
    w = sp.powdenest(k ** (-1 / d))
    terms = sp.Poly(polynomial * kernel, u).terms()
    return sp.Add(*[c * w ** (n + 1 + q) / d * sp.lowergamma((n + 1 + q) / d, (u / w) ** d) for (n,), c in terms])


def _binomial(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (b + a u^d)^p, a and b positive, d > 0 free: b^p u^(n+1)/(n+1) 2F1(-p, q; 1 + q; -a u^d/b).

    Here q = (n + 1)/d. Where d is a number, the average is a hypergeometric series in V, which is proved.
    """
    single = as_single(rest, u)
    if single is None or not single[1].is_Pow:
        return None
    polynomial, (base, p) = single[0], single[1].as_base_exp()
    b, power = base.as_independent(u, as_Add=True)
    a, monomial = power.as_independent(u, as_Add=False)
    of, d = monomial.as_base_exp()
    if of != u or p.has(u) or d.has(u) or d.is_number:
        return None
    if not (a.is_positive and b.is_positive and d.is_positive):
        return None
    z = -a * u**d / b
    terms = sp.Poly(polynomial * kernel, u).terms()
    return b**p * sp.Add(*[
        c * u ** (n + 1) / (n + 1) * sp.hyper((-p, (n + 1) / d), (1 + (n + 1) / d,), z) for (n,), c in terms
    ])  # fmt: skip


def _rational(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate rational functions whose denominator splits into factors of degree 1 and 2.

    A quadratic factor must have a discriminant of known sign.
    """
    parts = partial_fractions(rest * kernel, u)
    if parts is None:
        return None
    polynomial, fractions = parts
    total = sp.Poly(polynomial, u).integrate().as_expr()
    for numerator, base, power in fractions:
        if sp.degree(base, u) == 1:
            part = _over_linear(numerator, base, power, u)
        else:
            part = _over_quadratic(numerator, base, power, u)
        if part is None:
            return None
        total += part
    return total


def _over_linear(numerator: Expr, base: Expr, power: int, u: Expr) -> Expr:
    if power > 1:
        return numerator * base ** (1 - power) / (1 - power)
    return numerator * sp.log(sp.expand(base / (base.subs(u, 0) or 1)))


def _over_quadratic(numerator: Expr, base: Expr, power: int, u: Expr) -> Expr | None:
    """Integrate (A u + B) / base^power by Hermite's reduction; None if the roots may be real or complex."""
    _, b, c = sp.Poly(base, u).all_coeffs()
    A = sp.Poly(numerator, u).coeff_monomial(u)
    B = sp.Poly(numerator, u).coeff_monomial(1) - A * b / 2
    gap = minus_discriminant(b, c)
    total = A / 2 * (sp.log(sp.expand(base / c)) if power == 1 else base ** (1 - power) / (1 - power))
    while power > 1:
        total += B * (2 * u + b) / ((power - 1) * gap * base ** (power - 1))
        B *= sp.Rational(2 * (2 * power - 3), power - 1) / gap
        power -= 1
    if gap.is_positive:
        root = sp.sqrt(gap)
        return total + 2 * B / root * sp.atan((2 * u + b) / root)
    if gap.is_negative:
        root = sp.sqrt(-gap)
        return total + B / root * sp.log((2 * u + b - root) / (2 * u + b + root))
    return None


def _exponential_over_linear(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """exp(-a u) times a rational function with linear denominators, a > 0: E_1."""
    exponentials = [factor for factor in sp.Mul.make_args(rest) if isinstance(factor, sp.exp)]
    if len(exponentials) != 1:
        return None
    (exponential,) = exponentials
    others = [factor for factor in sp.Mul.make_args(rest) if factor != exponential]
    parts = partial_fractions(sp.Mul(*others, kernel), u)
    linear = as_linear(exponential.args[0], u)
    if parts is None or linear is None or not linear[0].is_negative:
        return None
    rate = linear[0]
    polynomial, fractions = parts
    total = climb(polynomial, LADDERS[sp.exp], exponential.args[0], u)
    for numerator, base, power in fractions:
        if sp.degree(base, u) != 1:
            return None
        while power > 1:
            total += numerator * exponential / ((1 - power) * base ** (power - 1))
            numerator *= rate / (power - 1)
            power -= 1
        front = sp.exp(sp.expand(exponential.args[0] - rate * base))
        total -= numerator * front * sp.expint(1, -rate * base)
    return total


def _exponential_tanh(rest: Expr, kernel: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u) tanh(k u), a > 0, k > 0, by the Lerch transcendent.

    exp(-r x) tanh(x) = exp(-r x) - 2 exp(-(r + 2) x) Phi(-exp(-2 x), 0, 1 + r/2), x = k u, r = a/k.
    """
    polynomial, others = split_polynomial(rest, u)
    if {factor.func for factor in others} != {sp.exp, sp.tanh} or len(others) != 2:
        return None
    exponential, tanh = sorted(others, key=lambda factor: factor.func is sp.tanh)
    decay, slope = as_linear(exponential.args[0], u), as_linear(tanh.args[0], u)
    if decay is None or slope is None or slope[1] != 0 or not decay[0].is_negative:
        return None
    k, r = slope[0], -decay[0] / slope[0]

    def ladder(j: int) -> Expr:
        z = -sp.exp(-2 * k * u)
        lerch = 2 * _HALF**j * z * Lerch(z, j, 1 + r / 2)
        return (-1 / k) ** j * exponential * (r**-j + lerch)

    return by_parts(polynomial * kernel, ladder, u)


_RULES = {
    "polynomial": _polynomial,
    "partial fractions": _rational,
    "repeated integrals": _function,
    "repeated integrals of a power": _function_power,
    "power": _power,
    "integration by parts": _log_of_polynomial,
    "square root of a quadratic": _root,
    "Gaussian": _gaussian,
    "incomplete gamma": _stretched,
    "Lerch transcendent": _exponential_tanh,
    "exponential integral": _exponential_over_linear,
    "hypergeometric function of a power": _binomial,
}

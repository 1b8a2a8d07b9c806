"""Averages of a hypergeometric series: the same series with the moments of the weight appended.

The average of v^p is a ratio of Gamma functions of p for every weight here, so each of them adds parameters to the
series of a profile.
"""

from collections.abc import Callable
from typing import NamedTuple

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.finding.matching import as_stretched, coefficients

__all__ = ["power_moment", "series_average"]

_HALF = sp.Rational(1, 2)


class _Part(NamedTuple):
    """A part of an average: what it makes of v^p, and how that goes on from p to p + a, p + 2 a, ...

    average(p + a n)/average(p) = (2 V)^(a n) times (x)_n for x of upper(p, a) over (x)_n for x of lower(p, a).
    """

    average: Callable[[Expr], Expr]
    upper: Callable[[Expr, Expr], list[Expr]]
    lower: Callable[[Expr, Expr], list[Expr]]


class _Series(NamedTuple):
    """front u^q pFq(upper; lower; z u^d)."""

    front: Expr
    q: Expr
    upper: tuple[Expr, ...]
    lower: tuple[Expr, ...]
    z: Expr
    d: Expr


def power_moment(p: Expr, V: Expr) -> Expr:
    """Return the harmonic average of v^p, p > -1/2."""
    factor = -(2 ** (p + 1)) * V ** (p - 1) / sp.sqrt(sp.pi)
    return factor * p * sp.gamma(p + _HALF) / sp.gamma(p + 2)


def _parts(criterion: Criterion, u: Expr, V: Expr) -> list[_Part]:
    """Return the harmonic average of the slope, or the integral from 0 to 2 V for each power in a kernel."""
    if not criterion.is_polynomial:
        return [
            _Part(
                lambda p: power_moment(p, V),
                lambda p, a: [*((p + _HALF + i) / a for i in range(int(a))), p / a + 1],
                lambda p, a: [*((p + 2 + i) / a for i in range(int(a))), p / a],
            )
        ]

    def of_power(n: int, c: Expr) -> _Part:
        return _Part(
            lambda p: c * (2 * V) ** (p + n + 1) / (p + n + 1),
            lambda p, a: [(p + n + 1) / a],
            lambda p, a: [(p + n + 1) / a + 1],
        )

    return [of_power(n, c) for (n,), c in sp.Poly(criterion.kernel, u).terms()]


def series_average(polynomial: Expr, factors: Expr, u: Expr, V: Expr, criterion: Criterion) -> Expr | None:
    """Return the average of a polynomial times a hypergeometric series in u^d, without boundary terms."""
    series = _series(factors, u, criterion)
    if series is None:
        return None
    terms = sp.Poly(polynomial, u).terms()
    parts = _parts(criterion, u, V)
    return series.front * sp.Add(
        *[c * _average(series._replace(q=series.q + n), V, part) for (n,), c in terms for part in parts]
    )


def _series(factors: Expr, u: Expr, criterion: Criterion) -> _Series | None:
    """Write exp(-k u^d), (1 + k u^d)^p or erf(k u) as a series.

    For d = 1/2, 1, 2 of the exponential, and whole numbers d of the binomial, under a polynomial weight any
    d > 0. For other d of the exponential such series are of no use: mpmath has no asymptotic series for 3F3 and
    above, and for d = a/b with b > 1 the parts cancel about 0.43 (2 V/w)^d digits.
    """
    if (stretched := as_stretched(factors, u)) is not None:
        front, q, k, d = stretched
        return _Series(front, q, (), (), -k, d) if d in (_HALF, 1, 2) else None
    if isinstance(factors, sp.erf):
        rate, *shift = coefficients(factors.args[0], u)
        if shift != [0]:
            return None
        front = 2 * rate / sp.sqrt(sp.pi)
        return _Series(front, sp.Integer(1), (_HALF,), (3 * _HALF,), -(rate**2), sp.Integer(2))
    base, p = factors.as_base_exp()
    constant, power = base.as_independent(u, as_Add=True)
    a, monomial = power.as_independent(u, as_Add=False)
    of, d = monomial.as_base_exp()
    z = sp.cancel(-a / constant) if constant != 0 else sp.Integer(0)
    whole = d.is_Integer or criterion.is_polynomial
    if of != u or p.has(u) or d.has(u) or not (whole and d.is_positive and z.could_extract_minus_sign()):
        return None
    return _Series(constant**p, sp.Integer(0), (-p,), (), z, d)


def _average(series: _Series, V: Expr, part: _Part) -> Expr:
    """Sum over every b-th power of z, d = a/b, for b first powers: but one whose average is 0."""
    _, q, upper, lower, z, d = series
    b = int(d.q) if d.is_Rational else 1
    a, total = d * b, sp.Integer(0)
    for start in range(b):
        first = b if part.average(q + d * start) == 0 else start
        p = q + d * first
        above = [(x + first + i) / b for x in upper for i in range(b)] + [sp.Integer(1)]
        above += part.upper(p, a)
        below = [(x + first + i) / b for x in [*lower, sp.Integer(1)] for i in range(b)]
        below += part.lower(p, a)
        for parameter in list(above):
            if parameter in below:
                above.remove(parameter)
                below.remove(parameter)
        ratio = sp.Mul(*[sp.rf(x, first) for x in upper], *[1 / sp.rf(x, first) for x in lower])
        argument = z**b * (2 * V) ** a * sp.Integer(b) ** (b * (len(upper) - len(lower) - 1))
        total += ratio * z**first / sp.factorial(first) * part.average(p) * sp.hyper(above, below, argument)
    return total

"""Langevin's function coth(x) - 1/x and its derivatives, without the cancellation of the two parts near 0.

Both are infinite at 0, where their difference is x/3 - x^3/45 + ..., for |x| < pi.
"""

import math
from functools import lru_cache
from typing import Any

import mpmath
import numpy as np
import sympy as sp
from flint import acb, acb_poly, arb, arb_series, ctx, fmpq

from stickslip_sym.core.aliases import Expr, FloatArray, Mpf

_NEAR = 1.5  # largest argument of the series: squares over pi^2, in which it goes, are below 0.23 = 2^-2.13
_DOUBLE = 53  # bits of a double


class Langevin(sp.Function):  # type: ignore[misc]  # SymPy is untyped
    """The n-th derivative of coth(x) - 1/x as a function of x and n."""

    nargs = 2
    is_real = True

    @classmethod
    def eval(cls, x: Expr, n: Expr) -> Expr:
        """Evaluate at 0."""
        return sp.Rational(str(_at_zero(int(n)))) if x == 0 else None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate with respect to x."""
        x, n = self.args
        return Langevin(x, n + 1)

    def elementary(self) -> Expr:
        """Return it as it is written."""
        x, n = self.args
        u = sp.Dummy()
        return sp.diff(sp.coth(u) - 1 / u, u, n).subs(u, x)

    def _eval_evalf(self, prec: int) -> Expr:
        x, n = self.args
        with mpmath.workprec(prec + 10):
            return sp.Float._new(in_mpmath(x._to_mpmath(prec + 10), int(n))._mpf_, prec)


@lru_cache(maxsize=64)
def _taylor(n: int, count: int) -> list[fmpq]:
    """Return the first coefficients of the n-th derivative, of every other power, from x^0 or x^1 on."""
    first = n // 2 + 1
    return [
        fmpq.bernoulli(2 * k) * 4**k / (2 * k) / math.factorial(2 * k - 1 - n) for k in range(first, first + count)
    ]


def _at_zero(n: int) -> fmpq:
    return _taylor(n, 1)[0] * (n % 2)


def _count(n: int, bits: int) -> int:
    """Return how many terms of the series give so many bits; beyond them each is less than half of that before."""
    return bits // 2 + 2 * n + 4


def _by_parts(x: Any, n: int, coth: Any, csch: Any) -> Any:
    """Return the difference of the derivatives of coth, csch^2 times a polynomial Q_n(coth), and of 1/x.

    As coth' = -csch^2, Q_1 = -1 and Q_(n+1)(c) = -2 c Q_n - (c^2 - 1) Q_n'.
    """
    polynomial: Any = 0
    for coefficient in _polynomial(n):
        polynomial = polynomial * coth + coefficient
    whole = polynomial * csch * csch if n else coth
    return whole - (-1) ** n * math.factorial(n) / x ** (n + 1)


@lru_cache(maxsize=64)
def _polynomial(n: int) -> list[int]:
    """Return the coefficients of Q_n, the highest first."""
    c = sp.Dummy()
    q = sp.Poly(-1, c)
    for _ in range(n - 1):
        q = q * sp.Poly(-2 * c, c) - sp.Poly(c**2 - 1, c) * q.diff(c)
    return list(map(int, q.all_coeffs()))


def in_balls(z: acb, order: acb) -> acb:
    """Return a ball around the value, also on balls around 0."""
    n, size = round(float(order.real)), arb(z.abs_upper())
    if not size <= _NEAR:
        return acb(_by_parts(z, n, z.coth(), z.csch()))
    if z == 0:
        return acb(_at_zero(n))
    series, left_out = _in_squares(n, ctx.prec)
    rest = (2 * left_out * size ** (2 * len(series) + (n + 1) % 2)).abs_upper()
    return series(z * z) * (1 if n % 2 else z) + acb(arb(0, rest), arb(0, rest))


@lru_cache(maxsize=64)
def _in_squares(n: int, bits: int) -> tuple[acb_poly, arb]:
    """Return the series as a polynomial in x^2, and the size of the first coefficient that it leaves out."""
    *coefficients, left_out = _taylor(n, _count(n, bits) + 1)
    return acb_poly(list(map(acb, coefficients))), abs(arb(left_out))


def in_series(inner: arb_series, order: arb) -> arb_series:
    """Return the power series of the value, from that of the argument."""
    n, factorial, terms = round(float(order)), 1, []
    start, *others = list(inner) or [arb(0)]
    for k in range(ctx.cap):
        terms.append(in_balls(acb(start), acb(n + k)).real / factorial)
        factorial *= k + 1
    return arb_series(terms)(arb_series([arb(0), *others]))


def in_mpmath(x: Mpf, n: int) -> Mpf:
    """Return the value in mpmath's working precision, with the bits that cancel near 0 besides."""
    if x == 0:
        return mpmath.mpf(int(_at_zero(n).p)) / int(_at_zero(n).q)
    with mpmath.extraprec(10 + (n + 2) * max(0, 2 - mpmath.mag(x))):
        return _by_parts(x, n, mpmath.coth(x), mpmath.csch(x))


def in_floats(x: Any, n: int) -> FloatArray:
    """Return the values of an array."""
    x = np.asarray(x, dtype=np.float64)
    with np.errstate(all="ignore"):
        parts = _by_parts(x, n, 1 / np.tanh(x), 1 / np.sinh(x))
        series = np.polynomial.polynomial.polyval(x * x, _in_doubles(n)) * (1 if n % 2 else x)
        return np.asarray(np.where(np.abs(x) < _NEAR, series, parts))


@lru_cache(maxsize=64)
def _in_doubles(n: int) -> list[float]:
    """Return the coefficients of the series in doubles."""
    return [int(c.p) / int(c.q) for c in _taylor(n, _count(n, _DOUBLE))]

"""Repeated integrals of the functions that friction laws are made of.

A ladder of g is a sequence with g_0 = g and g_j' = g_(j-1). With it any polynomial P integrates against g by
parts: F = sum_j (-1)^j P^(j) g_(j+1) has F' = P g, since the sum telescopes. So a family of laws needs no more
than its ladder.
"""

from collections.abc import Callable

import sympy as sp

from stickslip_sym.core.aliases import Expr

__all__ = ["LADDERS", "POWER_LADDERS", "asinh_ladder", "by_parts", "climb", "erf_ladder"]


def by_parts(polynomial: Expr, ladder: Callable[[int], Expr], u: Expr) -> Expr:
    """Return sum_j (-1)^j polynomial^(j) ladder(j + 1), where ladder(j)' = ladder(j - 1).

    Its derivative telescopes to polynomial * ladder(0).
    """
    total, sign, j = sp.Integer(0), 1, 1
    while polynomial != 0:
        total += sign * polynomial * ladder(j)
        polynomial, sign, j = sp.factor_terms(sp.diff(polynomial, u)), -sign, j + 1
    return total


def _log_ladder(x: Expr, j: int) -> Expr:
    return x**j / sp.factorial(j) * (sp.log(x) - sp.harmonic(j))


def _atan_ladder(x: Expr, j: int) -> Expr:
    """Imaginary part of the ladder of log(1 + i x)."""
    real, imaginary = sp.expand((x - sp.I) ** j).as_real_imag()
    log_part = sp.log(1 + x**2) / 2 - sp.harmonic(j)
    return (real * sp.atan(x) + imaginary * log_part) / sp.factorial(j)


def asinh_ladder(x: Expr, j: int) -> Expr:
    """j^2 g_j = (2 j - 1) x g_{j-1} - (1 + x^2) g_{j-2}, from (1 + x^2) g_0'' + x g_0' = 0."""
    before, last = 1 / sp.sqrt(1 + x**2), sp.asinh(x)
    for k in range(1, j + 1):
        before, last = last, sp.expand(((2 * k - 1) * x * last - (1 + x**2) * before) / k**2)
    return sp.collect(last, (sp.asinh(x), sp.sqrt(1 + x**2)))


def erf_ladder(x: Expr, j: int) -> Expr:
    """2 j g_j = g_{j-2} + 2 x g_{j-1}: repeated integrals of the error function."""
    before, last = 2 / sp.sqrt(sp.pi) * sp.exp(-(x**2)), sp.erf(x)
    for k in range(1, j + 1):
        before, last = last, sp.expand((before + 2 * x * last) / (2 * k))
    return sp.collect(last, (sp.erf(x), sp.exp(-(x**2))))


class polylog(sp.polylog):  # type: ignore[misc]  # noqa: N801  # SymPy is untyped; the name is what is printed
    """Li_s(z) as SymPy's, which spends a tenth of a second on the question whether z = 1 whenever it is made."""

    @classmethod
    def eval(cls, s: Expr, z: Expr) -> Expr | None:
        """Evaluate where it is known."""
        return super().eval(s, z) if z in (-1, 0, 1) or (s, z) == (2, sp.I) else None

    def fdiff(self, argindex: int = 2) -> Expr:
        """Differentiate with respect to z."""
        if argindex != 2:
            return super().fdiff(argindex)
        s, z = self.args
        return z / (1 - z) / z if s == 1 else polylog(s - 1, z) / z


def _tanh_ladder(x: Expr, j: int) -> Expr:
    """tanh(x) = 1 + 2 Li_0(-exp(-2 x)), and Li_s integrates to Li_{s+1}."""
    z = -sp.exp(-2 * x)
    last = -sp.log(1 - z) if j == 1 else polylog(j, z)
    return x**j / sp.factorial(j) + 2 * sp.Rational(-1, 2) ** j * last


def _sech_ladder(x: Expr, j: int) -> Expr:
    """sech(x) = 2 Ti_0(exp(-x)), Ti_j(y) = Im Li_j(i y) the inverse tangent integral."""
    y = sp.exp(-x)
    return 2 * (-1) ** j * (sp.atan(y) if j == 1 else sp.im(polylog(j, sp.I * y)))


def _tanh_power_ladder(x: Expr, n: int, j: int) -> Expr:
    """tanh^n = tanh^(n-2) - (tanh^(n-1))' / (n - 1)."""
    if j == 0 or n == 0:
        return sp.tanh(x) ** n * x**j / sp.factorial(j)
    if n == 1:
        return _tanh_ladder(x, j)
    return _tanh_power_ladder(x, n - 2, j) - _tanh_power_ladder(x, n - 1, j - 1) / (n - 1)


def _sech_power_ladder(x: Expr, n: int, j: int) -> Expr:
    """(n - 1) sech^n = (n - 2) sech^(n-2) - (sech^(n-2))'' / (n - 2); sech^2 = tanh'."""
    if j <= 0:
        return sp.diff(sp.sech(x) ** n, x, -j)
    if n == 1:
        return _sech_ladder(x, j)
    if n == 2:
        return _tanh_power_ladder(x, 1, j - 1)
    lower = (n - 2) * _sech_power_ladder(x, n - 2, j) - _sech_power_ladder(x, n - 2, j - 2) / (n - 2)
    return lower / (n - 1)


LADDERS: dict[Expr, Callable[[Expr, int], Expr]] = {
    sp.exp: lambda x, j: sp.exp(x),
    sp.sin: lambda x, j: sp.sin(x - j * sp.pi / 2),
    sp.cos: lambda x, j: sp.cos(x - j * sp.pi / 2),
    sp.log: _log_ladder,
    sp.atan: _atan_ladder,
    sp.asinh: asinh_ladder,
    sp.erf: erf_ladder,
    sp.tanh: _tanh_ladder,
    sp.sech: _sech_ladder,
}

POWER_LADDERS: dict[Expr, Callable[[Expr, int, int], Expr]] = {
    sp.tanh: _tanh_power_ladder,
    sp.sech: _sech_power_ladder,
}


def climb(polynomial: Expr, ladder: Callable[[Expr, int], Expr], argument: Expr, u: Expr) -> Expr:
    """Integrate polynomial * g(argument), argument = rate * u + shift, g_j = ladder(x, j)."""
    x = sp.Dummy("x", real=True)
    rate = sp.diff(argument, u)
    return by_parts(polynomial, lambda j: ladder(x, j).subs(x, argument) / rate**j, u)

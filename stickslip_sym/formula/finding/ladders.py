"""Repeated integrals of functions.

A ladder of g is a sequence with g_0 = g and g_j' = g_(j-1). With it any polynomial P integrates against g by
parts: F = sum_j (-1)^j P^(j) g_(j+1) has F' = P g, since the sum telescopes. So a family of laws needs no more
than its ladder.
"""

from collections.abc import Callable

import sympy as sp

from stickslip_sym.core.aliases import Expr

__all__ = ["LADDERS", "by_parts", "polylog"]


def by_parts(polynomial: Expr, ladder: Callable[[int], Expr], u: Expr) -> Expr:
    """Return sum_j (-1)^j polynomial^(j) ladder(j + 1), where ladder(j)' = ladder(j - 1)."""
    total, sign, j = sp.Integer(0), 1, 1
    while polynomial != 0:
        total += sign * polynomial * ladder(j)
        polynomial, sign, j = sp.factor_terms(sp.diff(polynomial, u)), -sign, j + 1
    return total


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
        return 1 / (1 - z) if s == 1 else polylog(s - 1, z) / z


def _tanh_ladder(x: Expr, n: int, j: int) -> Expr:
    """Tanh = 1 + 2 Li_0(-exp(-2 x)), Li_s integrates to Li_(s+1); tanh^n = tanh^(n-2) - (tanh^(n-1))'/(n - 1)."""
    if j == 0 or n == 0:
        return sp.tanh(x) ** n * x**j / sp.factorial(j)
    if n > 1:
        return _tanh_ladder(x, n - 2, j) - _tanh_ladder(x, n - 1, j - 1) / (n - 1)
    z = -sp.exp(-2 * x)
    last = -sp.log(1 - z) if j == 1 else polylog(j, z)
    return x**j / sp.factorial(j) + 2 * sp.Rational(-1, 2) ** j * last


def _sech_ladder(x: Expr, n: int, j: int) -> Expr:
    """Note that sech = 2 Ti_0(exp(-x)), Ti_j(y) = Im Li_j(i y).

    (n - 1) sech^n = (n - 2) sech^(n-2) - (sech^(n-2))''/(n - 2), sech^2 = tanh'.
    """
    if j <= 0:
        return sp.diff(sp.sech(x) ** n, x, -j)
    if n == 1:
        y = sp.exp(-x)
        return 2 * (-1) ** j * (sp.atan(y) if j == 1 else sp.im(polylog(j, sp.I * y)))
    if n == 2:
        return _tanh_ladder(x, 1, j - 1)
    return ((n - 2) * _sech_ladder(x, n - 2, j) - _sech_ladder(x, n - 2, j - 2) / (n - 2)) / (n - 1)


LADDERS: dict[type[Expr], Callable[[Expr, int, int], Expr]] = {
    sp.exp: lambda x, n, j: sp.exp(x),
    sp.sin: lambda x, n, j: sp.sin(x - j * sp.pi / 2),
    sp.cos: lambda x, n, j: sp.cos(x - j * sp.pi / 2),
    sp.tanh: _tanh_ladder,
    sp.sech: _sech_ladder,
}
"""The j-th integral of a function; of hyperbolic ones, of the n-th power."""

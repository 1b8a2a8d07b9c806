"""Lerch's transcendent for real arguments, which neither SymPy nor mpmath evaluates well."""

import mpmath
import sympy as sp

from stickslip_sym.core.aliases import Expr, Mpf

__all__ = ["Lerch", "lerch"]


class Lerch(sp.Function):  # type: ignore[misc]  # SymPy is untyped
    """Lerch's transcendent sum_n z^n / (n + a)^s for -1 <= z <= 0, a > 0 and s = 0, 1, 2, ...

    SymPy has it as `lerchphi`; mpmath's function behind that takes up to seconds a value, and gives
    complex numbers for real arguments.
    """

    nargs = 3

    @classmethod
    def eval(cls, z: Expr, s: Expr, a: Expr) -> Expr:
        """Reduce order 0 to an elementary function."""
        return 1 / (1 - z) if s == 0 else None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate with respect to z."""
        if argindex != 1:
            raise sp.core.function.ArgumentIndexError(self, argindex)
        z, s, a = self.args
        return (Lerch(z, s - 1, a) - a * Lerch(z, s, a)) / z

    def _eval_evalf(self, prec: int) -> Expr:
        with mpmath.workprec(prec + 10):
            z, s, a = (argument._to_mpmath(prec + 10) for argument in self.args)
            value = lerch(z, s, a)
        return sp.Float._new(value._mpf_, prec)


def lerch(z: Mpf, s: Mpf, a: Mpf) -> Mpf:
    """Evaluate `Lerch` in mpmath; the error relative to the sum is 5.8^-terms.

    H. Cohen, F. Rodriguez Villegas, D. Zagier, Convergence acceleration of alternating series,
    Experimental Mathematics 9 (2000), algorithm 1.
    """
    with mpmath.extradps(5):
        terms = int(1.31 * mpmath.mp.dps) + 2
        scale = (3 + mpmath.sqrt(8)) ** terms
        scale = (scale + 1 / scale) / 2
        b, c, total, power = mpmath.mpf(-1), -scale, mpmath.mpf(0), mpmath.mpf(1)
        for k in range(terms):
            c = b - c
            total += c * power / (k + a) ** s
            power *= -z
            b *= mpmath.mpf((k + terms) * (k - terms) * 2) / ((2 * k + 1) * (k + 1))
        return total / scale

"""Functions that SymPy lacks, or differentiates or evaluates badly. Each says how its ball is found.

`Removable` ones are 0/0 at x = 0, and near there power series: a new one is its form and its series.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, ClassVar

import mpmath
import numpy as np
import sympy as sp
from flint import acb, acb_poly, arb, arb_series, ctx, fmpq, fmpq_series
from sympy.printing.precedence import PRECEDENCE
from sympy.printing.printer import Printer

from stickslip_sym.core.aliases import Expr, FloatArray, Mpf
from stickslip_sym.core.numbers import DOUBLE_BITS, NUMBER_BITS
from stickslip_sym.core.precision import ball_of_mpmath, middle_in_mpmath, mp, refined, working_precision

_CIRCLE = 3  # a radius up to which a removable function is analytic
# A bound on its size there: coth(z) - 1/z is largest beside its pole i pi, where coth(i y) is -i cot(y).
_BOUND_ON_CIRCLE = math.ceil(1 / _CIRCLE - 1 / math.tan(_CIRCLE))
_SERIES_RADIUS = _CIRCLE / 2  # largest argument of its power series


class Special(sp.Function):
    """A function whose numbers come from balls."""

    ball: ClassVar[Callable[..., acb]]

    @classmethod
    def mpf(cls, context: mpmath.MPContext, *arguments: Mpf) -> Mpf:
        """Return the value in the working precision of a context of mpmath."""
        balls = [ball_of_mpmath(argument) for argument in arguments]
        value = middle_in_mpmath(refined(lambda: cls.ball(*balls).real, context.prec, context.prec + NUMBER_BITS))
        return +context.make_mpf(value._mpf_)

    def _eval_evalf(self, prec: int) -> Expr:
        arguments = [part._to_mpmath(prec + 10) for part in self.args]
        with mp.workprec(prec + 10):
            return sp.Float._new(self.mpf(mp.context, *arguments)._mpf_, prec)


class Lerch(Special):
    """Lerch's transcendent sum_n z^n / (n + a)^s for -1 <= z <= 0, a > 0 and s = 0, 1, 2, ...

    SymPy has it as `lerchphi`; mpmath's function behind that takes up to seconds a value, and gives
    complex numbers for real arguments.
    """

    nargs = 3
    ball = staticmethod(acb.lerch_phi)

    @classmethod
    def eval(cls, z: Expr, s: Expr, a: Expr) -> Expr | None:
        """Reduce order 0 to an elementary function."""
        return 1 / (1 - z) if s == 0 else None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate with respect to z."""
        if argindex != 1:
            raise sp.core.function.ArgumentIndexError(self, argindex)
        z, s, a = self.args
        return (Lerch(z, s - 1, a) - a * Lerch(z, s, a)) / z


class Ein(Special):
    """The entire exponential integral, from 0 to x of (1 - exp(-t))/t: E_1(x) + log(x) + gamma for x > 0."""

    nargs = 1
    is_real = True

    @classmethod
    def eval(cls, x: Expr) -> Expr | None:
        """Evaluate at 0."""
        return sp.S.Zero if x == 0 else None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate."""
        (x,) = self.args
        return (1 - sp.exp(-x)) / x

    @staticmethod
    def ball(z: acb) -> acb:
        """Return z times the hypergeometric series 2F2(1, 1; 2, 2; -z)."""
        return z * (-z).hypgeom([acb(1), acb(1)], [acb(2), acb(2)])

    @staticmethod
    def floats(x: Any) -> FloatArray:
        """Return the values of an array of numbers >= 0."""
        from scipy.special import exp1

        x = np.asarray(x, dtype=np.float64)
        n = np.arange(1, DOUBLE_BITS)
        coefficients = np.concatenate([[0.0], -((-1.0) ** n) / (n * np.cumprod(n.astype(np.float64)))])
        series = np.polynomial.polynomial.polyval(np.minimum(x, 1.0), coefficients)
        with np.errstate(all="ignore"):
            return np.asarray(np.where(x < 1, series, exp1(x) + np.log(x) + np.euler_gamma))


class Erfcx(Special):
    """exp(x^2) erfc(x), whose factors over- and underflow where it is about 1/(sqrt(pi) x)."""

    nargs = 1
    is_real = True

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate."""
        (x,) = self.args
        return 2 * x * Erfcx(x) - 2 / sp.sqrt(sp.pi)

    @staticmethod
    def ball(z: acb) -> acb:
        """Return the product."""
        return (z * z).exp() * z.erfc()

    @staticmethod
    def far_coefficients(count: int) -> list[Expr]:
        """Return sqrt(pi) times its coefficients far out in powers of 1/x; the series diverges (DLMF 7.12.1)."""
        coefficients = [sp.S.Zero] * (count + 1)
        term = sp.S.One
        for k in range(1, count + 1, 2):
            coefficients[k] = term
            term *= -sp.Rational(k, 2)
        return coefficients

    @staticmethod
    def floats(x: Any) -> FloatArray:
        """Return the values of an array."""
        from scipy.special import erfcx

        return np.asarray(erfcx(x))


class polylog(sp.polylog):  # noqa: N801  # the name is what is printed
    """Li_s(z) as SymPy's, which spends a tenth of a second on the question whether z = 1 whenever it is made."""

    @classmethod
    def eval(cls, s: Expr, z: Expr) -> Expr | None:
        """Evaluate where it is known."""
        if z in (-1, 0, 1) or (s == 2 and z == sp.I):
            return super().eval(s, z)
        return None

    def fdiff(self, argindex: int = 2) -> Expr:
        """Differentiate with respect to z."""
        if argindex != 2:
            return super().fdiff(argindex)
        s, z = self.args
        if s == 1:
            return 1 / (1 - z)
        return polylog(s - 1, z) / z


class NumberPower(Special):
    """A positive rational number to a rational power, which is not computed.

    SymPy would expand a power such as 0.0788816^1.4144337 into factors with exponents near 1e15.
    """

    nargs = 2
    is_positive = True
    precedence = PRECEDENCE["Pow"]  # a power of it needs brackets
    ball = staticmethod(acb.pow)

    def _printed(self, printer: Printer) -> str:
        """Print it as the power of two symbols would be, the numbers in their place."""
        base, exponent = (f"({printer._print(argument)})" for argument in self.args)
        return str(printer._print(sp.Symbol("B") ** sp.Symbol("E"))).replace("B", base).replace("E", exponent)

    _sympystr = _latex = _numpycode = _pythoncode = _mpmathcode = _printed


# -- functions that are 0/0 at x = 0 -----------------------------------------------------------------


class Removable(Special):
    """The n-th derivative, as a function of x and n, of a function with a removable singularity at 0."""

    nargs = 2
    is_real = True
    form: ClassVar[Callable[..., Expr]]
    """From x to the function: a sum of products of 1/x, and of functions that NumPy and Arb have by name."""
    power_series: ClassVar[Callable[..., fmpq_series]]
    """From the power series of x to that of the function, in exact rationals."""

    @classmethod
    def eval(cls, x: Expr, n: Expr) -> Expr | None:
        """Evaluate at 0."""
        if x == 0:
            return sp.Rational(str(cls._taylor(int(n), 1)[0]))
        return None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Differentiate with respect to x."""
        x, n = self.args
        return type(self)(x, n + 1)

    def elementary(self) -> Expr:
        """Return it as it is written."""
        x, n = self.args
        u = sp.Dummy()
        return sp.diff(self.form(u), u, n).subs(u, x)

    @classmethod
    @lru_cache
    def _taylor(cls, n: int, count: int) -> list[fmpq]:
        """Return the first coefficients of the n-th derivative."""
        with working_precision(DOUBLE_BITS, n + count + 3):
            series = cls.power_series(fmpq_series([0, 1]))
            return [series[k + n] * int(sp.ff(k + n, n)) for k in range(count)]

    @classmethod
    @lru_cache
    def _terms(cls, n: int) -> tuple[list[str], list[tuple[list[int], int]]]:
        """Return the n-th derivative as a polynomial in 1/x and in functions: their names, and its terms.

        Of the hyperbolic functions only those that stay finite far out are left.
        """
        u = sp.Dummy()
        expr = sp.diff(cls.form(u), u, n).subs({sp.cosh(u): sp.coth(u) / sp.csch(u), sp.sinh(u): 1 / sp.csch(u)})
        functions = sorted(expr.atoms(sp.Function), key=str)
        terms = sp.Poly(sp.expand(expr), 1 / u, *functions).terms()
        return [type(f).__name__ for f in functions], [(list(map(int, powers)), int(c)) for powers, c in terms]

    @classmethod
    def _by_terms(cls, x: Any, n: int, function: Callable[[str], Any]) -> Any:
        """Return the value in any arithmetic by the terms, which cancel near 0."""
        names, terms = cls._terms(n)
        values = [1 / x, *(function(name) for name in names)]
        total: Any = 0
        for powers, coefficient in terms:
            factors = [value**power for value, power in zip(values, powers, strict=True)]
            total += sp.prod(factors, coefficient)
        return total

    @classmethod
    @lru_cache
    def _near(cls, n: int, bits: int) -> tuple[acb_poly, arb]:
        """Return the power series as a polynomial, and a bound on what it leaves out over the last power of |x|.

        By Cauchy's estimate, summed as a geometric series: from 2 n terms on the next is below 3/4 of the last.
        """
        count = bits + 2 * n + 8
        left_out = 4 * _BOUND_ON_CIRCLE * int(sp.ff(count + n, n)) / arb(_CIRCLE) ** (count + n)
        return acb_poly(list(map(acb, cls._taylor(n, count)))), left_out

    @classmethod
    def ball(cls, z: acb, order: acb) -> acb:
        """Return a ball around the value, also on balls around 0."""
        n = round(float(order.real))
        if z == 0:
            return acb(cls._taylor(n, 1)[0])
        size = arb(z.abs_upper())
        if not size <= _SERIES_RADIUS:
            return acb(cls._by_terms(z, n, lambda name: getattr(z, name)()))
        series, left_out = cls._near(n, ctx.prec)
        rest = (left_out * size ** (ctx.prec + 2 * n + 8)).abs_upper()
        return series(z) + acb(arb(0, rest), arb(0, rest))

    @classmethod
    def series(cls, inner: arb_series, order: arb) -> arb_series:  # type: ignore[override]  # not SymPy's
        """Return the power series of the value, from that of the argument."""
        n = round(float(order))
        factorial = 1
        terms = []
        start, *others = list(inner) or [arb(0)]
        for k in range(ctx.cap):
            terms.append(cls.ball(acb(start), acb(n + k)).real / factorial)
            factorial *= k + 1
        return arb_series(terms)(arb_series([arb(0), *others]))

    @classmethod
    def floats(cls, x: Any, n: int) -> FloatArray:
        """Return the values of an array."""
        x = np.asarray(x, dtype=np.float64)
        with np.errstate(all="ignore"):
            inverse = {"coth": np.tanh, "csch": np.sinh}
            parts = cls._by_terms(x, n, lambda f: 1 / inverse[f](x) if f in inverse else getattr(np, f)(x))
            coefficients = [int(c.p) / int(c.q) for c in cls._taylor(n, DOUBLE_BITS + 2 * n + 8)]
            series = np.polynomial.polynomial.polyval(x, coefficients)
            return np.asarray(np.where(np.abs(x) < _SERIES_RADIUS, series, parts))


class Langevin(Removable):
    """The n-th derivative of coth(x) - 1/x = x/3 - x^3/45 + ..., whose poles are i pi, 2 i pi, ..."""

    form = staticmethod(lambda x: sp.coth(x) - 1 / x)
    power_series = staticmethod(lambda x: (x * x.cosh() - x.sinh()) / (x * x.sinh()))

"""The table of functions: a row for each, with all that is known of it, and the one fold over expressions.

A new function is one row here and nothing else: formulas, printers, derivatives, balls, series and differences
look it up when they need it. In other languages it is written where SymPy's printers have it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np
import sympy as sp
from flint import acb, arb, arb_series
from sympy.codegen.cfunctions import expm1, log1p

from stickslip_sym.core.aliases import Expr, ExprOrCondition
from stickslip_sym.core.numbers import DOUBLE_BITS, bits
from stickslip_sym.core.special import Ein, Erfcx, Langevin, Lerch, NumberPower, Removable, polylog

T = TypeVar("T")


@dataclass(frozen=True)
class Function:
    """A function, and all that is known of it. Its derivative is SymPy's, `kind.fdiff`."""

    kind: type[Expr]
    """SymPy's class."""
    ball: Callable[..., acb] | None
    """From balls of the arguments to a ball around the value, in Arb."""
    cut: Callable[..., bool] = lambda *z: False
    """Whether a ball of the argument meets a branch cut. A pole needs none: no ball around it is finite."""
    series: Callable[..., arb_series] | None = None
    """From the power series of the argument to that of the function; None where the integral of its derivative
    has to do."""
    stable_difference: Callable[[Expr, Expr, Expr], Expr] | None = None
    """From the argument x, its value a at another point, and x - a: f(x) - f(a), without cancellation where the
    two are close; None where the difference is taken as it stands."""
    inverse: type[Expr] | None = None
    """SymPy's class of the inverse, of a function that rises from any value to any higher one."""
    analytic: bool = False
    """Whether it is analytic at every real argument."""
    domain: Callable[..., Sequence[Expr] | None] = lambda *z: None
    """From the arguments of any other: what must be positive for it to be analytic; None where it is not known."""
    hypergeometric: Callable[..., Expr] | None = None
    """From the arguments: the same by hypergeometric series around 0."""
    iterated_integral: Callable[[Expr, int, int], Expr | None] | None = None
    """From x, n and j: the j-th integral of the n-th power, or of the n-th derivative where it has an order; None
    where it has none."""
    bounded: bool = False
    """Whether its size has a bound over all real arguments."""
    in_laws: bool = False
    """Whether the formula of a friction law may have it."""
    aliases: tuple[str, ...] = ()
    """Other names that are read."""
    latex: str | None = ""
    r"""Its name in LaTeX; by default ``\operatorname{name}``, None where it is printed in a way of its own."""
    indexed: bool = False
    """Whether LaTeX writes the first argument as an index."""
    floats: Callable[..., Any] | None = None
    """From floats or arrays; None where SciPy, else NumPy, and math have it by its name. What SymPy would write by
    exponentials, which overflow apart, stands here."""
    squared: bool = False
    """Whether LaTeX writes powers on the name."""
    meaning: str = ""
    """What a document says of it, in LaTeX, of a function that not every reader knows."""
    dlmf: str = ""
    """The sections of the Digital Library of Mathematical Functions on its derivative and its series."""

    @property
    def name(self) -> str:
        """Its name in a formula."""
        return str(self.kind.__name__)


@dataclass(frozen=True)
class Constant:
    """A constant with a name: its value as SymPy's and as a ball, and what LaTeX calls it."""

    name: str
    value: Expr
    ball: Callable[[], acb]
    latex: str
    in_laws: bool = False


_MOST_ROOT_BITS = 2 * DOUBLE_BITS  # of a number times the index of its root, where SymPy simplifies (1/4)^(3/2)


def power(base: Expr, exponent: Expr) -> Expr:
    """Return a power, its rational factor kept as it is written where SymPy would expand it."""
    number, rest = base.as_coeff_Mul(rational=True) if not base.is_Rational else (base, sp.S.One)
    harmless = not exponent.is_Rational or exponent.is_Integer or number in (0, 1) or number.is_negative
    if harmless or bits(number) * exponent.q <= _MOST_ROOT_BITS:
        return base**exponent
    if exponent > 0:
        of_number = NumberPower(number, exponent)
    else:
        of_number = NumberPower(1 / number, -exponent)
    return of_number * rest**exponent


# -- where branch cuts lie, and differences without cancellation -----------------------------------


def _cut_below_zero(z: acb) -> bool:
    return bool(z.imag.contains(0) and not z.real > 0)


def _cut_below_one(z: acb) -> bool:
    return _cut_below_zero(z - 1)


def _sech(z: acb) -> acb:
    """Return sech(z), which is finite on wide balls as well, where Arb's own is not."""
    decaying = (-z if z.real > 0 else z).exp()
    return 2 * decaying / (1 + decaying * decaying)


def _cut_outside_real_unit(z: acb) -> bool:
    return bool(z.imag.contains(0) and not abs(z.real) < 1)


def _cut_outside_imaginary_unit(z: acb) -> bool:
    return bool(z.real.contains(0) and not abs(z.imag) < 1)


def _anywhere(*z: acb) -> bool:
    """Say that a function may not be analytic, as nothing is known of it."""
    return True


def _difference_of_asinh(x: Expr, a: Expr, step: Expr) -> Expr:
    return sp.asinh(step * (x + a) / (x * sp.sqrt(1 + a**2) + a * sp.sqrt(1 + x**2)))


def _difference_of_cosh(x: Expr, a: Expr, step: Expr) -> Expr:
    return 2 * sp.sinh((x + a) / 2) * sp.sinh(step / 2)


def _where_it_converges(upper: Sequence[Expr], lower: Sequence[Expr], z: Expr) -> Sequence[Expr] | None:
    if len(upper) > len(lower) + 1 or any(b.is_integer and b.is_nonpositive for b in lower):
        return None
    if len(upper) <= len(lower):
        return ()
    return (1 - z,)


def _bessel_by_hypergeometric(sign: int) -> Callable[[Expr, Expr], Expr]:
    return lambda n, z: (z / 2) ** n / sp.factorial(n) * sp.hyper((), (n + 1,), sign * z**2 / 4)


def _domain_of_whole_order(order: Expr, z: Expr) -> Sequence[Expr] | None:
    return () if order.is_Integer else None


# -- repeated integrals ----------------------------------------------------------------------------


def _trigonometric_integrals(function: type[Expr]) -> Callable[[Expr, int, int], Expr | None]:
    return lambda x, n, j: function(x - j * sp.pi / 2) if n == 1 else None


def _iterated_integral_of_tanh(x: Expr, n: int, j: int) -> Expr:
    """Tanh = 1 + 2 Li_0(-exp(-2 x)), Li_s integrates to Li_(s+1); tanh^n = tanh^(n-2) - (tanh^(n-1))'/(n - 1)."""
    if j == 0 or n == 0:
        return sp.tanh(x) ** n * x**j / sp.factorial(j)
    if n > 1:
        return _iterated_integral_of_tanh(x, n - 2, j) - _iterated_integral_of_tanh(x, n - 1, j - 1) / (n - 1)
    z = -sp.exp(-2 * x)
    if j == 1:
        last = -sp.log(1 - z)
    else:
        last = polylog(j, z)
    return x**j / sp.factorial(j) + 2 * sp.Rational(-1, 2) ** j * last


def _iterated_integral_of_sech(x: Expr, n: int, j: int) -> Expr:
    """Note that sech = 2 Ti_0(exp(-x)), Ti_j(y) = Im Li_j(i y).

    (n - 1) sech^n = (n - 2) sech^(n-2) - (sech^(n-2))''/(n - 2), sech^2 = tanh'.
    """
    if j <= 0:
        return sp.diff(sp.sech(x) ** n, x, -j)
    if n == 1:
        y = sp.exp(-x)
        return 2 * sp.S.NegativeOne**j * (sp.atan(y) if j == 1 else sp.im(polylog(j, sp.I * y)))
    if n == 2:
        return _iterated_integral_of_tanh(x, 1, j - 1)
    return (
        (n - 2) * _iterated_integral_of_sech(x, n - 2, j) - _iterated_integral_of_sech(x, n - 2, j - 2) / (n - 2)
    ) / (n - 1)


def _iterated_integral_of_langevin(x: Expr, order: int, j: int) -> Expr:
    """Note that coth = 1 + 2 Li_0(exp(-2 x)), and that 1/x has the integrals x^(j-1)/(j-1)! (log x - H_(j-1))."""
    if j <= order:
        return sp.diff(sp.coth(x) - 1 / x, x, order - j)
    j -= order
    z = sp.exp(-2 * x)
    if j == 1:
        return x + sp.log((1 - z) / x)
    pole = x ** (j - 1) / sp.factorial(j - 1) * (sp.log(x) - sp.harmonic(j - 1))
    return x**j / sp.factorial(j) + 2 * sp.Rational(-1, 2) ** j * polylog(j, z) - pole


_HALF = sp.Rational(1, 2)
_ROWS = (
    Function(
        sp.exp,
        acb.exp,
        series=arb_series.exp,
        stable_difference=lambda x, a, step: sp.exp(a) * expm1(step),
        inverse=sp.log,
        analytic=True,
        hypergeometric=lambda z: sp.hyper((), (), z),
        iterated_integral=lambda x, n, j: sp.exp(x),
        in_laws=True,
        latex=None,
        dlmf="4.7, 4.2",
    ),
    Function(
        sp.log,
        acb.log,
        _cut_below_zero,
        arb_series.log,
        stable_difference=lambda x, a, step: log1p(step / a),
        inverse=sp.exp,
        domain=lambda z: (z,),
        in_laws=True,
        aliases=("ln",),
        latex=r"\ln",
    ),
    Function(
        sp.sin,
        acb.sin,
        series=arb_series.sin,
        stable_difference=lambda x, a, step: 2 * sp.cos((x + a) / 2) * sp.sin(step / 2),
        analytic=True,
        bounded=True,
        hypergeometric=lambda z: z * sp.hyper((), (3 * _HALF,), -(z**2) / 4),
        iterated_integral=_trigonometric_integrals(sp.sin),
        in_laws=True,
        latex=r"\sin",
        squared=True,
    ),
    Function(
        sp.cos,
        acb.cos,
        series=arb_series.cos,
        stable_difference=lambda x, a, step: -2 * sp.sin((x + a) / 2) * sp.sin(step / 2),
        analytic=True,
        bounded=True,
        hypergeometric=lambda z: sp.hyper((), (_HALF,), -(z**2) / 4),
        iterated_integral=_trigonometric_integrals(sp.cos),
        in_laws=True,
        latex=r"\cos",
        squared=True,
    ),
    Function(sp.tan, acb.tan, series=arb_series.tan, in_laws=True, latex=r"\tan", squared=True),
    Function(
        sp.sinh,
        acb.sinh,
        series=lambda z: (z.exp() - (-z).exp()) / 2,
        stable_difference=lambda x, a, step: 2 * sp.cosh((x + a) / 2) * sp.sinh(step / 2),
        inverse=sp.asinh,
        analytic=True,
        in_laws=True,
        latex=r"\sinh",
        squared=True,
    ),
    Function(
        sp.cosh,
        acb.cosh,
        series=lambda z: (z.exp() + (-z).exp()) / 2,
        stable_difference=_difference_of_cosh,
        analytic=True,
        in_laws=True,
        latex=r"\cosh",
        squared=True,
    ),
    Function(
        sp.tanh,
        acb.tanh,
        series=lambda z: 1 - 2 / ((2 * z).exp() + 1),
        stable_difference=lambda x, a, step: sp.tanh(step) * (1 - sp.tanh(x) * sp.tanh(a)),
        analytic=True,
        bounded=True,
        iterated_integral=_iterated_integral_of_tanh,
        in_laws=True,
        latex=r"\tanh",
        squared=True,
    ),
    Function(
        sp.sech,
        _sech,
        series=lambda z: 2 / (z.exp() + (-z).exp()),
        stable_difference=lambda x, a, step: -_difference_of_cosh(x, a, step) * sp.sech(x) * sp.sech(a),
        analytic=True,
        bounded=True,
        iterated_integral=_iterated_integral_of_sech,
        in_laws=True,
        squared=True,
        floats=lambda x: 1 / np.cosh(x),
    ),
    Function(
        sp.coth,
        acb.coth,
        series=lambda z: 1 + 2 / ((2 * z).exp() - 1),
        stable_difference=lambda x, a, step: -sp.sinh(step) / (sp.sinh(x) * sp.sinh(a)),
        in_laws=True,
        latex=r"\coth",
        squared=True,
        floats=lambda x: 1 / np.tanh(x),
    ),
    Function(
        Langevin,
        Langevin.ball,
        series=Langevin.series,
        analytic=True,
        bounded=True,
        floats=Langevin.floats,
        iterated_integral=_iterated_integral_of_langevin,
        latex=None,
    ),
    Function(sp.csch, acb.csch),
    # Arb's own asinh is not finite on wide balls.
    Function(
        sp.asinh,
        lambda z: (z + (z * z + 1).sqrt()).log(),
        _cut_outside_imaginary_unit,
        series=lambda z: (z + (z * z + 1).sqrt()).log(),
        stable_difference=_difference_of_asinh,
        inverse=sp.sinh,
        analytic=True,
        in_laws=True,
        aliases=("arcsinh", "arsinh"),
        latex=r"\operatorname{arsinh}",
        meaning=r"$\operatorname{arsinh}$ is the inverse hyperbolic sine",
    ),
    Function(sp.acosh, acb.acosh, _cut_below_one, latex=r"\operatorname{arcosh}"),
    Function(sp.atanh, acb.atanh, _cut_outside_real_unit, latex=r"\operatorname{artanh}"),
    Function(
        sp.atan,
        acb.atan,
        _cut_outside_imaginary_unit,
        arb_series.atan,
        stable_difference=lambda x, a, step: sp.atan2(step, 1 + x * a),
        analytic=True,
        bounded=True,
        in_laws=True,
        aliases=("arctan",),
        latex=r"\arctan",
    ),
    Function(
        sp.asin,
        acb.asin,
        _cut_outside_real_unit,
        domain=lambda z: (1 - z**2,),
        in_laws=True,
        aliases=("arcsin",),
        latex=r"\arcsin",
    ),
    Function(
        sp.acos,
        acb.acos,
        _cut_outside_real_unit,
        domain=lambda z: (1 - z**2,),
        in_laws=True,
        aliases=("arccos",),
        latex=r"\arccos",
    ),
    Function(
        sp.erf,
        acb.erf,
        series=arb_series.erf,
        analytic=True,
        bounded=True,
        in_laws=True,
        meaning=r"$\operatorname{erf}$ is the error function",
    ),
    Function(sp.erfc, acb.erfc, series=arb_series.erfc, analytic=True, bounded=True),
    Function(
        Erfcx,
        Erfcx.ball,
        series=lambda z: (z * z).exp() * z.erfc(),
        analytic=True,
        floats=Erfcx.floats,
        latex=r"\operatorname{erfcx}",
    ),
    Function(sp.erfi, acb.erfi, series=arb_series.erfi, analytic=True),
    Function(expm1, acb.expm1, floats=np.expm1),
    Function(log1p, acb.log1p, lambda z: _cut_below_zero(1 + z)),
    Function(
        sp.besseli,
        lambda order, z: z.bessel_i(order),
        _anywhere,
        domain=_domain_of_whole_order,
        hypergeometric=_bessel_by_hypergeometric(1),
        latex="I",
        indexed=True,
        dlmf="10.29, 10.25",
        meaning="$I_n$ is the modified Bessel function of the first kind",
    ),
    Function(
        sp.besselj,
        lambda order, z: z.bessel_j(order),
        _anywhere,
        domain=_domain_of_whole_order,
        hypergeometric=_bessel_by_hypergeometric(-1),
        latex="J",
        indexed=True,
        dlmf="10.6, 10.2",
    ),
    Function(sp.besselk, lambda order, z: z.bessel_k(order), _anywhere, latex="K", indexed=True),
    Function(sp.bessely, lambda order, z: z.bessel_y(order), _anywhere, latex="Y", indexed=True),
    Function(sp.gamma, acb.gamma, latex=r"\Gamma"),
    Function(
        sp.lowergamma,
        lambda s, z: z.gamma_lower(s),
        _anywhere,
        domain=lambda s, z: (s,) if z.is_nonnegative else None,
        latex=r"\gamma",
        meaning=r"$\gamma(s, x)$ is the lower incomplete gamma function",
    ),
    Function(
        sp.uppergamma,
        lambda s, z: z.gamma_upper(s),
        _anywhere,
        domain=lambda s, z: (z,),
        latex=r"\Gamma",
        meaning=r"$\Gamma(s, x)$ is the upper incomplete gamma function",
    ),
    Function(sp.beta, None, _anywhere, latex=r"\mathrm{B}"),
    Function(sp.expint, lambda s, z: z.expint(s), _anywhere, domain=lambda s, z: (z,), latex="E", indexed=True),
    Function(
        sp.polylog,
        lambda s, z: z.polylog(s),
        _anywhere,
        domain=lambda s, z: () if z.is_imaginary else (1 - z,),
        latex=r"\operatorname{Li}",
        indexed=True,
        meaning=r"$\operatorname{Li}_n$ is the polylogarithm",
    ),
    Function(
        Ein,
        Ein.ball,
        analytic=True,
        floats=Ein.floats,
        latex=r"\operatorname{Ein}",
        dlmf="6.2",
        meaning=r"$\operatorname{Ein}(x)$ is the integral from $0$ to $x$ of $(1 - \mathrm{e}^{-t})/t$",
    ),
    Function(sp.zeta, acb.zeta, _anywhere, latex=r"\zeta"),
    Function(
        sp.dirichlet_eta,
        acb.dirichlet_eta,
        _anywhere,
        latex=r"\eta",
        meaning=r"$\eta$ is Dirichlet's eta function",
    ),
    Function(
        sp.hyper,
        None,
        domain=_where_it_converges,
        latex=None,
        dlmf="16.3, 16.2",
        meaning="${}_pF_q$ is the generalised hypergeometric function",
    ),
    Function(
        sp.elliptic_k,
        acb.elliptic_k,
        _anywhere,
        domain=lambda m: (1 - m,),
        hypergeometric=lambda m: sp.pi / 2 * sp.hyper((_HALF, _HALF), (1,), m),
        latex="K",
        dlmf="19.4, 19.5",
    ),
    Function(
        sp.elliptic_e,
        acb.elliptic_e,
        _anywhere,
        domain=lambda m: (1 - m,),
        hypergeometric=lambda m: sp.pi / 2 * sp.hyper((-_HALF, _HALF), (1,), m),
        latex="E",
        dlmf="19.4, 19.5",
        meaning="$E(m)$ is the complete elliptic integral of the second kind of the parameter $m$",
    ),
    Function(
        sp.elliptic_pi,
        acb.elliptic_pi,
        _anywhere,
        domain=lambda n, m: (1 - n, 1 - m),
        latex=r"\Pi",
        dlmf="19.2, 19.4, 19.5",
        meaning=r"$\Pi(n, m)$ is the one of the third kind, of the characteristic $n$",
    ),
    Function(Lerch, Lerch.ball, _anywhere, domain=lambda z, s, a: () if z.is_nonpositive else None, latex=r"\Phi"),
    Function(
        sp.Ei,
        acb.ei,
        _anywhere,
        domain=lambda z: (z,),
        latex=r"\operatorname{Ei}",
        meaning=r"$\operatorname{Ei}$ is the exponential integral",
    ),
    Function(
        sp.Si,
        acb.si,
        analytic=True,
        bounded=True,
        latex=r"\operatorname{Si}",
        meaning=r"$\operatorname{Si}(x)$ is the integral from $0$ to $x$ of $\sin(t)/t$",
    ),
    Function(sp.Ci, acb.ci, _anywhere),
    Function(sp.Shi, acb.shi, _anywhere),
    Function(sp.Chi, acb.chi, _anywhere),
    Function(sp.fresnels, acb.fresnel_s, _anywhere, latex="S"),
    Function(sp.fresnelc, acb.fresnel_c, _anywhere, latex="C"),
    Function(NumberPower, NumberPower.ball, latex=None),
    Function(sp.re, lambda z: acb(z.real), _anywhere, latex=r"\operatorname{Re}"),
    Function(sp.im, lambda z: acb(z.imag), _anywhere, domain=lambda z: (), latex=r"\operatorname{Im}"),
    Function(sp.Abs, lambda z: acb(abs(z)), _anywhere, latex=None),
    Function(sp.arg, lambda z: acb(z.arg()), _anywhere, latex=r"\arg"),
    Function(sp.sign, lambda z: z.sgn(), _anywhere, latex=r"\operatorname{sgn}"),
)

FUNCTIONS: dict[type[Expr], Function] = {function.kind: function for function in _ROWS}
"""Every function by SymPy's class."""

CONSTANTS = {
    constant.value: constant
    for constant in (
        Constant("pi", sp.pi, acb.pi, r"\pi", in_laws=True),
        Constant("E", sp.E, lambda: acb(1).exp(), "e"),
        Constant("I", sp.I, lambda: acb(0, 1), "i"),
        Constant("EulerGamma", sp.EulerGamma, lambda: acb(arb.const_euler()), r"\gamma"),
        Constant("Catalan", sp.Catalan, lambda: acb(arb.const_catalan()), "G"),
    )
}
"""Every constant by SymPy's."""


def row(expr: Expr) -> Function | None:
    """Return the row of the function that an expression applies to its arguments; None for any other node."""
    kind = expr.func
    if expr.is_Pow and expr.base is sp.E:
        kind = sp.exp
    return FUNCTIONS.get(kind) or FUNCTIONS.get(kind.__bases__[0])  # a class of ours may stand for SymPy's


def must_be_positive(expr: Expr) -> Sequence[Expr] | None:
    """Return what must be positive for a node to be analytic in its arguments; None where that is not known."""
    known = row(expr)
    if expr.is_Add or expr.is_Mul or (known is not None and known.analytic):
        return ()
    if known is None:
        return None
    return known.domain(*expr.args)


_ANY = sp.Wild("a")


@lru_cache
def write_sech(expr: Expr) -> Expr:
    """Write 1 - tanh^2 as sech^2, which does not cancel."""
    if expr.has(sp.tanh):
        return expr.replace(1 - sp.tanh(_ANY) ** 2, sp.sech(_ANY) ** 2)
    return expr


def write_erfcx(expr: Expr) -> Expr:
    """Write exp(x^2) erfc(x), of which one factor overflows far out, as one function."""

    def scaled(product: Expr) -> Expr:
        for factor in product.atoms(sp.erfc):
            (x,) = factor.args
            for other in product.args:
                if isinstance(other, sp.exp) and sp.expand(other.exp - x**2) == 0:
                    return product / factor / other * Erfcx(x)
        return product

    if expr.has(sp.erfc):
        return expr.replace(lambda node: node.is_Mul, scaled)
    return expr


def elementary(expr: ExprOrCondition) -> ExprOrCondition:
    """Write functions that are one node for a removable singularity, such as Langevin's, as coth(x) - 1/x."""
    return expr.replace(lambda node: isinstance(node, Removable), lambda node: node.elementary())


def functions_in_laws() -> dict[str, Function]:
    """Return the functions that a friction law may have, by every name that is read."""
    rows = [row for row in FUNCTIONS.values() if row.in_laws]
    return {name: row for row in rows for name in (row.name, *row.aliases)}


def arguments(expr: Expr) -> Sequence[Expr]:
    """Return the arguments of a node; those of a hypergeometric function stand in tuples."""
    if expr.is_Pow and expr.base is sp.E:
        return (expr.exp,)
    return [
        part for argument in expr.args for part in (argument if isinstance(argument, sp.Tuple) else [argument])
    ]


def fold(expr: Expr, combine: Callable[[Expr, list[T]], T]) -> T:
    """Return what an expression is in an algebra: a node from its arguments, each distinct node once.

    `combine` takes a node, and what its `arguments` are, to what the node is; an atom has none.
    """
    seen: dict[Expr, T] = {}

    def of(node: Expr) -> T:
        if node not in seen:
            seen[node] = combine(node, [of(argument) for argument in arguments(node)])
        return seen[node]

    return of(expr)

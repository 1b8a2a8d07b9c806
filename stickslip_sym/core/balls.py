"""SymPy expressions as functions of balls: complex numbers with a radius, in Arb's arithmetic.

A ball function returns a ball that holds every value which the expression takes on its argument. Only the nodes
of a closed list are translated. Where Arb integrates it asks whether a function is analytic on a whole ball: a
branch cut that is not reported gives a tight ball around a wrong number, so each function with one looks for it.
"""

import operator
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import reduce
from typing import Generic, TypeVar, cast

import sympy as sp
from flint import acb, arb, arb_series, ctx, fmpq

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.lerch import Lerch

__all__ = [
    "BallFunction", "ball", "ball_function", "ball_value", "flat_arguments", "rational", "series_function",
    "working_precision",
]  # fmt: skip

Z = TypeVar("Z", acb, arb_series)
BallFunction = Callable[[acb, bool], acb]
"""A function of a ball; the flag asks for a ball that is not finite where it is not analytic."""
Otherwise = Callable[[Expr, list[acb]], acb]
"""From a function that has no ball here, and the balls of its arguments, to a ball around its value."""

_LARGEST_POWER = 64  # of an integer exponent that is multiplied out; a power by logarithm fails around 0
_lock = threading.RLock()  # Arb's precision is one setting of the whole process
_NOWHERE = acb("nan")


@contextmanager
def working_precision(bits: int, terms: int | None = None) -> Iterator[None]:
    """Compute with so many bits, and terms of a power series, inside the block, and as before after it.

    Other threads wait.
    """
    with _lock:
        before = ctx.prec, ctx.cap
        ctx.prec, ctx.cap = bits, ctx.cap if terms is None else terms
        try:
            yield
        finally:
            ctx.prec, ctx.cap = before


def rational(value: Expr) -> fmpq:
    """Return an exact SymPy rational as Arb's."""
    return fmpq(int(value.p), int(value.q))


def ball(value: Expr) -> acb:
    """Return the smallest ball of the working precision around an exact SymPy rational."""
    return acb(rational(value))


def ball_value(expr: Expr, point: Mapping[Expr, Expr | acb], otherwise: Otherwise | None = None) -> acb:
    """Return a ball around the value of an expression at values of its symbols.

    Parameters
    ----------
    expr : sympy.Expr
    point : mapping
        Exact rational values of its symbols, or balls.
    otherwise : callable, optional
        Takes a function that is not among those enclosed, or has no finite ball there, and the balls of its
        arguments; returns a ball in its place.

    Raises
    ------
    InputError
        For a function that is not in the list, unless `otherwise` serves it.
    """
    values = {symbol: value if isinstance(value, acb) else ball(value) for symbol, value in point.items()}
    return _constant(_chosen(expr, point), values, otherwise)


def ball_function(expr: Expr, variable: Expr, point: Mapping[Expr, Expr]) -> BallFunction:
    """Return an expression as a function of one symbol, the others having exact rational values.

    It holds constants of the present working precision.

    Raises
    ------
    InputError
        For a node that is not in the list.
    """
    return _BALLS.translated(expr, variable, {symbol: ball(value) for symbol, value in point.items()})


def series_function(expr: Expr, variable: Expr, point: Mapping[Expr, Expr]) -> Callable[[arb_series], arb_series]:
    """Return an expression as a function of a power series, with balls for coefficients; as `ball_function`."""
    function = _SERIES.translated(expr, variable, {symbol: ball(value) for symbol, value in point.items()})

    def of_series(series: arb_series) -> arb_series:
        value = function(series, False)
        return arb_series([value], prec=ctx.cap) if isinstance(value, arb) else value

    return of_series


def _chosen(expr: Expr, point: Mapping[Expr, Expr]) -> Expr:
    """Decide, exactly, which of its pieces an expression takes at a point."""
    nodes = expr.atoms(sp.Piecewise, sp.Min, sp.Max)
    return expr.xreplace({node: _decided(node, point) for node in nodes}) if nodes else expr


def _decided(node: Expr, point: Mapping[Expr, Expr]) -> Expr:
    if isinstance(node, sp.Piecewise):
        return next(_chosen(part, point) for part, holds in node.args if holds.xreplace(dict(point)))
    values = {argument: argument.xreplace(dict(point)) for argument in node.args}
    best = node.func(*values.values())
    return next(_chosen(argument, point) for argument, value in values.items() if value == best)


@dataclass(frozen=True)
class _Arithmetic(Generic[Z]):
    """What an expression is translated into.

    Attributes
    ----------
    functions : mapping
        SymPy's functions of one argument, as functions of a value and of the flag.
    power : callable
        A power that is no whole number, of a value, its exponent and the flag.
    constant : callable
        What a ball is as a constant there.
    """

    functions: Mapping[type[Expr], Callable[[Z, bool], Z]]
    power: Callable[[Z, acb, bool], Z]
    constant: Callable[[acb], Z]

    def translated(self, expr: Expr, variable: Expr, values: Mapping[Expr, acb]) -> Callable[[Z, bool], Z]:
        """Return an expression as a function of one symbol."""
        if expr == variable:
            return lambda z, analytic: z
        if not expr.has(variable):
            constant = self.constant(_constant(expr, values))
            return lambda z, analytic: constant
        if expr.is_Add or expr.is_Mul:
            return self._folded(expr, variable, values)
        if expr.is_Pow and expr.base is not sp.E:
            return self._raised(expr, variable, values)
        kind = sp.exp if expr.is_Pow else type(expr)
        if kind not in self.functions:
            raise InputError(f"{kind.__name__} is not among the functions that are enclosed")
        function, argument = self.functions[kind], expr.exp if expr.is_Pow else expr.args[0]
        inner = self.translated(argument, variable, values)
        return lambda z, analytic: function(inner(z, analytic), analytic)

    def _folded(self, expr: Expr, variable: Expr, values: Mapping[Expr, acb]) -> Callable[[Z, bool], Z]:
        """Return a sum or a product, its constant part computed once."""
        fixed, moving = expr.as_independent(variable, as_Add=expr.is_Add)
        parts = [self.translated(part, variable, values) for part in type(expr).make_args(moving)]
        if fixed != type(expr).identity:
            constant = self.constant(_constant(fixed, values))
            parts.append(lambda z, analytic: constant)
        join = operator.add if expr.is_Add else operator.mul
        return lambda z, analytic: reduce(join, [part(z, analytic) for part in parts])

    def _raised(self, expr: Expr, variable: Expr, values: Mapping[Expr, acb]) -> Callable[[Z, bool], Z]:
        inner, exponent = self.translated(expr.base, variable, values), expr.exp
        if exponent.is_Integer and abs(exponent) <= _LARGEST_POWER:
            count = int(exponent)
            return lambda z, analytic: _whole_power(inner(z, analytic), count)
        if exponent.has(variable):
            raise InputError(
                f"a power whose exponent depends on {variable} is not among the functions that are enclosed"
            )
        constant = _constant(exponent, values)
        return lambda z, analytic: self.power(inner(z, analytic), constant, analytic)


def _whole_power(z: Z, exponent: int) -> Z:
    """Multiply out: Arb's own power of a ball around 0 is not a number."""
    power = reduce(operator.mul, [z] * abs(exponent)) if abs(exponent) < 4 else _squared_up(z, abs(exponent))
    return power if exponent > 0 else 1 / power


def _squared_up(z: Z, exponent: int) -> Z:
    half = _whole_power(z, exponent // 2)
    return half * half * z if exponent % 2 else half * half


def _power(z: acb, exponent: acb, analytic: bool) -> acb:
    """Return z^p: by the logarithm, and for p > 0 around 0, where there is none, within the largest size."""
    if not analytic and exponent.real > 0 and exponent.imag == 0 and z.contains(0):
        largest = arb(z.abs_upper())
        size = largest**exponent.real if largest > 0 else arb(0)
        around = arb(0, size.abs_upper())
        return acb(around, around)
    return z.pow(exponent, analytic)


def _arctangent(z: acb, analytic: bool) -> acb:
    """Return atan(z), whose cuts run along the imaginary axis from i and -i outwards."""
    return _NOWHERE if analytic and z.real.contains(0) and not abs(z.imag) < 1 else z.atan()


_MEROMORPHIC: dict[type[Expr], Callable[[acb], acb]] = {
    sp.exp: acb.exp, sp.sin: acb.sin, sp.cos: acb.cos, sp.tan: acb.tan, sp.sinh: acb.sinh, sp.cosh: acb.cosh,
    sp.tanh: acb.tanh, sp.coth: acb.coth, sp.sech: acb.sech, sp.csch: acb.csch, sp.erf: acb.erf,
    sp.erfc: acb.erfc, sp.erfi: acb.erfi,
}  # fmt: skip
"""Functions without branch cuts: a ball that holds a pole is not finite by itself."""
_CUT: dict[type[Expr], Callable[[acb, bool], acb]] = {
    sp.log: lambda z, analytic: z.log(analytic),
    sp.atan: _arctangent,
    sp.asinh: lambda z, analytic: (z + (z * z + 1).sqrt(analytic)).log(analytic),  # Arb's own fails on wide balls
}


def _whatever_is_asked(function: Callable[[Z], Z]) -> Callable[[Z, bool], Z]:
    """Return a function that takes the flag too, and needs it not."""
    return lambda z, analytic: function(z)


_BALLS: _Arithmetic[acb] = _Arithmetic(
    {kind: _whatever_is_asked(function) for kind, function in _MEROMORPHIC.items()} | _CUT, _power, lambda z: z
)
_SERIES: _Arithmetic[arb_series] = _Arithmetic(
    {
        kind: _whatever_is_asked(function)
        for kind, function in {
            sp.exp: arb_series.exp, sp.log: arb_series.log, sp.sin: arb_series.sin, sp.cos: arb_series.cos,
            sp.tan: arb_series.tan, sp.atan: arb_series.atan, sp.erf: arb_series.erf, sp.erfc: arb_series.erfc,
            sp.erfi: arb_series.erfi,
            sp.sinh: lambda z: (z.exp() - (-z).exp()) / 2,
            sp.cosh: lambda z: (z.exp() + (-z).exp()) / 2,
            sp.tanh: lambda z: 1 - 2 / ((2 * z).exp() + 1),
            sp.coth: lambda z: 1 + 2 / ((2 * z).exp() - 1),
            sp.sech: lambda z: 2 / (z.exp() + (-z).exp()),
            sp.asinh: lambda z: (z + (z * z + 1).sqrt()).log(),
        }.items()
    },
    lambda z, exponent, analytic: (z.log() * exponent.real).exp(),
    # A number, which joins any series: a series of it would keep for good the number of terms of the moment.
    lambda z: cast(arb_series, z.real),
)  # fmt: skip
_NUMBERS: dict[Expr, Callable[[], acb]] = {
    sp.pi: acb.pi,
    sp.E: lambda: acb(1).exp(),
    sp.I: lambda: acb(0, 1),
    sp.EulerGamma: lambda: acb(arb.const_euler()),
    sp.Catalan: lambda: acb(arb.const_catalan()),
}
_OF_CONSTANTS: dict[type[Expr], Callable[..., acb]] = {
    sp.Add: lambda *terms: reduce(operator.add, terms),
    sp.Mul: lambda *factors: reduce(operator.mul, factors),
    sp.Pow: lambda base, exponent: base.pow(exponent),
    sp.besseli: lambda order, z: z.bessel_i(order),
    sp.lowergamma: lambda s, z: z.gamma_lower(s),
    sp.uppergamma: lambda s, z: z.gamma_upper(s),
    sp.gamma: acb.gamma,
    sp.besselj: lambda order, z: z.bessel_j(order),
    sp.expint: lambda s, z: z.expint(s),
    sp.polylog: lambda s, z: z.polylog(s),
    sp.zeta: acb.zeta,
    sp.dirichlet_eta: acb.dirichlet_eta,
    sp.elliptic_k: acb.elliptic_k,
    sp.elliptic_e: acb.elliptic_e,
    sp.elliptic_pi: acb.elliptic_pi,
    sp.acos: acb.acos,
    sp.asin: acb.asin,
    sp.acosh: acb.acosh,
    sp.atanh: acb.atanh,
    Lerch: lambda z, s, a: z.lerch_phi(s, a),
    sp.re: lambda z: acb(z.real),
    sp.im: lambda z: acb(z.imag),
    sp.Abs: lambda z: acb(abs(z)),
    sp.arg: lambda z: acb(z.arg()),
    sp.sign: lambda z: z.sgn(),
}
"""Functions of constants only, which closed forms hold."""


def _constant(expr: Expr, values: Mapping[Expr, acb], otherwise: Otherwise | None = None) -> acb:
    """Return a ball around an expression whose symbols have values."""
    if expr.is_Rational:
        return ball(expr)
    if expr.is_Symbol:
        return values[expr]
    if expr in _NUMBERS:
        return _NUMBERS[expr]()
    kind = sp.exp if expr.is_Pow and expr.base is sp.E else type(expr)
    if kind is sp.Pow and expr.exp.is_Integer and abs(expr.exp) <= _LARGEST_POWER:
        return acb(_whole_power(_constant(expr.base, values, otherwise), int(expr.exp)))
    parts = (expr.exp,) if kind is sp.exp else flat_arguments(expr)
    arguments = [_constant(part, values, otherwise) for part in parts]
    found = _of_constants(kind, arguments, expr)
    if otherwise is not None and isinstance(expr, sp.Function) and (found is None or not found.is_finite()):
        return otherwise(expr, arguments)
    if found is None:
        raise InputError(f"{kind.__name__} is not among the functions that are enclosed")
    return found


def _of_constants(kind: type[Expr], arguments: list[acb], expr: Expr) -> acb | None:
    if kind is sp.hyper:
        top = len(expr.args[0])
        return arguments[-1].hypgeom([*arguments[:top]], [*arguments[top:-1]])
    if kind in _OF_CONSTANTS:
        return _OF_CONSTANTS[kind](*arguments)
    return acb(_BALLS.functions[kind](arguments[0], False)) if kind in _BALLS.functions else None


def flat_arguments(expr: Expr) -> list[Expr]:
    """Return the arguments of a function; those of a hypergeometric one stand in tuples."""
    return [
        part for argument in expr.args for part in (argument if isinstance(argument, sp.Tuple) else [argument])
    ]

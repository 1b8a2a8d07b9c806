"""What an expression gains from one slip speed to another, with all its digits.

Where the belt hardly moves, mu(v) and mu(0+) agree to most of their digits, and their difference is what drives
the mass. Identities such as exp(a) - exp(b) = exp(b) expm1(a - b) say it as products, which lose none.
Each is in the table of functions.
"""

import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import row

__all__ = ["gain"]

_LONGEST = 16  # terms of a^n - b^n as a sum; for larger n it is the exponential of a logarithm


def gain(expr: Expr, variable: Expr, start: Expr) -> Expr | None:
    """Return expr(variable) - expr(start), in a form that does not cancel where the two are close.

    Parameters
    ----------
    expr : sympy.Expr
        Without a Piecewise in the variable.
    variable : sympy.Symbol
    start : sympy.Expr
        Without the variable.

    Returns
    -------
    sympy.Expr or None
        None where a part of the expression has no finite value at `start`. A function that has no rule in the
        table is subtracted as it stands, unless it is 0 at `start`.
    """
    try:
        return _Gain(variable, start).of(expr)
    except _NoValue:
        return None


class _NoValue(Exception):
    """A part has no finite value at the start."""


class _Gain:
    def __init__(self, variable: Expr, start: Expr) -> None:
        self.variable, self.start = variable, start

    def low(self, expr: Expr) -> Expr:
        value = expr.subs(self.variable, self.start)
        if value.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
            raise _NoValue
        return value

    def of(self, expr: Expr) -> Expr:
        if not expr.has(self.variable):
            return sp.Integer(0)
        if expr == self.variable:
            return expr - self.start
        if expr.is_Add:
            return sp.Add(*map(self.of, expr.args))
        if expr.is_Mul:
            first, rest = expr.as_two_terms()
            return self.of(first) * rest + self.low(first) * self.of(rest)
        if expr.is_Pow:
            return self.of_power(expr.base, expr.exp)
        low, known = self.low(expr), row(expr)
        if known is None or known.gain is None:
            return expr - low
        (part,) = expr.args
        return known.gain(part, self.low(part), self.of(part))

    def of_power(self, base: Expr, exponent: Expr) -> Expr:
        if exponent.has(self.variable):
            power = exponent * sp.log(base)
            return sp.exp(self.low(power)) * expm1(self.of(power))
        low, rise = self.low(base), self.of(base)
        if low == 0:
            return base**exponent - self.low(base**exponent)
        if exponent.is_Integer and abs(exponent) <= _LONGEST:
            number = abs(int(exponent))
            terms = sp.Add(*(base**i * low ** (number - 1 - i) for i in range(number)))
            return rise * terms if exponent > 0 else -rise * terms / (base**number * low**number)
        return low**exponent * expm1(exponent * log1p(rise / low))

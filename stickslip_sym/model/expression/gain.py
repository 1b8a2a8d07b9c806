"""What an expression gains from one slip speed to another, with all its digits.

Where the belt hardly moves, mu(v) and mu(0+) agree to most of their digits, and their difference is what drives
the mass. Identities such as exp(a) - exp(b) = exp(b) expm1(a - b) say it as products, which lose none.
Each is in the table of functions.
"""

import sympy as sp
from sympy.codegen.cfunctions import expm1, log1p

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import fold, row

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

    def gained(node: Expr, parts: list[tuple[Expr, Expr]]) -> tuple[Expr, Expr]:
        """Return the value of a node at the start, and its gain, from those of its arguments."""
        if not node.has(variable):
            return node, sp.S.Zero
        if node == variable:
            return start, node - start
        low = node.subs(variable, start)
        if low.has(sp.nan, sp.zoo, sp.oo, -sp.oo):
            raise _NoValue
        if node.is_Add:
            return low, sp.Add(*(rise for _, rise in parts))
        if node.is_Mul:
            rises = [
                sp.Mul(*(before for before, _ in parts[:i]), rise, *node.args[i + 1 :])
                for i, (_, rise) in enumerate(parts)
            ]
            return low, sp.Add(*rises)
        if node.is_Pow and len(parts) == 2:
            return low, _of_power(node, low, *parts)
        known = row(node)
        if known is None or known.gain is None:
            return low, node - low
        ((before, rise),) = parts
        return low, known.gain(node.exp if node.is_Pow else node.args[0], before, rise)

    try:
        return fold(expr, gained)[1]
    except _NoValue:
        return None


class _NoValue(Exception):
    """A part has no finite value at the start."""


def _of_power(node: Expr, low: Expr, base: tuple[Expr, Expr], exponent: tuple[Expr, Expr]) -> Expr:
    """Return the gain of a power from its value at the start, and the values and gains of its two parts."""
    (base_low, base_rise), (power, power_rise) = base, exponent
    if power_rise != 0 and base_low == 0:
        raise _NoValue
    if power_rise != 0:  # that of p log(b) is (p_0 + rise of p) (rise of log b) + (rise of p) log(b_0)
        logarithm = log1p(base_rise / base_low)
        return low * expm1(node.exp * logarithm + power_rise * sp.log(base_low))
    if base_low == 0:
        return node - low
    if power.is_Integer and abs(power) <= _LONGEST:
        count = abs(int(power))
        terms = sp.Add(*(node.base**i * base_low ** (count - 1 - i) for i in range(count)))
        return base_rise * terms if power > 0 else -base_rise * terms / (node.base**count * base_low**count)
    return low * expm1(power * log1p(base_rise / base_low))

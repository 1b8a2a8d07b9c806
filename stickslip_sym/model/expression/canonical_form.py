"""One normal form for formulas that mean the same, so that what is known of one spelling is known of all.

Every rule is an identity for real v >= 0 and positive parameters. Closed forms are known for the right sides.
"""

from collections.abc import Callable
from functools import reduce
from operator import mul

import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import fold, power, write_sech
from stickslip_sym.core.special import Langevin
from stickslip_sym.model.expression.pieces import join_kinks

HIGHEST_POWER_OF_V = 24
"""That a law may have and a rule makes; zeros of polynomials of a higher degree, which take milliseconds, are not
computed."""
HIGHEST_POWER_OF_SUM = 16
"""That a law may have, and that is multiplied out."""
_ANY = sp.Wild("x")
_RECIPROCALS: dict[type[Expr], type[Expr]] = {sp.cosh: sp.sech, sp.tanh: sp.coth}
_OF_LOGARITHMS: dict[type[Expr], Callable[[Expr], Expr]] = {
    sp.tanh: lambda x: (x**2 - 1) / (x**2 + 1), sp.sech: lambda x: 2 * x / (x**2 + 1),
    sp.sinh: lambda x: (x - 1 / x) / 2, sp.cosh: lambda x: (x + 1 / x) / 2,
}  # fmt: skip
"""Hyperbolic functions of log(x)."""


def canonical_form(expr: Expr) -> Expr:
    """Return an expression of the same value, in one spelling.

    - ``1/cosh(x)`` is sech(x), 1 - tanh(x)^2 is sech(x)^2, and ``1/(exp(x) + exp(-x))`` sech(x)/2.
    - ``1/(b + a*exp(x))`` is (1 - tanh(y/2))/(2 b) with y = x + log(a/b).
    - ``a^x`` is exp(x*log(a)), and exp(p*log(x)) is x^p.
    - ``1/(a*exp(x) - b)`` is exp(-x)/(a - b exp(-x)).
    - A product of an exponential and hyperbolic functions is a sum of exponentials.
    - tanh(log(x)) is (x^2 - 1)/(x^2 + 1), and log(b + a/v^p) a difference of logarithms without the quotient.
    - ``1/(5*v + 5)`` is (1/5)/(v + 1).
    - sin(x)^2 + cos(x)^2, and cosh(x)^2 - sinh(x)^2, is 1.
    - log(b + a*exp(x)), x growing, is x plus a logarithm that falls.
    - coth(x) - 1/x is Langevin's function, one node.
    - No two kinks stand in one term.
    """
    return join_kinks(write_sech(fold(expr, _rebuilt)))


def _rebuilt(node: Expr, parts: list[Expr]) -> Expr:
    """Return a node of normal arguments in its normal form."""
    if not parts or not node.has(symbols.v) or isinstance(node, sp.core.relational.Relational):
        return node
    if isinstance(node, sp.Piecewise):
        return node.func(*zip(parts[::2], parts[1::2], strict=True))
    if node.is_Pow and len(parts) == 2:
        return _rewrite_power(*parts)
    if isinstance(node, sp.exp):
        return _exponential(*parts)
    made = node.func(*parts)
    if isinstance(made, sp.log):
        return _logarithm_of_sum(made)
    if made.func in _OF_LOGARITHMS:
        return _rational_of_power(made)
    if made.is_Mul:
        return _product(made)
    if made.is_Add:
        made = _sum_squares(made)
    if made.is_Add and made.has(sp.coth):
        return _write_langevin(made)
    return made


def _sum_squares(expr: Expr) -> Expr:
    """Write a sin(x)^2 + a cos(x)^2, and a cosh(x)^2 - a sinh(x)^2, as a."""
    for squared, other, sign in ((sp.sin, sp.cos, 1), (sp.sinh, sp.cosh, -1)):
        for node in expr.atoms(squared):
            x = node.args[0]
            front = expr.coeff(squared(x) ** 2)
            if front != 0 and expr.is_Add and expr.coeff(other(x) ** 2) == sign * front:
                expr = sp.expand_mul(expr - front * squared(x) ** 2 - sign * front * other(x) ** 2) + sign * front
    return expr


def _rewrite_power(base: Expr, exponent: Expr) -> Expr:
    if exponent.has(symbols.v):
        if base.is_positive and not base.has(symbols.v):
            return sp.exp(exponent * sp.log(base))
        return base**exponent
    if base.func in _RECIPROCALS and exponent.is_negative:
        base = _RECIPROCALS[base.func](base.args[0])
        exponent = -exponent
    if base.is_Add and exponent.is_Integer and exponent < 0:
        if exponent >= -HIGHEST_POWER_OF_SUM and (reciprocal := _reciprocal_of_exponentials(base)) is not None:
            return reduce(lambda a, b: sp.expand(a * b), [reciprocal] * int(-exponent))
        if (falling := _write_by_falling_exponential(base)) is not None:
            return power(falling[1], exponent) * sp.exp(exponent * falling[0].args[0])
        whole = sp.Integer(base.primitive()[0].p)
        if whole != 1:  # SymPy keeps 1/(5*(v + 1)), but takes 5*(v + 1) for 5*v + 5
            return whole**exponent * sp.Add(*(term / whole for term in base.args)) ** exponent
    return power(base, exponent)


def _reciprocal_of_exponentials(base: Expr) -> Expr | None:
    """Return 1/(a exp(x) + b exp(y)), b and y perhaps without v, by a hyperbolic function; None for other sums."""
    terms = [term.as_independent(sp.exp, as_Add=False) for term in base.args]
    if len(terms) != 2 or any(
        front.has(symbols.v) or not front.is_positive or not (rest == 1 or isinstance(rest, sp.exp))
        for front, rest in terms
    ):
        return None
    (a, x), (b, y) = ((front, sp.log(rest) if rest == 1 else rest.args[0]) for front, rest in terms)
    if a == b and x + y == 0:
        return sp.sech(x) / (2 * a)
    if x == 0:
        (a, x), (b, y) = (b, y), (a, x)
    if y == 0:
        return (1 - sp.tanh((x + sp.log(a / b)) / 2)) / (2 * b)
    return None


def _write_by_falling_exponential(base: Expr) -> tuple[Expr, Expr] | None:
    """Return a exp(x) - b, x growing with v, as exp(x) and a - b exp(-x), whose balls are small far out."""
    constant, growing = base.as_independent(sp.exp, as_Add=True)
    front, rest = growing.as_independent(sp.exp, as_Add=False)
    if not isinstance(rest, sp.exp) or front.has(symbols.v) or constant.has(symbols.v) or constant == 0:
        return None
    rate = sp.diff(rest.args[0], symbols.v)
    if not (rate.is_positive and not rate.has(symbols.v) and (constant * front).is_negative):
        return None
    return rest, front + constant * sp.exp(-rest.args[0])


def _exponential(argument: Expr) -> Expr:
    """Return exp(...) with the logarithms in its argument taken as powers."""
    factors = []
    rest = []
    for term in sp.Add.make_args(sp.expand_mul(argument)):
        front, logarithm = term.as_independent(sp.log, as_Add=False)
        if isinstance(logarithm, sp.log) and logarithm.has(symbols.v) and not front.has(symbols.v):
            factors.append(power(logarithm.args[0], front))
        else:
            rest.append(term)
    if factors:
        return sp.Mul(*factors, sp.exp(sp.Add(*rest)))
    return sp.exp(argument)


def _logarithm_of_sum(expr: Expr) -> Expr:
    """Return log(b + a/v^p) as log(1 + b v^p/a) - log(v^p) + log(a), and log(b + a exp(x)) likewise."""
    growing = _growing_exponential(expr.args[0])
    if growing is not None:
        b, a, x = growing
        return x + sp.log(1 + b / a * sp.exp(-x)) + sp.log(a)
    offset, rest = expr.args[0].as_independent(symbols.v, as_Add=True)
    front, base_power = rest.as_independent(symbols.v, as_Add=False)
    base, exponent = base_power.as_base_exp()
    if base != symbols.v or not exponent.is_negative or not front.is_positive or not offset.is_nonnegative:
        return expr
    inverse = power(symbols.v, -exponent) / front
    return sp.log(1 + offset * inverse) + exponent * sp.log(symbols.v) + sp.log(front)


def _growing_exponential(expr: Expr) -> tuple[Expr, Expr, Expr] | None:
    """Return b, a and x of b + a exp(x), where x grows with v and both are positive; None for anything else."""
    b, rest = expr.as_independent(symbols.v, as_Add=True)
    a, exponential = rest.as_independent(symbols.v, as_Add=False)
    if not isinstance(exponential, sp.exp) or not (a.is_positive and b.is_positive):
        return None
    rate = sp.diff(exponential.exp, symbols.v)
    if rate.is_positive and not rate.has(symbols.v):
        return (b, a, exponential.exp)
    return None


def _rational_of_power(expr: Expr) -> Expr:
    """Return a hyperbolic function of c*log(x) as a rational one of x^c, unless no computer could expand that."""
    front, logarithm = expr.args[0].as_independent(sp.log, as_Add=False)
    if not isinstance(logarithm, sp.log) or front.has(symbols.v):
        return expr
    if front.is_number and abs(front) > HIGHEST_POWER_OF_V:
        return expr
    return _OF_LOGARITHMS[expr.func](power(logarithm.args[0], front))


def _write_langevin(expr: Expr) -> Expr:
    """Return a sum with a L(x), L Langevin's function, which is finite at 0, for a coth(x) - a/x."""
    for node in expr.atoms(sp.coth):
        front = expr.coeff(node)
        x = node.args[0]
        if front != 0 and -front / x in expr.args:
            expr += front * Langevin(x, 0) - front * node + front / x
    return expr


def _product(expr: Expr) -> Expr:
    """Return a product of an exponential and hyperbolic sines and cosines as a sum of exponentials.

    One of an exponential and 1 - erf(x) holds erfc(x), which keeps its digits where the exponential grows.
    """
    if expr.has(sp.erf) and any(isinstance(factor, sp.exp) for factor in expr.args):
        expr = expr.replace(1 - sp.erf(_ANY), sp.erfc(_ANY))
    moving = [factor for factor in expr.args if factor.has(symbols.v)]
    waves = [factor for factor in moving if factor.has(sp.sinh, sp.cosh)]
    decays = [factor for factor in moving if isinstance(factor, sp.exp)]
    if not decays or not waves or any(not isinstance(factor, sp.sinh | sp.cosh) for factor in waves):
        return expr
    others = sp.Mul(*(factor for factor in expr.args if factor not in (*waves, *decays)))
    total = sp.expand(reduce(mul, [*decays, *(wave.rewrite(sp.exp) for wave in waves)]))
    terms = [sp.powsimp(term, combine="exp") for term in sp.Add.make_args(total)]
    return sp.Add(*(others * term.replace(sp.exp, lambda x: sp.exp(sp.factor_terms(x))) for term in terms))

"""The shape in which a result is printed."""

from collections import defaultdict
from functools import lru_cache

import sympy as sp
from flint import Ordering, fmpz_mpoly_ctx

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.proof.normal_form import plain

_MOST_FACTORED_OPERATIONS = 1500  # operations of an expression that is still factored


def tidy(expr: Expr, model: Expr, small: Expr) -> Expr:
    """Rewrite a result as a person would print it.

    The common factors come out, what multiplies a function is collected and factored, and each factor has the
    sign that it has in `model` (the formula of the law), or that is positive for a small value of the symbol
    `small`.
    """
    expr = plain(expr)
    # To algebra every function is a symbol: SymPy would otherwise take exp(-x/3) and exp(-1000 x) for powers of
    # one generator, of a degree that nothing survives.
    functions: dict[Expr, Expr] = {}
    walk = sp.preorder_traversal(expr)
    for node in walk:
        if isinstance(node, sp.Function | sp.Min | sp.Max):
            # Each a name of its own: the order of variables decides how long factoring takes.
            functions.setdefault(node, sp.Dummy(f"f{len(functions)}", real=True))
            walk.skip()
    opaque = expr.xreplace(functions)
    if opaque.count_ops() > _MOST_FACTORED_OPERATIONS:
        return expr
    order = [functions[node] for node in sorted(functions, key=sp.default_sort_key)]
    shapes = (
        _tidy_factors(opaque, order, model, small),
        sp.Add(*[_tidy_factors(term, order, model, small) for term in sp.Add.make_args(opaque)]),
    )
    chosen = min(shapes, key=lambda shape: int(shape.count_ops()))
    return chosen.xreplace({symbol: node for node, symbol in functions.items()})


def _tidy_factors(expr: Expr, functions: list[Expr], model: Expr, small: Expr) -> Expr:
    factors = []
    for factor in sp.Mul.make_args(sp.Mul(*map(_rooted, sp.Mul.make_args(factored(expr))))):
        sign = 1
        if factor.is_Add and _should_flip(factor, model, small):
            sign = -1
        factor *= sign
        if factor.is_Add and factor.has(*functions):
            factor = sp.collect(factor, functions, factored)
        factors += [sign, factor]
    return sp.Mul(*factors)


def _rooted(factor: Expr) -> Expr:
    """Bring out the roots that all terms of a sum share, which to factoring are no common factor."""
    total, exponent = factor.as_base_exp()
    if not total.is_Add or not exponent.is_Integer:
        return factor
    powers = [term.as_powers_dict() for term in total.args]
    shared = {base: [power[base] for power in powers] for base in set(powers[0]).intersection(*powers[1:])}
    common = sp.Mul(*[
        base ** min(exponents)
        for base, exponents in shared.items()
        if not base.is_number and all(power.is_Rational and power > 0 for power in exponents)
    ])  # fmt: skip
    return common**exponent * sp.Add(*[term / common for term in total.args]) ** exponent


@lru_cache(maxsize=128, typed=True)
def factored(expr: Expr) -> Expr:
    """Factor as SymPy does, sums by FLINT, which takes no longer for some of them than for others."""
    number = sp.S.One
    powers = defaultdict[Expr, Expr](lambda: sp.S.Zero)
    for part in sp.Mul.make_args(sp.together(expr)):
        base, exponent = part.as_base_exp()
        if base.is_Add and (constant := sp.expand(base)).is_number:  # as (V - 1) (V + 1) - V^2
            part = constant**exponent
            base = constant
        polynomial = sp.Poly(base) if base.is_Add and exponent.is_Integer else None
        if polynomial is None or not (polynomial.domain.is_ZZ or polynomial.domain.is_QQ):
            coefficient, rest = sp.factor(part).as_coeff_Mul(rational=True)
            pairs = [rest.as_base_exp() if base.is_Add else (rest, sp.S.One)]
        else:
            content, factors = _flint_factors(polynomial)
            coefficient = content**exponent
            pairs = [(factor, k * exponent) for factor, k in factors]
        number *= coefficient
        for factor, power in pairs:
            powers[factor] += power
    product = sp.Mul(*[factor**power for factor, power in powers.items()])
    return sp.Mul(number, product, evaluate=not product.is_Add or abs(number) == 1)


def _flint_factors(polynomial: sp.Poly) -> tuple[Expr, list[tuple[Expr, int]]]:
    """Return the content of a polynomial over the rationals, and its factors, each with its power."""
    denominator, whole = polynomial.clear_denoms(convert=True)
    context = fmpz_mpoly_ctx.get([f"x{i}" for i in range(len(whole.gens))], Ordering.lex)
    content, factors = context.from_dict({powers: int(c) for powers, c in whole.terms()}).factor()
    pairs = []
    for factor, power in factors:
        terms = {tuple(map(int, powers)): int(c) for powers, c in factor.to_dict().items()}
        pairs.append((sp.Poly(terms, *whole.gens).as_expr(), int(power)))
    return int(content) / denominator, pairs


def _should_flip(factor: Expr, model: Expr, small: Expr) -> bool:
    for total in model.atoms(sp.Add):
        primitive = total.primitive()[1]
        if primitive in (factor, -factor):
            return primitive == -factor
    leading = factor.subs(small, 0)
    if leading.is_negative or leading.is_positive:
        return bool(leading.is_negative)
    # Its sign is not known, or it vanishes because its terms cancel: let the fewer ones carry a minus.
    signs = [term.could_extract_minus_sign() for term in sp.Add.make_args(sp.expand(factor))]
    return bool(2 * sum(signs) > len(signs))

"""The normal form in which equal expressions become the same expression."""

import sympy as sp
from sympy.functions.elementary.hyperbolic import HyperbolicFunction

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.functions import elementary
from stickslip_sym.model.expression.canonical_form import HIGHEST_POWER_OF_SUM
from stickslip_sym.model.terms import expand_above

_BOUND = sp.Dummy("xi", real=True)  # the variable of every integral in normal form


def single_limit(integral: sp.Integral) -> tuple[Expr, Expr, Expr]:
    """Return the variable and the limits of a definite integral over one variable."""
    if len(integral.limits) != 1 or len(integral.limits[0]) != 3:
        raise ValueError(f"{integral} is not a definite integral over one variable")
    variable, low, high = integral.limits[0]
    return variable, low, high


def normal_form(expr: Expr) -> Expr:
    """Reduce an expression so that zero becomes 0.

    Integrals are split by linearity, and done where their integrand is a polynomial. Hyperbolic
    functions become exponentials, and so do sines and cosines where something is left; polylogarithms of order 1
    become elementary, of contiguous hypergeometric functions one is left, and radicands
    are factored. What is left is put over one denominator, and its numerator expanded: a polynomial in symbols,
    in functions that are algebraically independent, and in integrals of unknown functions.
    """
    check_time()
    expr = plain(elementary(sp.sympify(expr)).replace(lambda node: isinstance(node, sp.Integral), _split))
    # Which argument a Min, Max or Piecewise takes does not matter to an identity that holds for all numbers.
    pieces = sorted(expr.atoms(sp.Min, sp.Max, sp.Piecewise), key=sp.default_sort_key)
    expr = expr.xreplace({node: _opaque(node) for node in pieces})
    # Im Li_1(i y) is the arctangent of y.
    expr = expr.replace(
        lambda node: isinstance(node, sp.im) and _is_logarithm(node.args[0]),
        lambda node: sp.atan(node.args[0].args[1] / sp.I),
    )
    expr = expr.replace(_is_logarithm, lambda node: -sp.log(1 - node.args[1]))
    expr = expr.replace(sp.log, _logarithm_of_factors)
    expr = expr.replace(
        lambda node: node.is_Pow and node.exp.is_Rational and not node.exp.is_Integer,
        lambda node: sp.factor(node.base) ** node.exp,
    )
    expr = expr.replace(
        lambda node: node.is_Pow and node.base.is_Add and not node.exp.is_number, _power_of_primitive
    )
    expr = _contiguous(expr)
    check_time()
    numerator = _numerator(expr.rewrite(HyperbolicFunction, sp.exp))
    if numerator != 0 and numerator.has(sp.sin, sp.cos):
        return _numerator(expr.rewrite([HyperbolicFunction, sp.sin, sp.cos], sp.exp))
    return numerator


def _numerator(expr: Expr) -> Expr:
    numerator, _ = sp.fraction(sp.together(_exponentials_as_symbols(expr)))
    check_time()
    expanded = sp.expand(numerator)
    check_time()
    return sp.expand(sp.powsimp(expanded))


def is_integral_of_binomial(node: Expr) -> bool:
    """Whether a node is 2F1(-p, e; 1 + e; z), by which u^(q - 1) (b + a u^d)^p is integrated, e = q/d."""
    if not isinstance(node, sp.hyper) or (len(node.ap), len(node.bq)) != (2, 1):
        return False
    return any(sp.expand(node.bq[0] - e) == 1 for e in node.ap)


def _contiguous(expr: Expr) -> Expr:
    """Write what differentiating F = 2F1(-p, e; 1 + e; z) leaves by F itself: z F' = e ((1 - z)^p - F)."""
    functions = {node for node in expr.atoms(sp.hyper) if is_integral_of_binomial(node)}
    replaced = {}
    for node in functions:
        lower = next((F for F in functions if F.argument == node.argument and _is_shifted(node, F)), None)
        if lower is None:
            continue
        (w,) = lower.bq
        z = node.argument
        if sp.expand(w - lower.ap[0]) == 1:
            minus_p = lower.ap[1]
        else:
            minus_p = lower.ap[0]
        # F' = -p e/(1 + e) times the node.
        replaced[node] = w / minus_p * ((1 - z) ** -minus_p - lower) / z
    return expr.xreplace(replaced)


def _is_shifted(node: sp.hyper, lower: sp.hyper) -> bool:
    """Whether the parameters of a node are those of another function, each one higher."""
    (x, y) = node.ap
    (w,) = node.bq
    (a, b) = lower.ap
    (c,) = lower.bq
    shifts = [{sp.expand(w - c), sp.expand(x - s), sp.expand(y - t)} for s, t in ((a, b), (b, a))]
    return {1} in shifts


def _power_of_primitive(node: Expr) -> Expr:
    """Return (p/q b)^s, b a sum of whole multiples, as p^s q^(-s) b^s."""
    base, exponent = node.args
    content, primitive = base.primitive()
    return sp.Integer(content.p) ** exponent * sp.Integer(content.q) ** -exponent * primitive**exponent


def _logarithm_of_factors(argument: Expr) -> Expr:
    """Return log(a u^p), u > 0 a symbol, as log(a) + p log(u)."""
    powers = {base: p for base, p in argument.as_powers_dict().items() if base.is_Symbol and base.is_nonnegative}
    rest = argument / sp.Mul(*(base**p for base, p in powers.items()))
    return sp.Add(sp.log(rest), *(p * sp.log(base) for base, p in powers.items()))


def _is_logarithm(node: Expr) -> bool:
    return isinstance(node, sp.polylog) and node.args[0] == 1


def plain(expr: Expr) -> Expr:
    """Write special functions as a reader knows them, and bring positive factors out of every Min and Max.

    Dirichlet's eta of a number is written by Riemann's zeta, a hypergeometric function that is elementary by what
    it is, and the argument of any other in lowest terms.
    """
    expr = expr.replace(lambda node: isinstance(node, sp.hyper), _elementary_hypergeometric)
    expr = expr.replace(
        sp.dirichlet_eta, lambda order: sp.log(2) if order == 1 else (1 - 2 ** (1 - order)) * sp.zeta(order)
    )
    return expr.replace(lambda node: isinstance(node, sp.Min | sp.Max), _factor_out_of_extremum)


def _elementary_hypergeometric(node: sp.hyper) -> Expr:
    """Return a hypergeometric function elementarily where it is elementary, its argument in lowest terms."""
    z = node.argument
    if z.is_rational_function() and not z.is_number:
        z = sp.factor(z)
    if len(node.ap) == 1 and not node.bq:
        return (1 - z) ** -node.ap[0]
    if is_arctangent(node) and z.is_positive:
        return sp.atanh(sp.sqrt(z)) / sp.sqrt(z)
    if is_arctangent(node) and z.is_negative:
        return sp.atan(sp.sqrt(-z)) / sp.sqrt(-z)
    if is_integral_of_binomial(node):
        e = node.bq[0] - 1
        p = sp.Add(*node.ap) - node.bq[0] + 1
        if e.is_Integer and 0 < e <= HIGHEST_POWER_OF_SUM and p.is_Rational and not p.is_Integer:
            return _hypergeometric_of_whole_order(int(e), p, z)
    return sp.hyper(node.ap, node.bq, z)


def _hypergeometric_of_whole_order(e: int, p: Expr, z: Expr) -> Expr:
    """Return 2F1(p, e; e + 1; z) = e z^(-e) integral_0^z t^(e-1) (1 - t)^(-p) dt by powers of 1 - t."""
    powers = [sp.binomial(e - 1, k) * (-1) ** k * ((1 - z) ** (k + 1 - p) - 1) / (p - k - 1) for k in range(e)]
    return e * z**-e * sp.Add(*powers)


def is_arctangent(node: Expr) -> bool:
    """Whether a node is 2F1(1/2, 1; 3/2; z), artanh(x)/x with x^2 = z, for z < 0 arctan(x)/x with x^2 = -z."""
    half = sp.Rational(1, 2)
    return isinstance(node, sp.hyper) and set(node.ap) == {half, sp.S.One} and set(node.bq) == {3 * half}


def arguments_of_arctangents(expr: Expr) -> list[Expr]:
    """Return the arguments z of all 2F1(1/2, 1; 3/2; z) in a formula, whose signs are not known."""
    return sorted({node.argument for node in expr.atoms(sp.hyper) if is_arctangent(node)}, key=sp.default_sort_key)


def factor_of_sign(expr: Expr) -> Expr:
    """Return the product of the factors that decide the sign of a rational function, multiplied out."""
    number, factors = sp.factor_list(sp.numer(sp.together(expr)) * sp.denom(sp.together(expr)))
    odd = [factor for factor, power in factors if power % 2 and not factor.is_positive]
    return sp.sign(number) * sp.expand(sp.Mul(*odd))


def _factor_out_of_extremum(node: Expr) -> Expr:
    """Bring a positive factor out of a Min or a Max: Min(2 V/w, p/w) is Min(2 V, p)/w."""
    denominators = {sp.denom(argument) for argument in node.args if not argument.is_number}
    unit = sp.Mul(*denominators) if len(denominators) == 1 else sp.Integer(1)
    if unit == 1 or not unit.is_positive:
        return node
    return node.func(*[argument * unit for argument in node.args]) / unit


def _exponentials_as_symbols(expr: Expr) -> Expr:
    """Give each exponential a symbol of its own, where none stands in a denominator.

    Expanding merges the exponentials of every product first, so no relation between them is lost. To SymPy
    exp(-x/3) and exp(-1000 x) are powers of one generator, of a degree that nothing survives.
    """
    below = [node for node in expr.atoms(sp.Pow) if not (node.exp.is_Integer and node.exp > 0)]
    if not expr.has(sp.exp) or any(node.has(sp.exp) for node in below):
        return expr
    # Sums under a fraction bar stay whole: multiplied out, they would take the exponentials along.
    whole = {node: sp.Dummy() for node in below if node.base.is_Add}
    expr = sp.expand(expr.xreplace(whole)).xreplace({symbol: node for node, symbol in whole.items()})
    return expr.xreplace({node: sp.Dummy(positive=True) for node in expr.atoms(sp.exp)})


def _opaque(node: Expr) -> Expr:
    return sp.Symbol(f"[{sp.srepr(node)}]", nonnegative=node.is_nonnegative, positive=node.is_positive)


def _split(integral: sp.Integral) -> Expr:
    """Split an integral over its sum, do the polynomial parts, and give the others one notation.

    That is: limits from low to high, and one name for the variable of integration.
    """
    variable, low, high = single_limit(integral)
    low = sp.expand(low)
    high = sp.expand(high)
    sign = 1
    if sp.default_sort_key(low) > sp.default_sort_key(high):
        low, high, sign = high, low, -1
    total = sp.S.Zero
    for term in sp.Add.make_args(expand_above(integral.function.subs(variable, _BOUND))):
        constant, rest = term.as_independent(_BOUND, as_Add=False)
        part = sp.Integral(rest, (_BOUND, low, high))
        total += sign * constant * (part.doit() if rest.is_polynomial(_BOUND) else part)
    return total

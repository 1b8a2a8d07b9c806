"""Averages proved: both sides satisfy one differential equation and agree in their first coefficients.

For g(u) = sum g_n u^n near 0 the average is the power series V F(V) = -sum b_n g_n V^n, b_n = n <(1 + s)^(n-1)>,
and b_(n+1)/b_n is a rational function of n for every weight here; for the harmonic one it is
(n + 1)(2 n + 1)/(n (n + 2)). A linear differential equation of g with polynomial coefficients is a
recurrence of the g_n; so b_n g_n has one, which as a differential equation in V the closed form must satisfy. Two
power series that do, and agree in all coefficients that the recurrence does not fix, are equal; and two functions
analytic for V > 0 that agree near 0 agree for every V > 0.
"""

from dataclasses import dataclass

import sympy as sp
from sympy.polys.polyerrors import BasePolynomialError

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.core.functions import is_analytic
from stickslip_sym.core.symbols import V
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.proof.differential import Algebra, Differential
from stickslip_sym.formula.proof.expansions import Expansion, Series
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.formula.proof.theorems import is_positive, is_smooth
from stickslip_sym.model.terms import split_polynomial
from stickslip_sym.output import printing

__all__ = ["AVERAGES_AGREE", "AverageSeries", "definition", "prove_average"]

_SPARE = (2, 6, 14)  # terms of a series beyond those that are compared, for those that cancel


AVERAGES_AGREE = (
    "both sides satisfy one linear differential equation in V, begin with the same coefficients at V = 0, and are "
    "analytic for V > 0"
)
"""The theorem in words, for a step that it proves."""


@dataclass(frozen=True)
class AverageSeries:
    """Evaluate the average of `constant` g(v) under a criterion as `constant` times `value`.

    Attributes
    ----------
    term : sympy.Expr
        g, analytic for v >= 0, or under the harmonic weight a power of v.
    criterion : Criterion
    constant : sympy.Expr
    value : sympy.Expr
        The proposed average of g.
    """

    term: Expr
    criterion: Criterion
    constant: Expr
    value: Expr

    def __call__(self, expr: Expr) -> Expr:
        """Apply the theorem, after checking every hypothesis of it."""
        expected = definition(self.constant * self.term, self.criterion)
        if expr != expected and normal_form(expr - expected) != 0:
            raise ValueError("the integral is not the average of the term")
        try:
            prove_average(self.term, self.value, self.criterion)
        except (BasePolynomialError, NotImplementedError) as failure:
            raise ValueError(f"SymPy cannot compute with the term: {type(failure).__name__}") from None
        return self.constant * self.value


def definition(mu: Expr, criterion: Criterion) -> Expr:
    """Return -<mu'(V(1 + s))>_w as an integral of mu itself.

    Raises
    ------
    NoClosedForm
        If mu has no value at v = 0, where the weight is not 0.
    """
    v, theta = symbols.v, symbols.theta
    if not criterion.is_polynomial:
        return sp.Integral(mu.subs(v, V * (1 - sp.cos(theta))) * criterion.angle_kernel, (theta, 0, sp.pi))
    boundary = criterion.boundary(mu)
    if boundary.has(sp.zoo, sp.oo, sp.nan):
        raise NoClosedForm(
            f"the weight of {criterion.name!r} is not 0 at s = -1, where {printing.text(mu)} has no value"
        )
    return sp.Integral(mu * criterion.kernel, (v, 0, 2 * V)) + boundary


def prove_average(term: Expr, value: Expr, criterion: Criterion) -> None:
    """Prove that `value` is the average of a term, or raise ValueError and say which hypothesis fails."""
    u = symbols.v
    if term.is_Pow and term.base == u and not term.exp.is_Integer:
        _require_moment(term.exp, value, criterion)
        return
    # Bessel functions of higher orders by their recurrence, J_(k+1) = 2 k J_k/z - J_(k-1).
    value = value.replace(lambda node: isinstance(node, sp.besselj), sp.expand_func)
    parameters = sorted((term.free_symbols | value.free_symbols) - {u, V}, key=str)
    recurrence, start = _recurrence(term, u)
    n = sp.Dummy("n")
    weighted, common = _weighted(recurrence, criterion, n)
    first = _fixed_from(weighted[-1] * common, n, start)
    algebra = Algebra(V, [*parameters, sp.pi])
    count = first + len(weighted) - 1  # coefficients that the recurrence does not fix
    _require_real_analytic(value, V)
    _require_same_start(algebra, term, value, criterion, count)
    _require_equation(Differential(algebra).of(V * value), algebra, weighted, n, count)


def _require_moment(p: Expr, value: Expr, criterion: Criterion) -> None:
    """Compare the harmonic average of v^p, -p (2 V)^(p-1) B_(p-1), p > -1/2, with the Beta integral."""
    half = sp.Rational(1, 2)
    if criterion.is_polynomial or not (p + half).is_positive:
        raise ValueError(f"v^({p}) is not integrable with the weight of the criterion")
    moment = 2 * sp.gamma(p + half) / (sp.gamma(p + 2) * sp.gamma(3 * half))
    if sp.gammasimp(sp.powsimp(value / (V ** (p - 1) * moment) / (-p * 2 ** (p - 1)))) != 1:
        raise ValueError("the value is not known to be the Beta integral")


def _recurrence(term: Expr, u: Expr) -> tuple[list[Expr], int]:
    """Return p_k with sum_k p_k(n) g_(n+k) = 0 for n >= start, each a function of n."""
    if term.is_polynomial(u):
        return [lambda n: sp.Integer(1)], int(sp.degree(term, u)) + 1 if term.has(u) else 1
    if term.is_rational_function(u):
        above, below = (sp.Poly(part, u) for part in sp.fraction(sp.cancel(term)))
        if below.nth(0) == 0:
            raise ValueError(f"{term} is not known to be finite at {u} = 0")
        _require_no_zero(below.as_expr(), u)
        coefficients = below.all_coeffs()  # sum_k below_(d-k) g_(n+k)
        return [lambda n, c=c: c for c in coefficients], max(above.degree() - below.degree() + 1, 0)
    polynomial, others = split_polynomial(term, u)
    shift, f = sp.degree(polynomial, u) if polynomial.has(u) else 0, sp.Mul(*others)
    if sp.Poly(polynomial, u).length() != 1:
        raise ValueError(f"{polynomial} is not one power")
    if not is_smooth(f, u):
        raise ValueError(f"{f} is not known to be smooth for {u} >= 0")
    equation = _equation(f, u)
    _require_no_zero(equation[-1].as_expr(), u)
    parts: dict[int, list[tuple[Expr, int]]] = {}
    for i, coefficient in enumerate(equation):
        for (m,), c in coefficient.terms():
            if c != 0:
                parts.setdefault(i - m, []).append((c, i))
    low = min(parts)

    def part(k: int) -> Expr:
        """Note that c u^m f^(i) adds c j...(j - i + 1) f_j to that of u^(j - i + m), here j = n - shift + k."""
        terms = parts.get(low + k, [])
        return lambda n: sp.Add(*[c * sp.ff(n - shift + k, i) for c, i in terms])

    return [part(k) for k in range(max(parts) - low + 1)], max(int(shift) + low, int(shift))


def _equation(f: Expr, u: Expr) -> list[Expr]:
    """Return polynomials a_i with sum_i a_i f^(i) = 0."""
    slope = sp.diff(f, u)
    for ratio, orders in (
        (slope / f, (0, 1)),
        (sp.diff(slope, u) / slope, (1, 2)),
        (sp.diff(slope, u) / f, (0, 2)),
    ):
        ratio = sp.cancel(sp.powsimp(ratio)) if ratio.has(u) else ratio
        if ratio.is_rational_function(u):
            above, below = (sp.Poly(part, u) for part in sp.fraction(sp.cancel(sp.together(ratio))))
            equation = [sp.Poly(0, u)] * (orders[1] + 1)
            equation[orders[0]], equation[orders[1]] = -above, below
            return equation
    raise ValueError(f"no differential equation of {f} is known here")


def _require_no_zero(polynomial: Expr, u: Expr) -> None:
    """Refuse a leading coefficient that may vanish for u > 0; at 0 the series says that all is analytic."""
    for factor, _ in sp.factor_list(polynomial, u)[1]:
        if factor != u and not (is_positive(factor, u) or is_positive(-factor, u)):
            raise ValueError(f"{factor} is not known to have no zero for {u} >= 0")


def _weighted(recurrence: list[Expr], criterion: Criterion, n: Expr) -> tuple[list[Expr], Expr]:
    """Return q_k with sum_k q_k(n) b_(n+k) g_(n+k) = 0, polynomials in n, and what was divided out of them."""
    r = len(recurrence) - 1
    above, below = _ratio(criterion, n)
    terms = []
    for k, p in enumerate(recurrence):
        factors = [below.subs(n, n + i) if i < k else above.subs(n, n + i) for i in range(r)]
        terms.append(p(n) * sp.prod(factors))
    fractions = [sp.fraction(sp.cancel(term)) for term in terms]
    below = sp.lcm_list([q for _, q in fractions]) if r else fractions[0][1]
    whole = [sp.Poly(sp.cancel(p * below / q), n) for p, q in fractions]
    common = whole[0]
    for q in whole[1:]:
        common = sp.gcd(common, q)
    return [sp.Poly(sp.cancel(q.as_expr() / common.as_expr()), n) for q in whole], common


def _ratio(criterion: Criterion, n: Expr) -> tuple[Expr, Expr]:
    """Return b_(n+1)/b_n as a fraction of polynomials in n."""
    if not criterion.is_polynomial:
        return (n + 1) * (2 * n + 1), n * (n + 2)
    moment = sp.Add(*[w * 2**j / (n + j) for (j,), w in criterion.from_rest.terms()])  # <(1 + s)^(n-1)> over 2^n
    above, below = sp.fraction(sp.cancel(2 * (n + 1) * moment.subs(n, n + 1) / (n * moment)))
    return above, below


def _fixed_from(leading: Expr, n: Expr, start: int) -> int:
    """Return the n >= 1 from which the recurrence fixes every coefficient; no root of `leading` comes after."""
    first = max(start, 1)
    constant, factors = sp.factor_list(leading.as_expr(), n)
    for factor, _ in factors:
        polynomial = sp.Poly(factor, n)
        if polynomial.degree() > 1 and polynomial.domain.is_ZZ:
            continue  # it has no rational root, as it does not factor
        if polynomial.degree() > 1:
            raise ValueError(f"the roots of {factor} are not known")
        root = -polynomial.coeff_monomial(1) / polynomial.LC()
        if root.is_Integer:
            first = max(first, int(root) + 1)
        elif not root.is_Rational:
            raise ValueError(f"{factor} may vanish for a whole number {n}")
    if not sp.sympify(constant).is_nonzero:
        raise ValueError(f"{constant} may vanish")
    return first


def _require_real_analytic(expr: Expr, V: Expr, inside: bool = False) -> None:
    """Refuse a formula that may leave the domain on which its functions are analytic.

    Poles do not matter, save inside of a function: where a formula equals a function without poles except at
    isolated places, it has none.
    """
    if not expr.has(V) or expr == V:
        return
    if isinstance(expr, sp.Tuple) or is_analytic(expr):
        fine = True
    elif expr.is_Pow and not expr.exp.has(V):
        free = expr.exp.is_Integer and (expr.exp > 0 or not inside)
        fine = free or _positive(expr.base, V)
    elif isinstance(expr, sp.log):
        fine = _positive(expr.args[0], V)
    elif isinstance(expr, sp.hyper):
        upper, lower, z = expr.args
        fine = len(upper) <= len(lower) or (len(upper) == len(lower) + 1 and _positive(-z, V))
        fine = fine and not any(b.is_integer and b.is_nonpositive for b in lower)
    elif isinstance(expr, sp.elliptic_e | sp.elliptic_k | sp.elliptic_pi):
        fine = all(_positive(sp.factor(1 - argument), V) for argument in expr.args)
    else:
        fine = isinstance(expr, sp.besseli | sp.besselj) and expr.args[0] in (0, 1)
    if not fine:
        raise ValueError(f"{expr} is not known to be analytic for {V} > 0")
    rational = expr.is_Add or expr.is_Mul or (expr.is_Pow and expr.exp.is_Integer)
    for argument in expr.args:
        _require_real_analytic(argument, V, inside or not rational)


def _positive(expr: Expr, V: Expr) -> bool:
    """Tell whether an expression is known to be positive for V > 0.

    So is c sqrt(R) + L, c > 0, where L is positive, and where c^2 R > L^2.
    """
    if is_positive(expr, V):
        return True
    if expr.is_Mul or expr.is_Pow:
        return all(_positive(factor.as_base_exp()[0], V) for factor in sp.Mul.make_args(expr))
    if not expr.is_Add:
        return False
    if all(_positive(term, V) for term in expr.args):
        return True
    expr = sp.expand(expr)
    roots = {node for node in expr.atoms(sp.Pow) if node.exp == sp.Rational(1, 2) and node.has(V)}
    if len(roots) != 1:
        return False
    (root,) = roots
    c, L = expr.coeff(root), expr.coeff(root, 0)
    if not c.is_positive or L.has(root) or sp.expand(expr - c * root - L) != 0:
        return False
    return is_positive(L, V) or _outweighs(c**2 * root.base - L**2, L, V)


def _outweighs(above: Expr, L: Expr, V: Expr) -> bool:
    """Tell whether `above` is positive for V > 0, save at zeros of even order where L is positive."""
    if not above.is_polynomial(V):
        return False
    constant, factors = sp.factor_list(above, V)
    if not sp.sympify(constant).is_positive:
        return False
    for factor, power in factors:
        if is_positive(factor, V):
            continue
        places = sp.roots(factor, V)
        if power % 2 or sum(places.values()) < sp.degree(factor, V):
            return False
        if not all(place.is_nonpositive or L.subs(V, place).is_positive for place in places):
            return False
    return True


def _require_same_start(algebra: Algebra, term: Expr, value: Expr, criterion: Criterion, count: int) -> None:
    """Compare V value(V) and -sum b_n g_n V^n in the coefficients of V^n, n < count."""
    u = symbols.v
    for spare in _SPARE:
        of_term: Series = Expansion(algebra, u, count + spare).of(term)
        of_value: Series = Expansion(algebra, V, count + spare).of(V * value)
        if min(of_term.known, of_value.known) >= count:
            break
    else:
        raise ValueError("too many terms of a series cancel")
    if of_term.order < 0 and of_term.coefficients:
        raise ValueError(f"{term} is infinite at {u} = 0")
    for power in range(min(of_value.order, 0), count):
        weight = power * criterion.mean_power(power - 1) if power > 0 else sp.Integer(0)
        if of_value.coefficient(power) != -algebra.constant(weight) * of_term.coefficient(power):
            raise ValueError(f"the coefficients of V^{power - 1} are not known to be equal")


def _require_equation(product: Expr, algebra: Algebra, weighted: list[Expr], n: Expr, count: int) -> None:
    """Apply sum_k V^(r-k) q_k(theta - k), theta = V d/dV, to V F: a polynomial below V^count must be left."""
    r = len(weighted) - 1
    shifted = [sp.Poly(q.as_expr().subs(n, n - k), n) for k, q in enumerate(weighted)]
    differential = Differential(algebra)
    left, power = algebra.ring.zero, product
    for i in range(max(q.degree() for q in shifted) + 1):
        if i:
            power = differential.derivative(power) * algebra.scalar(V)
        factor = sp.Add(*[V ** (r - k) * q.coeff_monomial(n**i) for k, q in enumerate(shifted)])
        left += power * algebra.scalar(factor)
    if left == 0:
        return
    rest = algebra.field.to_sympy(left.coeff(1)) if left.is_ground else None
    if rest is None or not rest.is_polynomial(V) or sp.degree(rest, V) >= count:
        raise ValueError("the closed form is not known to satisfy the differential equation of the average")

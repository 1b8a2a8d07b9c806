"""Averages proved: both sides satisfy one differential equation and agree in their first coefficients.

For g(u) = sum g_n u^n near 0 the average is the power series V F(V) = -sum b_n g_n V^n, b_n = n <(1 + s)^(n-1)>,
and b_(n+1)/b_n is a rational function of n for every weight here; for the harmonic one it is
(n + 1)(2 n + 1)/(n (n + 2)). A linear differential equation of g with polynomial coefficients is a
recurrence of the g_n; so b_n g_n has one, which as a differential equation in V the closed form must satisfy. Two
power series that do, and agree in all coefficients that the recurrence does not fix, are equal; and two functions
analytic for V > 0 that agree near 0 agree for every V > 0.
"""

from dataclasses import dataclass
from functools import cached_property, reduce
from operator import add

import sympy as sp
from sympy.polys.matrices import DomainMatrix
from sympy.polys.polyerrors import BasePolynomialError

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import NoClosedForm
from stickslip_sym.core.symbols import V
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.proof.algebra import Algebra, Element, LaurentSeries, SeriesExpansion
from stickslip_sym.formula.proof.normal_form import normal_form
from stickslip_sym.formula.proof.theorems import is_positive, is_smooth
from stickslip_sym.output import printing

_HIGHEST_ORDER = 4  # of a differential equation that is looked for

AVERAGES_AGREE = (
    "both sides satisfy one linear differential equation in V, begin with the same coefficients at V = 0, and are "
    "analytic for V > 0"
)
"""The theorem in words, for a step that it proves."""


@dataclass(frozen=True)
class AverageSeries:
    """Evaluate the average of `constant` g(v) under a criterion as `constant` times `value`."""

    term: Expr
    criterion: Criterion
    constant: Expr
    value: Expr

    def __call__(self, expr: Expr) -> Expr:
        """Apply the theorem, after checking every hypothesis of it."""
        expected = definition(self.constant * self.term, self.criterion)
        if expr != expected and normal_form(expr - expected) != 0:
            raise ValueError("the integral is not the average of the term")
        _ = self.proof
        return self.constant * self.value

    @cached_property
    def proof(self) -> "SeriesProof | None":
        """What the hypotheses were checked on; of a power v^p, whose average is a moment, nothing more."""
        try:
            return prove_average(self.term, self.value, self.criterion)
        except (BasePolynomialError, NotImplementedError) as failure:  # SymPy's ways to say that
            raise ValueError(f"SymPy cannot compute with the term: {type(failure).__name__}") from None


@dataclass(frozen=True)
class SeriesProof:
    """The data of the theorem: with them its hypotheses are checked again in a few lines of algebra.

    Attributes
    ----------
    equation : list of Poly
        a_i(v) with sum_i a_i g^(i) = `rest`.
    rest : Poly
    operator : list of Poly
        q_k(n) with sum_k q_k(n - k) b_(n-k) g_(n-k) = 0 for n >= `count`: sum_k V^k q_k(theta), theta = V d/dV,
        leaves a polynomial below V^count of V F(V).
    count : int
        How many coefficients that does not fix.
    product : Element
        V F(V).
    """

    equation: list[sp.Poly]
    rest: sp.Poly
    operator: list[sp.Poly]
    count: int
    product: Element


def definition(mu: Expr, criterion: Criterion) -> Expr:
    """Return -<mu'(V(1 + s))>_w as an integral of mu itself."""
    v = symbols.v
    theta = symbols.theta
    if not criterion.is_polynomial:
        return sp.Integral(mu.subs(v, V * (1 - sp.cos(theta))) * criterion.angle_kernel, (theta, 0, sp.pi))
    boundary = criterion.boundary(mu)
    if boundary.has(sp.zoo, sp.oo, sp.nan):
        raise NoClosedForm(
            f"the weight of {criterion.name!r} is not 0 at s = -1, where {printing.text(mu)} has no value"
        )
    return sp.Integral(mu * criterion.kernel, (v, 0, 2 * V)) + boundary


def prove_average(term: Expr, value: Expr, criterion: Criterion) -> SeriesProof | None:
    """Prove that `value` is the average of a term, or raise ValueError and say which hypothesis fails."""
    u = symbols.v
    if term.is_Pow and term.base == u and not term.exp.is_Integer:
        _require_moment(term.exp, value, criterion)
        return None
    parameters = sorted((term.free_symbols | value.free_symbols) - {u, V}, key=str)
    n = sp.Dummy("n")
    equation, rest = _equation_of(term, u)
    recurrence, start = _recurrence(equation, rest, n)
    weighted, common = _weighted(recurrence, criterion, n)
    first = _fixed_from(weighted[-1].as_expr() * common, n, start)
    r = len(weighted) - 1
    operator = [sp.Poly(q.as_expr().subs(n, n - r + k), n) for k, q in enumerate(weighted[::-1])]
    count = first + r
    algebra = Algebra(V, parameters)
    if not is_smooth(value, V, analytic=True, inside=False):
        raise ValueError(f"{value} is not known to be analytic for {V} > 0")
    _require_same_start(algebra, term, value, criterion, count)
    product = algebra.of(V * value)
    _require_equation(product, operator, count)
    return SeriesProof(equation, rest, operator, count, product)


def _require_moment(p: Expr, value: Expr, criterion: Criterion) -> None:
    """Compare the average of v^p with -p V^(p-1) <(1 + s)^(p-1)>."""
    if not (p + criterion.order_at_rest).is_positive:
        raise ValueError(f"v^({p}) is not integrable with the weight of the criterion")
    if sp.gammasimp(sp.powsimp(value / (-p * V ** (p - 1) * criterion.mean_power(p - 1)))) != 1:
        raise ValueError("the value is not known to be the moment of the weight")


# -- the recurrence of the term, and of the average ------------------------------------------------


def _equation_of(term: Expr, u: Expr) -> tuple[list[sp.Poly], sp.Poly]:
    """Return polynomials a_i and a rest with sum_i a_i g^(i) = rest for a term g; a_r has no zero for u > 0."""
    if term.is_rational_function(u):
        rest, below = (sp.Poly(part, u) for part in sp.fraction(sp.cancel(term)))
        if below.nth(0) == 0:
            raise ValueError(f"{term} is not known to be finite at {u} = 0")
        equation = [below]
    elif is_smooth(term, u):
        equation = _equation(term, u)
        rest = sp.Poly(0, u)
    else:
        raise ValueError(f"{term} is not known to be smooth for {u} >= 0")
    _require_no_zero(equation[-1].as_expr(), u)
    return equation, rest


def _recurrence(equation: list[sp.Poly], rest: sp.Poly, n: Expr) -> tuple[list[Expr], int]:
    """Return p_k(n) and the first n with sum_k p_k(n) g_(n+k) = 0 from it on, g_j = 0 for j < 0."""
    # c u^m g^(i) adds c j...(j - i + 1) g_j to the coefficient of u^(j - i + m).
    lowest = min(i - m for i, coefficient in enumerate(equation) for (m,) in coefficient.monoms())
    parts: dict[int, Expr] = {}
    for i, coefficient in enumerate(equation):
        for (m,), c in coefficient.terms():
            k = i - m - lowest
            parts[k] = parts.get(k, 0) + c * sp.ff(n + k, i)
    start = lowest + (0 if rest.is_zero else rest.degree() + 1)
    return [parts.get(k, sp.Integer(0)) for k in range(max(parts) + 1)], max(start, 0)


def _equation(f: Expr, u: Expr) -> list[sp.Poly]:
    """Return polynomials a_i with sum_i a_i f^(i) = 0, of the lowest order."""
    algebra = Algebra(u, sorted(f.free_symbols - {u}, key=str))
    derivatives: list[Element] = [algebra.of(f)]
    for _ in range(_HIGHEST_ORDER):
        derivatives.append(derivatives[-1].derivative)
        monomials = sorted(set().union(*(d.polynomial.monoms() for d in derivatives)))
        rows = [[d.polynomial.get(m, algebra.field.zero) for d in derivatives] for m in monomials]
        kernel = DomainMatrix(rows, (len(rows), len(derivatives)), algebra.field).nullspace()
        if kernel.shape[0]:
            solution = sp.together(sp.Matrix(kernel.to_Matrix().row(0)))
            below = sp.lcm_list([sp.denom(entry) for entry in solution])
            return [sp.Poly(sp.cancel(entry * below), u) for entry in solution]
    raise ValueError(f"no differential equation of {f} is known here")


def _require_no_zero(polynomial: Expr, u: Expr) -> None:
    """Refuse a leading coefficient that may vanish for u > 0; at 0 the series says that all is analytic."""
    for factor, _ in sp.factor_list(polynomial, u)[1]:
        if factor != u and not (is_positive(factor, u) or is_positive(-factor, u)):
            raise ValueError(f"{factor} is not known to have no zero for {u} >= 0")


def _weighted(recurrence: list[Expr], criterion: Criterion, n: Expr) -> tuple[list[sp.Poly], Expr]:
    """Return q_k with sum_k q_k(n) b_(n+k) g_(n+k) = 0, polynomials in n, and what was divided out of them."""
    ratio = moment_ratio(criterion, n)
    terms = [sp.cancel(p / sp.prod([ratio.subs(n, n + i) for i in range(k)])) for k, p in enumerate(recurrence)]
    above = sp.lcm_list([sp.denom(term) for term in terms])
    whole = [sp.Poly(sp.cancel(term * above), n) for term in terms]
    common = reduce(sp.gcd, whole).as_expr()
    return [sp.Poly(sp.cancel(q.as_expr() / common), n) for q in whole], common


def moment_ratio(criterion: Criterion, n: Expr) -> Expr:
    """Return b_(n+1)/b_n."""
    if not criterion.is_polynomial:
        return (n + 1) * (2 * n + 1) / (n * (n + 2))
    moment = sp.Add(*[w * 2**j / (n + j) for (j,), w in criterion.from_rest.terms()])  # <(1 + s)^(n-1)> over 2^n
    return sp.cancel(2 * (n + 1) * moment.subs(n, n + 1) / (n * moment))


def _fixed_from(leading: Expr, n: Expr, start: int) -> int:
    """Return the n >= 1 from which the recurrence fixes every coefficient; no root of `leading` comes after."""
    first = max(start, 1)
    constant, factors = sp.factor_list(leading, n)
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


# -- what the closed form must fulfil --------------------------------------------------------------


def _require_same_start(algebra: Algebra, term: Expr, value: Expr, criterion: Criterion, count: int) -> None:
    """Compare V value(V) and -sum b_n g_n V^n in the coefficients of V^n, n < count."""
    u = symbols.v

    def expanded(terms: int) -> tuple[LaurentSeries, LaurentSeries]:
        return SeriesExpansion(algebra, u, terms).of(term), SeriesExpansion(algebra, V, terms).of(V * value)

    of_term, of_value = expanded(count)
    lacking = count - min(of_term.known, of_value.known)
    if lacking > 0:
        of_term, of_value = expanded(count + lacking)
    if min(of_term.known, of_value.known) < count:
        raise ValueError("too many terms of a series cancel")
    if of_term.order < 0 and of_term.coefficients:
        raise ValueError(f"{term} is infinite at {u} = 0")
    zero = algebra.of(sp.S.Zero)
    for power in range(min(of_value.order, 0), count):
        if power > 0:
            weight = power * criterion.mean_power(power - 1)
        else:
            weight = sp.S.Zero
        if (of_value.coefficient(power) or zero) + algebra.of(weight) * (of_term.coefficient(power) or zero):
            raise ValueError(f"the coefficients of V^{power - 1} are not known to be equal")


def _require_equation(product: Element, operator: list[sp.Poly], count: int) -> None:
    """Apply sum_k V^k q_k(theta), theta = V d/dV, to V F: a polynomial below V^count must be left."""
    algebra = product.algebra
    (n,) = operator[0].gens
    terms = []
    power = product
    for i in range(max(q.degree() for q in operator) + 1):
        factor = sp.Add(*[V**k * q.coeff_monomial(n**i) for k, q in enumerate(operator)])
        terms.append(power * algebra.of(factor))
        power = power.derivative * algebra.of(V)
    left = reduce(add, terms).polynomial
    if left.is_ground:
        rest = algebra.field.to_sympy(left.coeff(1))
    else:
        rest = None
    if rest is None or not rest.is_polynomial(V) or (rest != 0 and sp.degree(rest, V) >= count):
        raise ValueError("the closed form is not known to satisfy the differential equation of the average")

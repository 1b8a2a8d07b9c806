"""Antiderivatives of a term of a law times a polynomial kernel, one rule for each family of terms.

A rule returns F with F' = polynomial times factors, real and smooth for u >= 0, or None where it does not apply. F
is proved by differentiation wherever it is used, so a wrong rule cannot give a wrong result.
"""

from collections.abc import Callable
from typing import cast

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.core.special import Ein, Lerch, polylog
from stickslip_sym.formula.finding.matching import (
    Rule,
    argument_coefficients,
    as_binomial,
    as_damped_wave,
    as_power,
    as_stretched,
    coefficients,
    first_rule,
    minus_discriminant,
    partial_fractions,
    waves_apart,
)
from stickslip_sym.model.expression.letters import HIGHEST_ROOT
from stickslip_sym.model.terms import grouped

_HALF = sp.Rational(1, 2)


def integrate_by_parts(polynomial: Expr, iterated_integral: Callable[[int], Expr], u: Expr) -> Expr:
    """Return sum_j (-1)^j polynomial^(j) ladder(j + 1), where ladder(j)' = ladder(j - 1)."""
    total = sp.S.Zero
    sign = 1
    j = 1
    while polynomial != 0:
        total += sign * polynomial * iterated_integral(j)
        polynomial = sp.factor_terms(sp.diff(polynomial, u))
        sign = -sign
        j += 1
    return total


# -- rules ------------------------------------------------------------------------------------------


def antiderivative(rest: Expr, kernel: Expr, u: Expr) -> tuple[str, Expr] | None:
    """Return the names of the rules that integrate rest * kernel, term by term, and what they give, or None."""
    names = []
    total = sp.S.Zero
    for part, constant in grouped(waves_apart(rest), u).items():
        by_rule = first_rule(_RULES, part, kernel, u)
        if by_rule is None:
            return None
        names.append(by_rule[0])
        total += constant * by_rule[1]
    return ", ".join(dict.fromkeys(names)), total


def _integral_of_polynomial(polynomial: Expr, u: Expr) -> Expr:
    return sp.Poly(polynomial, u).integrate().as_expr()


def _integrate_repeatedly(polynomial: Expr, node: Expr, line: list[Expr], u: Expr) -> Expr | None:
    """Integrate u^n times a power of a function of a linear argument."""
    base, power = (node, 1) if isinstance(node, sp.exp) else node.as_base_exp()
    (_, *order) = base.args
    x = sp.Dummy("x", real=True)
    iterated_integral = FUNCTIONS[base.func].iterated_integral
    n = int(order[0] if order else power)
    if iterated_integral is None or (order and power != 1) or iterated_integral(x, n, 1) is None:
        return None
    return integrate_by_parts(
        polynomial, lambda j: cast(Expr, iterated_integral(x, n, j)).subs(x, base.args[0]) / line[0] ** j, u
    )


def _subtract_integral(product: Expr, rest: Expr, u: Expr) -> Expr | None:
    """Return a product less the integral of what integration by parts leaves, if that has one."""
    left = antiderivative(rest, sp.Integer(1), u)
    if left is None:
        return None
    return product - left[1]


def _product_by_parts(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """W f^k - integral of W (f^k)', W' the polynomial, f a function whose derivative has none of its kind."""
    function, power = node.as_base_exp()
    line = coefficients(function.args[0], u)
    if len(line) == 2 and function.args[0] != u:
        # In x = a u + b, where W = 0 at x = 0: of a logarithm's power is left a polynomial times a lower one.
        x = sp.Dummy("x", positive=isinstance(function, sp.log) or None, real=True)
        inner = sp.expand(polynomial.subs(u, (x - line[1]) / line[0]) / line[0])
        primitive: Expr | None = _product_by_parts(inner, function.func(x) ** power, x)
        if primitive is None:
            return None
        return primitive.subs(x, function.args[0])
    whole = _integral_of_polynomial(polynomial, u)
    slope = sp.diff(function, u)
    if slope.is_rational_function(u):
        factor = sp.cancel(whole * slope)
    else:
        factor = whole * slope
    return _subtract_integral(whole * node, power * factor * function ** (power - 1), u)


def _reduced(polynomial: Expr, alpha: Expr, beta: Expr, u: Expr) -> tuple[Expr, Expr]:
    """Return A and a remainder of the lowest degree with A' alpha + A beta + remainder = polynomial.

    So A alpha w + the integral of remainder w is that of polynomial w, where (alpha w)' = beta w.
    """
    total = sp.S.Zero
    left = sp.Poly(polynomial, u)
    above = sp.Poly(alpha, u)
    below = sp.Poly(beta, u)
    drop = max(above.degree() - 1, below.degree())
    while left.degree() >= drop and not left.is_zero:
        k = left.degree() - drop
        step = sp.Poly(left.LC() / (k * above.nth(drop + 1) + below.nth(drop)) * u**k, u)
        total += step.as_expr()
        left -= step.diff(u) * above + step * below
        left = sp.Poly({power: c for power, c in left.terms() if power[0] < k + drop} or {(0,): 0}, u)
    return total, left.as_expr()


def _power(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (a u + b)^p, p no integer (for b = 0: p > -1)."""
    match = as_power(node, u)
    if match is None:
        return None
    base, rate, _, p = match
    return integrate_by_parts(polynomial, lambda j: base ** (p + j) / (sp.rf(p + 1, j) * rate**j), u)


def _root(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """u^n (a u^2 + b u + c)^(k/2), k odd and >= -1, the quadratic positive: asinh. Holds u/sqrt(u^2 + w^2).

    Where its zeros may be real it is a logarithm, for a, b, c >= 0, and for a < 0 an arcsine.
    """
    base, exponent = node.as_base_exp()
    quadratic = coefficients(base, u)
    times = exponent + _HALF
    if len(quadratic) != 3 or not (times.is_Integer and times >= 0):
        return None
    a, b, c = quadratic
    gap = sp.factor(4 * a * c - b**2)
    falls = a.is_negative and gap.is_negative
    if not (falls or (a.is_positive and (gap.is_positive or (b.is_positive and c.is_positive)))):
        return None
    above, constant = _reduced(polynomial * base**times, base, sp.diff(base, u) / 2, u)
    root = sp.sqrt(base)
    slope = 2 * a * u + b
    if falls:
        return above * root - constant / sp.sqrt(-a) * sp.asin(slope / sp.sqrt(-gap))
    if gap.is_positive:
        arc = sp.asinh(slope / sp.sqrt(gap))
    else:
        arc = sp.log(2 * sp.sqrt(a) * root + slope)
    return above * root + constant / sp.sqrt(a) * arc


def _gaussian(polynomial: Expr, node: Expr, quadratic: list[Expr], u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u^2 + b u + c), a > 0."""
    a, b, c = -quadratic[0], *quadratic[1:]
    if not a.is_positive:
        return None
    x = sp.Dummy("x", real=True)
    root = sp.sqrt(a)
    middle = b / (2 * a)
    inner = sp.expand(polynomial.subs(u, x / root + middle)) / root
    above, constant = _reduced(inner, sp.Integer(1), -2 * x, x)
    integral = above * sp.exp(-(x**2)) + constant * sp.sqrt(sp.pi) / 2 * sp.erf(x)
    return sp.exp(c + a * middle**2) * integral.subs(x, root * (u - middle))


def _lognormal(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a log(u)^2 + b log(u) + c), a > 0: a Gaussian of log(u)."""
    x = sp.Dummy("x", real=True)
    quadratic = coefficients(sp.expand_log(node.exp).subs(sp.log(u), x), x)
    if len(quadratic) != 3 or any(part.has(u) for part in quadratic) or not quadratic[0].is_negative:
        return None
    a, b, c = -quadratic[0], *quadratic[1:]
    total = sp.S.Zero
    for (n,), front in sp.Poly(polynomial, u).terms():
        rate = n + 1 + b
        bell = sp.erf(sp.sqrt(a) * sp.log(u) - rate / (2 * sp.sqrt(a)))
        total += front * sp.exp(c + rate**2 / (4 * a)) * sp.sqrt(sp.pi / a) / 2 * bell
    return total


def _stretched(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate u^q exp(-(u/w)^d), d and q symbolic: incomplete gamma functions, for d < 0 the upper ones."""
    match = as_stretched(factors, u)
    if match is None:
        return None
    front, q, k, d = match
    terms = [(c, n + 1 + q) for (n,), c in sp.Poly(front * polynomial, u).terms()]
    if d.is_negative:
        orders = [(c, power / -d) for c, power in terms]
        return sp.Add(*[-c / d * k**order * _upper_gamma(-order, k * u**d) for c, order in orders])
    if any(power.is_nonpositive for _, power in terms):  # infinite at 0, unless another term cancels it
        return None
    w = sp.powdenest(k ** (-1 / d))
    return sp.Add(*[c * w**power / d * sp.lowergamma(power / d, (u / w) ** d) for c, power in terms])


def _upper_gamma(order: Expr, x: Expr) -> Expr:
    """Return Gamma(order, x), of the orders 0, -1, -2, ... by E_1.

    -n Gamma(-n, x) = Gamma(1 - n, x) - x^(-n) exp(-x).
    """
    if not (order.is_Integer and order <= 0):
        return sp.uppergamma(order, x)
    value = sp.expint(1, x)
    for n in range(1, int(-order) + 1):
        value = (x**-n * sp.exp(-x) - value) / n
    return sp.expand(value)


def _exponential_power(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (a u + b)^p exp(-k u), p no integer: upper incomplete gamma functions of k (u + b/a)."""
    power, exponential = factors.as_independent(sp.exp, as_Add=False)
    match = as_power(power, u)
    line = argument_coefficients(exponential, sp.exp, u)
    if match is None or len(line) != 2 or not line[0].is_negative:
        return None
    _, rate, shift, p = match
    k = -line[0]
    start = shift / rate
    x = sp.Dummy("x", positive=True)
    if not start.is_positive:
        return None
    terms = sp.Poly(sp.expand(polynomial.subs(u, x - start)), x).terms()
    total = sp.Add(*[-c * k ** -(p + n + 1) * sp.uppergamma(p + n + 1, k * (u + start)) for (n,), c in terms])
    return rate**p * sp.exp(sp.expand(line[1] + k * start)) * total


def _power_of_logarithm(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n y^p, y = c - b log(u) > 0, b > 0: upper incomplete gamma functions of multiples of y."""
    base, p = node.as_base_exp()
    if sp.denom(base).has(u):
        base = 1 / base
        p = -p
    b = -base.coeff(sp.log(u))
    c = base.subs(sp.log(u), 0)
    if p.has(u) or p.is_integer is not False or c.has(u) or not b.is_positive:
        return None
    if sp.expand(base - c + b * sp.log(u)) != 0:
        return None
    total = sp.S.Zero
    for (n,), front in sp.Poly(polynomial, u).terms():
        m = (n + 1) / b
        total += front * sp.exp(m * c) * m ** -(p + 1) / b * sp.uppergamma(p + 1, m * base)
    return total


def _damped_wave(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(a u + c) cos(b u + d), or sin: the real part of exp(z u), whose integrals are over z^j."""
    match = as_damped_wave(factors, u)
    if match is None:
        return None
    exponential, wave, (a, _), (b, _) = match
    angle = wave.args[0]
    square = a**2 + b**2

    def ladder(j: int) -> Expr:
        x = sp.Dummy("x", real=True)
        y = sp.Dummy("y", real=True)
        P, Q = (part.subs({x: a, y: b}) for part in sp.expand((x - sp.I * y) ** j).as_real_imag())
        cosine = sp.cos(angle)
        sine = sp.sin(angle)
        if isinstance(wave, sp.cos):
            turned = P * cosine - Q * sine
        else:
            turned = P * sine + Q * cosine
        return exponential * turned / square**j

    return integrate_by_parts(polynomial, ladder, u)


def _sine_over_speed(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate u^n sin(a u)/u: the sine integral, and for n > 0 a polynomial times sines."""
    over, sine = factors.as_independent(sp.sin, as_Add=False)
    line = argument_coefficients(sine, sp.sin, u)
    if over != 1 / u or len(line) != 2 or line[1] != 0:
        return None
    powers = sp.Poly(polynomial, u)
    higher = sp.cancel((powers - powers.nth(0)).as_expr() / u)
    if higher != 0:
        left = _integrate_repeatedly(higher, sine, line, u)
    else:
        left = sp.Integer(0)
    if left is None:
        return None
    return powers.nth(0) * sp.Si(sine.args[0]) + left


def _integral_with_exponential(polynomial: Expr, rate: Expr, u: Expr) -> Expr:
    """Return the integral of a polynomial times exp(rate u), over that."""
    return sp.factor_terms(integrate_by_parts(polynomial, lambda j: rate**-j, u))


def _exponential_logarithm(polynomial: Expr, exponential: Expr, logarithm: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u) log(r u + s), s > 0, by parts: what is left are exponential integrals."""
    line = coefficients(exponential.args[0], u)
    inner = coefficients(logarithm.args[0], u)
    if logarithm.is_Pow or len(line) != 2 or len(inner) != 2 or inner[1] == 0:
        return None
    whole = _integral_with_exponential(polynomial, line[0], u)
    left = _exponential_over_linear(whole, sp.diff(logarithm, u) * exponential, u)
    if left is None:
        return None
    return whole * exponential * logarithm - left


def _exponential_of_root(polynomial: Expr, error: Expr, exponential: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(a u) erf(sqrt(b u)), or erfc, by parts: left are powers of u with exp((a - b) u)."""
    line = coefficients(exponential.args[0], u)
    rate = sp.expand(error.args[0] ** 2) / u
    if error.is_Pow or len(line) != 2 or rate.has(u) or not rate.is_positive:
        return None
    whole = _integral_with_exponential(polynomial, line[0], u)
    rest = sp.expand(whole * exponential * sp.diff(error, u))
    return _subtract_integral(whole * exponential * error, rest, u)


def _log_cosh(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n log(cosh(a u + b)) by parts: what is left is u^(n + 1) tanh(a u + b)."""
    if node.is_Pow or not isinstance(node.args[0], sp.cosh):
        return None
    (x,) = node.args[0].args
    whole = _integral_of_polynomial(polynomial, u)
    rest = sp.expand(whole * sp.diff(x, u)) * sp.tanh(x)
    return _subtract_integral(whole * node, rest, u)


def _softplus(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n log(1 + c exp(k u)) = -u^n Li_1(-c exp(k u)), c > 0: Li_s(z) integrates to Li_(s+1)(z)/k."""
    rest, exponential = (node.args[0] - 1).as_independent(sp.exp, as_Add=False)
    line = argument_coefficients(exponential, sp.exp, u)
    if node.is_Pow or len(line) != 2 or not rest.is_positive:
        return None
    z = -rest * exponential
    return integrate_by_parts(polynomial, lambda j: -polylog(1 + j, z) / line[0] ** j, u)


def _product_of_roots(polynomial: Expr, first: Expr, second: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (a u + b)^(i/2) (c u + d)^(k/2), i and k odd and >= -1: the root of a quadratic."""
    one = as_power(first, u)
    two = as_power(second, u)
    if one is None or two is None:
        return None
    (left, *_, p) = one
    (right, *_, q) = two
    if not ((p + _HALF).is_Integer and (q + _HALF).is_Integer):
        return None
    lowest = min(p, q)
    above = left ** (p - lowest) * right ** (q - lowest)
    return _root(sp.expand(polynomial * above), sp.Pow(sp.expand(left * right), lowest), u)


def _rational_in_root(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate a rational function of u^(1/q), q up to 6, by x = u^(1/q)."""
    orders = {power.exp.q for power in factors.atoms(sp.Pow) if power.base == u and power.exp.is_Rational}
    q = int(sp.ilcm(1, 1, *orders))
    x = sp.Dummy("x", positive=True)
    if not 1 < q <= HIGHEST_ROOT:
        return None
    inner = (polynomial * factors).xreplace({u: x**q}) * q * x ** (q - 1)
    if not inner.is_rational_function(x):
        return None
    found = _rational(sp.Integer(1), sp.cancel(sp.together(inner)), x)
    if found is None:
        return None
    return found.xreplace({x: u ** sp.Rational(1, q)})


def _binomial(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate u^n (b + a u^d)^p, n perhaps no integer, by b^p u^(n+1)/(n+1) 2F1(-p, e; 1 + e; -a u^d/b).

    Here e = (n + 1)/d.
    """
    match = as_binomial(factors, u)
    if match is None:
        return None
    q, b, a, d, p = match
    terms = []
    for (n,), c in sp.Poly(polynomial, u).terms():
        m = n + q + 1
        terms.append(c * u**m / m * sp.hyper((-p, m / d), (1 + m / d,), -a * u**d / b))
    return b**p * sp.Add(*terms)


def _exponential_of_inverse(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(c - a/u), a > 0: exp(c) u^(n+1) E_(n+2)(a/u), by E_(k+1)(x) = (exp(-x) - x E_k(x))/k."""
    constant, inverse = sp.expand(node.exp).as_independent(u, as_Add=True)
    a = -inverse * u
    if a.has(u) or not a.is_positive:
        return None
    x = a / u
    total = sp.S.Zero
    top = 0
    if polynomial.has(u):
        top = int(sp.degree(polynomial, u))
    integral = sp.expint(1, x)
    for n in range(top + 1):
        integral = (sp.exp(-x) - x * integral) / (n + 1)
        total += sp.expand(polynomial).coeff(u, n) * u ** (n + 1) * integral
    return sp.exp(constant) * sp.expand(total)


def _exponential_erf(polynomial: Expr, erf: Expr, exponential: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u) erf(b u) by parts, what is left of which is Gaussian."""
    line = coefficients(exponential.args[0], u)
    inner = coefficients(erf.args[0], u)
    if erf.is_Pow or len(line) != 2 or len(inner) != 2:
        return None
    whole = _integral_with_exponential(polynomial, line[0], u)
    exponent = sp.expand(exponential.args[0] - erf.args[0] ** 2)
    left = _gaussian(
        sp.expand(2 * inner[0] / sp.sqrt(sp.pi) * whole), sp.exp(exponent), coefficients(exponent, u), u
    )
    if left is None:
        return None
    return whole * exponential * erf - left


def _reciprocal_of_logarithm(polynomial: Expr, node: Expr, u: Expr) -> Expr | None:
    """Integrate u^n/(c + b log(w)), w = r u + s: w^n gives exp(-(n + 1) c/b) Ei((n + 1) (log(w) + c/b))/(b r)."""
    base, power = node.as_base_exp()
    logarithms = [*base.atoms(sp.log)]
    if power != -1 or len(logarithms) != 1:
        return None
    (logarithm,) = logarithms
    line = coefficients(logarithm.args[0], u)
    c = base.subs(logarithm, 0)
    b = base.coeff(logarithm)
    w = sp.Dummy("w", positive=True)
    if (
        len(line) != 2
        or c.has(u)
        or sp.expand(base - c - b * logarithm) != 0
        or not (b.is_positive and c.is_positive)
    ):
        return None
    if not (line[0].is_positive and (line[1] - 1).is_nonnegative):
        return None
    total = sp.S.Zero
    for (n,), front in sp.Poly(sp.expand(polynomial.subs(u, (w - line[1]) / line[0])), w).terms():
        total += front * sp.exp(-(n + 1) * c / b) * sp.Ei((n + 1) * (logarithm + c / b))
    return total / (b * line[0])


def _rational(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate rational functions whose denominator splits into factors of degree 1 and 2."""
    parts = partial_fractions(polynomial * factors, u)
    if parts is None:
        return None
    fractions = [_fraction(*fraction, u) for fraction in parts[1]]
    if None in fractions:
        return None
    return _integral_of_polynomial(parts[0], u) + sp.Add(*fractions)


def _fraction(numerator: Expr, monic: list[Expr], power: int, u: Expr) -> Expr | None:
    """Integrate (A u + B)/(u^2 + b u + c)^power by Hermite's reduction, or B/(u + c)^power."""
    base = sp.Poly(monic, u).as_expr()
    *middle, c = monic[1:]
    of_zero = base
    if c != 0:
        of_zero = 1 + sp.expand(sp.expand(base - c) / c)
    if power == 1:
        over = sp.log(of_zero)
    else:
        over = base ** (1 - power) / (1 - power)
    if not middle:
        return numerator * over
    (b,) = middle
    line = sp.Poly(numerator, u)
    A = line.nth(1)
    gap = minus_discriminant(middle[0], c)
    B = line.nth(0) - A * b / 2
    total = A / 2 * over
    slope = 2 * u + b
    for k in range(power - 1, 0, -1):
        total += B * slope / (k * gap * base**k)
        B *= sp.Rational(2 * (2 * k - 1), k) / gap
    root = sp.sqrt(sp.Abs(gap))
    if gap.is_positive:
        return total + 2 * B / root * sp.atan(slope / root)
    if gap.is_negative:
        return total + B / root * sp.log((slope - root) / (slope + root))
    if power > 1:
        return None
    # Roots that may be real or complex: the arctangent over its root, which is analytic in the discriminant.
    reach = u / (2 * c + b * u)
    return total + 2 * B * reach * sp.hyper((_HALF, 1), (3 * _HALF,), -gap * reach**2)


def _exponential_over_linear(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """exp(-a u) times a rational function with linear denominators, a > 0: E_1."""
    rational, exponential = factors.as_independent(sp.exp, as_Add=False)
    parts = partial_fractions(polynomial * rational, u)
    line = argument_coefficients(exponential, sp.exp, u)
    if parts is None or len(line) != 2 or not line[0].is_negative or any(len(base) > 2 for _, base, _ in parts[1]):
        return None
    rate, constant = line
    total = _integrate_repeatedly(parts[0], exponential, line, u) or sp.Integer(0)
    for numerator, (_, shift), power in parts[1]:
        base = u + shift
        for k in range(power - 1, 0, -1):
            total -= numerator * exponential / (k * base**k)
            numerator *= rate / k
        if shift == 0:  # what log(u) is infinite by, another term may cancel, as in (1 - exp(-u))/u
            total += numerator * sp.exp(constant) * (sp.log(u) - Ein(-rate * u))
            continue
        total -= numerator * sp.exp(sp.expand(constant - rate * shift)) * sp.expint(1, -rate * base)
    return total


def _logarithm_over_linear(polynomial: Expr, factors: Expr, u: Expr) -> Expr | None:
    """Integrate log(a u + b) times a rational function with linear denominators: Li_2.

    With w = u + b/a and q = w - (u + s), log(a w)^2/2 + log(a w) log(1 - q/w) - Li_2(q/w) has the derivative
    log(a w)/(u + s), and q/w is below 1.
    """
    rational, logarithm = factors.as_independent(sp.log, as_Add=False)
    parts = partial_fractions(polynomial * rational, u)
    line = argument_coefficients(logarithm, sp.log, u)
    if parts is None or len(line) != 2 or any(len(base) > 2 for _, base, _ in parts[1]):
        return None
    whole = _integral_of_polynomial(parts[0], u)
    total = sp.S.Zero
    start = line[1] / line[0]
    for numerator, (_, s), power in parts[1]:
        if power > 1:
            whole += numerator * (u + s) ** (1 - power) / (1 - power)
        elif s == start:
            total += numerator * logarithm**2 / 2
        else:
            z = sp.factor((start - s) / (u + start))
            total += numerator * (logarithm**2 / 2 + logarithm * sp.log(1 - z) - polylog(2, z))
    left = _rational(whole * sp.diff(logarithm, u), sp.Integer(1), u)
    if left is None:
        return None
    return total + whole * logarithm - left


def _exponential_tanh(polynomial: Expr, exponential: Expr, tanh: Expr, u: Expr) -> Expr | None:
    """Integrate u^n exp(-a u) tanh(k u), a > 0, k > 0, by the Lerch transcendent.

    exp(-r x) tanh(x) = exp(-r x) - 2 exp(-(r + 2) x) Phi(-exp(-2 x), 0, 1 + r/2), x = k u, r = a/k.
    """
    decay = coefficients(exponential.args[0], u)
    slope = coefficients(tanh.args[0], u)
    if not isinstance(tanh, sp.tanh) or not len(decay) == len(slope) == 2 or slope[1] != 0:
        return None
    k = slope[0]
    r = -decay[0] / k
    if not r.is_positive:
        return None

    def ladder(j: int) -> Expr:
        z = -sp.exp(-2 * k * u)
        lerch = 2 * _HALF**j * z * Lerch(z, j, 1 + r / 2)
        return (-1 / k) ** j * exponential * (r**-j + lerch)

    return integrate_by_parts(polynomial, ladder, u)


_RULES = (
    Rule("polynomial", (), _integral_of_polynomial),
    Rule("partial fractions", None, _rational),
    Rule(
        "repeated integrals",
        (tuple(kind for kind, row in FUNCTIONS.items() if row.iterated_integral),),
        _integrate_repeatedly,
        degree=1,
    ),
    Rule("integration by parts", ((sp.log, sp.atan, sp.asinh, sp.asin, sp.acos, sp.erf),), _product_by_parts),
    Rule("power", (sp.Pow,), _power),
    Rule("square root of a quadratic", (sp.Pow,), _root),
    Rule("Gaussian", (sp.exp,), _gaussian, degree=2),
    Rule("Gaussian of a logarithm", (sp.exp,), _lognormal),
    Rule("incomplete gamma", None, _stretched),
    Rule("Lerch transcendent", (sp.exp, sp.tanh), _exponential_tanh),
    Rule("exponential integral", None, _exponential_over_linear),
    Rule("damped oscillation", None, _damped_wave),
    Rule("sine integral", None, _sine_over_speed),
    Rule("upper incomplete gamma", None, _exponential_power),
    Rule("upper incomplete gamma of a logarithm", (sp.Pow,), _power_of_logarithm),
    Rule("integration by parts, and exponential integral", (sp.exp, sp.log), _exponential_logarithm),
    Rule("integration by parts, and powers", ((sp.erf, sp.erfc), sp.exp), _exponential_of_root),
    Rule("polylogarithm", (sp.log,), _softplus),
    Rule("integration by parts, and repeated integrals", (sp.log,), _log_cosh),
    Rule("square root of a product", (sp.Pow, sp.Pow), _product_of_roots),
    Rule("partial fractions of a root", None, _rational_in_root),
    Rule("dilogarithm", None, _logarithm_over_linear),
    Rule("exponential integral of an inverse", (sp.exp,), _exponential_of_inverse),
    Rule("integration by parts, and Gaussian", (sp.erf, sp.exp), _exponential_erf),
    Rule("exponential integral of a logarithm", (sp.Pow,), _reciprocal_of_logarithm),
    Rule("hypergeometric function of a power", None, _binomial),
)

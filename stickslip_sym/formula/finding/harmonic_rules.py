"""The harmonic criterion of a term of a law, one rule for each family of terms.

With H[g] = 2/(pi V) * integral_0^pi g(V (1 - cos(theta))) cos(theta) dtheta the criterion is c = N H[mu]. A rule
returns H of its factors, real for V > 0, or None where it does not apply: rational functions by residues, powers
and hypergeometric series by moments, the rest by Fourier coefficients.
"""

from collections.abc import Callable
from itertools import pairwise

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.formula.finding.matching import (
    Rule,
    argument_coefficients,
    as_binomial,
    as_damped_wave,
    as_power,
    as_stretched,
    first_rule,
    minus_discriminant,
    partial_fractions,
    waves_apart,
)
from stickslip_sym.model.terms import grouped

_HALF = sp.Rational(1, 2)


def harmonic_average(rest: Expr, u: Expr, V: Expr) -> tuple[str, Expr] | None:
    """Return the name of the rule that averages a term and H[rest], or None; waves apart, each by its rule."""
    names = []
    total = sp.S.Zero
    pole = sp.S.Zero
    for part, constant in grouped(waves_apart(rest), u).items():
        if (exponent := _exponent_over_speed(part, u)) is not None:
            rate, shift = exponent
            pole += constant * sp.exp(shift)
            # exp(-k u)/u = 1/u - k 1F1(1; 2; -k u), and what is left of 1/u must cancel.
            series = _average_of_series(sp.S.Zero, [sp.S.One], [sp.Integer(2)], rate, sp.S.One, V)
            total += constant * sp.exp(shift) * rate * series
            names.append("hypergeometric series")
            continue
        if part.has(u):
            average = first_rule(_RULES, part, sp.Integer(1), u, V)
        else:
            average = ("polynomial", sp.Integer(0))
        if average is None:
            return None
        names.append(average[0])
        total += constant * average[1]
    if sp.expand(pole) == 0:
        return (", ".join(dict.fromkeys(names)), total)
    return None


def _exponent_over_speed(part: Expr, u: Expr) -> tuple[Expr, Expr] | None:
    """Return a and b of exp(a u + b)/u, 0 and 0 of 1/u; None for anything else."""
    if part == 1 / u:
        return sp.S.Zero, sp.S.Zero
    numerator = sp.expand_mul(part * u)
    line = argument_coefficients(numerator, sp.exp, u)
    if len(line) == 2:
        return (line[0], line[1])
    return None


def _cosine_coefficients(polynomial: Expr, u: Expr, V: Expr) -> list[Expr]:
    """Return w_k with polynomial(V (1 - cos(theta))) cos(theta) = sum w_k cos(k theta)."""
    z = sp.Dummy("z")  # exp(i theta)
    cosine = (z + 1 / z) / 2
    weight = sp.expand(cosine * polynomial.subs(u, V * (1 - cosine)))
    top = 1
    if polynomial.has(u):
        top = int(sp.degree(polynomial, u)) + 1
    return [weight.coeff(z, k) * (2 if k else 1) for k in range(top + 1)]


def _averages(polynomial: Expr, coefficient: Callable[[int], Expr], u: Expr, V: Expr) -> Expr:
    """Return H[polynomial * g] from the Fourier coefficients of g.

    coefficient(k) = (1/pi) integral_0^pi g(V (1 - cos(theta))) cos(k theta) dtheta.
    """
    return 2 / V * sp.Add(*[w * coefficient(k) for k, w in enumerate(_cosine_coefficients(polynomial, u, V))])


# -- powers and rational functions -----------------------------------------------------------------


def _power_moment(p: Expr, V: Expr) -> Expr:
    """Return the harmonic average of v^p, p > -1/2."""
    factor = -(2 ** (p + 1)) * V ** (p - 1) / sp.sqrt(sp.pi)
    return factor * p * sp.gamma(p + _HALF) / sp.gamma(p + 2)


def _rational(polynomial: Expr, factors: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average residues at the roots of factors of degree 1 and 2, real for complex roots too."""
    parts = partial_fractions(polynomial * factors, u)
    if parts is None:
        return None
    total = sp.Add(*[c * _power_moment(sp.Integer(n), V) for (n,), c in sp.Poly(parts[0], u).terms()])
    for numerator, (_, *b, c), power in parts[1]:
        A = sp.Poly(numerator, u).nth(1)
        B = sp.Poly(numerator, u).nth(0)
        if b:
            total += _average_over_quadratic(A, B, b[0], c, power, V)
        else:
            total += numerator * _average_over_linear(c, power, V)
    return total


def _average_over_linear(w: Expr, power: int, V: Expr) -> Expr:
    """Return H[1/(u + w)^power], w > 0."""
    if power == 1:
        root = sp.sqrt(w * (w + 2 * V))
        return 2 / (root * (root + w + V))
    x = sp.Dummy("w", positive=True)
    slope = sp.diff(2 * (x * (x + 2 * V)) ** sp.Rational(-3, 2), x, power - 2)
    return (sp.S.NegativeOne**power * slope / sp.factorial(power - 1)).subs(x, w)


def _average_over_quadratic(A: Expr, B: Expr, b: Expr, c: Expr, power: int, V: Expr) -> Expr:
    """Return H[(A u + B)/(u^2 + b u + c)^power]; the quadratic is positive on [0, 2 V].

    Everything is rational in the roots p and q of its values at 0 and 2 V, and in t = (p + q)/sqrt(2 w),
    w = p (p + q) + b V, where dt/dc = t (1 - t^2)/(2 p q); q = p (2 t^2 - 1) for b = 0. The same formula holds for
    real, double and complex zeros.
    """
    p, q, t, w = (sp.Dummy(name, positive=True) for name in "pqtw")
    other: Expr = q
    if b == 0:
        other = p * (2 * t**2 - 1)
    value = A * (4 / (w * (t + 1)) - 4 * t / (q * (p + q))) + 4 * B * t * (b + 2 * V) / (p * q * (p + q) ** 2)
    if b == 0 or power > 1:
        value = sp.factor(value.subs(w, (p + q) ** 2 / (2 * t**2)).subs(q, other))
    for k in range(1, power):
        slope = sp.diff(value, p) / p + sp.diff(value, q) / q + t * (1 - t**2) / (p * q) * sp.diff(value, t)
        value = sp.factor(-slope.subs(q, other) / (2 * k))
    low = sp.sqrt(c)
    high = sp.sqrt(c + 2 * b * V + 4 * V**2)
    between = low * (low + high) + b * V
    value = value.subs(2 * t**2 - 1, high / low)
    return value.subs({p: low, q: high, w: between, t: (low + high) / sp.sqrt(2 * between)}, simultaneous=True)


def _power(polynomial: Expr, node: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n u^p, p > -1/2, and u^n (a u + b)^p by Gauss's hypergeometric function."""
    match = as_power(node, u)
    if match is None:
        return None
    _, rate, shift, p = match
    x = sp.Dummy("x")
    terms = sp.Poly(sp.expand(polynomial.subs(u, (x - shift) / rate)), x).terms()
    return sp.Add(*[c * _shifted_power(rate, shift, p + n, V) for (n,), c in terms])


def _shifted_power(rate: Expr, shift: Expr, p: Expr, V: Expr) -> Expr:
    """Return H[(rate u + shift)^p]; complete elliptic integrals for p = 1/2."""
    if shift == 0:
        return rate**p * _power_moment(p, V)
    r = V * rate / shift
    if p == _HALF:
        m = 2 * r / (1 + 2 * r)
        elliptic = (m - 2) * sp.elliptic_e(m) + 2 * (1 - m) * sp.elliptic_k(m)
        return 4 * sp.sqrt(shift * (1 + 2 * r)) * elliptic / (3 * sp.pi * V * m)
    return -p * rate * shift ** (p - 1) * sp.hyper((1 - p, sp.Rational(3, 2)), (3,), -2 * r)


# -- hypergeometric series -------------------------------------------------------------------------


def _series(polynomial: Expr, factors: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average a polynomial times a hypergeometric series: the same series with the moments of the weight appended.

    That is exp(-k u^d), d = 1/2, 1 or 2, u^q (1 + k u^d)^p, d a whole number, erf(k u), or sin(k u)/u. For other
    d of the exponential such series are of no use: mpmath has no asymptotic series for 3F3 and above, and for
    d = a/b with b > 1 the parts cancel about 0.43 (2 V/w)^d digits.
    """
    # front u^q pFq(upper; lower; z u^d)
    q = sp.S.Zero
    upper: list[Expr] = []
    lower: list[Expr] = []
    d: Expr = sp.Integer(2)
    if (stretched := as_stretched(factors, u)) is not None:
        front, q, k, d = stretched
        z = -k
        known = d in (_HALF, 1, 2)
    elif (binomial := as_binomial(factors, u)) is not None:
        q, b, a, d, p = binomial
        front = b**p
        upper = [-p]
        z = -a / b
        known = d.is_Integer
    elif (rate := _rate_of_sinc(factors, u)) is not None:
        front = rate
        lower = [3 * _HALF]
        z = -(rate**2) / 4
        known = True
    else:
        line = argument_coefficients(factors, sp.erf, u)
        known = len(line) == 2 and line[1] == 0
        q = sp.Integer(1)
        upper = [_HALF]
        lower = [3 * _HALF]
        z = -(line[0] ** 2) if known else sp.S.Zero
        front = 2 * sp.sqrt(-z / sp.pi)
    if not known:
        return None
    terms = sp.Poly(polynomial, u).terms()
    return front * sp.Add(*[c * _average_of_series(q + n, upper, lower, z, d, V) for (n,), c in terms])


def _rate_of_sinc(factors: Expr, u: Expr) -> Expr | None:
    """Return k of sin(k u)/u, or None."""
    sine = factors * u
    line = argument_coefficients(sine, sp.sin, u)
    if len(line) == 2 and line[1] == 0:
        return line[0]
    return None


def _average_of_series(q: Expr, upper: list[Expr], lower: list[Expr], z: Expr, d: Expr, V: Expr) -> Expr:
    """Average u^q pFq(upper; lower; z u^d), d = a/b: the sum over every b-th power of z, for b first powers."""
    a = int(d.p)
    b = int(d.q)
    total = sp.S.Zero
    for start in range(b):
        first = b if q == 0 and start == 0 else start  # H[u^0] = 0
        p = q + d * first
        above = [(x + first + i) / b for x in upper for i in range(b)] + [sp.Integer(1)]
        above += [(p + _HALF + i) / a for i in range(a)] + [p / a + 1]
        below = [(x + first + i) / b for x in [*lower, sp.Integer(1)] for i in range(b)]
        below += [(p + 2 + i) / a for i in range(a)] + [p / a]
        ratio = sp.Mul(*[sp.rf(x, first) for x in upper], *[1 / sp.rf(x, first) for x in lower])
        argument = z**b * (2 * V) ** a * sp.Integer(b) ** (b * (len(upper) - len(lower) - 1))
        total += ratio * z**first / sp.factorial(first) * _power_moment(p, V) * sp.hyper(above, below, argument)
    return total


# -- functions -------------------------------------------------------------------------------------


def _bessel(polynomial: Expr, node: Expr, line: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Average u^n f(a u + b), f = exp, sin or cos; of the modified functions orders 0 and 1 are left."""
    rate, shift = line
    if not isinstance(node, sp.exp | sp.sin | sp.cos):
        return None

    def coefficient(k: int) -> Expr:
        if isinstance(node, sp.exp):
            return sp.besseli(k, -rate * V)
        return sp.besselj(k, rate * V) * node.func(shift + rate * V - k * sp.pi / 2)

    average = _averages(polynomial, coefficient, u, V)
    if not isinstance(node, sp.exp):
        return average
    return sp.exp(shift + rate * V) * sp.expand(sp.expand_func(average))


def _damped_wave(polynomial: Expr, factors: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n exp(a u + c) cos(b u + d), or sin: the real part of the rule for exp((a + i b) u)."""
    match = as_damped_wave(factors, u)
    if match is None:
        return None
    _, wave, (a, c), (b, d) = match
    z = a + sp.I * b
    phase = c + sp.I * d
    part = sp.re if isinstance(wave, sp.cos) else sp.im
    return _averages(polynomial, lambda k: part(sp.exp(phase + z * V) * sp.besseli(k, -z * V)), u, V)


def _logarithm(polynomial: Expr, node: Expr, line: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Average u^n log(a u + b), b >= 0, and log(a u + b)^2; H[log(1 + a u)] = -2 a/(1 + a V + sqrt(1 + 2 a V)).

    The root of z (z + 2 V), z = b/a, is the one outside the circle of radius V. Written with a factored out it is
    the positive root for either sign of a. With coefficients -rho^k/k those of the square are a sum
    of rho^(2 k + 1)/(k (k + 1)).
    """
    (rate, shift) = line
    (_, power) = node.as_base_exp()
    if not shift.is_nonnegative or power > 2 or (power == 2 and polynomial.has(u)):
        return None
    root = sp.sqrt(shift * (shift + 2 * rate * V))
    reach = shift + rate * V + root
    rho = rate * V / reach
    mean = sp.log(sp.expand(reach) / 2)
    if power == 2:
        if shift != 0:
            rest = 1 + 2 * root * reach / (rate * V) ** 2 * sp.log(2 * root / reach)
        else:
            rest = sp.Integer(1)
        return polynomial * 4 / V * rho * (rest - mean)
    return _averages(polynomial, lambda k: -(rho**k) / k if k else mean, u, V)


def _arctangent(polynomial: Expr, node: Expr, line: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Average u^n atan(a u + b): the imaginary part of the rule for the logarithm of u + x + i y."""
    rate, shift = line
    if node.is_Pow or (rate.is_nonnegative is None and shift != 0):
        return None
    # SymPy writes atan(u/w - a) as -atan(a - u/w); the arctangent is odd.
    size = sp.Abs(rate)
    sign = rate / size
    if rate.is_nonnegative is not None:
        sign = sp.S.One if rate.is_nonnegative else sp.S.NegativeOne
        size = sign * rate
    return sign * _average_of_complex_logarithm(
        polynomial, shift / rate, 1 / size, lambda p, q: sp.atan(p / q), lambda p, q: q, u, V
    )


def _logarithm_of_quadratic(polynomial: Expr, node: Expr, quadratic: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Average u^n log(a u^2 + b u + c), complex roots: twice the real part of that of u + x + i y."""
    a, b, c = quadratic
    square = minus_discriminant(b / a, c / a) / 4
    if node.is_Pow or not (a.is_positive and square.is_positive):
        return None

    def mean(p: Expr, q: Expr) -> Expr:
        return sp.log(a * (p**2 + q**2) / 4)

    return _average_of_complex_logarithm(polynomial, b / (2 * a), sp.sqrt(square), mean, lambda p, q: -2 * p, u, V)


_Share = Callable[[Expr, Expr], Expr]


def _average_of_complex_logarithm(
    polynomial: Expr, x: Expr, y: Expr, mean: _Share, share: _Share, u: Expr, V: Expr
) -> Expr:
    """Average by the Fourier coefficients of log(u + x + i y), y > 0: -(z + V - r)^k/(k V^k), r^2 = z (z + 2 V).

    Of the zeroth, of z + V + r, `mean` gives the part that is needed, of the others' powers, without -, `share`.
    """
    square = x**2 - y**2 + 2 * V * x
    size = sp.sqrt((x**2 + y**2) * ((x + 2 * V) ** 2 + y**2))
    imaginary = sp.sqrt((size - square) / 2)
    real = y * (x + V) / imaginary
    P = sp.Dummy("P", real=True)
    Q = sp.Dummy("Q", real=True)

    def coefficient(k: int) -> Expr:
        if k == 0:
            return mean(x + V + real, y + imaginary)
        power = share(*((P + sp.I * Q) ** k).expand().as_real_imag())
        return power.subs({P: x + V - real, Q: y - imaginary}, simultaneous=True) / (k * V**k)

    return _averages(polynomial, coefficient, u, V)


def _asinh(polynomial: Expr, node: Expr, line: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Average asinh(a u + b) by complete elliptic integrals of the second and third kind.

    The substitution 1 + s = (1 - l) (1 - cn)/(1 + l cn), l = (A - B)/(A + B), leads there.
    """
    rate, shift = line
    if node.is_Pow or polynomial.has(u):
        return None
    A = sp.sqrt(1 + (shift + 2 * V * rate) ** 2)
    B = sp.sqrt(1 + shift**2)
    n = -((A - B) ** 2) / (4 * A * B)
    m = n + (rate * V) ** 2 / (A * B)
    elliptic = (1 - n) * sp.elliptic_pi(n, m) - sp.elliptic_e(m)
    return -4 * polynomial * sp.sqrt(A * B) / (sp.pi * rate * V**2) * elliptic


# -- pieces ----------------------------------------------------------------------------------------


def average_of_pieces(pieces: list[Expr], ends: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Return H of a term that is a polynomial in u, and in 1/u but on the first piece, i from end i to i + 1."""
    theta = sp.Dummy("theta", real=True)
    t = sp.Dummy("t")
    zero = sp.S.Zero
    primitives = [zero]
    for number, piece in enumerate(pieces):
        polynomial = zero
        inverse = zero
        for term in sp.Add.make_args(sp.expand(piece)):
            if term.is_polynomial(u):
                polynomial += term
                continue
            constant, varying = term.as_independent(u, as_Add=False)
            base, n = varying.as_base_exp()
            if base != u or not n.is_Integer or number == 0:
                return None
            inverse += constant * (2 * V) ** n * (t**2 - 1) * (1 + t**2) ** (-n - 2)
        mean, *weights = _cosine_coefficients(polynomial, u, V)
        # 1/u = (1 + t^2)/(2 V), cos(theta) = (t^2 - 1)/(t^2 + 1), dtheta = -2 dt/(1 + t^2), t = cot(theta/2).
        of_inverse = -2 * sp.integrate(inverse, t).subs(sp.atan(t), -theta / 2)
        primitives.append(
            mean * theta + sp.Add(*[w * sp.sin(k * theta) / k for k, w in enumerate(weights, 1)]) + of_inverse
        )
    total = zero
    for end, (before, after) in zip(ends, pairwise([*primitives, zero]), strict=True):
        jump = sp.expand(before - after)
        angle = sp.pi
        if end != 2 * V:
            angle = sp.acos(1 - end / V)
        total += (jump.subs(t, sp.sqrt(2 * V / end - 1)) if jump.has(t) else jump).subs(theta, angle)
    return 2 / (sp.pi * V) * total


_RULES = (
    Rule("residues", None, _rational),
    Rule("Bessel functions", ((sp.exp, sp.sin, sp.cos),), _bessel, degree=1),
    Rule("Bessel functions of a complex argument", None, _damped_wave),
    Rule("Fourier coefficients of the logarithm", (sp.log,), _logarithm, degree=1),
    Rule("Fourier coefficients of the arctangent", (sp.atan,), _arctangent, degree=1),
    Rule("Fourier coefficients of the logarithm of a quadratic", (sp.log,), _logarithm_of_quadratic, degree=2),
    Rule("complete elliptic integrals", (sp.asinh,), _asinh, degree=1),
    Rule("Beta function", (sp.Pow,), _power),
    Rule("hypergeometric series", None, _series),
)

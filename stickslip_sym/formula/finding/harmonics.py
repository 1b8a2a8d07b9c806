"""The harmonic criterion of a term of a law, one rule for each family of terms.

With H[g] = 2/(pi V) * integral_0^pi g(V (1 - cos(theta))) cos(theta) dtheta the criterion is c = N H[mu]. A rule
takes (rest, u, V) and returns H[rest], real for V > 0, or None where it does not apply. The weight of
the slope is that of a Beta(3/2, 3/2) distribution, H[g] = -E[g'(2 V X)]: from its moments come the powers and
the hypergeometric series, from residues the rational functions, and from Fourier coefficients the rest. The rule
of hypergeometric series serves polynomial weights too, where no antiderivative is known.
"""

from collections.abc import Callable
from dataclasses import dataclass

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.formula.finding.matching import (
    as_function,
    as_power,
    as_single,
    as_stretched,
    first_rule,
    minus_discriminant,
    partial_fractions,
)

__all__ = ["harmonic_average", "kinked_polynomial_average", "series_average"]

_HALF = sp.Rational(1, 2)


def harmonic_average(rest: Expr, u: Expr, V: Expr) -> tuple[str, Expr] | None:
    """Return the name of the rule that averages a term and H[rest], or None."""
    return first_rule(_RULES, rest, u, V)


def _power_moment(p: Expr, V: Expr) -> Expr:
    """Return H[u^p], p > -1/2."""
    factor = -(2 ** (p + 1)) * V ** (p - 1) / sp.sqrt(sp.pi)
    return factor * p * sp.gamma(p + _HALF) / sp.gamma(p + 2)


def _polynomial_moment(polynomial: Expr, p: Expr, u: Expr, V: Expr) -> Expr:
    """Return H[polynomial * u^p]."""
    return sp.Add(*[c * _power_moment(p + n, V) for (n,), c in sp.Poly(polynomial, u).terms()])


def _averages(polynomial: Expr, coefficient: Callable[[int], Expr], u: Expr, V: Expr) -> Expr:
    """Return H[polynomial * g] from the Fourier coefficients of g.

    coefficient(k) = (1/pi) integral_0^pi g(V (1 - cos(theta))) cos(k theta) dtheta.
    """
    z = sp.Dummy("z")  # exp(i theta)
    cosine = (z + 1 / z) / 2
    weight = sp.expand(cosine * polynomial.subs(u, V * (1 - cosine)))
    top = int(sp.degree(polynomial, u)) + 1 if polynomial.has(u) else 1
    weights = {k: weight.coeff(z, k) * (1 if k == 0 else 2) for k in range(top + 1)}
    return 2 / V * sp.Add(*[weights[k] * coefficient(k) for k in weights])


def _rational(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average residues at the roots of factors of degree 1 and 2, real for complex roots too."""
    parts = partial_fractions(rest, u)
    if parts is None:
        return None
    polynomial, fractions = parts
    total = _polynomial_moment(polynomial, sp.Integer(0), u, V)
    for numerator, base, power in fractions:
        coefficients = sp.Poly(base, u).all_coeffs()
        if len(coefficients) == 2:
            total += numerator * _linear_residue(coefficients[1], power, V)
        else:
            A = sp.Poly(numerator, u).coeff_monomial(u)
            B = sp.Poly(numerator, u).coeff_monomial(1)
            b, c = coefficients[1:]
            if b == 0:
                total += _lorentzian_residue(A, B, sp.sqrt(c), power, V)
            else:
                total += _quadratic_residue(A, B, b, c, power, V)
    return total


def _linear_residue(w: Expr, power: int, V: Expr) -> Expr:
    """Return H[1/(u + w)^power], w > 0."""
    if power == 1:
        root = sp.sqrt(w * (w + 2 * V))
        return 2 / (root * (root + w + V))
    x = sp.Dummy("w", positive=True)
    cubed = 2 * (x * (x + 2 * V)) ** sp.Rational(-3, 2)
    return ((-1) ** power * sp.diff(cubed, x, power - 2) / sp.factorial(power - 1)).subs(x, w)


def _lorentzian_residue(A: Expr, B: Expr, width: Expr, power: int, V: Expr) -> Expr:
    """Return H[(A u + B)/(u^2 + y^2)^power], y = width > 0.

    Everything is rational in V, y and h = sqrt((1 + q)/2), q = sqrt(1 + 4 V^2/y^2), with the derivative
    dh/dy = -h (h^2 - 1)/(y q).
    """
    h, y = sp.Dummy("h", positive=True), sp.Dummy("y", positive=True)
    q = 2 * h**2 - 1
    value = 2 * (A * (h**2 - h - 1) / (y**2 * h**2 * (h + 1)) + B * V / (y**4 * h**3)) / q
    for k in range(1, power):
        slope = sp.diff(value, y) - h * (h**2 - 1) / (y * q) * sp.diff(value, h)
        value = sp.factor(-slope / (2 * k * y))
    root = sp.sqrt(1 + 4 * V**2 / width**2)
    return value.subs({q: root, h: sp.sqrt((1 + root) / 2), y: width})


def _quadratic_residue(A: Expr, B: Expr, b: Expr, c: Expr, power: int, V: Expr) -> Expr:
    """Return H[(A u + B)/(u^2 + b u + c)^power]; the quadratic is positive on [0, 2 V].

    The same formula holds for real, double and complex roots.
    """
    x = sp.Dummy("c", positive=True)
    rho = sp.sqrt(x * (x + 2 * b * V + 4 * V**2))  # root of Q(0) Q(2 V)
    low = rho + x + b * V
    high = low + 2 * V**2
    tau = sp.sqrt(high / low)
    of_one = 2 * tau * (b + 2 * V) / (rho * high)
    of_u = 4 / (low * (tau + 1)) - 2 * tau * (rho + x) / (rho * high)
    value = sp.diff(A * of_u + B * of_one, x, power - 1)
    return ((-1) ** (power - 1) * value / sp.factorial(power - 1)).subs(x, c)


def _power(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n u^p, p > -1/2, and u^n (a u + b)^p by Gauss's hypergeometric function."""
    match = as_power(rest, u)
    if match is None:
        return None
    polynomial, _, rate, shift, p = match
    if shift == 0:
        return rate**p * _polynomial_moment(polynomial, p, u, V)
    x = sp.Dummy("x")
    terms = sp.Poly(sp.expand(polynomial.subs(u, (x - shift) / rate)), x).terms()
    return sp.Add(*[c * _shifted_power(rate, shift, p + n, V) for (n,), c in terms])


def _shifted_power(rate: Expr, shift: Expr, p: Expr, V: Expr) -> Expr:
    """Return H[(rate u + shift)^p]; complete elliptic integrals for p = 1/2."""
    r = V * rate / shift
    if p == _HALF:
        m = 2 * r / (1 + 2 * r)
        elliptic = (m - 2) * sp.elliptic_e(m) + 2 * (1 - m) * sp.elliptic_k(m)
        return 4 * sp.sqrt(shift * (1 + 2 * r)) * elliptic / (3 * sp.pi * V * m)
    return -p * rate * shift ** (p - 1) * sp.hyper((1 - p, sp.Rational(3, 2)), (3,), -2 * r)


def _exponential(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n exp(a u + b), modified Bessel functions of -a V, order 0 and 1."""
    match = as_function(rest, u, sp.exp)
    if match is None:
        return None
    polynomial, _, rate, shift = match
    z = sp.Dummy("z", positive=True)
    even, odd = sp.Integer(0), sp.Integer(1)  # exp(-z) (even I_0(z) + odd I_1(z))
    total, done = sp.Integer(0), 0
    for (n,), c in sorted(sp.Poly(polynomial, u).terms()):
        for _ in range(n - done):
            even, odd = (
                sp.expand(sp.diff(even, z) - even + odd),
                sp.expand(sp.diff(odd, z) - odd + even - odd / z),
            )
        done = n
        total += c * (-V) ** n * (even * sp.besseli(0, z) + odd * sp.besseli(1, z))
    return 2 / V * sp.exp(shift + rate * V) * sp.expand(total).subs(z, -rate * V)


def _sine(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """u^n sin(a u + b) and u^n cos(a u + b): Bessel functions."""
    for function in (sp.sin, sp.cos):
        match = as_function(rest, u, function)
        if match is None:
            continue
        polynomial, _, rate, shift = match
        phase = shift + rate * V

        def coefficient(k: int, rate: Expr = rate, phase: Expr = phase, function: Expr = function) -> Expr:
            return sp.besselj(k, rate * V) * function(phase - k * sp.pi / 2)

        return _averages(polynomial, coefficient, u, V)
    return None


def _log(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n log(a u + b), b >= 0; H[log(1 + a u)] = -2 a/(1 + a V + sqrt(1 + 2 a V)).

    The root of z (z + 2 V), z = b/a, is the one outside the circle of radius V. Written with a factored out it is
    the positive root for either sign of a.
    """
    match = as_function(rest, u, sp.log)
    if match is None or not match[3].is_nonnegative:
        return None
    polynomial, _, rate, shift = match
    reach = shift + rate * V + sp.sqrt(shift * (shift + 2 * rate * V))

    def coefficient(k: int) -> Expr:
        return sp.log(sp.expand(reach) / 2) if k == 0 else -((rate * V / reach) ** k) / k

    return _averages(polynomial, coefficient, u, V)


def _atan(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n atan(a u + b), a > 0: the imaginary part of the rule for the logarithm of u + x + i y."""
    match = as_function(rest, u, sp.atan)
    if match is None:
        return None
    polynomial, _, rate, shift = match
    if rate.is_negative:  # SymPy writes atan(u/w - a) as -atan(a - u/w)
        polynomial, rate, shift = -polynomial, -rate, -shift
    x, y = shift / rate, 1 / rate
    real, imaginary = _complex_root(x, y, V)

    def coefficient(k: int) -> Expr:
        if k == 0:
            return sp.atan((x + V + real) / (y + imaginary))
        return _complex_power(x + V - real, y - imaginary, k)[1] / (k * V**k)

    return _averages(polynomial, coefficient, u, V)


def _log_of_quadratic(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average u^n log(a u^2 + b u + c), complex roots: twice the real part of that of u + x + i y."""
    match = as_function(rest, u, sp.log, degree=2)
    if match is None:
        return None
    polynomial, _, a, b, c = match
    x, square = b / (2 * a), minus_discriminant(b / a, c / a) / 4
    if not (a.is_positive and square.is_positive):
        return None
    y = sp.sqrt(square)
    real, imaginary = _complex_root(x, y, V)

    def coefficient(k: int) -> Expr:
        if k == 0:
            return sp.log(a * ((x + V + real) ** 2 + (y + imaginary) ** 2) / 4)
        return -2 * _complex_power(x + V - real, y - imaginary, k)[0] / (k * V**k)

    return _averages(polynomial, coefficient, u, V)


def _complex_root(x: Expr, y: Expr, V: Expr) -> tuple[Expr, Expr]:
    """Return the real and the imaginary part of the root of z (z + 2 V), z = x + i y, y > 0."""
    square = x**2 - y**2 + 2 * V * x
    size = sp.sqrt((x**2 + y**2) * ((x + 2 * V) ** 2 + y**2))
    imaginary = sp.sqrt((size - square) / 2)
    return y * (x + V) / imaginary, imaginary


def _complex_power(p: Expr, q: Expr, k: int) -> tuple[Expr, Expr]:
    """Return the real and the imaginary part of (p + i q)^k."""
    P, Q = sp.Dummy("P", real=True), sp.Dummy("Q", real=True)
    parts = ((P + sp.I * Q) ** k).expand().as_real_imag()
    return tuple(part.subs({P: p, Q: q}, simultaneous=True) for part in parts)


def _asinh(rest: Expr, u: Expr, V: Expr) -> Expr | None:
    """Average asinh(a u + b) by complete elliptic integrals of the second and third kind.

    The substitution 1 + s = (1 - l) (1 - cn)/(1 + l cn), l = (A - B)/(A + B), leads there.
    """
    match = as_function(rest, u, sp.asinh)
    if match is None or match[0].has(u):
        return None
    constant, _, rate, shift = match
    A, B = sp.sqrt(1 + (shift + 2 * V * rate) ** 2), sp.sqrt(1 + shift**2)
    n = -((A - B) ** 2) / (4 * A * B)
    m = n + (rate * V) ** 2 / (A * B)
    elliptic = (1 - n) * sp.elliptic_pi(n, m) - sp.elliptic_e(m)
    return -4 * constant * sp.sqrt(A * B) / (sp.pi * rate * V**2) * elliptic


def series_average(rest: Expr, u: Expr, V: Expr, criterion: Criterion = harmonic) -> Expr | None:
    """Return the average of u^q f, f a hypergeometric series in u^d, a series with the weight's moments appended.

    f is exp(-k u^d), d = 1/2, 1 or 2 (the Gaussian is one 2F2), (1 + k u^d)^p, d a whole number, or erf(k u). For
    other d of the exponential such series are of no use: mpmath has no asymptotic series for 3F3 and above, and
    for d = a/b with b > 1 the parts cancel about 0.43 (2 V/w)^d digits.
    """
    single, stretched = as_single(rest, u), as_stretched(rest, u)
    q, front, upper, lower = sp.Integer(0), sp.Integer(1), [], []
    if stretched is not None:
        polynomial, q, k, d = stretched
        if d not in (_HALF, 1, 2):
            return None
        z = -k
    elif single is not None and single[1].is_Pow:
        polynomial, (base, p) = single[0], single[1].as_base_exp()
        powers = dict(sp.Poly(base, u).terms()) if base.is_polynomial(u) else {}
        (d,), z = max(powers, default=(0,)), -sp.cancel(base / (base.subs(u, 0) or 1) - 1)
        if p.has(u) or powers.keys() != {(0,), (d,)} or not z.could_extract_minus_sign():
            return None
        z, d, front, upper = z / u**d, sp.Integer(d), base.subs(u, 0) ** p, [-p]
    elif (match := as_function(rest, u, sp.erf)) is not None and match[3] == 0:
        polynomial, _, rate, _ = match
        q, d, z, front = sp.Integer(1), sp.Integer(2), -(rate**2), 2 * rate / sp.sqrt(sp.pi)
        upper, lower = [_HALF], [sp.Rational(3, 2)]
    else:
        return None
    terms = sp.Poly(polynomial, u).terms()
    return front * sp.Add(
        *[c * _moments(q + n, d, upper, lower, z, V, part) for (n,), c in terms for part in _parts(criterion)]
    )


def _moments(q: Expr, d: Expr, upper: list[Expr], lower: list[Expr], z: Expr, V: Expr, part: "_Part") -> Expr:
    """Average u^q pFq(upper; lower; z u^d), d = a/b: the sum over every b-th power of z, for b first powers."""
    a, b = int(d.p), int(d.q)
    total = sp.Integer(0)
    for start in range(b):
        first = b if q == 0 and start == 0 else start  # H[u^0] = 0
        p = q + d * first
        above = [(x + first + i) / b for x in upper for i in range(b)] + [sp.Integer(1)]
        above += [(p + x + i) / a for x in part.upper for i in range(a)] + [p / a + 1]
        below = [(x + first + i) / b for x in [*lower, sp.Integer(1)] for i in range(b)]
        below += [(p + x + i) / a for x in part.lower for i in range(a)] + [p / a]
        for parameter in list(above):
            if parameter in below:
                above.remove(parameter)
                below.remove(parameter)
        ratio = sp.Mul(*[sp.rf(x, first) for x in upper], *[1 / sp.rf(x, first) for x in lower])
        value = sp.hyper(above, below, z**b * (2 * V) ** a * sp.Integer(b) ** (b * (len(upper) - len(lower) - 1)))
        total += ratio * z**first / sp.factorial(first) * part.value(p, V) * value
    return total


@dataclass(frozen=True)
class _Part:
    """A part of a weight: the average of u^p is value(p, V), a ratio of Gammas of p + upper and p + lower."""

    upper: tuple[Expr, ...]
    lower: tuple[Expr, ...]
    value: Callable[[Expr, Expr], Expr]


def _parts(criterion: Criterion) -> list[_Part]:
    """Split a weight: the harmonic one is one part, a polynomial one a part for each power of 1 + s."""
    if not criterion.is_polynomial:
        return [_Part((_HALF,), (sp.Integer(2),), _power_moment)]

    def of_power(j: int, w: Expr) -> _Part:
        def value(p: Expr, V: Expr) -> Expr:
            return -p * w * 2 ** (p + j) * V ** (p - 1) / (p + j)

        return _Part((sp.Integer(j),), (sp.Integer(j + 1),), value)

    return [of_power(j, w) for (j,), w in criterion.from_rest.terms()]


def kinked_polynomial_average(pieces: list[Expr], ends: list[Expr], u: Expr, V: Expr) -> Expr | None:
    """Return H of a term that is a polynomial in u on each piece, piece i between ends i and i + 1."""
    if not all(piece.is_polynomial(u) for piece in pieces):
        return None
    theta = sp.Dummy("theta", real=True)
    angles = [sp.acos(1 - end / V) for end in ends]
    total = sp.Integer(0)
    for piece, low, high in zip(pieces, angles, angles[1:], strict=False):
        part = _cosine_primitive(piece.subs(u, V * (1 - sp.cos(theta))), theta)
        total += part.subs(theta, high) - part.subs(theta, low)
    return 2 / (sp.pi * V) * total


def _cosine_primitive(polynomial: Expr, theta: Expr) -> Expr:
    """Integrate polynomial * cos(theta), a polynomial in cos(theta), as a Fourier sum."""
    z = sp.Dummy("z")
    cosine = (z + 1 / z) / 2
    weight = sp.expand((polynomial * sp.cos(theta)).subs(sp.cos(theta), cosine))
    top = sp.degree(sp.together(weight).as_numer_denom()[1], z)
    total = weight.coeff(z, 0) * theta
    for k in range(1, int(top) + 1):
        total += 2 * weight.coeff(z, k) * sp.sin(k * theta) / k
    return total


_RULES = {
    "residues": _rational,
    "modified Bessel functions": _exponential,
    "Bessel functions": _sine,
    "Fourier coefficients of the logarithm": _log,
    "Fourier coefficients of the arctangent": _atan,
    "Fourier coefficients of the logarithm of a quadratic": _log_of_quadratic,
    "complete elliptic integrals": _asinh,
    "Beta function": _power,
    "hypergeometric series": series_average,
}

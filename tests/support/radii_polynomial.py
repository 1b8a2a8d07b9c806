"""The orbit that grazes the belt's speed, proved to exist by a Newton-Kantorovich theorem in Fourier coefficients.

In units of the belt's speed and of sqrt(m/k), with v = 1 - w the velocity of the mass, W the orbit's frequency and
d = c/sqrt(k m), the slip solves  W v_t + q + N(v) = 0,  q_t = v/W,  N(v) = eta (mu(0) - mu(V w)) - d w.
Unknown are X = (W, d, v_k for k != 0).  The zeros of

    F_1 = sum v_k - 1,      F_2 = sum v_k/(i W k) - N_0,      F_k = (i W k + 1/(i W k)) v_k + N_k

are the slips that leave P and come back to P. With |v| = sum |v_k| nu^|k|, a numerical solution X and an
inverse A, nearly, of DF(X), let Y >= |A F(X)|, Z1 >= |1 - A DF(X)| and Z2 r >= |A (DF(X + h) - DF(X))| for
every h with |h| <= r <= R. If Y + (Z1 + Z2 r) r < r, one zero is within r of X, and one only (the radii
polynomial of Day, Lessard and Mischaikow, 2007). No code is shared with the package.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from flint import acb, acb_mat, acb_poly, arb, ctx, fmpq

MODES = 24
KEPT = 3 * MODES  # coefficients of a product on either side; the norm of those beyond is carried along
NU = arb(fmpq(5, 4))
LARGEST = arb(1e-6)  # the largest radius for which Z2 holds
BITS = 100
NEAR = arb(fmpq(3, 10))  # the touch, in which v is shown to be curved; elsewhere to be below 1


@dataclass(frozen=True)
class Series:
    """All functions whose Fourier coefficients are near those of a polynomial, within `rest` in the norm."""

    terms: acb_poly  # the coefficient of k stands at k + KEPT
    rest: arb

    @classmethod
    def of(cls, coefficients):
        """Return a series from a mapping of k to a number."""
        return cls(acb_poly([coefficients.get(k, 0) for k in range(-KEPT, KEPT + 1)]), arb(0))

    def __getitem__(self, k):
        inside = self.terms[k + KEPT] if abs(k) <= KEPT else acb(0)
        size = (self.rest / NU ** abs(k)).upper()
        return inside + acb(arb(0, 1) * arb(size), arb(0, 1) * arb(size))

    def __add__(self, other):
        other = other if isinstance(other, Series) else Series.of({0: acb(other)})
        return Series(self.terms + other.terms, self.rest + other.rest)

    def __mul__(self, other):
        if not isinstance(other, Series):
            return Series(self.terms * acb(other), self.rest * acb(other).abs_upper())
        product = self.terms * other.terms  # the coefficient of k stands at k + 2 KEPT
        kept = [product[k + 2 * KEPT] for k in range(-KEPT, KEPT + 1)]
        lost = sum(
            (size(product[k + 2 * KEPT], k) for k in range(-2 * KEPT, 2 * KEPT + 1) if abs(k) > KEPT), arb(0)
        )
        rest = self.polynomial_norm * other.rest + self.rest * (other.polynomial_norm + other.rest)
        return Series(acb_poly(kept), lost + rest)

    @property
    def polynomial_norm(self):
        return sum((size(self.terms[k + KEPT], k) for k in range(-KEPT, KEPT + 1)), arb(0))

    @property
    def norm(self):
        return self.polynomial_norm + self.rest

    def exp(self):
        """Return the exponential by its series, whose end is bounded by a geometric one."""
        total = term = Series.of({0: acb(1)})
        n = 0
        while not (term.norm < arb(2) ** -BITS and n > 2 * self.norm):
            n += 1
            term = term * self * (acb(1) / n)
            total = total + term
        return Series(total.terms, total.rest + term.norm)


def size(value, k):
    """Return a bound of a coefficient's part in the norm."""
    return value.abs_upper() * NU ** abs(k)


@dataclass(frozen=True)
class Exponential:
    """mu(0) - mu(V w) = D (1 - exp(-a w)) for the law (3)."""

    D: fmpq
    a: fmpq

    def of(self, w):
        """Return the function, its derivative, and a bound of its second in a ball of radius `LARGEST`."""
        decay = (w * -acb(self.a)).exp()
        most = arb(self.D * self.a**2) * decay.norm * (arb(self.a) * LARGEST).exp()
        return (decay + -1) * -acb(self.D), decay * acb(self.D * self.a), most

    def numbers(self, w):
        D, a = (float(x.p) / float(x.q) for x in (self.D, self.a))
        return D * (1 - np.exp(-a * w)), D * a * np.exp(-a * w)


@dataclass(frozen=True)
class Cubic:
    """mu(0) - mu(V w) = A w - B w^3 for the law (4)."""

    A: fmpq
    B: fmpq

    def of(self, w):
        square = w * w
        most = arb(6 * self.B) * (w.norm + LARGEST)
        return w * acb(self.A) + square * w * -acb(self.B), square * -acb(3 * self.B) + acb(self.A), most

    def numbers(self, w):
        A, B = (float(x.p) / float(x.q) for x in (self.A, self.B))
        return A * w - B * w**3, A - 3 * B * w**2


WAVES = [k for k in range(-MODES, MODES + 1) if k]


def numerical_orbit(friction, eta):
    """Return W, d and v_k for k from -MODES to MODES, by Newton's method from a harmonic motion."""
    k = np.array(WAVES)
    points = 8 * MODES
    W, d, v = 1.0, 0.27, np.where(abs(k) == 1, 0.5 + 0j, 0)
    for _ in range(40):
        full = np.zeros(points, complex)
        full[k] = v
        motion = (np.fft.ifft(full) * points).real
        value, slope = friction.numbers(1 - motion)
        N = np.fft.fft(eta * value - d * (1 - motion)) / points
        p = np.fft.fft(-eta * slope + d) / points
        lam = 1j * W * k + 1 / (1j * W * k)
        F = np.r_[v.sum() - 1, (v / (1j * W * k)).sum() - N[0], lam * v + N[k]]
        J = np.zeros((k.size + 2, k.size + 2), complex)
        J[0, 2:] = 1
        J[1, 0] = -(v / (1j * W**2 * k)).sum()
        J[1, 1] = 1
        J[1, 2:] = 1 / (1j * W * k) - p[-k]
        J[2:, 0] = (1j * k - 1 / (1j * W**2 * k)) * v
        J[2:, 1] = v
        J[2:, 2:] = np.diag(lam) + p[k[:, None] - k[None, :]]
        step = np.linalg.solve(J, F)
        W, d, v = W - step[0].real, d - step[1].real, v - step[2:]
        if abs(step).max() < 1e-15:
            break
    return W, d, v, np.linalg.inv(J)


@dataclass(frozen=True)
class Proof:
    """What the bounds gave."""

    damping: arb
    radius: arb
    Y: arb
    Z1: arb
    Z2: arb
    first_return: bool


def prove(friction, eta, shift=0.0):
    """Prove the grazing orbit; `damping` is a ball that holds d, and the radius is of all unknowns together.

    With `shift` the numerical solution has another damping, and nothing should be proved of it.
    """
    before, ctx.prec = ctx.prec, BITS
    try:
        return _prove(friction, eta, shift)
    finally:
        ctx.prec = before


def _prove(friction, eta, shift):
    W, d, v, inverse = numerical_orbit(friction, float(eta.p) / float(eta.q))
    W, d = arb(W), arb(d + shift)
    # With v_-k the conjugate of v_k so is the zero, as it is the only one near: it is a real motion.
    upward = {k: acb(z.real, z.imag) for k, z in zip(WAVES, v.tolist(), strict=True) if k > 0}
    v = {k: upward[k] if k > 0 else upward[-k].conjugate() for k in WAVES}
    motion = Series.of(v)
    w = motion * acb(-1) + 1
    value, slope, bend = friction.of(w)
    N = value * acb(eta) + w * acb(-d)
    p = slope * -acb(eta) + acb(d)
    lam = {k: acb(0, W * k) + 1 / acb(0, W * k) for k in range(-KEPT, KEPT + 1) if k}
    turn = {k: acb(0, k) - 1 / acb(0, W * W * k) for k in WAVES}  # the derivative of lam to W
    A = acb_mat([[acb(z.real, z.imag) for z in row] for row in inverse.tolist()])
    weights = [arb(1), arb(1), *(NU ** abs(k) for k in WAVES)]
    count = len(weights)

    def total(column):
        return sum((entry.abs_upper() * weight for entry, weight in zip(column, weights, strict=True)), arb(0))

    columns = [total([A[i, j] for i in range(count)]) for j in range(count)]  # |A e_j|, not over the weight of e_j
    tail = 1 / (W * (MODES + 1) - 1 / W)  # of 1/lam_k for |k| > MODES

    # Y
    F = [sum(v.values(), acb(-1)), sum((z / acb(0, W * k) for k, z in v.items()), -N[0])]
    F += [lam[k] * v[k] + N[k] for k in WAVES]
    step = A * acb_mat([[entry] for entry in F])
    beyond = sum((size(N.terms[k + KEPT], k) for k in range(-KEPT, KEPT + 1) if abs(k) > MODES), N.rest)
    Y = total([step[i, 0] for i in range(count)]) + tail * beyond

    # Z1, first the columns of the unknowns that were computed
    J = acb_mat(count, count)
    J[1, 0], J[1, 1] = -sum((z / acb(0, W * W * k) for k, z in v.items()), acb(0)), acb(1)
    for j, m in enumerate(WAVES, 2):
        J[0, j], J[1, j] = acb(1), 1 / acb(0, W * m) - p[-m]
        J[j, 0], J[j, 1] = turn[m] * v[m], v[m]
        for i, k in enumerate(WAVES, 2):
            J[i, j] = p[k - m] + (lam[k] if k == m else 0)
    left = A * J
    Z1 = arb(0)
    for j in range(count):
        column = total([(1 if i == j else 0) - left[i, j] for i in range(count)])
        Z1 = Z1.max((column + (tail * p.norm * weights[j] if j > 1 else 0)) / weights[j])
    # ... then those of v_m for |m| > MODES, of which each row sees what p carries, and the first all
    for m in range(MODES + 1, KEPT + MODES + 2):
        for sign in (1, -1):
            seen = [columns[0], columns[1] * (1 / (W * m) + p[-sign * m].abs_upper())]
            seen += [columns[i] * p[k - sign * m].abs_upper() for i, k in enumerate(WAVES, 2)]
            Z1 = Z1.max(sum(seen, arb(0)) / NU**m + tail * p.norm)
    farther = sum((c * (1 + p.norm) for c in columns), arb(0)) / NU ** (KEPT + 2)  # p_k <= |p| for those beyond
    Z1 = Z1.max(farther + tail * p.norm)

    # Z2
    low = W - LARGEST
    wide = [abs(k) + 1 / (low * low * abs(k)) for k in WAVES]  # of the derivative of lam
    most, stretched = tail, (1 + 1 / (low * low)) / low / (1 - 1 / (low * low * (MODES + 1) ** 2))
    for c, t, weight in zip(columns[2:], wide, weights[2:], strict=True):
        most, stretched = most.max(c / weight), stretched.max(c * t / weight)
    curved = 2 / low**3 * (motion.norm + LARGEST)
    changes = arb(eta) * bend + 1
    Z2 = 2 * stretched + most * (curved + changes + 1) + columns[1] * (2 / low**2 + curved + changes + 1)

    # Y + Z1 r + Z2 r^2 < r
    radius = arb((2 * Y / (1 - Z1)).upper())
    if not (radius < LARGEST and Y + (Z1 + Z2 * radius) * radius < radius):
        raise ArithmeticError(f"no radius: Y = {Y}, Z1 = {Z1}, Z2 = {Z2}")
    ball = arb(0, 1) * radius
    return Proof(d + ball, radius, Y, Z1, Z2, _touches_once(v, radius))


def _touches_once(v, radius):
    """Return whether v < 1 but at t = 0: it is curved downwards there, and lower elsewhere."""

    def over(span, order):
        terms = (z * acb(0, k) ** order * acb(0, k * span).exp() for k, z in v.items())
        # A coefficient may be off by r nu^-k, and k^2 nu^-k is at most 4/(e log(nu))^2.
        off = radius * 4 / (arb(1).exp() * NU.log()) ** 2
        return sum((term.real for term in terms), arb(0)) + arb(0, 1) * arb(off.upper())

    ends = [NEAR + (2 * arb.pi() - 2 * NEAR) * i / 400 for i in range(401)]
    spans = [one.union(other) for one, other in pairwise(ends)]
    close = [(NEAR * i / 16).union(NEAR * (i + 1) / 16) for i in range(-16, 16)]
    return all(over(span, 0) < 1 for span in spans) and all(over(span, 2) < 0 for span in close)

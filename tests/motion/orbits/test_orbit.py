"""Grazing orbits against collocation in mpmath, which shares no code with them."""

import mpmath
import numpy as np

import stickslip_sym as ss
from support.sweeps import sweep

DIGITS = 45
EXACT = 1e-12
POINTS = [
    ("exponential", 0.5, 100.0), ("exponential", 0.05, 1.0), ("exponential", 1.2, 1e6),
    ("polynomial", 0.5, 100.0), ("polynomial", 0.3, 10.0), ("polynomial", 1.2, 1e6),
    ("hyperbolic", 0.5, 100.0), ("gaussian", 0.4, 30.0), ("lorentzian", 0.5, 100.0), ("arctangent", 0.5, 100.0),
    ("sech", 0.6, 100.0), ("kragelskii", 0.5, 100.0),
]  # fmt: skip


def orbit_damping(law, V, k, N=9.81, m=1.0, **options):
    return ss.pure_slip_damping(law, V=V, N=N, m=m, k=k, method="orbit", **({"rtol": 1e-12} | options)).value


def collocated(law, V, k, points, N=9.81):
    """Solve the same orbit from its equation of the second order, on an odd number of points from the graze on.

    Newton's method in double precision first, then with residuals of 45 digits and the same Jacobian.
    """
    theta = 2 * np.pi * np.arange(points) / points
    impedance = mpmath.sqrt(k)
    e = mpmath.mpf(N) / impedance
    far = np.subtract.outer(np.arange(points), np.arange(points))
    with np.errstate(divide="ignore"):
        D = np.where(far == 0, 0.0, 0.5 * (-1.0) ** far / np.sin(np.pi * far / points))

    def jacobian(z, pace, d, push):
        J = np.zeros((points + 2, points + 2))
        slope = -float(e) * law.slope(V * np.maximum(1 - z, 0.0)) - d
        J[:points, :points] = pace**2 * D @ D + np.eye(points) - pace * D * slope
        J[:points, points] = 2 * pace * (D @ D @ z) - D @ push
        J[:points, points + 1] = pace * (D @ z)
        J[points, 0], J[points + 1, :points] = 1, D[0]
        return J

    z, pace, d = np.cos(theta), 1.0, float(e) * 0.5
    for _ in range(8):
        push = float(e) / V * law.mu(V * np.maximum(1 - z, 0.0)) - d * z
        residual = np.append(pace**2 * D @ (D @ z) + z - pace * D @ push, [z[0] - 1, D[0] @ z])
        step = np.linalg.solve(jacobian(z, pace, d, push), residual)
        z, pace, d = z - step[:points], pace - step[points], d - step[points + 1]
    mu = law.function("mpmath")
    x = [mpmath.mpf(value) for value in (*z.tolist(), float(pace), float(d))]
    for _ in range(4):
        with mpmath.workdps(DIGITS):
            first = [mpmath.mpf((-1) ** j) / (2 * mpmath.sin(mpmath.pi * j / points)) for j in range(1, points)]
            kernel = [
                mpmath.mpf(0),
                *first,
            ]  # its sign alternates around the circle, as the number of points is odd
            rows = [[kernel[i - j] if i >= j else -kernel[j - i] for j in range(points)] for i in range(points)]
            z, pace, d = x[:points], x[points], x[points + 1]
            push = [e / V * mu(V * (1 - value)) - d * value for value in z]
            z_theta = [mpmath.fdot(row, z) for row in rows]
            curved = [mpmath.fdot(row, z_theta) for row in rows]
            pushed = [mpmath.fdot(row, push) for row in rows]
            residual = [pace**2 * a + b - pace * g for a, b, g in zip(curved, z, pushed, strict=True)]
            residual += [z[0] - 1, z_theta[0]]
            size = max(abs(value) for value in residual) or mpmath.mpf(1)
            doubles = [np.array([float(value) for value in part]) for part in (z, push)]
            J = jacobian(doubles[0], float(pace), float(d), doubles[1])
            change = np.linalg.solve(J, [float(value / size) for value in residual])
            x = [value - size * mpmath.mpf(step) for value, step in zip(x, change.tolist(), strict=True)]
    with mpmath.workdps(DIGITS):
        return x[-1] * impedance


@sweep(("name", "V", "k"), POINTS, POINTS[0], POINTS[4], POINTS[7])
def test_orbit_is_that_of_45_digit_collocation(name, V, k):
    law = ss.laws.catalogue[name].typical()
    with mpmath.workdps(DIGITS):
        reference = collocated(law, V, k, 81)
        assert abs(orbit_damping(law, V, k) / reference - 1) < EXACT

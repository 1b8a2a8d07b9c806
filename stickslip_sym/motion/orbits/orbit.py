"""Pure-slip orbits of a given height, by spectral collocation and Newton's method.

With time in 1/omega and z = x'/V, slip obeys Lienard's equation

    z'' + (d - g(z)) z' + z = 0,    g(z) = -N mu'(V(1 - z))/sqrt(k m),    d = c/sqrt(k m).

Given the highest velocity A V, the unknowns are the Fourier coefficients of z from the second harmonic on, the
frequency, and d; the fundamental follows from z'(0) = 0 and z(0) = A. No orbit is higher elsewhere: where z' = 0
there is z'' = -z, so between two highest velocities lies a negative lowest one, and an orbit, which does not cross
itself, goes round its rest once. Two orbits that enclose each other cannot have the same damping and highest
velocity, since damping rotates the field of directions one way: d is a function of A. For A = 1 the orbit grazes
the belt's speed, and d is the pure-slip threshold.

Every term with friction enters as a small one, so weak friction loses no digits; nothing here knows a closed form.
How d changes with the law follows from the matrix of Newton's method.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg.lapack import dgesv

from stickslip_sym.core.aliases import ComplexArray, FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.core.numbers import EPSILON, ROOT_OF_ROUNDING
from stickslip_sym.criteria.rule import gauss_average
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.motion.orbits.expansion import damping_of_layer, fourier_coefficients, values

_COARSEST_GRID, _FINEST_GRID = 32, 192  # a period: twice as many each time; more take longer than a simulation
_MOST_NEWTON_STEPS = 10  # of Newton's method
_GRID_RATIO = 8  # times, the grid on which the lowest velocity is sought
_ROUNDING_OF_DAMPING = 16 * EPSILON  # of d, as a part of the largest slope


@dataclass(frozen=True)
class Orbits:
    """Slip orbits, one row for each operating point; all of shape (n,).

    - `d`: damping over sqrt(k m); NaN where there is no orbit.
    - `relative_error`: estimated error of d; infinite where d was not found, or is 0 but need not be.
    - `exponent`: Floquet exponent over omega, the mean of g(z) - d: the orbit is stable if it is negative.
    - `lowest`: lowest velocity z.
    - `changes`: how d/strength changes with the law in the direction of others, a column for each of them.
    """

    d: FloatArray
    relative_error: FloatArray
    exponent: FloatArray
    lowest: FloatArray
    changes: FloatArray


def orbits(
    law: BoundLaw, V: ArrayLike, strength: ArrayLike, A: ArrayLike = 1.0, *, rtol: float = 1e-13,
    added: Sequence[BoundLaw] = (),
) -> Orbits:  # fmt: skip
    """Return the pure-slip orbits of given height; what is not known of one that was not found is NaN.

    - `law`: smooth on the speeds of the orbit.
    - `V`: belt speeds in m/s.
    - `strength`: N/sqrt(k m) in m/s.
    - `A`: highest velocity over belt speed, at most 1.
    - `rtol`: relative error of d at which the grid is fine enough, where rounding allows.
    - `added`: the laws of `changes`.
    """
    V, strength, A = (np.ravel(column).astype(np.float64) for column in np.broadcast_arrays(V, strength, A))
    with np.errstate(all="ignore"):  # iterates that run away are given up
        harmonic = strength * gauss_average(law, V, A)[0]
        starts = [_Orbit.start(law, *point) for point in np.transpose([V, strength, A, harmonic]).tolist()]
        rows = np.reshape([_solved(start, rtol, added) for start in starts], (-1, 4 + len(added)))
    d, relative_error, exponent, lowest = rows[:, :4].T
    return Orbits(d, relative_error, exponent, lowest, rows[:, 4:])


# -- collocation -----------------------------------------------------------------------------------


def _solved(orbit: "_Orbit", rtol: float, added: Sequence[BoundLaw]) -> list[float]:
    """Solve by Newton's method, on a finer grid whenever that is done; return the row of an orbit."""
    longest = math.inf
    before = math.inf
    for _ in range(_MOST_NEWTON_STEPS):
        check_time()
        change, g, tail = orbit.improve()
        if not change < longest:
            break
        longest = 1.0  # a step as long as the orbit is high leads nowhere, but for the first
        d = orbit.d
        scale = max(float(np.abs(g).max()), abs(orbit.harmonic))
        error = scale * (tail + _ROUNDING_OF_DAMPING * len(g) / _COARSEST_GRID)
        enough = rtol * abs(d)
        finest = len(g) == _FINEST_GRID or tail <= _ROUNDING_OF_DAMPING
        gains = change < 0.1 * before
        before = change
        if change > ROOT_OF_ROUNDING and (finest or error <= enough or (change > tail and gains)):
            continue  # until the grid sets the error, which shows in steps that gain less than a digit too
        if finest or error <= enough:
            error += orbit.unseen()
        if finest or error <= enough:
            relative = error / abs(d) if d else math.inf if error else 0.0
            velocity = orbit.velocity
            changes = orbit.changes(added) if added else ()
            return [d, relative, float(orbit.g(velocity).mean()) - d, orbit.lowest, *changes]
        orbit = orbit.on(min(2 * len(g), _FINEST_GRID))
        before = math.inf
    return [np.nan, np.inf, np.nan, np.nan] + [np.nan] * len(added)


def _tail(size: FloatArray) -> float:
    """Estimate the size of the coefficients that fold back into the first.

    From the decay over the last octave: right for a power of the order, too large for a geometric decay.
    """
    K = len(size) - 1
    last = float(size[(4 * K) // 5 :].max())
    before = float(size[(2 * K) // 5 : K // 2].max())
    return last * min(1.0, last / before) if before else last


def _real_and_imaginary_parts(rows: ComplexArray) -> FloatArray:
    """Return the real parts of rows and then the imaginary ones."""
    return np.concatenate([rows.real, rows.imag])


@dataclass
class _Orbit:
    """An iterate: z_n for n = 0 to K (z_1 follows from A), d, and sigma = frequency - 1/frequency.

    The grid has 2 (K + 1) points a period, the midpoints of cells of the phase. The damping by harmonic balance is
    from slopes at every scale, over sqrt(k m).
    """

    law: BoundLaw
    V: float
    strength: float
    A: float
    harmonic: float
    z: ComplexArray
    d: float
    sigma: float = 0.0

    @classmethod
    def start(cls, law: BoundLaw, V: float, strength: float, A: float, harmonic: float) -> "_Orbit":
        """Return the harmonic motion on the coarsest grid that misses nothing of the law, or on the finest."""
        size = _COARSEST_GRID
        orbit = cls(law, V, strength, A, harmonic, np.array([0, A / 2 + 0j]), harmonic).on(size)
        while size < _FINEST_GRID and not orbit.sees():
            size = min(2 * size, _FINEST_GRID)
            orbit = orbit.on(size)
        return orbit

    def sees(self) -> bool:
        """Whether the grid meets every narrow piece of the law's table within the orbit's speeds."""
        low = self.V * (1 - self.A)
        high = self.V * (1 - self.lowest)
        return bool(self.law.table.resolved(low, high, len(self.z)))

    @property
    def velocity(self) -> FloatArray:
        """The velocity z on the grid."""
        return values(self.z)

    @property
    def lowest(self) -> float:
        """The lowest velocity, between the points of the grid too: that of a parabola on a finer one."""
        fine = self.on(_GRID_RATIO * 2 * len(self.z)).velocity
        left, middle, right = np.roll(fine, 1 - int(fine.argmin()))[:3]
        bend = left - 2 * middle + right
        return float(middle - (right - left) ** 2 / (8 * bend) if bend > 0 else middle)

    def on(self, size: int) -> "_Orbit":
        """Return the iterate on another grid."""
        return replace(self, z=np.pad(self.z, (0, size // 2 - len(self.z))))

    def g(self, velocity: FloatArray) -> FloatArray:
        """Return the slope g of friction at velocities; an iterate may overshoot the belt."""
        return -self.strength * self.law.at_speeds(self.V * np.abs(1 - velocity), derivative=True)

    def unseen(self) -> float:
        """Return what the grid may miss of d: that by harmonic balance, a layer at rest, or a narrow piece."""
        theta = (np.arange(2 * len(self.z)) + 0.5) * (np.pi / len(self.z))
        seen = 2 * float((self.g(self.A * np.cos(theta)) * np.sin(theta) ** 2).mean())
        V = np.array([self.V])
        strength = np.array([self.strength])
        if not self.sees():
            return math.inf
        layer = float(damping_of_layer(self.law, V, strength, len(self.z))[0]) if self.A == 1 else 0.0
        return abs(seen - self.harmonic) + layer

    def improve(self) -> tuple[float, FloatArray, float]:
        """Take a Newton step; return its size, g on the grid and the tail of the spectrum.

        Size and tail are relative to what friction does to an orbit of this height.
        """
        g = self.g(self.velocity)
        K = len(self.z) - 1
        strength = self.A * float(np.abs(g).max()) or 1.0
        matrix, residual, push = self.equations(g)
        # NumPy's own takes threads for a hundred unknowns, which wait for each other longer than they work.
        _, _, change, singular = dgesv(matrix, -residual)
        if singular:
            return math.inf, g, math.inf
        self.z[2:] += (change[: K - 1] - 1j * change[K - 1 : -2]) / 2
        self.d += float(change[-2])
        self.sigma += float(change[-1])
        n = np.arange(2, K + 1)
        self.z[1] = self.A / 2 - self.z[2:].real.sum() - 1j * (n * self.z[2:].imag).sum()  # z(0) = A, z'(0) = 0
        return float(np.abs(change).max()) / min(1.0, strength), g, _tail(push / strength)

    def changes(self, added: Sequence[BoundLaw]) -> FloatArray:
        """Return the derivatives of d: the equations are solved for what other slopes add to their right side."""
        velocity = self.velocity
        n = np.arange(1, len(self.z))
        rate = values(1j * np.arange(len(self.z)) * self.z)
        speed = self.V * np.abs(1 - velocity)
        pushes = [fourier_coefficients(-law.at_speeds(speed, derivative=True) * rate)[1:] / n**2 for law in added]
        matrix, _, _ = self.equations(self.g(velocity))
        return np.asarray(dgesv(matrix, _real_and_imaginary_parts(np.transpose(pushes)))[2][-2])

    def equations(self, g: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the balance of the harmonics 1 to K: its matrix, its residual, and the sizes of its right side.

        The matrix is the derivative of the residual, of real parts and then imaginary parts, by twice the real and
        minus twice the imaginary parts of z_2 to z_K, then d, then sigma. The sizes are those of the coefficients
        of (g - d) dz/dtheta.
        """
        size = len(g)
        K = len(self.z) - 1
        n = np.arange(1, K + 1)
        excess = g - self.d
        push = fourier_coefficients(excess * values(1j * np.arange(K + 1) * self.z))
        # The positive root of frequency - 1/frequency = sigma, and its inverse, without cancellation.
        root = np.hypot(1.0, self.sigma / 2) + abs(self.sigma) / 2
        fast, slow = (root, 1 / root) if self.sigma >= 0 else (1 / root, root)
        # Balance of the harmonic n: (1/(n^2 frequency) - frequency) z_n = push_n/n^2.
        detuned = slow / n**2 - fast
        detuned[0] = -self.sigma
        residual = detuned * self.z[1:] - push[1:] / n**2
        # The variation of the friction is the derivative of excess times that of z: no second slope is needed.
        spectrum = np.fft.fft(excess) * (np.exp(-1j * np.pi / size * np.arange(size)) / size)
        spectrum = np.concatenate([spectrum[K - 1 : 0 : -1].conj(), spectrum])  # from 1 - K up
        minus = spectrum[n[:, None] - n + K - 1]
        plus = spectrum[n[:, None] + n + K - 1]
        by_cosine = (minus + plus) / 2
        by_sine = (minus - plus) / 2j
        turn = (-1j / n)[:, None]
        m = n[1:]
        diagonal = np.arange(1, K)
        cosine = turn * (by_cosine[:, 1:] - by_cosine[:, :1])
        cosine[diagonal, diagonal - 1] += detuned[1:] / 2
        cosine[0] -= detuned[0] / 2
        sine = turn * (by_sine[:, 1:] - m * by_sine[:, :1])
        sine[diagonal, diagonal - 1] -= 0.5j * detuned[1:]
        sine[0] += 0.5j * m * detuned[0]
        by_fast = 1 / (1 + slow**2)
        by_sigma = ((by_fast - 1) / n**2 - by_fast) * self.z[1:]
        matrix = np.column_stack([cosine, sine, 1j * self.z[1:] / n, by_sigma])
        return _real_and_imaginary_parts(matrix), _real_and_imaginary_parts(residual), np.abs(push)

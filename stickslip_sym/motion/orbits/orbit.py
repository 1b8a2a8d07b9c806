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
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import ComplexArray, FloatArray
from stickslip_sym.core.deadline import check_time
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import Slope, averages, coefficients, expand, of_layer, slopes, values

_GRIDS = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024)  # points a period
_MOST_STEPS = 12  # of Newton's method on one grid
_CLOSE = 1e-8  # a step of Newton's method after which the next would be rounding
_ROUNDING = 4e-15  # of d, as a part of the largest slope
_RUNAWAY = 1e6  # a coefficient of z
_MOST_WORK = 3e9  # cubes of grids, summed over Newton steps
_NEAREST = 1e-12  # slip speed over belt speed that an iterate may come down to; it may overshoot the belt


@dataclass(frozen=True)
class Orbits:
    """Slip orbits, one row for each operating point; all of shape (n,).

    - `d`: damping over sqrt(k m); NaN where there is no orbit.
    - `error`: estimated error of d, as a part of `scale`, the largest slope g on the orbit.
    - `exponent`: Floquet exponent over omega, the mean of g(z) - d: the orbit is stable if it is negative.
    - `lowest`: lowest velocity z.
    """

    d: FloatArray
    error: FloatArray
    scale: FloatArray
    exponent: FloatArray
    lowest: FloatArray

    @property
    def relative_error(self) -> FloatArray:
        """Estimated error of d, relative; infinite where d was not found, or is 0 but need not be."""
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(self.error == 0, 0.0, self.error * self.scale / np.abs(self.d))
        return np.where(np.isnan(relative), np.inf, relative)


def orbits(
    law: FrictionLaw,
    V: ArrayLike,
    strength: ArrayLike,
    A: ArrayLike = 1.0,
    *,
    rtol: float = 1e-13,
    most_work: float = _MOST_WORK,
) -> Orbits:
    """Return the pure-slip orbits of given height; one that was not found has an infinite error.

    - `law`: with all parameters bound, smooth on the speeds of the orbit.
    - `V`: belt speeds in m/s.
    - `strength`: N/sqrt(k m) in m/s.
    - `A`: highest velocity over belt speed, at most 1.
    - `rtol`: relative error of d at which the grid is fine enough, where rounding allows.
    - `most_work`: cubes of grids, summed over the Newton steps of an orbit, after which it is given up.
    """
    V, strength, A = (np.ravel(column).astype(np.float64) for column in np.broadcast_arrays(V, strength, A))
    with np.errstate(all="ignore"):  # iterates that run away are given up
        everything = strength * averages(law, V, A)[0]
        rows = [
            _measured(law, *_solved(law, speed, force, height, rtol, most_work), whole)
            for speed, force, height, whole in np.transpose([V, strength, A, everything]).tolist()
        ]
    return Orbits(*np.array(rows).reshape(-1, 5).T)


def _measured(law: FrictionLaw, orbit: "_Orbit", tail: float, everything: float) -> tuple[float, ...]:
    """Return the row of an orbit; `everything` is its harmonic damping from slopes at every scale."""
    g, phases = orbit.g(orbit.slope), orbit.size // 2
    scale = max(float(np.abs(g).max()), abs(everything))
    # A layer of the law between v = 0 and the first phase would pass unseen.
    V, strength = np.array([orbit.V]), np.array([orbit.strength])
    seen = orbit.strength * float(expand(law, V, orbit.A, grid=phases).harmonic[0])
    layer = float(of_layer(law, V, strength, phases)[0]) if orbit.A == 1 else 0.0
    unseen = (abs(seen - everything) + layer) / (scale or 1.0)
    error = 0.0 if scale == 0 else tail + unseen + _ROUNDING * orbit.size / _GRIDS[0]
    d = orbit.d if np.isfinite(error) else np.nan
    return d, error, scale, float(g.mean()) - orbit.d, float(orbit.velocity.min())


def obstacle(law: FrictionLaw, V: ArrayLike, lowest: float = -1.0) -> str | None:
    """Say why slip orbits of a law are not smooth at belt speeds V, or return None.

    - `lowest`: the lowest velocity of the orbits over the belt speed.
    """
    if law.static is not None:
        static, onset = law.static_value, law.onset
        if static > onset:
            return f"its static coefficient {static:g} lies above mu(0+) = {onset:g}"
    reach = float(np.max(V, initial=0.0)) * (1 - lowest)
    kinks = [float(place) for place in law.kinks() if place < reach]
    return f"it has a kink at v = {kinks[0]:g}, which the orbit passes" if kinks else None


# -- collocation -----------------------------------------------------------------------------------


def _solved(
    law: FrictionLaw, V: float, strength: float, A: float, rtol: float, most_work: float
) -> tuple["_Orbit", float]:
    """Solve by Newton's method on finer and finer grids; return the orbit and its tail, infinite if that fails."""
    orbit, tail, work = _Orbit.weak(law, V, strength, A), np.inf, 0.0
    for size in _GRIDS:
        finer, tail = orbit.on(size), np.inf
        for _ in range(_MOST_STEPS):
            check_time()
            if work > most_work:
                return orbit, np.inf
            work += size**3
            try:
                change, push = finer.improve()
            except np.linalg.LinAlgError:
                return orbit, np.inf
            if not (np.isfinite(change) and np.abs(finer.z).max() < _RUNAWAY):
                return orbit, np.inf
            if change <= _CLOSE:
                orbit, tail = finer, _tail(push)
                break
        largest = float(np.abs(orbit.g(orbit.slope)).max()) or 1.0
        enough = max(_ROUNDING, rtol * min(1.0, abs(orbit.d) / largest))
        if not np.isfinite(tail) or work > most_work or tail <= enough:
            break
    return orbit, tail


def _tail(size: FloatArray) -> float:
    """Estimate the size of the coefficients that fold back into the first.

    From the decay over the last octave: right for a power of the order, too large for a geometric decay.
    """
    K = len(size) - 1
    last = float(size[(4 * K) // 5 :].max())
    before = float(size[(2 * K) // 5 : K // 2].max())
    return last * min(1.0, last / before) if before else last


def _parts(rows: ComplexArray) -> FloatArray:
    """Return the real parts of rows and then the imaginary ones."""
    return np.concatenate([rows.real, rows.imag])


@dataclass
class _Orbit:
    """An iterate: z_n for n = 0 to K (z_1 follows from A), d, and sigma = frequency - 1/frequency.

    The grid has 2 (K + 1) points a period, the midpoints of cells of the phase.
    """

    slope: Slope
    V: float
    strength: float
    A: float
    z: ComplexArray
    d: float
    sigma: float

    @classmethod
    def weak(cls, law: FrictionLaw, V: float, strength: float, A: float) -> "_Orbit":
        """Return the second-order orbit, its phase shifted so that the highest velocity is at 0."""
        size = _GRIDS[0] // 2
        weak, n = expand(law, V, A, grid=size), np.arange(size)
        shift = strength * (n * weak.sines[0]).sum() / A
        z = (strength**2 * weak.cosines[0] - 1j * strength * weak.sines[0]) / 2 * np.exp(1j * n * shift)
        d = strength * weak.harmonic[0] + strength**3 * weak.second[0]
        orbit = cls(slopes(law), V, strength, A, z, float(d), float(-2 * strength**2 * weak.slowing[0]))
        orbit.close()
        return orbit

    @property
    def size(self) -> int:
        """The number of points a period."""
        return 2 * len(self.z)

    @property
    def velocity(self) -> FloatArray:
        """The velocity z on the grid."""
        return values(self.z)

    @property
    def rate(self) -> FloatArray:
        """The derivative of z by the phase on the grid."""
        return values(1j * np.arange(len(self.z)) * self.z)

    def g(self, slope: Slope) -> FloatArray:
        """Return the slope g of friction, or its change for that of mu', on the grid."""
        return -self.strength * slope(self.V * np.maximum(1 - self.velocity, _NEAREST))

    def on(self, size: int) -> "_Orbit":
        """Return the iterate on another grid."""
        K = size // 2
        return replace(self, z=np.pad(self.z, (0, max(0, K - len(self.z))))[:K].copy())

    def close(self) -> None:
        """Set the fundamental so that z(0) = A is an extremum."""
        n = np.arange(2, len(self.z))
        self.z[1] = self.A / 2 - self.z[2:].real.sum() - 1j * (n * self.z[2:].imag).sum()

    def equations(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the balance of the harmonics 1 to K: its matrix, its residual, and the sizes of its right side.

        The matrix is the derivative of the residual, of real parts and then imaginary parts, by twice the real and
        minus twice the imaginary parts of z_2 to z_K, then d, then sigma. The sizes are those of the coefficients
        of (g - d) dz/dtheta.
        """
        size, K = self.size, len(self.z) - 1
        n = np.arange(1, K + 1)
        excess = self.g(self.slope) - self.d
        push = coefficients(excess * self.rate)
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
        by_cosine, by_sine = (minus + plus) / 2, (minus - plus) / 2j
        turn = (-1j / n)[:, None]
        m, diagonal = n[1:], np.arange(1, K)
        cosine = turn * (by_cosine[:, 1:] - by_cosine[:, :1])
        cosine[diagonal, diagonal - 1] += detuned[1:] / 2
        cosine[0] -= detuned[0] / 2
        sine = turn * (by_sine[:, 1:] - m * by_sine[:, :1])
        sine[diagonal, diagonal - 1] -= 0.5j * detuned[1:]
        sine[0] += 0.5j * m * detuned[0]
        by_fast = 1 / (1 + slow**2)
        by_sigma = ((by_fast - 1) / n**2 - by_fast) * self.z[1:]
        matrix = np.column_stack([cosine, sine, 1j * self.z[1:] / n, by_sigma])
        return _parts(matrix), _parts(residual), np.abs(push)

    def improve(self) -> tuple[float, FloatArray]:
        """Take a Newton step; return its size, and the sizes of the coefficients of (g - d) dz/dtheta.

        Both are relative to what friction does to an orbit of this height.
        """
        strength = self.A * float(np.abs(self.g(self.slope)).max()) or 1.0
        matrix, residual, push = self.equations()
        change = np.linalg.solve(matrix, -residual)
        K = len(self.z) - 1
        self.z[2:] += (change[: K - 1] - 1j * change[K - 1 : -2]) / 2
        self.d += float(change[-2])
        self.sigma += float(change[-1])
        self.close()
        return float(np.abs(change).max()) / min(1.0, strength), push / strength

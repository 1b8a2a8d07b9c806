"""Newton's method for slip orbits on a grid of phases, and from grid to finer grid.

The equations and the unknowns are those of `orbit`: the balance of each harmonic, for the Fourier coefficients of
z from the second harmonic on, the frequency, and d.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from stickslip_sym.core.aliases import BoolArray, ComplexArray, FloatArray, Rows
from stickslip_sym.core.deadline import check_time

__all__ = [
    "CLOSE", "GRIDS", "ROUNDING", "Equations", "Problem", "State", "Work", "close", "coefficients", "equations",
    "frequency", "grid", "largest_slope", "parts", "refined", "values",
]  # fmt: skip

GRIDS = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024)  # points a period
_MOST_STEPS = 12  # of Newton's method on one grid
CLOSE = 1e-8  # a step of Newton's method after which the next would be rounding
ROUNDING = 4e-15  # of d, as a part of the largest slope
_WORKSPACE = 4_000_000  # entries of the Jacobian matrices that are held at once
_RUNAWAY = 1e6  # a coefficient of z


class Problem(Protocol):
    """Orbits of given heights A, one a row, and the slope of friction on them."""

    @property
    def A(self) -> FloatArray: ...  # noqa: D102

    def rows(self, chosen: Rows) -> "Problem": ...  # noqa: D102

    def g(self, z: FloatArray) -> FloatArray: ...  # noqa: D102


@dataclass
class State:
    """Iterates, one a row: z_n for n = 0 to K (z_1 is set by A), d, and sigma = frequency - 1/frequency."""

    z: ComplexArray
    d: FloatArray
    sigma: FloatArray

    def rows(self, chosen: Rows) -> "State":
        """Return some of the iterates."""
        return State(self.z[chosen], self.d[chosen], self.sigma[chosen])

    def put(self, chosen: Rows, other: "State") -> None:
        """Replace some of the iterates."""
        self.z[chosen], self.d[chosen], self.sigma[chosen] = other.z, other.d, other.sigma

    def on(self, size: int) -> "State":
        """Return the same iterates on another grid, in memory of their own."""
        z = np.pad(self.z, ((0, 0), (0, max(0, size // 2 - self.z.shape[1]))))[:, : size // 2]
        return State(z.copy(), self.d.copy(), self.sigma.copy())


def grid(state: State) -> int:
    """Return the number of points a period."""
    return 2 * int(state.z.shape[1])


def values(z: ComplexArray, size: int) -> FloatArray:
    """Return a real function at the midpoints of cells of the phase from its coefficients."""
    n = np.arange(z.shape[1])
    return np.fft.irfft(z * np.exp(1j * np.pi / size * n), size, axis=1) * size


def coefficients(function: FloatArray) -> ComplexArray:
    """Return the coefficients of a real function at the midpoints of cells of the phase."""
    size = function.shape[1]
    n = np.arange(size // 2)
    turn: ComplexArray = np.exp(-1j * np.pi / size * n) / size
    return np.fft.rfft(function, axis=1)[:, : size // 2] * turn


def close(state: State, A: FloatArray) -> None:
    """Set the fundamental so that z(0) = A is an extremum."""
    n = np.arange(2, state.z.shape[1])
    state.z[:, 1] = A / 2 - state.z[:, 2:].real.sum(axis=1) - 1j * (n * state.z[:, 2:].imag).sum(axis=1)


def frequency(sigma: FloatArray) -> FloatArray:
    """Return the positive root of frequency - 1/frequency = sigma."""
    root = np.sqrt(1 + sigma**2 / 4)
    return np.where(sigma >= 0, root + sigma / 2, 1 / (root - np.minimum(sigma, 0) / 2))


@dataclass(frozen=True)
class Equations:
    """The balance of the harmonics at some iterates, one row each, and its derivative.

    Attributes
    ----------
    matrix : numpy.ndarray, shape (rows, 2 K, 2 K)
        Derivative of the residual by twice the real and minus twice the imaginary parts of z_2 to z_K, then d,
        then sigma.
    residual, push : numpy.ndarray, shape (rows, K)
        Of the harmonics 1 to K, complex; and the coefficients of (g - d) dz/dtheta.
    strength : numpy.ndarray, shape (rows,)
        What friction does to an orbit of this height.
    """

    matrix: FloatArray
    residual: ComplexArray
    push: ComplexArray
    strength: FloatArray


def parts(complex_rows: ComplexArray) -> FloatArray:
    """Return real and then imaginary parts of rows, the order of the equations."""
    return np.concatenate([complex_rows.real, complex_rows.imag], axis=1)


def equations(problem: Problem, state: State) -> Equations:
    """Return the balance of the harmonics at the iterates."""
    size = grid(state)
    K = state.z.shape[1] - 1
    count = len(state.d)
    n = np.arange(K + 1)
    z, z_theta = values(state.z, size), values(1j * n * state.z, size)
    g = problem.g(z)
    strength = problem.A * np.abs(g).max(axis=1)
    strength[strength == 0] = 1.0
    excess = g - state.d[:, None]
    push = coefficients(excess * z_theta)
    fast = frequency(state.sigma)
    slow = 1 / fast
    n = n[1:]
    # Balance of the harmonic n: (1/(n^2 frequency) - frequency) z_n = push_n/n^2.
    detuned = slow[:, None] / n**2 - fast[:, None]
    detuned[:, 0] = -state.sigma
    residual = detuned * state.z[:, 1:] - push[:, 1:] / n**2
    # The variation of the friction is the derivative of excess times that of z: no second slope is needed.
    spectrum = np.fft.fft(excess, axis=1) * (np.exp(-1j * np.pi / size * np.arange(size)) / size)
    spectrum = np.concatenate([spectrum[:, K - 1 : 0 : -1].conj(), spectrum], axis=1)  # from 1 - K up
    minus = spectrum[:, n[:, None] - n[None, :] + K - 1]
    plus = spectrum[:, n[:, None] + n[None, :] + K - 1]
    by_cosine, by_sine = (minus + plus) / 2, (minus - plus) / 2j
    rate = (-1j / n)[:, None]
    m = n[1:]
    diagonal = np.arange(1, K)
    matrix = np.empty((count, 2 * K, 2 * K))

    def enter(columns: slice, part: ComplexArray) -> None:
        matrix[:, :K, columns], matrix[:, K:, columns] = part.real, part.imag

    cosine = rate * (by_cosine[:, :, 1:] - by_cosine[:, :, :1])
    cosine[:, diagonal, diagonal - 1] += detuned[:, 1:] / 2
    cosine[:, 0, :] -= detuned[:, :1] / 2
    enter(slice(0, K - 1), cosine)
    sine = rate * (by_sine[:, :, 1:] - m * by_sine[:, :, :1])
    sine[:, diagonal, diagonal - 1] -= 0.5j * detuned[:, 1:]
    sine[:, 0, :] += 0.5j * m * detuned[:, :1]
    enter(slice(K - 1, 2 * K - 2), sine)
    enter(slice(2 * K - 2, 2 * K - 1), (1j * state.z[:, 1:] / n)[:, :, None])
    d_fast = 1 / (1 + slow**2)
    by_sigma = ((d_fast - 1)[:, None] / n**2 - d_fast[:, None]) * state.z[:, 1:]
    enter(slice(2 * K - 1, 2 * K), by_sigma[:, :, None])
    return Equations(matrix, residual, push, strength)


def _step(problem: Problem, state: State) -> tuple[FloatArray, FloatArray]:
    """Take one Newton step in place; return its size, and the sizes of the coefficients of (g - d) dz/dtheta.

    Both are relative to what friction does to an orbit of this height.
    """
    here = equations(problem, state)
    K = state.z.shape[1] - 1
    change = np.linalg.solve(here.matrix, -parts(here.residual)[:, :, None])[:, :, 0]
    state.z[:, 2:] += (change[:, : K - 1] - 1j * change[:, K - 1 : 2 * K - 2]) / 2
    state.d += change[:, -2]
    state.sigma += change[:, -1]
    close(state, problem.A)
    strength = here.strength
    return np.abs(change).max(axis=1) / np.minimum(1.0, strength), np.abs(here.push) / strength[:, None]


@dataclass
class Work:
    """A bound on the work: cubes of grids, which a Newton step takes."""

    most: float
    done: float = 0.0

    @property
    def spent(self) -> bool:
        """Whether the bound is reached."""
        return self.done > self.most

    @property
    def left(self) -> float:
        """What may still be done."""
        return self.most - self.done


def _newton(problem: Problem, state: State, work: Work) -> tuple[BoolArray, FloatArray]:
    """Iterate in place; return which rows converged, and the size of the unresolved tail of each."""
    count = len(state.d)
    converged, tail = np.zeros(count, dtype=bool), np.full(count, np.inf)
    active = np.arange(count)
    for _ in range(_MOST_STEPS):
        check_time()
        if work.spent:
            break
        work.done += active.size * grid(state) ** 3
        part, rows = problem.rows(active), state.rows(active)
        try:
            change, push = _step(part, rows)
        except np.linalg.LinAlgError:
            break
        state.put(active, rows)
        sound = np.isfinite(change) & (np.abs(rows.z).max(axis=1) < _RUNAWAY)
        done = sound & (change <= CLOSE)
        tail[active[done]] = _tail(push[done])
        converged[active[done]] = True
        active = active[sound & ~done]
        if not active.size:
            break
    return converged, tail


def _tail(size: FloatArray) -> FloatArray:
    """Estimate the size of the coefficients that fold back into the first.

    From the decay over the last octave: right for a power of the order, too large for a geometric decay.
    """
    K = size.shape[1] - 1
    last = size[:, (4 * K) // 5 :].max(axis=1)
    before = size[:, (2 * K) // 5 : K // 2].max(axis=1)
    return np.where(last == 0, 0.0, last * np.minimum(1.0, last / before))


def refined(problem: Problem, state: State, rtol: float, work: Work) -> tuple[State, FloatArray]:
    """Solve on finer and finer grids; return the iterates and their tails, infinite where Newton failed."""
    tail = np.full(len(state.d), np.inf)
    found = state
    active = np.arange(len(state.d))
    for size in GRIDS:
        if size < grid(state) and size != GRIDS[-1]:
            continue
        found = found.on(size)
        chunk = max(1, _WORKSPACE // size**2)
        for part in (active[i : i + chunk] for i in range(0, active.size, chunk)):
            if work.spent:
                break
            rows = found.rows(part)
            converged, tail[part] = _newton(problem.rows(part), rows, work)
            found.put(part[converged], rows.rows(converged))
        wanted = np.maximum(ROUNDING, rtol * np.minimum(1.0, np.abs(found.d) / largest_slope(problem, found)))
        active = active[np.isfinite(tail[active]) & (tail > wanted)[active]]
        if not active.size or work.spent:
            break
    return found, tail


def largest_slope(problem: Problem, state: State) -> FloatArray:
    """Return the largest slope on each orbit, and 1 where there is no friction."""
    scale = np.abs(problem.g(values(state.z, grid(state)))).max(axis=1)
    return np.where(scale == 0, 1.0, scale)

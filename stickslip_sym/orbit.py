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

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from stickslip_sym.friction import FrictionLaw, limit_at_rest
from stickslip_sym.perturbation import averages, expand, slopes

__all__ = ["Orbits", "obstacle", "orbits"]

_GRIDS = (32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024)  # points a period
_MOST_STEPS = 12  # of Newton's method on one grid
_MOST_WORK = 3e9  # cubes of grids, summed over the Newton steps on the way from weak friction to all of it
_CLOSE = 1e-8  # a step of Newton's method after which the next would be rounding
_SAME = 1e-12  # relative; a static coefficient that exceeds mu(0+) by less does not
_ROUNDING = 4e-15  # of d, as a part of the largest slope
_WORKSPACE = 4_000_000  # entries of the Jacobian matrices that are held at once
_WEAKEST = 1e-3  # part of the friction with which the way to all of it begins
_LOOSE = 1e-3  # relative error of d on that way
_RUNAWAY = 1e6  # a coefficient of z
_NEAREST = 1e-12  # slip speed over belt speed that an iterate may come down to; it may overshoot the belt


@dataclass(frozen=True)
class Orbits:
    """Slip orbits, one row for each scene.

    Attributes
    ----------
    d : numpy.ndarray, shape (n,)
        Damping over sqrt(k m).
    frequency : numpy.ndarray, shape (n,)
        Over omega.
    error : numpy.ndarray, shape (n,)
        Estimated error of d, as a part of the largest slope g on the orbit.
    scale : numpy.ndarray, shape (n,)
        That largest slope.
    exponent : numpy.ndarray, shape (n,)
        Floquet exponent, the mean of g(z) - d, over omega: the orbit is stable if it is negative.
    lowest : numpy.ndarray, shape (n,)
        Lowest velocity z of the orbit.
    """

    d: Any
    frequency: Any
    error: Any
    scale: Any
    exponent: Any
    lowest: Any

    @property
    def relative_error(self) -> Any:
        """Estimated error of d, relative; infinite where d was not found, or is 0 but need not be."""
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(self.error == 0, 0.0, self.error * self.scale / np.abs(self.d))
        return np.where(np.isnan(relative), np.inf, relative)


@dataclass
class _State:
    """Iterates, one a row: z_n for n = 0 to K (z_1 is set by A), d, and sigma = frequency - 1/frequency."""

    z: Any
    d: Any
    sigma: Any

    def rows(self, chosen: Any) -> "_State":
        return _State(self.z[chosen], self.d[chosen], self.sigma[chosen])

    def put(self, chosen: Any, other: "_State") -> None:
        self.z[chosen], self.d[chosen], self.sigma[chosen] = other.z, other.d, other.sigma

    def on(self, size: int) -> "_State":
        """Return the same iterates on another grid, in memory of their own."""
        z = np.pad(self.z, ((0, 0), (0, max(0, size // 2 - self.z.shape[1]))))[:, : size // 2]
        return _State(z.copy(), self.d.copy(), self.sigma.copy())


@dataclass(frozen=True)
class _Problem:
    """Scenes of one law: the slope of mu, belt speeds, frictions over impedance N/sqrt(k m), and heights."""

    slope: Callable[[Any], Any]
    V: Any
    e: Any
    A: Any

    def rows(self, chosen: Any) -> "_Problem":
        return _Problem(self.slope, self.V[chosen], self.e[chosen], self.A[chosen])

    def g(self, z: Any) -> Any:
        slip = np.maximum(1 - z, _NEAREST)
        return -self.e[:, None] * self.slope(self.V[:, None] * slip)


def _grid(state: _State) -> int:
    return 2 * int(state.z.shape[1])


def _values(z: Any, size: int) -> Any:
    """Return a real function at the midpoints of cells of the phase from its coefficients."""
    n = np.arange(z.shape[1])
    return np.fft.irfft(z * np.exp(1j * np.pi / size * n), size, axis=1) * size


def _coefficients(values: Any) -> Any:
    size = values.shape[1]
    n = np.arange(size // 2)
    return np.fft.rfft(values, axis=1)[:, : size // 2] * (np.exp(-1j * np.pi / size * n) / size)


def _close(state: _State, A: Any) -> None:
    """Set the fundamental so that z(0) = A is an extremum."""
    n = np.arange(2, state.z.shape[1])
    state.z[:, 1] = A / 2 - state.z[:, 2:].real.sum(axis=1) - 1j * (n * state.z[:, 2:].imag).sum(axis=1)


def _frequency(sigma: Any) -> Any:
    """Return the positive root of frequency - 1/frequency = sigma."""
    root = np.sqrt(1 + sigma**2 / 4)
    return np.where(sigma >= 0, root + sigma / 2, 1 / (root - np.minimum(sigma, 0) / 2))


def _step(problem: _Problem, state: _State) -> tuple[Any, Any]:
    """Take one Newton step in place; return its size, and the sizes of the coefficients of (g - d) dz/dtheta.

    Both are relative to what friction does to an orbit of this height.
    """
    size = _grid(state)
    K = state.z.shape[1] - 1
    count = len(state.d)
    n = np.arange(K + 1)
    z, z_theta = _values(state.z, size), _values(1j * n * state.z, size)
    g = problem.g(z)
    strength = problem.A * np.abs(g).max(axis=1)
    strength[strength == 0] = 1.0
    excess = g - state.d[:, None]
    push = _coefficients(excess * z_theta)
    fast = _frequency(state.sigma)
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

    def enter(columns: slice, part: Any) -> None:
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
    right = -np.concatenate([residual.real, residual.imag], axis=1)
    change = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
    state.z[:, 2:] += (change[:, : K - 1] - 1j * change[:, K - 1 : 2 * K - 2]) / 2
    state.d += change[:, -2]
    state.sigma += change[:, -1]
    _close(state, problem.A)
    return np.abs(change).max(axis=1) / np.minimum(1.0, strength), np.abs(push) / strength[:, None]


@dataclass
class _Work:
    """A bound on the work: cubes of grids, which a Newton step takes."""

    most: float
    done: float = 0.0


def _newton(problem: _Problem, state: _State, work: _Work) -> tuple[Any, Any]:
    """Iterate in place; return which rows converged, and the size of the unresolved tail of each."""
    count = len(state.d)
    converged, tail = np.zeros(count, dtype=bool), np.full(count, np.inf)
    active = np.arange(count)
    for _ in range(_MOST_STEPS):
        work.done += active.size * _grid(state) ** 3
        part, rows = problem.rows(active), state.rows(active)
        try:
            change, push = _step(part, rows)
        except np.linalg.LinAlgError:
            break
        state.put(active, rows)
        sound = np.isfinite(change) & (np.abs(rows.z).max(axis=1) < _RUNAWAY)
        done = sound & (change <= _CLOSE)
        tail[active[done]] = _tail(push[done])
        converged[active[done]] = True
        active = active[sound & ~done]
        if not active.size:
            break
    return converged, tail


def _tail(size: Any) -> Any:
    """Estimate the size of the coefficients that fold back into the first.

    From the decay over the last octave: right for a power of the order, too large for a geometric decay.
    """
    K = size.shape[1] - 1
    last = size[:, (4 * K) // 5 :].max(axis=1)
    before = size[:, (2 * K) // 5 : K // 2].max(axis=1)
    return np.where(last == 0, 0.0, last * np.minimum(1.0, last / before))


def _refined(problem: _Problem, state: _State, rtol: float, work: _Work) -> tuple[_State, Any]:
    """Solve on finer and finer grids; return the iterates and their tails, infinite where Newton failed."""
    tail = np.full(len(state.d), np.inf)
    found = state
    active = np.arange(len(state.d))
    for size in _GRIDS:
        if size < _grid(state) and size != _GRIDS[-1]:
            continue
        found = found.on(size)
        chunk = max(1, _WORKSPACE // size**2)
        for part in (active[i : i + chunk] for i in range(0, active.size, chunk)):
            rows = found.rows(part)
            converged, tail[part] = _newton(problem.rows(part), rows, work)
            found.put(part[converged], rows.rows(converged))
        wanted = np.maximum(_ROUNDING, rtol * np.minimum(1.0, np.abs(found.d) / _scale(problem, found)))
        active = active[np.isfinite(tail[active]) & (tail > wanted)[active]]
        if not active.size or work.done > work.most:
            break
    return found, tail


def _scale(problem: _Problem, state: _State) -> Any:
    """Return the largest slope on each orbit, and 1 where there is no friction."""
    scale = np.abs(problem.g(_values(state.z, _grid(state)))).max(axis=1)
    return np.where(scale == 0, 1.0, scale)


def _start(law: FrictionLaw, problem: _Problem, size: int) -> _State:
    """Return the second-order orbits, their phase shifted so that the highest velocity is at 0."""
    weak = expand(law, problem.V, problem.A, grid=size // 2)
    e, n = problem.e[:, None], np.arange(size // 2)
    shift = problem.e * (n * weak.sines).sum(axis=1) / problem.A
    z = (e**2 * weak.cosines - 1j * e * weak.sines) / 2 * np.exp(1j * n * shift[:, None])
    d = problem.e * weak.harmonic + problem.e**3 * weak.second
    state = _State(z, d, -2 * problem.e**2 * weak.slowing)
    _close(state, problem.A)
    return state


def _continued(law: FrictionLaw, problem: _Problem, rtol: float) -> tuple[_State, Any]:
    """Follow one orbit from weak friction to all of it."""
    part, growth, work = 1.0, 1.5, _Work(_MOST_WORK)
    tail = np.array([np.inf])
    while not np.isfinite(tail[0]) and part > _WEAKEST and work.done < work.most:
        part /= 2
        weak = _scaled(problem, part)
        state, tail = _refined(weak, _start(law, weak, _GRIDS[0]), _LOOSE, work)
    before = last = (part, state)
    while np.isfinite(tail[0]) and growth > 1 + 1e-4 and work.done < work.most:
        if last[0] == 1.0:
            return state, tail
        part = min(1.0, last[0] * growth)
        guess = _extrapolated(before, last, part)
        new, new_tail = _refined(_scaled(problem, part), guess, _LOOSE if part < 1 else rtol, work)
        if np.isfinite(new_tail[0]):
            before, last, state, tail = last, (part, new), new, new_tail
            growth = min(2.0, 1 + 1.5 * (growth - 1))
        else:
            growth = 1 + (growth - 1) / 3
    return state, np.array([np.inf])


def _scaled(problem: _Problem, part: float) -> _Problem:
    return _Problem(problem.slope, problem.V, problem.e * part, problem.A)


def _extrapolated(before: tuple[float, _State], last: tuple[float, _State], part: float) -> _State:
    """Continue two orbits along the secant through them, in the logarithm of the friction."""
    state = last[1].on(_grid(last[1]))
    if before[0] < last[0]:
        ahead = np.log(part / last[0]) / np.log(last[0] / before[0])
        old = before[1].on(_grid(state))
        state.z += ahead * (state.z - old.z)
        state.d += ahead * (state.d - old.d)
        state.sigma += ahead * (state.sigma - old.sigma)
    return state


def obstacle(law: FrictionLaw, V: Any, lowest: float = -1.0, *, jump: bool = True) -> str | None:
    """Say why slip orbits of a law are not smooth at belt speeds V, or return None.

    Parameters
    ----------
    law : FrictionLaw
    V : array_like
    lowest : float
        The lowest velocity of the orbits over the belt speed.
    jump : bool
        Whether a static coefficient matters, as it does where orbits touch the belt's speed.
    """
    if jump and law.static is not None:
        static, onset = float(law.substitute(law.static)), limit_at_rest(law.substitute(law.expr))
        if not static <= onset * (1 + _SAME):
            return f"its static coefficient {static:g} lies above mu(0+) = {onset:g}"
    reach = float(np.max(V, initial=0.0)) * (1 - lowest)
    kinks = [float(place) for place in law.kinks() if place < reach]
    return f"it has a kink at v = {kinks[0]:g}, which the orbit passes" if kinks else None


def _harmonics(law: FrictionLaw, problem: _Problem, size: int) -> tuple[Any, Any]:
    """Return the harmonic damping over impedance, from the slopes on a grid and from slopes at every scale."""
    on_grid = expand(law, problem.V, problem.A, grid=size // 2).harmonic
    return problem.e * on_grid, problem.e * averages(law, problem.V, problem.A)[1]


def orbits(law: FrictionLaw, V: Any, e: Any, A: Any = 1.0, *, rtol: float = 1e-13) -> Orbits:
    """Return the pure-slip orbits of given height.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound, smooth on the speeds of the orbit.
    V : array_like
        Belt speeds in m/s.
    e : array_like
        N/sqrt(k m) in m/s.
    A : array_like
        Highest velocity over belt speed, at most 1.
    rtol : float
        Relative error of d at which the grid is fine enough, where rounding allows.

    Returns
    -------
    Orbits
        An orbit that was not found has an infinite error, and no number for d.
    """
    columns = np.broadcast_arrays(*(np.asarray(value, np.float64) for value in (V, e, A)))
    problem = _Problem(slopes(law), *(np.ravel(column) for column in columns))
    with np.errstate(all="ignore"):  # iterates that run away are given up
        state, tail = _refined(problem, _start(law, problem, _GRIDS[0]), rtol, _Work(np.inf))
        for row in np.flatnonzero(~np.isfinite(tail)):
            single, tail[[row]] = _continued(law, problem.rows([row]), rtol)
            size = max(_grid(state), _grid(single))
            state = state.on(size)
            state.put([row], single.on(size))
        z = _values(state.z, _grid(state))
        g = problem.g(z)
        scale = np.abs(g).max(axis=1)
        seen, all_there_is = _harmonics(law, problem, _grid(state))  # a layer near v = 0 would pass unseen
        scale = np.maximum(scale, np.abs(all_there_is))
        unseen = np.abs(seen - all_there_is) / np.where(scale == 0, 1.0, scale)
        rounding = _ROUNDING * _grid(state) / _GRIDS[0]
        error = tail + unseen + rounding
    error[scale == 0] = 0.0
    return Orbits(
        d=np.where(np.isfinite(error), state.d, np.nan),
        frequency=_frequency(state.sigma),
        error=error,
        scale=scale,
        exponent=g.mean(axis=1) - state.d,
        lowest=z.min(axis=1),
    )

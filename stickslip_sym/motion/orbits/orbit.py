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

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import FloatArray, Rows
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.collocation import (
    GRIDS,
    ROUNDING,
    State,
    Work,
    close,
    coefficients,
    equations,
    frequency,
    grid,
    parts,
    refined,
    values,
)
from stickslip_sym.motion.orbits.expansion import Slope, averages, expand, of_layer, slopes

__all__ = ["Orbits", "derivatives", "obstacle", "orbits"]

_MOST_WORK = 3e9  # cubes of grids, summed over Newton steps
_SAME = 1e-12  # relative; a static coefficient that exceeds mu(0+) by less does not
_TIGHT = 1e-13  # relative error of d where it is differentiated
_NEAREST = 1e-12  # slip speed over belt speed that an iterate may come down to; it may overshoot the belt


@dataclass(frozen=True)
class Orbits:
    """Slip orbits, one row for each operating point."""

    d: FloatArray  # damping over sqrt(k m), shape (n,)
    frequency: FloatArray  # over omega, shape (n,)
    error: FloatArray  # estimated error of d, as a part of the largest slope g on the orbit, shape (n,)
    scale: FloatArray  # that largest slope, shape (n,)
    exponent: FloatArray
    """Floquet exponent, the mean of g(z) - d, over omega: the orbit is stable if it is negative, shape (n,)."""
    lowest: FloatArray  # lowest velocity z of the orbit, shape (n,)
    work: float = 0.0  # cubes of grids, summed over Newton steps and rows

    @property
    def relative_error(self) -> FloatArray:
        """Estimated error of d, relative; infinite where d was not found, or is 0 but need not be."""
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = np.where(self.error == 0, 0.0, self.error * self.scale / np.abs(self.d))
        return np.where(np.isnan(relative), np.inf, relative)


@dataclass(frozen=True)
class _Problem:
    """Points of one law: the slope of mu, belt speeds, frictions over impedance N/sqrt(k m), and heights."""

    slope: Slope
    V: FloatArray
    strength: FloatArray
    A: FloatArray

    def rows(self, chosen: Rows) -> "_Problem":
        return _Problem(self.slope, self.V[chosen], self.strength[chosen], self.A[chosen])

    def g(self, z: FloatArray) -> FloatArray:
        slip = np.maximum(1 - z, _NEAREST)
        return -self.strength[:, None] * self.slope(self.V[:, None] * slip)


def _start(law: FrictionLaw, problem: _Problem, size: int) -> State:
    """Return the second-order orbits, their phase shifted so that the highest velocity is at 0."""
    weak = expand(law, problem.V, problem.A, grid=size // 2)
    strength, n = problem.strength[:, None], np.arange(size // 2)
    shift = problem.strength * (n * weak.sines).sum(axis=1) / problem.A
    z = (strength**2 * weak.cosines - 1j * strength * weak.sines) / 2 * np.exp(1j * n * shift[:, None])
    d = problem.strength * weak.harmonic + problem.strength**3 * weak.second
    state = State(z, d, -2 * problem.strength**2 * weak.slowing)
    close(state, problem.A)
    return state


def obstacle(law: FrictionLaw, V: ArrayLike, lowest: float = -1.0, *, jump: bool = True) -> str | None:
    """Say why slip orbits of a law are not smooth at belt speeds V, or return None.

    - `lowest`: the lowest velocity of the orbits over the belt speed.
    - `jump`: whether a static coefficient matters, as it does where orbits touch the belt's speed.
    """
    if jump and law.static is not None:
        static, onset = law.number(law.static), law.onset
        if not static <= onset * (1 + _SAME):
            return f"its static coefficient {static:g} lies above mu(0+) = {onset:g}"
    reach = float(np.max(V, initial=0.0)) * (1 - lowest)
    kinks = [float(place) for place in law.kinks() if place < reach]
    return f"it has a kink at v = {kinks[0]:g}, which the orbit passes" if kinks else None


def _harmonics(law: FrictionLaw, problem: _Problem, size: int) -> tuple[FloatArray, FloatArray]:
    """Return the harmonic damping over impedance, from the slopes on a grid and from slopes at every scale."""
    on_grid = expand(law, problem.V, problem.A, grid=size // 2).harmonic
    return problem.strength * on_grid, problem.strength * averages(law, problem.V, problem.A)[0]


def _solution(
    law: FrictionLaw, given: Sequence[ArrayLike], rtol: float, work: Work
) -> tuple[_Problem, State, FloatArray]:
    """Solve for the orbits of belt speeds, frictions over impedance, and heights; return their tails too."""
    columns = np.broadcast_arrays(*(np.asarray(value, np.float64) for value in given))
    problem = _Problem(slopes(law), *(np.ravel(column) for column in columns))
    return problem, *refined(problem, _start(law, problem, GRIDS[0]), rtol, work)


def derivatives(law: FrictionLaw, V: ArrayLike, strength: ArrayLike) -> dict[str, FloatArray]:
    """Return the derivatives of d of grazing orbits, from one linear solve an orbit.

    With F(u, d; p) = 0 the balance of the harmonics, and l the vector with l^T F_u = 0 and l^T F_d = 1,
    dd/dp = -l^T F_p. Along the orbit F_p is the spectrum of -(dg/dp) dz/dtheta, over the squares of the orders.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound, smooth on the speeds of the orbit.
    V, strength : array_like, shape (n,)
        As for `orbits`.

    Returns
    -------
    dict of str to numpy.ndarray, shape (n,)
        "d" itself; "V" and "strength", derivatives by the logarithms of these; and each parameter of the law. NaN
        where there is no orbit.
    """
    with np.errstate(all="ignore"):
        problem, state, tail = _solution(law, (V, strength, 1.0), _TIGHT, Work(np.inf))
        size, K = grid(state), state.z.shape[1] - 1
        n = np.arange(K + 1)
        z, z_theta = values(state.z, size), values(1j * n * state.z, size)
        unit = np.zeros((len(state.d), 2 * K, 1))
        unit[:, -2] = 1.0
        found = np.isfinite(tail)
        left = np.full(unit.shape[:2], np.nan)
        matrix = equations(problem, state).matrix[found]
        left[found] = np.linalg.solve(matrix.transpose(0, 2, 1), unit[found])[:, :, 0]
        result = {"d": np.where(found, state.d, np.nan)}
        changes = {name: slopes(law.partial(name)) for name in ("V", *law.parameters)}
        changes["strength"] = problem.slope
        for name, slope in changes.items():
            change = replace(problem, slope=slope).g(z)
            by_name = coefficients(change * z_theta)[:, 1:] / n[1:] ** 2
            result[name] = (left * parts(by_name)).sum(axis=1)
    return result


def orbits(
    law: FrictionLaw,
    V: ArrayLike,
    strength: ArrayLike,
    A: ArrayLike = 1.0,
    *,
    rtol: float = 1e-13,
    most_work: float = _MOST_WORK,
) -> Orbits:
    """Return the pure-slip orbits of given height.

    - `law`: with all parameters bound, smooth on the speeds of the orbit.
    - `V`: belt speeds in m/s.
    - `strength`: N/sqrt(k m) in m/s.
    - `A`: highest velocity over belt speed, at most 1.
    - `rtol`: relative error of d at which the grid is fine enough, where rounding allows.
    - `most_work`: cubes of grids, summed over Newton steps and rows, after which what is not found yet is given
      up.

    An orbit that was not found has an infinite error, and no number for d.
    """
    work = Work(most_work)
    with np.errstate(all="ignore"):  # iterates that run away are given up
        problem, state, tail = _solution(law, (V, strength, A), rtol, work)
        z = values(state.z, grid(state))
        g = problem.g(z)
        scale = np.abs(g).max(axis=1)
        # A layer of the law between v = 0 and the first phase would pass unseen.
        seen, all_there_is = _harmonics(law, problem, grid(state))
        scale = np.maximum(scale, np.abs(all_there_is))
        layer = np.where(problem.A == 1, of_layer(law, problem.V, problem.strength, grid(state) // 2), 0.0)
        unseen = (np.abs(seen - all_there_is) + layer) / np.where(scale == 0, 1.0, scale)
        error = tail + unseen + ROUNDING * grid(state) / GRIDS[0]
    error[scale == 0] = 0.0
    return Orbits(
        d=np.where(np.isfinite(error), state.d, np.nan),
        frequency=frequency(state.sigma),
        error=error,
        scale=scale,
        exponent=g.mean(axis=1) - state.d,
        lowest=z.min(axis=1),
        work=work.done,
    )

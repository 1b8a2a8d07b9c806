"""Weak friction: slip orbits expanded in powers of the friction, and the averages of the slope they start from.

With time in 1/omega, z = x'/V and g(z) = -N mu'(V(1 - z))/sqrt(k m), slip obeys Lienard's equation

    z'' + (d - g(z)) z' + z = 0,    d = c/sqrt(k m).

Its periodic orbit with the highest velocity z = A is expanded in powers of g by the method of Lindstedt and
Poincare; `derivations/d8_second_order.py` proves the formulas. For A = 1 it grazes the belt's speed. Only the
slope of mu enters, never mu itself: nothing cancels at small belt speeds.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache, lru_cache

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, ComplexArray, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.model.at_rest import reals
from stickslip_sym.model.law import FrictionLaw

Slope = Callable[[FloatArray], FloatArray]
"""mu' at slip speeds."""
_GRIDS = (32, 192, 1152)  # phases in half a period; the next where these do not do
_TAIL = 1e-14  # of the highest quarter of the Fourier coefficients, relative: the rounding of a sum of them
_OCTAVES = 40  # of the phase, to which panels shrink towards the graze
_NODES = 16


def slopes(law: FrictionLaw) -> Slope:
    """Return mu'(v) as a function of arrays; NaN where it has no finite real value."""
    compiled = law.function("numpy", derivative=True)

    def slope(v: FloatArray) -> FloatArray:
        with np.errstate(all="ignore"):
            try:
                found = reals(compiled(v))
            except ArithmeticError:  # of constants in the formula
                found = np.asarray(np.nan)
        return np.broadcast_to(found, np.shape(v))

    return slope


# Fourier series on 2 K phases theta_j = (j + 1/2) pi/K of a period, the midpoints of cells: of real functions, by
# z_n for n = 0 to K - 1 with sum of z_n exp(i n theta) + its conjugate; a row each.


def coefficients(function: FloatArray) -> ComplexArray:
    """Return the coefficients of functions from their values."""
    size = function.shape[-1]
    turn: ComplexArray = np.exp(-1j * np.pi / size * np.arange(size // 2)) / size
    return np.fft.rfft(function)[..., : size // 2] * turn


def values(z: ComplexArray | FloatArray) -> FloatArray:
    """Return the values of functions from their coefficients."""
    size = 2 * z.shape[-1]
    found: FloatArray = np.fft.irfft(z * np.exp(1j * np.pi / size * np.arange(size // 2)), size) * size
    return found


@dataclass(frozen=True)
class Expansion:
    """The slip orbit with the highest velocity A V, for weak friction; one row for each belt speed.

    In z = A cos(theta) + sum of a_n cos(n theta) + b_n sin(n theta), and with f = N/sqrt(k m), the coefficients
    are b_n = f `sines`, a_n = f^2 `cosines`, the frequency is 1 - f^2 `slowing`, and c/N = `harmonic` +
    f^2 `second`.

    - `harmonic`, `second`, `slowing`: in s/m, (s/m)^3 and (s/m)^2, shape (n,).
    - `cosines`, `sines`: shape (n, H), column j belongs to the harmonic j.
    - `largest`: the largest slope on the orbit, in s/m, shape (n,).
    - `tail`: size of the highest coefficients of friction, relative, shape (n,).
    """

    harmonic: FloatArray
    second: FloatArray
    slowing: FloatArray
    cosines: FloatArray
    sines: FloatArray
    largest: FloatArray
    tail: FloatArray

    def refined(self, rows: BoolArray, finer: "Expansion") -> "Expansion":
        """Return the expansion with some rows replaced by those from a finer grid."""
        columns = {}
        for entry in fields(self):
            column, finer_column = getattr(self, entry.name), getattr(finer, entry.name)
            wider = [(0, 0), *((0, len(finer_column[0]) - len(column[0])) for _ in column.shape[1:])]
            columns[entry.name] = np.pad(column, wider)
            columns[entry.name][rows] = finer_column
        return Expansion(**columns)

    def distortion(self, strength: FloatArray) -> FloatArray:
        """Return the amplitudes of the overtones times their orders, for N/sqrt(k m) in m/s.

        Friction changes along an orbit as fast as its highest overtones do.
        """
        found: FloatArray = strength * (np.abs(self.sines) @ np.arange(self.sines.shape[1]))
        return found

    @property
    def resolved(self) -> BoolArray:
        """Whether the grid resolved the law."""
        return self.tail <= _TAIL


def expand(law: FrictionLaw, V: ArrayLike, A: ArrayLike = 1.0, *, grid: int | None = None) -> Expansion:
    """Expand slip orbits for weak friction.

    - `law`: with all parameters bound, smooth on the speeds of the orbit.
    - `V, A`: belt speeds in m/s, and highest velocities as parts of them.
    - `grid`: number of phases in half a period; found for each speed if not given.
    """
    V, A = (np.ravel(array) for array in np.broadcast_arrays(np.asarray(V, np.float64), A))
    slope = slopes(law)
    found = _expand(slope, V, A, grid or _GRIDS[0])
    for size in () if grid else _GRIDS[1:]:
        again = ~found.resolved
        if again.any():
            found = found.refined(again, _expand(slope, V[again], A[again], size))
    return found


def expansion_changes(
    law: FrictionLaw, V: FloatArray, weak: Expansion, name: str
) -> tuple[FloatArray, FloatArray]:
    """Return how `harmonic` and `second` of orbits that graze change with a parameter, or with ln V for "V".

    They are of the first and of the third degree in the slopes, so central differences over one step and two are
    exact.
    """
    slope, change, grid = slopes(law), slopes(law.partial(name)), weak.sines.shape[1]
    height = np.ones_like(V)
    by_itself = _expand(change, V, height, grid)
    step = np.where(by_itself.largest > 0, weak.largest / by_itself.largest, 1.0)

    def second(t: FloatArray) -> FloatArray:
        return _expand(lambda v: slope(v) + t[:, None] * change(v), V, height, grid).second

    def difference(t: FloatArray) -> FloatArray:
        return (second(t) - second(-t)) / (2 * t)

    return by_itself.harmonic, (4 * difference(step) - difference(2 * step)) / 3


def _expand(slope: Slope, V: FloatArray, A: FloatArray, size: int) -> Expansion:
    """Expand on one grid; the midpoints of cells of the phase, so that v = 0 itself is never met."""
    theta = (np.arange(2 * size) + 0.5) * (np.pi / size)
    sine, n = np.sin(theta), np.arange(size, dtype=np.float64)
    off_resonance = n**2 - 1
    off_resonance[1] = np.inf  # the fundamental is set by the amplitude
    column = A[:, None]
    # 1 - cos(theta) without cancellation.
    reach = (1 - column) + 2 * column * np.sin(theta[:size] / 2) ** 2
    half = -slope(V[:, None] * reach)
    g = np.hstack([half, half[:, ::-1]])
    feed = -2 * coefficients(g * sine).imag
    harmonic = feed[:, 1]
    b = column * feed / off_resonance
    z1, excess = values(-0.5j * b), g - harmonic[:, None]
    f = -2 * coefficients(excess * z1).imag
    a = -n * f / off_resonance
    a[:, 1] = -((n * b).sum(axis=1) ** 2) / (2 * A) - a[:, 2:].sum(axis=1)
    curvature = values(-1j * n * coefficients(g)) / (column * sine)  # dg/dz, from the derivative by the phase
    second = 2 * ((excess * values(a / 2) + curvature * z1**2 / 2) * np.cos(theta)).mean(axis=1) / A
    high, largest = np.abs(feed[:, size - size // 4 :]).max(axis=1), np.abs(g).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        tail = np.nan_to_num(np.where(high == 0, 0.0, high / largest), nan=np.inf, posinf=np.inf)
    return Expansion(harmonic, second, f[:, 1] / (2 * A), a, b, largest, tail)


def averages(
    law: FrictionLaw, V: ArrayLike, A: ArrayLike = 1.0, *, criteria: Sequence[Criterion] = (harmonic,)
) -> list[FloatArray]:
    """Return the averages of -mu' at belt speeds V by the weights of criteria, in s/m.

    Over the slip speeds V (1 - A) to V (1 + A) of a harmonic motion of velocity amplitude A V.

    Gauss-Legendre panels in the phase, v = V (1 - cos(theta)), halved again and again towards v = 0: a law whose
    features lie at any part of the belt's speed down to 1e-24 of it is resolved.
    """
    V, A = (column[:, None] for column in np.broadcast_arrays(np.asarray(V, np.float64), A))
    theta, _ = _graded()
    slope = -slopes(law)(V * ((1 - A) + 2 * A * np.sin(theta / 2) ** 2))
    # No product of matrices: threads would wait for each other longer than they work.
    return [(slope * _shares(criterion)).sum(axis=1) for criterion in criteria]


@lru_cache(maxsize=32)
def _shares(criterion: Criterion) -> FloatArray:
    """Return what each node contributes to an average."""
    theta, weight = _graded()
    sine: FloatArray = np.sin(theta)
    p, q = sp.symbols("p q", positive=True)
    value = function_of([p, q], criterion.from_ends(p, q), "numpy")
    shares: FloatArray = weight * value(2 * np.sin(theta / 2) ** 2, 2 * np.cos(theta / 2) ** 2) * sine
    return shares


@cache
def _graded() -> tuple[FloatArray, FloatArray]:
    """Return the nodes and weights of the panels."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    ends = np.pi * np.append(0.0, 2.0 ** np.arange(-_OCTAVES, 1))
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + nodes)).ravel(), (half * weights).ravel()


def of_layer(law: FrictionLaw, V: FloatArray, strength: FloatArray, phases: int) -> FloatArray:
    """Return the damping over sqrt(k m) that a layer of the law at rest may add, of which a grid sees nothing.

    A thin layer acts as a static coefficient that lies higher by its height h: the halves of the grazing orbit
    begin apart by q = N h/(V sqrt(k m)), and damping has to do the work q^2/2 in a round, so d = q^2/(2 pi). The
    height is what mu loses before the first of the grid's phases, but for the integral of the cubic through the
    slopes at the first four.

    - `strength`: N/sqrt(k m) in m/s.
    - `phases`: of half a period.
    """
    v = 2 * np.sin(np.pi / (4 * phases) * np.arange(1, 9, 2)) ** 2
    shares = v[0] * np.linalg.solve(np.vander(v / v[0], increasing=True).T, 1 / np.arange(1, 5))
    with np.errstate(all="ignore"):
        seen = V * (slopes(law)(V[:, None] * v) * shares).sum(axis=1)
        height = law.at_speeds(V * v[0]) - law.onset - seen
    found: FloatArray = (strength * height / V) ** 2 / (2 * np.pi)
    return found

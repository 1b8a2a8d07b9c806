"""Weak friction: slip orbits expanded in powers of the friction, and the averages of the slope they start from.

With time in 1/omega, z = x'/V and g(z) = -N mu'(V(1 - z))/sqrt(k m), slip obeys Lienard's equation

    z'' + (d - g(z)) z' + z = 0,    d = c/sqrt(k m).

Its periodic orbit that grazes the belt's speed, z = 1, is expanded in powers of g by the method of Lindstedt and
Poincare; `derivations/d8_second_order.py` proves the formulas. Only the slope of mu enters, never mu itself:
nothing cancels at small belt speeds.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import BoolArray, ComplexArray, FloatArray
from stickslip_sym.core.numbers import ROUNDING
from stickslip_sym.model.bound import BoundLaw

FEWEST_PHASES, _MOST_PHASES = 32, 1024  # in half a period: twice as many each time


# Fourier series on 2 K phases theta_j = (j + 1/2) pi/K of a period, the midpoints of cells: of real functions, by
# z_n for n = 0 to K - 1 with sum of z_n exp(i n theta) + its conjugate; a row each.


def fourier_coefficients(function: FloatArray) -> ComplexArray:
    """Return the coefficients of functions from their values."""
    size = function.shape[-1]
    turn: ComplexArray = np.exp(-1j * np.pi / size * np.arange(size // 2)) / size
    return np.fft.rfft(function)[..., : size // 2] * turn


def values(z: ComplexArray | FloatArray) -> FloatArray:
    """Return the values of functions from their coefficients."""
    size = 2 * z.shape[-1]
    samples: FloatArray = np.fft.irfft(z * np.exp(1j * np.pi / size * np.arange(size // 2)), size) * size
    return samples


class GrazingExpansion(NamedTuple):
    """The slip orbit that grazes the belt's speed, for weak friction; an entry for each belt speed.

    With f = N/sqrt(k m), c/N = `harmonic` + f^2 `second`; the overtones of the velocity go with f.

    - `harmonic`, `second`: in s/m and (s/m)^3.
    - `overtones`: the amplitudes of the overtones times their orders, in s/m.
    - `largest`: the largest slope on the orbit, in s/m.
    - `tail`: size of the highest coefficients of friction, relative; infinite where phases miss a narrow piece of
      the law.
    - `phases`: of half a period, of which it was made.
    """

    harmonic: FloatArray
    second: FloatArray
    overtones: FloatArray
    largest: FloatArray
    tail: FloatArray
    phases: FloatArray

    @property
    def resolved(self) -> BoolArray:
        """Whether the grid resolved the law."""
        return self.tail <= ROUNDING


def expand(
    law: BoundLaw, V: ArrayLike, *, fewest: int = FEWEST_PHASES, most: int = _MOST_PHASES
) -> GrazingExpansion:
    """Expand slip orbits for weak friction.

    - `law`: smooth on the speeds of the orbits.
    - `V`: belt speeds in m/s.
    - `fewest`, `most`: phases in half a period, doubled until they resolve the law.
    """
    V = np.ravel(np.asarray(V, np.float64))
    expansion = GrazingExpansion(*np.full((len(GrazingExpansion._fields), V.size), np.inf))
    size = fewest
    while (again := ~expansion.resolved).any() and size <= most:
        finer = _expand(_falls_over_period(law, V[again], size))
        seen = law.table.resolved(0.0, 2 * V[again], size)
        finer = finer._replace(tail=np.where(seen, finer.tail, np.inf))
        for column, values_there in zip(expansion, finer, strict=True):
            column[again] = values_there
        size = 2 * size
    return expansion


def expansion_changes(
    law: BoundLaw, partial: BoundLaw, V: FloatArray, weak: GrazingExpansion
) -> tuple[FloatArray, FloatArray]:
    """Return how `harmonic` and `second` change with a parameter, or with ln V.

    - `partial`: the derivative of the law by that, as `FrictionLaw.partial` gives it.

    They are of the first and of the third degree in the slopes, so central differences over one step and two are
    exact.
    """
    fall, change = (_falls_over_period(varied, V, int(weak.phases.max())) for varied in (law, partial))
    by_itself = _expand(change)
    step = np.where(by_itself.largest > 0, weak.largest / by_itself.largest, 1.0)

    def second(t: FloatArray) -> FloatArray:
        return _expand(fall + t[:, None] * change).second

    def difference(t: FloatArray) -> FloatArray:
        return (second(t) - second(-t)) / (2 * t)

    return by_itself.harmonic, (4 * difference(step) - difference(2 * step)) / 3


def _falls_over_period(law: BoundLaw, V: FloatArray, size: int) -> FloatArray:
    """Return -mu' at the phases of a harmonic motion, v = V (1 - cos(theta)), a row for each belt speed."""
    theta = (np.arange(size) + 0.5) * (np.pi / size)  # midpoints of cells, so that v = 0 itself is never met
    return -law.at_speeds(2 * V[:, None] * np.sin(theta / 2) ** 2, derivative=True)


def _expand(half: FloatArray) -> GrazingExpansion:
    """Expand from -mu' at the phases of half a period."""
    size = half.shape[1]
    theta = (np.arange(2 * size) + 0.5) * (np.pi / size)
    sine = np.sin(theta)
    n = np.arange(size, dtype=np.float64)
    off_resonance = n**2 - 1
    off_resonance[1] = np.inf  # the fundamental is set by the amplitude
    g = np.hstack([half, half[:, ::-1]])
    feed = -2 * fourier_coefficients(g * sine).imag
    harmonic = feed[:, 1]
    b = feed / off_resonance
    z1 = values(-0.5j * b)
    excess = g - harmonic[:, None]
    a = 2 * n * fourier_coefficients(excess * z1).imag / off_resonance
    a[:, 1] = -((n * b).sum(axis=1) ** 2) / 2 - a[:, 2:].sum(axis=1)
    curvature = values(-1j * n * fourier_coefficients(g)) / sine  # dg/dz, from the derivative by the phase
    second = 2 * ((excess * values(a / 2) + curvature * z1**2 / 2) * np.cos(theta)).mean(axis=1)
    high = np.abs(feed[:, size - size // 4 :]).max(axis=1)
    largest = np.abs(g).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        tail = np.nan_to_num(np.where(high == 0, 0.0, high / largest), nan=np.inf, posinf=np.inf)
    return GrazingExpansion(harmonic, second, np.abs(b) @ n, largest, tail, np.full(len(half), size))


def damping_of_layer(law: BoundLaw, V: FloatArray, strength: FloatArray, phases: ArrayLike) -> FloatArray:
    """Return the damping over sqrt(k m) that a layer of the law at rest may add, of which a grid sees nothing.

    A thin layer acts as a static coefficient that lies higher by its height h: the halves of the grazing orbit
    begin apart by q = N h/(V sqrt(k m)), and damping has to do the work q^2/2 in a round, so d = q^2/(2 pi). The
    height is what mu loses before the first of the grid's phases, but for the integral of the cubic through the
    slopes at about the first four: the speeds there are nearly as the odd squares.

    - `strength`: N/sqrt(k m) in m/s.
    - `phases`: of half a period.
    """
    squares = np.arange(1, 9, 2) ** 2
    shares = np.linalg.solve(np.vander(squares, increasing=True).T, 1 / np.arange(1, 5))
    first = 2 * V * np.sin(np.pi / (4 * np.asarray(phases))) ** 2
    with np.errstate(all="ignore"):
        slopes = law.at_speeds(first[:, None] * squares, derivative=True)
        height = law.table.values(first) - first * (slopes @ shares)
    value: FloatArray = (strength * height / V) ** 2 / (2 * np.pi)
    return value

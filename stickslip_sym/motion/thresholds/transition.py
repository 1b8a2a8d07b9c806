"""`transition_speed`: the belt speeds at which a given damping is just the pure-slip damping, every one.

For a polynomial law a slope average is a polynomial in V, and all its roots are found as such: for the paper's law
(4), from (18). Otherwise the threshold is sampled over 24 decades of V, and every change of sign of threshold
minus c, and every extremum that comes close to one, is followed.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp
from scipy.optimize import brentq, minimize_scalar

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime
from stickslip_sym.core.numbers import exact, lookup
from stickslip_sym.criteria.criterion import catalogue
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import read_rtol, real
from stickslip_sym.motion.orbits.expansion import averages, slopes
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import AVERAGES, Scenes, average, on_orbit, second_order, simulated
from stickslip_sym.motion.thresholds.threshold import METHODS
from stickslip_sym.output import markup

__all__ = ["TransitionSpeed", "transition_speed"]

_DECADES = (-12, 12)
_PER_DECADE = 16
_NEAR = 0.5  # relative distance of c from the threshold by slopes, within which the exact one is looked at
_FINER = 4  # times as dense there
_RESOLVED = 1e-2  # relative error of an expansion from its grid, above which it is no number
_LOOSE, _TIGHT = 1e-6, 1e-12  # relative errors of orbits on a grid of belt speeds, and at a root
_SIMULATED = 1e-9  # and of simulations
_BESIDE = 1e-4  # relative distance at which the slope of the threshold is taken
_SIMULATED_NEAR = 1e-3  # relative distance from the orbit's root within which simulation's is sought
_SHARE = 0.4  # of the last measured speed, up to which belt speeds are tried: motions slip at a little over 2 V
_COARSE_GRID = 10.0 ** np.linspace(-4, 4, 25)  # belt speeds in m/s at which a law that is not smooth is sampled
_ROOT = float(4 * np.finfo(np.float64).eps)


@dataclass(frozen=True)
class TransitionSpeed:
    """A belt speed at which stick-slip begins or ends, the method that gave it, and its estimated relative error.

    Attributes
    ----------
    value : float
        In m/s.
    method : str
    error : float or None
        Estimated error, relative; None where nothing is known of it.
    """

    value: float
    method: str
    error: float | None

    def __str__(self) -> str:
        accuracy = "unknown" if self.error is None else f"{self.error:.0e}"
        return f"{self.value:.10g} m/s ({self.method}, relative error {accuracy})"

    def __repr__(self) -> str:
        return f"TransitionSpeed: {self}"

    def _repr_html_(self) -> str:
        return markup.block(f"transition speed: {self}")


def transition_speed(
    law: FrictionLaw,
    *,
    c: float,
    N: float,
    m: float | None = None,
    k: float | None = None,
    method: str = "auto",
    rtol: float = 1e-3,
    time_limit: float | None = None,
) -> tuple[TransitionSpeed, ...]:
    """Return every belt speed V at which the pure-slip damping is c, ascending.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    c, N : float
        Damping coefficient in kg/s and normal force in N.
    m, k : float, optional
        Mass in kg and stiffness in N/m. Without them errors are not known.
    method : str
        As for `pure_slip_damping`; "auto" gives the cheapest rung whose speeds are all within `rtol` of those of
        the orbit, or of the simulation where that has no value. Without m and k it gives "harmonic".
    rtol : float
        Relative error of V that is good enough, 1e-12 to 1.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Returns
    -------
    tuple of TransitionSpeed
        Empty where there is none: the damping suffices at every belt speed, or at none.

    Raises
    ------
    InputError
        For an unknown method, or numbers that are missing or unusable.
    NotConverged
        If a rung does not reach `rtol`.
    OutOfTime
        When the time limit is reached; it tells the speeds of the last rung that was finished.
    """
    lookup("method", method, dict.fromkeys(METHODS))
    c, rtol = real("c", c), read_rtol(rtol, least=1e-12, most=1.0)
    scene = Scenes.of(law, V=1.0, N=real("N", N), m=m, k=k)
    if scene.m is None and method in ("second_order", "orbit", "simulation"):
        raise InputError(f'method="{method}" needs the mass m and the stiffness k')
    search = _Search(law, c, scene)
    with deadline.time_limit(time_limit):
        try:
            if scene.m is not None:
                return search.climb(rtol) if method == "auto" else search.named(method)
            method = "harmonic" if method == "auto" else method
            return _speeds(search.roots(method), method, None)
        except OutOfTime as stop:
            raise OutOfTime(f"{stop}; {search.so_far}") from None


class _Search:
    """The search for the roots of threshold minus c, for one law and scene."""

    def __init__(self, law: FrictionLaw, c: float, scene: Scenes) -> None:
        self.law, self.c, self.scene = law, c, scene
        self.so_far = "no belt speed was found yet"

    def scenes(self, V: Any) -> Scenes:
        """Return the scene at other belt speeds."""
        N, m, k = (
            None if column is None else np.full(V.shape, column[0])
            for column in (self.scene.N, self.scene.m, self.scene.k)
        )  # fmt: skip
        return Scenes(self.law, V, N, m, k, V.shape)

    def excess(self, method: str, V: Any, orbit_rtol: float = _TIGHT) -> Any:
        """Return threshold minus c at belt speeds; NaN where there is none."""
        deadline.check_time()
        if method in AVERAGES:
            return self._by_slopes(method, V) - self.c
        if method == "second_order":
            value, resolution, _ = second_order(self.scenes(V))
            return np.where(resolution < _RESOLVED, value, np.nan) - self.c
        if method == "orbit":
            # Where the expansion is not resolved by any grid, the orbit is not either.
            value = np.full(V.size, np.nan)
            fine = np.flatnonzero(second_order(self.scenes(V))[1] < _RESOLVED)
            value[fine] = on_orbit(self.scenes(V[fine]), orbit_rtol)[0]
            return value - self.c
        return np.array([self._simulated(self.scenes(V[[row]])) for row in range(V.size)])

    def _by_slopes(self, method: str, V: Any) -> Any:
        if self.law.kinks():
            return average(self.scenes(V), method)
        least_squares, harmonic = averages(self.law, V)
        by_name = {"least_squares": least_squares, "harmonic": harmonic}
        return self.scene.N[0] * (by_name[method] if method in by_name else -slopes(self.law)(V))

    def _simulated(self, scenes: Scenes) -> float:
        try:
            return float(simulated(scenes, _SIMULATED)[0][0]) - self.c
        except NoThreshold:
            return -1.0 - abs(self.c)  # it lies below 0, nobody knows how far
        except NotConverged:
            return math.nan

    def roots(self, method: str) -> Any:
        """Return the roots of a rung, ascending."""
        found = self._roots(method)
        speeds = ", ".join(f"{V:.6g}" for V in found) or "none"
        self.so_far = f"by {method} the speeds are, to an unknown error, {speeds} m/s"
        return found

    def _roots(self, method: str) -> Any:
        if method in AVERAGES and self.law.expr.is_polynomial(symbols.v):
            return self._of_polynomial(method)
        V = 10.0 ** np.linspace(*_DECADES, (_DECADES[1] - _DECADES[0]) * _PER_DECADE + 1)
        smooth = obstacle(self.law, np.inf) is None
        if not smooth:  # each value takes a quadrature or a simulation
            V = _COARSE_GRID
        if self.law.v_max is not None:
            V = np.geomspace(1e-4, _SHARE, V.size) * float(self.law.v_max)
        if method == "simulation" and smooth:
            nearby = [V * (1 + sign * _SIMULATED_NEAR) for V in self.roots("orbit") for sign in (-1, 1)]
            V = np.array(nearby)
        elif method not in (*AVERAGES, "simulation"):
            V = self._near(V)
        return np.array(sorted(self._crossings(method, V)))

    def _of_polynomial(self, method: str) -> Any:
        """Return the roots of c(V), for which the slope is averaged term by term of its expansion about V."""
        V, v = symbols.V, symbols.v
        slope = sp.Poly(self.law.substitute(self.law.expr), v).diff()
        criterion = catalogue[method]
        total = exact(self.c, "c")
        for j in range(slope.degree() // 2 + 1 if not slope.is_zero else 0):
            moment = criterion.even_moment(j) if criterion.weight is not None else sp.Integer(j == 0)
            derivative = slope.diff((v, 2 * j)) if j else slope
            total += (
                exact(self.scene.N[0], "N")
                * moment
                * derivative.as_expr().subs(v, V)
                * V ** (2 * j)
                / sp.factorial(2 * j)
            )
        polynomial = sp.Poly(total, V)
        if polynomial.is_ground:
            return np.empty(0)
        found = {float(root.evalf(20)) for root in polynomial.real_roots()}
        return np.array(sorted(root for root in found if root > 0))

    def _near(self, V: Any) -> Any:
        """Return a finer grid, near where the harmonic threshold comes close to c."""
        with np.errstate(all="ignore"):
            off = self.excess("harmonic", V)
            near = np.abs(off) <= _NEAR * (np.abs(off + self.c) + abs(self.c))
            near[:-1] |= np.sign(off[:-1]) != np.sign(off[1:])
        near = np.convolve(near & np.isfinite(off), np.ones(5), "same") > 0
        exponents = np.log10(V)
        fine = np.linspace(exponents[0], exponents[-1], _FINER * (V.size - 1) + 1)
        return 10.0 ** fine[np.interp(fine, exponents, near) > 0]

    def _crossings(self, method: str, V: Any) -> list[float]:
        """Return the places where a rung's excess changes sign, also between two points of a grid."""

        def single(logarithm: float) -> float:
            value = float(self.excess(method, np.exp([logarithm]))[0])
            if np.isnan(value):
                raise NotConverged(
                    f"there is no {method} threshold at V = {np.exp(logarithm):g}; try another method"
                )
            return value

        asked = V.size
        with np.errstate(all="ignore"):
            off = self.excess(method, V, _LOOSE)
        V, off = V[np.isfinite(off)], off[np.isfinite(off)]
        if asked and not V.size:
            raise NotConverged(f"there is no {method} threshold at any belt speed; try another method")
        if not V.size:
            return []
        x = np.log(V)
        brackets = [(x[i], x[i + 1]) for i in np.flatnonzero(np.sign(off[:-1]) * np.sign(off[1:]) < 0)]
        size = np.abs(off)
        close = size <= _NEAR * (np.abs(off + self.c) + abs(self.c))
        for i in range(1, V.size - 1):
            if (
                close[i]
                and size[i] < min(size[i - 1], size[i + 1])
                and off[i - 1] * off[i] > 0 < off[i] * off[i + 1]
            ):
                sign = np.sign(off[i])
                dip = minimize_scalar(
                    lambda y, sign=sign: sign * single(y), bounds=(x[i - 1], x[i + 1]), method="bounded"
                )
                if dip.fun < 0:
                    brackets += [(x[i - 1], dip.x), (dip.x, x[i + 1])]
        found = [float(np.exp(brentq(single, *bracket, xtol=1e-15, rtol=_ROOT))) for bracket in brackets]
        # A zero beside zeros is a threshold too small for double precision, not one that changes sign.
        padded = np.concatenate(([0.0], off, [0.0]))
        crossed = (off == 0) & (padded[:-2] != 0) & (padded[2:] != 0)
        return [*found, *V[crossed].tolist()]

    def named(self, method: str) -> tuple[TransitionSpeed, ...]:
        """Return the roots of a rung; the error of the two exact ones is known."""
        reason = obstacle(self.law, np.inf)
        if reason is not None and method in ("second_order", "orbit"):
            raise InputError(f'method="{method}" needs a law that is smooth: {reason}; try method="simulation"')
        found = self.roots(method)
        return _speeds(found, method, self._doubt(method, found) if method in ("orbit", "simulation") else None)

    def climb(self, rtol: float) -> tuple[TransitionSpeed, ...]:
        """Return the roots of the cheapest rung that are all known to be close enough to the exact ones."""
        smooth = obstacle(self.law, np.inf) is None
        if smooth:
            expected = self.roots("second_order")
            for method in (*AVERAGES, "second_order"):
                V = self.roots(method)
                if V.size == expected.size and ((error := self._distance(V, rtol)) <= rtol).all():
                    return _speeds(V, method, error)
        for method in ("orbit", "simulation") if smooth else ("simulation",):
            V = self.roots(method)
            if ((error := self._doubt(method, V)) <= rtol).all():
                return _speeds(V, method, error)
        raise NotConverged(f"the belt speeds are known to {error.max():.1e} relative only, not to rtol = {rtol:g}")

    def _distance(self, V: Any, rtol: float) -> Any:
        """Return how far speeds are from the exact ones, by a step of Newton's method on the orbit."""
        if not V.size:
            return V
        below, above = (self.excess("second_order", V * (1 + shift)) for shift in (-_BESIDE, _BESIDE))
        value, error, _ = on_orbit(self.scenes(V), rtol / 10)
        with np.errstate(all="ignore"):
            off = np.abs(value - self.c) + error * np.abs(value)
            distance = off * 2 * _BESIDE / np.abs(above - below)
        return np.where(np.isnan(distance), np.inf, distance)

    def _doubt(self, method: str, V: Any) -> Any:
        """Return the relative error of roots, from the error of the threshold and its slope beside them."""
        below, above = (self.excess(method, V * (1 + shift)) for shift in (-_BESIDE, _BESIDE))
        error = np.full(V.size, _SIMULATED)
        if method == "orbit":
            error = on_orbit(self.scenes(V * (1 + _BESIDE)), _TIGHT)[1]
        with np.errstate(divide="ignore"):
            return error * np.abs(above + self.c) * 2 * _BESIDE / np.abs(above - below) + _ROOT


def _speeds(V: Any, method: str, error: Any) -> tuple[TransitionSpeed, ...]:
    errors = [None] * len(V) if error is None else error.tolist()
    return tuple(TransitionSpeed(value, method, doubt) for value, doubt in zip(V.tolist(), errors, strict=True))

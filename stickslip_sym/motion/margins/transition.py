"""`transition_speed`: the belt speeds at which a given damping is just the pure-slip damping, every one.

For a polynomial law a slope average is a polynomial in V, and all its roots are found as such: for the paper's law
(4), from (18). Otherwise the threshold is sampled over 24 decades of V, and every change of sign of threshold
minus c, and every extremum that comes close to one, is followed.
"""

import math
from dataclasses import dataclass

import numpy as np
import sympy as sp
from scipy.optimize import brentq, minimize_scalar

from stickslip_sym.core import deadline, symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NotConverged, NoThreshold, OutOfTime
from stickslip_sym.core.numbers import exact, read_rtol, real
from stickslip_sym.criteria.criterion import Criterion, harmonic
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import averages, slopes
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import Rung, average, find, ladder, rungs, second_order
from stickslip_sym.motion.thresholds.scenes import Scenes
from stickslip_sym.output import markup

__all__ = ["Search", "TransitionSpeed", "transition_speed"]

_DECADES = (-12, 12)  # powers of ten of the belt speeds in m/s that are sampled
_PER_DECADE = 16  # belt speeds sampled
_NEAR = 0.5  # relative distance of c from the threshold by slopes, within which the exact one is looked at
_FINER = 4  # ratio of the density of the grid there to that elsewhere
_RESOLVED = 1e-2  # relative error of an expansion from its grid, above which it is not used
_LOOSE, _TIGHT = 1e-6, 1e-12  # relative errors of orbits on a grid of belt speeds, and at a root
_SINGLE = 1e-9  # relative error of rungs that take scenes one by one
_BESIDE = 1e-4  # relative distance at which the slope of the threshold is taken
_SINGLE_NEAR = 1e-3  # relative distance from the orbit's root within which simulation's is sought
_SHARE = 0.4  # of the last measured speed, up to which belt speeds are tried: motions slip at a little over 2 V
_COARSE_GRID = 10.0 ** np.linspace(-4, 4, 25)  # belt speeds in m/s at which a law that is not smooth is sampled
_ROOT = float(4 * np.finfo(np.float64).eps)  # relative tolerance of a root, the least that brentq takes
_WEAK = rungs()[harmonic.name]  # the limit of weak friction


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
    method: str | Criterion | Rung = "auto",
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
    method : str, Criterion or Rung
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
    rung = find(method)
    c, rtol = real("c", c), read_rtol(rtol, least=1e-12, most=1.0)
    scene = Scenes.of(law, V=1.0, N=real("N", N), m=m, k=k)
    if rung is not None:
        rung.require_oscillator(scene.m)
    search = Search(law, c, scene)
    with deadline.time_limit(time_limit):
        try:
            if scene.m is not None:
                return search.climb(rtol) if rung is None else search.named(rung)
            rung = rung or _WEAK
            return _speeds(search.roots(rung), rung, None)
        except OutOfTime as stop:
            raise OutOfTime(f"{stop}; {search.so_far}") from None


class Search:
    """The search for the roots of threshold minus c, for one law and scene, along the belt speed."""

    of = "V"
    closest = 1e-15  # tolerance of the logarithm of a root

    def __init__(self, law: FrictionLaw, c: float, scene: Scenes) -> None:
        self.law, self.c, self.scene = law, c, scene
        self.so_far = "no belt speed was found yet"

    def scenes(self, V: FloatArray) -> Scenes:
        """Return the scene at other belt speeds."""
        m, k = (None if one is None else np.full(V.shape, one[0]) for one in (self.scene.m, self.scene.k))
        return Scenes(self.law, V, np.full(V.shape, self.scene.N[0]), m, k, V.shape)

    def excess(self, rung: Rung, V: FloatArray, orbit_rtol: float = _TIGHT) -> FloatArray:
        """Return threshold minus c at belt speeds; NaN where there is none."""
        deadline.check_time()
        if rung.criterion is not None:
            return self._by_slopes(rung.criterion, V) - self.c
        if rung.singly:
            return np.array([self._single(rung, self.scenes(V[[row]])) for row in range(V.size)])
        # Where the expansion is not resolved by any grid, the orbit is not either.
        weak, resolution, _ = second_order(self.scenes(V))
        value, fine = np.full(V.size, np.nan), np.flatnonzero(resolution < _RESOLVED)
        if rung.knows_its_error:
            value[fine] = rung.compute(self.scenes(V[fine]), orbit_rtol).value
        else:
            value[fine] = weak[fine]
        return value - self.c

    def _by_slopes(self, criterion: Criterion, V: FloatArray) -> FloatArray:
        if self.law.kinks():
            return average(self.scenes(V), criterion)
        if criterion.weight is None:
            found = -slopes(self.law)(V)
        else:
            (found,) = averages(self.law, V, criteria=[criterion])
        return float(self.scene.N[0]) * found

    def _single(self, rung: Rung, scenes: Scenes) -> float:
        try:
            return float(rung.compute(scenes, _SINGLE).value[0]) - self.c
        except NoThreshold:
            return -1.0 - abs(self.c)  # below 0, by an unknown amount
        except NotConverged:
            return math.nan

    def roots(self, rung: Rung) -> FloatArray:
        """Return the roots of a rung, ascending."""
        found = self._roots(rung)
        speeds = ", ".join(f"{V:.6g}" for V in found) or "none"
        self.so_far = f"by {rung.name} the speeds are, to an unknown error, {speeds} m/s"
        return found

    def _roots(self, rung: Rung) -> FloatArray:
        if rung.criterion is not None and self.law.expr.is_polynomial(symbols.v):
            return self._of_polynomial(rung.criterion)
        V: FloatArray = 10.0 ** np.linspace(*_DECADES, (_DECADES[1] - _DECADES[0]) * _PER_DECADE + 1)
        smooth = obstacle(self.law, np.inf) is None
        if not smooth:  # each value takes a quadrature or a simulation
            V = _COARSE_GRID
        if self.law.v_max is not None:
            V = np.geomspace(1e-4, _SHARE, V.size) * float(self.law.v_max)
        if rung.smooth:
            V = self.near(V)
        elif rung.singly and smooth:
            orbit = rungs()["orbit"]
            V = np.array([V * (1 + sign * _SINGLE_NEAR) for V in self.roots(orbit) for sign in (-1, 1)])
        return np.array(sorted(self.crossings(rung, V)))

    def _of_polynomial(self, criterion: Criterion) -> FloatArray:
        """Return the roots of c(V), for which the slope is averaged term by term of its expansion about V."""
        V, v = symbols.V, symbols.v
        slope, N = sp.Poly(self.law.substitute(self.law.expr), v).diff(), exact(self.scene.N[0], "N")
        total = exact(self.c, "c")
        for j in range(slope.degree() + 1 if not slope.is_zero else 0):
            derivative = slope.diff((v, j)) if j else slope
            total += N * criterion.moment(j) * derivative.as_expr().subs(v, V) * V**j / sp.factorial(j)
        polynomial = sp.Poly(total, V)
        if polynomial.is_ground:
            return np.empty(0)
        found = {float(root.evalf(20)) for root in polynomial.real_roots()}
        return np.array(sorted(root for root in found if root > 0))

    def near(self, V: FloatArray) -> FloatArray:
        """Return a finer grid, near where the harmonic threshold comes close to c."""
        with np.errstate(all="ignore"):
            off = self.excess(_WEAK, V)
            near = np.abs(off) <= _NEAR * (np.abs(off + self.c) + abs(self.c))
            near[:-1] |= np.sign(off[:-1]) != np.sign(off[1:])
        near = np.convolve(near & np.isfinite(off), np.ones(5), "same") > 0
        exponents = np.log10(V)
        fine = np.linspace(exponents[0], exponents[-1], _FINER * (V.size - 1) + 1)
        return 10.0 ** fine[np.interp(fine, exponents, near) > 0]

    def crossings(self, rung: Rung, V: FloatArray) -> list[float]:
        """Return the places where a rung's excess changes sign, also between two points of a grid."""

        def single(logarithm: float) -> float:
            value = float(self.excess(rung, np.exp([logarithm]))[0])
            if np.isnan(value):
                raise NotConverged(
                    f"there is no {rung.name} threshold at {self.of} = {np.exp(logarithm):g}; try another method"
                )
            return value

        asked = V.size
        with np.errstate(all="ignore"):
            off = self.excess(rung, V, _LOOSE)
        V, off = V[np.isfinite(off)], off[np.isfinite(off)]
        if asked and not V.size:
            raise NotConverged(f"there is no {rung.name} threshold at any {self.of}; try another method")
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
        found = [float(np.exp(brentq(single, *bracket, xtol=self.closest, rtol=_ROOT))) for bracket in brackets]
        # A zero beside zeros is a threshold too small for double precision, not one that changes sign.
        padded = np.concatenate(([0.0], off, [0.0]))
        crossed = (off == 0) & (padded[:-2] != 0) & (padded[2:] != 0)
        return [*found, *V[crossed].tolist()]

    def named(self, rung: Rung) -> tuple[TransitionSpeed, ...]:
        """Return the roots of a rung; the error of those that know their own is known."""
        rung.require_smooth(self.law, np.inf)
        found = self.roots(rung)
        return _speeds(found, rung, self._doubt(rung, found) if rung.knows_its_error else None)

    def climb(self, rtol: float) -> tuple[TransitionSpeed, ...]:
        """Return the roots of the cheapest rung that are all known to be close enough to the exact ones."""
        smooth = obstacle(self.law, np.inf) is None
        climbed = ladder(smooth)
        lower = [rung for rung in climbed if not rung.knows_its_error]
        if smooth:
            expected = self.roots(lower[-1])
            for rung in lower:
                V = self.roots(rung)
                if V.size == expected.size and ((error := self.distance(V, rtol)) <= rtol).all():
                    return _speeds(V, rung, error)
        for rung in climbed:
            if rung.knows_its_error:
                V = self.roots(rung)
                if ((error := self._doubt(rung, V)) <= rtol).all():
                    return _speeds(V, rung, error)
        raise NotConverged(f"the belt speeds are known to {error.max():.1e} relative only, not to rtol = {rtol:g}")

    def distance(self, V: FloatArray, rtol: float) -> FloatArray:
        """Return how far speeds are from the exact ones, by a step of Newton's method on the orbit."""
        if not V.size:
            return V
        weak, orbit = rungs()["second_order"], rungs()["orbit"]
        below, above = (self.excess(weak, V * (1 + shift)) for shift in (-_BESIDE, _BESIDE))
        found = orbit.compute(self.scenes(V), rtol / 10)
        with np.errstate(all="ignore"):
            off = np.abs(found.value - self.c) + found.error * np.abs(found.value)
            distance = off * 2 * _BESIDE / np.abs(above - below)
        return np.where(np.isnan(distance), np.inf, distance)

    def _doubt(self, rung: Rung, V: FloatArray) -> FloatArray:
        """Return the relative error of roots, from the error of the threshold and its slope beside them."""
        below, above = (self.excess(rung, V * (1 + shift)) for shift in (-_BESIDE, _BESIDE))
        error: FloatArray = np.full(V.size, _SINGLE)
        if not rung.singly:
            error = rung.compute(self.scenes(V * (1 + _BESIDE)), _TIGHT).error
        with np.errstate(divide="ignore"):
            doubt: FloatArray = error * np.abs(above + self.c) * 2 * _BESIDE / np.abs(above - below) + _ROOT
        return doubt


def _speeds(V: FloatArray, rung: Rung, error: FloatArray | None) -> tuple[TransitionSpeed, ...]:
    errors = [None] * len(V) if error is None else error.tolist()
    return tuple(TransitionSpeed(value, rung.name, doubt) for value, doubt in zip(V.tolist(), errors, strict=True))

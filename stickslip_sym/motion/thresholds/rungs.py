"""The rungs of the ladder towards the exact threshold, in the order in which they are climbed.

Every criterion is a rung, an average of the slope of mu. One more way is one `Rung`, added by `add`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import Enum
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.numbers import lookup
from stickslip_sym.criteria import criterion as criteria
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.expansion import LARGEST_GRID, SMALLEST_GRID, averages, expand
from stickslip_sym.motion.orbits.orbit import obstacle, orbits
from stickslip_sym.motion.thresholds.scenes import Scenes

if TYPE_CHECKING:
    from stickslip_sym.formula.evaluation.averages import SlopeAverage
    from stickslip_sym.motion.thresholds.theorem import Theorem

__all__ = [
    "Basis", "Found", "Rung", "add", "average", "find", "ladder", "numerical_averages", "rungs", "second_order",
]  # fmt: skip

ROUNDING = 1e-14
_LOOSEST = 1e-7  # of a simulation: what it costs hardly depends on it, and stiff motions get lost in rounding
_TIGHTER = (0.1, 1e-3, 1e-5)  # tolerances of simulation over rtol, until the error is at most that
_RESOLVED = 0.1  # part of rtol that the grid of an expansion may leave unresolved
_HOPELESS = 100.0  # times rtol: a next order that no finer grid brings down to it
_FINE = 1e-6  # rtol below which a stiff simulation takes ten times as long
_QUICK = (3e6, 3e7)  # cubes of grids that the orbit of one scene may take before a simulation is quicker; if fine
_PART = 0.5  # of rtol, that an orbit is asked for: its error is not told from its tail alone


class Basis(Enum):
    """What the error of a rung rests on."""

    DIFFERENCE = "its difference from the best value known"
    ESTIMATE = "an estimate of its own"
    BOUND = "a proof"


@dataclass(frozen=True)
class Found:
    """What a rung says of scenes.

    Attributes
    ----------
    value : numpy.ndarray
        In kg/s.
    error : numpy.ndarray
        Relative, infinite where there is no value. Where it rests on a difference, the part that the rung knows
        of by itself, its resolution.
    reason : str
        Why an error is larger than was asked for.
    theorems : tuple
        What was proved of each scene, if anything was.
    """

    value: FloatArray
    error: FloatArray
    reason: str = ""
    theorems: "tuple[Theorem, ...]" = ()


def _one_attempt(rtol: float) -> tuple[float, ...]:
    return (rtol / 10,)


@dataclass(frozen=True)
class Rung:
    """One way to a threshold.

    Attributes
    ----------
    name : str
    compute : callable
        From scenes, and the relative error that is good enough, to what is `Found`.
    rests_on : Basis
        What its error rests on.
    criterion : Criterion or None
        That of an average.
    oscillator, smooth : bool
        Whether it needs m and k, and whether a smooth law.
    singly : bool
        Whether scenes are computed one by one, each at some cost: "auto" asks it last.
    automatic : bool
        Whether "auto" may ask it.
    best, tightest, loosest : float
        The relative error it reaches, to compare others with it, and the smallest and the largest that it can be
        asked for.
    reachable : float
        An error that is never refused.
    attempts : callable
        From the relative error that is wanted to those it is asked for, one after another, in "auto".
    quickly : callable or None
        As `compute`, where that takes less work than a simulation, with an estimate of the whole error; infinite
        where it takes more. "auto" asks it first.
    """

    name: str
    compute: Callable[[Scenes, float], Found]
    rests_on: Basis
    criterion: Criterion | None = None
    oscillator: bool = True
    smooth: bool = False
    singly: bool = False
    automatic: bool = True
    best: float = 1e-12
    tightest: float = 1e-13
    loosest: float = 1.0
    reachable: float = 0.0
    attempts: Callable[[float], tuple[float, ...]] = _one_attempt
    quickly: Callable[[Scenes, float], Found] | None = None

    @property
    def knows_its_error(self) -> bool:
        """Whether its error needs no other rung."""
        return self.rests_on is not Basis.DIFFERENCE

    def require_oscillator(self, m: FloatArray | None) -> None:
        """Refuse to do without m and k where they are needed, by an `InputError`."""
        if self.oscillator and m is None:
            raise InputError(f'method="{self.name}" needs the mass m and the stiffness k')

    def require_smooth(self, law: FrictionLaw, V: ArrayLike) -> None:
        """Refuse a law that is not smooth where it has to be, by an `InputError`."""
        reason = obstacle(law, V) if self.smooth else None
        if reason is not None:
            raise InputError(f'method="{self.name}" needs a law that is smooth: {reason}; try method="simulation"')


_table: dict[str, Rung] = {}


def add(rung: Rung) -> None:
    """Put a rung on top of the ladder; raises `InputError` if there is one of that name."""
    if rung.name in rungs() or rung.name == "auto":
        raise InputError(f"there is a rung {rung.name!r} already; give the new one another name")
    _table[rung.name] = rung


def rungs() -> dict[str, Rung]:
    """Return the ladder: the averages by the criteria of the catalogue, and what comes closer."""
    return {name: _average_rung(criterion) for name, criterion in criteria.catalogue.items()} | _table


def ladder(smooth: bool) -> list[Rung]:
    """Return the rungs that "auto" may climb, for a law that is smooth, or for any."""
    return [rung for rung in rungs().values() if rung.automatic and (smooth or not rung.smooth)]


def find(method: "str | Criterion | Rung") -> Rung | None:
    """Return the rung of a method; None for "auto".

    Raises
    ------
    InputError
        If there is none of that name.
    """
    if isinstance(method, Rung):
        return method
    if isinstance(method, Criterion):
        return _average_rung(method)
    known: dict[str, Rung | None] = {**rungs(), "auto": None}
    return lookup("method", method, known)


# -- averages of the slope -------------------------------------------------------------------------


@lru_cache(maxsize=32)
def _average_rung(criterion: Criterion) -> Rung:
    def compute(scenes: Scenes, rtol: float) -> Found:
        del rtol
        return Found(average(scenes, criterion), np.zeros(len(scenes)))

    return Rung(criterion.name, compute, Basis.DIFFERENCE, criterion, oscillator=False)


@dataclass(frozen=True)
class _Shape:
    """A law up to the values of its parameters; equal for equal formulas."""

    expr: Expr
    law: FrictionLaw = field(compare=False)


@lru_cache(maxsize=128)
def _slope_average(shape: _Shape, criterion: Criterion) -> "SlopeAverage":
    from stickslip_sym.formula.evaluation.averages import slope_average

    return slope_average(shape.law.with_static(None), criterion)  # no slope average sees it, nor its parameters


def average(scenes: Scenes, criterion: Criterion) -> FloatArray:
    """Return a criterion's damping; no closed form is derived for it."""
    compiled = _slope_average(_Shape(scenes.law.expr, scenes.law), criterion)
    values: dict[str, Any] = {
        name: float(value) for name, value in scenes.law.values.items() if name in compiled.arguments
    }
    return np.atleast_1d(compiled(V=scenes.V, N=scenes.N, **values))


def numerical_averages(scenes: Scenes) -> dict[str, FloatArray]:
    """Return the dampings of the catalogue's criteria for a smooth law without any derivation."""
    law, N = scenes.law, scenes.N
    chosen = list(criteria.catalogue.values())
    found = averages(law, scenes.V, criteria=[one for one in chosen if one.is_average])
    finite = np.isfinite(sum(found))
    if not finite.all():
        row = int(np.flatnonzero(~finite)[0])
        raise InputError(f"mu has no finite slope somewhere between 0 and 2 V, for {scenes.label(row)}: {law!r}")
    weighted = iter(found)
    return {one.name: N * (-law.slope(scenes.V) if not one.is_average else next(weighted)) for one in chosen}


# -- the rungs that need m and k -------------------------------------------------------------------


def second_order(scenes: Scenes, rtol: float = 0.0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the damping to second order in the friction, its resolution, and what the next order may add.

    Both are relative errors. The resolution is that of the grid, which is no finer than `rtol` requires, nor
    refined where the next order is far above it. The expansion goes by the square of the orbit's distortion, the
    amplitudes of the overtones times their orders: friction changes along an orbit as fast as its highest ones do.
    It is one of the largest slope, not of the average, in which slopes may cancel.
    """
    found = np.empty((3, len(scenes)))
    (everything,) = averages(scenes.law, scenes.V)
    size, rows = SMALLEST_GRID, np.arange(len(scenes))
    while rows.size:
        strength, N = scenes.N[rows] / scenes.impedance[rows], scenes.N[rows]
        with np.errstate(all="ignore"):  # for strong friction the expansion is no number, or a huge one
            weak = expand(scenes.law, scenes.V[rows], grid=size)
            value = N * (weak.harmonic + strength**2 * weak.second)
            # `tail` is relative to the largest slope.
            resolution = np.where(weak.tail == 0, 0.0, weak.tail * weak.largest / np.abs(weak.harmonic))
            # A layer of the law between v = 0 and the first phase would pass unseen.
            unseen = np.abs(weak.harmonic - everything[rows])
            resolution += np.where(unseen == 0, 0.0, unseen / np.abs(weak.harmonic))
            distortion = strength * (np.abs(weak.sines) @ np.arange(weak.sines.shape[1]))
            scale = N * np.maximum(weak.largest, np.abs(everything[rows]))
            next_order = np.where(distortion == 0, 0.0, distortion**4 * scale / np.abs(value))
        resolution = np.where(np.isfinite(value), resolution, np.inf)
        found[:, rows] = value, resolution, np.where(np.isnan(next_order), np.inf, next_order)
        coarse = ~weak.resolved & ~(resolution <= _RESOLVED * rtol)
        hopeless = (rtol > 0) & ~(next_order <= _HOPELESS * rtol)
        size, rows = 2 * size, rows[coarse & ~hopeless] if size < LARGEST_GRID else rows[:0]
    return found[0], found[1], found[2]


def _second_order(scenes: Scenes, rtol: float) -> Found:
    value, resolution, _ = second_order(scenes)
    return Found(value, resolution, f"1024 phases do not resolve the slope of mu to {rtol:g}")


def _weak(scenes: Scenes, rtol: float) -> Found:
    value, resolution, next_order = second_order(scenes, rtol)
    return Found(value, next_order + resolution + ROUNDING, "friction is too strong for its second order")


def _on_orbit(scenes: Scenes, rtol: float, most_work: float | None = None) -> Found:
    """Return the damping of the grazing orbit; with a bound on the work by collocation alone."""
    strength, bound = scenes.N / scenes.impedance, most_work or np.inf
    found = orbits(scenes.law, scenes.V, strength, rtol=rtol, most_work=bound, shots=most_work is None)
    value, error = found.d * scenes.impedance, found.relative_error
    reason = obstacle(scenes.law, scenes.V, float(found.lowest.min(initial=0.0)))
    if reason is not None:
        return Found(np.full_like(value, np.nan), np.full_like(error, np.inf), reason)
    reason = "friction is too strong, or its law not smooth enough at v = 0, for the bound on work"
    return Found(value, error, reason)


def _small_orbit(scenes: Scenes, rtol: float) -> Found:
    return _on_orbit(scenes, _PART * rtol, _QUICK[rtol < _FINE] * len(scenes))


def _simulated(scenes: Scenes, rtol: float) -> Found:
    """Return the damping at which the simulated orbit grazes."""
    from stickslip_sym.model.oscillator import Oscillator
    from stickslip_sym.motion.thresholds.grazing import grazing_damping

    found = np.empty((2, len(scenes)))
    for row, (V, N, m, k) in enumerate(zip(scenes.V, scenes.N, scenes.m, scenes.k, strict=True)):
        found[:, row] = grazing_damping(scenes.law, Oscillator(m=m, k=k, V=V, N=N), rtol=rtol)
    return Found(found[0], found[1])


def _proved(scenes: Scenes, rtol: float) -> Found:
    """Return the middle of the dampings between which the threshold was proved to lie."""
    from stickslip_sym.motion.thresholds.proof import theorems

    found = tuple(theorems(scenes, rtol))
    enclosures = [theorem.enclosure for theorem in found]
    value = np.array([float(enclosure) for enclosure in enclosures])
    error = np.array([float(one.radius / abs(one.mid)) for one in enclosures])
    return Found(value, error, theorems=found)


def _tighter(rtol: float) -> tuple[float, ...]:
    return tuple(dict.fromkeys(min(max(rtol * part, 1e-13), _LOOSEST) for part in _TIGHTER))  # none twice


add(Rung("second_order", _second_order, Basis.DIFFERENCE, smooth=True, best=1.0, quickly=_weak))
# The orbit's error is rounding where thresholds are near 0.
add(Rung("orbit", _on_orbit, Basis.ESTIMATE, smooth=True, reachable=1e-9, quickly=_small_orbit))
add(Rung("simulation", _simulated, Basis.ESTIMATE, singly=True, best=1e-10, loosest=1e-3, reachable=np.inf,
         attempts=_tighter))  # fmt: skip
add(Rung("proof", _proved, Basis.BOUND, singly=True, automatic=False, tightest=1e-40, loosest=1e-3))

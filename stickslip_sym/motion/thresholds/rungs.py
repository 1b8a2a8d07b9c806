"""The rungs of the ladder towards the exact threshold: each a function of scenes, by arrays."""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.errors import InputError
from stickslip_sym.formula.evaluation.averages import SlopeAverage, slope_average
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.expansion import averages, expand
from stickslip_sym.motion.orbits.orbit import obstacle, orbits
from stickslip_sym.motion.thresholds.grazing import grazing_damping

__all__ = [
    "AVERAGES", "Scenes", "average", "numerical_averages", "on_orbit", "second_order", "simulated",
]  # fmt: skip

AVERAGES = ("equilibrium", "least_squares", "harmonic")


@dataclass(frozen=True)
class Scenes:
    """Scenes of one law, flat arrays of one length; m and k are None where they were not given."""

    law: FrictionLaw
    V: Any
    N: Any
    m: Any
    k: Any
    shape: tuple[int, ...]

    @classmethod
    def of(cls, law: FrictionLaw, **values: ArrayLike | None) -> "Scenes":
        """Broadcast V, N, m and k.

        Raises
        ------
        InputError
            For numbers that are not finite or have the wrong sign, shapes that do not broadcast, or only one
            of m and k.
        """
        given = {name: _column(name, value) for name, value in values.items() if value is not None}
        if ("m" in given) != ("k" in given):
            raise InputError("give both the mass m and the stiffness k, or neither")
        try:
            columns = dict(zip(given, np.broadcast_arrays(*given.values()), strict=True))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in given.items())
            raise InputError(f"the shapes do not broadcast: {shapes}") from None
        flat = {name: column.ravel() for name, column in columns.items()}
        return cls(law, flat["V"], flat["N"], flat.get("m"), flat.get("k"), columns["V"].shape)

    def __len__(self) -> int:
        return len(self.V)

    def rows(self, chosen: Any) -> "Scenes":
        """Return some of the scenes."""
        m, k = (None if column is None else column[chosen] for column in (self.m, self.k))
        return Scenes(self.law, self.V[chosen], self.N[chosen], m, k, self.V[chosen].shape)

    @property
    def impedance(self) -> Any:
        """The unit of damping, sqrt(k m) in kg/s."""
        return np.sqrt(self.k) * np.sqrt(self.m)

    def label(self, row: int) -> str:
        """Say which scene it is."""
        columns = (("V", self.V), ("N", self.N), ("m", self.m), ("k", self.k))
        return ", ".join(f"{name} = {column[row]:g}" for name, column in columns if column is not None)


def _column(name: str, value: ArrayLike) -> Any:
    if np.ma.is_masked(value):
        raise InputError(f"{name} has masked entries; drop them, or fill them with a number")
    try:
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} = {str(value)[:60]!r} is no number or array of numbers; try 0.5") from None
    if not np.isfinite(array).all():
        raise InputError(f"{name} holds a value that is not finite; give a float such as 0.5")
    lowest = array.min(initial=np.inf)
    if lowest < 0 or (lowest == 0 and name != "N"):
        required = "not be negative" if name == "N" else "be positive"
        raise InputError(f"{name} = {lowest:g} must {required}: it is the {symbols.QUANTITIES[name].meaning}")
    return array


# -- averages of the slope -------------------------------------------------------------------------


@dataclass(frozen=True)
class _Shape:
    """A law up to the values of its parameters; equal for equal formulas."""

    expr: Any
    law: FrictionLaw = field(compare=False)


@lru_cache(maxsize=128)
def _slope_average(shape: _Shape, criterion: str) -> SlopeAverage:
    return slope_average(shape.law, criterion)


def average(scenes: Scenes, criterion: str) -> Any:
    """Return a criterion's damping; no closed form is derived for it."""
    values: dict[str, Any] = {name: float(value) for name, value in scenes.law.values.items()}
    compiled = _slope_average(_Shape(scenes.law.expr, scenes.law), criterion)
    return np.atleast_1d(compiled(V=scenes.V, N=scenes.N, **values))


def numerical_averages(scenes: Scenes) -> dict[str, Any]:
    """Return the criteria's dampings for a smooth law without any derivation."""
    law, N = scenes.law, scenes.N
    fit, harmonic = averages(law, scenes.V)
    found = {"equilibrium": N * -law.slope(scenes.V), "least_squares": N * fit, "harmonic": N * harmonic}
    if not np.isfinite(harmonic + fit).all():
        row = int(np.flatnonzero(~np.isfinite(harmonic + fit))[0])
        raise InputError(f"mu has no finite slope somewhere between 0 and 2 V, for {scenes.label(row)}: {law!r}")
    return found


# -- the rungs that need m and k -------------------------------------------------------------------


def second_order(scenes: Scenes) -> tuple[Any, Any, Any]:
    """Return the damping to second order in the friction, its resolution, and what the next order may add.

    Both are relative errors. The resolution is that of the grid. The expansion goes by the square of the orbit's
    distortion, the amplitudes of the overtones times their orders: friction changes along an orbit as fast as its
    highest overtones do. It is one of the largest slope, not of the average, in which slopes may cancel.
    """
    weak = expand(scenes.law, scenes.V)
    e = scenes.N / scenes.impedance
    with np.errstate(all="ignore"):  # for strong friction the expansion is no number, or a huge one
        value = scenes.N * (weak.harmonic + e**2 * weak.second)
        # `tail` is relative to the largest slope.
        resolution = np.where(weak.tail == 0, 0.0, weak.tail * weak.largest / np.abs(weak.harmonic))
        # A layer of the law between v = 0 and the first phase would pass unseen.
        everything = averages(scenes.law, scenes.V)[1]
        unseen = np.abs(weak.harmonic - everything)
        resolution += np.where(unseen == 0, 0.0, unseen / np.abs(weak.harmonic))
        distortion = e * (np.abs(weak.sines) @ np.arange(weak.sines.shape[1]))
        size = scenes.N * np.maximum(weak.largest, np.abs(everything))
        next_order = np.where(distortion == 0, 0.0, distortion**4 * size / np.abs(value))
    return value, resolution, np.where(np.isnan(next_order), np.inf, next_order)


def on_orbit(scenes: Scenes, rtol: float) -> tuple[Any, Any, str]:
    """Return the damping of the grazing orbit, its relative error, and the reason where that is infinite."""
    found = orbits(scenes.law, scenes.V, scenes.N / scenes.impedance, rtol=rtol)
    value, error = found.d * scenes.impedance, found.relative_error
    reason = obstacle(scenes.law, scenes.V, float(found.lowest.min(initial=0.0)))
    if reason is not None:
        return np.full_like(value, np.nan), np.full_like(error, np.inf), reason
    reason = "friction is too strong, or its law not smooth enough at v = 0, for the bound on work"
    return value, error, reason


def simulated(scenes: Scenes, rtol: float) -> tuple[Any, Any]:
    """Return the damping at which the simulated orbit grazes, and its estimated relative error."""
    found = np.empty((2, len(scenes)))
    for row, (V, N, m, k) in enumerate(zip(scenes.V, scenes.N, scenes.m, scenes.k, strict=True)):
        found[:, row] = grazing_damping(scenes.law, Oscillator(m=m, k=k, V=V, N=N), rtol=rtol)
    return found[0], found[1]

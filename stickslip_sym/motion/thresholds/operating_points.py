"""`OperatingPoints`: where thresholds are asked for, as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray, Rational, Rows
from stickslip_sym.core.errors import NO_RESULT, InputError
from stickslip_sym.core.numbers import exact, fraction, read_array
from stickslip_sym.core.remedies import Argument
from stickslip_sym.core.uncertain import UFloat, split
from stickslip_sym.criteria.rule import gauss_average
from stickslip_sym.model.bound import BoundLaw
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.orbits.expansion import GrazingExpansion, expand

VANISHING = 1e-8
"""Of N <|mu'|>: a threshold below that is nearly 0, and its error relative to that."""

Quantity: TypeAlias = ArrayLike | UFloat
"""One number, which may carry a standard error, or an array of them without, as users give it."""


@dataclass(frozen=True)
class OperatingPoints:
    """Operating points of one law: flat arrays of one length.

    - `columns`: V and N in m/s and N; m and k in kg and N/m where they were given.
    - `shape`: that the broadcast arguments had.
    - `exact`: what was given as text, exactly.
    - `uncertain`: what carries a standard error, with it: a number for all points.
    """

    law: FrictionLaw
    columns: Mapping[str, FloatArray]
    shape: tuple[int, ...]
    exact: Mapping[str, Fraction] = field(default_factory=dict)
    uncertain: Mapping[str, UFloat] = field(default_factory=dict)

    @classmethod
    def of(
        cls, law: FrictionLaw, osc: Oscillator | None = None, /, **values: Quantity | None
    ) -> "OperatingPoints":
        """Broadcast V, N, m and k, or take those of an oscillator.

        Raises `InputError` for numbers that are missing, not finite or of the wrong sign, shapes that do not
        broadcast, only one of m and k, or an oscillator together with numbers.
        """
        numbers: dict[str, Any] = {name: value for name, value in values.items() if value is not None}
        if osc is not None:
            numbers = oscillator_quantities(osc, numbers, ("V", "N", "m", "k"))
        for name in ("V", "N"):
            if name not in numbers:
                raise InputError(f"the {symbols.QUANTITIES[name].meaning} is missing: give ", Argument(name))
        if ("m" in numbers) != ("k" in numbers):
            raise InputError("give both the mass m and the stiffness k, or neither")
        arrays = {}
        uncertain = {}
        exactly = {}
        for name, given in numbers.items():
            value, error = split(given, name)
            if isinstance(value, str):
                exactly[name] = fraction(value, name)
                value = float(exactly[name])
            if np.ma.is_masked(value):
                raise InputError(f"{name} has masked entries; drop them, or fill them with a number")
            arrays[name] = read_array(name, value).astype(np.float64, copy=False)
            symbols.require_sign(name, float(arrays[name].min(initial=np.inf)))
            if error is not None:
                uncertain[name] = error
        try:
            shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {array.shape}" for name, array in arrays.items())
            raise InputError(f"the shapes do not broadcast: {shapes}") from None

        columns = {name: np.broadcast_to(array, shape).ravel() for name, array in arrays.items()}
        return cls(law, columns, shape, exactly, uncertain)

    def __len__(self) -> int:
        return len(self.V)

    @property
    def V(self) -> FloatArray:
        """Belt speeds."""
        return self.columns["V"]

    @property
    def N(self) -> FloatArray:
        """Normal forces."""
        return self.columns["N"]

    @property
    def has_oscillator(self) -> bool:
        """Whether m and k were given."""
        return "m" in self.columns

    @property
    def impedance(self) -> FloatArray:
        """The unit of damping, sqrt(k m) in kg/s."""
        return np.asarray(np.sqrt(self.columns["k"]) * np.sqrt(self.columns["m"]))

    @property
    def strength(self) -> FloatArray:
        """The strength of friction, N/sqrt(k m) in m/s."""
        return self.N / self.impedance

    @property
    def bound(self) -> BoundLaw:
        """The law as numbers."""
        return self.law.bound

    @cached_property
    def obstacle(self) -> str | None:
        """Why slip up to twice the belt's speed is not smooth; None where it is."""
        return self.bound.obstacle(2 * float(np.max(self.V, initial=0.0)))

    @cached_property
    def weak(self) -> GrazingExpansion:
        """The orbits that graze the belt's speed, expanded for weak friction."""
        with np.errstate(all="ignore"):
            return expand(self.bound, self.V)

    @cached_property
    def averaged(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The average of -mu' by the harmonic weight, its error, and that of abs(mu'), in s/m."""
        return gauss_average(self.law.kinetic, self.V)

    @cached_property
    def slope_scale(self) -> FloatArray:
        """N <|mu'|> in kg/s, 0 where it is not known; a threshold is far smaller where slopes cancel."""
        try:
            size = self.averaged[2]
            return np.where(np.isfinite(size), self.N * size, 0.0)
        except NO_RESULT:
            return np.zeros(len(self))

    def error_base(self, value: FloatArray) -> FloatArray:
        """Return what the errors of thresholds are relative to: these, or a small part of N <|mu'|>."""
        return np.asarray(np.maximum(np.abs(value), VANISHING * self.slope_scale))

    def relative(self, error: FloatArray, value: FloatArray) -> FloatArray:
        """Return errors in kg/s relative to thresholds, or to a small part of N <|mu'|> where that is larger."""
        with np.errstate(all="ignore"):
            return np.where(error == 0, 0.0, error / self.error_base(value))

    def rows(self, chosen: Rows) -> "OperatingPoints":
        """Return some of the points."""
        columns = {name: column[chosen] for name, column in self.columns.items()}
        return replace(self, columns=columns, shape=columns["V"].shape)

    def exact_row(self, row: int) -> dict[str, Rational]:
        """Return V, N, m and k of one point exactly: text as the decimal it says, a float as the binary it is."""
        return {name: exact(self.exact.get(name, column[row]), name) for name, column in self.columns.items()}

    def oscillator(self, row: int, c: float = 0.0) -> Oscillator:
        """Return one point as an oscillator; it needs m and k."""
        return Oscillator(c=c, **{name: column[row] for name, column in self.columns.items()})

    def shifted(self, by: Mapping[str, float]) -> "OperatingPoints":
        """Return the points with some quantities and parameters shifted; refuse what leaves where it may be."""
        law = self.law
        parameters = {name: float(law.values[name]) + by[name] for name in law.parameters if name in by}
        moved = {name: column + by.get(name, 0.0) for name, column in self.columns.items()}
        return OperatingPoints.of(law.bind(**parameters) if parameters else law, **moved)

    def label(self, row: int) -> str:
        """Say which point it is."""
        return ", ".join(f"{name} = {column[row]:g}" for name, column in self.columns.items())


def oscillator_quantities(osc: Oscillator, numbers: Mapping[str, Any], names: Sequence[str]) -> dict[str, Any]:
    """Return quantities of an oscillator by name; refuse what is none, and numbers beside it."""
    if not isinstance(osc, Oscillator):
        raise InputError(
            f"got {osc!r} where an Oscillator is expected; write (law, Oscillator(...)), or give V, N, m and k"
        )
    if numbers:
        raise InputError(f"{', '.join(numbers)} was given beside an Oscillator, which holds it; give one of both")
    return {name: getattr(osc, name) for name in names}

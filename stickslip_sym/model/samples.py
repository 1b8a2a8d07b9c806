"""Measured points of a friction coefficient, and the curve through them.

The curve is the shape-preserving piecewise cubic (PCHIP): it passes through every point, its slope is
continuous, and it rises or falls only where the points do. Its coefficients are exact rationals, so criteria
of it are exact closed forms, piece by piece.
"""

import math
import warnings
from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any, SupportsFloat

import numpy as np
import sympy as sp
from scipy.interpolate import PchipInterpolator, PPoly

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, Mpf, Rational
from stickslip_sym.core.errors import InputError, InputWarning
from stickslip_sym.core.lambdify import Backend, context_of
from stickslip_sym.core.numbers import Number, binary_fraction, exact, to_mpf
from stickslip_sym.core.remedies import Argument, Call
from stickslip_sym.model.expression.pieces import piecewise
from stickslip_sym.model.expression.reading import require_evaluation

FEWEST, MOST = 4, 60
LARGEST = sp.Integer(10) ** 20  # m/s; the smallest speed above 0 is its inverse


@dataclass(frozen=True)
class SampledCurve:
    """The piecewise cubic through measured points: piece i is sum_j cubics[i][j] (v - places[i])^j.

    The pieces begin at `places`, ascending from 0, in m/s; the curve holds up to the slip speed `end`, for ever if
    that is None.
    """

    places: tuple[Rational, ...]
    cubics: tuple[tuple[Rational, ...], ...]
    end: Rational | None

    def __post_init__(self) -> None:
        ends = [*self.places, *([] if self.end is None else [self.end])]
        ascending = all(before < after for before, after in pairwise(ends))
        if not (self.places and self.places[0] == 0 and ascending):
            raise InputError("the pieces of a curve begin at ascending speeds, the first at 0")
        if [len(cubic) for cubic in self.cubics] != [4] * len(self.places):
            raise InputError("a curve has four coefficients for each piece")

    @classmethod
    def through(cls, v: Iterable[Number], mu: Iterable[Number], *, extrapolate: bool) -> "SampledCurve":
        """Return the curve through 4 to 60 points of ascending slip speeds in m/s.

        To extrapolate is to hold the first coefficient down to v = 0, with a warning, and the last one beyond the
        last speed. Otherwise the first speed must be 0, and the curve ends at the last.
        """
        require_evaluation()
        speeds, coefficients = _checked(v, mu)
        if speeds[0] != 0 and not extrapolate:
            raise InputError(
                f"the first speed is {float(speeds[0]):g} m/s, and criteria need mu from v = 0 on; add a point "
                "there, or hold the first coefficient below it: ",
                Argument("extrapolate", True),
            )
        cubics = _hermite_cubics(speeds, coefficients)
        places = speeds[:-1]
        if speeds[0] != 0:
            warnings.warn(
                f"nothing was measured below v = {float(speeds[0]):g} m/s; mu is held there at "
                f"{float(coefficients[0]):g}, without slope, and mu(0+) is this value",
                InputWarning,
                stacklevel=3,
            )
            places = [sp.Integer(0), *places]
            cubics = [(coefficients[0], *_LEVEL), *cubics]
        if extrapolate:
            places = [*places, speeds[-1]]
            cubics = [*cubics, (coefficients[-1], *_LEVEL)]
        return cls(tuple(places), tuple(cubics), None if extrapolate else speeds[-1])

    @property
    def expr(self) -> Expr:
        """The curve as a SymPy expression in v."""
        formulas = [
            sp.Add(*[coefficient * (symbols.v - place) ** j for j, coefficient in enumerate(cubic)])
            for place, cubic in zip(self.places, self.cubics, strict=True)
        ]
        return piecewise(list(zip(formulas, [*self.places[1:], None], strict=True)))

    def __str__(self) -> str:
        last = self.places[-1] if self.end is None else self.end
        return f"piecewise cubic of {len(self.cubics)} pieces from v = 0 to {float(last):g} m/s"

    def require_speed(self, v: SupportsFloat, label: str) -> None:
        """Refuse a slip speed beyond the last measured one, with both speeds, and what to do.

        - `label`: that of the law in a message.
        """
        if self.end is not None and float(v) > float(self.end):  # the double next to a decimal may be above it
            raise InputError(
                f"{label} is measured up to v = {float(self.end):g} m/s, and its value at {float(v):g} m/s is "
                "needed; measure further, take a lower speed, or hold the last coefficient: ",
                Argument("extrapolate", True),
            )

    def function(self, backend: Backend, *, derivative: bool) -> Callable[[Any], Any]:
        """Return mu(v), or its slope, as a function of one library's numbers; beyond the end, the last piece."""
        context = context_of(backend)
        if context is None:
            polynomials: Callable[[Any], Any] = self._polynomials.derivative() if derivative else self._polynomials
            return polynomials
        rows = [[j * cubic[j] for j in (3, 2, 1)] if derivative else cubic[::-1] for cubic in self.cubics]

        @lru_cache
        def rounded(precision: int) -> tuple[list[Mpf], list[list[Mpf]]]:
            places = [to_mpf(place, context) for place in self.places]
            return places, [[to_mpf(number, context) for number in row] for row in rows]

        def at_precision(v: Mpf) -> Mpf:
            places, coefficients = rounded(context.prec)
            piece = max(bisect_right(places, v) - 1, 0)
            return context.polyval(coefficients[piece], v - places[piece])

        return at_precision

    @cached_property
    def rises(self) -> list[tuple[float, Callable[[Any], Any]]]:
        """Where each piece begins, and what the curve gains from v = 0 on, beyond the ends of the piece too."""
        lowered = [(level - self.cubics[0][0], *row) for level, *row in self.cubics]
        return [
            (float(place), PPoly(np.array([row[::-1]], dtype=np.float64).T, [float(place), float(place) + 1]))
            for place, row in zip(self.places, lowered, strict=True)
        ]

    @cached_property
    def _polynomials(self) -> PPoly:
        places = [*map(float, self.places), math.inf]
        return PPoly(np.array([row[::-1] for row in self.cubics], dtype=np.float64).T, places)


def _checked(v: Iterable[Number], mu: Iterable[Number]) -> tuple[list[Rational], list[Rational]]:
    """Read the points exactly, and refuse what is no measured curve."""
    for name, values in (("v", v), ("mu", mu)):
        if isinstance(values, str) or not isinstance(values, Iterable):
            raise InputError(f"{name} is a sequence of numbers, got {type(values).__name__}")
    v = list(v)
    mu = list(mu)
    count = len(v)
    if count != len(mu):
        raise InputError(f"v has {count} numbers and mu {len(mu)}; give one mu for each v")
    if count < FEWEST:
        raise InputError(f"{count} points were given; a curve needs {FEWEST} or more, so measure at more speeds")
    if count > MOST:
        raise InputError(
            f"{count} points were given, and each becomes a piece of the formula; fit a law to so many (",
            Call("stickslip_sym.fit", "fit FILE"),
            f"), or average them over bins of speed to {MOST} or fewer, where the file is read: ",
            Argument("bins", MOST),
        )
    speeds = [exact(_as_written(value), f"v of point {number}") for number, value in enumerate(v, 1)]
    for number, (before, speed) in enumerate(pairwise([-LARGEST, *speeds]), 1):
        shown = f"v of point {number}, {float(speed):g} m/s,"
        if speed < 0:
            raise InputError(f"{shown} is below 0; the slip speed |x' - V| is never negative")
        if speed > LARGEST or 0 < speed < 1 / LARGEST:
            raise InputError(f"{shown} is out of all proportion: speeds are from 1e-20 to 1e20 m/s, or 0")
        if speed <= before:
            what = "repeats" if speed == before else "is below"
            raise InputError(
                f"{shown} {what} that of the point before; sort points by speed, and average those of one speed"
            )
    return speeds, [exact(_as_written(value), f"mu of point {number}") for number, value in enumerate(mu, 1)]


def _as_written(value: Number) -> Number:
    """Return a measured float as the shortest decimal that is read as it: 0.1 for the double next to it."""
    if isinstance(value, float) and math.isfinite(value):
        return repr(float(value))
    return value


def _hermite_cubics(x: Sequence[Rational], y: Sequence[Rational]) -> list[tuple[Rational, ...]]:
    """Return the coefficients of the Hermite cubic of each interval, in powers of the distance from its start."""
    # Scaled, so that neither subnormal nor huge speeds harm the slopes, which are then made exact.
    width = x[-1]
    height = max(map(abs, y)) or sp.Integer(1)
    scaled = PchipInterpolator([float(value / width) for value in x], [float(value / height) for value in y])
    d = [binary_fraction(slope) * height / width for slope in scaled(scaled.x, nu=1)]
    cubics: list[tuple[Rational, ...]] = []
    for i, ((x0, y0), (x1, y1)) in enumerate(pairwise(zip(x, y, strict=True))):
        step = x1 - x0
        rise = (y1 - y0) / step
        second = (3 * rise - 2 * d[i] - d[i + 1]) / step
        third = (d[i] + d[i + 1] - 2 * rise) / step**2
        cubics.append((y0, d[i], second, third))
    return cubics


_LEVEL = (sp.Integer(0),) * 3
"""The higher coefficients of a piece that is constant."""

"""A term of a law: its branches, and the powers of the arguments that stand before them."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, IntArray, Numbers
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.branches import Branch, Loop, Profile
from stickslip_sym.formula.evaluation.products import (
    extremes,
    largest_exponent,
    plain_product,
    power_of,
    scaled_product,
)
from stickslip_sym.formula.evaluation.profile import profile_of
from stickslip_sym.formula.evaluation.room import Room, multiply_by_power
from stickslip_sym.formula.evaluation.splitting import Term

__all__ = ["Ends", "Loops", "TermFunction"]

Ends = tuple[float, float]
"""The smallest and the largest of some values."""
Loops = Callable[[Profile], Loop | None]
"""From a profile to its compiled loop."""

_SAFE = 900.0  # binary exponents that no product may pass, lest something overflows on the way
_MOST = 0.9  # of a block: a branch that serves so much of it is taken for all
_WORTH_A_TABLE = 64  # elements with one shape for which branches are found


class _Floats(NamedTuple):
    """What the floats among the arguments give, the same for every block of a call.

    Attributes
    ----------
    bases : list of float
        NaN where an array takes part.
    varying : list of int
        Which those are.
    exponent : float
        The largest binary exponent that powers of the floats bring to a product.
    factor, number : float
        What they bring to r, and to the amplitude; nothing where that might overflow, for then it is not used.
    """

    bases: list[Numbers]
    varying: list[int]
    exponent: float
    factor: float
    number: float


class TermFunction:
    """A term of a law, compiled.

    Parameters
    ----------
    term : Term
    criterion : Criterion
    arguments : sequence of Symbol
    loops : callable, optional
        Returns all branches of a profile as one compiled loop, or None.
    """

    def __init__(
        self, term: Term, criterion: Criterion, arguments: Sequence[Expr], loops: Loops | None = None
    ) -> None:
        self.term, self.criterion, self.loops = term, criterion, loops
        self.number, self.size = float(term.number), float(term.size)
        self.shapes = [arguments.index(symbol) for symbol in term.shapes]
        bases = list(dict.fromkeys([symbols.V, symbols.N, *term.amplitude, *term.scale]))
        self.base_exprs = bases
        self.bases = [
            arguments.index(base) if base.is_Symbol else function_of(arguments, base, "numpy") for base in bases
        ]
        self.amplitude = [float(term.amplitude.get(base, 0)) + (base == symbols.N) for base in bases]
        self.ratio = [(base == symbols.V) - float(term.scale.get(base, 0)) for base in bases]
        self._profiles: dict[tuple[float, ...], Profile | None] = {}
        self._asked: set[tuple[float, ...]] = set()

    def profile(self, shape: tuple[float, ...], count: int) -> Profile | None:
        """Return the branches for values of the shape parameters; None if there are none, or not worth it."""
        if shape not in self._profiles:
            if shape and count < _WORTH_A_TABLE and shape not in self._asked:
                self._asked.add(shape)
                return None
            exact = {symbol: sp.Rational(value) for symbol, value in zip(self.term.shapes, shape, strict=True)}
            self._profiles[shape] = profile_of(self.term.mu.xreplace(exact), self.criterion)
        return self._profiles[shape]

    def fill(self, values: list[Numbers], ends: list[Ends], out: FloatArray, room: Room) -> None:
        """Evaluate at floats and flat arrays into `out`; NaN where no branch serves.

        Parameters
        ----------
        values : list of float or numpy.ndarray
            Of the length of `out`; at least one is an array.
        ends : list of tuple of float
            The smallest and the largest of each.
        """
        columns = [values[i] for i in self.shapes]
        floats = [column for column in columns if isinstance(column, float)]
        if len(floats) == len(columns):
            self._by_branches(values, ends, self.profile(tuple(floats), out.size), out, room)
            return
        shapes = np.stack([np.broadcast_to(column, out.shape) for column in columns])
        kinds, which = np.unique(shapes, axis=1, return_inverse=True)
        out.fill(np.nan)
        if kinds.shape[1] * _WORTH_A_TABLE <= out.size:
            for kind in range(kinds.shape[1]):
                here = np.flatnonzero(which.ravel() == kind)
                shape = tuple(float(x) for x in kinds[:, kind])
                self._some(values, here, self.profile(shape, here.size), out)

    def _some(self, values: list[Numbers], here: IntArray, profile: Profile | None, out: FloatArray) -> None:
        """Evaluate at some elements."""
        if here.size:
            taken = [value if isinstance(value, float) else value[here] for value in values]
            result = np.empty(here.size)
            self._by_branches(taken, [extremes(value) for value in taken], profile, result, Room())
            out[here] = result

    def _by_branches(
        self, values: list[Numbers], ends: list[Ends], profile: Profile | None, out: FloatArray, room: Room
    ) -> None:
        if profile is None:
            out.fill(np.nan)
            return
        floats = self._floats(values, profile, room)
        bases, exponent = list(floats.bases), floats.exponent
        ratio: list[tuple[FloatArray, float]] = []
        for i in floats.varying:
            base = self.bases[i]
            value: FloatArray = np.asarray(values[base] if isinstance(base, int) else base(*values))
            bases[i] = value
            exponent += self._reach(i, ends[base] if isinstance(base, int) else extremes(value), profile)
            if self.ratio[i]:
                ratio.append((value, self.ratio[i]))
        plain = exponent < _SAFE
        if plain and self.loops is not None and (loop := self.loops(profile)) is not None:
            if floats.varying == [0]:
                loop(ratio[0][0], floats.factor, floats.number, out)
            else:
                loop(plain_product(floats.factor, ratio, out.size, room), 1.0, floats.number, out)
            self._multiply(out, bases, room)
            return
        if plain:
            r = plain_product(floats.factor, ratio, out.size, room)
        else:
            factors = [(base, e) for base, e in zip(bases, self.ratio, strict=True) if e]
            with np.errstate(invalid="ignore"):
                r = scaled_product(1 / self.size, factors, np.ones(out.size))
        if plain and floats.varying == [0]:  # r rises with V
            low, high = floats.factor * ends[0][0], floats.factor * ends[0][1]
        else:
            low, high = extremes(r)
        if not high < np.inf:
            # One over a scale of 0, or V far beyond all scales.
            out.fill(np.nan)
            self._some(values, np.flatnonzero(np.isfinite(r)), profile, out)
            return
        number = floats.number if plain else None
        branches, edges = profile.cover(low, high)
        if not edges:
            self._branch(branches[0], r, bases, number, out, room)
            return
        masks = _parted(r, edges)
        counts = [int(np.count_nonzero(mask)) for mask in masks]
        common = max(range(len(counts)), key=counts.__getitem__)
        branch = branches[common]
        if branch is not None and (branch.is_light or counts[common] > _MOST * out.size):
            # For all, without copies; the others are put right.
            self._branch(branch, r, bases, number, out, room)
            counts[common] = 0
        for branch, mask, some in zip(branches, masks, counts, strict=True):
            if not some:
                continue
            here = np.flatnonzero(mask)
            part = [
                base if isinstance(base, float) or (plain and not a) else base.take(here)
                for base, a in zip(bases, self.amplitude, strict=True)
            ]
            taken, found = room("some r", some), room("some", some)
            r.take(here, out=taken, mode="clip")  # which needs no room of its own
            self._branch(branch, taken, part, number, found, room)
            out[here] = found

    def _reach(self, i: int, end: Ends, profile: Profile) -> float:
        """Return the largest binary exponent that powers of a base bring to a product."""
        times = abs(self.amplitude[i]) + (1 + profile.steepest) * abs(self.ratio[i])
        return float(largest_exponent(*end) * times)

    def _floats(self, values: list[Numbers], profile: Profile, room: Room) -> _Floats:
        """Return what the floats give; it is kept in the room."""
        found = room.kept.get(self)
        if isinstance(found, _Floats):
            return found
        bases = [values[base] if isinstance(base, int) else base(*values) for base in self.bases]
        varying = [i for i, base in enumerate(bases) if not isinstance(base, float)]
        exponent, factor, number = 0.0, 1 / self.size, self.number
        for i, base in enumerate(bases):
            if isinstance(base, float):
                exponent += self._reach(i, (base, base), profile)
        if exponent < _SAFE:
            for base, a, e in zip(bases, self.amplitude, self.ratio, strict=True):
                if isinstance(base, float):
                    factor, number = factor * power_of(base, e), number * power_of(base, a)
        found = _Floats(
            [base if isinstance(base, float) else math.nan for base in bases], varying, exponent, factor, number
        )
        room.kept[self] = found
        return found

    def _branch(
        self, branch: Branch | None, r: FloatArray, bases: list[Numbers], number: float | None, out: FloatArray,
        room: Room,
    ) -> None:  # fmt: skip
        """Evaluate by one branch; `number` is what floats bring to the amplitude, None where it might overflow."""
        if branch is None:
            out.fill(np.nan)
            return
        if number is not None:
            branch.fill(r, out, room, number, branch.power)
            self._multiply(out, bases, room)
            return
        branch.fill(r, out, room)
        exponents = [a + branch.power * e for a, e in zip(self.amplitude, self.ratio, strict=True)]
        factors = [(base, e) for base, e in zip(bases, exponents, strict=True) if e]
        out[...] = scaled_product(self.number * self.size**-branch.power, factors, out)

    def _multiply(self, value: FloatArray, bases: list[Numbers], room: Room) -> None:
        """Multiply in place by the amplitude's arrays."""
        for base, a in zip(bases, self.amplitude, strict=True):
            if a and not isinstance(base, float):
                multiply_by_power(value, base, a, room)

    def single(self, values: list[float]) -> float:
        """Evaluate at floats; NaN where no branch serves, or a product might overflow on the way."""
        bases = [values[base] if isinstance(base, int) else float(base(*values)) for base in self.bases]
        if not all(1e-60 < abs(base) < 1e60 for base in bases):
            return float("nan")
        profile = self.profile(tuple(values[i] for i in self.shapes), 1)
        if profile is None:
            return float("nan")
        r = 1 / self.size
        for base, exponent in zip(bases, self.ratio, strict=True):
            if exponent:
                r *= base**exponent
        branch = profile.branches[bisect_right(profile.starts, r) - 1]
        if branch is None:
            return float("nan")
        value: float = branch(r) * self.number * self.size**-branch.power
        for base, a, e in zip(bases, self.amplitude, self.ratio, strict=True):
            exponent = a + branch.power * e
            if exponent:
                value *= base**exponent
        return value


def _parted(r: FloatArray, edges: Sequence[float]) -> list[BoolArray]:
    """Return which elements lie below the first edge, from there to the next, and so on to beyond the last."""
    below = [r < edge for edge in edges]
    return [below[0], *(later > earlier for earlier, later in pairwise(below)), ~below[-1]]

"""A term of a law: its branches, and the powers of the arguments that stand before them."""

from bisect import bisect_right
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import BoolArray, Expr, FloatArray, Numbers
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import Criterion
from stickslip_sym.formula.evaluation.branches import Branch
from stickslip_sym.formula.evaluation.products import (
    extremes,
    largest_exponent,
    multiply_by_power,
    plain_product,
    scaled_product,
)
from stickslip_sym.formula.evaluation.profile import Profile, profile_of
from stickslip_sym.formula.evaluation.splitting import Term

__all__ = ["TermFunction"]

_SAFE = 900.0  # binary exponents that no product may pass, lest something overflows on the way
_MOST = 0.9  # of a block: a branch that serves so much of it is taken for all
_WORTH_A_TABLE = 64  # elements with one shape for which branches are found


class TermFunction:
    """A term of a law, compiled."""

    def __init__(self, term: Term, criterion: Criterion, arguments: Sequence[Expr]) -> None:
        self.term, self.criterion = term, criterion
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

    def __call__(self, values: list[Numbers]) -> FloatArray:
        """Evaluate at floats and at least one flat array, all of one length; NaN where no branch serves."""
        count = next(value.size for value in values if not isinstance(value, float))
        columns = [values[i] for i in self.shapes]
        floats = [column for column in columns if isinstance(column, float)]
        if len(floats) == len(columns):
            return self._by_branches(values, self.profile(tuple(floats), count), count)
        shapes = np.stack([np.broadcast_to(column, (count,)) for column in columns])
        kinds, which = np.unique(shapes, axis=1, return_inverse=True)
        result = np.full(count, np.nan)
        if kinds.shape[1] * _WORTH_A_TABLE <= count:
            for kind in range(kinds.shape[1]):
                here = np.flatnonzero(which.ravel() == kind)
                taken = [value if isinstance(value, float) else value[here] for value in values]
                shape = tuple(float(x) for x in kinds[:, kind])
                result[here] = self._by_branches(taken, self.profile(shape, here.size), here.size)
        return result

    def _by_branches(self, values: list[Numbers], profile: Profile | None, count: int) -> FloatArray:
        if profile is None:
            return np.full(count, np.nan)
        bases = [values[base] if isinstance(base, int) else base(*values) for base in self.bases]
        ends = [extremes(base) for base in bases]
        reach = [largest_exponent(*end) for end in ends]
        most = max((abs(branch.power) for branch in profile.branches if branch is not None), default=0.0)
        plain = (
            sum(
                r * (abs(a) + (1 + most) * abs(b))
                for r, a, b in zip(reach, self.amplitude, self.ratio, strict=True)
                if r
            )
            < _SAFE
        )
        ratio = [(base, e) for base, e in zip(bases, self.ratio, strict=True) if e]
        if plain:
            r = plain_product(1 / self.size, ratio)
        else:
            with np.errstate(invalid="ignore"):
                r = scaled_product(1 / self.size, ratio, np.ones(count))
        if isinstance(r, float):
            r = np.full(count, r)
        if plain and all(isinstance(base, float) for base in bases[1:]):  # r rises with V
            low, high = (plain_product(1 / self.size, [(end, 1.0), *ratio[1:]]) for end in ends[0])
        else:
            low, high = float(r.min()), float(r.max())
        if not high < np.inf:
            # One over a scale of 0, or V far beyond all scales.
            finite = np.isfinite(r)
            result = np.full(count, np.nan)
            taken = [value if isinstance(value, float) else value[finite] for value in values]
            if finite.any():
                result[finite] = self._by_branches(taken, profile, int(finite.sum()))
            return result
        first, last = bisect_right(profile.starts, low) - 1, bisect_right(profile.starts, high) - 1
        if first == last:
            return self._branch(profile.branches[first], r, bases, plain)
        branches = profile.branches[first : last + 1]
        masks = _parted(r, profile.starts[first + 1 : last + 1])
        counts = [int(np.count_nonzero(mask)) for mask in masks]
        common = max(range(len(counts)), key=counts.__getitem__)
        branch = branches[common]
        if branch is not None and (branch.is_light or counts[common] > _MOST * count):
            result = self._branch(branch, r, bases, plain)  # for all, without copies; the others are put right
            counts[common] = 0
        else:
            result = np.empty(count)
        for branch, mask, some in zip(branches, masks, counts, strict=True):
            if not some:
                continue
            here = np.flatnonzero(mask)
            part = [
                base if isinstance(base, float) or (plain and not a) else base.take(here)
                for base, a in zip(bases, self.amplitude, strict=True)
            ]
            result[here] = self._branch(branch, r.take(here), part, plain)
        return result

    def _branch(self, branch: Branch | None, r: FloatArray, bases: list[Numbers], plain: bool) -> FloatArray:
        if branch is None:
            return np.full(r.shape, np.nan)
        value, work = np.empty_like(r), np.empty_like(r)
        branch.fill(r, value, work)
        if plain:
            value *= plain_product(self.number, [(b, a) for b, a in zip(bases, self.amplitude, strict=True) if a])
            multiply_by_power(value, r, branch.power, work)
            return value
        exponents = [a + branch.power * e for a, e in zip(self.amplitude, self.ratio, strict=True)]
        factors = [(base, e) for base, e in zip(bases, exponents, strict=True) if e]
        return scaled_product(self.number * self.size**-branch.power, factors, value)

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

"""The average F(r) of a profile in floats: short formulas, each for a range of r.

Each branch is r^power G(r), and G and the power stay apart where a product would leave the range of floats. A
float and an array go through the same operations, so that they agree to the last digit.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import itemgetter
from typing import Any

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray, Numbers
from stickslip_sym.core.lambdify import function_of, is_multiplied, power_of


def horner(coefficients: Sequence[float], z: Numbers) -> Numbers:
    """Evaluate a polynomial at floats or arrays."""
    if len(coefficients) == 1:
        if isinstance(z, float):
            return coefficients[0]
        return np.full_like(z, coefficients[0])
    value = z * coefficients[-1]
    for coefficient in coefficients[-2:0:-1]:
        value += coefficient
        value *= z
    value += coefficients[0]
    return value


def alike(function: Callable[..., Any], expr: Expr) -> Callable[..., Any]:
    """Return a function of an expression that has the same digits for floats as in arrays.

    NumPy has other powers for a float than for an array, but for those that are multiplied out; sums, products and
    its functions are the same.
    """
    if all(map(is_multiplied, expr.atoms(sp.Pow))):
        return function

    def of_numbers(*values: Numbers) -> Any:
        if any(not isinstance(value, float) for value in values):
            return function(*values)
        results = function(*(np.array([value]) for value in values))
        if isinstance(results, list):
            return [np.ravel(x)[0] for x in results]
        return results[0]

    return of_numbers


@dataclass(frozen=True)
class Sum:
    """G = sum_i f_i(r) P_i(z) with polynomials P_i in z = r^variable.

    `parts` holds the f_i, functions of the symbol V, None for 1, and the coefficients of the P_i.
    """

    power: float
    variable: float
    parts: tuple[tuple[Expr | None, tuple[float, ...]], ...]

    @cached_property
    def _functions(self) -> list[Callable[[Numbers], Numbers] | None]:
        return [None if f is None else alike(function_of([symbols.V], f, "numpy"), f) for f, _ in self.parts]

    def __call__(self, r: Numbers) -> Numbers:
        """Return G."""
        z = power_of(r, self.variable)
        total: Numbers | None = None
        for function, (_, coefficients) in zip(self._functions, self.parts, strict=True):
            part = horner(coefficients, z)
            if function is not None:
                part = part * function(r)
            total = part if total is None else total + part
        assert total is not None
        return total


@dataclass(frozen=True, eq=False)
class PanelTable:
    """G as polynomials in panels.

    A row is a panel: its left end, the origin o, the centre and the inverse of half the width in y, then the
    coefficients of powers of (y - centre) over that half. Here y is r, or sqrt(r - o) where o is a number: beyond
    a kink the average under a weight that ends like a square root is analytic in that. A `function` of the
    symbol V, None for 1, stands before all of them.
    """

    rows: FloatArray
    function: Expr | None = None
    power = 0.0

    @cached_property
    def _front(self) -> Callable[[Numbers], Numbers]:
        f = sp.Integer(1) if self.function is None else self.function
        return alike(function_of([symbols.V], f, "numpy"), f)

    def __call__(self, r: Numbers) -> Numbers:
        """Return G."""
        value = self._in_panel(r)
        if self.function is None:
            return value
        return value * self._front(r)

    @cached_property
    def _panels(self) -> list[tuple[float, float, float, float, list[float]]]:
        """The rows for floats, coefficients from the highest on."""
        return [(*row[:4], row[:3:-1]) for row in self.rows.tolist()]

    @cached_property
    def _columns(self) -> list[FloatArray]:
        return [np.ascontiguousarray(column) for column in self.rows.T]

    @cached_property
    def _has_roots(self) -> bool:
        return bool(np.isfinite(self._columns[1]).any())

    def _in_panel(self, r: Numbers) -> Numbers:
        if isinstance(r, float):
            number = max(bisect_right(self._panels, r, key=itemgetter(0)) - 1, 0)
            _, begin, centre, scale, (highest, *others) = self._panels[number]
            y = ((r if math.isnan(begin) else math.sqrt(abs(r - begin))) - centre) * scale
            value: float = highest
            for coefficient in others:
                value = value * y + coefficient
            return value
        edges, origins, centres, scales, *coefficients = self._columns
        panel = np.searchsorted(edges[1:], r, side="right")
        position = r
        if self._has_roots:
            origin = origins[panel]
            position = np.where(np.isfinite(origin), np.sqrt(np.abs(r - origin)), r)
        position = position - centres.take(panel)
        position *= scales.take(panel)
        total = coefficients[-1].take(panel)
        here = np.empty_like(r)
        for column in coefficients[-2::-1]:
            total *= position
            total += column.take(panel, out=here, mode="clip")  # which needs no buffer of its own
        return total


Branch = Sum | PanelTable


@dataclass(frozen=True, eq=False)
class Branches:
    """F(r) by branches, and where each begins; the first at 0."""

    starts: tuple[float, ...]
    branches: tuple[Branch, ...]

    @cached_property
    def steepest(self) -> float:
        """The largest size of a branch's power."""
        return max(abs(branch.power) for branch in self.branches)

    def __call__(self, r: Numbers) -> Numbers:
        """Return F at a float or at each element of a flat array, as far as r^power stays within range."""
        if isinstance(r, float):
            return value_of(self.at(r), r)
        first, last = (bisect_right(self.starts, float(end)) - 1 for end in (r.min(), r.max()))
        if first == last:
            return value_of(self.branches[first], r)
        edges = [-np.inf, *self.starts[first + 1 : last + 1], np.inf]
        result = np.empty_like(r)
        for branch, (low, high) in zip(self.branches[first:], pairwise(edges), strict=False):
            here = np.flatnonzero((r >= low) & (r < high))
            if here.size:
                result[here] = value_of(branch, r.take(here))
        return result

    def at(self, r: float) -> Branch:
        """Return the branch at a float."""
        return self.branches[bisect_right(self.starts, r) - 1]


def value_of(branch: Branch, r: Numbers) -> Numbers:
    """Return F, r^power G, as far as it stays within range."""
    value = branch(r)
    if branch.power == 0:
        return value
    return value * power_of(r, branch.power)

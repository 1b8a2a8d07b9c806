"""Places and waves of a law: where its sum of squares has many minima, and the grids on which all are looked at.

A place is a slip speed at which mu has a kink, a jump, or the middle of a step or bump: a minimum may lie between
any two measured speeds. A wave is a sine or cosine, whose frequencies have a minimum for each half turn.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr, FloatArray
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.model.expression.pieces import places

_SIZES = np.geomspace(1e-12, 1e12, 4001)  # of a parameter, between which what it moves is interpolated
_EIGHTH = np.pi / 4
"""Of a turn: so far phases are apart, and frequencies over all speeds, where a minimum is a turn wide."""
PHASES = _EIGHTH * np.arange(1, 5)
"""Radians by which a wave is shifted, besides half a turn; none is near 0, the bound of a positive parameter."""


class SearchGrid(NamedTuple):
    """A place or a wave: the parameter that moves it, by its number, and what is looked at.

    `measure` gives the place in m/s, or the radians of the wave from the first to the last speed, of values of all
    parameters; `phases` are the numbers of parameters that shift the wave, with the radians for a unit of each.
    """

    moved: int
    measure: Callable[..., Any]
    levels: FloatArray
    phases: tuple[tuple[int, Callable[..., Any]], ...] = ()
    breaks: bool = False  # the law changes its formula there
    alone: bool = True  # no other parameter that is sought moves it

    def grid(self, p: FloatArray, bound: Sequence[float], levels: FloatArray) -> FloatArray:
        """Return values of all parameters that move the feature to each level, and shift it to each phase."""
        points = np.tile(p, (len(_SIZES), 1))
        points[:, self.moved] = _SIZES
        measured = np.broadcast_to(self._at(self.measure, points, bound), _SIZES.shape)
        use = np.isfinite(measured) & (measured > 0)
        if not use.any():
            return p[None]
        order = np.argsort(measured[use], kind="stable")
        x = np.log(measured[use][order])
        y = np.log(_SIZES[use][order])
        reached = levels[(np.log(levels) >= x[0]) & (np.log(levels) <= x[-1])]
        points = np.tile(p, (len(reached), 1))
        points[:, self.moved] = np.exp(np.interp(np.log(reached), x, y))
        for i, rate in self.phases:
            turns = np.abs(np.broadcast_to(self._at(rate, points, bound), len(points)))
            shifted = np.repeat(points, len(PHASES), axis=0)
            shifted[:, i] = np.outer(1 / turns, PHASES).ravel()
            points = shifted
        return points

    @staticmethod
    def _at(function: Callable[..., Any], points: FloatArray, bound: Sequence[float]) -> FloatArray:
        with np.errstate(all="ignore"):
            return np.asarray(function(*points.T, *bound), dtype=np.float64)


def features_of(
    expr: Expr, free: Sequence[Expr], bound: Sequence[Expr], sought: Sequence[int], speeds: FloatArray
) -> list[SearchGrid]:
    """Return the places and waves that parameters of a law move, those at which its formula changes first."""
    speeds = speeds[speeds > 0]
    if len(speeds) < 2:
        return []
    middles = (speeds[1:] + speeds[:-1]) / 2
    turns = np.pi * (len(speeds) - 1)  # a wave that turns faster between evenly spaced speeds is a slower one too
    radians = np.arange(1, turns / _EIGHTH) * _EIGHTH
    arguments = [*free, *bound]
    features = list[SearchGrid]()
    taken = set[int]()

    def moving(part: Expr) -> list[int]:
        return [i for i in sought if free[i] in part.free_symbols and i not in taken]

    def add(part: Expr, levels: FloatArray, phases: Sequence[tuple[int, Expr]] = (), *, breaks: bool) -> None:
        moved = [i for i in moving(part) if i not in dict(phases)]
        if moved:
            rates = tuple((i, function_of(arguments, rate, "numpy")) for i, rate in phases)
            measure = function_of(arguments, part, "numpy")
            features.append(SearchGrid(moved[0], measure, levels, rates, breaks, len(moved) == 1))
            taken.update((moved[0], *dict(phases)))

    for place in places(expr):
        add(place, middles, breaks=True)
    for node in sp.ordered(expr.atoms(sp.sin, sp.cos)):
        argument = node.args[0]
        rates = {i: sp.diff(argument, free[i]) for i in moving(argument)}
        span = sp.Abs(argument.subs(symbols.v, float(speeds[-1])) - argument.subs(symbols.v, float(speeds[0])))
        add(span, radians, [(i, rate) for i, rate in rates.items() if not rate.has(symbols.v)][:1], breaks=False)
    for total in sp.ordered(expr.atoms(sp.Add)):
        if total.is_polynomial(symbols.v) and (degree := sp.degree(total, symbols.v)) in (1, 2):
            highest, lower = sp.Poly(total, symbols.v).all_coeffs()[:2]
            add(-lower / (degree * highest), middles, breaks=False)
    return features

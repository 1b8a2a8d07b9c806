"""Levels of the slip speed between each two of which mu is as good as a polynomial."""

import math
from itertools import pairwise

import numpy as np
from numpy.polynomial import chebyshev

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.model.oscillator import Branch, Scene

__all__ = ["jumps", "levels_between"]

_WIDEST = 0.25  # distance of levels; an eighth of the range of w of an orbit
_HIGHEST = 8.0  # level; orbits that go higher are those of strong friction
_MOST = 160  # levels; with more it costs as much to follow an orbit in time
_STRONGEST = 50.0  # friction N/(V sqrt(k m)), from which on motions decay too fast for explicit steps
_NARROWEST = 1e-12  # distance of levels
_THINNEST = 3e-4  # the first level: where mu needs a lower one, a graze may turn below it
_TAIL = 1e-12  # of the last coefficients over the largest, of what is resolved
_JUMP = 1e-12  # of mu, relative, below which it is rounding
_DEGREE = 16
_PLACES = (1 - np.cos(np.arange(_DEGREE + 1) * math.pi / _DEGREE)) / 2  # from 0 to 1, both included
_SERIES = np.linalg.inv(chebyshev.chebvander(2 * _PLACES - 1, _DEGREE))
_THIN = 16.0 ** -np.arange(1, 11) * _PLACES[1]  # where layers at w = 0 are looked for that are thinner than that


def levels_between(scene: Scene) -> list[float]:
    """Return ascending slip speeds over the belt's, from 0 on, every kink of mu among them.

    Where mu is not known any more, or too rough above w = 1, they end. Where it is too rough below, or jumps, or
    friction is strong, there are none.
    """
    branches = scene.branches
    if scene.eta > _STRONGEST or any(jumps(scene, *pair) for pair in pairwise(branches)):
        return []
    top = min(scene.w_max, _HIGHEST)
    levels = [0.0]
    for branch in branches:
        end = min(branch.high, top)
        if branch.low >= top:
            break
        count = math.ceil((end - branch.low) / _WIDEST)
        pending = [branch.low + (end - branch.low) * i / count for i in range(1, count)] + [end]
        pending.reverse()
        while pending:
            low, high = levels[-1], pending[-1]
            if _resolved(scene, branch, low, high):
                levels.append(pending.pop())
            elif high - low < _NARROWEST or len(levels) + len(pending) > _MOST:
                return levels if low >= 1 else []
            else:
                pending.append(low + (high - low) / 2)
    return levels if levels[1] >= _THINNEST else []


def jumps(scene: Scene, before: Branch, after: Branch) -> bool:
    """Tell whether mu jumps from one smooth segment to the next."""
    one, other = (scene.onset + branch.rise(after.low) for branch in (before, after))
    return not abs(one - other) <= _JUMP * max(abs(one), abs(other))


def _resolved(scene: Scene, branch: Branch, low: float, high: float) -> bool:
    values = _rises(branch, low + (high - low) * _PLACES)
    if not np.isfinite(values).all():
        return False
    series = _SERIES @ values
    limit = _TAIL * max(np.abs(series).max(), abs(scene.onset))
    if np.abs(series[-2:]).max() > limit:
        return False
    if low > 0:
        return True
    found = _rises(branch, high * _THIN)
    return bool((np.abs(found - chebyshev.chebval(2 * _THIN - 1, series)) <= _DEGREE * limit).all())


def _rises(branch: Branch, w: FloatArray) -> FloatArray:
    return np.array([branch.rise(place) for place in w.tolist()])

"""Two values of a quantity between which it is proved that the slip from P ceases to return."""

from collections.abc import Callable
from typing import Any, TypeAlias

import sympy as sp

from stickslip_sym.core.aliases import Rational
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.criteria.enclosure import Enclosure
from stickslip_sym.motion.thresholds.box_scene import BoxScene
from stickslip_sym.motion.thresholds.box_transit import transit
from stickslip_sym.motion.thresholds.hypotheses import checked_hypotheses
from stickslip_sym.motion.thresholds.operating_points import OperatingPoints
from stickslip_sym.motion.thresholds.taylor_boxes import Undecided

__all__ = ["proved"]

At: TypeAlias = Callable[[Any], OperatingPoints]
"""From a value to the operating point."""

_BITS = (128, 256, 512)  # of precision, tried in turn
_WIDEST = 1e-2  # relative half width of an enclosure
_WIDER = 4  # ratio of a half width to the one tried before


def proved(at: At, c: float, value: float, error: float, rtol: float) -> Enclosure:
    """Return two values around one, at one of which the slip from P returns, and at the other not.

    Parameters
    ----------
    at : callable
        From a value to the operating point.
    c : float
        Damping in kg/s.
    value, error : float
        Where to look, and its relative error.
    rtol : float
        Width of the enclosure, relative.

    Raises
    ------
    InputError
        If the law does not meet a hypothesis of the lemma.
    NotConverged
        If no two such values are found within 1 %.
    """
    half = sp.Rational(max(rtol / 4, 2 * error, 1e-15))
    center = sp.Rational(value)
    words = "the slip returns at both ends, or at neither"
    while half <= _WIDEST:
        ends = [center * (1 - half), center * (1 + half)]
        try:
            if _returns(at, c, ends[0]) != _returns(at, c, ends[1]):
                return Enclosure.of(*sorted(ends))
        except Undecided as undecided:
            words = str(undecided)
        half *= _WIDER
    raise NotConverged(f"no two values within 1 % of {value:g} enclose a change: {words}")


def _returns(at: At, c: float, x: Rational) -> bool:
    points = at(str(x))
    scene = BoxScene(points.law, **points.exact_row(0))
    checked_hypotheses(scene)
    for bits in _BITS:
        try:
            return transit(scene, sp.Rational(c), bits).returns
        except Undecided as undecided:
            last = undecided
    raise last

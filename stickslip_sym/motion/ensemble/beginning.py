"""Slips at their beginnings, as a single one begins."""

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray, IntArray
from stickslip_sym.motion.ensemble.field import EXPONENT, Field
from stickslip_sym.motion.ensemble.rows import Rows

__all__ = ["begun"]

_LEVEL = 1e-13  # of the terms of w', below which it may be nothing but rounding


def begun(
    field: Field, row: IntArray, tau: FloatArray, q: FloatArray, w: FloatArray, side: FloatArray, *, rtol: float
) -> tuple[Rows, BoolArray]:
    """Return slips at their beginnings, and which of them the steps of many do not serve.

    - `row`: numbers of the starts.
    - `tau`, `q`, `w`, `side`: as in `Rows`.
    """
    scene = field.scene
    segment = np.searchsorted(field.lows, w, side="right") - 1
    rise = field.rise(segment)
    slope = field.slope(rise, q, w, side)
    held, risen = scene.eta * (side * scene.static - scene.onset), scene.eta * rise(w)
    terms = np.max(np.abs((held, risen, q, 2 * scene.zeta * w)), axis=0)
    level = (np.abs(slope) <= _LEVEL * terms) & (w < side)  # at a minimum of w
    rises = (w == 0) | level | (slope > 0)
    fast = np.maximum(1.0, np.maximum(np.abs(1 - side * w), np.abs(slope)))
    length = np.maximum(rtol**-EXPONENT / fast, 100 * np.spacing(tau))
    # One that begins where mu has a kink, and falls, is on the other side of it.
    odd = ~np.isfinite(slope) | (w > scene.w_max) | (~rises & (segment > 0) & (w == field.lows[segment]))
    return Rows.of(row, segment, tau, q, w, slope, side, length, rises, tau), odd

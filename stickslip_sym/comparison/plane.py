"""The plane of damping over belt speed: thresholds by averages and exactly."""

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
from uncertainties import UFloat

from stickslip_sym.comparison.compare import EXPLAINED_RTOL
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NotConverged, NoThreshold
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.thresholds.threshold import pure_slip_damping

Plane: TypeAlias = dict[str, FloatArray]
"""Belt speeds V, slope averages, exact thresholds in kg/s and their standard errors there; NaN where none is."""
_CURVE_POINTS = 33  # of a curve over belt speed
_AVERAGES = ("equilibrium", "least_squares", "harmonic")


def plane(law: FrictionLaw, given: Mapping[str, float | UFloat], speed: float) -> Plane:
    """Return the thresholds, for given N, m and k, up to twice a belt speed, or as far as mu was measured."""
    top = 2 * speed
    if law.v_max is not None:
        top = min(top, float(law.v_max) / 2)
    V = np.linspace(top / _CURVE_POINTS, top, _CURVE_POINTS)
    averages = {name: pure_slip_damping(law, V=V, N=given["N"], method=name).value for name in _AVERAGES}

    def exact(V: FloatArray) -> FloatArray:
        try:
            threshold = pure_slip_damping(law, V=V, N=given["N"], m=given["m"], k=given["k"], rtol=EXPLAINED_RTOL)
        except (NotConverged, NoThreshold):
            if len(V) == 1:
                return np.full((2, 1), np.nan)
            return np.hstack([exact(speed) for speed in V[:, None]])
        spread = 0.0 if threshold.budget is None else threshold.budget.uncertainty
        return np.array([threshold.value, np.broadcast_to(spread, V.shape)])

    return {"V": V, **averages, **dict(zip(("exact", "standard error"), exact(V), strict=True))}

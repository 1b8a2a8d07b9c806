"""The least-squares criterion along the lines of a map."""

import numpy as np

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NO_RESULT
from stickslip_sym.core.lambdify import function_of
from stickslip_sym.criteria.criterion import least_squares
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.rungs import average, numerical_averages
from stickslip_sym.motion.thresholds.scenes import Scenes

__all__ = ["least_squares_dampings"]

_GAUSS = np.polynomial.legendre.leggauss(4)  # exact to degree 7; a slope times the weight has degree 6


def least_squares_dampings(law: FrictionLaw, V: FloatArray, N: FloatArray) -> FloatArray:
    """Return the damping of the criterion in kg/s, for belt speeds and normal forces; NaN where there is none."""
    try:
        return _together(law, V, N)
    except NO_RESULT:
        if len(V) == 1:
            return np.full(1, np.nan)
    return np.concatenate([least_squares_dampings(law, V[[i]], N[[i]]) for i in range(len(V))])


def _together(law: FrictionLaw, V: FloatArray, N: FloatArray) -> FloatArray:
    scenes = Scenes.of(law, V=V, N=N)
    if obstacle(law, V, jump=False) is None:
        return np.asarray(numerical_averages(scenes)[least_squares.name])
    if law.curve is None:
        return np.asarray(average(scenes, least_squares))
    speeds, places = np.unique(V, return_inverse=True)
    return N * np.array([_through_points(law, speed) for speed in speeds.tolist()])[places]


def _through_points(law: FrictionLaw, V: float) -> float:
    """Return the damping over N of measured points: by Gauss, exact for the cubics between them."""
    end = 2 * V
    law.require_speed(end)
    places = [float(place) for place in law.kinks() if place < end]
    edges = np.array([0.0, *places, end])
    half = np.diff(edges)[:, None] / 2
    v = edges[:-1, None] + half * (1 + _GAUSS[0])
    weight = function_of([symbols.s], least_squares.weight, "numpy")(v / V - 1)
    return float(-(half * _GAUSS[1] * weight * law.slope(v)).sum() / V)

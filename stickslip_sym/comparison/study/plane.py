"""The plane of damping over belt speed: thresholds by averages, the exact one, and its standard error."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.core.errors import NotConverged, NoThreshold, StickSlipError
from stickslip_sym.core.uncertain import UFloat
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.orbits.orbit import obstacle
from stickslip_sym.motion.thresholds.methods import methods
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping

__all__ = ["Plane", "plane"]

_POINTS = 49  # of a curve, where an orbit serves all at once
_FEW = 13  # where each is simulated, 0.1 to 0.5 s
_WIDEST = 2.0  # times the belt speed
_RTOL = 1e-6  # of the curves, far below the width of a line
_AVERAGES = ("equilibrium", "least_squares", "harmonic")


@dataclass(frozen=True)
class Plane:
    """Thresholds over belt speed, all else as at the operating point.

    Attributes
    ----------
    V : numpy.ndarray
        Belt speeds in m/s.
    averages : mapping of str to numpy.ndarray
        The thresholds by averages of slopes, in kg/s.
    exact : numpy.ndarray
        The threshold, NaN where there is none.
    method : str
        That gave it: "orbit" or "simulation".
    uncertainty : numpy.ndarray or None
        Its standard error in kg/s; None where nothing carries one.
    """

    V: FloatArray
    averages: Mapping[str, FloatArray]
    exact: FloatArray
    method: str
    uncertainty: FloatArray | None


def plane(law: FrictionLaw, given: Mapping[str, float | UFloat], speed: float) -> Plane:
    """Return the thresholds from near rest to twice a belt speed, or as far as mu was measured.

    - `law`: with all parameters bound; with their standard errors, where they have any.
    - `given`: N, m and k.
    - `speed`: the belt's at the operating point, in m/s.

    Raises `InputError` where the law has no value, and `OutOfTime` when the time is up.
    """
    top = _WIDEST * speed if law.v_max is None else min(_WIDEST * speed, float(law.v_max) / 2)
    grid = np.linspace(top / _POINTS, top, _POINTS)
    averages = {
        name: np.asarray(pure_slip_damping(law, V=grid, N=given["N"], method=name).value) for name in _AVERAGES
    }
    if obstacle(law, grid) is None:
        try:
            found = _threshold(law, given, grid, "orbit")
            return Plane(grid, averages, np.asarray(found.value), "orbit", _spread(found))
        except (NotConverged, NoThreshold):
            pass  # somewhere friction is too strong for an orbit, and simulation serves
    few = np.linspace(0, _POINTS - 1, _FEW).round().astype(int)
    exact, spread = np.full(_FEW, math.nan), np.full(_FEW, math.nan)
    for place, V in enumerate(grid[few].tolist()):
        try:
            one = _threshold(law, given, V, "simulation")
        except (NotConverged, NoThreshold):
            continue
        exact[place] = one.value
        if (own := _spread(one)) is not None:
            spread[place] = own
    thinned = {name: curve[few] for name, curve in averages.items()}
    return Plane(grid[few], thinned, exact, "simulation", None if np.isnan(spread).all() else spread)


def _threshold(
    law: FrictionLaw, given: Mapping[str, float | UFloat], V: float | FloatArray, method: str
) -> Threshold:
    tightest = methods()[method].tightest
    N, m, k = (given[name] for name in "Nmk")
    return pure_slip_damping(law, V=V, N=N, m=m, k=k, method=method, rtol=max(_RTOL, tightest))


def _spread(found: Threshold) -> FloatArray | None:
    try:
        return None if found.budget is None else np.asarray(found.budget.uncertainty)
    except StickSlipError:
        return None

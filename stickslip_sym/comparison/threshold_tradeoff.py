"""Speed against accuracy of thresholds: every method, the paper's own procedure, and SciPy alone."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from stickslip_sym.comparison.newmark import Scan, pure_slip_by_scan
from stickslip_sym.comparison.plain import pure_slip_by_bisection
from stickslip_sym.comparison.ways import NO_NUMBER, Trade, Way, shortest
from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.methods import Method, methods
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping

__all__ = ["SPEEDS", "ThresholdWay", "threshold_tradeoff"]

SPEEDS = np.linspace(0.05, 1.0, 20)
"""Belt speeds in m/s over which the largest error is taken, those without a threshold left out."""

BISECTED = (1e-3, 1e-6, 1e-9)
"""Tolerances of ``scipy.integrate.solve_ivp``, whose own is the first."""
_UNITS = {"V": "m/s", "N": "N", "m": "kg", "k": "N/m"}
_SCAN_STEP = 0.001  # kg/s, the paper's
_FINE = 1e-11  # relative error that methods are asked for; a simulation states 1e-12 at best, and is refused there
_SHORTEST = 0.02  # seconds that the measurement of a method takes at least, all repetitions together


@dataclass(frozen=True)
class ThresholdWay(Way):
    """One way to a threshold.

    Attributes
    ----------
    largest : float
        Largest relative error over `SPEEDS`; NaN where it was not measured.
    status : str
        PROVED, or ESTIMATED; empty where there is no number.
    """

    largest: float = NO_NUMBER
    status: str = ""

    @staticmethod
    def further_columns() -> tuple[str, ...]:
        """Return the titles of what else is known of every way of this kind."""
        return ("largest up to V = 1 m/s", "status")

    def further(self) -> tuple[str, ...]:
        """Return what else is known of it, as text."""
        return ("not measured" if math.isnan(self.largest) else f"{self.largest:.1e}", self.status or "none")


def threshold_tradeoff(
    law: FrictionLaw, scene: Mapping[str, float], *, time_limit: float | None = None
) -> Trade[ThresholdWay]:
    """Measure every way to the threshold: its time for one, its error, and its largest error over `SPEEDS`.

    - `law`: smooth, with all parameters bound: the reference is the grazing orbit to 1e-12.
    - `scene`: V, N, m and k in SI units.
    - `time_limit`: seconds after which no other way is tried; those that are left give no number.

    They are the methods, with errors over the speeds; and in the one scene only the paper's scan of Newmark
      runs up to twice the threshold in steps of 0.001 kg/s, and bisection by ``scipy.integrate.solve_ivp``.

    Raises `InputError`, `NoThreshold` or `NotConverged` where the scene itself has no exact threshold.
    Raises `OutOfTime` if the time is up before that is known.
    """
    with deadline.time_limit(time_limit):
        ways = _measured(law, scene)
    where = ", ".join(f"{name} = {scene[name]:g} {unit}" for name, unit in _UNITS.items())
    return Trade("threshold", f"threshold of {law.name or 'the law'}, {where}", tuple(ways), dict(scene))


def _measured(law: FrictionLaw, scene: Mapping[str, float]) -> list[ThresholdWay]:
    orbit = methods()["orbit"]
    exact = _by(orbit, law, scene).value
    if not exact > 0:
        raise NoThreshold(f"the threshold is {exact:.3g} kg/s in this scene: nothing has a relative error")
    others = {name: value for name, value in scene.items() if name != "V"}
    references = {}
    for speed in SPEEDS.tolist():
        try:
            reference = _by(orbit, law, others | {"V": speed}).value
        except (NoThreshold, NotConverged):
            continue
        except OutOfTime:
            break
        if reference > 0:
            references[speed] = reference
    ways = []
    for name, method in methods().items():
        try:
            found, seconds = shortest(partial(_by, method, law, scene), enough=_SHORTEST)
        except (OutOfTime, NotConverged, InputError):
            ways.append(ThresholdWay(name))
            continue
        try:
            largest = max(
                (
                    _error(_by(method, law, others | {"V": speed}), reference)
                    for speed, reference in references.items()
                ),
                default=NO_NUMBER,
            )
        except (OutOfTime, NotConverged, NoThreshold):
            largest = NO_NUMBER
        ways.append(ThresholdWay(name, seconds, _error(found, exact), largest, found.status))
    osc = Oscillator(**scene)
    scan = Scan(np.arange(0.0, 2 * exact, _SCAN_STEP))
    ways.append(_peer("Newmark scan", partial(pure_slip_by_scan, law, osc, scan), exact))
    ways += [
        _peer(f"solve_ivp and bisection, rtol {rtol:.0e}", partial(pure_slip_by_bisection, law, osc, rtol), exact)
        for rtol in BISECTED
    ]
    return ways


def _peer(name: str, compute: Callable[[], float], exact: float) -> ThresholdWay:
    """Measure, once, a way that takes long and knows no error."""
    try:
        deadline.check_time()
        found, seconds = shortest(compute, least=1)
    except (OutOfTime, NoThreshold):
        return ThresholdWay(name)
    return ThresholdWay(name, seconds, abs(found / exact - 1), status="ESTIMATED")


def _by(method: Method, law: FrictionLaw, scene: Mapping[str, float]) -> Threshold:
    """Return the threshold by a method; averages of slopes are not made to look for their error."""
    numbers = dict(scene) if method.oscillator else {"V": scene["V"], "N": scene["N"]}
    return pure_slip_damping(law, **numbers, method=method, rtol=_FINE if method.converges else 1.0)


def _error(found: Threshold, reference: float) -> float:
    """Return the error against the orbit; the orbit's own is its estimate, and that of a proof its bound."""
    own = found.method == "orbit" or found.status == "PROVED"
    return float(found.relative_error) if own else abs(found.value / reference - 1)

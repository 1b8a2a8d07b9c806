"""Speed against accuracy of thresholds: every rung of the ladder, and the paper's own procedure."""

import math
import time
from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from stickslip_sym.comparison.newmark import Scan, pure_slip_by_scan
from stickslip_sym.comparison.tradeoff import Way
from stickslip_sym.core import deadline
from stickslip_sym.core.errors import InputError, NotConverged, NoThreshold, OutOfTime
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.thresholds.rungs import Rung, rungs
from stickslip_sym.motion.thresholds.threshold import Threshold, pure_slip_damping
from stickslip_sym.output.tables import duration, table

__all__ = ["SPEEDS", "threshold_report", "threshold_tradeoff"]

SPEEDS = np.linspace(0.05, 1.0, 20)
"""Belt speeds in m/s over which the largest error is taken, those without a threshold left out."""

_NEWMARK = "Newmark scan"
_SCAN_STEP = 0.001  # kg/s, the paper's


def threshold_tradeoff(
    law: FrictionLaw, scene: Mapping[str, float], *, time_limit: float | None = None
) -> list[Way]:
    """Measure every way to the threshold: its time for one, its error, and its largest error over `SPEEDS`.

    - `law`: smooth, with all parameters bound: the reference is the grazing orbit to 1e-12.
    - `scene`: V, N, m and k in SI units.
    - `time_limit`: seconds after which no other way is tried; those that are left give no number.

    Returns the rungs, and the paper's scan of Newmark runs up to twice the threshold in steps of 0.001 kg/s, its
      error in the one scene only.

    Raises `InputError`, `NoThreshold` or `NotConverged` where the scene itself has no exact threshold.
    Raises `OutOfTime` if the time is up before that is known.
    """
    with deadline.time_limit(time_limit):
        return _measured(law, scene)


def _measured(law: FrictionLaw, scene: Mapping[str, float]) -> list[Way]:
    orbit = rungs()["orbit"]
    exact = _rung(law, scene, orbit).value
    if not exact > 0:
        raise NoThreshold(f"the threshold is {exact:.3g} kg/s in this scene: nothing has a relative error")
    others = {name: value for name, value in scene.items() if name != "V"}
    references = {}
    for speed in SPEEDS.tolist():
        try:
            reference = _rung(law, others | {"V": speed}, orbit).value
        except (NoThreshold, NotConverged):
            continue
        except OutOfTime:
            break
        if reference > 0:
            references[speed] = reference
    ways = []
    for method, rung in rungs().items():
        try:
            found, seconds = _timed(partial(_rung, law, scene, rung))
        except (OutOfTime, NotConverged, InputError):
            ways.append(Way(method, math.nan, math.nan))
            continue
        try:
            largest = max(
                (
                    _error(_rung(law, others | {"V": speed}, rung), reference)
                    for speed, reference in references.items()
                ),
                default=math.nan,
            )
        except (OutOfTime, NotConverged, NoThreshold):
            largest = math.nan
        ways.append(Way(method, seconds, _error(found, exact), largest, found.status))
    scan = Scan(np.arange(0.0, 2 * exact, _SCAN_STEP))
    start = time.perf_counter()
    try:
        scanned = pure_slip_by_scan(law, Oscillator(**scene), scan)
    except OutOfTime:
        return [*ways, Way(_NEWMARK, math.nan, math.nan)]
    ways.append(Way(_NEWMARK, time.perf_counter() - start, abs(scanned / exact - 1), status="ESTIMATED"))
    return ways


def _rung(law: FrictionLaw, scene: Mapping[str, float], rung: Rung) -> Threshold:
    """Return the threshold by a rung; averages of slopes are not made to look for their error."""
    numbers = dict(scene) if rung.oscillator else {"V": scene["V"], "N": scene["N"]}
    return pure_slip_damping(law, **numbers, method=rung, rtol=rung.best)


def _error(found: Threshold, reference: float) -> float:
    """Return the error against the orbit; the orbit's own is its estimate, and that of a proof its bound."""
    own = found.method == "orbit" or found.status == "PROVED"
    return float(found.error) if own else abs(found.value / reference - 1)


def _timed(compute: Callable[[], Threshold]) -> tuple[Threshold, float]:
    """Return a value, and the shortest of three times to it."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        value = compute()
        times.append(time.perf_counter() - start)
    return value, min(times)


def threshold_report(ways: list[Way]) -> str:
    """Return the ways as a table."""

    def shown(error: float) -> str:
        return "not measured" if np.isnan(error) else f"{error:.1e}"

    rows: list[list[str]] = [
        [
            way.name,
            duration(way.seconds) if way.seconds == way.seconds else "no number",
            shown(way.error),
            shown(way.largest),
            way.status or "none",
        ]
        for way in ways
    ]
    return table(["way", "time a threshold", "relative error", "largest up to V = 1 m/s", "status"], rows)

"""Speed against accuracy of a share of starts: by the areas of basins, and by samples that are simulated."""

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import process_time

import numpy as np

from stickslip_sym.comparison.plain import comes_to_rest, comes_to_rest_smoothed
from stickslip_sym.comparison.ways import NO_NUMBER, Trade, Way, shortest
from stickslip_sym.core import deadline
from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.core.errors import NO_RESULT, InputError, OutOfTime
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.maps.basins import BasinMap, basin_map
from stickslip_sym.motion.maps.cells import MOTIONS
from stickslip_sym.motion.maps.shares import motions_by_side
from stickslip_sym.motion.motion import Motion
from stickslip_sym.motion.regimes.classification import classify

__all__ = ["ShareWay", "basin_tradeoff"]

SIMULATED = (50, 200, 800)
"""Numbers of starts that are simulated."""
WRITTEN = 50
"""Number of starts that runs of SciPy take: each takes some ten times as long."""
TOLERANCES = (1e-3, 1e-6)
"""Of these runs; the first is SciPy's own."""
_SEED = 1  # of the starts

Decision = Callable[[float, float], bool]
"""Whether a start, x0 and v0, comes to rest."""


@dataclass(frozen=True)
class ShareWay(Way):
    """One way to the share of a box of starts that come to rest.

    Attributes
    ----------
    error : float
        Of samples the root of the sum of two squares: of the standard error of their number, and of the share of
        these very starts that the way counts wrong.
    share : float
        As the way finds it, of its own starts; NaN where it gives no number.
    standard_error : float
        That part of the error which the number of starts alone brings; 0 without samples.
    """

    share: float = NO_NUMBER
    standard_error: float = 0.0

    @staticmethod
    def further_columns() -> tuple[str, ...]:
        """Return the titles of what else is known of every way of this kind."""
        return ("share", "standard error")

    def further(self) -> tuple[str, ...]:
        """Return what else is known of it, as text."""
        if not self.found:
            return ("", "")
        return (f"{self.share:.3g}", f"{self.standard_error:.2g}") if self.standard_error else (
            f"{self.share:.11g}", "none"
        )  # fmt: skip


def basin_tradeoff(
    law: FrictionLaw,
    osc: Oscillator,
    *,
    x0: tuple[float, float],
    v0: tuple[float, float],
    time_limit: float | None = None,
) -> Trade[ShareWay]:
    """Measure every way to the share of a box of starts that come to rest: its time and its error.

    - `law`: with all parameters bound.
    - `osc`: an oscillator whose basins geometry settles, as it does for every law without jumps.
    - `x0, v0`: the box, displacements in m and velocities in m/s.
    - `time_limit`: seconds after which no other way is tried; those that are left give no number.

    They are the area inside the separatrices, which is the reference too; seeded starts, by event-driven
      simulation; and fewer, by runs of ``scipy.integrate.solve_ivp`` over 80 natural periods, once with events and
      stick, once with the sign of the slip speed smoothed over a hundredth of the belt's speed.

    Raises `InputError` where geometry does not settle the basins, or no start comes to rest.
    Raises `OutOfTime` if the time is up before the areas are known.
    """
    with deadline.time_limit(time_limit):
        found, seconds = shortest(partial(basin_map, law, osc, x0=x0, v0=v0))
        exact = found.share.get(Motion.REST)
        if exact is None or exact.counted or not exact.value > exact.error:
            reason = (
                "no start comes to rest" if exact is None or exact.value == 0 else "its basins are not settled"
            )
            raise InputError(f"{reason} in this box: nothing has a relative error; try another c or box")
        rng = np.random.default_rng(_SEED)
        starts = np.column_stack([rng.uniform(*ends, max(SIMULATED)) for ends in (x0, v0)])
        ways = [ShareWay("geometry", seconds, exact.error / exact.value, exact.value)]
        sample = _Sample(starts, _fates(law, osc, found, starts), exact.value)
        ways += sample.counted("simulation", partial(_rests, law, osc), SIMULATED)
        for name, rests in (
            ("solve_ivp with events", comes_to_rest),
            ("solve_ivp smoothed", comes_to_rest_smoothed),
        ):
            for rtol in TOLERANCES:
                decide = partial(rests, law, osc, rtol=rtol)
                ways += sample.counted(f"{name}, rtol {rtol:.0e}", decide, (WRITTEN,))
    scene = {name: getattr(osc, name) for name in "VNmkc"}
    numbers = ", ".join(f"{name} = {value:g}" for name, value in scene.items())
    box = f"x0 = {x0[0]:g} to {x0[1]:g} m, v0 = {v0[0]:g} to {v0[1]:g} m/s"
    title = f"share of starts that come to rest, {law.name or 'the law'}, {numbers}, {box}"
    return Trade("share", title, tuple(ways), scene, {"x0": x0, "v0": v0})


@dataclass(frozen=True)
class _Sample:
    """Starts, whether each comes to rest, and the share of the whole box that does."""

    starts: FloatArray  # x0 and v0, shape (n, 2)
    rests: BoolArray
    exact: float

    def counted(self, name: str, decide: Decision, counts: tuple[int, ...]) -> list[ShareWay]:
        """Measure a way of deciding starts, for several numbers of the first of them."""
        found, seconds = [], []
        begin = process_time()
        with contextlib.suppress(OutOfTime, *NO_RESULT):
            for x0, v0 in self.starts[: max(counts)].tolist():
                deadline.check_time()
                found.append(decide(x0, v0))
                seconds.append(process_time() - begin)
        return [
            self._way(f"{name}, {count} starts", found[:count], seconds[count - 1 : count]) for count in counts
        ]

    def _way(self, name: str, found: list[bool], seconds: list[float]) -> ShareWay:
        if not seconds:
            return ShareWay(name)
        share = float(np.mean(found))
        wrong = share - float(np.mean(self.rests[: len(found)]))
        standard_error = math.sqrt(self.exact * (1 - self.exact) / len(found))
        return ShareWay(name, seconds[0], math.hypot(wrong, standard_error) / self.exact, share, standard_error)


def _fates(law: FrictionLaw, osc: Oscillator, found: BasinMap, starts: FloatArray) -> BoolArray:
    """Return which starts come to rest, by the side of the separatrices that they lie on."""
    rest = MOTIONS.index(Motion.REST)
    by_side = [int(motions_by_side(found.regime, *start[:, None])[0, 0]) for start in starts]
    return np.array(
        [
            _rests(law, osc, *start) if side < 0 else side == rest
            for side, start in zip(by_side, starts, strict=True)
        ]
    )


def _rests(law: FrictionLaw, osc: Oscillator, x0: float, v0: float) -> bool:
    return classify(law, osc, x0=float(x0), v0=float(v0)) is Motion.REST

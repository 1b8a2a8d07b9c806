"""How the motions of many starts first end: at P, at rest, at a minimum of the slip speed, or once around."""

import math
from dataclasses import dataclass

import numpy as np

from stickslip_sym.core.aliases import BoolArray, FloatArray
from stickslip_sym.model.oscillator import Scene
from stickslip_sym.motion.ensemble.field import Field
from stickslip_sym.motion.ensemble.log import OUTCOMES, Log
from stickslip_sym.motion.ensemble.slips import Slips
from stickslip_sym.motion.simulation.slip_phase import End
from stickslip_sym.motion.simulation.trajectory import Outcome

__all__ = ["Ends", "first_ends"]


@dataclass(frozen=True)
class Ends:
    """How motions first end, an entry for each start; none of these where the steps of many do not serve.

    Attributes
    ----------
    onset : numpy.ndarray of bool
        Whether at P.
    lowest : numpy.ndarray
        The slip speed w at a minimum of it, NaN where there was none.
    rounds : numpy.ndarray
        Rows of q where the mass began to slip slower than the belt and where it did so again, without having come
        to P; NaN where it did not.
    rests, unbounded, late : numpy.ndarray of bool
        Whether at rest, beyond all bounds, or with the time limit.
    """

    onset: BoolArray
    lowest: FloatArray
    rounds: FloatArray
    rests: BoolArray
    unbounded: BoolArray
    late: BoolArray


def first_ends(scene: Scene, q: FloatArray, u: FloatArray, *, horizon: float, rtol: float) -> Ends:
    """Return how motions first end.

    - `q`, `u`: displacements from P, and velocities over the belt's.
    - `horizon`: dimensionless time at which to give up.
    - `rtol`: relative tolerance of a step.
    """
    log = Log(q, u)
    with np.errstate(all="ignore"):
        slips = Slips(Field(scene), log, horizon=horizon, rtol=rtol, deadline=math.inf, until=End.MINIMUM)
        slips.follow()
    given_up = np.isin(np.arange(q.size), slips.alone)

    def ended(outcome: Outcome) -> BoolArray:
        return np.asarray(~given_up & (log.outcome == OUTCOMES.index(outcome)))

    return Ends(
        ~given_up & np.isfinite(log.onset),
        np.where(given_up, np.nan, slips.lowest),
        np.where(given_up, np.nan, slips.rounds),
        ended(Outcome.AT_REST),
        ended(Outcome.UNBOUNDED),
        ended(Outcome.TIME_LIMIT),
    )

"""Rounds outside P's orbit, slower than the belt and faster in turn, and the friction on motions far out."""

import math

import numpy as np

from stickslip_sym.core.aliases import FloatArray
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.motion.slip import Dimensionless
from stickslip_sym.motion.steps import End

_FAST = 1e12  # slip speed over the belt's, beyond every feature of a law: it stands for all that are higher


def friction_far_out(law: FrictionLaw, V: float) -> float:
    """Return mu(v)/v in s/m at slip speeds beyond every feature of a law; 0 if it is measured up to a speed."""
    return 0.0 if law.v_max is not None else float(law.mu(_FAST * V)) / (_FAST * V)


def rounds(
    system: Dimensionless,
    q: FloatArray,
    rtol: float,
    *,
    eta: FloatArray | None = None,
    zeta: FloatArray | None = None,
    **options: int,
) -> FloatArray:
    """Follow rounds that leave the belt's speed at displacements q >= 0, to slower motion first.

    - `eta`, `zeta`: an entry for each round, where they are not the system's.
    - `options`: of `Dimensionless.slips`.

    Returns the q where slip slower than the belt begins again: NaN if the mass sticks before, 0 if it stays slower
      than the belt, infinity if it moves away for ever or beyond what was measured, and -1 if that is unknown.
    """
    at_belt_speed = np.zeros_like(q)
    slips = system.slips(
        q, at_belt_speed, eta=eta, zeta=zeta, passes=1, until=End.MINIMUM, rtol=rtol, **options
    )  # fmt: skip
    # Slip faster than the belt ends where that slower than it begins, or where the mass sticks.
    back = slips.end == End.RETURN
    slower = np.isin(slips.end, (End.MINIMUM, End.REST, End.HORIZON))
    sticks = back & (slips.q <= 0)
    return np.select([sticks, back, slower, slips.end == End.OUTSIDE], [math.nan, slips.q, 0.0, math.inf], -1.0)

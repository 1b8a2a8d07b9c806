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
    ends, going = np.array(q, dtype=np.float64), np.arange(q.size)
    eta = np.full(q.shape, system.eta) if eta is None else eta
    zeta = np.full(q.shape, system.zeta) if zeta is None else zeta
    for side in (1.0, -1.0):
        slips = system.slips(
            ends[going], np.zeros(going.size), np.full(going.size, side), eta=eta[going], zeta=zeta[going],
            until=End.MINIMUM, rtol=rtol, **options,
        )  # fmt: skip
        back = slips.end == End.RETURN
        slower = np.isin(slips.end, (End.MINIMUM, End.REST, End.HORIZON))
        ends[going] = np.select([back, slower, slips.end == End.OUTSIDE], [slips.q, 0.0, math.inf], -1.0)
        sticks = back & (slips.q <= 0) & (slips.q >= -2 * eta[going] * system.table.static)
        ends[going[sticks]] = math.nan
        going = going[back & ~sticks]
    return ends

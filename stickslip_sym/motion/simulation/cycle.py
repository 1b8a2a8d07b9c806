"""The stick-slip cycle: one stick phase, and the slip from P that ends it.

Every forward stick phase ends at the same point P, at the belt's speed. So the slip that leaves P either comes
back to the belt's speed, and is the whole cycle together with the stick phase that follows, or never does: orbits
in a plane do not cross, so an orbit that misses once stays inside. Where damping and friction are weak, or damping
feeds energy in, it can come back beyond what static friction holds. The mass then overtakes the belt, and if that
slip does not end in stick either, the motion lies outside its first round from then on: it never sticks again, and
slips on both sides of the belt's speed.
"""

import math
from dataclasses import dataclass

from stickslip_sym.core import deadline
from stickslip_sym.core.errors import NotConverged
from stickslip_sym.core.numbers import read_rtol
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.laws import as_law
from stickslip_sym.model.oscillator import Oscillator
from stickslip_sym.motion.kernel.slip_data import SlipEnd
from stickslip_sym.motion.slip import NondimensionalOscillator
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.shown import Shown


@dataclass(frozen=True)
class StickSlipCycle(Shown, DataResult):
    """The periodic motion of stick and slip.

    One stick phase, one slip slower than the belt, and, where the mass returns beyond what static friction
    holds, one slip faster than the belt.

    Attributes
    ----------
    period, stick_time, slip_time : float
        In s; `slip_time` is all slip.
    x_min, x_max : float
        Extreme displacements in m.
    v_min, v_max : float
        Extreme velocities in m/s; the highest is the belt speed unless the mass overtakes the belt.
    """

    period: float
    stick_time: float
    slip_time: float
    x_min: float
    x_max: float
    v_min: float
    v_max: float

    def __str__(self) -> str:
        return f"stick-slip of period {self.period:.6g} s, of which stick {self.stick_time:.6g} s"

    def __repr__(self) -> str:
        return (
            f"StickSlipCycle: {self}; x from {self.x_min:.6g} to {self.x_max:.6g} m, "
            f"v from {self.v_min:.6g} to {self.v_max:.6g} m/s"
        )


def stick_slip_cycle(
    law: FrictionLaw | str, osc: Oscillator, *, rtol: float = 1e-12, time_limit: float | None = None
) -> StickSlipCycle | None:
    """Return the stick-slip cycle of an oscillator, or None if it has none.

    Parameters
    ----------
    law : FrictionLaw
        With all parameters bound.
    osc : Oscillator
    rtol : float
        Relative tolerance of an integration step, 1e-13 to 1e-3.
    time_limit : float, optional
        Seconds of computation after which it is given up.

    Raises
    ------
    InputError
        For an unbound law, or an unusable tolerance.
    NotConverged
        When the bound on the work is reached.
    OutOfTime
        When the time limit is reached.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> osc = ss.Oscillator(m=1, k=100, c=1.0, V=0.5, N=9.81)
    >>> print(ss.stick_slip_cycle(ss.laws.exponential.typical(), osc))
    stick-slip of period 0.651445 s, of which stick 0.120047 s
    """
    law = as_law(law)
    rtol = read_rtol(rtol)
    with deadline.time_limit(time_limit):
        system = NondimensionalOscillator.of(law.bound, osc)
        slip = system.slip(0.0, 0.0, passes=1, until=SlipEnd.MINIMUM, level=1.0, rtol=rtol)
    if slip.end is not SlipEnd.RETURN or not system.sticks(slip.q):
        return None
    onset = osc.onset(law)
    return StickSlipCycle(
        period=(slip.tau - slip.q) / osc.omega,
        stick_time=-slip.q / osc.omega,
        slip_time=slip.tau / osc.omega,
        x_min=onset + osc.length * slip.q_least,
        x_max=onset + osc.length * slip.q_most,
        v_min=osc.V * (1 - slip.u_most),
        v_max=osc.V * (1 - slip.u_least),
    )


def peak_velocity(law: FrictionLaw | str, osc: Oscillator, *, rtol: float = 1e-12) -> float:
    """Return the velocity in m/s at the peak that follows the slip from P, above V where the mass returns.

    The mass that misses the belt's speed has its peak below. One that returns, with the velocity V and an
    acceleration a, has none, and V + a^2/(2 omega^2 V) stands for it: by so much it would overshoot if the
    spring alone went on to pull, and near a graze that continues the peak with its value and its slope.
    The root of the result minus V, as a function of the damping, is the pure-slip threshold.

    Parameters
    ----------
    law, osc, rtol
        As for `stick_slip_cycle`.

    Raises
    ------
    InputError
        For an unbound law, or an unusable tolerance.
    NotConverged
        If the motion has no peak, since the mass creeps to rest, or when the bound on the work is reached.

    Examples
    --------
    >>> import stickslip_sym as ss
    >>> law = ss.laws.exponential.typical()
    >>> [round(ss.peak_velocity(law, ss.Oscillator(m=1, k=100, c=c, V=0.5, N=9.81)), 6) for c in (2.5, 2.7)]
    [0.513853, 0.475376]
    """
    height = first_minimum(NondimensionalOscillator.of(as_law(law).bound, osc), 0.0, 0.0, read_rtol(rtol))
    if math.isinf(height):
        raise NotConverged("the velocity has no peak after the slip from P, it falls for ever; try a larger c")
    if height == 1:
        raise NotConverged(
            f"the velocity has no peak after the slip from P, the mass creeps to rest: the damping ratio is "
            f"{osc.zeta:g}; try a smaller c"
        )
    return osc.V * (1 - height)


def first_minimum(system: NondimensionalOscillator, q: float, w: float, rtol: float) -> float:
    """Return the first minimum of the slip speed, over V, after a state below the belt's speed.

    Where the mass returns it is -w'^2/2, which continues the minimum through 0 with its value and its slope, and
    -infinity where the mass moves away for ever; where it creeps to rest it is 1.
    """
    slip = system.slip(q, w, until=SlipEnd.MINIMUM, rtol=rtol)
    least = {
        SlipEnd.RETURN: -(slip.rate**2) / 2,
        SlipEnd.OUTSIDE: -math.inf,
        SlipEnd.MINIMUM: slip.w,
        SlipEnd.REST: 1.0,
    }
    return least[slip.end]
